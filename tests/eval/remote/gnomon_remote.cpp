// gnomon-remote: full remote rendering, for comparison: a server that shades and streams H.264 and a client that
// only decodes, in one process, with a simulated link between them. Says how good, how late and how large.
#include <asio/io_context.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <thread>

#include "client/cli/options.h"
#include "client/cli/program.h"
#include "client/cli/report.h"
#include "client/media/scene_file.h"
#include "client/media/video_file.h"
#include "client/view/ground_truth_renderer.h"
#include "tests/eval/remote/remote_client.h"
#include "tests/eval/remote/remote_server.h"
#include "tests/tools/netsim/relay.h"

namespace {

using namespace gnomon;
using namespace gnomon::remote;

struct Arguments {
  std::string scene, scene_folder, size = "640x360", link, preset = "veryfast", device, cache, json, out;
  uint32_t frames = 120;
  double rate_hz = 30;
  uint64_t seed = 1;
};

void declare(CLI::App& app, Arguments& a) {
  app.add_option("--scene", a.scene, "a built-in scene, or a glTF file")->required()->type_name("NAME");
  app.add_option("--scene-dir", a.scene_folder, "folder of scene files")->type_name("DIR");
  app.add_option("--size", a.size, "of the picture")->type_name("WxH");
  app.add_option("--frames", a.frames, "steps in which the camera path is flown")->type_name("N");
  app.add_option("--rate", a.rate_hz, "cameras a second")->check(CLI::Range(1.0, 240.0))->type_name("HZ");
  app.add_option("--link", a.link,
                 "as netsim's: delay=25ms,jitter=2ms,loss=1%,rate=10mbit (the rate towards the client)")
      ->type_name("PROFILE");
  app.add_option("--seed", a.seed, "of the link's chances")->type_name("N");
  app.add_option("--preset", a.preset, "libx264's")->type_name("NAME");
  app.add_option("--device", a.device, "Vulkan device: name, index or type")->type_name("NAME");
  app.add_option("--cache", a.cache, "folder for light buffers, so that the next run is quick to start")
      ->type_name("DIR");
  app.add_option("--out", a.out, "folder for shown.mp4 and ideal.mp4: what came and what was rendered")
      ->type_name("DIR");
  app.add_option("--json", a.json, "where to write the figures")->type_name("FILE");
}

protocol::SealSecrets new_secrets() {
  std::random_device random;
  protocol::SealSecrets secrets;
  for (auto* secret : {&secrets.client, &secrets.server})
    for (uint8_t& byte : *secret) byte = static_cast<uint8_t>(random());
  return secrets;
}

// Both directions of the link, on a thread of its own, in front of one port.
class SimulatedLink {
 public:
  static Result<std::unique_ptr<SimulatedLink>> open(const std::string& profile, uint16_t port, uint64_t seed) {
    netsim::Profile down;
    if (auto applied = netsim::apply(profile, down); !applied) return applied.error();
    netsim::Profile up = down;
    up.rate_bit_per_s = 0;
    netsim::RelayOptions options;
    options.udp_ports = {port};
    options.up = {{{}, up}};
    options.down = {{{}, down}};
    options.seed = seed;
    std::unique_ptr<SimulatedLink> link(new SimulatedLink);
    auto relay = netsim::Relay::open(link->io_, options);
    if (!relay) return relay.error();
    link->relay_ = std::move(*relay);
    link->thread_ = std::thread([io = &link->io_] { io->run(); });
    link->address_ = {options.listen, port};
    return link;
  }
  ~SimulatedLink() {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }
  const client::Address& address() const { return address_; }

 private:
  SimulatedLink() = default;
  asio::io_context io_;
  std::unique_ptr<netsim::Relay> relay_;
  client::Address address_;
  std::thread thread_;
};

// Mean squared error of red, green and blue.
double squared_error(const client::Picture& a, const client::Picture& b) {
  double sum = 0;
  size_t count = 0;
  for (uint32_t y = 0; y < a.height; ++y)
    for (uint32_t x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c, ++count) sum += std::pow(int{a.pixel(x, y)[c]} - int{b.pixel(x, y)[c]}, 2);
  return sum / static_cast<double>(count);
}

// Of the pictures that came against those that were meant. Writes both as videos if asked.
Result<double> compare(const Arguments& a, const scenes::ScenePtr& scene, const client::Size& size,
                       const FlightResult& flight) {
  auto source =
      client::GroundTruthRenderer::create(scene, {size.width, size.height}, {.device = a.device}, a.cache);
  if (!source) return source.error();
  std::optional<client::VideoFile> shown_file, ideal_file;
  if (!a.out.empty()) {
    std::error_code exists;
    std::filesystem::create_directories(a.out, exists);
    for (auto* file : {&shown_file, &ideal_file}) {
      const char* name = file == &shown_file ? "shown.mp4" : "ideal.mp4";
      auto made = client::VideoFile::create(std::filesystem::path(a.out) / name, {.fps = a.rate_hz, .quality = 0});
      if (!made) return made.error();
      *file = std::move(*made);
    }
  }
  double error = 0;
  for (const ShownPicture& shown : flight.shown) {
    auto ideal = (*source)->picture(shown.camera);
    if (!ideal) return ideal.error();
    error += squared_error(shown.picture, *ideal);
    if (!shown_file) continue;
    if (auto added = shown_file->add(shown.picture); !added) return added.error();
    if (auto added = ideal_file->add(*ideal); !added) return added.error();
  }
  if (shown_file) {
    if (auto closed = shown_file->close(); !closed) return closed.error();
    if (auto closed = ideal_file->close(); !closed) return closed.error();
  }
  const double mean = error / static_cast<double>(flight.shown.size());
  return 10 * std::log10(255.0 * 255.0 / std::max(mean, 1e-9));
}

nlohmann::ordered_json row_of(const Arguments& a, const FlightResult& flight, const ServerFigures& server,
                              double psnr) {
  const auto ms = [](const client::Latencies& of, double share) { return to_milliseconds(of.percentile(share)); };
  const double shown = static_cast<double>(flight.shown.size());
  const double per_s = flight.seconds > 0 ? 1 / flight.seconds : 0;
  return {{"mode", "remote"},
          {"scene", a.scene},
          {"size", a.size},
          {"link", a.link},
          {"cameras", a.frames},
          {"shown", flight.shown.size()},
          {"fps", shown * per_s},
          {"response_ms", ms(flight.response, 0.5)},
          {"response_p99_ms", ms(flight.response, 0.99)},
          {"bytes_per_frame", static_cast<double>(flight.received_bytes) / shown},
          {"mbit_per_s", 8e-6 * static_cast<double>(flight.received_bytes) * per_s},
          {"psnr", psnr},
          {"render_ms", ms(server.render, 0.5)},
          {"encode_ms", ms(server.encode, 0.5)},
          {"decode_ms", ms(flight.decode, 0.5)},
          {"key_pictures", server.key_units},
          {"not_decoded", flight.not_decoded}};
}

Result<void> run(const Arguments& a) {
  const auto size = client::parse_size(a.size, 16);
  if (!size) return size.error();
  if (size->width % 2 || size->height % 2) return Error{"H.264 takes even widths and heights"};
  auto scene = client::load_own_scene(a.scene, a.scene_folder);
  if (!scene) return scene.error();

  ServerOptions options;
  options.scene = *scene;
  options.device = a.device;
  options.cache = a.cache;
  options.video = {.width = size->width, .height = size->height, .fps = a.rate_hz, .preset = a.preset.c_str()};
  options.secrets = new_secrets();
  auto server = RemoteServer::start(options);
  if (!server) return server.error();
  FlightPlan plan{.server = {"127.0.0.1", (*server)->port()},
                  .secrets = options.secrets,
                  .size = {size->width, size->height},
                  .frames = a.frames,
                  .rate_hz = a.rate_hz};
  std::unique_ptr<SimulatedLink> link;
  if (!a.link.empty()) {
    auto opened = SimulatedLink::open(a.link, plan.server.port, a.seed);
    if (!opened) return opened.error();
    link = std::move(*opened);
    plan.server = link->address();
  }
  auto flight = fly(client::CameraPath::of_scene(*scene), plan);
  if (!flight) return flight.error();
  auto figures = (*server)->stop();
  if (!figures) return figures.error();
  if (flight->shown.empty()) return Error{"no picture came"};
  const auto psnr = compare(a, *scene, *size, *flight);
  if (!psnr) return psnr.error();

  client::Report report{.suite = "remote", .device = a.device, .driver = "libx264 " + a.preset};
  report.rows.push_back(row_of(a, *flight, *figures, *psnr));
  for (const auto& [key, value] : report.rows[0].items())
    std::printf("%-16s %s\n", key.c_str(), value.dump().c_str());
  return a.json.empty() ? Result<void>{} : write_report(a.json, report);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Full remote rendering over a simulated link, for comparison with visibility streaming.",
               "gnomon-remote");
  return client::run_program(app, argc, argv, declare, run);
}
