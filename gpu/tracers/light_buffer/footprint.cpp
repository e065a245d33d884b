#include "gpu/tracers/light_buffer/footprint.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "gpu/tracers/light_buffer/picture.h"

namespace gnomon::gpu::light_buffer {

namespace {

// Of the function over the part of the footprint that the rectangle shows.
double greatest(const Linear& function, const Footprint& f, const Rect& rect) {
  const Rect part = common(rect, f.box);
  return std::max(function.x * part.u0, function.x * part.u1) +
         std::max(function.y * part.v0, function.y * part.v1) + function.z;
}

const AreaFootprint* of_area(const Footprint& f) {
  return f.has_extent ? static_cast<const AreaFootprint*>(&f) : nullptr;
}

}  // namespace

uint32_t faces_met(double diameter, double radius, const Corners& p) {
  const double margin = diameter / 4000.0 + (radius > 0.0 ? radius + 4.0 * kUnit * diameter : 0.0);
  const glm::dvec3 low = glm::min(p[0], glm::min(p[1], p[2])), high = glm::max(p[0], glm::max(p[1], p[2]));
  const glm::dvec3 lo = low - (high - low) - margin, hi = high + (high - low) + margin;
  uint32_t met = 0;
  for (int m = 0; m < 3; ++m) {
    const int u = (m + 1) % 3, v = (m + 2) % 3;
    const double aside = std::max({lo[u], -hi[u], lo[v], -hi[v]}) / kShown;
    // Along the negative axis, depths run from -hi to -lo.
    if (hi[m] >= std::max(aside, 0.0)) met |= 1u << (2 * m);
    if (-lo[m] >= std::max(aside, 0.0)) met |= 2u << (2 * m);
  }
  return met;
}

std::optional<Footprint> footprint(const Face& face, double diameter, const Corners& corners) {
  const Corners p = {face.to_face(corners[0]), face.to_face(corners[1]), face.to_face(corners[2])};
  const double unit = kUnit * diameter;
  const double margin = diameter / 4000.0;
  const Measure m = measure(p);
  // The volume over the light, or the area seen by it; per length of direction, at least `across`.
  const double volume = face.perspective ? glm::dot(m.normal, p[0]) : m.normal.z;
  const double across = face.perspective ? std::abs(volume) / (m.reach + 3.0 * m.longest) : std::abs(volume);
  const double height_seen = across / m.longest;
  const bool off_light = !face.perspective || std::abs(volume) > 24.0 * unit * glm::length(m.normal);
  const double perimeter = m.length[0] + m.length[1] + m.length[2];

  Footprint f;
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
  expect(f, 0.5 * glm::length(m.normal));
  return f;
}

void expect(Footprint& f, double area) {
  constexpr double kBacks = 0.5;
  const double whole = (f.box.u1 - f.box.u0) * (f.box.v1 - f.box.v0);
  if (std::isfinite(whole) && whole > 0.0) f.asking = (f.faces_light ? 1.0 : kBacks) * area / whole;
}

Quarters::Quarters(const Rect& first, const Rect& last)
    : sides{first, last},
      u{0.5 * (first.u0 + first.u1), 0.5 * (last.u0 + last.u1)},
      v{0.5 * (first.v0 + first.v1), 0.5 * (last.v0 + last.v1)},
      half_u(0.5 * std::max(first.u1 - first.u0, last.u1 - last.u0)),
      half_v(0.5 * std::max(first.v1 - first.v0, last.v1 - last.v0)) {}

uint32_t quarters_met(const Footprint& f, const Quarters& q) {
  const Rect &a = q.sides[0], &b = q.sides[1];
  const uint32_t left = f.box.u0 <= a.u1 && f.box.u1 >= a.u0 ? 0b0101 : 0;
  const uint32_t right = f.box.u0 <= b.u1 && f.box.u1 >= b.u0 ? 0b1010 : 0;
  const uint32_t low = f.box.v0 <= a.v1 && f.box.v1 >= a.v0 ? 0b0011 : 0;
  const uint32_t high = f.box.v0 <= b.v1 && f.box.v1 >= b.v0 ? 0b1100 : 0;
  const uint32_t boxes = (left | right) & (low | high);
  // Where the box tells it, the edges need not.
  if ((boxes & (boxes - 1)) == 0 && (boxes == 0 || q.holds(f.box, static_cast<uint32_t>(std::countr_zero(boxes)))))
    return boxes;
  // Signs of how far inside of all edges a quarter reaches, and how far outside of all, each for the four quarters.
  std::array<uint64_t, 4> upright{}, turned{};
  const auto sign = [](double value) { return std::bit_cast<uint64_t>(value); };
  for (size_t i = 0; i < 3; ++i) {
    const Linear& edge = f.edges[i];
    const double swing = std::abs(edge.x) * q.half_u + std::abs(edge.y) * q.half_v + f.slack[i];
    const double u0 = edge.x * q.u[0] + edge.z, u1 = edge.x * q.u[1] + edge.z;
    const double v0 = edge.y * q.v[0], v1 = edge.y * q.v[1];
    const std::array<double, 4> middles = {u0 + v0, u1 + v0, u0 + v1, u1 + v1};
    for (size_t c = 0; c < 4; ++c) upright[c] |= sign(swing + middles[c]);
    if (f.regular) continue;
    for (size_t c = 0; c < 4; ++c) turned[c] |= sign(swing - middles[c]);
  }
  uint32_t missed = 0;
  for (uint32_t c = 0; c < 4; ++c)
    missed |= static_cast<uint32_t>((f.regular ? upright[c] : upright[c] & turned[c]) >> 63) << c;
  return boxes & ~missed;
}

bool edges_meet(const Footprint& f, const Rect& rect) {
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

bool edges_cover(const Footprint& f, const Rect& rect) {
  const double u = 0.5 * (rect.u0 + rect.u1), v = 0.5 * (rect.v0 + rect.v1);
  const double half_u = 0.5 * (rect.u1 - rect.u0), half_v = 0.5 * (rect.v1 - rect.v0);
  const AreaFootprint* area = of_area(f);
  const std::array<Linear, 3>& edges = area != nullptr ? area->cover_edges : f.edges;
  const std::array<double, 3>& slack = area != nullptr ? area->cover_slack : f.slack;
  for (size_t i = 0; i < 3; ++i) {
    const double swing = std::abs(edges[i].x) * half_u + std::abs(edges[i].y) * half_v;
    if (at(edges[i], u, v) < swing + slack[i]) return false;
  }
  return true;
}

double excess(const Footprint& f, const Rect& rect, const Linear& plane) {
  const double most = greatest(f.nearest - plane, f, rect);
  const AreaFootprint* area = of_area(f);
  if (area == nullptr || !area->least) return most;
  double bound = std::min(most, greatest(Linear(0, 0, *area->least) - plane, f, rect));
  for (size_t i = 0; i < 3; ++i) {
    if (area->widening[i] == 0.0) continue;
    const Linear widened = (f.edges[i] + Linear(0, 0, kCutRounding)) * area->widening[i];
    bound = std::min(bound, greatest(widened - plane, f, rect));
  }
  return bound;
}

}  // namespace gnomon::gpu::light_buffer
