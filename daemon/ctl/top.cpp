#include "daemon/ctl/top.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <sstream>
#include <thread>

#include "common/clock.h"
#include "daemon/ctl/views.h"

namespace gnomon::ctl {
namespace {

constexpr const char* kHome = "\x1b[H";
constexpr const char* kClearLine = "\x1b[K\n";
constexpr const char* kClearBelow = "\x1b[J";

// As many lines as the terminal has; each line is cleared behind its text, so that the screen does not flicker.
std::string on_screen(const std::string& text) {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1 && size.ws_col > 0;
  std::istringstream lines(text);
  std::string screen = kHome;
  int row = 1;
  for (std::string line; std::getline(lines, line) && (!known || row < size.ws_row); ++row) {
    screen += (known ? line.substr(0, size.ws_col) : line) + kClearLine;
  }
  return screen + kClearBelow;
}

}  // namespace

Result<void> top(AdminClient& admin, const TopOptions& options) {
  const bool terminal = isatty(STDOUT_FILENO) == 1;
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
    std::fputs(terminal && !options.json ? on_screen(text).c_str() : text.c_str(), stdout);
    std::fflush(stdout);
    before = std::move(now);
    then = at;
  }
  return {};
}

}  // namespace gnomon::ctl
