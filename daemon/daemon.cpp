#include "daemon/daemon.h"

#include "daemon/scenes/scene_clock.h"
#include "daemon/scenes/scene_fetches.h"
#include "daemon/service/supervisor.h"
#include "daemon/session/credentials.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr size_t kRecordsPerPermit = 2;         // records that rest have no permit
constexpr const char* kStoreName = "sessions";  // in the service manager's file descriptor store

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items) {
  std::vector<std::string> names;
  for (const T& item : items) names.push_back(item.name);
  return names;
}

SceneFetches fetch_scenes(const std::vector<SceneFile>& scenes, SceneHost& host) {
  SceneFetches fetches;
  for (const SceneFile& scene : scenes) fetches.push_back(fetch_later(host, scene.name));
  return fetches;
}

Result<void> wait_for_scenes(const std::vector<SceneFile>& scenes, SceneFetches& fetches) {
  for (size_t i = 0; i < fetches.size(); ++i) {
    if (auto fetched = fetches[i].get(); !fetched) {
      return Error{scenes[i].place + ": scene " + scenes[i].name + ": " + fetched.error().message};
    }
  }
  return {};
}

// `asked`: the number of threads; 0: as many as suit the machine.
std::unique_ptr<EncodePool> open_encoders(uint32_t asked, const std::vector<PooledDevice>& devices,
                                          Metrics& metrics, FrameSink& sink) {
  const Cores usable = usable_cores();
  std::vector<Cores> near;
  for (const PooledDevice& device : devices) near.push_back(cores_near(device.pci_address, usable));
  const uint32_t threads = asked > 0 ? asked : default_encode_threads(usable);
  log::info("encoders open",
            {{"threads", threads}, {"cores", usable.size()}, {"cores_near_device_0", near.front().size()}});
  return std::make_unique<EncodePool>(threads, std::move(near), metrics, sink);
}

// The sessions that the process before has left, if the service manager kept them.
Result<std::unique_ptr<SessionStore>> open_store(const ServerConfig& server) {
  auto store = SessionStore::open(kRecordsPerPermit * server.max_sessions, server.silence_timeout,
                                  supervisor::take_memory(kStoreName));
  if (!store) return store;
  if (!(*store)->taken_over()) supervisor::keep_memory(kStoreName, (*store)->descriptor());
  if ((*store)->resting() > 0) log::info("sessions may be resumed", {{"count", (*store)->resting()}});
  return store;
}

// The tenants of a new configuration; those that would let everybody in from elsewhere are closed, unless the
// configuration allows it.
std::vector<TenantConfig> closed_to_strangers(const ServerConfig& server, std::vector<TenantConfig> tenants,
                                              std::vector<Error>& kept) {
  const auto safe = check_access(server, tenants);
  if (safe) return tenants;
  kept.push_back(safe.error());
  for (TenantConfig& tenant : tenants) tenant.open = false;
  return tenants;
}

// Each with its place in the configuration, and once.
void keep_once(std::vector<Error>& errors, const Config& config) {
  std::vector<Error> once;
  for (const Error& error : errors) {
    const Error full = placed(config, error);
    const auto same = [&](const Error& other) { return other.message == full.message; };
    if (std::none_of(once.begin(), once.end(), same)) once.push_back(full);
  }
  errors = std::move(once);
}

// A reload that cannot be applied as a whole. What of it was applied follows in lines of its own.
Error in_part(const std::string& why, const std::vector<std::string>& changes) {
  std::string text = "reloaded, but for this: " + why;
  for (const std::string& change : changes) text += "\n" + change;
  return Error{std::move(text)};
}

// Listed scenes that are new or changed are read once before anything is taken away for them: one that cannot be read
// stays as it was. Where its file is missing, that was said already.
void keep_unreadable(const Config& next, SceneCatalog& read, const SceneCatalog& before,
                     const scenes::SceneReader& read_scene, std::vector<Error>& kept) {
  for (const SceneFile& scene : next.scenes.list) {
    const scenes::SceneSource* const old = before.source(scene.name);
    const scenes::SceneSource& now = *read.source(scene.name);
    if (old && *old == now) continue;
    std::error_code none;
    if (std::filesystem::exists(now.file, none)) {
      const auto scene_read = read_scene(now, {}, {});
      const bool dark = scene_read && (*scene_read)->lights.empty();
      if (scene_read && !dark) continue;
      kept.push_back(Error{"scenes.list." + scene.name + ": scene " + scene.name + ": " +
                           (dark ? kNoLights : scene_read.error().message) + (old ? "; it stays as it was" : "")});
    }
    if (old) read.keep(scene.name, before);
  }
}

// Scenes that are new or changed are brought at once, as at the start.
void change_scenes(const Config& next, Published<SceneCatalog>& catalog, SceneHost& scenes, Metrics& metrics,
                   const scenes::SceneReader& read_scene, std::vector<Error>& kept) {
  auto read = SceneCatalog::read(next.scenes);
  if (!read) return kept.push_back(read.error());
  if (!read->left_out().empty()) kept.push_back(Error{read->left_out()});
  const auto before = catalog.get();
  keep_unreadable(next, *read, *before, read_scene, kept);
  for (const std::string& name : scenes.change_sources(*read, *before)) {
    kept.push_back(Error{"scenes.list." + name + ": scene " + name +
                         " is in use and stays as it was; gnomonctl scene unload " + name + ", then reload"});
  }
  metrics.scenes().add(names_of(next.scenes.list));
  std::vector<std::string> wanted;
  for (const SceneFile& scene : next.scenes.list) {
    const scenes::SceneSource* const old = before->source(scene.name);
    if (!old || *old != *read->source(scene.name)) wanted.push_back(scene.name);
  }
  catalog.publish(std::move(*read));
  for (const std::string& name : wanted) {
    scenes.fetch(name, [name](const Result<SceneForUse>& scene) {
      if (!scene)
        log::error("a scene of the new configuration did not load",
                   {{"scene", name}, {"why", scene.error().message}});
    });
  }
}

// The tenants by id after the reload. Where there is no room for new ones, those that are known still change, so that
// what is revoked is revoked.
TenantDirectory next_tenants(const TenantDirectory& now, std::vector<TenantConfig> tenants,
                             std::vector<Error>& kept) {
  TenantDirectory next = now.with(tenants);
  if (next.size() <= kMostTenants) return next;
  kept.push_back(Error{"tenants: more than " + std::to_string(kMostTenants) + " different ones since the start"});
  const std::vector<std::string> known = names_of(now.configs());
  std::erase_if(tenants, [&](const TenantConfig& tenant) {
    return std::find(known.begin(), known.end(), tenant.name) == known.end();
  });
  return now.with(tenants);
}

}  // namespace

Daemon::Daemon(Options options, SceneCatalog catalog)
    : options_(std::move(options)),
      metrics_(names_of(options_.config.tenants), names_of(options_.config.scenes.list), options_.version,
               options_.make_renderers.size()),
      session_limits_(options_.config, options_.make_renderers.size()),
      devices_(options_.make_renderers.size(), options_.config.fleet.assumed_rate_hz, metrics_, health_),
      certificates_(metrics_),
      reload_audit_(options_.config) {
  catalog_.publish(std::move(catalog));
}

Daemon::~Daemon() { stop(); }

Result<std::unique_ptr<Daemon>> Daemon::start(Options options) {
  auto catalog = SceneCatalog::read(options.config.scenes);
  if (!catalog) return catalog.error();
  if (!catalog->left_out().empty()) log::warning("scenes are left out", {{"why", catalog->left_out()}});
  std::unique_ptr<Daemon> made(new Daemon(std::move(options), std::move(*catalog)));
  if (auto up = made->bring_up(); !up) return up.error();
  return made;
}

// Ports are opened first, as they fail at once, while a scene may take seconds. Clients are heard from then on, so that
// they learn what they wait for; they are admitted once the devices are open and their scene is there.
Result<void> Daemon::bring_up() {
  sharing_policy_.publish(sharing_policy_of(options_.config));
  tenant_directory_.publish(TenantDirectory().with(options_.config.tenants));
  if (const auto why = strangers_access(options_.config.server, options_.config.tenants); !why.empty()) {
    log::warning("strangers are served", {{"why", why}});
  }
  if (auto opened = certificates_.open(options_.config.server, options_.config.web.listen); !opened) return opened;
  if (auto reachable = check_tenants(options_.config); !reachable) return reachable;
  auto changed_lights = ChangedLights::read(options_.config.scenes.lights_file);
  if (!changed_lights) return Error{"scenes.lights_file: " + changed_lights.error().message};
  lights_ = std::make_unique<SceneLights>(devices_, std::move(*changed_lights), options_.config.scenes.lights_file);
  scenes_ = std::make_unique<SceneHost>(
      *catalog_.get(), devices_, *lights_, metrics_, options_.read_scene,
      SceneMemory{scene_memory_limits(options_.config), uint64_t{options_.config.render.light_buffer_mb} << 20});
  auto store = open_store(options_.config.server);
  if (!store) return store.error();
  store_ = std::move(*store);
  if (options_.config.web.listen) {
    web_ = std::make_unique<WebService>(options_.config.web, options_.config.fleet);
    packs_ = std::make_unique<ScenePacks>(*scenes_);
  }
  auto server = Server::open({.config = options_.config,
                              .tenants = tenant_directory_,
                              .tracer = tracer_,
                              .catalog = catalog_,
                              .health = health_,
                              .tls = certificates_.published(),
                              .scenes = *scenes_,
                              .limits = session_limits_,
                              .kept_out = kept_out_,
                              .store = *store_,
                              .devices = devices_,
                              .metrics = metrics_,
                              .web = web_.get(),
                              .packs = packs_.get()});
  if (!server) return server.error();
  server_ = std::move(*server);
  if (auto opened = open_admin(); !opened) return opened;
  server_->run();
  if (auto opened = open_devices(); !opened) return opened;
  const std::vector<SceneFile>& list = options_.config.scenes.list;
  SceneFetches fetches = fetch_scenes(list, *scenes_);  // before those that clients ask for
  health_.serving = true;
  if (auto loaded = wait_for_scenes(list, fetches); !loaded) return loaded;
  health_.scenes_loaded = true;
  return {};
}

Result<void> Daemon::open_admin() {
  operations_ = std::make_unique<Operations>(OperatedParts{.version = options_.version,
                                                           .catalog = catalog_,
                                                           .health = health_,
                                                           .metrics = metrics_,
                                                           .tenants = tenant_directory_,
                                                           .sharing = sharing_policy_,
                                                           .tls = certificates_.published(),
                                                           .devices = devices_,
                                                           .scenes = *scenes_,
                                                           .lights = *lights_,
                                                           .limits = session_limits_,
                                                           .server = *server_,
                                                           .begin_stop = options_.on_stop,
                                                           .ask_for_reload = options_.ask_for_reload});
  auto admin = Admin::start(options_.config.admin, operations_->pages(), operations_->actions(), metrics_);
  if (!admin) return admin.error();
  admin_ = std::move(*admin);
  log::info("admin server open", {{"port", admin_->port()}, {"socket", admin_->socket().string()}});
  return {};
}

Result<void> Daemon::open_devices() {
  const ScenesConfig& scenes = options_.config.scenes;
  const SceneMotion::Settings motion{
      scenes.clock_hz, scenes.light_rest,
      scene_clock_start(options_.config, Clock::now(), std::chrono::system_clock::now())};
  const auto failed = [this](const Error& why) {
    if (options_.on_failure) options_.on_failure(why);
  };
  auto started = devices_.start(options_.make_renderers, sharing_policy_of(options_.config), motion, *this, failed);
  if (!started) return started;
  const PooledDevice first = devices_.report().front();
  tracer_ = first.tracer + " on " + first.name;
  // After the devices are open, as the pool needs their PCI addresses, and before the first session.
  encode_pool_ =
      open_encoders(options_.config.encode.threads, devices_.report(), metrics_, static_cast<FrameSink&>(*this));
  return {};
}

void Daemon::on_rendered(RenderedFrame frame) { encode_pool_->push(std::move(frame)); }

void Daemon::on_encoded(EncodedFrame frame) { server_->deliver(std::move(frame)); }

void Daemon::on_degraded(const SessionDegraded& session) { server_->notify(session); }

void Daemon::on_lights(const LightsUpdate& lights) {
  scenes_->keep_lights(lights);
  server_->announce_lights(lights);
}

std::string Daemon::summary() const {
  return "serving " + std::to_string(scenes_->resident().size()) + " scenes to " +
         std::to_string(session_limits_.taken()) + " sessions";
}

Result<std::vector<std::string>> Daemon::reload(const Result<Config>& next, const char* asked_by,
                                                std::vector<Error> missing) {
  if (!next) {
    metrics_.operation().reloaded(false);
    log::error("configuration not reloaded", {{"why", next.error().message}});
    reload_audit_.refused(next.error().message, asked_by);
    return next.error();
  }
  const protocol::Pin old_pin = pin();
  apply(*next, missing);
  keep_once(missing, *next);
  metrics_.operation().reloaded(missing.empty());
  ReloadAudit::Kept kept{restart_keys(*next, options_.config), {}};
  for (const Error& each : missing) kept.why += (kept.why.empty() ? "" : "; ") + each.message;
  auto changes = reload_audit_.applied(*next, kept, old_pin, pin(), asked_by);
  if (missing.empty()) return changes;
  log::error("configuration reloaded in part", {{"why", kept.why}});
  return in_part(kept.why, changes);
}

void Daemon::apply(const Config& next, std::vector<Error>& kept) {
  for (const std::string& key : restart_keys(next, options_.config)) {
    kept.push_back(Error{key + ": changed, which takes a restart; as it was until then"});
  }
  if (auto reachable = check_tenants(next); !reachable) kept.push_back(reachable.error());
  // As it runs: another address or mode needs a restart, so that what `next` says of them does not hold yet.
  ServerConfig server = options_.config.server;
  server.tls = next.server.tls;
  server.insecure_listen = next.server.insecure_listen;
  for (const Error& each : certificates_.reopen(server)) kept.push_back(each);
  AdminConfig admin = options_.config.admin;
  admin.token_file = next.admin.token_file;
  admin.tls = next.admin.tls;
  if (const auto secrets = read_admin_secrets(admin)) {
    admin_->set_secrets(*secrets);
  } else {
    kept.push_back(secrets.error());
  }
  log::configure(next.log.level, next.log.format);
  if (auto opened = log::set_audit_file(next.log.audit_file); !opened) {
    kept.push_back(Error{"log.audit_file: " + opened.error().message});
  }
  const TenantDirectory directory =
      next_tenants(*tenant_directory_.get(), closed_to_strangers(server, next.tenants, kept), kept);
  Config by_id = next;
  by_id.tenants = directory.configs();
  const SharingPolicy sharing = sharing_policy_of(by_id);
  sharing_policy_.publish(sharing);
  session_limits_.set_limits(next, directory);
  scenes_->set_memory_limits(scene_memory_limits(by_id));
  metrics_.add_tenants(names_of(by_id.tenants));
  if (options_.on_reload) options_.on_reload(next);
  change_scenes(next, catalog_, *scenes_, metrics_, options_.read_scene, kept);
  devices_.set_sharing(sharing);
  tenant_directory_.publish(directory);  // last: a published tenant already has its limits, metrics and terms
  server_->close_unwelcome();
  log::info("configuration reloaded", {{"policy", sharing.policy}, {"pin", protocol::to_string(pin())}});
}

void Daemon::drain() {
  health_.stopping = true;
  const auto timeout = options_.config.server.drain_timeout;
  log::info("stopping", {{"sessions", session_limits_.taken()}, {"deadline_ms", timeout.count()}});
  server_->announce_drain(timeout);
  const TimePoint deadline = Clock::now() + timeout;
  while (session_limits_.taken() > 0 && Clock::now() < deadline) std::this_thread::sleep_for(5ms);
  stop();
  store_->forget_resting();
}

// No client is refused meanwhile: the acceptor is closed first, and clients reconnect until the next process answers.
void Daemon::give_up() {
  server_->leave();
  stop();
}

// The order of the flow: no more views, then the frames on the devices, in the pool and on the wire; then the rest.
void Daemon::stop() {
  health_.stopping = true;
  if (scenes_) scenes_->stop_reading();
  devices_.stop();
  encode_pool_.reset();
  if (server_) server_->stop();
  if (store_) store_->close();
  admin_.reset();
  packs_.reset();
  if (scenes_) scenes_->stop();  // the watchdog's thread may still ask for the summary
}

}  // namespace gnomon::daemon
