// What the daemon counts of its devices, for Prometheus. Part of Metrics. Any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clock.h"

namespace prometheus {
class Counter;
class Gauge;
class Registry;
}  // namespace prometheus

namespace gnomon::daemon {

class DeviceMetrics {
 public:
  // Of several devices each has series of its own, labelled by number; one device needs no label.
  DeviceMetrics(prometheus::Registry& registry, size_t devices);

  void busy(uint32_t device, Nanoseconds gpu_time);
  void lost(uint32_t device);
  void up(uint32_t device, bool up);
  void load(uint32_t device, double load);            // 1 is all of the device
  void sessions(uint32_t device, uint32_t sessions);  // no series where there is one device

 private:
  struct Series {
    prometheus::Counter& busy;
    prometheus::Gauge& up;
    prometheus::Counter& losses;
    prometheus::Gauge& load;
    prometheus::Gauge* sessions;  // nullptr where there is one device
  };
  std::vector<Series> devices_;
};

}  // namespace gnomon::daemon
