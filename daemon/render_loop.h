// The policy of one device: start what capacity allows, then wait for one event (as ninja's Builder::Build).
//
// Owns the scheduler, the device and the newest view of every session; a newer camera replaces one not rendered yet.
// No locks, no clock: everything here belongs to the render thread and is told the time.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>

#include "daemon/metrics.h"
#include "daemon/render_device.h"
#include "daemon/render_inbox.h"
#include "scheduler/scheduler.h"

namespace gnomon::daemon {

class RenderLoop {
 public:
  // `rendered` is called from the renderer's completion thread. All references outlive the loop and its leases.
  RenderLoop(std::unique_ptr<scheduler::Scheduler> scheduler, RenderDevice& device, RenderInbox& inbox,
             Metrics& metrics, std::function<void(RenderedFrame)> rendered);

  void start(TimePoint now);                      // start what capacity allows
  void handle(RenderEvent event, TimePoint now);  // then react to one event

  bool finished() const { return failure_ || (stopping_ && in_flight_ == 0); }
  const std::optional<Error>& failure() const { return failure_; }  // the device is beyond repair
  bool device_up() const { return !lost_; }

 private:
  struct Session {
    SessionOpened opened;
    std::optional<ViewRequest> newest;
    uint32_t coalesced = 0;                           // since its last frame
    Nanoseconds cost = std::chrono::milliseconds(1);  // of its last frame
  };

  void on(const ViewRequest& view, TimePoint now);
  void on(const SessionOpened& opened, TimePoint now);
  void on(const SessionClosed& closed, TimePoint now);
  void on(const SceneArrived& arrived, TimePoint now);
  void on(const FrameFinished& finished, TimePoint now);
  void on(const LeaseDropped&, TimePoint now);
  void on(const StopRendering&, TimePoint now);

  void submit(Session& session, const scheduler::Ticket& ticket, TimePoint now);
  void recover(TimePoint now);
  std::function<void(gpu::FrameDone)> completion(const FrameMeta& meta, const scheduler::Ticket& ticket);

  std::unique_ptr<scheduler::Scheduler> scheduler_;
  RenderDevice& device_;
  RenderInbox& inbox_;
  Metrics& metrics_;
  std::function<void(RenderedFrame)> rendered_;

  std::unordered_map<SessionId, Session> sessions_;
  uint64_t next_job_ = 1;
  uint32_t in_flight_ = 0;       // submits whose lease has not come back
  uint32_t failed_submits_ = 0;  // in a row
  bool lost_ = false;
  bool stopping_ = false;
  std::optional<Error> failure_;
};

}  // namespace gnomon::daemon
