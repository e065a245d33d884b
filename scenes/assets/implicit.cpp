#include "scenes/assets/implicit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace gnomon::scenes::assets {
namespace {

// The field sampled at the corners of a grid, and the vertex of every cell that the surface crosses.
struct Grid {
  glm::ivec3 corners;
  glm::vec3 low;
  float cell;
  std::vector<float> values;
  std::vector<int64_t> vertices;

  size_t index(glm::ivec3 c) const {
    return (static_cast<size_t>(c.z) * static_cast<size_t>(corners.y) + static_cast<size_t>(c.y)) *
               static_cast<size_t>(corners.x) +
           static_cast<size_t>(c.x);
  }
  float value(glm::ivec3 c) const { return values[index(c)]; }
  glm::vec3 place(glm::ivec3 c) const { return low + cell * glm::vec3(c); }
};

Grid sample(const Field& field, glm::vec3 low, glm::vec3 high, float cell) {
  Grid grid{glm::ivec3(glm::ceil((high - low) / cell)) + 1, low, cell, {}, {}};
  const size_t count = grid.index({0, 0, grid.corners.z});
  grid.values.reserve(count);
  for (int z = 0; z < grid.corners.z; ++z) {
    for (int y = 0; y < grid.corners.y; ++y) {
      for (int x = 0; x < grid.corners.x; ++x) grid.values.push_back(field(grid.place({x, y, z})));
    }
  }
  grid.vertices.assign(count, -1);
  return grid;
}

glm::vec3 gradient(const Field& field, glm::vec3 p, float step) {
  const glm::vec3 x(step, 0, 0), y(0, step, 0), z(0, 0, step);
  return {field(p + x) - field(p - x), field(p + y) - field(p - y), field(p + z) - field(p - z)};
}

// Sets `vertex` to the mean of the points where the surface crosses the cell's edges; returns false if it crosses none.
bool cell_vertex(const Grid& grid, glm::ivec3 cell, glm::vec3& vertex) {
  glm::vec3 sum(0.0f);
  int crossings = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 4; ++k) {
      glm::ivec3 a = cell;
      a[(axis + 1) % 3] += k & 1, a[(axis + 2) % 3] += k >> 1;
      glm::ivec3 b = a;
      b[axis] += 1;
      const float va = grid.value(a), vb = grid.value(b);
      if ((va < 0) == (vb < 0)) continue;
      sum += glm::mix(grid.place(a), grid.place(b), va / (va - vb));
      ++crossings;
    }
  }
  if (crossings > 0) vertex = sum / static_cast<float>(crossings);
  return crossings > 0;
}

// Adds a quad between the four cells around each grid edge along which the field changes sign.
void add_quads(Grid& grid, Mesh& mesh) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::ivec3 u(0), v(0), along(0);
    u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1, along[axis] = 1;
    const glm::ivec3 first = u + v;
    for (int z = first.z; z + 1 < grid.corners.z; ++z) {
      for (int y = first.y; y + 1 < grid.corners.y; ++y) {
        for (int x = first.x; x + 1 < grid.corners.x; ++x) {
          const glm::ivec3 c(x, y, z);
          const bool inside = grid.value(c) < 0;
          if (inside == (grid.value(c + along) < 0)) continue;
          const auto at_cell = [&](glm::ivec3 d) { return static_cast<uint32_t>(grid.vertices[grid.index(d)]); };
          const uint32_t q[4] = {at_cell(c - u - v), at_cell(c - v), at_cell(c), at_cell(c - u)};
          const int s = inside ? 1 : 3;
          mesh.triangles.emplace_back(q[0], q[s], q[2]);
          mesh.triangles.emplace_back(q[0], q[2], q[4 - s]);
        }
      }
    }
  }
}

}  // namespace

float blend(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}

float carve(float solid, float hole, float k) { return -blend(-solid, hole, k); }

float ball(glm::vec3 p, glm::vec3 centre, float radius) { return glm::length(p - centre) - radius; }

float ellipsoid(glm::vec3 p, glm::vec3 centre, glm::vec3 radii) {
  const glm::vec3 q = p - centre;
  const float k0 = glm::length(q / radii), k1 = glm::length(q / (radii * radii));
  return k1 > 1e-6f ? k0 * (k0 - 1.0f) / k1 : -std::min({radii.x, radii.y, radii.z});
}

float capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b) {
  const glm::vec3 ab = b - a;
  const float t = glm::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0f, 1.0f);
  return glm::length(p - a - t * ab) - glm::mix(radius_a, radius_b, t);
}

float brick(glm::vec3 p, glm::vec3 centre, glm::vec3 half, float round) {
  const glm::vec3 q = glm::abs(p - centre) - half + round;
  return glm::length(glm::max(q, glm::vec3(0.0f))) + std::min(std::max({q.x, q.y, q.z}), 0.0f) - round;
}

Mesh sculpt(const Field& field, glm::vec3 low, glm::vec3 high, float cell) {
  Grid grid = sample(field, low, high, cell);
  Mesh mesh;
  for (int z = 0; z + 1 < grid.corners.z; ++z) {
    for (int y = 0; y + 1 < grid.corners.y; ++y) {
      for (int x = 0; x + 1 < grid.corners.x; ++x) {
        glm::vec3 vertex;
        if (!cell_vertex(grid, {x, y, z}, vertex)) continue;
        grid.vertices[grid.index({x, y, z})] = static_cast<int64_t>(mesh.positions.size());
        const glm::vec3 n = gradient(field, vertex, 0.4f * cell);
        mesh.positions.push_back(vertex);
        mesh.normals.push_back(glm::length(n) > 1e-12f ? glm::normalize(n) : glm::vec3(0, 1, 0));
      }
    }
  }
  add_quads(grid, mesh);
  return mesh;
}

}  // namespace gnomon::scenes::assets
