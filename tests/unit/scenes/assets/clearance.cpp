#include "tests/unit/scenes/assets/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon::scenes::assets {
namespace {

// The closest point of a triangle by Ericson, "Real-Time Collision Detection" (2005), 5.1.5.
float distance_to_triangle(glm::vec3 p, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
  const glm::vec3 ab = b - a, ac = c - a, ap = p - a;
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return glm::length(ap);
  const glm::vec3 bp = p - b;
  const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return glm::length(bp);
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(ap - d1 / (d1 - d3) * ab);
  const glm::vec3 cp = p - c;
  const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return glm::length(cp);
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(ap - d2 / (d2 - d6) * ac);
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return glm::length(bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  return std::abs(glm::dot(ap, glm::normalize(glm::cross(ab, ac))));
}

bool ray_meets_box(glm::vec3 o, glm::vec3 d, glm::vec3 low, glm::vec3 high) {
  const glm::vec3 t1 = (low - o) / d, t2 = (high - o) / d;
  const glm::vec3 enter = glm::min(t1, t2), leave = glm::max(t1, t2);
  return std::max({enter.x, enter.y, enter.z, 0.0f}) <= std::min({leave.x, leave.y, leave.z});
}

// The distance to the triangle along a ray, infinity if the ray misses it (Möller and Trumbore, "Fast, Minimum Storage
// Ray-Triangle Intersection", 1997).
float hit(glm::vec3 o, glm::vec3 d, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
  constexpr float kMiss = std::numeric_limits<float>::infinity();
  const glm::vec3 e1 = b - a, e2 = c - a, p = glm::cross(d, e2), s = o - a, q = glm::cross(s, e1);
  const float determinant = glm::dot(e1, p);
  if (determinant == 0.0f) return kMiss;
  const float u = glm::dot(s, p) / determinant, v = glm::dot(d, q) / determinant, t = glm::dot(e2, q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : kMiss;
}

}  // namespace

World::World(const Stage& stage) {
  for (const Node& node : stage.nodes) {
    for (const Part& part : stage.models[node.model].parts) {
      const Mesh mesh = placed(part.mesh, node.placement);
      Piece piece{
          mesh.positions.front(), mesh.positions.front(), stage.materials[part.material].cutout == kNoImage, {}};
      for (const glm::vec3& p : mesh.positions)
        piece.low = glm::min(piece.low, p), piece.high = glm::max(piece.high, p);
      for (const glm::uvec3& t : mesh.triangles) {
        for (int k = 0; k < 3; ++k) piece.corners.push_back(mesh.positions[t[k]]);
      }
      pieces_.push_back(std::move(piece));
    }
  }
}

float World::clearance(glm::vec3 point, float limit) const {
  float nearest = limit;
  for (const Piece& piece : pieces_) {
    if (glm::distance(point, glm::clamp(point, piece.low, piece.high)) >= nearest) continue;
    for (size_t i = 0; i < piece.corners.size(); i += 3) {
      const glm::vec3 a = piece.corners[i], b = piece.corners[i + 1], c = piece.corners[i + 2];
      const glm::vec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
      if (glm::any(glm::lessThan(point, low - nearest)) || glm::any(glm::greaterThan(point, high + nearest)))
        continue;
      nearest = std::min(nearest, distance_to_triangle(point, a, b, c));
    }
  }
  return nearest;
}

bool World::in_free_space(glm::vec3 point, glm::vec3 direction) const {
  float nearest = std::numeric_limits<float>::infinity();
  bool front = true;
  for (const Piece& piece : pieces_) {
    if (!piece.closed || !ray_meets_box(point, direction, piece.low, piece.high)) continue;
    for (size_t i = 0; i < piece.corners.size(); i += 3) {
      const glm::vec3 a = piece.corners[i], b = piece.corners[i + 1], c = piece.corners[i + 2];
      const float t = hit(point, direction, a, b, c);
      if (t < nearest) nearest = t, front = glm::dot(glm::cross(b - a, c - a), direction) < 0;
    }
  }
  return front;
}

}  // namespace gnomon::scenes::assets
