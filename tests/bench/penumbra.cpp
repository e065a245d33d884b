// Suite "penumbra": how far soft shadows of k sample points are from a reference of 1,024, with and without the
// clients' filter. Embree answers all of it, so that the figures are those of the points and of the filter, not of a
// tracer; but what accumulates over frames is traced on the device and read back from the client's pictures.
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

using nlohmann::ordered_json;

constexpr uint32_t kReference = 1024;
constexpr std::array<uint32_t, 4> kCounts{1, 4, 16, 64};  // of the points of a pixel
constexpr std::array<size_t, 2> kServed{1, 2};            // those of them that masks have

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

// Of one of kCounts.
struct CountErrors {
  Errors plain, filtered;
  Errors accumulated, accumulated_filtered;  // of kServed alone
};
using AllErrors = std::array<CountErrors, kCounts.size()>;

class PenumbraSuite : public ShareSuite {
 public:
  PenumbraSuite() : ShareSuite("penumbra", "built-in name or glTF file whose lights have an extent") {}

 private:
  Result<void> measure(const scenes::ScenePtr& scene) override {
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = "bvh";  // its masks are not used
    auto probe = gpu::SurfaceProbe::create(options, scene);
    if (!probe) return probe.error();
    const test::EmbreeOracle oracle(scene, true);
    std::vector<ClientShares> clients;  // of kServed
    for (size_t i = 0; i < kServed.size(); ++i) {
      auto client = ClientShares::create(device_, scene);
      if (!client) return client.error();
      clients.push_back(std::move(*client));
    }
    AllErrors errors{};
    for (uint32_t i = 0; i < frames_; ++i) {
      say("  " + scene->name + ": a camera");
      const double seconds = seconds_of(*scene, i);
      const gpu::CameraView camera = camera_on_path(*scene, seconds, size_);
      const auto frame = probe->render(camera, size_.width, size_.height);
      if (!frame) return frame.error();
      for (size_t served = 0; served < kServed.size(); ++served)
        if (auto seen = clients[served].see(*probe, seconds, size_, kCounts[kServed[served]]); !seen) return seen;
      for (uint32_t light = 0; light < scene->lights.size(); ++light) {
        if (scene->lights[light].area.shape == scenes::LightShape::point) continue;
        const LightShares shares = trace(*scene, scene->lights[light], camera, *frame, oracle);
        add_errors(camera, *frame, shares, errors);
        if (auto added = add_accumulated(clients, light, shares, errors); !added) return added;
      }
    }
    add_rows(*scene, errors);
    return {};
  }

  void add_rows(const scenes::Scene& scene, const AllErrors& errors) {
    for (size_t k = 0; k < kCounts.size(); ++k) {
      const CountErrors& of = errors[k];
      ordered_json row{
          {"scene", scene.name},
          {"size", size_text_},
          {"k", kCounts[k]},
          {"rmse", of.plain.rmse()},
          {"rmse_filtered", of.filtered.rmse()},
          {"rmse_accumulated", nullptr},
          {"rmse_accumulated_filtered", nullptr},
          {"penumbra_rmse", of.plain.penumbra_rmse()},
          {"penumbra_rmse_filtered", of.filtered.penumbra_rmse()},
          {"penumbra_share", static_cast<double>(of.plain.penumbra_pairs) / static_cast<double>(of.plain.pairs)}};
      if (of.accumulated.pairs > 0) {
        row["rmse_accumulated"] = of.accumulated.rmse();
        row["rmse_accumulated_filtered"] = of.accumulated_filtered.rmse();
      }
      report_.rows.push_back(std::move(row));
    }
  }

  Result<void> add_accumulated(std::vector<ClientShares>& clients, uint32_t light, const LightShares& shares,
                               AllErrors& errors) const {
    for (size_t served = 0; served < kServed.size(); ++served) {
      CountErrors& of = errors[kServed[served]];
      for (const bool filtered : {false, true}) {
        const auto shown = clients[served].of_light(light, {.accumulated = true, .filtered = filtered});
        if (!shown) return shown.error();
        for (size_t pixel = 0; pixel < shown->size(); ++pixel)
          if (shares.cares[pixel] &&
              compared(static_cast<uint32_t>(pixel % size_.width), static_cast<uint32_t>(pixel / size_.width)))
            (filtered ? of.accumulated_filtered : of.accumulated).add((*shown)[pixel], shares.reference[pixel]);
      }
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
          return seen_share(oracle, surface.normal, hard.origin, middle.position, points);
        };
        shares.of_count[0][pixel] = oracle.occluded(hard.origin, middle.position) ? 0.0f : 1.0f;
        for (size_t k = 1; k < kCounts.size(); ++k) {
          const size_t first = size_t{scenes::sample_pattern(x, y)} * kCounts[k];
          shares.of_count[k][pixel] = share(std::span(offsets[k]).subspan(first, kCounts[k]));
        }
        if (compared(x, y)) shares.reference[pixel] = share(all);
      }
    });
    return shares;
  }

  void add_errors(const gpu::CameraView& camera, const gpu::ProbedFrame& frame, const LightShares& shares,
                  AllErrors& errors) const {
    for (size_t k = 0; k < kCounts.size(); ++k) {
      for (uint32_t y = 0; y < size_.height; ++y) {
        for (uint32_t x = 0; x < size_.width; ++x) {
          const size_t pixel = size_t{y} * size_.width + x;
          if (!shares.cares[pixel] || !compared(x, y)) continue;
          errors[k].plain.add(shares.of_count[k][pixel], shares.reference[pixel]);
          const auto neighbour = [&](int dx, int dy) -> PenumbraPixel {
            const int64_t nx = int64_t{x} + dx, ny = int64_t{y} + dy;
            if (nx < 0 || ny < 0 || nx >= size_.width || ny >= size_.height) return {};
            const size_t at = static_cast<size_t>(ny * size_.width + nx);
            const gpu::SurfaceSample& sample = frame.samples[at];
            return {sample.triangle != 0, shares.cares[at] != 0, sample.position, sample.normal,
                    shares.of_count[k][at]};
          };
          errors[k].filtered.add(filtered_share(camera.position, neighbour), shares.reference[pixel]);
        }
      }
    }
  }
};

}  // namespace

std::unique_ptr<Suite> make_penumbra_suite() { return std::make_unique<PenumbraSuite>(); }

}  // namespace gnomon::bench
