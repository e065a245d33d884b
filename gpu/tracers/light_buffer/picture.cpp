#include "gpu/tracers/light_buffer/picture.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace gnomon::gpu::light_buffer {
namespace {

// Leaves what remains of the polygon where dot(plane, q) <= reach: mostly all of it.
void clip(Polygon& polygon, const glm::dvec3& plane, double reach) {
  std::array<double, 8> out;
  bool whole = true;
  for (size_t i = 0; i < polygon.count; ++i) {
    out[i] = glm::dot(plane, polygon.corners[i]) - reach;
    whole = whole && out[i] <= 0.0;
  }
  if (whole) return;
  Polygon kept;
  for (size_t i = 0; i < polygon.count; ++i) {
    const size_t next = i + 1 == polygon.count ? 0 : i + 1;
    const glm::dvec3& a = polygon.corners[i];
    const glm::dvec3& b = polygon.corners[next];
    if (out[i] <= 0.0) kept.corners[kept.count++] = a;
    if ((out[i] <= 0.0) != (out[next] <= 0.0))
      kept.corners[kept.count++] = a + (b - a) * (out[i] / (out[i] - out[next]));
  }
  polygon = kept;
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
  const Polygon shown = shown_part(p, 2.2 * by);
  if (shown.count == 0) return std::nullopt;
  const std::span<const glm::dvec3> corners(shown.corners.data(), shown.count);
  const double depth = std::ranges::min(corners, {}, &glm::dvec3::z).z;
  if (depth <= 16.0 * by) return kEverywhere;  // it touches the light
  std::array<glm::dvec2, 8> places;
  for (size_t i = 0; i < corners.size(); ++i) places[i] = glm::dvec2(corners[i]) / corners[i].z;
  const std::span<const glm::dvec2> picture(places.data(), corners.size());
  return padded(box_of(picture), 2.2 * by / depth + kCutRounding);
}

// Of what a perspective face shows of a box.
double least_depth(const glm::dvec3& lo, const glm::dvec3& hi) {
  return std::max({lo.z, lo.x / kShown, -hi.x / kShown, lo.y / kShown, -hi.y / kShown});
}

}  // namespace

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

std::array<Linear, 3> edge_functions(const Face& face, const Corners& p) {
  std::array<Linear, 3> edges;
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3& a = p[i];
    const glm::dvec3& b = p[(i + 1) % 3];
    edges[i] = face.perspective ? glm::cross(a, b) : Linear(a.y - b.y, b.x - a.x, a.x * b.y - a.y * b.x);
  }
  return edges;
}

Polygon shown_part(const Corners& p, double reach) {
  Polygon shown{{p[0], p[1], p[2]}, 3};
  for (const glm::dvec3& side : {glm::dvec3(1, 0, -kShown), glm::dvec3(-1, 0, -kShown), glm::dvec3(0, 1, -kShown),
                                 glm::dvec3(0, -1, -kShown)}) {
    clip(shown, side, reach);
  }
  return shown;
}

Corners stretched(const Corners& p, double factor) {
  const glm::dvec3 center = (p[0] + p[1] + p[2]) / 3.0;
  return {center + factor * (p[0] - center), center + factor * (p[1] - center), center + factor * (p[2] - center)};
}

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

std::optional<Rect> stretched_box(const Face& face, const Corners& p, double factor, double by) {
  const Corners reached = stretched(p, factor);
  if (face.perspective) return shown_box(reached, by);
  return padded(box_of(std::array{glm::dvec2(reached[0]), glm::dvec2(reached[1]), glm::dvec2(reached[2])}), by);
}

}  // namespace gnomon::gpu::light_buffer
