#include "gpu/tracers/light_buffer/query.h"

#include <bit>
#include <cmath>

namespace gnomon::gpu::light_buffer {
namespace {

struct Position {
  uint32_t face = 0;
  uint32_t x = 0, y = 0;  // fixed point
  float depth = 0;
};

uint32_t to_fixed(float f) {
  const float limit = static_cast<float>((1u << kIndexBits) - 1);
  return static_cast<uint32_t>(std::min(std::max(f, 0.0f), limit));
}

Position cube_position(const glm::vec3& rel) {
  const glm::vec3 size = glm::abs(rel);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const float scale = static_cast<float>(1u << kIndexBits) / (2.0f * kFaceExtent);
  const float per_depth = scale / size[axis];
  const float offset = scale * kFaceExtent;
  return {static_cast<uint32_t>(axis) * 2 + (rel[axis] < 0.0f ? 1u : 0u),
          to_fixed(rel[(axis + 1) % 3] * per_depth + offset), to_fixed(rel[(axis + 2) % 3] * per_depth + offset),
          size[axis]};
}

Position flat_position(const LightView& light, const glm::vec3& rel) {
  return {0, to_fixed(glm::dot(light.u_axis, rel) + light.u_offset),
          to_fixed(glm::dot(light.v_axis, rel) + light.v_offset), glm::dot(light.depth_axis, rel)};
}

const Node& find_leaf(const LightBuffer& buffer, const LightView& light, const Position& p) {
  uint32_t shift = kIndexBits - kRootLevel;
  uint32_t node = light.roots + p.face * kRootCount + ((p.y >> shift) << kRootLevel) + (p.x >> shift);
  while (buffer.nodes[node].children != kNone) {
    --shift;
    node = buffer.nodes[node].children + ((p.y >> shift) & 1) * 2 + ((p.x >> shift) & 1);
  }
  return buffer.nodes[node];
}

}  // namespace

Answer query(const LightBuffer& buffer, const LightView& light, const scenes::WorldMesh& mesh,
             const exact::ShadowSegment& segment) {
  const bool directional = light.directional != 0;
  const glm::vec3 rel = directional ? segment.origin - light.reference : -segment.direction;
  const Position position = directional ? flat_position(light, rel) : cube_position(rel);
  const Node& node = find_leaf(buffer, light, position);
  if (glm::dot(node.near_plane, rel) < 1.0f) return {true, End::near_plane, 0};
  if (glm::dot(node.cover_plane, rel) > 1.0f) return {false, End::cover_plane, 0};
  Answer answer{true, End::list, 0};
  const uint32_t count = buffer.lists[node.list];
  for (uint32_t k = 0; k < count; ++k) {
    const uint32_t entry = node.list + 1 + 2 * k;
    if (position.depth * std::bit_cast<float>(buffer.lists[entry + 1]) < 1.0f) break;
    const glm::uvec3 t = mesh.triangles[buffer.lists[entry]];
    ++answer.tested;
    if (exact::segment_meets_triangle(segment.origin, segment.direction, mesh.positions[t.x], mesh.positions[t.y],
                                      mesh.positions[t.z])) {
      answer.lit = false;
      break;
    }
  }
  return answer;
}

}  // namespace gnomon::gpu::light_buffer
