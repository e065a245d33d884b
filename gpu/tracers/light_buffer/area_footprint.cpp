#include <algorithm>
#include <cmath>
#include <span>

#include "gpu/tracers/light_buffer/footprint.h"
#include "gpu/tracers/light_buffer/picture.h"

namespace gnomon::gpu::light_buffer {
namespace {

struct Dilated {
  Rect box;
  double depth;  // of a corner of what the face may show, the least
};

// The box of the picture of a triangle whose points may each be displaced by `by`, corner by corner, as a light may be
// large beside its distance from a corner. nullopt if the face shows nothing of it.
std::optional<Dilated> dilated(const Corners& p, double by) {
  const double across = 1.5 * by;
  const Polygon shown = shown_part(p, across);
  if (shown.count == 0) return std::nullopt;
  Dilated out{{kInfinity, kInfinity, -kInfinity, -kInfinity}, kInfinity};
  for (const glm::dvec3& q : std::span(shown.corners.data(), shown.count)) {
    out.depth = std::min(out.depth, q.z);
    out.box = {std::min(out.box.u0, (q.x - across) / q.z), std::min(out.box.v0, (q.y - across) / q.z),
               std::max(out.box.u1, (q.x + across) / q.z), std::max(out.box.v1, (q.y + across) / q.z)};
  }
  if (out.depth <= 1e-6 * by) {
    out.box = kEverywhere;
  } else {
    out.box = {out.box.u0 - kCutRounding, out.box.v0 - kCutRounding, out.box.u1 + kCutRounding,
               out.box.v1 + kCutRounding};
  }
  return out;
}

// The unit normal of a plane on which points a and b have the value `offset`, next to `inward`, the unit normal of the
// plane through a, b and the reference. nullopt if the line through a and b comes that near to the reference.
std::optional<glm::dvec3> tilted(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& inward,
                                 double offset) {
  const glm::dvec3 along = b - a;
  const glm::dvec3 foot = a - along * (glm::dot(a, along) / glm::dot(along, along));
  const double squared = glm::dot(foot, foot);
  if (!(squared > 1.001 * offset * offset)) return std::nullopt;
  return std::sqrt(1.0 - offset * offset / squared) * inward + (offset / squared) * foot;
}

glm::dvec3 inward_normal(const glm::dvec3& a, const glm::dvec3& b, double volume) {
  return glm::normalize(glm::cross(a, b)) * (volume < 0.0 ? -1.0 : 1.0);
}

struct Light {
  double reach = 0;     // of a segment's end
  double farthest = 0;  // that a query's point can be
  double slack() const { return kCutRounding - 0.999 * reach / farthest; }
};

// The lines beyond which the triangle hides no point of the light. `depth`: the least of what the face shows of it.
void set_outer_edges(AreaFootprint& f, const Corners& p, double volume, const Light& light, double by,
                     double depth) {
  const double reach = light.reach + by;
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3 &a = p[i], &b = p[(i + 1) % 3];
    const auto normal = tilted(a, b, inward_normal(a, b, volume), reach);
    f.edges[i] = normal.value_or(glm::dvec3(0.0));
    const double missing = normal ? reach - glm::dot(*normal, p[(i + 2) % 3]) : kInfinity;
    f.slack[i] = missing <= 0.0 ? light.slack() : kCutRounding + 1.001 * missing / depth;
    f.widening[i] = missing <= 0.0 ? 1.0 / light.reach : 0.0;
  }
}

// The lines within which it hides every point; false if there are none. `kept`: from each edge, as a share of the height
// over it.
bool set_inner_edges(AreaFootprint& f, const Corners& p, double volume, const Light& light,
                     const std::array<double, 3>& kept) {
  const double all = kept[0] + kept[1] + kept[2];
  if (!(all < 0.5)) return false;
  const glm::dvec3 middle = kept[1] * p[0] + kept[2] * p[1] + kept[0] * p[2];
  Corners inner;
  for (size_t k = 0; k < 3; ++k) inner[k] = middle + (1.0 - all) * p[k];
  for (size_t i = 0; i < 3; ++i) {
    const glm::dvec3 &a = inner[i], &b = inner[(i + 1) % 3];
    const auto normal = tilted(a, b, inward_normal(a, b, volume), -light.reach);
    if (!normal) return false;
    f.cover_edges[i] = *normal;
    f.cover_slack[i] = light.slack();
  }
  return true;
}

}  // namespace

std::optional<AreaFootprint> area_footprint(const Face& face, double diameter, double radius,
                                            const Corners& corners) {
  const Corners p = {face.to_face(corners[0]), face.to_face(corners[1]), face.to_face(corners[2])};
  const double unit = kUnit * diameter, by = 8.0 * unit, margin = diameter / 4000.0;
  const Light light{radius + 4.0 * unit, face.farthest};
  const Measure m = measure(p);
  const double size = glm::length(m.normal), volume = glm::dot(m.normal, p[0]);
  // As in footprint(), over all points of the light.
  const double least_volume = std::abs(volume) - size * light.reach;
  const double across = std::max(least_volume, 0.0) / (m.reach + 3.0 * m.longest + 2.0 * margin + light.reach);
  const double height_seen = across / m.longest, perimeter = m.length[0] + m.length[1] + m.length[2];
  const bool off_light = least_volume > 24.0 * unit * size;

  AreaFootprint f;
  f.faces_light = volume < 0.0;
  f.regular = off_light && height_seen >= 40.0 * unit + 100.0 * kUnit * m.longest;
  f.can_cover = f.regular;
  if (f.regular) {
    const double s = 3.0 * 7.5 * unit * perimeter / (0.9 * across);
    const Corners reached = stretched(p, 1.0 + s);
    const auto shown = dilated(reached, light.reach + by);
    if (!shown) return std::nullopt;
    f.box = shown->box;
    const double distance = std::abs(volume) / size - light.reach - by;
    const double depth = std::max(shown->depth - light.reach - by, distance / 1.84);
    f.least = 1.001 / depth;
    set_planes(f, face, m, p, volume, s, height_seen, unit);
    set_outer_edges(f, reached, volume, light, by, depth);
    std::array<double, 3> kept;
    for (size_t i = 0; i < 3; ++i) kept[i] = unit * (8.5 * m.length[i] + 2.0 * (1.0 + s) * m.longest) / across;
    f.can_cover = f.can_cover && set_inner_edges(f, p, volume, light, kept);
    expect(f, 0.5 * size);
    return f;
  }
  f.slack.fill(kInfinity);
  if (!set_box(f, face, p, margin + light.reach)) return std::nullopt;
  constexpr double kLeastHeight = 6.0;
  if (off_light && height_seen >= kLeastHeight * unit) {
    const double thin = 3.0 * 7.5 * unit * perimeter / (across - 4.0 * unit * m.longest);
    const auto shown = dilated(stretched(p, 1.0 + thin), light.reach + by);
    if (!shown) return std::nullopt;
    f.box = common(f.box, shown->box);
    if (f.box.u0 > f.box.u1 || f.box.v0 > f.box.v1) return std::nullopt;
  }
  expect(f, 0.5 * size);
  return f;
}

}  // namespace gnomon::gpu::light_buffer
