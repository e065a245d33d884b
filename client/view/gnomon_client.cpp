// gnomon-client: the thin reference client. Flies through a scene with the server's visibility, shades every frame
// itself, leaves pictures and says how long answers took.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "client/options.h"
#include "client/report.h"
#include "client/scene_file.h"
#include "client/view/debug_view.h"
#include "client/view/flight.h"
#include "client/view/gallery.h"
#include "client/view/own_view.h"

namespace {

using namespace gnomon;
using namespace gnomon::client;

struct Arguments {
  std::string server, tenant, token_file, scene, scene_folder, size, mode = "sequential", out, json, device;
  std::string border = "0x0", view, codec;
  Trust trust;
  std::string transport = "auto";
  uint32_t frames = 60;
  uint32_t pictures = 4;
  double rate_hz = 0;
};

void declare(CLI::App& app, Arguments& a) {
  app.add_option("--server", a.server, "the daemon's control address")->required()->type_name("HOST:PORT");
  app.add_option("--tenant", a.tenant, "whose session this is")->type_name("NAME");
  app.add_option("--token-file", a.token_file, "file with the tenant's token")->type_name("FILE");
  declare_trust(app, a.trust);
  declare_transport(app, a.transport);
  app.add_option("--scene", a.scene, "scene that the server knows, or a glTF file")->required()->type_name("NAME");
  app.add_option("--scene-dir", a.scene_folder, "folder of this client's own scene files")->type_name("DIR");
  app.add_option("--size", a.size, "of the picture")->required()->type_name("WxH");
  app.add_option("--border", a.border, "prediction border, in all, traced around the picture")->type_name("WxH");
  app.add_option("--frames", a.frames, "steps in which the camera path is flown")
      ->check(CLI::Range(1u, 1000000u))
      ->type_name("N");
  app.add_option("--codec", a.codec, "tiles_lz4, tiles_context or raw32_lz4; else as the server likes")
      ->type_name("NAME");
  app.add_option("--mode", a.mode, "sequential, or queued: several cameras in flight")->type_name("MODE");
  app.add_option("--rate", a.rate_hz, "cameras a second at most; 0: as the mode allows")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("HZ");
  app.add_option("--out", a.out, "folder for pictures")->type_name("DIR");
  app.add_option("--pictures", a.pictures, "how many frames to keep")
      ->check(CLI::Range(1u, 10000u))
      ->type_name("N");
  app.add_option("--view", a.view, "also pictures of what the tracer does: mask, bounds or lists; see below")
      ->type_name("VIEW");
  app.footer(debug_legend());
  app.add_option("--device", a.device, "this client's own Vulkan device: name, index or type")->type_name("NAME");
  app.add_option("--json", a.json, "where to write the figures")->type_name("FILE");
}

Result<FlightOptions> flight_options(const Arguments& a) {
  const auto server = parse_address(a.server);
  if (!server) return server.error();
  const auto size = parse_size(a.size);
  if (!size) return size.error();
  const auto border = parse_size(a.border, 0);
  if (!border) return border.error();
  const auto mode = parse_mode(a.mode);
  if (!mode) return mode.error();

  FlightOptions flight;
  flight.mode = *mode;
  flight.rate_hz = a.rate_hz;
  flight.frames = a.frames;
  flight.size = {size->width, size->height, border->width, border->height};
  if (flight.size.traced_width() > protocol::kMaxSide || flight.size.traced_height() > protocol::kMaxSide) {
    return Error{"picture and border together exceed " + std::to_string(protocol::kMaxSide) + " pixels"};
  }
  flight.stream.answer_timeout = std::chrono::minutes(2);  // one step may take a CPU-only server long
  flight.stream.connect.server = *server;
  flight.stream.connect.trust = a.trust;
  const auto transport = parse_transport(a.transport);
  if (!transport) return transport.error();
  flight.stream.connect.transport = *transport;
  auto& hello = flight.stream.connect.hello;
  hello.client = "gnomon-client";
  hello.tenant = a.tenant;
  hello.scene = a.scene;
  hello.width = static_cast<uint16_t>(flight.size.traced_width());
  hello.height = static_cast<uint16_t>(flight.size.traced_height());
  hello.border_x = border->width;
  hello.border_y = border->height;
  hello.rate_hz = static_cast<float>(a.rate_hz);
  if (!a.codec.empty()) {
    const auto codec = protocol::parse_codec(a.codec);
    if (!codec) return codec.error();
    hello.codecs = {*codec};
  }
  if (!a.token_file.empty()) {
    auto token = read_token(a.token_file);
    if (!token) return token.error();
    hello.token = std::move(*token);
  }
  return flight;
}

void print_figures(const FlightFigures& f) {
  const auto ms = [&](double share) { return to_milliseconds(f.latencies.percentile(share)); };
  std::printf("frames      %llu complete, %llu with tiles missing, %llu cameras skipped, %llu unanswered\n",
              static_cast<unsigned long long>(f.counters.complete),
              static_cast<unsigned long long>(f.counters.incomplete),
              static_cast<unsigned long long>(f.counters.superseded),
              static_cast<unsigned long long>(f.counters.unanswered));
  std::printf("response    min %.1f  p50 %.1f  p99 %.1f  max %.1f ms\n", ms(0), ms(0.5), ms(0.99), ms(1));
  std::printf("rate        %.2f visibility buffers a second; drawing took %.1f ms a frame\n", f.vbps(),
              f.frames() ? 1000 * f.draw_seconds / static_cast<double>(f.frames()) : 0.0);
  std::printf("network     %.0f bytes a frame, %llu slices lost, %llu wrong\n", f.bytes_per_frame(),
              static_cast<unsigned long long>(f.counters.lost_slices),
              static_cast<unsigned long long>(f.counters.wrong_frames));
}

Report report_of(const Arguments& a, const FlightFigures& f, const std::string& tracer) {
  const auto ms = [&](double share) { return to_milliseconds(f.latencies.percentile(share)); };
  Report report{.suite = "client", .device = a.server, .driver = tracer};
  report.rows.push_back({{"scene", a.scene},
                         {"size", a.size},
                         {"border", a.border},
                         {"mode", a.mode},
                         {"tenant", a.tenant},
                         {"frames", f.counters.complete},
                         {"incomplete_frames", f.counters.incomplete},
                         {"superseded_cameras", f.counters.superseded},
                         {"unanswered_cameras", f.counters.unanswered},
                         {"vbps", f.vbps()},
                         {"min_ms", ms(0)},
                         {"p50_ms", ms(0.5)},
                         {"p99_ms", ms(0.99)},
                         {"max_ms", ms(1)},
                         {"draw_seconds", f.draw_seconds},
                         {"bytes_per_frame", f.bytes_per_frame()},
                         {"lost_slices", f.counters.lost_slices},
                         {"rebuilt_slices", f.counters.rebuilt_slices},
                         {"covered_words", f.covered_words},
                         {"wrong_frames", f.counters.wrong_frames}});
  return report;
}

// What --view asks for; empty without it.
Result<std::optional<DebugView>> debug_view(const Arguments& a, const scenes::ScenePtr& scene) {
  if (a.view.empty()) return std::optional<DebugView>();
  const auto kind = parse_debug_kind(a.view);
  if (!kind) return kind.error();
  if (a.out.empty()) return Error{"--view needs --out: a folder for its pictures"};
  auto view = DebugView::create(scene, *kind, a.device);
  if (!view) return view.error();
  return std::optional<DebugView>(std::move(*view));
}

Result<void> run(const Arguments& a) {
  const auto options = flight_options(a);
  if (!options) return options.error();
  auto scene = load_own_scene(a.scene, a.scene_folder);
  if (!scene) return scene.error();
  std::optional<Gallery> gallery;
  if (!a.out.empty()) {
    auto opened = Gallery::open(a.out, options->size, a.frames, a.pictures);
    if (!opened) return opened.error();
    gallery = std::move(*opened);
  }
  auto view = OwnView::create(*scene, a.device);
  if (!view) return view.error();
  auto debug = debug_view(a, *scene);
  if (!debug) return debug.error();

  Flight flight(*options);
  if (auto opened = flight.open(); !opened) return opened;
  if (const auto& motions = flight.welcome().motions; !motions.empty()) {
    scene = load_own_scene(a.scene, a.scene_folder, motions);
    if (!scene) return scene.error();
    view = OwnView::create(*scene, a.device);
    if (!view) return view.error();
    debug = debug_view(a, *scene);
    if (!debug) return debug.error();
  }
  if (auto same = check_same_scene(**scene, flight.welcome().scene); !same) return same;

  const auto draw = [&](const FlownFrame& frame) -> Result<void> {
    const auto shaded = view->shade(frame);
    if (!shaded) return shaded.error();
    if (!gallery || !gallery->wants(frame.index)) return {};
    const auto seen = view->seen_by_lights(frame);
    if (!seen) return seen.error();
    if (auto added = gallery->add(frame, *shaded, *seen); !added || !*debug) return added;
    const auto pictures = (*debug)->pictures(frame);
    if (!pictures) return pictures.error();
    return gallery->add_views(frame, a.view.c_str(), *pictures);
  };
  Progress progress;
  if (auto flown = flight.fly(CameraPath::of_scene(*scene), draw, progress); !flown) return flown;
  progress.clear();
  flight.close();

  const FlightFigures figures = flight.figures();
  print_figures(figures);
  if (gallery) {
    for (const auto& file : gallery->files()) std::printf("picture     %s\n", file.c_str());
  }
  if (!a.json.empty()) {
    const auto written = write_report(a.json, report_of(a, figures, flight.welcome().tracer));
    if (!written) return written;
  }
  if (figures.frames() == 0) return Error{"no camera was answered"};
  if (figures.counters.wrong_frames > 0) return Error{"slices came that answer no camera or do not decode"};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A thin client: rasterises and shades with visibility that a Gnomon daemon traced.",
               "gnomon-client");
  Arguments arguments;
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const auto done = run(arguments);
  if (!done) std::fprintf(stderr, "gnomon-client: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
