// gnomon-remote: full remote rendering, for comparison: a server that shades and streams H.264 and a client that
// only decodes, in one process, with a simulated link between them. With --server: Gnomon's thin client on the same
// path and clock. Says how late and how large; how good, by what was on the screen and what should have been (--out).
#include <algorithm>
#include <asio/io_context.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "client/cli/options.h"
#include "client/cli/program.h"
#include "client/cli/report.h"
#include "client/media/scene_file.h"
#include "client/view/ground_truth_renderer.h"
#include "tests/eval/remote/remote_client.h"
#include "tests/eval/remote/remote_server.h"
#include "tests/eval/remote/screen.h"
#include "tests/eval/remote/visibility_flight.h"
#include "tests/tools/netsim/relay.h"

namespace {

using namespace gnomon;
using namespace gnomon::remote;

struct Arguments {
  std::string scene, scene_folder, size = "640x360", border = "0x0", link, preset = "veryfast", device, cache, json,
                                   out;
  std::string server, tenant;
  client::Trust trust;
  uint32_t frames = 120;
  double rate_hz = 30, from_s = 0, warm_up_s = 1;
  uint64_t seed = 1;
};

void declare(CLI::App& app, Arguments& a) {
  app.add_option("--scene", a.scene, "a built-in scene, or a glTF file")->required()->type_name("NAME");
  app.add_option("--scene-dir", a.scene_folder, "folder of scene files")->type_name("DIR");
  app.add_option("--size", a.size, "of the picture")->type_name("WxH");
  app.add_option("--frames", a.frames, "of the camera path, at its own speed")->type_name("N");
  app.add_option("--from", a.from_s, "second of the path at which it begins")->type_name("S");
  app.add_option("--warm-up", a.warm_up_s, "seconds at the begin that are not judged")->type_name("S");
  app.add_option("--rate", a.rate_hz, "cameras a second")->check(CLI::Range(1.0, 240.0))->type_name("HZ");
  app.add_option("--link", a.link,
                 "as netsim's: delay=25ms,jitter=2ms,loss=1%,rate=10mbit (the rate towards the client)")
      ->type_name("PROFILE");
  app.add_option("--seed", a.seed, "of the link's chances")->type_name("N");
  app.add_option("--preset", a.preset, "libx264's")->type_name("NAME");
  app.add_option("--device", a.device, "Vulkan device: name, index or type")->type_name("NAME");
  app.add_option("--cache", a.cache, "folder for light buffers, so that the next run is quick to start")
      ->type_name("DIR");
  app.add_option("--out", a.out,
                 "folder for shown.rgb and ideal.rgb: what was on the screen at each step, what was meant")
      ->type_name("DIR");
  app.add_option("--server", a.server, "a gnomond: visibility from there in place of video, in mode auto")
      ->type_name("HOST:PORT");
  app.add_option("--tenant", a.tenant, "of --server's session")->type_name("NAME");
  app.add_option("--border", a.border, "of --server's masks, in all")->type_name("WxH");
  client::declare_trust(app, a.trust);
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

void append_rgb(std::ofstream& file, const client::Picture& picture) {
  std::vector<char> rgb(picture.rgba.size() / 4 * 3);
  for (size_t from = 0, to = 0; from < picture.rgba.size(); from += 4)
    for (size_t c = 0; c < 3; ++c) rgb[to++] = static_cast<char>(picture.rgba[from + c]);
  file.write(rgb.data(), static_cast<std::streamsize>(rgb.size()));
}

// Pictures of a path as they should be, each traced once. The exposure is that for step `first`.
class Ideal {
 public:
  static Result<Ideal> create(const Arguments& a, const scenes::ScenePtr& scene, const client::ViewSize& size,
                              uint32_t first) {
    auto source = client::GroundTruthRenderer::create(scene, size, {.device = a.device}, a.cache);
    if (!source) return source.error();
    Ideal ideal(a, client::CameraPath::of_scene(scene), size, std::move(*source));
    if (auto exposed = ideal.at(first); !exposed) return exposed.error();
    return ideal;
  }

  Result<const client::Picture*> at(uint32_t step) {
    if (step_ == step) return &picture_;
    auto made = source_->picture(client::view_of(path_.at(from_s_ + step / rate_hz_), size_));
    if (!made) return made.error();
    picture_ = std::move(*made);
    step_ = step;
    return &picture_;
  }

 private:
  Ideal(const Arguments& a, client::CameraPath path, const client::ViewSize& size,
        std::unique_ptr<client::GroundTruthRenderer> source)
      : from_s_(a.from_s), rate_hz_(a.rate_hz), path_(std::move(path)), size_(size), source_(std::move(source)) {}

  double from_s_, rate_hz_;
  client::CameraPath path_;
  client::ViewSize size_;
  std::unique_ptr<client::GroundTruthRenderer> source_;
  std::optional<uint32_t> step_;
  client::Picture picture_;
};

// Writes both videos if a folder is given. Shares of the steps whose picture was late.
Result<double> judge(const Arguments& a, const scenes::ScenePtr& scene, const client::ViewSize& size,
                     const Screen& screen, uint32_t exposed_for) {
  const auto seen = seen_at_steps(screen, static_cast<uint32_t>(a.warm_up_s * a.rate_hz));
  if (seen.empty()) return Error{"no picture came"};
  const auto late = std::count_if(seen.begin(), seen.end(), [](const Seen& step) { return step.late; });
  const double share = static_cast<double>(late) / static_cast<double>(seen.size());
  if (a.out.empty()) return share;
  std::error_code exists;
  std::filesystem::create_directories(a.out, exists);
  auto ideal = Ideal::create(a, scene, size, exposed_for);
  if (!ideal) return ideal.error();
  const std::filesystem::path folder(a.out);
  std::ofstream shown_file(folder / "shown.rgb", std::ios::binary),
      ideal_file(folder / "ideal.rgb", std::ios::binary);
  for (const Seen& step : seen) {
    const auto meant = ideal->at(step.meant);
    if (!meant) return meant.error();
    append_rgb(shown_file, screen.pictures[step.picture].picture);
    append_rgb(ideal_file, **meant);
  }
  if (!shown_file.flush() || !ideal_file.flush()) return Error{"cannot write to " + a.out};
  return share;
}

nlohmann::ordered_json row_of(const Arguments& a, const char* mode, const Screen& screen,
                              const client::Latencies& response, uint64_t bytes, double seconds, double late) {
  const double pictures = static_cast<double>(screen.pictures.size());
  return {{"mode", mode},
          {"scene", a.scene},
          {"size", a.size},
          {"link", a.link},
          {"cameras", a.frames},
          {"shown", screen.pictures.size()},
          {"fps", pictures / seconds},
          {"response_ms", to_milliseconds(response.percentile(0.5))},
          {"response_p99_ms", to_milliseconds(response.percentile(0.99))},
          {"mbit_per_s", 8e-6 * static_cast<double>(bytes) / seconds},
          {"late_share", late}};
}

Result<nlohmann::ordered_json> fly_video(const Arguments& a, const scenes::ScenePtr& scene,
                                         const client::ViewSize& size) {
  if (size.width % 2 || size.height % 2) return Error{"H.264 takes even widths and heights"};
  const client::CameraPath path = client::CameraPath::of_scene(scene);
  ServerOptions options;
  options.scene = scene;
  options.device = a.device;
  options.cache = a.cache;
  options.video = {.width = size.width, .height = size.height, .fps = a.rate_hz, .preset = a.preset.c_str()};
  options.secrets = new_secrets();
  options.first = client::view_of(path.at(a.from_s), size);
  auto server = RemoteServer::start(options);
  if (!server) return server.error();
  FlightPlan plan{.server = {"127.0.0.1", (*server)->port()},
                  .secrets = options.secrets,
                  .size = size,
                  .frames = a.frames,
                  .rate_hz = a.rate_hz,
                  .from_s = a.from_s};
  std::unique_ptr<SimulatedLink> link;
  if (!a.link.empty()) {
    auto opened = SimulatedLink::open(a.link, plan.server.port, a.seed);
    if (!opened) return opened.error();
    link = std::move(*opened);
    plan.server = link->address();
  }
  auto flight = fly(path, plan);
  if (!flight) return flight.error();
  const auto figures = (*server)->stop();
  if (!figures) return figures.error();
  const auto late = judge(a, scene, size, flight->screen, 0);
  if (!late) return late.error();
  auto row = row_of(a, "video", flight->screen, flight->response, flight->received_bytes, flight->seconds, *late);
  row["render_ms"] = to_milliseconds(figures->render.percentile(0.5));
  row["encode_ms"] = to_milliseconds(figures->encode.percentile(0.5));
  row["decode_ms"] = to_milliseconds(flight->decode.percentile(0.5));
  row["key_pictures"] = figures->key_units;
  row["not_decoded"] = flight->not_decoded;
  return row;
}

Result<VisibilityPlan> visibility_plan(const Arguments& a, const client::ViewSize& size) {
  const auto server = client::parse_address(a.server);
  if (!server) return server.error();
  VisibilityPlan plan{
      .stream = {}, .size = size, .device = a.device, .steps = a.frames, .rate_hz = a.rate_hz, .from_s = a.from_s};
  plan.stream.connect.server = *server;
  plan.stream.connect.trust = a.trust;
  auto& hello = plan.stream.connect.hello;
  hello.client = "gnomon-remote";
  hello.tenant = a.tenant;
  hello.scene = a.scene;
  hello.width = static_cast<uint16_t>(size.traced_width());
  hello.height = static_cast<uint16_t>(size.traced_height());
  hello.border_x = static_cast<uint16_t>(size.border_x);
  hello.border_y = static_cast<uint16_t>(size.border_y);
  hello.rate_hz = static_cast<float>(a.rate_hz);
  return plan;
}

Result<nlohmann::ordered_json> fly_visibility(const Arguments& a, const scenes::ScenePtr& scene,
                                              const client::ViewSize& size) {
  const auto plan = visibility_plan(a, size);
  if (!plan) return plan.error();
  const auto flight = fly(scene, *plan);
  if (!flight) return flight.error();
  if (flight->screen.pictures.empty()) return Error{"no picture came"};
  const auto late = judge(a, scene, size, flight->screen, flight->screen.pictures.front().step);
  if (!late) return late.error();
  auto row =
      row_of(a, "visibility", flight->screen, flight->response, flight->received_bytes, flight->seconds, *late);
  std::vector<size_t> ahead = flight->ahead;
  std::sort(ahead.begin(), ahead.end());
  row["x"] = ahead[ahead.size() / 2];
  row["vbps"] = static_cast<double>(flight->masks) / flight->seconds;
  return row;
}

Result<void> run(const Arguments& a) {
  const auto size = client::parse_size(a.size, 16);
  if (!size) return size.error();
  const auto border = client::parse_size(a.border, 0);
  if (!border) return border.error();
  auto scene = client::load_own_scene(a.scene, a.scene_folder);
  if (!scene) return scene.error();
  const auto row = a.server.empty()
                       ? fly_video(a, *scene, {size->width, size->height})
                       : fly_visibility(a, *scene, {size->width, size->height, border->width, border->height});
  if (!row) return row.error();
  for (const auto& [key, value] : row->items()) std::printf("%-16s %s\n", key.c_str(), value.dump().c_str());
  client::Report report{.suite = "remote", .device = a.device, .driver = "libx264 " + a.preset};
  report.rows.push_back(*row);
  return a.json.empty() ? Result<void>{} : write_report(a.json, report);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Full remote rendering over a simulated link, for comparison with visibility streaming.",
               "gnomon-remote");
  return client::run_program(app, argc, argv, declare, run);
}
