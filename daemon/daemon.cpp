#include "daemon/daemon.h"

#include "daemon/credentials.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto kSharesInterval = 1s;
constexpr auto kLongestBuild = 5min;  // of all that a tracer needs for one scene, on a slow device

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items) {
  std::vector<std::string> names;
  for (const T& item : items) names.push_back(item.name);
  return names;
}

}  // namespace

Daemon::Daemon(Options options, SceneCatalog catalog)
    : options_(std::move(options)),
      catalog_(std::move(catalog)),
      metrics_(names_of(options_.config.tenants), names_of(options_.config.scenes.list), options_.version),
      seats_(options_.config) {}

Daemon::~Daemon() { stop(); }

Result<std::unique_ptr<Daemon>> Daemon::start(Options options) {
  auto catalog = SceneCatalog::read(options.config.scenes);
  if (!catalog) return catalog.error();
  std::unique_ptr<Daemon> made(new Daemon(std::move(options), std::move(*catalog)));
  if (auto up = made->bring_up(); !up) return up.error();
  return made;
}

// Ports first: they fail at once, a scene may take seconds. Clients are taken when everything is there.
Result<void> Daemon::bring_up() {
  terms_.publish(terms_of(options_.config));
  roster_.publish(Roster().with(options_.config.tenants));
  auto tls = open_tls(options_.config.server);
  if (!tls) return tls.error();
  if (auto reachable = check_tenants(options_.config); !reachable) return reachable;
  tls_ = std::move(*tls);
  scenes_ = std::make_unique<SceneHost>(catalog_, inbox_, metrics_);
  auto server = Server::open(
      {options_.config, roster_, tracer_, catalog_, health_, *tls_, *scenes_, seats_, costs_, inbox_, metrics_});
  if (!server) return server.error();
  server_ = std::move(*server);
  auto admin = Admin::start(options_.config.admin, pages(), actions());
  if (!admin) return admin.error();
  admin_ = std::move(*admin);
  if (auto opened = open_device(); !opened) return opened;
  if (auto loaded = load_scenes(); !loaded) return loaded;
  server_->run();
  health_.scenes_loaded = true;
  return {};
}

Result<void> Daemon::open_device() {
  auto device = RenderDevice::open(options_.make_renderer);
  if (!device) return device.error();
  device_ = std::move(*device);
  const gpu::Renderer& renderer = device_->renderer();
  tracer_ = renderer.tracer_name();
  log::info("device open",
            {{"device", renderer.device_name()}, {"driver", renderer.driver_name()}, {"tracer", tracer_}});
  device_status_.publish({renderer.device_name(), renderer.driver_name(), tracer_});
  encode_pool_ = std::make_unique<EncodePool>(options_.config.encode.threads, metrics_,
                                              [this](EncodedFrame frame) { server_->deliver(std::move(frame)); });
  loop_ = std::make_unique<RenderLoop>(
      terms_of(options_.config), *device_, inbox_, metrics_,
      [this](RenderedFrame frame) { encode_pool_->push(std::move(frame)); },
      [this](const SessionDegraded& session) { server_->tell(session); });
  const ScenesConfig& scenes = options_.config.scenes;
  loop_->motion().configure({scenes.clock_hz, scenes.light_rest, Clock::now(), [this](const LightsNews& news) {
                               scenes_->keep_lights(news);
                               server_->announce_lights(news);
                             }});
  render_thread_ = std::thread([this] { render(); });
  return {};
}

Result<void> Daemon::load_scenes() {
  for (const SceneFile& scene : options_.config.scenes.list) {
    if (auto fetched = scenes_->fetch_now(scene.name); !fetched) {
      return Error{scene.place + ": scene " + scene.name + ": " + fetched.error().message};
    }
  }
  return {};
}

void Daemon::render() {
  std::vector<RenderEvent> batch;
  while (true) {
    show_life(batch);
    loop_->start(Clock::now());
    health_.device_up = loop_->device_up();
    if (loop_->finished()) break;
    publish_shares(Clock::now());
    inbox_.take(batch, std::min(next_shares_, loop_->wake_at()));
    for (RenderEvent& event : batch) {
      if (std::holds_alternative<SceneArrived>(event)) heartbeat_.excuse_until(Clock::now() + kLongestBuild);
      loop_->handle(std::move(event), Clock::now());
    }
  }
  heartbeat_.end();
  if (loop_->failure() && options_.on_failure) options_.on_failure(*loop_->failure());
}

// With frames out, life is that one of them comes to its end. A device that is made anew takes as long as a scene.
void Daemon::show_life(const std::vector<RenderEvent>& done) {
  const bool moved = std::any_of(done.begin(), done.end(), [](const RenderEvent& event) {
    return std::holds_alternative<JobFinished>(event) || std::holds_alternative<LeaseDropped>(event) ||
           std::holds_alternative<SceneArrived>(event);
  });
  if (moved || loop_->frames_out() == 0) heartbeat_.beat();
  if (!loop_->device_up()) heartbeat_.excuse_until(Clock::now() + kLongestBuild);
}

std::string Daemon::summary() const {
  return "serving " + std::to_string(scenes_->resident().size()) + " scenes to " + std::to_string(seats_.taken()) +
         " sessions";
}

Result<void> Daemon::reload(const Result<Config>& next) {
  const auto done = next ? apply(*next) : Result<void>(next.error());
  metrics_.reloaded(done.has_value());
  return done;
}

Result<void> Daemon::apply(const Config& next) {
  if (auto reachable = check_tenants(next); !reachable) return reachable;
  const Roster roster = roster_.get()->with(next.tenants);
  if (roster.size() > kMostTenants) {
    return Error{"tenants: more than " + std::to_string(kMostTenants) + " different ones since the start"};
  }
  if (needs_restart(next, options_.config)) log::warning("some of the new configuration needs a restart");
  Config by_id = next;
  by_id.tenants = roster.configs();
  const Terms terms = terms_of(by_id);
  terms_.publish(terms);
  seats_.set_limits(by_id);
  metrics_.know_tenants(names_of(by_id.tenants));
  log::set_level(next.log.level);
  inbox_.push(TermsChanged{terms});
  roster_.publish(roster);  // last: whoever learns of a tenant finds all that it needs
  server_->close_closed_tenants();
  log::info("configuration reloaded", {{"policy", terms.policy}});
  return {};
}

void Daemon::publish_shares(TimePoint now) {
  if (now < next_shares_) return;
  next_shares_ = now + kSharesInterval;
  loop_->review_sessions(kSharesInterval);
  const ShareReport report = loop_->shares();
  metrics_.shares(report);
  shares_.publish(report);
  costs_.publish(loop_->costs());
}

void Daemon::drain() {
  health_.draining = true;
  const auto timeout = options_.config.server.drain_timeout;
  log::info("draining", {{"sessions", seats_.taken()}, {"deadline_ms", timeout.count()}});
  server_->announce_drain(timeout);
  const TimePoint deadline = Clock::now() + timeout;
  while (seats_.taken() > 0 && Clock::now() < deadline) std::this_thread::sleep_for(5ms);
  stop();
}

// The flow's own order: no more views, then the frames on the device, in the pool, on the wire; then the rest.
void Daemon::stop() {
  health_.draining = true;
  inbox_.push(StopRendering{});
  if (render_thread_.joinable()) render_thread_.join();
  encode_pool_.reset();
  if (server_) server_->stop();
  admin_.reset();
  scenes_.reset();
}

}  // namespace gnomon::daemon
