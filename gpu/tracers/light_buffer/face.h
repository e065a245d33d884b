// How a light sees the world: a plane picture in coordinates (u, v), and a nearness that is linear over the picture
// of any plane.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "scenes/scene.h"

namespace gnomon::gpu::light_buffer {

// A linear function of (u, v): x * u + y * v + z.
using Linear = glm::dvec3;

inline double at(const Linear& f, double u, double v) { return f.x * u + f.y * v + f.z; }

struct Rect {
  double u0, v0, u1, v1;
};

// Picture coordinates of rel are u = dot(u_axis, rel) and v = dot(v_axis, rel), divided by depth in a perspective
// face; depth = dot(depth_axis, rel). Nearness is 1 / depth (perspective) or -depth.
struct Face {
  bool perspective = true;
  glm::dvec3 u_axis, v_axis, depth_axis;
  double low_u = 0, low_v = 0, size = 0;  // the square that the face covers
  double farthest = 0;                    // no point asked for is farther from the reference

  glm::dvec3 to_face(const glm::dvec3& rel) const {
    return {glm::dot(u_axis, rel), glm::dot(v_axis, rel), glm::dot(depth_axis, rel)};
  }

  // Square (i, j) of 2^level x 2^level, padded by more than the rounding of a query's fixed-point place.
  Rect square(uint32_t level, uint32_t i, uint32_t j) const;

  // Where within square (i, j) of `level` a query's place may be for a point of `box`; as ListEntry::box.
  uint32_t box_in_square(const Rect& box, uint32_t level, uint32_t i, uint32_t j) const;

  // The plane P (dot(P, rel) = 1) on which the nearness is `f`, moved towards the light (`towards` 1) or away (-1)
  // by more than the rounding of the shader's dot product. False: such a plane has no such form.
  bool plane(const Linear& f, double towards, glm::vec3& out) const;

  // What depth is multiplied with to be compared with 1, rounded towards the light.
  float reciprocal_depth(double nearness) const;
};

// A light's own view and its faces, for a scene within `bounds`. A spot light has the faces that its cone meets; the
// others have no footprints to show (`used` false).
struct LightFaces {
  LightView view;
  std::vector<Face> faces;
  std::array<bool, 6> used{};
  glm::dvec3 reference;
  double diameter = 0;  // no two of: light, surface points and triangle corners are farther apart
};

LightFaces light_faces(const exact::TracedLight& light, const scenes::Bounds& bounds);

}  // namespace gnomon::gpu::light_buffer
