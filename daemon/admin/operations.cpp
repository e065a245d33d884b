#include "daemon/admin/operations.h"

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/wall_clock.h"
#include "daemon/admin/page_files.h"
#include "daemon/admin/readiness.h"
#include "daemon/admin/status_json.h"
#include "daemon/render/light_change.h"

namespace gnomon::daemon {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr const char* kText = "text/plain; charset=utf-8";
constexpr size_t kMaxWhy = 200;  // bytes of the reason that the client is sent
// For how long a client that was kicked is kept out: where the operator says nothing, and at most.
constexpr int64_t kUsualStayOutS = 60;
constexpr int64_t kLongestStayOutS = 7 * 24 * 3600;
constexpr int64_t kLatestMs = int64_t{1} << 53;  // which every JSON reader has exactly

// The member `name` of the object, or `usual` where it has none; nullopt if it is no whole number from 0 to `most`.
std::optional<int64_t> whole_number(const json& object, const char* name, int64_t usual, int64_t most) {
  const auto found = object.find(name);
  if (found == object.end()) return usual;
  const bool fits = found->is_number_unsigned() && found->get<uint64_t>() <= static_cast<uint64_t>(most);
  return fits ? std::optional<int64_t>(found->get<int64_t>()) : std::nullopt;
}

// A change of a light, and when it was made where its body says so (`at_ms`): one that goes to all nodes of a fleet has one
// time.
struct DatedChange {
  LightChange change;
  int64_t at_ms = 0;
};

Result<DatedChange> parse_dated_change(const std::string& body) {
  json asked = json::parse(body, nullptr, false);
  if (!asked.is_object()) return Error{"the body must be a JSON object"};
  const int64_t now_ms = std::chrono::milliseconds(wall_now().time_since_epoch()).count();
  const auto at_ms = whole_number(asked, "at_ms", now_ms, kLatestMs);
  if (!at_ms) return Error{"at_ms: allowed is a whole number of milliseconds since 1970"};
  asked.erase("at_ms");
  const auto change = parse_light_change(asked.dump(-1, ' ', false, json::error_handler_t::replace));
  if (!change) return change.error();
  return DatedChange{*change, *at_ms};
}

// A line for each change.
std::string words_about(const std::vector<std::string>& changes) {
  std::string text = changes.empty() ? "reloaded; no key has changed" : "reloaded";
  for (const std::string& change : changes) text += "\n" + change;
  return text;
}

}  // namespace

Operations::Operations(OperatedParts parts) : parts_(std::move(parts)) {}

// The change is checked here, before it is sent to the render threads, which apply it later: the answer is "accepted". Of
// a scene that is not resident nobody knows how many lights it has.
Page Operations::change_light(const std::string& asked, const std::string& light, const std::string& body) {
  const std::string known = parts_.catalog.get()->find(asked);
  const std::string& name = known.empty() ? asked : known;  // a reload may have taken its name
  const auto resident = parts_.scenes.resident();
  const auto scene = resident.find(name);
  const bool is_resident = scene != resident.end();
  if (!is_resident && known.empty()) return {404, kText, "the configuration has no such scene\n"};
  const size_t most = is_resident ? scene->second.lights.lights.size() : ChangedLights::kMostNumber + 1;
  const size_t index = light.size() > 4 ? most : std::stoul(light);
  if (index >= most)
    return {404, kText, "lights of the scene are numbered from 0 to " + std::to_string(most - 1) + " at most\n"};
  const auto asked_for = parse_dated_change(body);
  if (!asked_for) return {400, kText, asked_for.error().message + "\n"};
  if (is_resident) {
    const auto& now = scene->second.lights.lights[index];
    const auto changed = changed_light(now, scene->second.loaded.scene->lights[index], asked_for->change);
    if (!changed) return {409, kText, changed.error().message + "\n"};
  }
  const auto done = parts_.lights.change(name, static_cast<uint32_t>(index), asked_for->change, asked_for->at_ms);
  if (!done) return {409, kText, done.error().message + "\n"};
  std::string said = is_resident ? "accepted" : "accepted, for when the scene is loaded";
  if (*done) said += "; not kept for the next start: " + (*done)->message;
  return {202, kText, said + "\n"};
}

Page Operations::take_lights(const std::string& body) {
  const auto others = ChangedLights::parse(body);
  if (!others) return {400, kText, others.error().message + "\n"};
  return {200, kText, "changed lights that were not known: " + std::to_string(parts_.lights.take(*others)) + "\n"};
}

Page Operations::kick(const std::string& session, const std::string& body) {
  SessionId id;
  const auto read = std::from_chars(session.data(), session.data() + session.size(), id.value);
  const json asked = json::parse(body, nullptr, false);
  if (read.ec != std::errc()) return {404, kText, "no such session\n"};
  if (!asked.is_object()) return {400, kText, "the body must be a JSON object\n"};
  const auto why = asked.find("why");
  if (why != asked.end() && (!why->is_string() || why->get_ref<const std::string&>().size() > kMaxWhy)) {
    return {400, kText, "why: allowed is a text of up to " + std::to_string(kMaxWhy) + " bytes\n"};
  }
  const auto stay_out_s = whole_number(asked, "for_s", kUsualStayOutS, kLongestStayOutS);
  if (!stay_out_s) {
    return {400, kText,
            "for_s: allowed is a whole number of seconds from 0 to " + std::to_string(kLongestStayOutS) + "\n"};
  }
  const Kick kick{why == asked.end() ? "closed by the operator" : why->get<std::string>(),
                  std::chrono::seconds(*stay_out_s)};
  if (!parts_.server.kick(id, kick)) return {404, kText, "no such session\n"};
  if (*stay_out_s == 0) return {200, kText, "closed; its client may come back\n"};
  return {200, kText, "closed; its client stays out for " + std::to_string(*stay_out_s) + " s\n"};
}

Page Operations::drain_device(const std::string& number, bool drained) {
  size_t device = parts_.devices.size();
  std::from_chars(number.data(), number.data() + number.size(), device);
  switch (parts_.devices.set_drained(device, drained)) {
    case DevicePool::DrainAnswer::no_such_device: return {404, kText, "no such device\n"};
    case DevicePool::DrainAnswer::last_in_service:
      return {409, kText,
              "no other device takes sessions, so that nobody would be served; `gnomonctl drain` admits nobody and "
              "serves on\n"};
    case DevicePool::DrainAnswer::done: break;
  }
  return {200, kText, drained ? "drained\n" : "takes sessions\n"};
}

Page Operations::set_draining(bool draining) {
  if (parts_.health.stopping) return {409, kText, "the server is stopping, which cannot be taken back\n"};
  if (parts_.health.draining.exchange(draining) != draining) {
    log::info(draining ? "nobody is admitted any more" : "clients are admitted again",
              {{"sessions", parts_.server.sessions().size()}});
    parts_.server.ask_to_move(draining);
  }
  return {200, kText,
          draining
              ? "draining: nobody is admitted, who is here is served on, and clients of a fleet are asked to move; "
                "undrain takes it back\n"
              : "clients are admitted\n"};
}

Page Operations::begin_stop() {
  if (!parts_.begin_stop) return {501, kText, "this daemon cannot be stopped from here\n"};
  parts_.health.stopping = true;  // at once, as the main thread may be busy
  parts_.begin_stop();
  return {202, kText, "stopping\n"};
}

Page Operations::readiness() const {
  const std::string why = why_not_ready(parts_);
  return why.empty() ? Page{200, kText, "ready\n"} : Page{503, kText, "not ready: " + why + "\n"};
}

// A daemon that is stopping may never fulfil `done`.
Page Operations::await(std::future<Result<std::string>> done) {
  while (done.wait_for(50ms) != std::future_status::ready) {
    if (parts_.health.stopping) return {503, kText, "the server is stopping\n"};
  }
  const auto result = done.get();
  return result ? Page{200, kText, *result + "\n"} : Page{409, kText, result.error().message + "\n"};
}

// One scene at a time, as each request occupies one of the server's few threads until the scene is resident.
Page Operations::load_scene(const std::string& asked) {
  const std::string name = parts_.catalog.get()->find(asked);
  if (name.empty()) return {404, kText, "the configuration has no such scene\n"};
  if (loading_.exchange(true)) return {409, kText, "another scene is being loaded\n"};
  const std::shared_ptr<void> loaded(nullptr, [this](void*) { loading_ = false; });  // also if memory runs out
  auto done = std::make_shared<std::promise<Result<std::string>>>();
  parts_.scenes.fetch(name, [done](Result<SceneForUse> scene) {
    done->set_value(scene ? Result<std::string>("loaded") : scene.error());
  });
  return await(done->get_future());
}

Page Operations::unload_scene(const std::string& asked) {
  const std::string known = parts_.catalog.get()->find(asked);
  const auto gone = parts_.scenes.unload(known.empty() ? asked : known);  // a reload may have taken its name
  return gone ? Page{200, kText, "unloaded\n"} : Page{409, kText, gone.error().message + "\n"};
}

// The main thread reads and applies the configuration; this thread waits for the result.
Page Operations::reload_page() {
  if (!parts_.ask_for_reload) return {501, kText, "this daemon has no configuration file\n"};
  auto done = std::make_shared<std::promise<Result<std::string>>>();
  parts_.ask_for_reload([done](const Result<std::vector<std::string>>& changes) {
    done->set_value(changes ? Result<std::string>(words_about(*changes)) : changes.error());
  });
  return await(done->get_future());
}

Admin::Actions Operations::actions() {
  using Groups = std::vector<std::string>;
  using Body = std::string;
  return {
      {"/sessions/([0-9]+)/kick", {"kick", [this](const Groups& g, const Body& body) { return kick(g[0], body); }}},
      {"/devices/([0-9]+)/drain",
       {"drain device", [this](const Groups& g, const Body&) { return drain_device(g[0], true); }}},
      {"/devices/([0-9]+)/resume",
       {"resume device", [this](const Groups& g, const Body&) { return drain_device(g[0], false); }}},
      {"/reload", {"reload", [this](const Groups&, const Body&) { return reload_page(); }}},
      {"/drain", {"drain", [this](const Groups&, const Body&) { return set_draining(true); }}},
      {"/undrain", {"undrain", [this](const Groups&, const Body&) { return set_draining(false); }}},
      {"/stop", {"stop", [this](const Groups&, const Body&) { return begin_stop(); }}},
      {"/scenes/(.+)/load", {"load scene", [this](const Groups& g, const Body&) { return load_scene(g[0]); }}},
      {"/scenes/(.+)/unload",
       {"unload scene", [this](const Groups& g, const Body&) { return unload_scene(g[0]); }}},
      {"/scenes/(.+)/lights/([0-9]+)",
       {"change light", [this](const Groups& g, const Body& body) { return change_light(g[0], g[1], body); }}},
      {"/lights", {"take changed lights", [this](const Groups&, const Body& body) { return take_lights(body); }}},
  };
}

Admin::Pages Operations::pages() {
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
         return parts_.health.hangs(Clock::now()) ? Page{503, kText, "a render thread hangs\n"}
                                                  : Page{200, kText, "alive\n"};
       }},
      {"/readyz", [this] { return readiness(); }},
      {"/metrics",
       [this] {
         parts_.metrics.operation().ready(parts_.health.ready(), !parts_.health.admits());
         const auto scenes = parts_.scenes.memory();
         const SessionMemory sessions = parts_.limits.memory();
         parts_.metrics.operation().memory({scenes.bytes, scenes.limit_bytes},
                                           {sessions.bytes, sessions.limit_bytes});
         return Page{200, "text/plain; version=0.0.4; charset=utf-8", parts_.metrics.text()};
       }},
      {"/lights",
       [this] {
         return Page{200, "application/json", parts_.lights.text()};
       }},
      {"/status",
       [this] {
         return Page{200, "application/json", status_json(parts_)};
       }},
  };
}

}  // namespace gnomon::daemon
