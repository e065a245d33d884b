#include "tests/eval/remote/visibility_flight.h"

#include "client/media/montage.h"
#include "client/prediction/error_balance.h"
#include "client/view/client_renderer.h"

namespace gnomon::remote {
namespace {

class Looks {
 public:
  Looks(const scenes::ScenePtr& scene, const VisibilityPlan& plan, client::ClientRenderer view)
      : path_(client::CameraPath::of_scene(scene)), plan_(plan), view_(std::move(view)), client_(loop_, options()) {
    flight_.screen.rate_hz = plan.rate_hz;
    flight_.screen.steps = plan.steps;
  }

  Result<VisibilityFlight> run() {
    if (auto opened = client_.wait_open(); !opened) return opened.error();
    const uint64_t before = client_.received_bytes();
    flight_.screen.started = Clock::now();
    for (uint32_t step = 0; step < plan_.steps; ++step) {
      loop_.run_until(at(step), [] { return false; });
      if (client_.failure()) return *client_.failure();
      client_.look(client::view_of(path_.at(plan_.from_s + step / plan_.rate_hz), plan_.size));
      loop_.poll();
      if (auto shown = show(); !shown) return shown.error();
    }
    loop_.run_until(at(plan_.steps), [] { return false; });
    flight_.seconds = to_seconds(Clock::now() - flight_.screen.started);
    flight_.received_bytes = client_.received_bytes() - before;
    flight_.masks = client_.counters().complete;
    client_.close("flight over");
    return std::move(flight_);
  }

 private:
  client::ThinClientOptions options() const {
    client::ThinClientOptions options;
    options.stream = plan_.stream;
    options.mode = client::Mode::automatic;
    options.automatic = std::make_unique<client::ErrorBalance>(client::ErrorBalanceOptions{.size = plan_.size});
    return options;
  }

  TimePoint at(uint32_t step) const {
    return flight_.screen.started + Nanoseconds(static_cast<int64_t>(step * 1e9 / plan_.rate_hz));
  }

  Result<void> show() {
    const auto showing = client_.next();
    if (!showing) return {};
    const TimePoint asked = Clock::now() - showing->age;
    const auto drawn = view_.draw(*showing, gpu::Samples::one);
    if (!drawn) return drawn.error();
    ScreenPicture picture{showing->index, Clock::now(), client::copied(*drawn)};
    flight_.response.add(picture.at - asked);
    flight_.ahead.push_back(showing->ahead());
    flight_.screen.pictures.push_back(std::move(picture));
    const auto outcome = view_.outcome(*showing);
    if (!outcome) return outcome.error();
    if (*outcome) client_.observe((*outcome)->earlier, (*outcome)->later, (*outcome)->error);
    return {};
  }

  client::CameraPath path_;
  const VisibilityPlan& plan_;
  client::ClientRenderer view_;
  client::Loop loop_;
  client::ThinClient client_;
  VisibilityFlight flight_;
};

}  // namespace

Result<VisibilityFlight> fly(const scenes::ScenePtr& scene, const VisibilityPlan& plan) {
  auto view = client::ClientRenderer::create(scene, plan.size, {.device = plan.device});
  if (!view) return view.error();
  return Looks(scene, plan, std::move(*view)).run();
}

}  // namespace gnomon::remote
