#include "tests/unit/gpu/brute_force.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>

#include "gpu/scene/resident_scene.h"
#include "scenes/light_samples.h"
#include "scenes/world_mesh.h"

namespace gnomon::test {

using namespace gpu;

namespace {

// The scene that was asked for last, and what was found of its segments: frames of all tracers and sample counts ask for
// the same ones again.
class BruteForce {
 public:
  static BruteForce& of(const scenes::Scene& scene) {
    static BruteForce last;
    scenes::WorldMesh mesh = scenes::build_world_mesh(scene);
    if (mesh.positions != last.mesh_.positions || mesh.triangles != last.mesh_.triangles) {
      last.mesh_ = std::move(mesh);
      last.found_.clear();
    }
    return last;
  }

  bool free(const exact::ShadowSegment& segment) {
    const auto [found, is_new] = found_.try_emplace(bits_of(segment));
    if (is_new) found->second = !meets_any(segment);
    return found->second;
  }

 private:
  using Bits = std::array<uint32_t, 6>;
  struct Hash {
    size_t operator()(const Bits& bits) const {
      uint64_t hash = 0;
      for (const uint32_t word : bits) hash = std::rotl((hash ^ word) * 0x9e3779b97f4a7c15u, 29);
      return hash;
    }
  };

  static Bits bits_of(const exact::ShadowSegment& segment) {
    Bits bits{};
    for (int i = 0; i < 3; ++i) {
      bits[static_cast<size_t>(i)] = std::bit_cast<uint32_t>(segment.origin[i]);
      bits[static_cast<size_t>(3 + i)] = std::bit_cast<uint32_t>(segment.direction[i]);
    }
    return bits;
  }

  bool meets_any(const exact::ShadowSegment& segment) const {
    return std::any_of(mesh_.triangles.begin(), mesh_.triangles.end(), [&](const glm::uvec3& t) {
      return exact::segment_meets_triangle(segment.origin, segment.direction, mesh_.positions[t.x],
                                           mesh_.positions[t.y], mesh_.positions[t.z]);
    });
  }

  scenes::WorldMesh mesh_;
  std::unordered_map<Bits, bool, Hash> found_;
};

bool lit_by_brute_force(BruteForce& force, const CameraView& camera, const SurfaceSample& sample,
                        const exact::TracedLight& light) {
  const auto segment = exact::shadow_segment(camera.position, {sample.position, sample.normal}, light);
  return segment.traced && force.free(segment);
}

// nullopt if the pair is not asked.
std::optional<uint32_t> seen_by_brute_force(BruteForce& force, const CameraView& camera,
                                            const SurfaceSample& sample, const exact::TracedLight& light,
                                            std::span<const glm::vec3> offsets) {
  if (sample.triangle == 0) return std::nullopt;
  const auto middle = exact::shadow_segment(camera.position, {sample.position, sample.normal}, light);
  if (!middle.traced) return std::nullopt;
  uint32_t seen = 0;
  for (const glm::vec3& offset : offsets) {
    const auto segment = exact::sample_segment(middle.origin, sample.normal, light.position + offset);
    seen += segment.traced && force.free(segment);
  }
  return seen;
}

PlaneBits bits_of(const ProbedFrame& frame, uint32_t x, uint32_t y, uint32_t first_plane, uint32_t planes) {
  PlaneBits found;
  for (uint32_t i = 0; i < planes; ++i) {
    found.mask |= uint32_t{frame.mask().lit(x, y, first_plane + i)} << i;
    found.valid |= uint32_t{frame.care().lit(x, y, first_plane + i)} << i;
  }
  return found;
}

}  // namespace

Count compare(const scenes::Scene& scene, const CameraView& camera, const ProbedFrame& frame) {
  BruteForce& force = BruteForce::of(scene);
  Count count;
  for (uint32_t y = 0; y < frame.grid.height; ++y)
    for (uint32_t x = 0; x < frame.grid.width; ++x) {
      const SurfaceSample& sample = frame.samples[size_t{y} * frame.grid.width + x];
      count.surfaces += sample.triangle != 0;
      for (uint32_t i = 0; i < frame.grid.planes; ++i) {
        const bool expected =
            sample.triangle != 0 &&
            lit_by_brute_force(force, camera, sample, traced_light(scene.lights[i], scene.bounds));
        (expected ? count.lit : count.dark) += sample.triangle != 0;
        count.differing += expected != frame.mask().lit(x, y, i);
      }
    }
  return count;
}

LightPlanes planes_of(const scenes::Scene& scene, SampleCounts samples) {
  std::vector<bool> areas;
  for (const scenes::Light& light : scene.lights) areas.push_back(light.area.shape != scenes::LightShape::point);
  return {areas, samples};
}

PlaneBits plane_bits(std::optional<uint32_t> seen, uint32_t samples) {
  if (!seen) return {};
  const uint32_t planes = gnomon::planes_of(samples);
  if (*seen == samples) return {1, 1};
  PlaneBits bits{0, (1u << planes) - 1};
  for (uint32_t plane = 1; plane < planes; ++plane) bits.mask |= (*seen >> (planes - 1 - plane) & 1) << plane;
  return bits;
}

SoftCount compare_soft(const scenes::Scene& scene, const CameraView& camera, const ProbedFrame& frame) {
  BruteForce& force = BruteForce::of(scene);
  const LightPlanes planes = planes_of(scene, frame.counts);
  SoftCount count;
  for (uint32_t light = 0; light < planes.light_count(); ++light) {
    const uint32_t samples = planes.samples(light);
    const std::vector<glm::vec3> offsets = samples > 1 ? scenes::sample_offsets(scene.lights[light].area, samples)
                                                       : std::vector<glm::vec3>(scenes::kSamplePatterns);
    const exact::TracedLight traced = traced_light(scene.lights[light], scene.bounds);
    for (uint32_t y = 0; y < frame.grid.height; ++y)
      for (uint32_t x = 0; x < frame.grid.width; ++x) {
        const SurfaceSample& sample = frame.surface_at(x, y);
        const auto of_pixel = std::span(offsets).subspan(scenes::sample_pattern(x, y) * samples, samples);
        std::optional<uint32_t> seen = seen_by_brute_force(force, camera, sample, traced, of_pixel);
        if (samples == 1 && seen) seen = lit_by_brute_force(force, camera, sample, traced) ? 1 : 0;
        const PlaneBits expected = plane_bits(seen, samples);
        const PlaneBits found = bits_of(frame, x, y, planes.first(light), planes.count(light));
        count.differing += found.mask != expected.mask || found.valid != expected.valid;
        if (!seen) continue;
        ++count.asked;
        ++(*seen == samples ? count.lit : *seen == 0 ? count.dark : count.penumbrae);
      }
  }
  return count;
}

OcclusionCount compare_occlusion(const scenes::Scene& scene, const CameraView& camera, const ProbedFrame& frame) {
  BruteForce& force = BruteForce::of(scene);
  const LightPlanes planes = planes_of(scene, frame.counts);
  const std::vector<glm::vec3> points = scenes::occlusion_points();
  const float radius = scenes::occlusion_radius(scene);
  OcclusionCount count;
  for (uint32_t y = 0; y < frame.grid.height; ++y)
    for (uint32_t x = 0; x < frame.grid.width; ++x) {
      const SurfaceSample& sample = frame.surface_at(x, y);
      std::optional<uint32_t> open;
      if (sample.triangle != 0 && planes.counts_occlusion(x, y)) {
        open = 0;
        const glm::vec3 origin = exact::segment_origin(camera.position, {sample.position, sample.normal});
        const size_t first = size_t{scenes::sample_pattern(x, y)} * kOcclusionSegments;
        for (size_t i = first; i < first + kOcclusionSegments; ++i) {
          const auto segment = exact::occlusion_segment(origin, sample.normal, points[i], radius);
          *open += !segment.traced || force.free(segment);
        }
        ++count.counted;
        ++(*open == kOcclusionSegments ? count.open : *open == 0 ? count.enclosed : count.partly);
      }
      const PlaneBits expected = plane_bits(open, kOcclusionSegments);
      const PlaneBits found =
          bits_of(frame, x, y, planes.first_of_occlusion(), gnomon::planes_of(kOcclusionSegments));
      count.differing += found.mask != expected.mask || found.valid != expected.valid;
    }
  return count;
}

}  // namespace gnomon::test
