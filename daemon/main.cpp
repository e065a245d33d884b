// gnomond: reads the configuration, starts the daemon, stops it on a signal.
#include <CLI/CLI.hpp>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <thread>

#include "daemon/daemon.h"
#include "daemon/render/vulkan_renderers.h"
#include "daemon/service/supervisor.h"
#include "daemon/service/watchdog.h"
#include "gpu/vulkan_renderer.h"
#include "scenes/loader.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto kStopTime = 1500ms;  // beyond server.drain_timeout_ms, for frames in flight and the last messages

struct Arguments {
  std::filesystem::path config;
  std::vector<std::string> overrides;
  std::filesystem::path check_scene;
  bool check_config = false;
};

int fail(const Error& error) {
  std::fprintf(stderr, "gnomond: %s\n", error.message.c_str());
  return EXIT_FAILURE;
}

// Build trees and installed trees have the same layout: bin/gnomond, libexec/gnomon and share/gnomon/scenes.
std::filesystem::path installed(const char* below) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / below;
}

int check_scene(const std::filesystem::path& file) {
  const auto scene = scenes::load_scene(file);
  if (!scene) return fail(scene.error());
  std::printf("triangles %llu\ninstances %zu\nlights %zu\nhash %s\n",
              static_cast<unsigned long long>((*scene)->triangle_count), (*scene)->instances.size(),
              (*scene)->lights.size(), scenes::to_hex((*scene)->content_hash).c_str());
  return EXIT_SUCCESS;
}

Result<Config> load_config(const Arguments& arguments) {
  auto config = read_config(arguments.config, arguments.overrides);
  if (!config) return config;
  const auto folder = std::filesystem::absolute(arguments.config).parent_path();
  if (auto found = find_files(*config, folder, installed("share/gnomon/scenes")); !found) return found.error();
  if (config->render.passes.empty()) config->render.passes = gpu::RendererOptions{}.passes;
  return config;
}

// The address as it is written before a colon and a port: IPv6 in brackets.
std::string bracketed(const std::string& address) {
  const bool v6 = address.find(':') != std::string::npos;
  return v6 ? std::string("[").append(address).append("]") : address;
}

void print_ready_line(const Daemon& daemon, const Config& config) {
  std::string data;
  for (const uint16_t port : daemon.data_ports()) data += (data.empty() ? "" : ",") + std::to_string(port);
  const Admin& admin = daemon.admin();
  const std::string socket = admin.socket().empty() ? "" : " socket=" + admin.socket().string();
  std::printf("gnomond ready control=%s:%u data=%s admin=%s://%s:%u pin=%s%s\n",
              bracketed(config.server.listen).c_str(), daemon.control_port(), data.c_str(),
              is_loopback(config.admin) ? "http" : "https", bracketed(config.admin.listen).c_str(), admin.port(),
              protocol::to_string(daemon.pin()).c_str(), socket.c_str());
  std::fflush(stdout);
}

// Ends the process at the deadline, even if a device or a disk hangs.
void leave_at(TimePoint deadline) {
  std::thread([deadline] {
    std::this_thread::sleep_until(deadline);
    log::warning("not stopped in time: leaving frames behind");
    std::_Exit(EXIT_SUCCESS);
  }).detach();
}

// Reads the file and the command line's overrides again. An error in them leaves the configuration unchanged.
Result<void> reload(Daemon& daemon, const Arguments& arguments, const char* asked_by) {
  supervisor::reloading();
  auto done = daemon.reload(load_config(arguments), asked_by);
  if (!done) log::error("configuration not reloaded", {{"why", done.error().message}});
  supervisor::ready(done ? daemon.summary() : "configuration not reloaded: " + done.error().message);
  return done;
}

// Reloads the configuration at each SIGHUP.
void reload_on_hangup(asio::signal_set& hangup, Daemon& daemon, const Arguments& arguments) {
  hangup.async_wait([&hangup, &daemon, &arguments](asio::error_code error, int) {
    if (error) return;
    (void)reload(daemon, arguments, "SIGHUP");  // it logs its errors
    reload_on_hangup(hangup, daemon, arguments);
  });
}

int serve(const Config& config, const Arguments& arguments) {
  asio::io_context events;
  std::optional<Error> failure;
  const auto failed = [&](const Error& error) {
    asio::post(events, [&, error] {
      failure = error;
      events.stop();
    });
  };
  const auto drain = [&] { asio::post(events, [&] { events.stop(); }); };
  Daemon* running = nullptr;  // set before the events run
  const auto ask_for_reload = [&](std::function<void(Result<void>)> answer) {
    asio::post(events, [&, answer] { answer(reload(*running, arguments, "operator")); });
  };
  auto daemon = Daemon::start({config, vulkan_renderers(config), GNOMON_VERSION, drain, failed, ask_for_reload,
                               installed("libexec/gnomon/gnomon-scene-worker")});
  if (!daemon) return fail(daemon.error());
  running = daemon->get();
  asio::signal_set signals(events, SIGTERM, SIGINT);  // a signal before this, while scenes load, ends the process
  signals.async_wait([&](asio::error_code, int) { events.stop(); });
  asio::signal_set hangup(events, SIGHUP);
  reload_on_hangup(hangup, **daemon, arguments);
  if (const int left = supervisor::close_untaken(); left > 0) {
    log::warning("sockets were opened for us that the configuration does not use", {{"count", left}});
  }
  print_ready_line(**daemon, config);
  supervisor::ready((*daemon)->summary());
  std::optional<Watchdog> watchdog(
      std::in_place, (*daemon)->heartbeats(), [&](TimePoint now) { (*daemon)->alive(now); },
      [&] { return (*daemon)->summary(); });
  events.run();  // until the first signal or a failure
  std::signal(SIGTERM, [](int) { std::_Exit(EXIT_FAILURE); });
  std::signal(SIGINT, [](int) { std::_Exit(EXIT_FAILURE); });
  supervisor::stopping();
  if (failure) {
    (*daemon)->give_up();
    return fail(*failure);
  }
  leave_at(Clock::now() + config.server.drain_timeout + kStopTime);
  (*daemon)->drain();
  watchdog.reset();
  daemon->reset();
  log::info("stopped");
  return EXIT_SUCCESS;
}

int run(const Arguments& arguments) {
  if (!arguments.check_scene.empty()) return check_scene(arguments.check_scene);
  const auto config = load_config(arguments);
  if (!config) return fail(config.error());
  if (arguments.check_config) {
    std::printf("%s: ok\n", arguments.config.c_str());
    return EXIT_SUCCESS;
  }
  log::configure(config->log.level, config->log.format);
  if (auto opened = log::set_audit_file(config->log.audit_file); !opened) {
    return fail(Error{"log.audit_file: " + opened.error().message});
  }
  return serve(*config, arguments);
}

}  // namespace
}  // namespace gnomon::daemon

int main(int argc, char** argv) {
  gnomon::daemon::Arguments arguments;
  CLI::App app{"Traces light visibility for many thin clients on one GPU."};
  auto* config = app.add_option("--config", arguments.config, "The configuration, see config/gnomond.yaml");
  app.add_option("--set", arguments.overrides, "key.path=value: overrides the file; may be repeated")
      ->allow_extra_args(false)
      ->needs(config);
  app.add_flag("--check-config", arguments.check_config, "Check the configuration and leave")->needs(config);
  auto* scene =
      app.add_option("--check-scene", arguments.check_scene, "Check a glTF file and leave")->excludes(config);
  app.set_version_flag("--version", "gnomond " GNOMON_VERSION);
  CLI11_PARSE(app, argc, argv);
  if (config->count() + scene->count() == 0) {
    std::fprintf(stderr, "gnomond: --config FILE is needed; config/gnomond.yaml shows every key\n");
    return EXIT_FAILURE;
  }
  return gnomon::daemon::run(arguments);
}
