// What an operator may ask about a running daemon, as plain data. Net and render threads publish theirs about once a
// second.
#pragma once

#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "common/ids.h"
#include "daemon/metrics/transport_metrics.h"
#include "gpu/renderer.h"
#include "protocol/messages.h"
#include "scheduler/sample_costs.h"

namespace gnomon::daemon {

// What was learned of the costs of each scene's frames.
using CostModels = std::map<SceneId, scheduler::SampleCosts>;

// A scene on a device: its memory there, and how far the build of its light buffers is.
struct SceneReport {
  std::string name;
  gpu::SceneFootprint on_device;
  gpu::LightState lights;
  gpu::BuildProgress progress;  // without lights if nothing is being built
  bool failed = false;          // the last build; lights are still traced with a hierarchy

  // The share of all lights that is built, 0 to 1; 1 also if the tracer builds nothing.
  double built_share() const {
    if (progress.lights.empty()) return lights.unbuilt > 0 ? 0 : 1;
    return std::accumulate(progress.lights.begin(), progress.lights.end(), 0.0) /
           static_cast<double>(progress.lights.size());
  }
};
using SceneReports = std::map<SceneId, SceneReport>;

struct SessionStatus {
  SessionId id;
  TenantId tenant;
  std::string scene;
  Transport transport = Transport::udp;
  std::string address;  // where frames go; empty until a valid datagram has arrived from there
  uint32_t width = 0;
  uint32_t height = 0;
  SampleCounts samples;  // granted
  double rate_hz = 0;    // granted; 0: none was named
  struct Served {        // at present: less than was granted where the device cannot keep up
    uint32_t width = 0, height = 0;
    SampleCounts samples;
    double rate_hz = 0;
    uint32_t untraced_lights = 0;
  } served;
  protocol::Stats stats;
};

}  // namespace gnomon::daemon
