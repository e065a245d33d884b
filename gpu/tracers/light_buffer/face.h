// The projection of the world onto a light's faces: picture coordinates (u, v), and a nearness that is linear in them
// over the picture of any plane.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "scenes/scene.h"

namespace gnomon::gpu::light_buffer {

// A linear function of (u, v): x * u + y * v + z.
using Linear = glm::dvec3;

inline double at(const Linear& f, double u, double v) { return f.x * u + f.y * v + f.z; }

// 2^exponent, exactly, which std::ldexp takes far longer for.
constexpr double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<uint64_t>(1023 + exponent) << 52);
}

struct Rect {
  double u0, v0, u1, v1;
};

// What both hold; a rectangle whose low side exceeds its high side is empty.
inline Rect common(const Rect& a, const Rect& b) {
  return {std::max(a.u0, b.u0), std::max(a.v0, b.v0), std::min(a.u1, b.u1), std::min(a.v1, b.v1)};
}

// Picture coordinates of rel are u = dot(u_axis, rel) and v = dot(v_axis, rel), divided by depth in a perspective
// face; depth = dot(depth_axis, rel). Nearness is 1 / depth (perspective) or -depth.
struct Face {
  bool perspective = true;
  glm::dvec3 u_axis, v_axis, depth_axis;
  double low_u = 0, low_v = 0, size = 0;  // the square that the face covers
  double farthest = 0;                    // upper bound of the distance of queried points from the reference

  glm::dvec3 to_face(const glm::dvec3& rel) const {
    return {glm::dot(u_axis, rel), glm::dot(v_axis, rel), glm::dot(depth_axis, rel)};
  }

  // Square (i, j) of 2^level x 2^level, padded by more than the rounding of a query's fixed-point place.
  Rect square(uint32_t level, uint32_t i, uint32_t j) const;

  // Sets `out` to the plane P (dot(P, rel) = 1) on which the nearness is `f`, moved towards the light (`towards` 1) or
  // away from it (-1) by more than the rounding of the shader's dot product. Returns false if the plane has no such
  // form.
  bool plane(const Linear& f, double towards, glm::vec3& out) const;

  // The factor of a depth such that the product is compared with 1, rounded towards the light.
  float reciprocal_depth(double nearness) const;
};

// A light's view and its faces, for a scene within `bounds`. Of a spot light, only the faces that its cone meets are
// used; the others have no footprints.
struct LightFaces {
  LightView view;
  std::vector<Face> faces;
  std::array<bool, 6> used{};
  glm::dvec3 reference;
  double diameter = 0;  // no two of: light, surface points and triangle corners are farther apart
};

LightFaces light_faces(const exact::TracedLight& light, const scenes::Bounds& bounds);

}  // namespace gnomon::gpu::light_buffer
