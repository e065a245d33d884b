// The picture of one triangle on one face of a light, made conservative against the rounding of the triangle test.
//
// segment_meets_triangle computes with floats, so it may say "yes" for segments that pass a triangle by a hair. With
// e = 2^-24, D the scene's diameter, L the triangle's longest edge, n its normal of length 2 * area, and t the unit
// direction of the segment, forward error analysis of the test as written gives:
//   - each of its three edge numbers is off by at most 2 e D |d| (9 |edge| + 2 W), where W bounds the distance of
//     the segment's line from the edge's corners. Here every edge is moved outwards by that (`slack`).
//   - The three slacks stretch the triangle by a factor of 1 + 3 eta about its centre, where
//     eta = e D (9 (sum of edges) + 12 L) / |dot(n, t)|, if W <= 2 L; that is so while eta <= 1. Beyond, the
//     triangle is thinner than rounding: `regular` is false, W is the distance to the light, both orientations
//     count, and nothing may be concluded from its plane.
//   - For regular triangles the side of the plane that a point lies on is right unless the point is nearer to
//     the plane, along t, than 2 e (3 s^2 + 9 s) L^3 / |dot(n, t)|, s = 1 + eta. `nearest` is the plane moved
//     towards the light by that, `cover` away from it.
// tests/light_buffer holds this against brute force over soups made to break it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "gpu/tracers/light_buffer/face.h"

namespace gnomon::gpu::light_buffer {

struct Footprint {
  std::array<Linear, 3> edges;  // inside: all >= 0
  std::array<double, 3> slack;  // can be hit where all >= -slack; is surely hit where all >= slack
  Linear nearest{0.0};          // the triangle's plane as nearness, moved towards the light
  Linear cover{0.0};            // moved away from the light
  Rect box{};                   // of the stretched triangle
  uint32_t triangle = 0;
  bool regular = true;
  bool can_cover = true;
};

// Corners are relative to the light's reference. Nothing: no segment on this face can hit the triangle.
std::optional<Footprint> footprint(const Face& face, double diameter, const std::array<glm::dvec3, 3>& corners);

// May a segment through the rectangle be found to hit the triangle?
bool meets(const Footprint& f, const Rect& rect);

// Is every segment through the rectangle, to a point behind `cover`, found to hit the triangle?
bool covers(const Footprint& f, const Rect& rect);

// Upper bound of f.nearest - plane over what the rectangle shows of a regular triangle.
double excess(const Footprint& f, const Rect& rect, const Linear& plane);

}  // namespace gnomon::gpu::light_buffer
