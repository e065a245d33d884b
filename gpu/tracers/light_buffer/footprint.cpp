#include "gpu/tracers/light_buffer/footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kUnit = 0x1p-24;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Measure {
  glm::dvec3 normal;             // length: twice the area
  std::array<double, 3> length;  // of edge i, between corners i and i + 1
  double longest = 0;
  double reach = 0;  // of the farthest corner from the reference
};

Measure measure(const std::array<glm::dvec3, 3>& p) {
  Measure m;
  m.normal = glm::cross(p[1] - p[0], p[2] - p[0]);
  for (size_t i = 0; i < 3; ++i) {
    m.length[i] = glm::distance(p[i], p[(i + 1) % 3]);
    m.longest = std::max(m.longest, m.length[i]);
    m.reach = std::max(m.reach, glm::length(p[i]));
  }
  return m;
}

// Edge functions: positive inside for a triangle whose plane has the reference on its positive side.
std::array<Linear, 3> edge_functions(const Face& face, const std::array<glm::dvec3, 3>& p) {
  std::array<Linear, 3> edges;
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3& a = p[i];
    const glm::dvec3& b = p[(i + 1) % 3];
    edges[i] = face.perspective ? glm::cross(a, b) : Linear(a.y - b.y, b.x - a.x, a.x * b.y - a.y * b.x);
  }
  return edges;
}

// Box of the triangle stretched about its centre; everything if it reaches behind the light.
Rect stretched_box(const Face& face, const std::array<glm::dvec3, 3>& p, double eta) {
  const glm::dvec3 center = (p[0] + p[1] + p[2]) / 3.0;
  Rect box{kInfinity, kInfinity, -kInfinity, -kInfinity};
  for (const glm::dvec3& corner : p) {
    const glm::dvec3 q = center + (1.0 + 3.0 * eta) * (corner - center);
    if (face.perspective && q.z <= 1e-9 * glm::length(q)) return {-kInfinity, -kInfinity, kInfinity, kInfinity};
    const double u = face.perspective ? q.x / q.z : q.x;
    const double v = face.perspective ? q.y / q.z : q.y;
    box = {std::min(box.u0, u), std::min(box.v0, v), std::max(box.u1, u), std::max(box.v1, v)};
  }
  return box;
}

bool all_behind(const std::array<glm::dvec3, 3>& p, double margin) {
  return p[0].z < -margin && p[1].z < -margin && p[2].z < -margin;
}

}  // namespace

std::optional<Footprint> footprint(const Face& face, double diameter, const std::array<glm::dvec3, 3>& corners) {
  const std::array<glm::dvec3, 3> p = {face.to_face(corners[0]), face.to_face(corners[1]),
                                       face.to_face(corners[2])};
  const Measure m = measure(p);
  const double unit = kUnit * diameter;
  // |dot(n, t)| times the direction's own length, which cancels against that of the slacks.
  const double volume = face.perspective ? glm::dot(m.normal, p[0]) : m.normal.z;
  const double across = face.perspective ? std::abs(volume) / (m.reach + m.longest) : std::abs(volume);
  const double perimeter = m.length[0] + m.length[1] + m.length[2];
  const double eta = unit * (9.0 * perimeter + 12.0 * m.longest) / across;
  const bool off_light = !face.perspective || std::abs(volume) > 16.0 * unit * glm::length(m.normal);

  Footprint f;
  f.regular = across > 0 && eta <= 1.0 && off_light;
  f.can_cover = f.regular;
  const double lever = f.regular ? 2.0 * m.longest : m.reach + m.longest;
  // The longest (u, v, 1) on a padded perspective face is below 1.83.
  const double length = face.perspective ? 1.83 : 1.0;
  const double sign = volume < 0 ? -1.0 : 1.0;
  f.edges = edge_functions(face, p);
  for (size_t i = 0; i < 3; ++i) {
    f.edges[i] *= sign;
    f.slack[i] = unit * length * (9.0 * m.length[i] + 2.0 * lever);
  }
  if (!f.regular) {
    // A false hit needs both orientations' slacks at once: widen each edge by the others'.
    const double all = f.slack[0] + f.slack[1] + f.slack[2];
    f.slack = {all, all, all};
    f.box = {-kInfinity, -kInfinity, kInfinity, kInfinity};
    return f;
  }
  if (face.perspective && all_behind(p, 3.0 * eta * m.longest)) return std::nullopt;
  const double all = f.slack[0] + f.slack[1] + f.slack[2];
  f.slack = {all, all, all};
  f.box = stretched_box(face, p, eta);
  const double s = 1.0 + eta;
  const double shift = 2.0 * kUnit * (3.0 * s * s + 9.0 * s) * m.longest * m.longest * m.longest / std::abs(volume);
  if (face.perspective) {
    const Linear nearness = m.normal / volume;
    f.nearest = nearness * (1.0 + 2.0 * shift);
    f.cover = nearness * (1.0 - shift);
    f.can_cover = shift < 0.1;
    if (shift > 0.1) f.regular = false;
  } else {
    // n.x u + n.y v + n.z depth = dot(n, p0)
    const Linear nearness = Linear(m.normal.x, m.normal.y, -glm::dot(m.normal, p[0])) / m.normal.z;
    f.nearest = nearness + Linear(0, 0, shift);
    f.cover = nearness - Linear(0, 0, shift);
  }
  return f;
}

bool meets(const Footprint& f, const Rect& rect) {
  if (f.box.u0 > rect.u1 || f.box.u1 < rect.u0 || f.box.v0 > rect.v1 || f.box.v1 < rect.v0) return false;
  const double u = 0.5 * (rect.u0 + rect.u1), v = 0.5 * (rect.v0 + rect.v1);
  const double half_u = 0.5 * (rect.u1 - rect.u0), half_v = 0.5 * (rect.v1 - rect.v0);
  bool upright = true, turned = !f.regular;
  for (size_t i = 0; i < 3; ++i) {
    const double middle = at(f.edges[i], u, v);
    const double swing = std::abs(f.edges[i].x) * half_u + std::abs(f.edges[i].y) * half_v + f.slack[i];
    upright = upright && middle >= -swing;
    turned = turned && middle <= swing;
  }
  return upright || turned;
}

bool covers(const Footprint& f, const Rect& rect) {
  if (!f.can_cover) return false;
  const double u = 0.5 * (rect.u0 + rect.u1), v = 0.5 * (rect.v0 + rect.v1);
  const double half_u = 0.5 * (rect.u1 - rect.u0), half_v = 0.5 * (rect.v1 - rect.v0);
  for (size_t i = 0; i < 3; ++i) {
    const double swing = std::abs(f.edges[i].x) * half_u + std::abs(f.edges[i].y) * half_v;
    if (at(f.edges[i], u, v) < swing + f.slack[i]) return false;
  }
  return true;
}

double excess(const Footprint& f, const Rect& rect, const Linear& plane) {
  const Linear difference = f.nearest - plane;
  const double u0 = std::max(rect.u0, f.box.u0), u1 = std::min(rect.u1, f.box.u1);
  const double v0 = std::max(rect.v0, f.box.v0), v1 = std::min(rect.v1, f.box.v1);
  return std::max(difference.x * u0, difference.x * u1) + std::max(difference.y * v0, difference.y * v1) +
         difference.z;
}

}  // namespace gnomon::gpu::light_buffer
