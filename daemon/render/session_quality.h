// What one session is served at the moment, between what it was granted and the least that its tenant allows: its rate,
// the samples, the size of its frames and the lights that are traced. Told the time.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "daemon/frame/frame_sink.h"
#include "daemon/metrics/metrics.h"
#include "daemon/render/link_steps.h"
#include "daemon/render/memory_steps.h"
#include "daemon/render/render_inbox.h"
#include "scheduler/degradation.h"
#include "scheduler/rate_limit.h"

namespace gnomon::daemon {

// Three ladders lead down and up again: the device's (scheduler::Degradation), the link's and the memory's. The client
// is notified of each change of its rate, samples, size and lights, through the sink. Belongs to the render thread.
class SessionQuality {
 public:
  // At first all that was granted. References outlive this.
  SessionQuality(const SessionOpened& opened, FrameSink& sink, Metrics& metrics);

  // Other limits: the rate follows at once, the rest with the next frame.
  void set_limits(const scheduler::DegradationLimits& limits);

  // In force now.
  TileGrid grid() const { return {width_, height_, opened_.grant.planes(samples_)}; }
  // All that was granted, and so what a client expects that was told of nothing else.
  bool is_as_granted() const;
  bool has_granted_size() const { return width_ == opened_.grant.width && height_ == opened_.grant.height; }
  SampleCounts samples() const { return samples_; }
  bool has_granted_samples() const { return samples_ == opened_.grant.samples; }
  const gpu::LightSet& untraced() const { return untraced_; }
  uint64_t traced_bits(uint64_t pixels) const;  // scheduler::weighted_bits() of the lights that are traced
  bool wants_dense_codec() const { return link_.dense(); }
  TimePoint eligible_at() const { return rate_.eligible_at(); }  // from when the session may start a frame

  // What happened since the last review.
  void view_arrived() { ++arrived_; }
  void frame_begun(TimePoint now);

  // Before each frame: takes over the size, the samples and the lights that the ladders want, as frames change between two and never
  // within one. `lights` are the scene's, `eye` is where the camera stands. Returns true if a frame's cost has changed.
  bool adapt(std::span<const scenes::Light> lights, const glm::vec3& eye, TimePoint now);

  // The device has no memory for a frame of this size. Returns true if the next frame is smaller, false if it can't be.
  bool shrink(TimePoint now, const Error& why);

  // Says again what is served. Called by itself where that changes.
  void tell_client() const;

  // Once in a while: the session gets less if the device did not keep up with it, or more again.
  void review(Nanoseconds since_last);
  // Once in a while: the session gets less if its link did not keep up with it, or more again.
  void review_link(const LinkWindow& window);

 private:
  double rate_hz() const { return opened_.grant.rate_hz * degradation_.point().rate; }
  TileGrid wanted_grid() const;
  uint32_t wanted_lights() const;
  bool adopt_size();
  bool choose_lights(std::span<const scenes::Light> lights, const glm::vec3& eye);
  void adopt_rate();

  const SessionOpened& opened_;
  FrameSink& sink_;
  Metrics& metrics_;
  uint32_t width_, height_;
  SampleCounts samples_;
  gpu::LightSet untraced_;
  scheduler::RateLimit rate_;
  scheduler::Degradation degradation_;
  LinkSteps link_;
  MemorySteps memory_;
  uint32_t arrived_ = 0, answered_ = 0;  // views since the last review
};

// That share of a side; in whole tiles, unless it is all of the side.
uint32_t shrunk(uint32_t side, double share);

}  // namespace gnomon::daemon
