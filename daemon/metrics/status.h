// What an operator may ask about a running daemon, as plain data. Net threads publish theirs about once a second.
#pragma once

#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "common/ids.h"
#include "gpu/renderer.h"
#include "protocol/messages.h"
#include "scheduler/cost_model.h"

namespace gnomon::daemon {

// What is known of the scenes' costs.
using CostModels = std::map<SceneId, scheduler::CostModel>;

// A scene on a device: what it takes there, and how far what the tracer builds for its lights is.
struct SceneReport {
  std::string name;
  gpu::SceneFootprint on_device;
  gpu::LightState lights;
  gpu::BuildProgress progress;  // no lights: nothing is being built
  bool failed = false;          // the last build; a hierarchy goes on to answer

  // Of all lights, 0 to 1. 1: they have what the tracer builds, or it builds nothing.
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
  std::string address;  // of its data; empty: none has proved itself yet
  uint32_t width = 0;
  uint32_t height = 0;
  protocol::Stats stats;
};

}  // namespace gnomon::daemon
