// gnomon-client: the thin reference client. Flies through a scene with the server's visibility, shades every frame
// itself, writes pictures and reports how long answers took.
#include <csignal>
#include <cstdio>

#include "client/cli/options.h"
#include "client/cli/program.h"
#include "client/cli/report.h"
#include "client/cli/waiting_line.h"
#include "client/media/montage.h"
#include "client/media/scene_file.h"
#include "client/view/client_renderer.h"
#include "client/view/debug_view.h"
#include "client/view/flight.h"
#include "client/view/flight_text.h"
#include "client/view/gallery.h"
#include "client/view/recording.h"
#include "common/printable.h"

namespace {

using namespace gnomon;
using namespace gnomon::client;

volatile std::sig_atomic_t interrupted = 0;

// The first Ctrl-C ends the flight, and what was recorded and measured until then is kept; the second ends the program.
void keep_on_interrupt() {
  for (const int number : {SIGINT, SIGTERM}) {
    std::signal(number, [](int caught) {
      interrupted = 1;
      std::signal(caught, SIG_DFL);
    });
  }
}

struct Arguments {
  std::string server, tenant, token_file, scene, scene_folder, size, mode = "sequential", out, json, device;
  std::string border = "0x0", view, codec, record, record_view = "shown", antialias;
  size_t ahead = 4;
  double cost_per_s = 0.15;
  bool border_by_motion = false;
  Trust trust;
  std::string transport = "auto";
  uint32_t samples = 1;
  Occlusion occlusion = Occlusion::none;
  bool soft_filter = false, soft_accumulate = false;
  uint32_t frames = 60;
  uint32_t pictures = 4;
  double rate_hz = 0;
};

void declare(CLI::App& app, Arguments& a) {
  declare_server(app, a.server);
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
  declare_codec(app, a.codec);
  declare_samples(app, a.samples);
  declare_occlusion(app, a.occlusion);
  app.add_flag("--soft-filter", a.soft_filter,
               "of soft shadows and occlusion: averages over the pixels around, where they show the same surface");
  app.add_flag("--soft-accumulate", a.soft_accumulate,
               "likewise: averages over the last four masks that came, where they show the same surface");
  app.add_option(
         "--mode", a.mode,
         "sequential; queued: several cameras in flight; predicted: shows cameras whose masks have not come; "
         "auto: the same, as far ahead as pays; non-sequential: old masks as they are")
      ->type_name("MODE");
  app.add_option("--ahead", a.ahead, "frames predicted ahead in mode predicted")
      ->check(CLI::Range(size_t{0}, kMostAhead))
      ->type_name("X");
  app.add_option("--age-cost", a.cost_per_s, "in mode auto: share of wrong bits that a second of response is worth")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("SHARE");
  app.add_flag("--border-by-motion", a.border_by_motion, "more of the border on the side that the camera turns to");
  declare_rate(app, a.rate_hz, "cameras a second at most; 0: as the mode allows");
  app.add_option("--antialias", a.antialias,
                 "samples of each pixel that are shaded: 4x or none; if not given, 4x for pictures and videos that "
                 "are kept")
      ->type_name("4x|none");
  app.add_option("--out", a.out, "folder for pictures")->type_name("DIR");
  app.add_option("--pictures", a.pictures, "how many frames to keep")
      ->check(CLI::Range(1u, 10000u))
      ->type_name("N");
  app.add_option("--record", a.record, "a video of what was shown (H.264, through the program ffmpeg)")
      ->type_name("FILE.mp4");
  app.add_option(
         "--record-view", a.record_view,
         "of --record: shown; side-by-side, with what this machine traces itself; or their difference, times 4")
      ->type_name("VIEW");
  app.add_option("--view", a.view, "also pictures of what the tracer does: mask, bounds or lists; see below")
      ->type_name("VIEW");
  app.footer(debug_legend());
  app.add_option("--device", a.device, "this client's own Vulkan device: name, index or type")->type_name("NAME");
  declare_json(app, a.json);
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
  const bool soft = a.samples > 1 || a.occlusion != Occlusion::none;
  if (a.record.empty() && a.record_view != Arguments().record_view) return Error{"--record-view is of --record"};
  if ((a.soft_filter || a.soft_accumulate) && !soft) {
    return Error{
        "--soft-filter and --soft-accumulate are of soft light: --samples 4 or 16, or --occlusion half or full"};
  }

  FlightOptions flight;
  flight.mode = *mode;
  flight.ahead = a.ahead;
  flight.cost_per_s = a.cost_per_s;
  flight.border_by_motion = a.border_by_motion;
  flight.rate_hz = a.rate_hz;
  flight.frames = a.frames;
  flight.size = {size->width, size->height, border->width, border->height};
  if (flight.size.traced_width() > protocol::kMaxSide || flight.size.traced_height() > protocol::kMaxSide) {
    return Error{"picture and border together exceed " + std::to_string(protocol::kMaxSide) + " pixels"};
  }
  flight.interrupted = [] { return interrupted != 0; };
  flight.stream.answer_timeout = std::chrono::minutes(2);  // one step may take a CPU-only server long
  flight.stream.connect.server = *server;
  flight.stream.connect.trust = a.trust;
  const auto transport = parse_transport(a.transport);
  if (!transport) return transport.error();
  flight.stream.connect.transport = *transport;
  flight.stream.samples = {a.samples, a.occlusion};
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
  return flight;
}

Result<ClientRenderer::Options> drawing_options(const Arguments& a) {
  const std::string kept = a.out.empty() && a.record.empty() ? "none" : "4x";
  const std::string& wanted = a.antialias.empty() ? kept : a.antialias;
  if (wanted != "4x" && wanted != "none") return Error{"--antialias " + wanted + ": 4x or none is"};
  return ClientRenderer::Options{a.device, wanted == "4x" ? gpu::Samples::four : gpu::Samples::one, a.soft_filter,
                                 a.soft_accumulate};
}

// As flight_options(), and of what is only used later.
Result<FlightOptions> understood(const Arguments& a) {
  if (const auto drawn = drawing_options(a); !drawn) return drawn.error();
  if (const auto view = parse_record_view(a.record_view); !view) return view.error();
  if (!a.view.empty()) {
    if (const auto kind = parse_debug_kind(a.view); !kind) return kind.error();
    if (a.out.empty()) return Error{"--view needs --out: a folder for its pictures"};
  }
  return flight_options(a);
}

Report report_of(const Arguments& a, const FlightStats& f, uint64_t covered_words, const std::string& tracer) {
  const auto age_ms = [&](double share) { return to_milliseconds(f.ages.percentile(share)); };
  const auto ms = [&](double share) { return to_milliseconds(f.latencies.percentile(share)); };
  const std::string told = without_controls(tracer);
  Report report{.suite = "client", .device = device_of(told), .driver = told, .server = a.server};
  report.rows.push_back({{"scene", a.scene},
                         {"size", a.size},
                         {"border", a.border},
                         {"mode", a.mode},
                         {"samples", a.samples},
                         {"occlusion", to_string(a.occlusion)},
                         {"tenant", a.tenant},
                         {"interrupted", interrupted != 0},
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
                         {"late_slices", f.counters.late_slices},
                         {"unreadable_slices", f.counters.unreadable_slices},
                         {"covered_words", covered_words},
                         {"reconnects", f.reconnects},
                         {"shown", f.shown},
                         {"fps", f.fps()},
                         {"mean_x", f.mean_ahead()},
                         {"response_p50_ms", age_ms(0.5)},
                         {"response_p99_ms", age_ms(0.99)},
                         {"resumed", f.counters.resumed},
                         {"moves", f.counters.moved},
                         {"invalid_slices", f.counters.invalid_slices},
                         {"wrong_frames", f.counters.invalid_slices}});  // deprecated name
  return report;
}

// The view that --view asks for; nullopt without it.
Result<std::optional<DebugView>> debug_view(const Arguments& a, const scenes::ScenePtr& scene,
                                            const ViewSize& size) {
  if (a.view.empty()) return std::optional<DebugView>();
  const auto kind = parse_debug_kind(a.view);
  if (!kind) return kind.error();
  auto view = DebugView::create(scene, size, *kind, a.device);
  if (!view) return view.error();
  return std::optional<DebugView>(std::move(*view));
}

// The recording that --record asks for; nullopt without it.
Result<std::optional<Recording>> recording(const Arguments& a, const scenes::ScenePtr& scene, const ViewSize& size,
                                           const ClientRenderer::Options& own) {
  if (a.record.empty()) return std::optional<Recording>();
  const auto view = parse_record_view(a.record_view);
  if (!view) return view.error();
  constexpr double kUsualFps = 30;
  auto opened = Recording::open({a.record, *view, a.rate_hz > 0 ? a.rate_hz : kUsualFps, own}, scene, size);
  if (!opened) return opened.error();
  return std::optional<Recording>(std::move(*opened));
}

// Everything that draws. Created before the server is connected to, as creation takes long, and again if the server's
// operator moves parts of the scene.
struct Views {
  ClientRenderer own;
  gpu::Samples samples;
  std::optional<DebugView> debug;
  std::optional<Recording> video;
};

Result<Views> make_views(const Arguments& a, const scenes::ScenePtr& scene, const ViewSize& size) {
  const auto options = drawing_options(a);
  if (!options) return options.error();
  auto own = ClientRenderer::create(scene, size, *options);
  if (!own) return own.error();
  auto debug = debug_view(a, scene, size);
  if (!debug) return debug.error();
  auto video = recording(a, scene, size, *options);
  if (!video) return video.error();
  return Views{std::move(*own), options->samples, std::move(*debug), std::move(*video)};
}

// Makes scene and views anew if the server's operator moves parts of the scene. Error: it is another scene.
Result<void> match_server(const Arguments& a, const Flight& flight, const ViewSize& size, scenes::ScenePtr& scene,
                          Views& views) {
  if (const auto& motions = flight.welcome().motions; !motions.empty()) {
    auto moving = load_own_scene(a.scene, a.scene_folder, motions);
    if (!moving) return moving.error();
    scene = std::move(*moving);
    auto made = make_views(a, scene, size);
    if (!made) return made.error();
    views = std::move(*made);
  }
  return check_same_scene(*scene, flight.welcome().scene);
}

void print_files(const Arguments& a, const std::optional<Gallery>& gallery) {
  if (gallery) {
    for (const auto& file : gallery->files()) std::printf("picture     %s\n", file.c_str());
  }
  if (!a.record.empty()) std::printf("video       %s\n", a.record.c_str());
}

Result<std::optional<Gallery>> open_gallery(const Arguments& a, const scenes::Scene& scene) {
  if (a.out.empty()) return std::optional<Gallery>();
  std::vector<std::string> lights;
  for (const scenes::Light& light : scene.lights) lights.push_back(light.name);
  auto opened = Gallery::open(a.out, a.frames, a.pictures, std::move(lights));
  if (!opened) return opened.error();
  return std::optional<Gallery>(std::move(*opened));
}

Result<void> check_answers(const FlightStats& figures) {
  if (figures.frames() == 0) return Error{"no camera was answered"};
  if (figures.counters.invalid_slices > 0) return Error{"slices came that answer no camera or do not decode"};
  return {};
}

// Ends the recording, and says what was measured and written.
Result<void> report(const Arguments& a, const Flight& flight, Views& views, const std::optional<Gallery>& gallery) {
  if (views.video) {
    if (auto closed = views.video->close(); !closed) return closed;
  }
  const FlightStats figures = flight.figures();
  print_figures(figures);
  print_granted({a.samples, a.occlusion}, sample_counts_of(flight.welcome().samples));
  print_files(a, gallery);
  if (!a.json.empty()) {
    const auto written =
        write_report(a.json, report_of(a, figures, views.own.covered_words(), flight.welcome().tracer));
    if (!written) return written;
  }
  return check_answers(figures);
}

// Notes the exit status of a flight that ended early.
Result<void> ended(const Flight& flight, const Error& why, Exit& after_error) {
  if (flight.kept_out()) after_error = Exit::kept_out;
  return why;
}

Result<void> run(const Arguments& a, Exit& after_error) {
  after_error = Exit::wrong_usage;
  auto options = understood(a);
  if (!options) return options.error();
  after_error = Exit::failed;
  if (!a.token_file.empty()) {
    auto token = read_token(a.token_file);
    if (!token) return token.error();
    options->stream.connect.hello.token = std::move(*token);
  }
  Progress progress;
  WaitingLine waiting(progress, a.server);
  options->message = [&waiting](const protocol::Message& message) { waiting.heard(message); };
  auto scene = load_own_scene(a.scene, a.scene_folder);
  if (!scene) return scene.error();
  auto opened_gallery = open_gallery(a, **scene);
  if (!opened_gallery) return opened_gallery.error();
  std::optional<Gallery>& gallery = *opened_gallery;
  auto views = make_views(a, *scene, options->size);
  if (!views) return views.error();

  keep_on_interrupt();
  Flight flight(*options);
  const auto opened = flight.open();
  progress.clear();
  if (!opened) return ended(flight, opened.error(), after_error);
  if (auto same = match_server(a, flight, options->size, *scene, *views); !same) return same;

  const auto draw = [&](const Showing& showing) -> Result<void> {
    const bool kept = gallery && gallery->wants(showing.index);
    const bool seen_by_none = a.antialias.empty() && !kept && !views->video;
    const auto drawn = views->own.draw(showing, seen_by_none ? gpu::Samples::one : views->samples);
    if (!drawn) return drawn.error();
    const Picture shaded = views->video || kept ? copied(*drawn) : Picture();
    if (views->video) {
      if (auto added = views->video->add(showing, shaded); !added) return added;
    }
    if (options->mode == Mode::automatic) {
      const auto outcome = views->own.outcome(showing);
      if (!outcome) return outcome.error();
      if (*outcome) flight.observe((*outcome)->earlier, (*outcome)->later, (*outcome)->error);
    }
    if (!kept) return {};
    const auto seen = views->own.seen_by_lights(showing);
    if (!seen) return seen.error();
    if (auto added = gallery->add(showing.index, shaded, *seen); !added || !views->debug) return added;
    const auto pictures = views->debug->pictures(*showing.seen);
    if (!pictures) return pictures.error();
    return gallery->add_views(showing.index, a.view.c_str(), *pictures);
  };
  if (auto flown = flight.fly(CameraPath::of_scene(*scene), draw, progress); !flown) {
    return ended(flight, flown.error(), after_error);
  }
  progress.clear();
  if (interrupted) std::printf("interrupted: what follows is of the flight until then\n");
  flight.close();
  return report(a, flight, *views, gallery);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A thin client: rasterises and shades with visibility that a Gnomon daemon traced.",
               "gnomon-client");
  app.set_version_flag("--version", "gnomon-client " GNOMON_VERSION);
  return run_program(app, argc, argv, declare, run);
}
