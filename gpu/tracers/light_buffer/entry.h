// The entries of leaves' lists, packed: where in a leaf a triangle can block, by a box and a strip. A box alone says too
// little, as most triangles in a long list are slivers that cross their box, or have an edge that does.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "gpu/tracers/light_buffer/footprint.h"

namespace gnomon::gpu::light_buffer {

// Where a triangle can block, between two lines: see ListEntry.
struct Strip {
  uint32_t direction = 0;
  int32_t low = -128, high = 127;
};

// Makes the entries of square (i, j) of `level`.
class LeafEntries {
 public:
  LeafEntries(const Face& face, uint32_t level, uint32_t i, uint32_t j);

  // The strip is the narrowest of those along the footprint's edges, and holds every place that a query may compute for a
  // point where the triangle can be hit. `nearness`: no point of the square in front of it is hidden. Returns nullopt if no
  // segment through the square can hit the triangle.
  std::optional<ListEntry> entry(const Footprint& f, double nearness) const;

 private:
  // `low`, `high`: of dot(n, place) for what lies within, in the face's coordinates.
  Strip strip_between(const glm::dvec2& n, double low, double high) const;

  // In 32nds of the leaf's side; `place` in 256ths.
  uint32_t side(double place) const;

  const Face& face_;
  const Rect square_;
  const glm::dvec2 corner_;
  const double scale_;     // from the face's coordinates to 256ths of the leaf's side
  double pad_, rounding_;  // what a query's place is off its true one, upwards and downwards; in 256ths
  int32_t unit_;           // what places are multiples of; in 256ths
};

// Whether a point of this depth lies in front of the triangle.
inline bool in_front(const ListEntry& entry, float depth) {
  return depth * std::bit_cast<float>(entry.depth_and_low >> 1) < 1.0f;
}

// Whether the place (x, y), in 256ths of the leaf's side, lies in the entry's box and strip.
inline bool holds(const ListEntry& entry, uint32_t x, uint32_t y) {
  const uint32_t low = entry.depth_and_low, high = entry.high_and_strip;
  if (x >> 3 < (low & 31) || y >> 3 < (low >> 5 & 31) || x >> 3 > (high & 31) || y >> 3 > (high >> 5 & 31))
    return false;
  const int32_t strip = static_cast<int32_t>(high);
  const int32_t across_x = 32 - (strip >> 10 & 63), across_y = 32 - std::abs(across_x);
  const int32_t across = (across_x * static_cast<int32_t>(x) + across_y * static_cast<int32_t>(y)) >> 6;
  return across >= static_cast<int8_t>(strip >> 16) && across <= strip >> 24;
}

}  // namespace gnomon::gpu::light_buffer
