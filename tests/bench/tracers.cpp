// Suite "tracers": the shadow stage of every tracer by the device's timestamps within frames that follow each other, compared
// in the same run and over the same surface points with Embree's occluded16 with coherent packets on two threads.
#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "common/clock.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/scratch_folder.h"
#include "tests/bench/steady_times.h"
#include "tests/bench/suites.h"
#include "tests/unit/gpu/embree_oracle.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;
using test::EmbreeOracle;
using test::EmbreeQuery;

constexpr unsigned kEmbreeThreads = 2;
constexpr int kRasterRepeats = 3;  // the fastest one counts

// Embree's results for one camera's surface points: the reference by robust single rays, and the time of the packets.
struct PeerFrame {
  std::vector<uint64_t> oracle;
  std::vector<uint64_t> valid_bits;  // the bits that were traced; the other bits of the frame do not matter
  std::vector<uint64_t> packets;
  double ms = 0;
  uint64_t bits = 0;  // pixels with a surface times lights
};

uint64_t differing_bits(const std::vector<uint64_t>& a, const std::vector<uint64_t>& b) {
  uint64_t bits = 0;
  for (size_t i = 0; i < a.size(); ++i) bits += static_cast<uint64_t>(__builtin_popcountll(a[i] ^ b[i]));
  return bits;
}

// Medians over the cameras.
struct Series {
  std::vector<double> ms, mvis_per_s, ratio;
  uint64_t differing = 0, bits = 0;

  void add(double frame_ms, const PeerFrame& peer) {
    ms.push_back(frame_ms);
    mvis_per_s.push_back(static_cast<double>(peer.bits) / frame_ms / 1e3);
    ratio.push_back(peer.ms / frame_ms);
    bits += peer.bits;
  }
  double diff_ppm() const { return bits ? 1e6 * static_cast<double>(differing) / static_cast<double>(bits) : 0; }
};

class TracersSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file; default: all that are there");
    command.add_option("--size", size_text_, "pixels of the traced picture")->capture_default_str();
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--frames", frames_, "cameras along the scene's path")->capture_default_str();
    command.add_option("--tracer", tracers_, "tracers to measure; default: all that the device offers");
    command.add_option("--light-buffer-mb", light_buffer_mb_, "memory of a scene's light buffers; 0: the default");
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    size_ = *size;
    report_.suite = "tracers";
    if (scenes_.empty()) scenes_ = default_scenes();
    for (const std::string& name : scenes_) {
      say("scene " + name + ": loading");
      const auto scene = open_scene(name);
      if (!scene) return scene.error();
      if (auto measured = measure(*scene); !measured) return measured.error();
    }
    return std::move(report_);
  }

 private:
  gpu::RendererOptions options(const std::string& tracer) const {
    gpu::RendererOptions out;
    out.device = device_;
    out.tracer = tracer;
    out.tracer_options.cache_folder = cache_.path();
    out.tracer_options.light_buffer_bytes = uint64_t{light_buffer_mb_} << 20;
    return out;
  }

  // The build time of a second start; nothing for tracers without a cache.
  Result<ordered_json> cached_build_ms(const scenes::ScenePtr& scene, const std::string& tracer) const {
    const auto again = gpu::SurfaceProbe::create(options(tracer), scene);
    if (!again) return again.error();
    const gpu::TracedScene& traced = again->scene().traced();
    return traced.list_statistics.from_cache ? ordered_json(traced.build_seconds * 1e3) : ordered_json(nullptr);
  }

  Result<void> measure(const scenes::ScenePtr& scene) {
    const std::vector<gpu::CameraView> cameras = cameras_along_path(*scene, std::max(1u, frames_), size_);
    std::vector<PeerFrame> peers;
    if (auto r = measure_embree(scene, cameras, peers); !r) return r;
    for (const std::string& tracer : tracers_)
      if (auto r = measure_tracer(scene, tracer, cameras, peers); !r) return r;
    if (auto r = measure_raster(scene, cameras); !r) return r;
    return measure_frame(scene, cameras, peers);
  }

  Result<void> measure_embree(const scenes::ScenePtr& scene, const std::vector<gpu::CameraView>& cameras,
                              std::vector<PeerFrame>& peers) {
    say("  embree16");
    auto probe = gpu::SurfaceProbe::create(options("bvh"), scene);  // its masks are not used
    if (!probe) return probe.error();
    report_.device = probe->device().info().name;
    report_.driver = probe->device().info().driver;
    const EmbreeOracle oracle(scene, true), peer(scene, false);
    Series series;
    for (const gpu::CameraView& camera : cameras) {
      const auto frame = probe->render(camera, size_.width, size_.height);
      if (!frame) return frame.error();
      PeerFrame out;
      for (const gpu::SurfaceSample& sample : frame->samples) out.bits += sample.triangle != 0;
      out.bits *= frame->grid.planes;
      out.valid_bits = frame->valid_bits;
      out.oracle = oracle.trace(camera, frame->grid, frame->samples, EmbreeQuery::single, kEmbreeThreads);
      const TimePoint start = Clock::now();
      out.packets = peer.trace(camera, frame->grid, frame->samples, EmbreeQuery::packets16, kEmbreeThreads);
      out.ms = to_milliseconds(Clock::now() - start);
      series.add(out.ms, out);
      series.differing += differing_bits(out.packets, out.oracle);
      peers.push_back(std::move(out));
    }
    ordered_json row = row_of(*scene, "embree16", series);
    row["build_ms"] = peer.build_seconds() * 1e3;
    report_.rows.push_back(std::move(row));
    return {};
  }

  Result<void> measure_tracer(const scenes::ScenePtr& scene, const std::string& tracer,
                              const std::vector<gpu::CameraView>& cameras, const std::vector<PeerFrame>& peers) {
    auto probe = gpu::SurfaceProbe::create(options(tracer), scene);
    if (!probe) {
      say("  " + tracer + ": skipped, " + probe.error().message);
      return {};
    }
    const gpu::RendererOptions like = options(tracer);
    auto timed = gpu::BlockingFrame::create(like, like.passes, scene);
    if (!timed) return timed.error();
    const auto grid = (*timed)->reserve(size_.width, size_.height);
    if (!grid) return grid.error();
    // The first frame compiles shaders and is not counted.
    if (auto warm = (*timed)->render(cameras[0], *grid); !warm) return warm.error();
    Series series;
    for (size_t i = 0; i < cameras.size(); ++i) {
      say("  " + tracer + ": camera " + std::to_string(i + 1) + " of " + std::to_string(cameras.size()));
      const auto times = steady_times(**timed, cameras[i], *grid);
      if (!times) return times.error();
      const auto frame = probe->render(cameras[i], size_.width, size_.height);
      if (!frame) return frame.error();
      series.add(times->shadow_stage_ms(), peers[i]);
      series.differing += differing_bits(frame->words, peers[i].oracle);
    }
    ordered_json row = row_of(*scene, tracer, series);
    row["build_ms"] = probe->scene().traced().build_seconds * 1e3;
    row["memory_bytes"] = probe->scene().traced().memory_bytes();
    auto cached = cached_build_ms(scene, tracer);
    if (!cached) return cached.error();
    row["cached_build_ms"] = std::move(*cached);
    report_.rows.push_back(std::move(row));
    return {};
  }

  // The G-buffer with culling and without; measured alternately, so that both run under the same conditions.
  Result<void> measure_raster(const scenes::ScenePtr& scene, const std::vector<gpu::CameraView>& cameras) {
    const std::array<std::string, 2> rows{"raster_all", "raster_culled"}, passes{"gbuffer_all", "gbuffer"};
    std::array<std::unique_ptr<gpu::BlockingFrame>, 2> frames;
    std::array<std::vector<double>, 2> ms;
    for (size_t k = 0; k < 2; ++k) {
      auto frame = gpu::BlockingFrame::create(options("auto"), {passes[k]}, scene);
      if (!frame) return frame.error();
      frames[k] = std::move(*frame);
    }
    for (const gpu::CameraView& camera : cameras) {
      std::array<double, 2> best{};
      for (int repeat = 0; repeat <= kRasterRepeats; ++repeat)
        for (size_t k = 0; k < 2; ++k) {
          const auto grid = frames[k]->reserve(size_.width, size_.height);
          if (!grid) return grid.error();
          const auto timing = frames[k]->render(camera, *grid);
          if (!timing) return timing.error();
          const double took = static_cast<double>(timing->total_ns) / 1e6;
          if (repeat > 0) best[k] = best[k] > 0 ? std::min(best[k], took) : took;  // the first one warms up
        }
      for (size_t k = 0; k < 2; ++k) ms[k].push_back(best[k]);
    }
    for (size_t k = 0; k < 2; ++k)
      report_.rows.push_back({{"scene", scene->name},
                              {"tracer", rows[k]},
                              {"size", size_text_},
                              {"triangles", scene->triangle_count},
                              {"ms", median(ms[k])},
                              {"ratio_to_raster_all", median(ms[0]) / median(ms[k])}});
    return {};
  }

  // The complete frame as the daemon renders it: default passes, default tracer.
  Result<void> measure_frame(const scenes::ScenePtr& scene, const std::vector<gpu::CameraView>& cameras,
                             const std::vector<PeerFrame>& peers) {
    say("  frame");
    const gpu::RendererOptions defaults = options("auto");
    auto frame = gpu::BlockingFrame::create(defaults, defaults.passes, scene);
    if (!frame) return frame.error();
    const auto grid = (*frame)->reserve(size_.width, size_.height);
    if (!grid) return grid.error();
    if (auto warm = (*frame)->render(cameras[0], *grid); !warm) return warm.error();
    Series series;
    std::vector<double> readback_bytes, to_shadow_stage;
    std::map<std::string, std::vector<double>> stages;
    for (size_t i = 0; i < cameras.size(); ++i) {
      const auto times = steady_times(**frame, cameras[i], *grid);
      if (!times) return times.error();
      series.add(times->frame_ms, peers[i]);
      to_shadow_stage.push_back(times->frame_ms / times->shadow_stage_ms());
      for (const auto& [pass, ms] : times->stage_ms) stages[pass].push_back(ms);
      const PackedMaskView packed = (*frame)->packed(*grid);
      std::vector<uint64_t> words = unpacked(packed);
      for (size_t w = 0; w < words.size(); ++w) words[w] &= peers[i].valid_bits[w];
      series.differing += differing_bits(words, peers[i].oracle);
      readback_bytes.push_back(static_cast<double>(packed.bytes()));
    }
    ordered_json row = row_of(*scene, "frame", series);
    row["readback_bytes"] = median(readback_bytes);
    row["ratio_to_shadow_stage"] = median(to_shadow_stage);
    row["memory_bytes"] = (*frame)->scene().memory_bytes();
    for (const auto& [pass, ms] : stages) row["stages_ms"][pass] = median(ms);
    report_.rows.push_back(std::move(row));
    return {};
  }

  ordered_json row_of(const scenes::Scene& scene, const std::string& tracer, const Series& series) const {
    return {{"scene", scene.name},
            {"tracer", tracer},
            {"size", size_text_},
            {"lights", scene.lights.size()},
            {"triangles", scene.triangle_count},
            {"ms", median(series.ms)},
            {"mvis_per_s", median(series.mvis_per_s)},
            {"ratio_to_embree16", median(series.ratio)},
            {"diff_ppm_embree", series.diff_ppm()},
            {"build_ms", nullptr},
            {"cached_build_ms", nullptr},
            {"memory_bytes", nullptr}};
  }

  std::vector<std::string> scenes_;
  std::string size_text_ = "1920x1080";
  std::string device_;
  ScratchFolder cache_;  // a scene's first build computes its light buffers, the next one reads them from disk
  uint32_t frames_ = 5;
  std::vector<std::string> tracers_{"light_buffer", "bvh", "ray_query"};
  uint32_t light_buffer_mb_ = 0;
  PictureSize size_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_tracers_suite() { return std::make_unique<TracersSuite>(); }

}  // namespace gnomon::bench
