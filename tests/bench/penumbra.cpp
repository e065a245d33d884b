// Suite "penumbra": how far soft shadows of k sample points are from a reference of 1,024, with and without the
// clients' filter. Embree answers all of it, so that the figures are those of the points and of the filter, not of a
// tracer.
#include <cmath>

#include "scenes/light_samples.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/parallel_rows.h"
#include "tests/bench/penumbra_filter.h"
#include "tests/bench/suites.h"
#include "tests/unit/gpu/embree_oracle.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;

constexpr uint32_t kReference = 1024;
constexpr std::array<uint32_t, 4> kCounts{1, 4, 16, 64};  // of the points of a pixel

// The shares of one light's points that each pixel sees, for each of kCounts, and of the reference.
struct LightShares {
  std::array<std::vector<float>, kCounts.size()> of_count;
  std::vector<float> reference;
  std::vector<uint8_t> cares;
};

struct Errors {
  double squares = 0, in_penumbra = 0;
  uint64_t pairs = 0, penumbra_pairs = 0;

  void add(float share, float reference) {
    const double square = (static_cast<double>(share) - reference) * (static_cast<double>(share) - reference);
    squares += square;
    ++pairs;
    if (reference <= 0.0f || reference >= 1.0f) return;
    in_penumbra += square;
    ++penumbra_pairs;
  }
  double rmse() const { return pairs ? std::sqrt(squares / static_cast<double>(pairs)) : 0; }
  double penumbra_rmse() const {
    return penumbra_pairs ? std::sqrt(in_penumbra / static_cast<double>(penumbra_pairs)) : 0;
  }
};

class PenumbraSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file whose lights have an extent")
        ->capture_default_str();
    command.add_option("--size", size_text_, "pixels of the traced picture")->capture_default_str();
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--frames", frames_, "cameras along the scene's path")->capture_default_str();
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    size_ = *size;
    report_.suite = "penumbra";
    for (const std::string& name : scenes_) {
      const auto scene = open_scene(name);
      if (!scene) return scene.error();
      if (auto measured = measure(*scene); !measured) return measured.error();
    }
    return std::move(report_);
  }

 private:
  Result<void> measure(const scenes::ScenePtr& scene) {
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = "bvh";  // its masks are not used
    auto probe = gpu::SurfaceProbe::create(options, scene);
    if (!probe) return probe.error();
    const test::EmbreeOracle oracle(scene, true);
    std::array<Errors, kCounts.size()> plain{}, filtered{};
    for (const gpu::CameraView& camera : cameras_along_path(*scene, std::max(1u, frames_), size_)) {
      say("  " + scene->name + ": a camera");
      const auto frame = probe->render(camera, size_.width, size_.height);
      if (!frame) return frame.error();
      for (const scenes::Light& light : scene->lights) {
        if (light.area.shape == scenes::LightShape::point) continue;
        add_errors(camera, *frame, trace(*scene, light, camera, *frame, oracle), plain, filtered);
      }
    }
    for (size_t k = 0; k < kCounts.size(); ++k) {
      report_.rows.push_back(
          {{"scene", scene->name},
           {"size", size_text_},
           {"k", kCounts[k]},
           {"rmse", plain[k].rmse()},
           {"rmse_filtered", filtered[k].rmse()},
           {"penumbra_rmse", plain[k].penumbra_rmse()},
           {"penumbra_rmse_filtered", filtered[k].penumbra_rmse()},
           {"penumbra_share", static_cast<double>(plain[k].penumbra_pairs) / static_cast<double>(plain[k].pairs)}});
    }
    return {};
  }

  LightShares trace(const scenes::Scene& scene, const scenes::Light& light, const gpu::CameraView& camera,
                    const gpu::ProbedFrame& frame, const test::EmbreeOracle& oracle) const {
    LightShares shares;
    const size_t pixels = size_t{size_.width} * size_.height;
    for (auto& of_count : shares.of_count) of_count.resize(pixels);
    shares.reference.resize(pixels);
    shares.cares.resize(pixels);
    const gpu::exact::TracedLight middle = gpu::traced_light(light, scene.bounds);
    std::array<std::vector<glm::vec3>, kCounts.size()> offsets;
    for (size_t k = 1; k < kCounts.size(); ++k) offsets[k] = scenes::sample_offsets(light.area, kCounts[k]);
    const std::vector<glm::vec3> all = scenes::sample_offsets(light.area, kReference / scenes::kSamplePatterns);
    for_rows(size_.height, [&](uint32_t y) {
      for (uint32_t x = 0; x < size_.width; ++x) {
        const size_t pixel = size_t{y} * size_.width + x;
        const gpu::SurfaceSample& sample = frame.samples[pixel];
        if (sample.triangle == 0) continue;
        const gpu::exact::SurfacePoint surface{sample.position, sample.normal};
        const gpu::exact::ShadowSegment hard = gpu::exact::shadow_segment(camera.position, surface, middle);
        if (!hard.traced) continue;
        shares.cares[pixel] = 1;
        const auto share = [&](std::span<const glm::vec3> points) {
          uint32_t seen = 0;
          for (const glm::vec3& offset : points) {
            const glm::vec3 point = middle.position + offset;
            seen += glm::dot(surface.normal, point - hard.origin) > 0.0f && !oracle.occluded(hard.origin, point);
          }
          return static_cast<float>(seen) / static_cast<float>(points.size());
        };
        shares.of_count[0][pixel] = oracle.occluded(hard.origin, middle.position) ? 0.0f : 1.0f;
        for (size_t k = 1; k < kCounts.size(); ++k) {
          const size_t first = size_t{scenes::sample_pattern(x, y)} * kCounts[k];
          shares.of_count[k][pixel] = share(std::span(offsets[k]).subspan(first, kCounts[k]));
        }
        shares.reference[pixel] = share(all);
      }
    });
    return shares;
  }

  void add_errors(const gpu::CameraView& camera, const gpu::ProbedFrame& frame, const LightShares& shares,
                  std::array<Errors, kCounts.size()>& plain, std::array<Errors, kCounts.size()>& filtered) const {
    for (size_t k = 0; k < kCounts.size(); ++k) {
      for (uint32_t y = 0; y < size_.height; ++y) {
        for (uint32_t x = 0; x < size_.width; ++x) {
          const size_t pixel = size_t{y} * size_.width + x;
          if (!shares.cares[pixel]) continue;
          plain[k].add(shares.of_count[k][pixel], shares.reference[pixel]);
          const auto neighbour = [&](int dx, int dy) -> PenumbraPixel {
            const int64_t nx = int64_t{x} + dx, ny = int64_t{y} + dy;
            if (nx < 0 || ny < 0 || nx >= size_.width || ny >= size_.height) return {};
            const size_t at = static_cast<size_t>(ny * size_.width + nx);
            const gpu::SurfaceSample& sample = frame.samples[at];
            return {sample.triangle != 0, shares.cares[at] != 0, sample.position, sample.normal,
                    shares.of_count[k][at]};
          };
          filtered[k].add(filtered_share(camera.position, neighbour), shares.reference[pixel]);
        }
      }
    }
  }

  std::vector<std::string> scenes_{"living_room", "temple"};
  std::string size_text_ = "480x270", device_;
  uint32_t frames_ = 3;
  PictureSize size_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_penumbra_suite() { return std::make_unique<PenumbraSuite>(); }

}  // namespace gnomon::bench
