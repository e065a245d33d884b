#include "scenes/assets/mesh.h"

#include <cmath>
#include <map>
#include <tuple>

namespace gnomon::scenes::assets {
namespace {

using Place = std::tuple<int64_t, int64_t, int64_t>;

// Places are equal to a hundredth of a millimetre, because vertices along a seam differ by rounding.
Place place_of(glm::vec3 p) {
  const auto cell = [](float v) { return static_cast<int64_t>(std::llround(double{v} * 1e5)); };
  return {cell(p.x), cell(p.y), cell(p.z)};
}

void drop_empty_triangles(Mesh& mesh) {
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    return glm::length(glm::cross(b - a, c - a)) < 1e-11f;
  });
}

void drop_unused_vertices(Mesh& mesh) {
  constexpr uint32_t kUnused = 0xffffffff;
  std::vector<uint32_t> renamed(mesh.positions.size(), kUnused);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) renamed[t[k]] = 0;
  }
  Mesh kept;
  for (uint32_t v = 0; v < renamed.size(); ++v) {
    if (renamed[v] == kUnused) continue;
    renamed[v] = static_cast<uint32_t>(kept.positions.size());
    kept.positions.push_back(mesh.positions[v]);
    if (!mesh.uvs.empty()) kept.uvs.push_back(mesh.uvs[v]);
  }
  for (glm::uvec3& t : mesh.triangles) t = {renamed[t.x], renamed[t.y], renamed[t.z]};
  mesh.positions = std::move(kept.positions);
  mesh.uvs = std::move(kept.uvs);
}

std::vector<glm::vec3> area_normals(const Mesh& mesh) {
  std::vector<glm::vec3> sums(mesh.positions.size(), glm::vec3(0.0f));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const glm::vec3 n = glm::cross(b - a, c - a);
    for (int k = 0; k < 3; ++k) sums[t[k]] += n;
  }
  return sums;
}

glm::vec3 unit_or_up(glm::vec3 v) {
  const float length = glm::length(v);
  return length > 1e-20f ? v / length : glm::vec3(0.0f, 1.0f, 0.0f);
}

}  // namespace

void append(Mesh& to, const Mesh& part, const glm::mat4& placement) {
  const auto base = static_cast<uint32_t>(to.positions.size());
  const glm::mat3 linear(placement);
  const bool mirrored = glm::determinant(linear) < 0.0f;
  const glm::mat3 to_normal = glm::transpose(glm::inverse(linear));
  if (!part.uvs.empty()) to.uvs.resize(base);
  for (const glm::vec3& p : part.positions) to.positions.emplace_back(placement * glm::vec4(p, 1.0f));
  for (const glm::vec3& n : part.normals) to.normals.push_back(unit_or_up(to_normal * n));
  to.uvs.insert(to.uvs.end(), part.uvs.begin(), part.uvs.end());
  if (!to.uvs.empty()) to.uvs.resize(to.positions.size());
  for (const glm::uvec3& t : part.triangles) {
    to.triangles.push_back(base + (mirrored ? glm::uvec3(t.x, t.z, t.y) : t));
  }
}

void add_quad(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangles.emplace_back(a, c, d);
}

void add_cap(Mesh& mesh, uint32_t first, uint32_t count, bool reversed) {
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  glm::vec3 centre(0.0f);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 p = mesh.positions[first + i];
    centre += p / static_cast<float>(count);
    mesh.positions.push_back(p);
  }
  mesh.positions.push_back(centre);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t a = base + i, b = base + (i + 1) % count;
    mesh.triangles.push_back(reversed ? glm::uvec3(base + count, b, a) : glm::uvec3(base + count, a, b));
  }
}

Mesh placed(const Mesh& mesh, const glm::mat4& placement) {
  Mesh result;
  append(result, mesh, placement);
  return result;
}

void smooth_normals(Mesh& mesh, float crease_degrees) {
  drop_empty_triangles(mesh);
  drop_unused_vertices(mesh);
  const std::vector<glm::vec3> own = area_normals(mesh);
  std::map<Place, std::vector<uint32_t>> at_place;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) at_place[place_of(mesh.positions[v])].push_back(v);

  const float least_cos = std::cos(glm::radians(crease_degrees));
  mesh.normals.assign(mesh.positions.size(), glm::vec3(0.0f, 1.0f, 0.0f));
  for (const auto& [place, group] : at_place) {
    for (const uint32_t v : group) {
      glm::vec3 sum(0.0f);
      for (const uint32_t other : group) {
        const bool joined = glm::dot(unit_or_up(own[v]), unit_or_up(own[other])) >= least_cos - 1e-4f;
        if (joined) sum += own[other];
      }
      mesh.normals[v] = unit_or_up(sum);
    }
  }
}

void deform(Mesh& mesh, const std::function<glm::vec3(glm::vec3)>& move) {
  for (glm::vec3& p : mesh.positions) p = move(p);
  smooth_normals(mesh);
}

glm::mat4 at(glm::vec3 position) { return glm::translate(glm::mat4(1.0f), position); }
glm::mat4 at(float x, float y, float z) { return at(glm::vec3(x, y, z)); }
glm::mat4 turned(float degrees, glm::vec3 axis) {
  return glm::rotate(glm::mat4(1.0f), glm::radians(degrees), axis);
}
glm::mat4 scaled(float x, float y, float z) { return glm::scale(glm::mat4(1.0f), glm::vec3(x, y, z)); }
glm::mat4 scaled(float factor) { return scaled(factor, factor, factor); }

glm::mat4 pointing(glm::vec3 direction) {
  const glm::vec3 y = glm::normalize(direction);
  const glm::vec3 aside = std::abs(y.x) < 0.8f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1);
  const glm::vec3 z = glm::normalize(glm::cross(aside, y));
  const glm::vec3 x = glm::cross(y, z);
  return glm::mat4(glm::vec4(x, 0), glm::vec4(y, 0), glm::vec4(z, 0), glm::vec4(0, 0, 0, 1));
}

}  // namespace gnomon::scenes::assets
