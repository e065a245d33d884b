// Suite "growth": the time of a frame as a scene grows, over triangles with few lights and over lights with few
// triangles, and a plot of both.
#include <cmath>

#include "gpu/picture/blocking_frame.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/growth_plot.h"
#include "tests/bench/growth_scene.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

// The quantity that is varied, and the value of the other one meanwhile.
struct Sweep {
  std::vector<uint64_t> triangles;
  std::vector<uint32_t> lights;
};

struct Growth {
  Sweep triangles, lights;
};

const Growth kFull{{{10'000, 30'000, 100'000, 300'000, 1'000'000, 2'000'000, 5'000'000}, {4}},
                   {{100'000}, {1, 2, 4, 8, 16, 32, 64}}};
const Growth kQuick{{{3'000, 10'000}, {2}}, {{3'000}, {1, 4}}};

// Milliseconds of the passes from `first` to `last`.
double between(const gpu::FrameTiming& timing, std::string_view first, std::string_view last) {
  double ms = 0;
  bool within = false;
  for (const gpu::StageTime& stage : timing.stages) {
    within = within || stage.pass == first;
    if (within) ms += static_cast<double>(stage.gpu_ns) / 1e6;
    if (stage.pass == last) return ms;
  }
  return ms;
}

class GrowthSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--size", size_text_, "pixels of the traced picture")->capture_default_str();
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--tracer", tracer_, "as render.tracer of the configuration")->capture_default_str();
    command.add_option("--frames", frames_, "cameras, on a circle")->capture_default_str();
    command.add_option("--plot", plot_, "draw the curves into this file, .png or .svg (needs gnuplot)");
    command.add_flag("--quick", quick_, "few and small scenes: tries the suite, measures nothing of use");
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    size_ = *size;
    report_.suite = "growth";
    const Growth& growth = quick_ ? kQuick : kFull;
    GrowthCurves curves;
    if (auto r = measure("triangles", growth.triangles, curves.triangles); !r) return r.error();
    if (auto r = measure("lights", growth.lights, curves.lights); !r) return r.error();
    curves.caption = "one frame of " + size_text_ + ", " + tracer_ + ", " + report_.device + ": " +
                     std::to_string(growth.triangles.lights[0]) + " lights, or " +
                     std::to_string(growth.lights.triangles[0]) + " triangles";
    if (!plot_.empty())
      if (auto plotted = plot_growth(curves, plot_); !plotted) return plotted.error();
    return std::move(report_);
  }

 private:
  Result<void> measure(const std::string& axis, const Sweep& sweep, std::vector<GrowthPoint>& curve) {
    for (const uint64_t triangles : sweep.triangles)
      for (const uint32_t lights : sweep.lights) {
        say("growth of " + axis + ": " + std::to_string(triangles) + " triangles, " + std::to_string(lights) +
            " lights");
        auto point = measure_scene(axis, growth_scene(triangles, lights));
        if (!point) return point.error();
        curve.push_back(*point);
      }
    return {};
  }

  // Medians over the cameras. The second frame of each counts, as the first one warms up.
  Result<GrowthPoint> measure_scene(const std::string& axis, const scenes::ScenePtr& scene) {
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = tracer_;
    auto frame = gpu::BlockingFrame::create(options, options.passes, scene);
    if (!frame) return frame.error();
    report_.device = (*frame)->device().info().name;
    report_.driver = (*frame)->device().info().driver;
    const auto grid = (*frame)->reserve(size_.width, size_.height);
    if (!grid) return grid.error();
    std::vector<double> total, raster, trace, bytes;
    for (const gpu::CameraView& camera : cameras_along_path(*scene, std::max(1u, frames_), size_)) {
      if (auto warm = (*frame)->render(camera, *grid); !warm) return warm.error();
      const auto timing = (*frame)->render(camera, *grid);
      if (!timing) return timing.error();
      total.push_back(static_cast<double>(timing->total_ns) / 1e6);
      raster.push_back(between(*timing, timing->stages.front().pass, "gbuffer"));
      trace.push_back(between(*timing, "trace", "trace"));
      bytes.push_back(static_cast<double>((*frame)->packed(*grid).bytes()));
    }
    const gpu::ResidentScene& resident = (*frame)->scene();
    report_.rows.push_back({{"scene", scene->name},
                            {"axis", axis},
                            {"tracer", tracer_},
                            {"size", size_text_},
                            {"triangles", scene->triangle_count},
                            {"lights", scene->lights.size()},
                            {"ms", median(total)},
                            {"raster_ms", median(raster)},
                            {"trace_ms", median(trace)},
                            {"readback_bytes", median(bytes)},
                            {"build_ms", resident.traced().build_seconds * 1e3},
                            {"memory_bytes", resident.memory_bytes()}});
    const auto count = static_cast<double>(axis == "lights" ? scene->lights.size() : scene->triangle_count);
    return GrowthPoint{count, median(total), median(raster), median(trace)};
  }

  std::string size_text_ = "1280x720", device_, tracer_ = "auto", plot_;
  uint32_t frames_ = 3;
  bool quick_ = false;
  PictureSize size_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_growth_suite() { return std::make_unique<GrowthSuite>(); }

}  // namespace gnomon::bench
