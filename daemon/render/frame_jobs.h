// The frames on the device: begun for the picked sessions, continued band by band, or given up.
#pragma once

#include <functional>

#include "daemon/frame/frame_sink.h"
#include "daemon/render/device_load.h"
#include "daemon/render/render_device.h"
#include "daemon/render/render_queue.h"

namespace gnomon::daemon {

// Belongs to the render thread; the caller passes the time.
class FrameJobs {
 public:
  // `sink` receives frames on the renderer's completion threads, `inbox` the cost of each job. All references outlive
  // this object and the leases.
  FrameJobs(RenderDevice& device, RenderInbox& inbox, Metrics& metrics, FrameSink& sink, SceneMotion& motion,
            RenderQueue& queue)
      : device_(device), inbox_(inbox), metrics_(metrics), sink_(sink), motion_(motion), queue_(queue) {}

  // Whether another job of full length may be submitted.
  bool look_for_room(TimePoint now);

  // Submits the next job of a picked session: its newest view, or the next band of its partial frame. A job that cannot
  // be submitted is not charged.
  void submit(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);

  // Abandons the session's partial frame and takes the session out of the queue. Bands that are on the device still
  // finish, but are not sent. Precondition: the session has a partial frame.
  void give_up(RenderSession& session);

  DeviceLoad& load() { return load_; }
  const DeviceLoad& load() const { return load_; }

 private:
  void begin(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  void resume(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  gpu::RenderJob job_of(const RenderSession& session, const PartialFrame& frame, TimePoint now) const;
  void submitted(RenderSession& session, TimePoint now);
  void not_submitted(RenderSession& session, const scheduler::Ticket& ticket, const Error& why, TimePoint now);
  std::function<void(gpu::FrameDone)> completion(const RenderSession& session, const scheduler::Ticket& ticket,
                                                 const PartialFrame& frame) const;

  RenderDevice& device_;
  RenderInbox& inbox_;
  Metrics& metrics_;
  FrameSink& sink_;
  SceneMotion& motion_;
  RenderQueue& queue_;
  DeviceLoad load_;
  uint64_t next_job_ = 1;
};

}  // namespace gnomon::daemon
