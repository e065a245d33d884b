// What operators see over HTTP.
#include <nlohmann/json.hpp>

#include "daemon/daemon.h"

namespace gnomon::daemon {
namespace {

using nlohmann::json;

json to_json(const std::string& name, const HostedScene& scene) {
  return {{"name", name},
          {"triangles", scene.loaded.scene->triangle_count},
          {"lights", scene.loaded.scene->lights.size()},
          {"hash", scenes::to_hex(scene.loaded.scene->content_hash)},
          {"load_seconds", scene.loaded.load_seconds},
          {"memory_bytes", scene.loaded.memory_bytes},
          {"device_memory_bytes", scene.on_device.memory_bytes},
          {"tracer_build_seconds", scene.on_device.tracer_build_seconds},
          {"period_seconds", std::chrono::duration<double>(scene.loaded.scene->period).count()},
          {"lights_version", scene.lights.version}};
}

json to_json(const DeviceStatus& device, bool up) {
  return {{"name", device.name}, {"driver", device.driver}, {"tracer", device.tracer}, {"up", up}};
}

json to_json(const TenantReport& tenant) {
  return {{"gpu_seconds", to_seconds(tenant.service)},
          {"share", tenant.share},
          {"expected_share", tenant.expected_share},
          {"lag_ms", to_milliseconds(tenant.lag)},
          {"cost_error", tenant.predicted_error}};
}

// Ids are 64 bits: as text, for readers whose numbers are doubles.
json to_json(const SessionStatus& session, const std::string& tenant) {
  return {{"id", std::to_string(session.id.value)},
          {"tenant", tenant},
          {"scene", session.scene},
          {"address", session.address},
          {"width", session.width},
          {"height", session.height},
          {"frames", session.stats.frames},
          {"coalesced", session.stats.coalesced},
          {"queue_us", session.stats.queue_us},
          {"gpu_us", session.stats.gpu_us},
          {"total_us", session.stats.total_us}};
}

}  // namespace

std::string Daemon::status_json() const {
  const auto& tenants = options_.config.tenants;
  const std::vector<SessionStatus> sessions = server_->sessions();
  const auto shares = shares_.get();
  const auto terms = terms_.get();
  json status{{"version", options_.version},
              {"ready", health_.ready()},
              {"draining", health_.draining.load()},
              {"devices", json::array({to_json(*device_status_.get(), health_.device_up)})},
              {"scenes", json::array()},
              {"policy", terms->policy},
              {"jain", shares->jain},
              {"worst_lag_ms", to_milliseconds(shares->worst_lag)},
              {"tenants", json::array()},
              {"sessions", json::array()}};
  for (const auto& [name, scene] : scenes_->resident()) status["scenes"].push_back(to_json(name, scene));
  for (uint32_t i = 0; i < tenants.size(); ++i) {
    const auto open = std::count_if(sessions.begin(), sessions.end(),
                                    [&](const SessionStatus& s) { return s.tenant == TenantId{i}; });
    json row{{"name", tenants[i].name}, {"weight", terms->tenants[i].terms.weight}, {"sessions", open}};
    if (i < shares->tenants.size()) row.update(to_json(shares->tenants[i]));
    status["tenants"].push_back(std::move(row));
  }
  for (const SessionStatus& session : sessions) {
    status["sessions"].push_back(to_json(session, tenants[session.tenant.value].name));
  }
  // A scene file's name may be no UTF-8: shown with replacement characters, never an exception.
  return status.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

// Says what is wrong before the render thread is asked; that it was asked is all that it says otherwise.
Page Daemon::change_light(const std::string& name, const std::string& light, const std::string& body) {
  const char* text = "text/plain; charset=utf-8";
  const auto resident = scenes_->resident();
  const auto scene = resident.find(name);
  if (scene == resident.end()) return {404, text, "no such scene is resident\n"};
  const std::vector<scenes::Light>& lights = scene->second.lights.lights;
  const size_t index = light.size() > 4 ? lights.size() : std::stoul(light);
  if (index >= lights.size()) return {404, text, "the scene has " + std::to_string(lights.size()) + " lights\n"};
  const auto change = parse_light_change(body);
  if (!change) return {400, text, change.error().message + "\n"};
  const auto changed = changed_light(lights[index], scene->second.loaded.scene->lights[index], *change);
  if (!changed) return {409, text, changed.error().message + "\n"};
  inbox_.push(LightChanged{scene->second.loaded.id, static_cast<uint32_t>(index), *change});
  return {202, text, "accepted\n"};
}

Admin::Actions Daemon::actions() {
  return {{"/scenes/(.+)/lights/([0-9]+)", [this](const std::vector<std::string>& groups, const std::string& body) {
             return change_light(groups[0], groups[1], body);
           }}};
}

Admin::Pages Daemon::pages() {
  const char* text = "text/plain; charset=utf-8";
  return {
      {"/healthz",
       [text] {
         return Page{200, text, "alive\n"};
       }},
      {"/readyz",
       [this, text] {
         return health_.ready() ? Page{200, text, "ready\n"} : Page{503, text, "not ready\n"};
       }},
      {"/metrics",
       [this] {
         return Page{200, "text/plain; version=0.0.4; charset=utf-8", metrics_.text()};
       }},
      {"/status",
       [this] {
         return Page{200, "application/json", status_json()};
       }},
  };
}

}  // namespace gnomon::daemon
