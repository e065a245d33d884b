// One device: its render thread, its inbox, and the reports that it publishes.
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "common/published.h"
#include "daemon/metrics/status.h"
#include "daemon/render/render_loop.h"
#include "daemon/service/heartbeat.h"

namespace gnomon::daemon {

class DeviceThread {
 public:
  // The owner of the devices. Its functions are called on the render thread.
  class Owner {
   public:
    virtual void device_changed(uint32_t number, bool up) = 0;          // the device was lost or rebuilt
    virtual void device_failed(uint32_t number, const Error& why) = 0;  // once, last: it is beyond repair
    virtual void device_reported() = 0;                                 // shares(), costs(), scenes() are new

   protected:
    ~Owner() = default;
  };

  // `number`: among the daemon's devices. All references outlive this object.
  DeviceThread(uint32_t number, Metrics& metrics, Owner& owner)
      : number_(number), metrics_(metrics), owner_(owner) {}
  ~DeviceThread() { stop(); }

  // Opens the device and starts the thread. Error if it cannot be opened.
  Result<void> start(RendererFactory factory, const SharingPolicy& sharing, const SceneMotion::Settings& motion,
                     FrameSink& sink);
  // Blocks until the thread has ended, which it does when the last lease is dropped.
  void stop();

  // Any thread.
  RenderInbox& inbox() { return inbox_; }
  Heartbeat& heartbeat() { return heartbeat_; }
  bool up() const { return up_; }
  gpu::DeviceInfo info() const { return *info_.get(); }
  std::shared_ptr<const ShareReport> shares() const { return shares_.get(); }
  std::shared_ptr<const CostModels> costs() const { return costs_.get(); }
  std::shared_ptr<const SceneReports> scenes() const { return scenes_.get(); }

 private:
  void render();
  void show_life(const std::vector<RenderEvent>& done);
  void publish(TimePoint now);
  bool tell_change();
  void handle(std::vector<RenderEvent>& batch);
  void refuse_the_rest(const Error& why);

  const uint32_t number_;
  Metrics& metrics_;
  Owner& owner_;
  RenderInbox inbox_;
  Heartbeat heartbeat_;
  std::atomic<bool> up_{false};
  Published<gpu::DeviceInfo> info_;
  Published<ShareReport> shares_;
  Published<CostModels> costs_;
  Published<SceneReports> scenes_;
  TimePoint next_report_{};           // the render thread's
  std::unique_ptr<RenderLoop> loop_;  // outlives the device, whose last frames report to it
  std::unique_ptr<RenderDevice> device_;
  std::thread thread_;
};

}  // namespace gnomon::daemon
