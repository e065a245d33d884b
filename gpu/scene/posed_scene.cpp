#include "gpu/scene/posed_scene.h"

#include <cstring>

namespace gnomon::gpu {

exact::TracedLight silenced_light(const scenes::Bounds& bounds) {
  exact::TracedLight light{};
  light.position = 2.0f * bounds.max - bounds.min + 1.0f;
  light.direction = {0.0f, -1.0f, 0.0f};
  light.reach = 1e-30f;  // its square is 0
  return light;
}

bool same_light(const exact::TracedLight& a, const exact::TracedLight& b) {
  static_assert(sizeof(exact::TracedLight) == 40, "no padding");
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

std::vector<scenes::ClusterGroup> draws_of(const scenes::Scene& scene, const scenes::WorldMesh& mesh) {
  std::vector<scenes::ClusterGroup> draws;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool masked = t >= mesh.opaque_count;
    const bool double_sided = scene.materials[mesh.materials[t]].double_sided;
    if (draws.empty() || draws.back().masked != masked || draws.back().double_sided != double_sided) {
      draws.push_back({});
      draws.back().first_triangle = t;
      draws.back().masked = masked;
      draws.back().double_sided = double_sided;
    }
    ++draws.back().triangle_count;
  }
  return draws;
}

}  // namespace gnomon::gpu
