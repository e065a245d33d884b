// Suite "occlusion": how far ambient occlusion of n segments a pixel is from a reference of 1,024, of all pixels and at
// half size, with and without the clients' filter. Embree answers all of it, so that the figures are those of the
// segments and of what clients fill in, not of a tracer; but what accumulates over frames is traced on the device and read
// back from the client's pictures.
#include <cmath>

#include "scenes/light_samples.h"
#include "tests/bench/client_shares.h"
#include "tests/bench/embree_shares.h"
#include "tests/bench/parallel_rows.h"
#include "tests/bench/penumbra_filter.h"
#include "tests/bench/share_suite.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {
namespace {

constexpr uint32_t kReference = 1024;

struct Error {
  double squares = 0;
  uint64_t pixels = 0;

  void add(float share, float reference) {
    squares += (static_cast<double>(share) - reference) * (static_cast<double>(share) - reference);
    ++pixels;
  }
  double rmse() const { return pixels ? std::sqrt(squares / static_cast<double>(pixels)) : 0; }
};

// What clients shade with.
enum Shown : size_t {
  all_pixels,
  all_filtered,
  half_size,
  half_filtered,
  all_accumulated,
  all_accumulated_filtered,
  half_accumulated,
  half_accumulated_filtered,
  kShown
};
constexpr std::array<const char*, kShown> kNames{"full",
                                                 "full, filtered",
                                                 "half",
                                                 "half, filtered",
                                                 "full, accumulated",
                                                 "full, accumulated, filtered",
                                                 "half, accumulated",
                                                 "half, accumulated, filtered"};

// The share of open segments of each pixel that shows a surface, and of the reference.
struct Shares {
  std::vector<float> own, reference;
};

class OcclusionSuite : public ShareSuite {
 public:
  OcclusionSuite() : ShareSuite("occlusion", "built-in name or glTF file") {}

 private:
  Result<void> measure(const scenes::ScenePtr& scene) override {
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = "bvh";  // its masks are not used
    auto probe = gpu::SurfaceProbe::create(options, scene);
    if (!probe) return probe.error();
    const test::EmbreeOracle oracle(scene, true);
    auto client = ClientShares::create(device_, scene);
    if (!client) return client.error();
    std::array<Error, kShown> errors{};
    double open = 0;
    for (uint32_t i = 0; i < frames_; ++i) {
      say("  " + scene->name + ": a camera");
      const double seconds = seconds_of(*scene, i);
      const gpu::CameraView camera = camera_on_path(*scene, seconds, size_);
      const auto frame = probe->render(camera, size_.width, size_.height);
      if (!frame) return frame.error();
      const Shares shares = trace(*scene, camera, *frame, oracle);
      for (uint32_t y = 0; y < size_.height; ++y)
        for (uint32_t x = 0; x < size_.width; ++x) add_errors(camera, *frame, shares, x, y, errors, open);
      if (auto added = add_accumulated(*client, *probe, seconds, *frame, shares, errors); !added) return added;
    }
    for (size_t shown = 0; shown < kShown; ++shown) {
      report_.rows.push_back({{"scene", scene->name},
                              {"size", size_text_},
                              {"segments", kOcclusionSegments},
                              {"of", kNames[shown]},
                              {"rmse", errors[shown].rmse()},
                              {"mean_open", open / static_cast<double>(errors[shown].pixels)}});
    }
    return {};
  }

  Shares trace(const scenes::Scene& scene, const gpu::CameraView& camera, const gpu::ProbedFrame& frame,
               const test::EmbreeOracle& oracle) const {
    const std::vector<glm::vec3> own = scenes::occlusion_points();
    const std::vector<glm::vec3> all = scenes::occlusion_points(kReference / scenes::kSamplePatterns);
    const float radius = scenes::occlusion_radius(scene);
    Shares shares;
    shares.own.resize(frame.samples.size());
    shares.reference.resize(frame.samples.size());
    for_rows(size_.height, [&](uint32_t y) {
      for (uint32_t x = 0; x < size_.width; ++x) {
        const gpu::SurfaceSample& sample = frame.surface_at(x, y);
        if (sample.triangle == 0) continue;
        const auto share = [&](std::span<const glm::vec3> points) {
          return open_share(oracle, camera, sample, points, radius);
        };
        const size_t first = size_t{scenes::sample_pattern(x, y)} * kOcclusionSegments;
        shares.own[size_t{y} * size_.width + x] = share(std::span(own).subspan(first, kOcclusionSegments));
        if (compared(x, y)) shares.reference[size_t{y} * size_.width + x] = share(all);
      }
    });
    return shares;
  }

  // What a client fills in for the pixel: the weighted mean over those of the window around it that show the same surface
  // and count. `reach`: how far the window goes.
  float filled(const gpu::CameraView& camera, const gpu::ProbedFrame& frame, const Shares& shares, uint32_t x,
               uint32_t y, int reach, bool half) const {
    const auto at = [&](int64_t px, int64_t py) -> PenumbraPixel {
      if (px < 0 || py < 0 || px >= size_.width || py >= size_.height) return {};
      const gpu::SurfaceSample& s = frame.surface_at(static_cast<uint32_t>(px), static_cast<uint32_t>(py));
      return {s.triangle != 0, true, s.position, s.normal, shares.own[static_cast<size_t>(py * size_.width + px)]};
    };
    const PenumbraPixel here = at(x, y);
    float sum = 0, weights = 0;
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) {
        const int64_t px = int64_t{x} + dx, py = int64_t{y} + dy;
        if (half && ((px | py) & 1) != 0) continue;
        const PenumbraPixel other = at(px, py);
        if ((dx != 0 || dy != 0) && !same_surface(here, other, camera.position)) continue;
        const float weight = (std::abs(dx) == 2 ? 1.0f : 2.0f) * (std::abs(dy) == 2 ? 1.0f : 2.0f);
        sum += weight * other.seen;
        weights += weight;
      }
    return weights > 0 ? sum / weights : 1.0f;
  }

  void add_errors(const gpu::CameraView& camera, const gpu::ProbedFrame& frame, const Shares& shares, uint32_t x,
                  uint32_t y, std::array<Error, kShown>& errors, double& open) const {
    if (frame.surface_at(x, y).triangle == 0 || !compared(x, y)) return;
    const size_t pixel = size_t{y} * size_.width + x;
    const float reference = shares.reference[pixel], own = shares.own[pixel];
    const bool counts = ((x | y) & 1) == 0;
    open += reference;
    errors[all_pixels].add(own, reference);
    errors[all_filtered].add(filled(camera, frame, shares, x, y, 2, false), reference);
    errors[half_size].add(counts ? own : filled(camera, frame, shares, x, y, 1, true), reference);
    errors[half_filtered].add(filled(camera, frame, shares, x, y, 2, true), reference);
  }

  Result<void> add_accumulated(ClientShares& client, gpu::SurfaceProbe& probe, double seconds,
                               const gpu::ProbedFrame& frame, const Shares& shares,
                               std::array<Error, kShown>& errors) const {
    for (const Occlusion occlusion : {Occlusion::full, Occlusion::half}) {
      if (auto seen = client.see(probe, seconds, size_, {1, occlusion}); !seen) return seen;
      for (const bool filtered : {false, true}) {
        const auto shown = client.of_ambient({.accumulated = true, .filtered = filtered});
        if (!shown) return shown.error();
        const size_t first = occlusion == Occlusion::full ? all_accumulated : half_accumulated;
        for (size_t pixel = 0; pixel < shown->size(); ++pixel)
          if (frame.samples[pixel].triangle != 0 &&
              compared(static_cast<uint32_t>(pixel % size_.width), static_cast<uint32_t>(pixel / size_.width)))
            errors[first + filtered].add((*shown)[pixel], shares.reference[pixel]);
      }
    }
    return {};
  }
};

}  // namespace

std::unique_ptr<Suite> make_occlusion_suite() { return std::make_unique<OcclusionSuite>(); }

}  // namespace gnomon::bench
