#include "gpu/tracers/light_buffer/entry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kWide = 32.0;         // |x| + |y| of the direction across a strip
constexpr double kCutRounding = 1e-6;  // of the slack, with room to spare for what doubles round
constexpr double kNarrowBox = 16.0;    // of 256ths: boxes that are narrower need no strip

// What is left of a square, cut along three edges: seven corners at most.
struct Region {
  std::array<glm::dvec2, 8> corners;
  size_t count;
};

// Leaves what has edge >= -slack. Returns whether it cut.
bool cut(Region& region, const Linear& edge, double slack) {
  std::array<double, 8> inside;
  double least = 0.0;
  for (size_t k = 0; k < region.count; ++k) {
    inside[k] = at(edge, region.corners[k].x, region.corners[k].y) + slack;
    least = std::min(least, inside[k]);
  }
  if (least >= 0.0) return false;
  Region kept;
  kept.count = 0;
  for (size_t k = 0; k < region.count; ++k) {
    const size_t next = k + 1 == region.count ? 0 : k + 1;
    if (inside[k] >= 0.0) kept.corners[kept.count++] = region.corners[k];
    if ((inside[k] >= 0.0) != (inside[next] >= 0.0)) {
      const double share = inside[k] / (inside[k] - inside[next]);
      kept.corners[kept.count++] = region.corners[k] + (region.corners[next] - region.corners[k]) * share;
    }
  }
  region.count = kept.count;
  std::copy_n(kept.corners.begin(), kept.count, region.corners.begin());
  return true;
}

// Where a footprint can be hit, in one piece or, if it may be hit either way round, in two.
struct Hit {
  std::array<Region, 2> regions;
  size_t count = 0;
  std::array<bool, 3> by{};  // the edges that bound it

  bool empty() const { return regions[0].count == 0 && (count < 2 || regions[1].count == 0); }

  void add(const Footprint& f, const Rect& r, double side) {
    Region& region = regions[count++];
    region.corners = {glm::dvec2(r.u0, r.v0), {r.u1, r.v0}, {r.u1, r.v1}, {r.u0, r.v1}};
    region.count = 4;
    for (size_t k = 0; k < 3; ++k)
      by[k] = cut(region, side * f.edges[k], f.slack[k] * (1.0 + kCutRounding)) || by[k];
  }
};

// The direction across a strip along the edge: |x| + |y| = kWide, y >= 0. nullopt if the edge has none.
std::optional<glm::dvec2> across(const Linear& edge) {
  const double size = std::abs(edge.x) + std::abs(edge.y);
  if (!(size > 0.0) || !std::isfinite(size)) return std::nullopt;
  const double exact = (edge.y < 0.0 ? -edge.x : edge.x) / size * kWide;
  const int rounded = static_cast<int>(exact + kWide + 0.5) - static_cast<int>(kWide);
  const double x = rounded == -static_cast<int>(kWide) ? kWide : rounded;  // the same strip
  return glm::dvec2(x, kWide - std::abs(x));
}

// The upper bits of a float that is not negative, rounded up.
uint32_t upper_bits(float value) {
  constexpr uint32_t kDropped = 9;
  const uint32_t bits = std::bit_cast<uint32_t>(std::max(value, 0.0f));
  return (bits >> kDropped) + ((bits & ((1u << kDropped) - 1)) != 0 ? 1 : 0);
}

// The greatest integer that is not larger, within [low, high]; quicker than std::floor on a plain x86-64.
int32_t floor_within(double value, int32_t low, int32_t high) {
  return static_cast<int32_t>(std::clamp<double>(value, low, high) - low) + low;
}

}  // namespace

LeafEntries::LeafEntries(const Face& face, uint32_t level, uint32_t i, uint32_t j)
    : face_(face),
      square_(face.square(level, i, j)),
      corner_(face.low_u + i * face.size * power_of_two(-static_cast<int>(level)),
              face.low_v + j * face.size * power_of_two(-static_cast<int>(level))),
      scale_(256.0 / face.size * power_of_two(static_cast<int>(level))) {
  const double unit = power_of_two(static_cast<int>(level) - 8);
  unit_ = std::max(static_cast<int32_t>(unit), 1);
  pad_ = 0.5 * unit;
  rounding_ = std::max(unit, 1.0) + pad_;
}

std::optional<ListEntry> LeafEntries::entry(const Footprint& f, double nearness) const {
  const Rect rect = common(square_, f.box);
  Strip strip;
  if (std::min(rect.u1 - rect.u0, rect.v1 - rect.v0) * scale_ > kNarrowBox) {
    Hit hit;
    hit.add(f, rect, 1.0);
    if (!f.regular) hit.add(f, rect, -1.0);
    if (hit.empty()) return std::nullopt;
    double least = 1e30;
    for (size_t k = 0; k < 3; ++k) {
      const auto n = hit.by[k] ? across(f.edges[k]) : std::nullopt;
      if (!n) continue;
      double low = 1e30, high = -1e30;
      for (const Region& region : std::span(hit.regions).first(hit.count)) {
        for (const glm::dvec2& corner : std::span(region.corners).first(region.count)) {
          const double d = glm::dot(*n, corner);
          low = std::min(low, d);
          high = std::max(high, d);
        }
      }
      const double width = (high - low) * (high - low) / glm::dot(*n, *n);  // squared
      if (width >= least) continue;
      least = width;
      strip = strip_between(*n, low, high);
    }
  }
  const glm::dvec2 low = (glm::dvec2(f.box.u0, f.box.v0) - corner_) * scale_ - pad_;
  const glm::dvec2 high = (glm::dvec2(f.box.u1, f.box.v1) - corner_) * scale_ + pad_;
  return ListEntry{upper_bits(face_.reciprocal_depth(nearness)) << 10 | side(low.y) << 5 | side(low.x),
                   static_cast<uint32_t>(strip.high & 255) << 24 | static_cast<uint32_t>(strip.low & 255) << 16 |
                       strip.direction << 10 | side(high.y) << 5 | side(high.x),
                   f.triangle};
}

uint32_t LeafEntries::side(double place) const {
  return static_cast<uint32_t>(floor_within(place, 0, 255) & ~(unit_ - 1)) >> 3;
}

// A query's place is its true one, in 256ths of the leaf's side, rounded down to what fixed point and these can tell,
// after it was computed in floats, which moves it by less than Face::square pads.
Strip LeafEntries::strip_between(const glm::dvec2& n, double low, double high) const {
  const double origin = glm::dot(n, corner_), right = std::max(n.x, 0.0) + n.y, left = std::max(-n.x, 0.0);
  const double first = (low - origin) * scale_ - right * rounding_ - left * pad_ - kCutRounding;
  const double last = (high - origin) * scale_ + left * rounding_ + right * pad_ + kCutRounding;
  return {static_cast<uint32_t>(kWide - n.x), floor_within(first / 64.0, -128, 127),
          floor_within(last / 64.0, -128, 127)};
}

}  // namespace gnomon::gpu::light_buffer
