#include "gpu/tracers/light_buffer/footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kUnit = 0x1p-24;
constexpr double kCutRounding = 1e-9;  // of a cut corner's place, with room to spare
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

// Queries of a perspective face have |u| and |v| below this: 1, the padding of its squares and the rounding of a place.
constexpr double kShown = 1.1;

// A triangle that four planes have cut has at most seven corners.
struct Polygon {
  std::array<glm::dvec3, 8> corners;
  size_t count = 0;
};

// What remains of the polygon where dot(plane, q) <= reach.
Polygon clipped(const Polygon& polygon, const glm::dvec3& plane, double reach) {
  Polygon kept;
  for (size_t i = 0; i < polygon.count; ++i) {
    const glm::dvec3& a = polygon.corners[i];
    const glm::dvec3& b = polygon.corners[(i + 1) % polygon.count];
    const double out_a = glm::dot(plane, a) - reach, out_b = glm::dot(plane, b) - reach;
    if (out_a <= 0.0) kept.corners[kept.count++] = a;
    if ((out_a <= 0.0) != (out_b <= 0.0)) kept.corners[kept.count++] = a + (b - a) * (out_a / (out_a - out_b));
  }
  return kept;
}

template <class Points>
Rect box_of(const Points& points) {
  Rect box{kInfinity, kInfinity, -kInfinity, -kInfinity};
  for (const glm::dvec2& p : points) {
    box = {std::min(box.u0, p.x), std::min(box.v0, p.y), std::max(box.u1, p.x), std::max(box.v1, p.y)};
  }
  return box;
}

Rect padded(const Rect& box, double pad) { return {box.u0 - pad, box.v0 - pad, box.u1 + pad, box.v1 + pad}; }

// The box of the picture, on a perspective face, of a triangle whose points may each be displaced by `by`; nullopt if
// the face shows nothing of it. The header explains the numbers.
std::optional<Rect> shown_box(const Corners& p, double by) {
  Polygon shown{{p[0], p[1], p[2]}, 3};
  const double reach = 2.2 * by;
  for (const glm::dvec3& side : {glm::dvec3(1, 0, -kShown), glm::dvec3(-1, 0, -kShown), glm::dvec3(0, 1, -kShown),
                                 glm::dvec3(0, -1, -kShown)}) {
    shown = clipped(shown, side, reach);
  }
  if (shown.count == 0) return std::nullopt;
  const std::span<const glm::dvec3> corners(shown.corners.data(), shown.count);
  const double depth = std::ranges::min(corners, {}, &glm::dvec3::z).z;
  if (depth <= 16.0 * by) return kEverywhere;  // it touches the light
  std::array<glm::dvec2, 8> places;
  for (size_t i = 0; i < corners.size(); ++i) places[i] = glm::dvec2(corners[i]) / corners[i].z;
  const std::span<const glm::dvec2> picture(places.data(), corners.size());
  return padded(box_of(picture), 2.2 * by / depth + kCutRounding);
}

Corners stretched(const Corners& p, double factor) {
  const glm::dvec3 center = (p[0] + p[1] + p[2]) / 3.0;
  return {center + factor * (p[0] - center), center + factor * (p[1] - center), center + factor * (p[2] - center)};
}

// Of what a perspective face shows of a box.
double least_depth(const glm::dvec3& lo, const glm::dvec3& hi) {
  return std::max({lo.z, lo.x / kShown, -hi.x / kShown, lo.y / kShown, -hi.y / kShown});
}

// Whether a perspective face certainly shows nothing of the triangle, by its box alone: the box that an irregular
// triangle can be hit in, and that of a regular one, stretched to no more than three times its size.
bool beside(const Corners& p, double margin) {
  const glm::dvec3 low = glm::min(p[0], glm::min(p[1], p[2])), high = glm::max(p[0], glm::max(p[1], p[2]));
  const glm::dvec3 lo = low - (high - low) - margin, hi = high + (high - low) + margin;
  return least_depth(lo, hi) > hi.z || hi.z < 0.0;
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

// The box of an irregular triangle, and the nearness of the nearest place where it can be hit: within its box widened
// by `margin`, as far as the face shows that. False if it shows nothing of it.
bool set_box(Footprint& f, const Face& face, const Corners& p, double margin) {
  const glm::dvec3 lo = glm::min(p[0], glm::min(p[1], p[2])) - margin;
  const glm::dvec3 hi = glm::max(p[0], glm::max(p[1], p[2])) + margin;
  if (!face.perspective) {
    f.box = {lo.x, lo.y, hi.x, hi.y};
    f.nearest = Linear(0, 0, -lo.z);
    return true;
  }
  const double depth = least_depth(lo, hi);
  if (depth > hi.z) return false;
  f.bounded = depth > 1e-9 * glm::length(hi - lo);
  if (!f.bounded) {
    f.box = kEverywhere;
    return true;
  }
  f.box = {lo.x / (lo.x < 0.0 ? depth : hi.z), lo.y / (lo.y < 0.0 ? depth : hi.z),
           hi.x / (hi.x > 0.0 ? depth : hi.z), hi.y / (hi.y > 0.0 ? depth : hi.z)};
  f.nearest = Linear(0, 0, 1.0 / depth);
  return true;
}

// The box of a triangle that is stretched by `factor` and moved by at most `by`; nullopt if the face shows nothing of it.
std::optional<Rect> stretched_box(const Face& face, const Corners& p, double factor, double by) {
  const Corners reached = stretched(p, factor);
  if (face.perspective) return shown_box(reached, by);
  return padded(box_of(std::array{glm::dvec2(reached[0]), glm::dvec2(reached[1]), glm::dvec2(reached[2])}), by);
}

}  // namespace

std::optional<Footprint> footprint(const Face& face, double diameter, const Corners& corners) {
  const Corners p = {face.to_face(corners[0]), face.to_face(corners[1]), face.to_face(corners[2])};
  const double unit = kUnit * diameter;
  const double margin = diameter / 4000.0;
  if (face.perspective && beside(p, margin)) return std::nullopt;
  const Measure m = measure(p);
  // The volume over the light, or the area seen by it; per length of direction, at least `across`.
  const double volume = face.perspective ? glm::dot(m.normal, p[0]) : m.normal.z;
  const double across = face.perspective ? std::abs(volume) / (m.reach + 3.0 * m.longest) : std::abs(volume);
  const double height_seen = across / m.longest;
  const bool off_light = !face.perspective || std::abs(volume) > 24.0 * unit * glm::length(m.normal);
  const double perimeter = m.length[0] + m.length[1] + m.length[2];

  Footprint f;
  f.area = 0.5 * glm::length(m.normal);
  f.faces_light = volume < 0.0;
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
  // Irregular triangles are stretched the more, the thinner they look, until their widened box says more.
  constexpr double kLeastHeight = 6.0;
  std::optional<Rect> reached = kEverywhere;
  if (f.regular) {
    reached = stretched_box(face, p, 1.0 + s, 8.0 * unit);
  } else if (off_light && height_seen >= kLeastHeight * unit) {
    const double thin = 3.0 * 7.5 * unit * perimeter / (across - 4.0 * unit * m.longest);
    reached = stretched_box(face, p, 1.0 + thin, 8.0 * unit);
  }
  if (!reached) return std::nullopt;
  if (f.regular) {
    f.box = *reached;
    set_planes(f, face, m, p, volume, s, height_seen, unit);
  } else {
    if (!set_box(f, face, p, margin)) return std::nullopt;
    f.box = common(f.box, *reached);
    if (f.box.u0 > f.box.u1 || f.box.v0 > f.box.v1) return std::nullopt;
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
