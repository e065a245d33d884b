#include "gpu/tracers/light_buffer/footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kUnit = 0x1p-24;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Corners = std::array<glm::dvec3, 3>;

struct Measure {
  glm::dvec3 normal;             // length: twice the area
  std::array<double, 3> length;  // of edge i, between corners i and i + 1
  double longest = 0;
  double reach = 0;  // of the farthest corner from the reference
};

Measure measure(const Corners& p) {
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
std::array<Linear, 3> edge_functions(const Face& face, const Corners& p) {
  std::array<Linear, 3> edges;
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3& a = p[i];
    const glm::dvec3& b = p[(i + 1) % 3];
    edges[i] = face.perspective ? glm::cross(a, b) : Linear(a.y - b.y, b.x - a.x, a.x * b.y - a.y * b.x);
  }
  return edges;
}

constexpr Rect kEverywhere{-kInfinity, -kInfinity, kInfinity, kInfinity};

// The box of the picture of points; unbounded if one of them is not in front of the light.
template <class Points>
Rect picture_box(const Face& face, const Points& points) {
  Rect box{kInfinity, kInfinity, -kInfinity, -kInfinity};
  for (const glm::dvec3& q : points) {
    if (face.perspective && q.z <= 1e-9 * glm::length(q)) return kEverywhere;
    const double u = face.perspective ? q.x / q.z : q.x;
    const double v = face.perspective ? q.y / q.z : q.y;
    box = {std::min(box.u0, u), std::min(box.v0, v), std::max(box.u1, u), std::max(box.v1, v)};
  }
  return box;
}

// The box of a picture whose points may each be displaced by `by`.
Rect moved(const Rect& box, const Face& face, const Corners& p, double by) {
  const double depth = face.perspective ? std::min(p[0].z, std::min(p[1].z, p[2].z)) - by : 1.0;
  if (depth <= 0.0) return kEverywhere;
  // |u|, |v| <= 1.1 on the face: a point moves by at most (1 + 1.1) * by / depth where that matters.
  const double pad = 2.2 * by / depth;
  return {box.u0 - pad, box.v0 - pad, box.u1 + pad, box.v1 + pad};
}

Corners stretched(const Corners& p, double factor) {
  const glm::dvec3 center = (p[0] + p[1] + p[2]) / 3.0;
  return {center + factor * (p[0] - center), center + factor * (p[1] - center), center + factor * (p[2] - center)};
}

std::array<glm::dvec3, 8> widened_box(const Corners& p, double margin) {
  const glm::dvec3 lo = glm::min(p[0], glm::min(p[1], p[2])) - margin;
  const glm::dvec3 hi = glm::max(p[0], glm::max(p[1], p[2])) + margin;
  std::array<glm::dvec3, 8> box;
  for (size_t k = 0; k < 8; ++k) box[k] = {k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z};
  return box;
}

// The planes of a regular triangle. `across`: see footprint().
void set_planes(Footprint& f, const Face& face, const Measure& m, const Corners& p, double volume, double s,
                double height_seen, double unit) {
  const double height = glm::length(m.normal) / m.longest;
  const double rounding = kUnit * (4.5 * m.longest / height + 4.0 + 2.0 * s);
  const double kept = 1.0 - 4.0 * unit / height_seen - rounding * height / height_seen;
  // Along the segment times the sine, which is |volume| / |n| per distance from the light, or |volume| / |n|.
  const double shift = rounding * (1.0 + s) * m.longest / kept * glm::length(m.normal) / std::abs(volume);
  if (face.perspective) {
    const Linear nearness = m.normal / volume;
    f.nearest = nearness * (1.0 + 2.0 * shift);
    f.cover = nearness * (1.0 - shift);
    f.can_cover = f.bounded = shift < 0.5;
  } else {
    // n.x u + n.y v + n.z depth = dot(n, p0)
    const Linear nearness = Linear(m.normal.x, m.normal.y, -glm::dot(m.normal, p[0])) / m.normal.z;
    f.nearest = nearness + Linear(0, 0, shift);
    f.cover = nearness - Linear(0, 0, shift);
  }
}

// The box of an irregular triangle, and the nearness of its nearest corner.
void set_box(Footprint& f, const Face& face, const Corners& p, double margin) {
  const std::array<glm::dvec3, 8> box = widened_box(p, margin);
  f.box = picture_box(face, box);
  double depth = kInfinity;
  for (const glm::dvec3& q : box) depth = std::min(depth, q.z);
  f.bounded = !face.perspective || depth > 0.0;
  if (f.bounded) f.nearest = Linear(0, 0, face.perspective ? 1.0 / depth : -depth);
}

}  // namespace

std::optional<Footprint> footprint(const Face& face, double diameter, const Corners& corners) {
  const Corners p = {face.to_face(corners[0]), face.to_face(corners[1]), face.to_face(corners[2])};
  const Measure m = measure(p);
  const double unit = kUnit * diameter;
  const double margin = diameter / 4000.0;
  if (face.perspective && std::max(p[0].z, std::max(p[1].z, p[2].z)) < -margin) return std::nullopt;
  // The volume over the light, or the area seen by it; per length of direction, at least `across`.
  const double volume = face.perspective ? glm::dot(m.normal, p[0]) : m.normal.z;
  const double across = face.perspective ? std::abs(volume) / (m.reach + 3.0 * m.longest) : std::abs(volume);
  const double height_seen = across / m.longest;
  const bool off_light = !face.perspective || std::abs(volume) > 24.0 * unit * glm::length(m.normal);
  const double perimeter = m.length[0] + m.length[1] + m.length[2];

  Footprint f;
  f.regular = off_light && height_seen >= 40.0 * unit + 100.0 * kUnit * m.longest;
  f.can_cover = f.regular;
  const double s = f.regular ? 3.0 * 7.5 * unit * perimeter / (0.9 * across) : 0.0;
  const double lever = f.regular ? (1.0 + s) * m.longest : m.longest + 4.0 * margin;
  // The longest (u, v, 1) on a padded perspective face is below 1.83.
  const double length = face.perspective ? 1.83 : 1.0;
  f.edges = edge_functions(face, p);
  for (size_t i = 0; i < 3; ++i) {
    if (volume < 0) f.edges[i] = -f.edges[i];
    f.slack[i] = unit * length * (8.5 * m.length[i] + 2.0 * lever);
  }
  if (f.regular) {
    Corners reached = stretched(p, 1.0 + s);
    f.box = moved(picture_box(face, reached), face, reached, 8.0 * unit);
    set_planes(f, face, m, p, volume, s, height_seen, unit);
  } else {
    set_box(f, face, p, margin);
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
