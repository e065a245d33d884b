// What the net threads share with the rest of the daemon.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "common/published.h"
#include "common/wall_clock.h"
#include "daemon/config/config.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/metrics/health.h"
#include "daemon/metrics/metrics.h"
#include "daemon/net/tls.h"
#include "daemon/net/web_service.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/scene_host.h"
#include "daemon/scenes/scene_packs.h"
#include "daemon/session/credentials.h"
#include "daemon/session/kept_out.h"
#include "daemon/session/session_limits.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

// Everything referred to outlives the net threads and may be used by any of them.
struct NetShared {
  const Config& config;
  const Published<TenantDirectory>& tenants;
  const std::string& tracer;  // its name and the device's, for clients
  const Published<SceneCatalog>& catalog;
  const Health& health;
  const PublishedTls& tls;
  SceneHost& scenes;
  SessionLimits& limits;
  KeptOut& kept_out;
  SessionStore& store;
  DevicePool& devices;
  Metrics& metrics;
  const WebService* web = nullptr;  // nullptr: browsers are not served
  ScenePacks* packs = nullptr;      // set where `web` is
};

// What an operator closes a session with.
struct Kick {
  std::string why;                       // its client is told
  std::chrono::milliseconds stay_out{};  // for so long its client is kept out; 0: it may come back
};

// Why a session with this grant may not go on now, as its client is told; nullopt if it may.
inline std::optional<std::string> objection_to(const SessionGrant& grant, const NetShared& shared) {
  const auto tenants = shared.tenants.get();
  const auto tls = shared.tls.get();
  const ServerConfig& server = shared.config.server;
  return objection_to(grant.credential, grant.tenant,
                      {.tenants = *tenants,
                       .authorities = (*tls)->authorities,
                       .mode = server.mode,
                       .max_age = server.max_session_age},
                      wall_now());
}

}  // namespace gnomon::daemon
