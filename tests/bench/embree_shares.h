// Shares by Embree, of any number of points: references for what masks count.
#pragma once

#include <span>

#include "gpu/tracers/tracer.h"
#include "tests/unit/gpu/embree_oracle.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {

// The share of a light's points, which lie at `offsets` from its `middle`, that the surface sees. `origin`: where its
// shadow segments start.
inline float seen_share(const test::EmbreeOracle& oracle, const glm::vec3& normal, const glm::vec3& origin,
                        const glm::vec3& middle, std::span<const glm::vec3> offsets) {
  uint32_t seen = 0;
  for (const glm::vec3& offset : offsets) {
    const glm::vec3 point = middle + offset;
    seen += glm::dot(normal, point - origin) > 0.0f && !oracle.occluded(origin, point);
  }
  return static_cast<float>(seen) / static_cast<float>(offsets.size());
}

// The share of the segments from the surface to `points` of the occlusion's sphere that nothing blocks.
inline float open_share(const test::EmbreeOracle& oracle, const gpu::CameraView& camera,
                        const gpu::SurfaceSample& sample, std::span<const glm::vec3> points, float radius) {
  const glm::vec3 origin = gpu::exact::segment_origin(camera.position, {sample.position, sample.normal});
  uint32_t free = 0;
  for (const glm::vec3& point : points) {
    const auto segment = gpu::exact::occlusion_segment(origin, sample.normal, point, radius);
    free += !segment.traced || !oracle.occluded(origin, origin + segment.direction);
  }
  return static_cast<float>(free) / static_cast<float>(points.size());
}

}  // namespace gnomon::bench
