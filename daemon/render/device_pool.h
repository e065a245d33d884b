// All devices of the daemon. A session lives on one of them, and moves when that is lost, drained or comes back; scenes
// are resident on each, so that a move needs nothing but the session itself.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "daemon/metrics/health.h"
#include "daemon/render/device_thread.h"
#include "daemon/render/session_places.h"

namespace gnomon::daemon {

struct PooledDevice : gpu::DeviceInfo {
  bool up = false;
  bool drained = false;
  uint32_t sessions = 0;
};

// Any thread.
class DevicePool final : private DeviceThread::Owner {
 public:
  DevicePool(size_t count, Metrics& metrics, Health& health);

  // The main thread, before all others. `factories`: as many as there are devices. `sink` outlives the pool's threads.
  // `failed` is called once, from a render thread: the last device is beyond repair. Error: one cannot be opened.
  Result<void> start(const std::vector<RendererFactory>& factories, const SharingPolicy& terms,
                     const SceneMotion::Settings& motion, FrameSink& sink,
                     std::function<void(const Error&)> failed);
  void stop();  // all threads end when their last leases have come back

  size_t size() const { return devices_.size(); }
  std::vector<PooledDevice> report() const;
  ShareReport shares() const;
  CostModels costs() const;
  // Of each scene, what the device says that is the least ready for it.
  SceneReports scenes() const;
  // Every device's.
  std::vector<Heartbeat*> heartbeats();

  // False: too many views wait, or the device takes none.
  bool push_view(const ViewRequest& view);
  // `asked.answer` is called once: there is room as soon as one device that takes sessions says so, or if none does at
  // the moment; there is none when all have said so.
  void ask_room(const RoomAsked& asked);
  void open(const SessionOpened& session);
  void close(SessionId session);
  void choose_codec(const CodecChosen& chosen);
  void review(const LinkReviewed& reviewed);
  void sent(uint32_t device, const BytesSent& sent);

  void set_terms(const SharingPolicy& terms);
  void change_light(const LightChanged& change);
  // To every device. `arrived.resident` is called once, when all have answered: with what it takes on one of them, or
  // the error where none could take it.
  void bring(const SceneArrived& arrived);
  void take_away(SceneId scene);

  // A drained device gets no sessions, and those that it has move to others, if there are any. False: no such device.
  bool set_drained(size_t device, bool drained);

 private:
  void device_changed(uint32_t device, bool up) override;
  void device_failed(uint32_t device, const Error& why) override;
  void device_reported() override;

  Metrics& metrics_;
  Health& health_;
  std::function<void(const Error&)> failed_;
  std::vector<std::unique_ptr<DeviceThread>> devices_;

  mutable std::mutex mutex_;
  SessionPlaces places_;  // guarded by mutex_
};

}  // namespace gnomon::daemon
