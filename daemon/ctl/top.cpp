#include "daemon/ctl/top.h"

#include <cstdio>
#include <thread>

#include "common/clock.h"
#include "daemon/ctl/top_screen.h"

namespace gnomon::ctl {
namespace {

using std::chrono::milliseconds;

Result<void> print_tables(AdminClient& admin, const TopOptions& options) {
  auto before = admin.status();
  TimePoint then = Clock::now();
  if (!before) return before.error();
  for (uint32_t shown = 0; options.count == 0 || shown < options.count; ++shown) {
    std::this_thread::sleep_for(options.interval);
    auto now = admin.status();
    if (!now) return now.error();
    const TimePoint at = Clock::now();
    const std::string text =
        options.json ? now->dump(-1, ' ', true) + "\n" : top_text(*before, *now, to_seconds(at - then)) + "\n";
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
    before = std::move(now);
    then = at;
  }
  return {};
}

// Shows the tables until the next ones are due. Returns false if the user wants to leave.
bool serve_keys(TopScreen& screen, TopView& view, const TopSample& sample, const std::string& trouble,
                TimePoint until) {
  while (true) {
    screen.draw(view.screen(top_tables(sample, view.order()), screen.rows(), screen.columns(), trouble));
    const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
    if (left <= milliseconds(0)) return true;
    const auto pressed = screen.wait_for_key(left);
    if (pressed && !view.press(pressed->key, pressed->character)) return false;
  }
}

Result<void> show_tables(AdminClient& admin, const TopOptions& options, TopScreen& screen, nlohmann::json before) {
  TopView view;
  nlohmann::json now = before;
  TimePoint then = Clock::now(), at = then;
  std::string trouble;
  for (uint32_t shown = 0; options.count == 0 || shown <= options.count; ++shown) {
    const TopSample sample{before, now, to_seconds(at - then)};
    if (!serve_keys(screen, view, sample, trouble, Clock::now() + options.interval)) return {};
    auto next = admin.status();
    trouble = next ? "" : next.error().message;
    if (!next) continue;
    before = std::move(now);
    now = std::move(*next);
    then = at;
    at = Clock::now();
  }
  return {};
}

}  // namespace

Result<void> top(AdminClient& admin, const TopOptions& options) {
  if (options.json) return print_tables(admin, options);
  auto first = admin.status();  // before the screen is taken over, so that an error is seen
  if (!first) return first.error();
  const auto screen = TopScreen::open();
  if (!screen) return print_tables(admin, options);
  return show_tables(admin, options, *screen, std::move(*first));
}

}  // namespace gnomon::ctl
