#include "daemon/metrics/device_metrics.h"

#include <string>

#include "daemon/metrics/prometheus_families.h"

namespace gnomon::daemon {

DeviceMetrics::DeviceMetrics(prometheus::Registry& registry, size_t devices) {
  auto& busy =
      counter_family(registry, "gnomon_device_busy_seconds_total", "Time that the device spent on frames.");
  auto& up = gauge_family(registry, "gnomon_device_up", "1: the device takes work, 0: it is being made anew.");
  auto& losses = counter_family(registry, "gnomon_device_losses_total", "Times that the device was lost.");
  auto& load = gauge_family(registry, "gnomon_load_ratio",
                            "Device seconds a second that open sessions are predicted to need; 1 is all of it.");
  auto& sessions = gauge_family(registry, "gnomon_device_sessions",
                                "Open sessions that live on the device, where there are several.");
  for (size_t i = 0; i < devices; ++i) {
    const prometheus::Labels label =
        devices == 1 ? prometheus::Labels{} : prometheus::Labels{{"device", std::to_string(i)}};
    devices_.push_back({.busy = busy.Add(label),
                        .up = up.Add(label),
                        .losses = losses.Add(label),
                        .load = load.Add(label),
                        .sessions = devices == 1 ? nullptr : &sessions.Add(label)});
  }
}

void DeviceMetrics::busy(uint32_t device, Nanoseconds gpu_time) {
  devices_[device].busy.Increment(to_seconds(gpu_time));
}

void DeviceMetrics::lost(uint32_t device) { devices_[device].losses.Increment(); }

void DeviceMetrics::up(uint32_t device, bool up) { devices_[device].up.Set(up ? 1 : 0); }

void DeviceMetrics::load(uint32_t device, double load) { devices_[device].load.Set(load); }

void DeviceMetrics::sessions(uint32_t device, uint32_t sessions) {
  if (prometheus::Gauge* gauge = devices_[device].sessions) gauge->Set(sessions);
}

}  // namespace gnomon::daemon
