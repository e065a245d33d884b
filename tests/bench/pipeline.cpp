// Suite "pipeline": the complete daemon in this process, kept busy by clients over loopback; for comparison, in the
// same run and along the same camera paths, the bare kernels: frames submitted back to back and discarded.
#include <sys/resource.h>

#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>

#include "client/load/load_report.h"
#include "client/load/load_run.h"
#include "common/clock.h"
#include "daemon/daemon.h"
#include "daemon/render/vulkan_renderers.h"
#include "gpu/vulkan_renderer.h"
#include "scenes/loader.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/scratch_folder.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;

constexpr SceneId kScene{0};

double cpu_seconds(int who) {
  rusage usage{};
  getrusage(who, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double device_busy_seconds(const daemon::Metrics& metrics) {
  std::istringstream lines(metrics.text());
  const std::string name("gnomon_device_busy_seconds_total ");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(name)) return std::stod(line.substr(name.size()));
  return 0;
}

// The clients of one measurement and what they saw, on enough threads that the clients do not limit the daemon.
struct Flight {
  double vbps = 0, seconds = 0, clients_cpu_seconds = 0;
  uint64_t frames = 0, bytes = 0;
  client::Latencies server, response;
};

Result<Flight> fly(const client::LoadOptions& options, size_t clients, size_t threads) {
  threads = std::min(threads, clients);
  std::vector<std::unique_ptr<client::LoadRun>> runs;
  std::vector<std::thread> pilots;
  std::vector<Result<void>> done(threads, Result<void>());
  std::vector<double> cpu(threads);
  for (size_t t = 0; t < threads; ++t) {
    const size_t mine = clients / threads + (t < clients % threads ? 1 : 0);
    runs.push_back(std::make_unique<client::LoadRun>(options, std::vector<client::LoadGroup>{{.clients = mine}}));
    pilots.emplace_back([&, t] {
      std::FILE* nowhere = std::fopen("/dev/null", "w");
      {
        Progress progress(nowhere);
        done[t] = runs[t]->run(progress);
      }
      std::fclose(nowhere);
      cpu[t] = cpu_seconds(RUSAGE_THREAD);
    });
  }
  for (std::thread& pilot : pilots) pilot.join();
  Flight flight;
  for (size_t t = 0; t < threads; ++t) {
    if (!done[t]) return done[t].error();
    const client::LoadRow total = client::load_rows(*runs[t]).back();
    flight.vbps += total.vbps;
    flight.frames += total.figures.counters.complete;
    flight.bytes += total.figures.bytes;
    flight.response.add(total.figures.latencies);
    flight.seconds = std::max(flight.seconds, runs[t]->flight_seconds());
    flight.clients_cpu_seconds += cpu[t];
    for (const auto& participant : runs[t]->participants()) flight.server.add(participant.client->server_times());
  }
  return flight;
}

// Frames of `clients` cameras in turn, each at another place of the path, as the load's clients are.
class BareKernels {
 public:
  // `in_flight`: frames on the device at a time, as many as the daemon has at most.
  BareKernels(std::unique_ptr<gpu::Renderer> renderer, scenes::ScenePtr scene, uint32_t in_flight)
      : renderer_(std::move(renderer)), scene_(std::move(scene)), in_flight_(static_cast<int>(in_flight)) {}

  // Means since the last call: the time of a frame and of each of its passes on the device.
  void take_times(nlohmann::ordered_json& row) {
    const double frames = 1e6 * static_cast<double>(std::max<uint64_t>(done_, 1));
    row["bare_gpu_ms"] = static_cast<double>(gpu_ns_) / frames;
    for (const auto& [pass, ns] : stage_ns_)
      row["pass_" + std::string(pass) + "_ms"] = static_cast<double>(ns) / frames;
    stage_ns_.clear();
    gpu_ns_ = done_ = 0;
  }

  Result<void> prepare() { return renderer_->make_resident(kScene, scene_); }
  const gpu::Renderer& renderer() const { return *renderer_; }

  // Frames a second.
  Result<double> run(PictureSize size, size_t clients, double seconds) {
    const TimePoint start = Clock::now();
    uint64_t frames = 0;
    for (double now = 0; now < seconds; now = to_seconds(Clock::now() - start), ++frames) {
      const double phase = static_cast<double>(frames % clients) / static_cast<double>(clients);
      const double length = path_seconds(*scene_);
      const double place = std::fmod(now + phase * length, length);
      if (auto submitted = submit(camera_on_path(*scene_, place, size), size); !submitted) return submitted.error();
    }
    wait_until(0);
    return static_cast<double>(frames) / to_seconds(Clock::now() - start);
  }

 private:
  Result<void> submit(const gpu::CameraView& camera, PictureSize size) {
    wait_until(in_flight_ - 1);
    const gpu::RenderJob job{JobId(++jobs_), kScene, camera, size.width, size.height};
    auto submitted = renderer_->submit(job, [this](gpu::FrameDone done) {
      done.mask.drop();
      std::lock_guard lock(mutex_);
      gpu_ns_ += done.gpu_ns;
      ++done_;
      for (const gpu::StageTime& stage : done.stages) stage_ns_[stage.pass] += stage.gpu_ns;
      --under_way_;
      changed_.notify_all();
    });
    if (!submitted) return submitted;
    std::lock_guard lock(mutex_);
    ++under_way_;
    return {};
  }

  void wait_until(int most) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return under_way_ <= most; });
  }

  std::unique_ptr<gpu::Renderer> renderer_;
  scenes::ScenePtr scene_;
  const int in_flight_;
  uint64_t jobs_ = 0;
  std::map<std::string_view, uint64_t> stage_ns_;  // sums, as below; guarded by mutex_ while frames are out
  uint64_t gpu_ns_ = 0, done_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  int under_way_ = 0;
};

class PipelineSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file; default: both built-in ones and Sponza");
    command.add_option("--size", sizes_, "pixels of each client's buffer")->capture_default_str();
    command.add_option("--clients", clients_, "how many at a time")->capture_default_str();
    command.add_option("--rate", rate_hz_, "cameras a second of each client; 0: as many as are answered")
        ->capture_default_str();
    command.add_option("--seconds", seconds_, "of each measurement")->capture_default_str();
    command.add_option("--cache", cache_, "folder of what tracers build; default: one that is thrown away");
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--raster", raster_, "as render.raster of the configuration")->capture_default_str();
    command.add_option("--queues", queues_, "as render.queues")->capture_default_str();
    command.add_option("--frames-in-flight", frames_in_flight_, "as render.frames_in_flight")
        ->capture_default_str();
    command.add_option("--quantum-us,--slice-us", quantum_us_, "scheduler.quantum_us of the daemon; default: auto");
    command.add_option("--encode-threads", encode_threads_, "encode.threads of the daemon")->capture_default_str();
    command.add_option("--load-threads", load_threads_, "of the clients")->capture_default_str();
    command.add_option("--net-threads", net_threads_, "server.net_threads of the daemon")->capture_default_str();
  }

  Result<Report> run() override {
    report_.suite = "pipeline";
    log::set_level(log::Level::warning);
    if (scenes_.empty()) {
      for (const std::string& scene : default_scenes())
        if (scene == "living_room" || scene == "temple" || scene == "sponza_crytek") scenes_.push_back(scene);
    }
    for (const std::string& scene : scenes_) {
      if (auto measured = measure_scene(scene); !measured) return measured.error();
    }
    return std::move(report_);
  }

 private:
  daemon::Config config(const std::string& name, const std::filesystem::path& file) const {
    daemon::Config config;
    config.server.mode = daemon::ServerMode::demo;
    config.server.state_folder = scratch_.path();
    config.server.control_port = config.server.data_port = config.admin.port = 0;
    config.admin.socket.clear();
    config.server.net_threads = net_threads_;
    config.server.drain_timeout = std::chrono::milliseconds(0);
    config.scenes.list = {{name, file, ""}};
    if (!device_.empty()) config.render.device = device_;
    config.render.raster = raster_;
    config.render.queues = queues_;
    config.render.frames_in_flight = frames_in_flight_;
    config.render.wait_for_light_buffers = true;
    config.render.cache_folder = cache_.empty() ? scratch_.path() : cache_;
    config.render.passes = gpu::RendererOptions{}.passes;
    config.encode.threads = encode_threads_;
    if (quantum_us_) config.scheduler.quantum = std::chrono::microseconds(*quantum_us_);
    config.scheduler.admit_percent = 0;
    return config;
  }

  Result<void> measure_scene(const std::string& name) {
    const auto file = scene_file(name);
    if (!file) return file.error();
    const auto scene = scenes::load_scene(*file);
    if (!scene) return scene.error();
    const daemon::Config config = this->config(file->stem().string(), *file);
    const std::vector<daemon::RendererFactory> factories = daemon::vulkan_renderers(config);
    say("scene " + name + ": the bare kernels get ready");
    auto renderer = factories.front()();
    if (!renderer) return renderer.error();
    BareKernels bare(std::move(*renderer), *scene, frames_in_flight_);
    if (auto ready = bare.prepare(); !ready) return ready;
    report_.device = bare.renderer().info().name;
    report_.driver = bare.renderer().info().driver;
    say("scene " + name + ": the daemon gets ready");
    auto daemon = daemon::Daemon::start({config, factories, "bench", {}, [](const Error& e) { say(e.message); }});
    if (!daemon) return daemon.error();
    for (const std::string& size : sizes_) {
      for (const size_t clients : clients_) {
        if (auto r = measure(name, *file, (*scene)->lights.size(), bare, **daemon, size, clients); !r) return r;
      }
    }
    return {};
  }

  client::LoadOptions load(const std::filesystem::path& file, const daemon::Daemon& daemon, PictureSize size,
                           double seconds) const {
    client::LoadOptions options;
    options.server = {"127.0.0.1", daemon.control_port()};
    options.trust.pin = protocol::to_string(daemon.pin());
    options.scene = file.stem().string();
    options.scene_folder = file.parent_path();
    options.size = {static_cast<uint16_t>(size.width), static_cast<uint16_t>(size.height)};
    options.rate_hz = rate_hz_;
    options.in_flight = 2;  // so that the next camera waits when a frame is finished
    options.duration = std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(seconds));
    return options;
  }

  // The bare kernels are measured half before and half after, as the machine's speed may change meanwhile.
  Result<void> measure(const std::string& name, const std::filesystem::path& file, size_t lights, BareKernels& bare,
                       daemon::Daemon& daemon, const std::string& size_text, size_t clients) {
    const auto size = parse_size(size_text);
    if (!size) return size.error();
    say("scene " + name + " " + size_text + ", " + std::to_string(clients) + " clients");
    const auto before = bare.run(*size, clients, seconds_ / 2);
    if (!before) return before.error();
    const auto warm = fly(load(file, daemon, *size, 0.25 * seconds_), clients, load_threads_);  // costs are learned
    if (!warm) return warm.error();
    const double busy = device_busy_seconds(daemon.metrics()), cpu = cpu_seconds(RUSAGE_SELF);
    const auto flight = fly(load(file, daemon, *size, seconds_), clients, load_threads_);
    if (!flight) return flight.error();
    const double busy_s = device_busy_seconds(daemon.metrics()) - busy;
    const double cpu_s = cpu_seconds(RUSAGE_SELF) - cpu - flight->clients_cpu_seconds;
    const auto after = bare.run(*size, clients, seconds_ / 2);
    if (!after) return after.error();

    const double bare_vbps = (*before + *after) / 2;
    const double bits = static_cast<double>(size->width) * size->height * static_cast<double>(lights);
    const double frames = std::max<double>(1, static_cast<double>(flight->frames));
    ordered_json row{{"scene", name},
                     {"size", size_text},
                     {"clients", clients},
                     {"rate_hz", rate_hz_},
                     {"vbps", flight->vbps},
                     {"gvis_per_s", flight->vbps * bits / 1e9},
                     {"p50_ms", to_milliseconds(flight->server.percentile(0.5))},
                     {"p99_ms", to_milliseconds(flight->server.percentile(0.99))},
                     {"response_p50_ms", to_milliseconds(flight->response.percentile(0.5))},
                     {"gpu_busy_share", busy_s / flight->seconds},
                     {"cpu_ms_per_frame", 1e3 * cpu_s / frames},
                     {"bytes_per_frame", static_cast<double>(flight->bytes) / frames},
                     {"bare_vbps", bare_vbps},
                     {"ratio_to_bare_kernels", flight->vbps / bare_vbps}};
    bare.take_times(row);
    report_.rows.push_back(std::move(row));
    return {};
  }

  std::vector<std::string> scenes_;
  std::vector<std::string> sizes_{"1280x720", "1920x1080"};
  std::vector<size_t> clients_{1, 2, 4, 8, 16};
  double rate_hz_ = 0, seconds_ = 8;
  std::string device_, raster_ = "auto";
  std::filesystem::path cache_;
  uint32_t queues_ = daemon::RenderConfig{}.queues, frames_in_flight_ = daemon::RenderConfig{}.frames_in_flight;
  std::optional<int64_t> quantum_us_;
  uint32_t encode_threads_ = 1, net_threads_ = 1;
  size_t load_threads_ = 1;
  ScratchFolder scratch_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_pipeline_suite() { return std::make_unique<PipelineSuite>(); }

}  // namespace gnomon::bench
