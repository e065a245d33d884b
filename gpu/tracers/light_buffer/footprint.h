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
//
// Area lights. A query asks for the segments from a point q to points s of a ball of radius R about the reference c, and
// is sorted by its place and depth as seen from c. `across` and the height H are their least over the ball: with
// |volume| - R |n| for |volume|, and R added to the distance. R includes 4 e D, by which rounding moves a segment's end.
//   - A segment that is said to hit passes within b = 8 e D of the stretched triangle, at x = q + t (s - q). The point
//     y = x - t (s - c) lies within b + R of it, and on the segment from q to c: so it has the place of q, and is
//     nowhere deeper. The box is that of the picture of the stretched triangle with every point displaced by b + R: a
//     displacement of length d changes x / z of a point with |x / z| <= 1.1 by at most sqrt(1 + 1.1^2) d / z < 1.5 d / z,
//     where z is the depth of the displaced point's origin. So corners are widened one by one.
//   - `least` is the least depth of y: as deep as the shown part, less b + R, and, as y is at least |volume| / |n| - R - b
//     off the plane through c that is parallel to the triangle's, that divided by 1.83.
//   - The side of an edge: of the two planes through the (stretched) edge that touch the ball about c of radius
//     b + R, take the one that has that ball on its outer side, with the unit normal m inwards. Its points have
//     dot(m, x) = b + R, as seen from c. If the third corner has no less, dot(m, y) >= b + R - b - t R = (1 - t) R, and
//     as y = (1 - t) (q - c), dot(m, (u, v, 1)) >= R / depth(q) >= R / farthest. If it has less, that is missing.
//     So beside the triangle what it hides begins the farther behind it: nearness(q) <= dot(m, (u, v, 1)) / R. Without
//     that bound the planes of triangles beside each other would hide surfaces that curve away from the light.
//   - Near plane: q is on the light's side of the triangle's plane, and so is the whole ball: `nearest` is as above.
//   - Cover: q is behind the plane, the ball before it. The test says yes where the segment meets the plane with
//     barycentric weights of at least e D (8.5 |edge| + 2 (1 + s) L) / across: within a smaller triangle. All of its
//     segments to the ball do so if q is on the inner side of the three planes through the smaller triangle's edges that
//     touch the ball and have it on their inner side: dot(m, q - c) >= -R, or dot(m, (u, v, 1)) >= -R / farthest.
//   - A triangle whose plane passes within the ball, or nearly so, is irregular: it is hit within its widened box, and y
//     within that widened by R more. It has no edges.
// tests/unit/gpu/light_buffer compares this with brute force over random scenes that are made to break it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "gpu/tracers/light_buffer/face.h"

namespace gnomon::gpu::light_buffer {

// As it is made it has no edges: what stays so is bounded by `box` alone, where `slack` is infinite.
struct Footprint {
  std::array<Linear, 3> edges{};  // inside: all >= 0
  std::array<double, 3> slack{};  // can be hit if all >= -slack; of a point light, is certainly hit if all >= slack
  Linear nearest{0.0};            // no point in front of this nearness is hidden by the triangle
  Linear cover{0.0};              // every point behind this nearness is hidden, where covers() holds
  Rect box{};                     // the triangle cannot be hit outside
  double asking = 0;              // area of surface that asks, for each area of the box: see expect()
  uint32_t triangle = 0;
  bool faces_light = true;  // the light is on the side from which the corners run counter-clockwise
  bool regular = true;
  bool bounded = true;  // false: the triangle touches the light, and `nearest` is not defined
  bool can_cover = true;
  bool has_extent = false;  // the light has, and this is an AreaFootprint
};

// Of a light with an extent.
struct AreaFootprint : Footprint {
  AreaFootprint() { has_extent = true; }

  // As the edges, for what is hidden from every point of the light: that is certainly hit if all >= cover_slack.
  std::array<Linear, 3> cover_edges{};
  std::array<double, 3> cover_slack{};
  std::optional<double> least;  // nor is a point in front of this nearness hidden
  // Of each edge: nor one in front of edge * widening + rounding. 0: there is no such bound.
  std::array<double, 3> widening{};
};

// Which of the six faces of a point light may show something of the triangle, by its box alone, and where segments lead
// to points of `radius` around the light: a bit for each face. `corners` are relative to the light's reference. The box is
// that which an irregular triangle can be hit in, and that of a regular one, stretched to no more than three times its size.
uint32_t faces_met(double diameter, double radius, const std::array<glm::dvec3, 3>& corners);

// Sets what surface lies in a footprint's box: a triangle of this area, in the world. Of one that turns its back on the
// light only what belongs to open meshes asks.
void expect(Footprint& f, double area);

// `corners` are relative to the light's reference. Returns nullopt if no segment on this face can hit the triangle. Of a
// triangle that faces_met rules out, the footprint may be everywhere.
std::optional<Footprint> footprint(const Face& face, double diameter, const std::array<glm::dvec3, 3>& corners);

// As footprint, for a light with an extent, of which no point is farther than `radius` from the reference: of the
// segments from points on this face to any of them. Only for perspective faces.
std::optional<AreaFootprint> area_footprint(const Face& face, double diameter, double radius,
                                            const std::array<glm::dvec3, 3>& corners);

// A square's four quarters, by the first and the last; the number of one has a bit for each axis.
struct Quarters {
  Quarters(const Rect& first, const Rect& last);

  bool holds(const Rect& box, uint32_t quarter) const {
    const Rect &across = sides[quarter & 1], &along = sides[quarter >> 1];
    return box.u0 >= across.u0 && box.u1 <= across.u1 && box.v0 >= along.v0 && box.v1 <= along.v1;
  }

  std::array<Rect, 2> sides;
  std::array<double, 2> u, v;  // their middles
  double half_u, half_v;
};

// As meets, of each quarter: a bit for each.
uint32_t quarters_met(const Footprint& f, const Quarters& quarters);

// As meets and covers, where the boxes allow it.
bool edges_meet(const Footprint& f, const Rect& rect);
bool edges_cover(const Footprint& f, const Rect& rect);

// Whether a segment through the rectangle may be found to hit the triangle.
inline bool meets(const Footprint& f, const Rect& rect) {
  return !(f.box.u0 > rect.u1 || f.box.u1 < rect.u0 || f.box.v0 > rect.v1 || f.box.v1 < rect.v0) &&
         edges_meet(f, rect);
}

// Whether every segment through the rectangle, to a point behind `cover`, is found to hit the triangle. What covers the
// rectangle reaches beyond it on all sides.
inline bool covers(const Footprint& f, const Rect& rect) {
  return f.box.u0 <= rect.u0 && f.box.u1 >= rect.u1 && f.box.v0 <= rect.v0 && f.box.v1 >= rect.v1 && f.can_cover &&
         edges_cover(f, rect);
}

// An upper bound of f.nearest - plane over the part of a bounded triangle that the rectangle shows.
double excess(const Footprint& f, const Rect& rect, const Linear& plane);

}  // namespace gnomon::gpu::light_buffer
