#include "daemon/render/session_quality.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/render/light_importance.h"
#include "scheduler/sample_costs.h"

namespace gnomon::daemon {
namespace {

// Cameras may be early by one and a half intervals, as clients and networks jitter.
scheduler::RateLimit limit_to(double rate_hz) {
  const std::chrono::duration<double> early(rate_hz > 0 ? 1.5 / rate_hz : 0);
  return scheduler::RateLimit(rate_hz, std::chrono::duration_cast<Nanoseconds>(early));
}

// Compares operating points.
double served(const scheduler::OperatingPoint& point) {
  return point.rate * point.size * point.lights / (1 + point.fewer_samples);
}

}  // namespace

uint32_t shrunk(uint32_t side, double share) {
  if (share >= 1) return side;
  return std::min(side, std::max(kTileSize, static_cast<uint32_t>(side * share) / kTileSize * kTileSize));
}

SessionQuality::SessionQuality(const SessionOpened& opened, FrameSink& sink, Metrics& metrics)
    : opened_(opened),
      sink_(sink),
      metrics_(metrics),
      width_(opened.grant.width),
      height_(opened.grant.height),
      samples_(opened.grant.samples),
      rate_(limit_to(opened.grant.rate_hz)) {
  degradation_.set_limits({}, samples_);
}

void SessionQuality::set_limits(const scheduler::DegradationLimits& limits) {
  const double before = rate_hz();
  degradation_.set_limits(limits, opened_.grant.samples);
  link_.set_limits(limits, opened_.grant.dense_codec != opened_.grant.codec);
  if (rate_hz() != before) adopt_rate();
}

void SessionQuality::adopt_rate() {
  rate_ = limit_to(rate_hz());
  tell_client();
}

void SessionQuality::frame_begun(TimePoint now) {
  ++answered_;
  rate_.spend(1, now);
}

bool SessionQuality::adapt(std::span<const scenes::Light> lights, const glm::vec3& eye, TimePoint now) {
  if (memory_.recover(now)) metrics_.degraded(false);
  const bool other_size = adopt_size();
  const bool other_lights = choose_lights(lights, eye);
  return other_size || other_lights;
}

bool SessionQuality::adopt_size() {
  const TileGrid wanted = wanted_grid();
  // Half and full ambient occlusion have the same grid, since their planes are as many: samples are compared too.
  if (wanted == grid() && degradation_.samples() == samples_) return false;
  width_ = wanted.width;
  height_ = wanted.height;
  samples_ = degradation_.samples();
  tell_client();
  return true;
}

// The lights are chosen for each frame, but rarely change.
bool SessionQuality::choose_lights(std::span<const scenes::Light> lights, const glm::vec3& eye) {
  const size_t keep = wanted_lights();
  if (keep >= opened_.grant.lights && untraced_.none()) return false;
  const gpu::LightSet untraced = least_important(lights, eye, keep, untraced_);
  if (untraced == untraced_) return false;
  untraced_ = untraced;
  tell_client();
  return true;
}

bool SessionQuality::shrink(TimePoint now, const Error& why) {
  do {
    if (!memory_.refuse(now)) return false;
  } while (wanted_grid() == grid());
  metrics_.degraded(true);
  log::warning("smaller frames for a session", {{"session", opened_.session.value},
                                                {"tenant", metrics_.name(opened_.grant.tenant)},
                                                {"width", wanted_grid().width},
                                                {"height", wanted_grid().height},
                                                {"why", why.message}});
  return true;
}

// A session without a rate is not degraded: its client sends the next view when the last one is answered.
void SessionQuality::review(Nanoseconds since_last) {
  const uint32_t arrived = std::exchange(arrived_, 0), answered = std::exchange(answered_, 0);
  if (opened_.grant.rate_hz <= 0) return;
  const auto allowed = static_cast<uint32_t>(rate_hz() * to_seconds(since_last));
  const scheduler::OperatingPoint before = degradation_.point();
  if (!degradation_.observe({std::min(arrived, allowed), answered})) return;
  const scheduler::OperatingPoint after = degradation_.point();
  const bool less = served(after) < served(before);
  metrics_.degraded(less);
  log::info(less ? "a session is served less" : "a session is served more again",
            {{"session", opened_.session.value},
             {"tenant", metrics_.name(opened_.grant.tenant)},
             {"rate_hz", rate_hz()},
             {"samples", degradation_.samples().per_light},
             {"size_percent", std::lround(after.size * 100)},
             {"lights_percent", std::lround(after.lights * 100)}});
  if (after.rate != before.rate) adopt_rate();
}

void SessionQuality::review_link(const LinkWindow& window) {
  const auto quality = [this] { return std::pair(!link_.dense(), link_.size()); };
  const auto before = quality();
  if (link_.observe(window)) metrics_.degraded(quality() < before);
}

TileGrid SessionQuality::wanted_grid() const {
  const double size = std::min({degradation_.point().size, link_.size(), memory_.size()});
  return {shrunk(opened_.grant.width, size), shrunk(opened_.grant.height, size),
          opened_.grant.planes(degradation_.samples())};
}

bool SessionQuality::is_as_granted() const {
  return has_granted_size() && has_granted_samples() && untraced_.none() && degradation_.point().rate >= 1;
}

uint64_t SessionQuality::traced_bits(uint64_t pixels) const {
  uint32_t lights = 0, areas = 0;
  for (uint32_t light = 0; light < opened_.grant.lights; ++light) {
    if (untraced_[light]) continue;
    ++lights;
    areas += opened_.grant.is_area(light);
  }
  return scheduler::weighted_bits(pixels, lights, areas, samples_);
}

// At least one light is traced.
uint32_t SessionQuality::wanted_lights() const {
  return std::max(1u, static_cast<uint32_t>(std::ceil(degradation_.point().lights * opened_.grant.lights)));
}

void SessionQuality::tell_client() const {
  protocol::Degraded message;
  message.width = static_cast<uint16_t>(width_);
  message.height = static_cast<uint16_t>(height_);
  message.rate_hz = static_cast<float>(rate_hz());
  if (opened_.grant.has(protocol::kFeatureSoft)) message.samples = to_byte(samples_);
  for (uint16_t light = 0; light < opened_.grant.lights; ++light) {
    if (untraced_[light]) message.untraced_lights.push_back(light);
  }
  const bool full = degradation_.point() == scheduler::OperatingPoint{};
  if (memory_.size() < 1) {
    message.reason = "the device has no memory for more";
  } else if (link_.size() < 1) {
    message.reason = "the link cannot carry more";
  } else {
    message.reason = full ? "the device keeps up again" : "the device cannot keep up";
  }
  sink_.on_degraded({opened_.session, opened_.net_thread, message, opened_.generation});
}

}  // namespace gnomon::daemon
