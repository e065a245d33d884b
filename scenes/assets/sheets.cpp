// The shapes that are defined over a grid of parameters (u, v).
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets {
namespace {

// Positions f(u, v) in rows of constant v, with two triangles for each cell and without normals.
Mesh grid(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f) {
  Mesh mesh;
  for (int j = 0; j <= spans_v; ++j) {
    for (int i = 0; i <= spans_u; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(spans_u);
      const float v = static_cast<float>(j) / static_cast<float>(spans_v);
      mesh.positions.push_back(f(u, v));
      mesh.uvs.emplace_back(u, v);
    }
  }
  const auto row = static_cast<uint32_t>(spans_u + 1);
  for (uint32_t j = 0; j < static_cast<uint32_t>(spans_v); ++j) {
    for (uint32_t i = 0; i + 1 < row; ++i) {
      const uint32_t v = j * row + i;
      add_quad(mesh, v, v + 1, v + row + 1, v + row);
    }
  }
  return mesh;
}

// The normals of a grid, without removing vertices. A vertex without area around it, where a row degenerates to a
// point, takes the normal of the row before.
std::vector<glm::vec3> grid_normals(const Mesh& mesh, uint32_t row) {
  std::vector<glm::vec3> normals(mesh.positions.size(), glm::vec3(0.0f));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    for (int k = 0; k < 3; ++k) normals[t[k]] += glm::cross(b - a, c - a);
  }
  for (uint32_t v = 0; v < normals.size(); ++v) {
    const float length = glm::length(normals[v]);
    normals[v] = length > 1e-12f ? normals[v] / length : v >= row ? normals[v - row] : glm::vec3(0, 1, 0);
  }
  return normals;
}

}  // namespace

Mesh surface(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f) {
  Mesh mesh = grid(spans_u, spans_v, f);
  smooth_normals(mesh);
  return mesh;
}

Mesh sheet(int spans_u, int spans_v, float thickness, const std::function<glm::vec3(float, float)>& f) {
  Mesh mesh = grid(spans_u, spans_v, f);
  mesh.uvs.clear();
  const auto row = static_cast<uint32_t>(spans_u + 1), rows = static_cast<uint32_t>(spans_v + 1);
  const uint32_t front = row * rows;
  const size_t front_triangles = mesh.triangles.size();
  const std::vector<glm::vec3> normals = grid_normals(mesh, row);
  for (uint32_t v = 0; v < front; ++v) mesh.positions.push_back(mesh.positions[v] - thickness * normals[v]);
  for (size_t t = 0; t < front_triangles; ++t) {
    const glm::uvec3 face = mesh.triangles[t] + front;
    mesh.triangles.emplace_back(face.x, face.z, face.y);
  }
  std::vector<uint32_t> rim;  // counter-clockwise seen from the front
  for (uint32_t i = 0; i < row; ++i) rim.push_back(i);
  for (uint32_t j = 1; j < rows; ++j) rim.push_back(j * row + row - 1);
  for (uint32_t i = row - 1; i-- > 0;) rim.push_back((rows - 1) * row + i);
  for (uint32_t j = rows - 1; j-- > 1;) rim.push_back(j * row);
  const auto edge = static_cast<uint32_t>(mesh.positions.size());
  const auto length = static_cast<uint32_t>(rim.size());
  for (const uint32_t v : rim) mesh.positions.push_back(mesh.positions[v]);
  for (const uint32_t v : rim) mesh.positions.push_back(mesh.positions[v + front]);
  for (uint32_t i = 0; i < length; ++i) {
    const uint32_t a = edge + i, b = edge + (i + 1) % length;
    add_quad(mesh, a, a + length, b + length, b);
  }
  smooth_normals(mesh, 50.0f);
  return mesh;
}

Mesh barrel(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f) {
  Mesh mesh;
  const auto ring = static_cast<uint32_t>(spans_u), rows = static_cast<uint32_t>(spans_v);
  for (uint32_t j = 0; j <= rows; ++j) {
    for (uint32_t i = 0; i < ring; ++i) {
      mesh.positions.push_back(
          f(static_cast<float>(i) / static_cast<float>(ring), static_cast<float>(j) / static_cast<float>(rows)));
    }
  }
  for (uint32_t j = 0; j < rows; ++j) {
    for (uint32_t i = 0; i < ring; ++i) {
      const uint32_t a = j * ring + i, b = j * ring + (i + 1) % ring;
      add_quad(mesh, a, b, b + ring, a + ring);
    }
  }
  add_cap(mesh, 0, ring, true);
  add_cap(mesh, rows * ring, ring, false);
  smooth_normals(mesh, 50.0f);
  return mesh;
}

}  // namespace gnomon::scenes::assets
