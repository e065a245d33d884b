#include "tests/eval/auto_link.h"

#include <algorithm>
#include <deque>
#include <optional>

#include "client/media/camera_path.h"
#include "client/prediction/show_order.h"
#include "tests/tools/netsim/link.h"

namespace gnomon::eval {
namespace {

constexpr size_t kCameraBytes = 120, kSliceBytes = 1200;

netsim::Schedule schedule_of(const LinkPlan& plan) {
  netsim::Schedule schedule;
  for (size_t i = 0; i < plan.round_trips_ms.size(); ++i) {
    netsim::Profile profile;
    profile.delay = std::chrono::microseconds(plan.round_trips_ms[i] * 500);
    profile.jitter = std::min<Nanoseconds>(profile.delay / 4, std::chrono::milliseconds(3));
    profile.rate_bit_per_s = 100e6;
    schedule.push_back(
        {std::chrono::milliseconds(static_cast<int64_t>(1000 * plan.phase_s * static_cast<double>(i))), profile});
  }
  return schedule;
}

// One session's server: renders one frame at a time, always the newest camera that it has.
class Server {
 public:
  explicit Server(const LinkPlan& plan)
      : plan_(plan), up_(schedule_of(plan), plan.seed, {}), down_(schedule_of(plan), plan.seed + 1, {}) {}

  void ask(uint32_t index, TimePoint now) {
    const netsim::Fate fate = up_.send(kCameraBytes, now);
    if (fate.copies > 0) cameras_.push_back({fate.at[0], index});
  }

  // Answers that have come by `now`: camera, and when.
  std::vector<std::pair<uint32_t, TimePoint>> answers(TimePoint now) {
    while (!cameras_.empty()) {
      const TimePoint start = std::max(free_, cameras_.front().first);
      if (start > now) break;
      uint32_t newest = 0;
      while (!cameras_.empty() && cameras_.front().first <= start) {
        newest = cameras_.front().second;
        cameras_.pop_front();
      }
      free_ = start + plan_.render;
      send(newest);
    }
    std::vector<std::pair<uint32_t, TimePoint>> come;
    while (!on_their_way_.empty() && on_their_way_.front().second <= now) {
      come.push_back(on_their_way_.front());
      on_their_way_.pop_front();
    }
    return come;
  }

 private:
  void send(uint32_t index) {
    TimePoint last{};
    for (size_t sent = 0; sent < plan_.frame_bytes; sent += kSliceBytes) {
      const netsim::Fate fate = down_.send(std::min(kSliceBytes, plan_.frame_bytes - sent), free_);
      if (fate.copies == 0) return;  // the frame stays incomplete; a newer one follows
      last = std::max(last, fate.at[0]);
    }
    on_their_way_.push_back({index, last});
  }

  const LinkPlan& plan_;
  netsim::Link up_, down_;
  TimePoint free_{};
  std::deque<std::pair<TimePoint, uint32_t>> cameras_;
  std::deque<std::pair<uint32_t, TimePoint>> on_their_way_;
};

double error_of(const LinkPlan& plan, uint32_t frame, size_t x) {
  return x == 0 ? 0.0 : std::max(0.0, (*plan.errors)[frame][x - 1]);
}

}  // namespace

Outcome play(const LinkPlan& plan, std::unique_ptr<client::PredictionPolicy> ahead) {
  client::ShowOrder order(client::Mode::automatic, std::move(ahead));
  Server server(plan);
  const auto frames = static_cast<uint32_t>(plan.errors->size());
  const client::CameraPath path = client::CameraPath::of_scene(plan.scene);
  std::vector<protocol::CameraView> cameras;
  // As client/view/client_renderer.h: masks that are kept until those of that camera have come.
  std::optional<std::pair<uint32_t, uint32_t>> trial;
  std::optional<client::Shown> shown;
  Outcome outcome;
  size_t counted = 0;
  for (uint32_t i = 0; i < frames; ++i) {
    const TimePoint now{std::chrono::nanoseconds(static_cast<int64_t>(1e9 / plan.fps * i))};
    cameras.push_back(client::view_of(path.at((plan.first + i) / plan.fps), plan.size));
    server.ask(i, now);
    order.asked(cameras.back(), now);
    for (const auto& [index, when] : server.answers(now)) {
      if (trial && index >= trial->second) {
        const uint32_t x = index - trial->first;
        if (x <= client::kMostAhead)
          order.ahead().observe(cameras[trial->first], cameras[index], error_of(plan, index, x));
        trial.reset();
      }
      order.answered(index, when);
      if (!trial) trial.emplace(index, i);
    }
    if (const auto next = order.next(now)) shown = next;
    if (!shown) continue;
    outcome.error += error_of(plan, shown->camera.index, shown->ahead());
    outcome.response_ms += to_milliseconds(now - shown->camera.asked);
    outcome.mean_x += static_cast<double>(shown->ahead());
    ++counted;
  }
  if (counted == 0) return outcome;
  outcome.error /= static_cast<double>(counted);
  outcome.response_ms /= static_cast<double>(counted);
  outcome.mean_x /= static_cast<double>(counted);
  return outcome;
}

}  // namespace gnomon::eval
