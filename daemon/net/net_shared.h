// What the net threads share with the rest of the daemon.
#pragma once

#include <string>

#include "common/published.h"
#include "daemon/config/config.h"
#include "daemon/config/roster.h"
#include "daemon/metrics/health.h"
#include "daemon/metrics/metrics.h"
#include "daemon/net/tls.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/scene_host.h"
#include "daemon/session/seats.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

// Everything referred to outlives the net threads and may be used by any of them.
struct NetShared {
  const Config& config;
  const Published<Roster>& roster;
  const std::string& tracer;  // its name, for clients
  const SceneCatalog& catalog;
  const Health& health;
  const PublishedTls& tls;
  SceneHost& scenes;
  Seats& seats;
  SessionStore& store;
  DevicePool& devices;
  Metrics& metrics;
};

}  // namespace gnomon::daemon
