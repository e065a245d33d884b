// Case of gnomon-bench transport: what honest sessions notice of a flood of junk on their data port. The daemon with a
// renderer that takes a set time, so that the flood meets the network's side alone.
#include <sys/socket.h>

#include <asio/ip/udp.hpp>
#include <atomic>
#include <random>
#include <thread>

#include "client/load/load_report.h"
#include "client/load/load_run.h"
#include "daemon/daemon.h"
#include "scenes/loader.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/report.h"
#include "tests/bench/scratch_folder.h"
#include "tests/bench/transport.h"
#include "tests/daemon/fake_renderer.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr double kJunkPerSecond = 110e3;  // the promise is of 100,000; a thread that was kept waiting catches up
constexpr size_t kBatch = 100;
constexpr auto kFrameTime = 10ms;
constexpr size_t kClients = 4;

// Junk of all kinds: noise, right headers of sessions that do not exist, nothing at all.
std::vector<std::vector<uint8_t>> junk() {
  std::mt19937_64 random(1);
  std::vector<std::vector<uint8_t>> made(kBatch);
  for (size_t i = 0; i < kBatch; ++i) {
    if (i % 3 == 1) {
      made[i].resize(protocol::kHeaderBytes);
      const std::span<uint8_t, protocol::kHeaderBytes> header(made[i]);
      protocol::write_header(header, {.session = SessionId{random()}, .sequence = i + 1});
    }
    const size_t noise = i % 3 == 2 ? random() % 20 : 200 + random() % 1000;
    for (size_t byte = 0; byte < noise; ++byte) made[i].push_back(static_cast<uint8_t>(random()));
  }
  return made;
}

// Sends until it is dropped.
class Flood {
 public:
  explicit Flood(uint16_t port) : thread_([this, port] { run(port); }) {}
  ~Flood() { stop(); }

  uint64_t stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    return sent_;
  }

 private:
  void run(uint16_t port) {
    asio::io_context io;
    asio::ip::udp::socket socket(io);
    socket.connect({asio::ip::address_v4::loopback(), port});
    auto datagrams = junk();
    std::array<mmsghdr, kBatch> messages{};
    std::array<iovec, kBatch> buffers;
    for (size_t i = 0; i < kBatch; ++i) {
      buffers[i] = {datagrams[i].data(), datagrams[i].size()};
      messages[i].msg_hdr.msg_iov = &buffers[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    const TimePoint start = Clock::now();
    while (!stopping_) {
      const int took = sendmmsg(socket.native_handle(), messages.data(), kBatch, 0);
      if (took > 0) sent_ += static_cast<uint64_t>(took);
      std::this_thread::sleep_until(start + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(
                                                static_cast<double>(sent_) / kJunkPerSecond)));
    }
  }

  std::atomic<bool> stopping_{false};
  std::atomic<uint64_t> sent_{0};
  std::thread thread_;
};

Result<double> vbps(const client::LoadOptions& load) {
  client::Progress progress;
  client::LoadRun flight(load, {{"", "", kClients}});
  if (auto done = flight.run(progress); !done) return done.error();
  progress.clear();
  return client::load_rows(flight).back().vbps;
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
  served.config.server.drain_timeout = 0ms;
  served.config.scenes.list = {{"living_room", *file, ""}};
  served.config.render.passes = {"gbuffer", "trace", "pack", "readback"};
  served.config.scheduler.admit_percent = 0;
  served.config.scheduler.slice = 0us;  // each piece of a frame would take the set time
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
  // In turns, so that both meet the same machine.
  constexpr int kTurns = 3;
  std::vector<double> alone, beside, ratios;
  uint64_t sent = 0;
  double flooded_s = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    const auto calm = vbps(load);
    if (!calm) return calm.error();
    const TimePoint start = Clock::now();
    Flood flood((*daemon)->data_ports().front());
    const auto flooded = vbps(load);
    sent += flood.stop();
    flooded_s += to_seconds(Clock::now() - start);
    if (!flooded) return flooded.error();
    alone.push_back(*calm);
    beside.push_back(*flooded);
    ratios.push_back(*flooded / *calm);
  }
  return std::vector<ordered_json>{{{"case", "junk_flood"},
                                    {"clients", kClients},
                                    {"datagrams_per_s", static_cast<double>(sent) / flooded_s},
                                    {"vbps_alone", median(alone)},
                                    {"vbps", median(beside)},
                                    {"vbps_ratio_to_alone", median(ratios)}}};
}

}  // namespace

std::vector<TransportCase> junk_cases() { return {{"junk_flood", junk_flood}}; }

}  // namespace gnomon::bench
