#include "scenes/assets/shapes.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/assets/random.h"

namespace gnomon::scenes::assets {
namespace {

// The positions along one edge of a rounded box at which its face is divided: by equal angles over the rounding, by
// equal lengths over the flat part.
std::vector<float> face_cuts(float half, float radius, int round, int flat) {
  std::vector<float> cuts;
  const float inner = half - radius;
  for (int i = round; i > 0; --i) {
    const float angle = glm::quarter_pi<float>() * static_cast<float>(i) / static_cast<float>(round);
    cuts.push_back(-inner - radius * std::tan(angle));
  }
  for (int i = 0; i <= flat; ++i)
    cuts.push_back(-inner + 2 * inner * static_cast<float>(i) / static_cast<float>(flat));
  for (int i = 1; i <= round; ++i) {
    const float angle = glm::quarter_pi<float>() * static_cast<float>(i) / static_cast<float>(round);
    cuts.push_back(inner + radius * std::tan(angle));
  }
  return cuts;
}

void add_rounded_face(Mesh& mesh, glm::vec3 half, float radius, int round, int flat, int axis, float side) {
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  const std::vector<float> cuts_a = face_cuts(half[a], radius, round, flat);
  const std::vector<float> cuts_b = face_cuts(half[b], radius, round, flat);
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  for (const float ca : cuts_a) {
    for (const float cb : cuts_b) {
      glm::vec3 p;
      p[axis] = side * half[axis], p[a] = ca, p[b] = cb;
      const glm::vec3 inner = glm::clamp(p, -half + radius, half - radius);
      const glm::vec3 n = glm::normalize(p - inner);
      mesh.positions.push_back(inner + radius * n);
      mesh.normals.push_back(n);
    }
  }
  const auto columns = static_cast<uint32_t>(cuts_b.size());
  for (uint32_t i = 0; i + 1 < cuts_a.size(); ++i) {
    for (uint32_t j = 0; j + 1 < columns; ++j) {
      const uint32_t v = base + i * columns + j;
      const glm::uvec3 t1(v, v + columns, v + columns + 1), t2(v, v + columns + 1, v + 1);
      mesh.triangles.push_back(side > 0 ? t1 : glm::uvec3(t1.x, t1.z, t1.y));
      mesh.triangles.push_back(side > 0 ? t2 : glm::uvec3(t2.x, t2.z, t2.y));
    }
  }
}

}  // namespace

Mesh bevel_box(glm::vec3 low, glm::vec3 high, float bevel) {
  // Each corner has three vertices, one for each face that meets there, with that face's normal.
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 p, n(0.0f);
      for (int k = 0; k < 3; ++k) {
        const bool upper = (corner >> k) & 1;
        const float inset = k == axis ? 0.0f : bevel;
        p[k] = upper ? high[k] - inset : low[k] + inset;
      }
      n[axis] = ((corner >> axis) & 1) ? 1.0f : -1.0f;
      mesh.positions.push_back(p);
      mesh.normals.push_back(n);
    }
  }
  const auto vertex = [](int corner, int axis) { return static_cast<uint32_t>(corner * 3 + axis); };
  const auto facing = [&mesh](glm::uvec3 t) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const glm::vec3 outside = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
    const bool outwards = glm::dot(glm::cross(b - a, c - a), outside) > 0;
    mesh.triangles.push_back(outwards ? t : glm::uvec3(t.x, t.z, t.y));
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int a = 1 << ((axis + 1) % 3), b = 1 << ((axis + 2) % 3), up = 1 << axis;
    for (const int side : {0, up}) {
      facing({vertex(side, axis), vertex(side | a, axis), vertex(side | a | b, axis)});
      facing({vertex(side, axis), vertex(side | a | b, axis), vertex(side | b, axis)});
    }
    if (bevel <= 0.0f) continue;
    // The four edges along this axis join the faces of the two other axes.
    const int f = (axis + 1) % 3, g = (axis + 2) % 3;
    for (const int edge : {0, a, b, a | b}) {
      facing({vertex(edge, f), vertex(edge | up, f), vertex(edge | up, g)});
      facing({vertex(edge, f), vertex(edge | up, g), vertex(edge, g)});
    }
  }
  for (int corner = 0; bevel > 0.0f && corner < 8; ++corner) {
    facing({vertex(corner, 0), vertex(corner, 1), vertex(corner, 2)});
  }
  return mesh;
}

Mesh rounded_box(glm::vec3 size, float radius, int round, int flat) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    add_rounded_face(mesh, size / 2.0f, radius, round, flat, axis, 1.0f);
    add_rounded_face(mesh, size / 2.0f, radius, round, flat, axis, -1.0f);
  }
  return mesh;
}

Mesh cushion(glm::vec3 size, float puff, int detail, uint32_t seed) {
  Mesh mesh = rounded_box(size, 0.42f * size.y, std::max(2, detail / 4), detail);
  Random random(seed);
  const float phase = random.range(0.0f, glm::two_pi<float>()), lean = random.range(-0.3f, 0.3f);
  deform(mesh, [&](glm::vec3 p) {
    const float x = 2 * p.x / size.x, z = 2 * p.z / size.z;
    const float middle = (1 - x * x) * (1 - z * z);
    const float side = 2 * p.y / size.y;
    const float wrinkle =
        0.012f * std::sin(9 * x + 4 * z * z + phase) * std::sin(5 * z + lean * x + phase) * middle;
    p.y += side * (puff * std::sqrt(std::max(middle, 0.0f)) + wrinkle * size.x);
    // Edges between the corners draw in a little.
    p.x *= 1 - 0.035f * (1 - z * z), p.z *= 1 - 0.035f * (1 - x * x);
    return p;
  });
  return mesh;
}

Mesh prism(const std::vector<glm::vec2>& outline, float depth) {
  Mesh mesh;
  const auto count = static_cast<uint32_t>(outline.size());
  for (const glm::vec2& p : outline) mesh.positions.emplace_back(p, 0.0f);
  for (const glm::vec2& p : outline) mesh.positions.emplace_back(p, depth);
  // Every side has its own vertices, so that angular outlines stay sharp; the crease angle below smooths curved ones.
  const auto sides = static_cast<uint32_t>(mesh.positions.size());
  for (uint32_t i = 0; i < count; ++i) {
    for (const uint32_t v : {i, (i + 1) % count, (i + 1) % count + count, i + count}) {
      mesh.positions.push_back(mesh.positions[v]);
    }
    add_quad(mesh, sides + 4 * i, sides + 4 * i + 1, sides + 4 * i + 2, sides + 4 * i + 3);
  }
  add_cap(mesh, 0, count, true);
  add_cap(mesh, count, count, false);
  smooth_normals(mesh, 30.0f);
  return mesh;
}

}  // namespace gnomon::scenes::assets
