// Frames on the device: begun for sessions that were picked, continued band by band, given up.
#pragma once

#include <functional>

#include "daemon/frame/frame_sink.h"
#include "daemon/render/device_load.h"
#include "daemon/render/render_device.h"
#include "daemon/render/render_queue.h"

namespace gnomon::daemon {

// The render thread's; told the time.
class FrameJobs {
 public:
  // `sink` gets frames from the renderer's completion threads, `inbox` what each job cost. References outlive this and
  // the leases.
  FrameJobs(RenderDevice& device, RenderInbox& inbox, Metrics& metrics, FrameSink& sink, SceneMotion& motion,
            RenderQueue& queue)
      : device_(device), inbox_(inbox), metrics_(metrics), sink_(sink), motion_(motion), queue_(queue) {}

  // Another job of full length may be submitted.
  bool has_room(TimePoint now);

  // The next job of a session that was picked: the newest view there is at this moment, or the next band of its frame.
  // What cannot be submitted is charged nothing.
  void submit(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);

  // The bands of the session's partial frame that are on the device are done, but nobody will see them; the session
  // leaves the queue.
  void give_up(RenderSession& session);

  DeviceLoad& load() { return load_; }
  const DeviceLoad& load() const { return load_; }

 private:
  void begin(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  void resume(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  gpu::RenderJob job_of(const RenderSession& session, const PartialFrame& frame, TimePoint now) const;
  void submitted(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
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
