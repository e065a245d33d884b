#include "daemon/admin/status_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/audit_file.h"
#include "common/wall_clock.h"
#include "daemon/admin/readiness.h"
#include "daemon/admin/taken_apart.h"

namespace gnomon::daemon {
namespace {

using nlohmann::json;

const char* state_of(const SceneReport& scene) {
  if (scene.failed) return "failed";
  if (scene.built_share() == 0) return "waiting";
  return scene.progress.lights.empty() ? "ready" : "building";
}

// How far the build of the scene's light buffers is. Until it is complete, frames are as exact but cost more.
json to_json(const SceneReport& scene) {
  return {{"state", state_of(scene)},
          {"percent", 100 * scene.built_share()},
          {"lights_percent",
           [&] {
             json lights = json::array();
             for (const float share : scene.progress.lights) lights.push_back(100 * share);
             return lights;
           }()},
          {"average_list", scene.on_device.tracer_average_list},
          {"longest_list", scene.on_device.tracer_longest_list}};
}

json to_json(const std::string& name, const HostedScene& scene, const SceneReport& report) {
  return {{"name", name},
          {"triangles", scene.loaded.scene->triangle_count},
          {"lights", scene.loaded.scene->lights.size()},
          {"hash", scenes::to_hex(scene.loaded.scene->content_hash)},
          {"sessions", scene.users},
          {"load_seconds", scene.loaded.load_seconds},
          {"memory_bytes", scene.loaded.memory_bytes},
          {"account_bytes", scene.account_bytes},
          {"device_memory_bytes", report.on_device.memory_bytes},
          {"tracer_build_seconds", report.on_device.tracer_build_seconds},
          {"light_buffers", to_json(report)},
          {"period_seconds", std::chrono::duration<double>(scene.loaded.scene->period).count()},
          {"lights_version", scene.lights.version}};
}

json to_json(const SceneUnderWay& scene, TimePoint now) {
  json shown{{"name", scene.name}, {"stage", to_string(scene.stage)}, {"seconds", to_seconds(now - scene.since)}};
  if (scene.share) shown["share"] = *scene.share;
  return shown;
}

json to_json(const PooledDevice& device) {
  return {{"name", device.name},         {"driver", device.driver}, {"tracer", device.tracer},
          {"raster", device.raster},     {"up", device.up},         {"drained", device.drained},
          {"sessions", device.sessions}, {"load", device.load}};
}

json to_json(const TenantTotals& totals) {
  return {{"buffers", totals.buffers}, {"bits", totals.bits}, {"bytes", totals.bytes}};
}

json to_json(const TenantReport& tenant) {
  return {{"gpu_seconds", to_seconds(tenant.service)},
          {"share", tenant.share},
          {"expected_share", tenant.expected_share},
          {"lag_ms", to_milliseconds(tenant.lag)},
          {"cost_error", tenant.predicted_error}};
}

// Ids have 64 bits and are given as text, for readers whose numbers are doubles.
json to_json(const SessionStatus& session, const std::string& tenant) {
  return {{"id", std::to_string(session.id.value)},
          {"tenant", tenant},
          {"scene", session.scene},
          {"transport", to_string(session.transport)},
          {"address", session.address},
          {"samples", session.samples.per_light},
          {"occlusion", to_string(session.samples.occlusion)},
          {"width", session.width},
          {"height", session.height},
          {"rate_hz", session.rate_hz},
          {"served",
           {{"samples", session.served.samples.per_light},
            {"occlusion", to_string(session.served.samples.occlusion)},
            {"width", session.served.width},
            {"height", session.served.height},
            {"rate_hz", session.served.rate_hz},
            {"untraced_lights", session.served.untraced_lights}}},
          {"frames", session.stats.frames},
          {"coalesced", session.stats.coalesced},
          {"queue_us", session.stats.queue_us},
          {"gpu_us", session.stats.gpu_us},
          {"total_us", session.stats.total_us}};
}

json to_json(const FirstExpiry& first, std::chrono::sys_seconds now) {
  return {{"key", first.key},
          {"expires", first.at.time_since_epoch().count()},
          {"days_left", std::chrono::floor<std::chrono::days>(first.at - now).count()}};
}

json to_json(const log::UnwrittenAudit& audit) { return {{"unwritten", audit.lines}, {"why", audit.why}}; }

// The document member by member and row by row, each written and gone before the next.
class Document {
 public:
  void add(const char* key, json value) {
    name(key);
    write(std::move(value), "\n  ");
  }
  template <typename Rows, typename ToJson>
  void add_rows(const char* key, const Rows& rows, ToJson row_of) {
    name(key);
    text_ += "[";
    const char* before = "\n    ";
    for (const auto& row : rows) {
      text_ += std::exchange(before, ",\n    ");
      write(row_of(row), "\n    ");
    }
    text_ += "]";
  }
  std::string text() && { return std::move(text_) + "\n}\n"; }

 private:
  void name(const char* key) {
    text_ += std::exchange(before_, ",\n  ");
    write(key, "");
    text_ += ": ";
  }
  // A scene file's name may not be valid UTF-8: replacement characters avoid an exception.
  void write(json value, std::string_view line) {
    const TakenApart taken(std::move(value));
    for (const char c : taken.value().dump(2, ' ', false, json::error_handler_t::replace)) {
      if (c == '\n') {
        text_ += line;
      } else {
        text_ += c;
      }
    }
  }

  std::string text_ = "{";
  const char* before_ = "\n  ";
};

void add_tenants(Document& document, const OperatedParts& parts, const std::vector<SessionStatus>& sessions,
                 const SessionMemory& memory) {
  const auto directory = parts.tenants.get();
  const ShareReport shares = parts.devices.shares();
  const auto sharing = parts.sharing.get();
  std::vector<uint32_t> shown;
  std::vector<size_t> open_sessions(std::min(directory->size(), sharing->tenants.size()));
  for (uint32_t i = 0; i < open_sessions.size(); ++i) {
    open_sessions[i] = static_cast<size_t>(std::count_if(
        sessions.begin(), sessions.end(), [&](const SessionStatus& s) { return s.tenant == TenantId{i}; }));
    if (directory->open(TenantId{i}) || open_sessions[i] > 0) shown.push_back(i);
  }
  document.add("policy", sharing->policy);
  document.add("jain", shares.jain);
  document.add("worst_lag_ms", to_milliseconds(shares.worst_lag));
  document.add_rows("tenants", shown, [&](uint32_t i) {
    json row{{"name", directory->name(TenantId{i})},
             {"weight", sharing->tenants[i].scheduling.weight},
             {"sessions", open_sessions[i]},
             {"session_memory_bytes", i < memory.of_tenant.size() ? memory.of_tenant[i] : 0}};
    row.update(to_json(parts.metrics.totals(TenantId{i})));
    if (i < shares.tenants.size()) row.update(to_json(shares.tenants[i]));
    return row;
  });
  document.add_rows("sessions", sessions,
                    [&](const SessionStatus& s) { return to_json(s, directory->name(s.tenant)); });
}

}  // namespace

std::string status_json(const OperatedParts& parts) {
  const std::vector<SessionStatus> sessions = parts.server.sessions();
  const SessionMemory session_memory = parts.limits.memory();
  Document document;
  document.add("version", parts.version);
  document.add("ready", parts.health.ready());
  document.add("why_not_ready", why_not_ready(parts));
  document.add("draining", parts.health.draining.load());
  document.add("stopping", parts.health.stopping.load());
  document.add_rows("devices", parts.devices.report(), [](const PooledDevice& device) { return to_json(device); });
  document.add("scene_memory",
               {{"bytes", parts.scenes.memory().bytes}, {"limit_bytes", parts.scenes.memory().limit_bytes}});
  document.add("session_memory", {{"bytes", session_memory.bytes}, {"limit_bytes", session_memory.limit_bytes}});
  const SceneReports reports = parts.devices.scenes();
  document.add_rows("scenes", parts.scenes.resident(), [&](const auto& resident) {
    const auto& [name, scene] = resident;
    const auto report = reports.find(scene.loaded.id);
    return to_json(
        name, scene,
        report == reports.end() ? SceneReport{name, scene.on_device, {.unbuilt = 1}, {}} : report->second);
  });
  document.add_rows("scenes_under_way", parts.scenes.under_way(),
                    [now = Clock::now()](const SceneUnderWay& scene) { return to_json(scene, now); });
  document.add("certificate", to_json(first_expiry(**parts.tls.get()), wall_now()));
  document.add("audit", to_json(log::unwritten_audit()));
  add_tenants(document, parts, sessions, session_memory);
  return std::move(document).text();
}

}  // namespace gnomon::daemon
