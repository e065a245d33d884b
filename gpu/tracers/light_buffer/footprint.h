// The picture of one triangle on one face of a light, made conservative against the rounding of the triangle test.
//
// segment_meets_triangle computes with floats, so it may say "yes" for segments that pass a triangle by a hair. With
// e = 2^-24, D the scene's diameter, L the triangle's longest edge, h = 2 * area / L its height, H that height as the
// segment sees it (h times the sine of the angle between segment and plane):
//   - Corners relative to the segment's origin are rounded by e D, but all three edge numbers use the same ones:
//     the test runs on a triangle moved by that. What follows rounds each edge number by 7.5 e D |edge| |d|.
//   - So a segment that is said to hit passes through the moved triangle stretched about its centre by 1 + s,
//     s = 3 * 7.5 e D (sum of edges) / (L H): for H >= 40 e D, s is below 2, and the triangle is `regular`.
//     Each edge is moved outwards by `slack` = e D |d| (8.5 |edge| + 2 (1 + s) L), which bounds all that.
//   - A regular triangle's plane is on the right side of a point unless that is nearer to it, along the segment,
//     than e (4.5 L / h + 4 + 2 s) (1 + s) L / sine. `nearest` is the plane moved towards the light by that,
//     `cover` away from it. The light itself is on the right side if H >= 8 e D and it is 24 e D off the plane.
//   - Other triangles (edge-on to the light, slivers, touching it) may pass the edges and the plane by chance, with
//     either orientation. But the test also asks for a point within D / 4096 of the triangle's box: that box gives
//     them their place and a constant `nearest`, and they never cover.
//   - Whatever its sign, each edge number is within 7.5 e D |edge| |d| of the true one, and the true ones add up to
//     L H |d|: so the segment meets the plane within the triangle stretched by 1 + s, for any s. That bounds the place
//     of irregular triangles that look thin, but not edge-on (H >= 6 e D, less 4 e D as corners move), better than the
//     box does.
//   - A perspective face shows only points with |x| and |y| <= 1.1 z in its axes (1, and more than all padding), so of
//     what can be hit only that part counts, also of triangles that reach behind the light or beside the face. A point
//     q that is hit lies beside a point r of the stretched triangle by at most b = 8 e D: with |q.x| <= 1.1 q.z,
//     |r.x| <= 1.1 r.z + 2.1 b. The triangle is cut with the four planes |x| <= 1.1 z + 2.2 b, |y| likewise. What is
//     left has its least depth z0 at a corner and, as projection keeps lines, the bounds of its picture at corners;
//     |u(q) - u(r)| = |(q.x - r.x) - u(q) (q.z - r.z)| / r.z <= 2.1 b / z0. If z0 <= 16 b the triangle touches the
//     light, for that purpose, and its picture is everywhere. An irregular triangle is hit within its widened box
//     only, in which every point that the face shows has a depth of at least lo.z, lo.x / 1.1, -hi.x / 1.1, lo.y / 1.1
//     and -hi.y / 1.1: that bounds its picture and its `nearest`.
// tests/unit/gpu/light_buffer compares this with brute force over random scenes that are made to break it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "gpu/tracers/light_buffer/face.h"

namespace gnomon::gpu::light_buffer {

struct Footprint {
  std::array<Linear, 3> edges;  // inside: all >= 0
  std::array<double, 3> slack;  // can be hit if all >= -slack; is certainly hit if all >= slack
  Linear nearest{0.0};          // no point in front of this nearness is hidden by the triangle
  Linear cover{0.0};            // every point behind this nearness is hidden, where covers() holds
  Rect box{};                   // the triangle cannot be hit outside
  double area = 0;              // of the triangle, in the world
  uint32_t triangle = 0;
  bool faces_light = true;  // the light is on the side from which the corners run counter-clockwise
  bool regular = true;
  bool bounded = true;  // false: the triangle touches the light, and `nearest` is not defined
  bool can_cover = true;
};

// `corners` are relative to the light's reference. Returns nullopt if no segment on this face can hit the triangle.
std::optional<Footprint> footprint(const Face& face, double diameter, const std::array<glm::dvec3, 3>& corners);

// Whether a segment through the rectangle may be found to hit the triangle.
bool meets(const Footprint& f, const Rect& rect);

// Whether every segment through the rectangle, to a point behind `cover`, is found to hit the triangle.
bool covers(const Footprint& f, const Rect& rect);

// An upper bound of f.nearest - plane over the part of a bounded triangle that the rectangle shows.
double excess(const Footprint& f, const Rect& rect, const Linear& plane);

}  // namespace gnomon::gpu::light_buffer
