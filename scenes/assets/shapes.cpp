#include "scenes/assets/shapes.h"

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/assets/random.h"

namespace gnomon::scenes::assets {
namespace {

constexpr float kTwoPi = glm::two_pi<float>();

// Where along one edge of a rounded box its face is cut: finer over the rounding, even over the flat.
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

template <class V>
std::vector<V> catmull_rom(const std::vector<V>& p, int steps) {
  std::vector<V> out;
  const int n = static_cast<int>(p.size());
  for (int i = 0; i + 1 < n; ++i) {
    const V a = p[std::max(i - 1, 0)], b = p[i], c = p[i + 1], d = p[std::min(i + 2, n - 1)];
    for (int s = 0; s < steps; ++s) {
      const float t = static_cast<float>(s) / static_cast<float>(steps);
      out.push_back(0.5f * (2.0f * b + (c - a) * t + (2.0f * a - 5.0f * b + 4.0f * c - d) * (t * t) +
                            (3.0f * b - a - 3.0f * c + d) * (t * t * t)));
    }
  }
  out.push_back(p.back());
  return out;
}

void add_quad(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangles.emplace_back(a, c, d);
}

// A flat lid over the ring of vertices first, first + 1, ... with vertices of its own, so that its rim is sharp.
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

}  // namespace

Mesh bevel_box(glm::vec3 low, glm::vec3 high, float bevel) {
  // Three vertices a corner, one for each face that meets there, each with that face's normal.
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
  const float phase = random.range(0.0f, kTwoPi), lean = random.range(-0.3f, 0.3f);
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

Mesh lathe(const std::vector<glm::vec2>& profile, int segments) {
  Mesh mesh;
  const auto ring = static_cast<uint32_t>(segments + 1);
  for (const glm::vec2& p : profile) {
    for (uint32_t s = 0; s < ring; ++s) {
      const float angle =
          kTwoPi * static_cast<float>(s % static_cast<uint32_t>(segments)) / static_cast<float>(segments);
      mesh.positions.emplace_back(p.x * std::cos(angle), p.y, -p.x * std::sin(angle));
    }
  }
  for (uint32_t i = 0; i + 1 < profile.size(); ++i) {
    if (profile[i] == profile[i + 1]) continue;  // a sharp edge: two rings at one place, nothing between
    for (uint32_t s = 0; s + 1 < ring; ++s) {
      const uint32_t v = i * ring + s;
      add_quad(mesh, v, v + 1, v + ring + 1, v + ring);
    }
  }
  smooth_normals(mesh, 35.0f);
  return mesh;
}

Mesh turned_vessel(const std::vector<glm::vec2>& profile, int segments, int steps) {
  std::vector<glm::vec2> fine = curve(profile, steps);
  for (glm::vec2& p : fine) p.x = std::max(p.x, 0.0f);
  return lathe(fine, segments);
}

Mesh sphere(float radius, int segments) {
  std::vector<glm::vec2> profile;
  const int rings = segments / 2;
  for (int i = 0; i <= rings; ++i) {
    const float angle = glm::pi<float>() * (static_cast<float>(i) / static_cast<float>(rings) - 0.5f);
    const bool pole = i == 0 || i == rings;
    profile.emplace_back(pole ? 0.0f : radius * std::cos(angle), radius * std::sin(angle));
  }
  return lathe(profile, segments);
}

Mesh cylinder(float radius, float low, float high, int segments, float bevel) {
  const glm::vec2 a(radius - bevel, low), b(radius, low + bevel), c(radius, high - bevel), d(radius - bevel, high);
  return lathe({{0, low}, a, a, b, b, c, c, d, d, {0, high}}, segments);
}

std::vector<glm::vec3> curve(const std::vector<glm::vec3>& points, int steps) { return catmull_rom(points, steps); }
std::vector<glm::vec2> curve(const std::vector<glm::vec2>& points, int steps) { return catmull_rom(points, steps); }

Mesh tube(const std::vector<glm::vec3>& path, const std::function<float(float)>& radius, int sides) {
  Mesh mesh;
  const auto count = static_cast<uint32_t>(path.size());
  const auto ring = static_cast<uint32_t>(sides);
  glm::vec3 tangent = glm::normalize(path[1] - path[0]);
  glm::vec3 across = glm::vec3(pointing(tangent)[0]);
  for (uint32_t i = 0; i < count; ++i) {
    // The frame is carried along, so that the bar does not twist.
    tangent = glm::normalize(path[std::min(i + 1, count - 1)] - path[i > 0 ? i - 1 : 0]);
    across = glm::normalize(across - tangent * glm::dot(across, tangent));
    const glm::vec3 other = glm::cross(tangent, across);
    const float r = radius(static_cast<float>(i) / static_cast<float>(count - 1));
    for (uint32_t s = 0; s < ring; ++s) {
      const float angle = kTwoPi * static_cast<float>(s) / static_cast<float>(ring);
      mesh.positions.push_back(path[i] + r * (std::cos(angle) * across + std::sin(angle) * other));
    }
  }
  for (uint32_t i = 0; i + 1 < count; ++i) {
    for (uint32_t s = 0; s < ring; ++s) {
      const uint32_t a = i * ring + s, b = i * ring + (s + 1) % ring;
      add_quad(mesh, a, b, b + ring, a + ring);
    }
  }
  add_cap(mesh, 0, ring, true);
  add_cap(mesh, (count - 1) * ring, ring, false);
  smooth_normals(mesh, 60.0f);
  return mesh;
}

Mesh tube(const std::vector<glm::vec3>& path, float radius, int sides) {
  return tube(
      path, [radius](float) { return radius; }, sides);
}

Mesh surface(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f) {
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
  smooth_normals(mesh);
  return mesh;
}

Mesh sheet(int spans_u, int spans_v, float thickness, const std::function<glm::vec3(float, float)>& f) {
  Mesh mesh = surface(spans_u, spans_v, f);
  mesh.uvs.clear();
  const auto front = static_cast<uint32_t>(mesh.positions.size());
  const size_t front_triangles = mesh.triangles.size();
  for (uint32_t v = 0; v < front; ++v) mesh.positions.push_back(mesh.positions[v] - thickness * mesh.normals[v]);
  for (size_t t = 0; t < front_triangles; ++t) {
    const glm::uvec3 face = mesh.triangles[t] + front;
    mesh.triangles.emplace_back(face.x, face.z, face.y);
  }
  std::vector<uint32_t> rim;  // counter-clockwise seen from the front
  const auto row = static_cast<uint32_t>(spans_u + 1), rows = static_cast<uint32_t>(spans_v + 1);
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

Mesh prism(const std::vector<glm::vec2>& outline, float depth) {
  Mesh mesh;
  const auto count = static_cast<uint32_t>(outline.size());
  for (const glm::vec2& p : outline) mesh.positions.emplace_back(p, 0.0f);
  for (const glm::vec2& p : outline) mesh.positions.emplace_back(p, depth);
  // Every side has its own vertices: outlines are angular, and curved ones are smoothed by the crease below.
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
