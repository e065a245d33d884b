#include "gpu/tracers/light_buffer/footprint.h"

#include <algorithm>
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
  f.cover_edges = f.edges;
  f.cover_slack = f.slack;
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
  for (size_t i = 0; i < 3; ++i) {
    const Linear& edge = f.cover_edges[i];
    const double swing = std::abs(edge.x) * half_u + std::abs(edge.y) * half_v;
    if (at(edge, u, v) < swing + f.cover_slack[i]) return false;
  }
  return true;
}

double excess(const Footprint& f, const Rect& rect, const Linear& plane) {
  const double most = greatest(f.nearest - plane, f, rect);
  if (!f.least) return most;
  double bound = std::min(most, greatest(*f.least - plane, f, rect));
  for (size_t i = 0; i < 3; ++i) {
    if (f.widening[i] == 0.0) continue;
    const Linear widened = (f.edges[i] + Linear(0, 0, kCutRounding)) * f.widening[i];
    bound = std::min(bound, greatest(widened - plane, f, rect));
  }
  return bound;
}

}  // namespace gnomon::gpu::light_buffer
