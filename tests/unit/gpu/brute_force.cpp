#include "tests/unit/gpu/brute_force.h"

#include "gpu/scene/resident_scene.h"
#include "scenes/world_mesh.h"

namespace gnomon::test {

using namespace gpu;

namespace {

bool lit_by_brute_force(const scenes::WorldMesh& mesh, const CameraView& camera, const SurfaceSample& sample,
                        const exact::TracedLight& light) {
  const auto segment = exact::shadow_segment(camera.position, {sample.position, sample.normal}, light);
  if (!segment.traced) return false;
  for (const glm::uvec3& t : mesh.triangles)
    if (exact::segment_meets_triangle(segment.origin, segment.direction, mesh.positions[t.x], mesh.positions[t.y],
                                      mesh.positions[t.z]))
      return false;
  return true;
}

}  // namespace

Count compare(const scenes::Scene& scene, const CameraView& camera, const ProbedFrame& frame) {
  const scenes::WorldMesh mesh = scenes::build_world_mesh(scene);
  Count count;
  for (uint32_t y = 0; y < frame.grid.height; ++y)
    for (uint32_t x = 0; x < frame.grid.width; ++x) {
      const SurfaceSample& sample = frame.samples[size_t{y} * frame.grid.width + x];
      count.surfaces += sample.triangle != 0;
      for (uint32_t i = 0; i < frame.grid.planes; ++i) {
        const bool expected = sample.triangle != 0 &&
                              lit_by_brute_force(mesh, camera, sample, traced_light(scene.lights[i], scene.bounds));
        (expected ? count.lit : count.dark) += sample.triangle != 0;
        count.differing += expected != frame.mask().lit(x, y, i);
      }
    }
  return count;
}

}  // namespace gnomon::test
