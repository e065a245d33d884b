// The policy of one device: start what capacity allows, then wait for one event (as ninja's Builder::Build).
//
// The loop connects parts that own what they decide about: RenderQueue the sessions and whose turn it is,
// SessionQuality what each of them is served, FrameJobs the frames on the device, SceneCosts what frames cost,
// SceneMotion the scenes' clock and lights, DeviceRecovery the device's losses. No locks, no clock: everything here
// belongs to the render thread, and the caller passes the time.
#pragma once

#include "daemon/render/device_recovery.h"
#include "daemon/render/frame_jobs.h"

namespace gnomon::daemon {

class RenderLoop {
 public:
  // All references outlive the loop and its leases.
  RenderLoop(const SharingPolicy& sharing, RenderDevice& device, RenderInbox& inbox, Metrics& metrics,
             FrameSink& sink);

  void start(TimePoint now);                      // start what capacity allows
  void handle(RenderEvent event, TimePoint now);  // then react to one event
  TimePoint wake_at() const;                      // start again then, even if nothing happens

  bool finished() const { return failure() || (stopping_ && jobs_.load().idle()); }
  const std::optional<Error>& failure() const { return recovery_.failure(); }  // the device is beyond repair
  bool device_up() const { return !recovery_.lost(); }
  uint32_t frames_out() const { return jobs_.load().frames_out(); }  // begun or on the device or being encoded
  SceneMotion& motion() { return motion_; }

  const CostModels& costs() const { return costs_.built(); }
  // Once in a while: sessions that the device did not keep up with since the last time get less, others more again.
  void review_sessions(Nanoseconds since_last);
  ShareReport shares() { return queue_.shares(); }  // since the last call

 private:
  void recover(TimePoint now);
  void take_view(const ViewRequest& view, TimePoint now);
  void answer_room(const CapacityRequested& asked, TimePoint now);
  void close(SessionId id);
  void move_away(const SessionMoved& leaves);
  void bring_scene(const SceneLoaded& arrived);
  void remove_scene(SceneId scene);
  void change_light(const LightChanged& changed, TimePoint now);
  void settle_job(const JobFinished& job, TimePoint now);
  void settle_unstarted(const JobFinished& job, TimePoint now);
  void lose_device();
  void stop();
  void forget(RenderSession& session);

  RenderDevice& device_;
  Metrics& metrics_;
  SceneMotion motion_;
  SceneCosts costs_;
  RenderQueue queue_;
  FrameJobs jobs_;
  DeviceRecovery recovery_;
  bool stopping_ = false;
};

}  // namespace gnomon::daemon
