// The policy of one device: start what capacity allows, then wait for one event (as ninja's Builder::Build).
//
// Owns the scheduler, the device and the newest view of every session; a newer camera replaces one not rendered yet.
// No locks, no clock: everything here belongs to the render thread and is told the time.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>

#include "daemon/config/terms.h"
#include "daemon/frame/frame_sink.h"
#include "daemon/metrics/metrics.h"
#include "daemon/metrics/status.h"
#include "daemon/render/render_device.h"
#include "daemon/render/render_inbox.h"
#include "daemon/render/render_session.h"
#include "daemon/render/scene_motion.h"
#include "daemon/render/share_account.h"

namespace gnomon::daemon {

class RenderLoop {
 public:
  // All references outlive the loop and its leases.
  RenderLoop(const Terms& terms, RenderDevice& device, RenderInbox& inbox, Metrics& metrics, FrameSink& sink);

  void start(TimePoint now);                      // start what capacity allows
  void handle(RenderEvent event, TimePoint now);  // then react to one event
  TimePoint wake_at() const;                      // start again then, even if nothing happens

  bool finished() const { return failure_ || (stopping_ && in_flight_ == 0 && submits_ == 0); }
  const std::optional<Error>& failure() const { return failure_; }  // the device is beyond repair
  bool device_up() const { return !lost_; }
  uint32_t frames_out() const { return in_flight_; }  // begun or on the device or being encoded
  SceneMotion& motion() { return motion_; }

  const CostModels& costs() const { return models_; }
  // Once in a while: sessions that the device did not keep up with since the last time get less, others more again.
  void review_sessions(Nanoseconds since_last);
  ShareReport shares();  // since the last call

 private:
  void on(const ViewRequest& view, TimePoint now);
  void on(const RoomAsked& asked, TimePoint now);
  void on(const SessionOpened& opened, TimePoint now);
  void on(const SessionClosed& closed, TimePoint now);
  void on(const CodecChosen& chosen, TimePoint now);
  void on(const SessionLeaves& leaves, TimePoint now);
  void on(const SceneArrived& arrived, TimePoint now);
  void on(const SceneLeaves& leaves, TimePoint now);
  void on(const JobFinished& finished, TimePoint now);
  void on(const LeaseDropped&, TimePoint now);
  void on(const BytesSent& sent, TimePoint now);
  void on(const TermsChanged& changed, TimePoint now);
  void on(const TenantPart& part, TimePoint now);
  void on(const LightChanged& changed, TimePoint now);
  void on(const LinkReviewed& reviewed, TimePoint now);
  void on(const BackgroundDone&, TimePoint) {}  // start() looks after it
  void on(const StopRendering&, TimePoint now);

  void apply(const Terms& terms, TimePoint now);
  Nanoseconds slice() const;
  bool has_room(TimePoint now);
  void ask(RenderSession& session, TimePoint now);
  void ask_anew(SceneId scene, TimePoint now);
  scheduler::CostModel& model_of(SceneId scene);
  void meet_new_costs(SceneId scene, TimePoint now);
  void ask_when_allowed(RenderSession& session, TimePoint now);
  void release_held(TimePoint now);
  void drop_hopeless(TimePoint now);
  void submit(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  void adopt_size(RenderSession& session);
  void choose_lights(RenderSession& session, const gpu::CameraView& camera);
  void set_terms(RenderSession& session);
  void tell(const RenderSession& session);
  void begin(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  void resume(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  void started(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now);
  void not_started(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now, const Error& error);
  bool shrink(RenderSession& session, const scheduler::Ticket& ticket, const ViewRequest& view, TimePoint now,
              const Error& error);
  void not_afforded(const JobFinished& job, TimePoint now);
  void abandon(RenderSession& session);
  void give_up_begun(RenderSession& session);
  void lose_device();
  void recover(TimePoint now);
  void refuse_waiting(const Error& why);
  void forget(SessionId id);
  std::function<void(gpu::FrameDone)> completion(const RenderSession& session, const scheduler::Ticket& ticket,
                                                 const BegunFrame& frame);

  RenderDevice& device_;
  RenderInbox& inbox_;
  Metrics& metrics_;
  FrameSink& sink_;
  const Nanoseconds usual_slice_;  // of the device's kind
  SceneMotion motion_;

  Terms terms_;
  std::unique_ptr<scheduler::Scheduler> scheduler_;
  uint64_t policy_ = 0;  // counts the schedulers that there were
  ShareAccount account_;
  CostModels models_, unbuilt_models_;  // of frames that are answered by what the tracer builds, or not yet
  std::unordered_map<SessionId, RenderSession> sessions_;
  std::multimap<TimePoint, SessionId> held_;  // until then they may not ask
  std::vector<RenderEvent> waiting_;          // for the device to be back: scenes, changed lights

  uint64_t next_job_ = 1;
  uint32_t in_flight_ = 0;                // frames whose lease has not come back, those begun included
  uint32_t begun_ = 0;                    // of these, not all submitted
  uint32_t submits_ = 0;                  // not done
  Nanoseconds predicted_{};               // of these
  TimePoint runs_dry_{};                  // when they are done, as far as predictions go
  TimePoint room_at_ = TimePoint::max();  // then there is room if nothing happens before
  bool lost_ = false;
  bool stopping_ = false;
  std::optional<Error> failure_;
};

}  // namespace gnomon::daemon
