// The parts of a daemon that its operators inspect and change.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/published.h"
#include "common/result.h"
#include "daemon/config/sharing_policy.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/metrics/health.h"
#include "daemon/metrics/metrics.h"
#include "daemon/net/server.h"
#include "daemon/net/tls.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/scene_catalog.h"
#include "daemon/scenes/scene_host.h"
#include "daemon/session/session_limits.h"

namespace gnomon::daemon {

// Everything referred to outlives the holder and may be used on any thread.
struct OperatedParts {
  std::string version;
  const Published<SceneCatalog>& catalog;
  Health& health;
  Metrics& metrics;
  const Published<TenantDirectory>& tenants;
  const Published<SharingPolicy>& sharing;
  const PublishedTls& tls;
  DevicePool& devices;
  SceneHost& scenes;
  SceneLights& lights;
  const SessionLimits& limits;
  Server& server;
  std::function<void()> begin_stop;  // empty if nobody can be asked to stop
  // Answers with what has changed, key by key. Empty if there is no file to read again.
  std::function<void(std::function<void(Result<std::vector<std::string>>)>)> ask_for_reload;
};

}  // namespace gnomon::daemon
