// Triangles as a face shows them: their measures, pictures and planes, of which footprints are made. footprint.h explains
// the numbers.
#pragma once

#include <array>
#include <limits>
#include <optional>

#include "gpu/tracers/light_buffer/footprint.h"

namespace gnomon::gpu::light_buffer {

inline constexpr double kUnit = 0x1p-24;
inline constexpr double kCutRounding = 1e-9;  // of a cut corner's place, with room to spare
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr Rect kEverywhere{-kInfinity, -kInfinity, kInfinity, kInfinity};
// Queries of a perspective face have |u| and |v| below this: 1, the padding of its squares and the rounding of a place.
inline constexpr double kShown = 1.1;

using Corners = std::array<glm::dvec3, 3>;

struct Measure {
  glm::dvec3 normal;             // length: twice the area
  std::array<double, 3> length;  // of edge i, between corners i and i + 1
  double longest = 0;
  double reach = 0;  // of the farthest corner from the reference
};
Measure measure(const Corners& p);

// A triangle that four planes have cut has at most seven corners.
struct Polygon {
  std::array<glm::dvec3, 8> corners;
  size_t count = 0;
};
// What a perspective face may show of a triangle: what has |x| and |y| <= kShown z + reach in its axes.
Polygon shown_part(const Corners& p, double reach);

// Edge functions: positive inside for a triangle whose plane has the reference on its positive side.
std::array<Linear, 3> edge_functions(const Face& face, const Corners& p);

// About the triangle's centre.
Corners stretched(const Corners& p, double factor);

// The box of a triangle that is stretched by `factor` and moved by at most `by`; nullopt if the face shows nothing of it.
std::optional<Rect> stretched_box(const Face& face, const Corners& p, double factor, double by);

// The planes of a regular triangle. `volume`, `s`, `height_seen`, `unit`: see footprint().
void set_planes(Footprint& f, const Face& face, const Measure& m, const Corners& p, double volume, double s,
                double height_seen, double unit);

// The box of an irregular triangle, and the nearness of the nearest place where it can be hit: within its box widened
// by `margin`, as far as the face shows that. False if it shows nothing of it.
bool set_box(Footprint& f, const Face& face, const Corners& p, double margin);

}  // namespace gnomon::gpu::light_buffer
