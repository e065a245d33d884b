// What the net threads share with the rest of the daemon.
#pragma once

#include <string>

#include "common/published.h"
#include "daemon/config/config.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/metrics/health.h"
#include "daemon/metrics/metrics.h"
#include "daemon/net/tls.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/scene_host.h"
#include "daemon/session/session_limits.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

// Everything referred to outlives the net threads and may be used by any of them.
struct NetShared {
  const Config& config;
  const Published<TenantDirectory>& tenants;
  const std::string& tracer;  // its name, for clients
  const SceneCatalog& catalog;
  const Health& health;
  const PublishedTls& tls;
  SceneHost& scenes;
  SessionLimits& limits;
  SessionStore& store;
  DevicePool& devices;
  Metrics& metrics;
};

}  // namespace gnomon::daemon
