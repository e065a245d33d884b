// Case of gnomon-bench transport: the effect of a flood of junk on honest sessions at the same data port. The daemon
// has a renderer that takes a fixed time, so that the flood loads only the network side.
#include "client/load/load_report.h"
#include "client/load/load_run.h"
#include "daemon/daemon.h"
#include "scenes/loader.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/report.h"
#include "tests/bench/scratch_folder.h"
#include "tests/bench/transport.h"
#include "tests/tools/flood/flood.h"
#include "tests/unit/daemon/render/fake_renderer.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr double kJunkPerSecond = 200e3;
constexpr auto kFrameTime = 10ms;
constexpr size_t kClients = 4;

struct Fare {
  double vbps = 0, p99_ms = 0;
};

Result<Fare> fare(const client::LoadOptions& load) {
  Progress progress;
  client::LoadRun flight(load, {{.clients = kClients}});
  if (auto done = flight.run(progress); !done) return done.error();
  progress.clear();
  const client::LoadRow total = client::load_rows(flight).back();
  return Fare{total.vbps, to_milliseconds(total.figures.latencies.percentile(0.99))};
}

Result<std::vector<ordered_json>> junk_flood(const TransportOptions& options) {
  const auto file = scene_file("living_room");
  if (!file) return file.error();
  const auto scene = scenes::load_scene(*file);
  if (!scene) return scene.error();
  const ScratchFolder scratch;
  daemon::Daemon::Options served;
  served.config.server.mode = daemon::ServerMode::demo;
  served.config.server.state_folder = scratch.path();
  served.config.server.control_port = served.config.server.data_port = served.config.admin.port = 0;
  served.config.admin.socket.clear();
  served.config.server.drain_timeout = 0ms;
  served.config.server.silence_timeout = 1h;  // keeps the session whose datagrams are copied
  served.config.scenes.list = {{"living_room", *file, ""}};
  served.config.render.passes = {"gbuffer", "trace", "pack", "readback"};
  served.config.scheduler.admit_percent = 0;
  served.config.scheduler.quantum = 0us;  // no bands, as the renderer's fixed time applies to each band
  served.version = "bench";
  const auto lights = static_cast<uint32_t>((*scene)->lights.size());
  served.make_renderers = {[lights]() -> Result<std::unique_ptr<gpu::Renderer>> {
    return std::unique_ptr<gpu::Renderer>(std::make_unique<daemon::SelfRunningFakeRenderer>(3, lights, kFrameTime));
  }};
  const auto daemon = daemon::Daemon::start(std::move(served));
  if (!daemon) return daemon.error();

  client::LoadOptions load;
  load.server = {"127.0.0.1", (*daemon)->control_port()};
  load.trust.pin = protocol::to_string((*daemon)->pin());
  load.scene = "living_room";
  load.scene_folder = file->parent_path();
  load.size = {128, 72};
  load.duration = std::chrono::duration_cast<Nanoseconds>(options.seconds);
  daemon::TestClient listened((*daemon)->control_port());
  if (!listened.join(daemon::TestClient::hello("living_room"))) return Error{"no session to listen to"};
  tests::Datagrams junk = tests::strangers_junk();
  for (auto& datagram : tests::listeners_junk(listened)) junk.push_back(std::move(datagram));
  const auto came_in = [&] { return (*daemon)->metrics().datagrams(); };

  // Measured alternately, so that both run under the same conditions.
  constexpr int kTurns = 3;
  std::vector<double> alone, beside, ratios, p99_alone, p99_beside, p99_ratios;
  uint64_t sent = 0, replies = 0, read = 0;
  double flooded_s = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    const auto calm = fare(load);
    if (!calm) return calm.error();
    const TimePoint start = Clock::now();
    const uint64_t before = came_in();
    tests::Flood flood((*daemon)->server().data_ports().front(), junk, kJunkPerSecond);
    const auto flooded = fare(load);
    flooded_s += to_seconds(Clock::now() - start);
    flood.stop();
    read += came_in() - before;
    sent += flood.sent();
    replies += flood.replies();
    if (!flooded) return flooded.error();
    alone.push_back(calm->vbps);
    beside.push_back(flooded->vbps);
    ratios.push_back(flooded->vbps / calm->vbps);
    p99_alone.push_back(calm->p99_ms);
    p99_beside.push_back(flooded->p99_ms);
    p99_ratios.push_back(flooded->p99_ms / calm->p99_ms);
  }
  return std::vector<ordered_json>{{{"case", "junk_flood"},
                                    {"clients", kClients},
                                    {"datagrams_per_s", static_cast<double>(sent) / flooded_s},
                                    {"read_datagrams_per_s", static_cast<double>(read) / flooded_s},
                                    {"replies", replies},
                                    {"vbps_alone", median(alone)},
                                    {"vbps", median(beside)},
                                    {"vbps_ratio_to_alone", median(ratios)},
                                    {"p99_alone_ms", median(p99_alone)},
                                    {"p99_ms", median(p99_beside)},
                                    {"p99_ratio_to_alone", median(p99_ratios)}}};
}

}  // namespace

std::vector<TransportCase> junk_cases() { return {{"junk_flood", junk_flood}}; }

}  // namespace gnomon::bench
