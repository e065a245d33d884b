// All devices of the daemon. Each session is served by one of them, and moves when a device is lost, is drained or
// comes back. Scenes are resident on every device, so that only the session itself has to move.
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
  double load = 0;  // device seconds a second that its sessions are predicted to need; 1 is all of the device
};

// Any thread.
class DevicePool final : private DeviceThread::Owner {
 public:
  // `assumed_rate_hz`: of sessions that named no rate, where sessions are placed and the load is counted.
  DevicePool(size_t count, double assumed_rate_hz, Metrics& metrics, Health& health);

  // Called on the main thread, before any other call. `factories`: one for each device. `sink` outlives the pool's
  // threads. `failed` is called once, on a render thread, when the last device is beyond repair. Error if a device
  // cannot be opened.
  Result<void> start(const std::vector<RendererFactory>& factories, const SharingPolicy& sharing,
                     const SceneMotion::Settings& motion, FrameSink& sink,
                     std::function<void(const Error&)> failed);
  void stop();  // blocks until all threads have ended, which they do when their last leases are dropped

  size_t size() const { return devices_.size(); }
  std::vector<PooledDevice> report() const;
  ShareReport shares() const;
  CostModels costs() const;
  // For each scene, the report of the device on which the smallest share of its light buffers is built.
  SceneReports scenes() const;
  // One for each device; they live as long as the pool.
  std::vector<Heartbeat*> heartbeats();

  // Returns false if too many views wait or the device has failed; the view is dropped then.
  bool push_view(const ViewRequest& view);
  // Asks the devices that take sessions. `asked.answer` is called once: with a success as soon as one of them has room,
  // or at once if none takes sessions at the moment; with an error when all of them have refused.
  void ask_room(const CapacityRequested& asked);
  void open(const SessionOpened& session);
  void close(SessionId session);
  void review(const LinkReviewed& reviewed);
  void sent(uint32_t device, const BytesSent& sent);

  void set_sharing(const SharingPolicy& sharing);
  void change_light(const LightChanged& change);
  // Brings the scene to every device. `arrived.resident` is called once, when all have answered: with the footprint on
  // one of them, or with an error if one could not take it. Others may have it then, until take_away().
  void bring(const SceneLoaded& arrived);
  void take_away(SceneId scene);

  enum class DrainAnswer { done, no_such_device, last_in_service };
  // A drained device gets no sessions, and its sessions move to other devices. The last one that takes sessions is not
  // drained.
  DrainAnswer set_drained(size_t device, bool drained);

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
