// gnomond: reads the configuration, starts the daemon, stops it on a signal.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

#include "common/log_line.h"
#include "common/wall_clock.h"
#include "common/within_memory.h"
#include "daemon/daemon.h"
#include "daemon/render/vulkan_renderers.h"
#include "daemon/scenes/scene_worker.h"
#include "daemon/service/agones.h"
#include "daemon/service/supervisor.h"
#include "daemon/service/watchdog.h"
#include "daemon/start_check.h"
#include "scenes/loader.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr int kWrongUsage = 2;             // exit status after a command line that cannot be understood
constexpr auto kBetweenReminders = 10min;  // looks at the dates of certificates
constexpr auto kStopTime = 1500ms;  // beyond server.drain_timeout_ms, for frames in flight and the last messages

struct Arguments {
  std::filesystem::path config;
  std::vector<std::string> overrides;
  std::filesystem::path check_scene;
  bool check_config = false;
  bool for_reload = false;
};

int fail(const std::vector<Error>& errors) {
  for (const Error& error : errors) std::fprintf(stderr, "gnomond: %s\n", error.message.c_str());
  return EXIT_FAILURE;
}

int fail(const Error& error) { return fail(std::vector{error}); }

// Build trees and installed trees have the same layout: bin/gnomond, libexec/gnomon and share/gnomon/scenes.
std::filesystem::path installed(const char* below) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / below;
}

// With less, drivers and threads fail in ways that name no reason.
Result<void> check_address_space() {
  constexpr rlim_t kLeast = rlim_t{3} << 29;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= kLeast) return {};
  return Error{"the address space is limited to " + std::to_string(limit.rlim_cur >> 20) + " MiB (ulimit -v); " +
               std::to_string(kLeast >> 20) + " MiB are the least to serve with"};
}

int check_scene(const std::filesystem::path& file) {
  const auto scene = scenes::load_scene(file);
  if (!scene) return fail(scene.error());
  std::printf("triangles %llu\ninstances %zu\nlights %zu\nhash %s\n",
              static_cast<unsigned long long>((*scene)->triangle_count), (*scene)->instances.size(),
              (*scene)->lights.size(), scenes::to_hex((*scene)->content_hash).c_str());
  return EXIT_SUCCESS;
}

enum class Purpose { check, start, reload };

// The configuration with what stands in other files.
struct CheckedConfig {
  Config config;
  std::vector<Error> mistakes;  // in the configuration itself and in token files: it cannot be used
  StartFindings found;          // what it names and what is not as it should be
};

CheckedConfig check_config(const Arguments& arguments, Purpose purpose) {
  ConfigReading reading = examine_config(arguments.config, arguments.overrides);
  StartCheckOptions options{.config_folder = std::filesystem::absolute(arguments.config).parent_path(),
                            .share_folder = installed("share/gnomon/scenes"),
                            .for_reload = purpose == Purpose::reload,
                            .for_start = purpose == Purpose::start};
  const SceneWorkerOptions worker = worker_options(reading.config, installed("libexec/gnomon/gnomon-scene-worker"));
  if (purpose == Purpose::check) options.read_scene = reader_in_worker(worker);  // a start reads them anyway
  options.check_renderers = check_vulkan_renderers;
  StartFindings found = check_start(reading, options);
  return {std::move(reading.config), std::move(reading.errors), std::move(found)};
}

int print_check(const Arguments& arguments) {
  const auto checked = check_config(arguments, arguments.for_reload ? Purpose::reload : Purpose::check);
  for (const std::string& warning : checked.found.warnings) {
    std::fprintf(stderr, "gnomond: warning: %s\n", warning.c_str());
  }
  fail(checked.mistakes);
  fail(checked.found.errors);
  // A reload applies each part that it can, and says what it cannot.
  const bool good = checked.mistakes.empty() && (checked.found.errors.empty() || arguments.for_reload);
  if (!good) return EXIT_FAILURE;
  std::printf("%s: ok\n", arguments.config.c_str());
  return EXIT_SUCCESS;
}

// The address as it is written before a colon and a port: IPv6 in brackets.
std::string bracketed(const std::string& address) {
  const bool v6 = address.find(':') != std::string::npos;
  return v6 ? std::string("[").append(address).append("]") : address;
}

void print_ready_line(const Daemon& daemon, const Config& config) {
  std::string data;
  for (const uint16_t port : daemon.server().data_ports()) data += (data.empty() ? "" : ",") + std::to_string(port);
  const Admin& admin = daemon.admin();
  const std::string control = bracketed(config.server.listen) + ":" + std::to_string(daemon.control_port());
  const std::string pages = std::string(is_loopback(config.admin) ? "http://" : "https://") +
                            bracketed(config.admin.listen) + ":" + std::to_string(admin.port());
  const std::string pin = protocol::to_string(daemon.pin()), socket = admin.socket().string();
  if (config.log.format == log::Format::json) {
    std::fputs(
        log::json_line("gnomond ready",
                       {{"control", control}, {"data", data}, {"admin", pages}, {"pin", pin}, {"socket", socket}})
            .c_str(),
        stdout);
  } else {
    std::printf("gnomond ready control=%s data=%s admin=%s pin=%s%s\n", control.c_str(), data.c_str(),
                pages.c_str(), pin.c_str(), socket.empty() ? "" : (" socket=" + socket).c_str());
  }
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

Error all_of(const std::vector<Error>& errors) {
  std::string all;
  for (const Error& error : errors) all += (all.empty() ? "" : "\n") + error.message;
  return Error{all};
}

// Reads the file and the command line's overrides again.
Result<std::vector<std::string>> reload(Daemon& daemon, const Arguments& arguments, const char* asked_by) {
  supervisor::reloading();
  CheckedConfig checked = check_config(arguments, Purpose::reload);
  const bool usable = checked.mistakes.empty();
  auto done = usable ? daemon.reload(checked.config, asked_by, checked.found.errors)
                     : daemon.reload(all_of(checked.mistakes), asked_by);
  const std::string how = usable ? "configuration " : "configuration not reloaded: ";
  supervisor::ready(done ? daemon.summary() : how + done.error().message);
  return done;
}

// Reloads the configuration at each SIGHUP.
void reload_on_hangup(asio::signal_set& hangup, Daemon& daemon, const Arguments& arguments) {
  hangup.async_wait([&hangup, &daemon, &arguments](asio::error_code error, int) {
    if (error) return;
    done_or_dropped("a reload", [&] { (void)reload(daemon, arguments, "SIGHUP"); });  // it logs its errors
    until_memory_suffices([&] { reload_on_hangup(hangup, daemon, arguments); });
  });
}

// A start takes as long as its scenes. A stop ends it at once, also that of a container's first process, which no signal
// ends that it does not take; a reload is done once it is over.
volatile std::sig_atomic_t hung_up_early = 0;
void take_early_signals() {
  for (const int stop : {SIGTERM, SIGINT}) std::signal(stop, [](int) { std::_Exit(EXIT_SUCCESS); });
  std::signal(SIGHUP, [](int) { hung_up_early = 1; });
}

// Reloads the configuration at each SIGHUP from now on, and at once if one came before.
void take_hangups(asio::signal_set& hangup, Daemon& daemon, const Arguments& arguments) {
  reload_on_hangup(hangup, daemon, arguments);
  if (hung_up_early != 0) std::raise(SIGHUP);
}

void remind_daily(asio::steady_timer& timer, Daemon& daemon) {
  done_or_dropped("a look at certificates", [&] { daemon.remind(wall_now()); });
  until_memory_suffices([&] {
    timer.expires_after(kBetweenReminders);
    timer.async_wait([&timer, &daemon](asio::error_code error) {
      if (!error) remind_daily(timer, daemon);
    });
  });
}

// What is made beside the daemon by the configuration, and goes with it at a reload.
struct Beside {
  explicit Beside(const Config& config)
      : worker(worker_options(config, installed("libexec/gnomon/gnomon-scene-worker"))),
        cache_bytes(std::make_shared<std::atomic<uint64_t>>(cache_bytes_of(config.render))) {}

  std::vector<RendererFactory> renderers(const Config& config) const {
    return vulkan_renderers(config, builds_in_worker(worker), cache_bytes);
  }

  void take(const Config& next) const {
    worker.log->level = next.log.level;
    worker.log->format = next.log.format;
    *cache_bytes = cache_bytes_of(next.render);
  }

  const SceneWorkerOptions worker;
  const std::shared_ptr<std::atomic<uint64_t>> cache_bytes;
};

int serve(const Config& config, const Arguments& arguments) {
  if (const auto enough = check_address_space(); !enough) return fail(enough.error());
  asio::io_context events;
  std::optional<Error> failure;
  const auto failed = [&](const Error& error) {
    asio::post(events, [&, error] {
      failure = error;
      events.stop();
    });
  };
  const auto stop = [&] { asio::post(events, [&] { events.stop(); }); };
  Daemon* running = nullptr;  // set before the events run
  const auto ask_for_reload = [&](std::function<void(Result<std::vector<std::string>>)> answer) {
    asio::post(events,
               [&, answer] { answer(within_memory([&] { return reload(*running, arguments, "operator"); })); });
  };
  const Beside beside(config);
  std::optional<Agones> agones;
  if (config.fleet.agones) agones.emplace(Agones::port_of(std::getenv("AGONES_SDK_HTTP_PORT")));
  auto daemon = Daemon::start({config, beside.renderers(config), GNOMON_VERSION, stop, failed, ask_for_reload,
                               reader_in_worker(beside.worker), [&](const Config& next) { beside.take(next); }});
  if (!daemon) return fail(placed(config, daemon.error()));
  running = daemon->get();
  asio::signal_set signals(events, SIGTERM, SIGINT);
  signals.async_wait([&](asio::error_code, int) { events.stop(); });
  asio::signal_set hangup(events, SIGHUP);
  take_hangups(hangup, **daemon, arguments);
  asio::steady_timer reminders(events);
  remind_daily(reminders, **daemon);
  if (const int left = supervisor::close_untaken(); left > 0) {
    log::warning("sockets were opened for us that the configuration does not use", {{"count", left}});
  }
  print_ready_line(**daemon, config);
  supervisor::ready((*daemon)->summary());
  if (agones) agones->ready();
  std::optional<Watchdog> watchdog(
      std::in_place, (*daemon)->heartbeats(),
      [&](TimePoint now) {
        (*daemon)->alive(now);
        if (agones) agones->alive(now);
      },
      [&] { return (*daemon)->summary(); });
  while (
      !done_or_dropped("an event of the daemon", [&] { events.run(); })) {  // until the first signal or a failure
  }
  std::signal(SIGTERM, [](int) { std::_Exit(EXIT_FAILURE); });
  std::signal(SIGINT, [](int) { std::_Exit(EXIT_FAILURE); });
  supervisor::stopping();
  if (failure) {
    (*daemon)->give_up();
    return fail(*failure);
  }
  leave_at(Clock::now() + config.server.drain_timeout + kStopTime);
  (*daemon)->drain();
  if (agones) agones->leave();
  watchdog.reset();
  daemon->reset();
  log::info("stopped");
  return EXIT_SUCCESS;
}

int run(const Arguments& arguments) {
  if (!arguments.check_scene.empty()) return check_scene(arguments.check_scene);
  if (arguments.check_config) return print_check(arguments);
  take_early_signals();
  log::leave_out_what_nobody_reads();
  const CheckedConfig checked = check_config(arguments, Purpose::start);
  if (!checked.mistakes.empty() || !checked.found.errors.empty()) {
    fail(checked.mistakes);
    return fail(checked.found.errors);
  }
  log::configure(checked.config.log.level, checked.config.log.format);
  if (auto opened = log::set_audit_file(checked.config.log.audit_file); !opened) {
    return fail(placed(checked.config, Error{"log.audit_file: " + opened.error().message}));
  }
  return serve(checked.config, arguments);
}

}  // namespace
}  // namespace gnomon::daemon

int main(int argc, char** argv) {
  gnomon::daemon::Arguments arguments;
  CLI::App app{"Traces light visibility for many thin clients on one GPU."};
  app.option_defaults()->always_capture_default();
  auto* config =
      app.add_option("--config", arguments.config, "The configuration, see gnomond.yaml(5)")->type_name("FILE");
  app.add_option("--set", arguments.overrides, "key.path=value: overrides the file; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->needs(config);
  auto* check =
      app.add_flag("--check-config", arguments.check_config, "Check the configuration and leave")->needs(config);
  app.add_flag("--for-reload", arguments.for_reload, "With --check-config: files that are missing are no mistake")
      ->needs(check);
  auto* scene = app.add_option("--check-scene", arguments.check_scene, "Check a glTF file and leave")
                    ->type_name("FILE")
                    ->excludes(config);
  app.set_version_flag("--version", "gnomond " GNOMON_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& ended) {
    return app.exit(ended) == 0 ? EXIT_SUCCESS : gnomon::daemon::kWrongUsage;
  }
  if (config->count() + scene->count() == 0) {
    std::fprintf(stderr, "gnomond: --config FILE is needed; gnomond.yaml(5) explains every key\n");
    return gnomon::daemon::kWrongUsage;
  }
  return gnomon::daemon::run(arguments);
}
