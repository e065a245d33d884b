#include "gpu/tracers/light_buffer/query.h"

#include <bit>
#include <cmath>
#include <vector>

#include "gpu/tracers/light_buffer/entry.h"

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
  const float scale = static_cast<float>(1u << kIndexBits) / 2.0f;
  const float per_depth = scale / size[axis];
  const float offset = scale;
  return {static_cast<uint32_t>(axis) * 2 + (rel[axis] < 0.0f ? 1u : 0u),
          to_fixed(rel[(axis + 1) % 3] * per_depth + offset), to_fixed(rel[(axis + 2) % 3] * per_depth + offset),
          size[axis]};
}

Position flat_position(const LightView& light, const glm::vec3& rel) {
  return {0, to_fixed(glm::dot(light.u_axis, rel) + light.u_offset),
          to_fixed(glm::dot(light.v_axis, rel) + light.v_offset), glm::dot(light.depth_axis, rel)};
}

const Leaf& find_leaf(const LightBuffer& buffer, const LightView& light, const Position& p) {
  const uint32_t shift = kIndexBits - kTopLevel;
  const uint32_t cell =
      buffer.grid[light.cells + p.face * kCellCount + ((p.y >> shift) << kTopLevel) + (p.x >> shift)];
  const uint32_t bits = cell & ((1u << kDepthBits) - 1);
  const uint32_t mask = (1u << bits) - 1;
  const uint32_t x = p.x >> (shift - bits) & mask, y = p.y >> (shift - bits) & mask;
  return buffer.leaves[buffer.grid[(cell >> kDepthBits) + (y << bits) + x]];
}

// The place in 256ths of the leaf's side.
glm::uvec2 place_in_leaf(const Position& p, const Leaf& leaf) {
  const uint32_t level = leaf.count >> kCountBits;
  const uint32_t mask = (1u << kIndexBits) - 1;
  return {(p.x << level & mask) >> (kIndexBits - 8), (p.y << level & mask) >> (kIndexBits - 8)};
}

}  // namespace

Answer query(const LightBuffer& buffer, const LightView& light, const scenes::WorldMesh& mesh,
             const exact::ShadowSegment& segment) {
  const bool directional = light.directional != 0;
  const glm::vec3 rel = directional ? segment.origin - light.reference : -segment.direction;
  const Position position = directional ? flat_position(light, rel) : cube_position(rel);
  const Leaf& leaf = find_leaf(buffer, light, position);
  if (glm::dot(leaf.near_plane, rel) < 1.0f) return {true, End::near_plane};
  if (glm::dot(leaf.cover_plane, rel) > 1.0f) return {false, End::cover_plane};
  Answer answer{true, End::list};
  const uint32_t count = leaf.count & ((1u << kCountBits) - 1);
  const glm::uvec2 in_leaf = place_in_leaf(position, leaf);
  for (uint32_t k = leaf.first; k < leaf.first + count; ++k) {
    const ListEntry& entry = buffer.entries[k];
    ++answer.steps;
    if (in_front(entry, position.depth)) break;
    if (!holds(entry, in_leaf.x, in_leaf.y)) continue;
    const glm::uvec3 t = mesh.triangles[entry.triangle];
    ++answer.tested;
    if (exact::segment_meets_triangle(segment.origin, segment.direction, mesh.positions[t.x], mesh.positions[t.y],
                                      mesh.positions[t.z])) {
      answer.lit = false;
      answer.blocker = entry.triangle;
      break;
    }
  }
  return answer;
}

AreaAnswer query_area(const LightBuffer& buffer, const LightView& light, const scenes::WorldMesh& mesh,
                      const exact::SurfacePoint& surface, const glm::vec3& origin,
                      std::span<const glm::vec3> points) {
  const glm::vec3 rel = origin - light.reference;
  const Position position = cube_position(rel);
  const Leaf& leaf = find_leaf(buffer, light, position);
  AreaAnswer answer;
  if (glm::dot(leaf.cover_plane, rel) > 1.0f) {
    answer.end = End::cover_plane;
    return answer;
  }
  uint32_t open = 0;  // the points that nothing hides so far
  std::vector<exact::ShadowSegment> segments;
  for (const glm::vec3& point : points) {
    segments.push_back(exact::sample_segment(origin, surface.normal, point));
    open |= uint32_t{segments.back().traced} << (segments.size() - 1);
  }
  answer.seen = static_cast<uint32_t>(std::popcount(open));
  if (glm::dot(leaf.near_plane, rel) < 1.0f) return answer;
  answer.end = End::list;
  const uint32_t count = leaf.count & ((1u << kCountBits) - 1);
  const glm::uvec2 in_leaf = place_in_leaf(position, leaf);
  for (uint32_t k = leaf.first; k < leaf.first + count && open != 0; ++k) {
    const ListEntry& entry = buffer.entries[k];
    ++answer.steps;
    if (in_front(entry, position.depth)) break;
    if (!holds(entry, in_leaf.x, in_leaf.y)) continue;
    const glm::uvec3 t = mesh.triangles[entry.triangle];
    ++answer.tested;
    for (size_t i = 0; i < segments.size(); ++i) {
      if (exact::segment_meets_triangle(origin, segments[i].direction, mesh.positions[t.x], mesh.positions[t.y],
                                        mesh.positions[t.z])) {
        open &= ~(1u << i);
      }
    }
  }
  answer.seen = static_cast<uint32_t>(std::popcount(open));
  return answer;
}

}  // namespace gnomon::gpu::light_buffer
