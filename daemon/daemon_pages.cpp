// What operators see over HTTP.
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "daemon/admin/page_files.h"
#include "daemon/daemon.h"

namespace gnomon::daemon {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr const char* kText = "text/plain; charset=utf-8";
constexpr size_t kMaxWhy = 200;  // bytes that a client is told

const char* state_of(const SceneReport& scene) {
  if (scene.failed) return "failed";
  if (scene.built_share() == 0) return "waiting";
  return scene.progress.lights.empty() ? "ready" : "building";
}

// What the tracer builds for the scene's lights. Until it is ready frames are as exact, and cost more.
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
          {"device_memory_bytes", report.on_device.memory_bytes},
          {"tracer_build_seconds", report.on_device.tracer_build_seconds},
          {"light_buffers", to_json(report)},
          {"period_seconds", std::chrono::duration<double>(scene.loaded.scene->period).count()},
          {"lights_version", scene.lights.version}};
}

json to_json(const PooledDevice& device) {
  return {{"name", device.name},        {"driver", device.driver}, {"tracer", device.tracer},
          {"raster", device.raster},    {"up", device.up},         {"drained", device.drained},
          {"sessions", device.sessions}};
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
  const auto directory = tenant_directory_.get();
  const std::vector<SessionStatus> sessions = server_->sessions();
  const ShareReport shares = devices_.shares();
  const auto sharing = sharing_policy_.get();
  json status{{"version", options_.version},
              {"ready", health_.ready()},
              {"draining", health_.draining.load()},
              {"devices", json::array()},
              {"scenes", json::array()},
              {"policy", sharing->policy},
              {"jain", shares.jain},
              {"worst_lag_ms", to_milliseconds(shares.worst_lag)},
              {"tenants", json::array()},
              {"sessions", json::array()}};
  for (const PooledDevice& device : devices_.report()) status["devices"].push_back(to_json(device));
  const SceneReports reports = devices_.scenes();
  for (const auto& [name, scene] : scenes_->resident()) {
    const auto report = reports.find(scene.loaded.id);
    const SceneReport just_arrived{name, scene.on_device, {.unbuilt = 1}, {}};
    status["scenes"].push_back(to_json(name, scene, report == reports.end() ? just_arrived : report->second));
  }
  for (uint32_t i = 0; i < std::min(directory->size(), sharing->tenants.size()); ++i) {
    const auto open = std::count_if(sessions.begin(), sessions.end(),
                                    [&](const SessionStatus& s) { return s.tenant == TenantId{i}; });
    if (!directory->open(TenantId{i}) && open == 0) continue;
    json row{
        {"name", directory->name(TenantId{i})}, {"weight", sharing->tenants[i].terms.weight}, {"sessions", open}};
    row.update(to_json(metrics_.totals(TenantId{i})));
    if (i < shares.tenants.size()) row.update(to_json(shares.tenants[i]));
    status["tenants"].push_back(std::move(row));
  }
  for (const SessionStatus& session : sessions) {
    status["sessions"].push_back(to_json(session, directory->name(session.tenant)));
  }
  // A scene file's name may be no UTF-8: shown with replacement characters, never an exception.
  return status.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

// Says what is wrong before the render thread is asked; that it was asked is all that it says otherwise.
Page Daemon::change_light(const std::string& name, const std::string& light, const std::string& body) {
  const auto resident = scenes_->resident();
  const auto scene = resident.find(name);
  if (scene == resident.end()) return {404, kText, "no such scene is resident\n"};
  const std::vector<scenes::Light>& lights = scene->second.lights.lights;
  const size_t index = light.size() > 4 ? lights.size() : std::stoul(light);
  if (index >= lights.size()) return {404, kText, "the scene has " + std::to_string(lights.size()) + " lights\n"};
  const auto change = parse_light_change(body);
  if (!change) return {400, kText, change.error().message + "\n"};
  const auto changed = changed_light(lights[index], scene->second.loaded.scene->lights[index], *change);
  if (!changed) return {409, kText, changed.error().message + "\n"};
  devices_.change_light({scene->second.loaded.id, static_cast<uint32_t>(index), *change});
  return {202, kText, "accepted\n"};
}

Page Daemon::kick(const std::string& session, const std::string& body) {
  SessionId id;
  const auto read = std::from_chars(session.data(), session.data() + session.size(), id.value);
  const json asked = json::parse(body, nullptr, false);
  if (read.ec != std::errc()) return {404, kText, "no such session\n"};
  if (!asked.is_object()) return {400, kText, "the body must be a JSON object\n"};
  const auto why = asked.find("why");
  if (why != asked.end() && (!why->is_string() || why->get_ref<const std::string&>().size() > kMaxWhy)) {
    return {400, kText, "why: allowed is a text of up to " + std::to_string(kMaxWhy) + " bytes\n"};
  }
  const std::string told = why == asked.end() ? "closed by the operator" : why->get<std::string>();
  return server_->kick(id, told) ? Page{200, kText, "closed\n"} : Page{404, kText, "no such session\n"};
}

Page Daemon::drain_device(const std::string& number, bool drained) {
  size_t device = devices_.size();
  std::from_chars(number.data(), number.data() + number.size(), device);
  if (!devices_.set_drained(device, drained)) return {404, kText, "no such device\n"};
  return {200, kText, drained ? "drained\n" : "takes sessions\n"};
}

Page Daemon::begin_drain() {
  if (!options_.on_drain) return {501, kText, "this daemon cannot be drained from here\n"};
  health_.draining = true;  // at once: main may be busy
  options_.on_drain();
  return {202, kText, "draining\n"};
}

// Those who answer may end before they do: a daemon that stops keeps nobody waiting.
Page Daemon::await(std::future<Result<void>> done, const char* what) {
  while (done.wait_for(50ms) != std::future_status::ready) {
    if (health_.draining) return {503, kText, "the server is stopping\n"};
  }
  const auto result = done.get();
  return result ? Page{200, kText, std::string(what) + "\n"} : Page{409, kText, result.error().message + "\n"};
}

// One at a time: each holds a thread of this server's few for as long as it takes.
Page Daemon::load_scene(const std::string& asked) {
  const std::string name = catalog_.find(asked);
  if (name.empty()) return {404, kText, "the configuration has no such scene\n"};
  if (loading_.exchange(true)) return {409, kText, "another scene is being loaded\n"};
  auto done = std::make_shared<std::promise<Result<void>>>();
  scenes_->fetch(name, [done](Result<SceneForUse> scene) {
    done->set_value(scene ? Result<void>() : Result<void>(scene.error()));
  });
  const Page answer = await(done->get_future(), "loaded");
  loading_ = false;
  return answer;
}

Page Daemon::unload_scene(const std::string& asked) {
  const auto gone = scenes_->unload(catalog_.find(asked));
  return gone ? Page{200, kText, "unloaded\n"} : Page{409, kText, gone.error().message + "\n"};
}

// The main thread reads and applies; this one waits for what it says.
Page Daemon::reload_page() {
  if (!options_.ask_for_reload) return {501, kText, "this daemon has no configuration file\n"};
  auto done = std::make_shared<std::promise<Result<void>>>();
  options_.ask_for_reload([done](Result<void> reloaded) { done->set_value(std::move(reloaded)); });
  return await(done->get_future(), "reloaded");
}

Admin::Actions Daemon::actions() {
  using Groups = std::vector<std::string>;
  return {
      {"/sessions/([0-9]+)/kick", [this](const Groups& g, const std::string& body) { return kick(g[0], body); }},
      {"/devices/([0-9]+)/drain", [this](const Groups& g, const std::string&) { return drain_device(g[0], true); }},
      {"/devices/([0-9]+)/resume",
       [this](const Groups& g, const std::string&) { return drain_device(g[0], false); }},
      {"/reload", [this](const Groups&, const std::string&) { return reload_page(); }},
      {"/drain", [this](const Groups&, const std::string&) { return begin_drain(); }},
      {"/scenes/(.+)/load", [this](const Groups& g, const std::string&) { return load_scene(g[0]); }},
      {"/scenes/(.+)/unload", [this](const Groups& g, const std::string&) { return unload_scene(g[0]); }},
      {"/scenes/(.+)/lights/([0-9]+)",
       [this](const Groups& g, const std::string& body) { return change_light(g[0], g[1], body); }},
  };
}

Admin::Pages Daemon::pages() {
  return {
      {"/",
       [] {
         return Page{200, "text/html; charset=utf-8", kPageHtml};
       }},
      {"/page.css",
       [] {
         return Page{200, "text/css; charset=utf-8", kPageCss};
       }},
      {"/page.js",
       [] {
         return Page{200, "text/javascript; charset=utf-8", kPageJs};
       }},
      {"/healthz",
       [this] {
         return health_.hangs(Clock::now()) ? Page{503, kText, "a render thread hangs\n"}
                                            : Page{200, kText, "alive\n"};
       }},
      {"/readyz",
       [this] {
         return health_.ready() ? Page{200, kText, "ready\n"} : Page{503, kText, "not ready\n"};
       }},
      {"/metrics",
       [this] {
         metrics_.ready(health_.ready());
         return Page{200, "text/plain; version=0.0.4; charset=utf-8", metrics_.text()};
       }},
      {"/status",
       [this] {
         return Page{200, "application/json", status_json()};
       }},
  };
}

}  // namespace gnomon::daemon
