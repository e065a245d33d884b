#include "gpu/tracers/light_buffer/face.h"

#include <algorithm>
#include <cmath>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kUnit = 0x1p-24;  // half an ulp of 1: the relative rounding of one float operation
constexpr double kPadding = 0.5;   // of a fixed-point unit, on each side

// Faces 2 m and 2 m + 1 look along the positive and negative axis m; the query picks m as the largest component.
Face cube_face(uint32_t index) {
  const uint32_t axis = index / 2;
  Face face;
  face.u_axis = face.v_axis = face.depth_axis = glm::dvec3(0.0);
  face.u_axis[static_cast<int>((axis + 1) % 3)] = 1.0;
  face.v_axis[static_cast<int>((axis + 2) % 3)] = 1.0;
  face.depth_axis[static_cast<int>(axis)] = index % 2 == 0 ? 1.0 : -1.0;
  face.low_u = face.low_v = -1.0;
  face.size = 2.0;
  return face;
}

// Whether the cone around `axis` may meet the face's pyramid. The test uses the pyramid's circumscribed cone.
bool cone_meets_face(const glm::dvec3& axis, double outer_cone_cos, const Face& face) {
  const double half_angle = std::atan(std::sqrt(2.0)) + 0.01;
  const double cone = std::acos(glm::clamp(outer_cone_cos, -1.0, 1.0));
  return std::acos(glm::clamp(glm::dot(axis, face.depth_axis), -1.0, 1.0)) < cone + half_angle;
}

LightFaces point_faces(const exact::TracedLight& light) {
  LightFaces result;
  result.reference = light.position;
  result.view.reference = light.position;
  for (uint32_t f = 0; f < 6; ++f) {
    result.faces.push_back(cube_face(f));
    result.used[f] = light.kind != 1 || cone_meets_face(light.direction, light.outer_cone_cos, result.faces[f]);
  }
  return result;
}

glm::dvec3 perpendicular(const glm::dvec3& direction) {
  const glm::dvec3 helper = std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, helper));
}

// The reference lies upstream by several diameters, so that most planes have it on their lit side.
LightFaces directional_face(const exact::TracedLight& light, const scenes::Bounds& bounds, double diameter) {
  LightFaces result;
  const glm::dvec3 center = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
  const glm::dvec3 direction = glm::normalize(glm::dvec3(light.direction));
  result.view.reference = glm::vec3(center - direction * (4.0 * diameter));
  result.view.directional = 1;
  result.reference = result.view.reference;
  Face face;
  face.perspective = false;
  face.depth_axis = direction;
  face.u_axis = perpendicular(direction);
  face.v_axis = glm::cross(direction, face.u_axis);
  face.size = 1.05 * diameter;
  face.low_u = glm::dot(face.u_axis, center - result.reference) - 0.5 * face.size;
  face.low_v = glm::dot(face.v_axis, center - result.reference) - 0.5 * face.size;
  const double scale = power_of_two(kIndexBits) / face.size;
  result.view.u_axis = glm::vec3(face.u_axis * scale);
  result.view.v_axis = glm::vec3(face.v_axis * scale);
  result.view.u_offset = static_cast<float>(-face.low_u * scale);
  result.view.v_offset = static_cast<float>(-face.low_v * scale);
  result.view.depth_axis = glm::vec3(direction);
  result.view.direction = light.direction * -light.reach;
  result.faces.push_back(face);
  result.used[0] = true;
  return result;
}

}  // namespace

Rect Face::square(uint32_t level, uint32_t i, uint32_t j) const {
  const double pitch = size * power_of_two(-static_cast<int>(level));
  const double pad = size * kPadding * power_of_two(-static_cast<int>(kIndexBits));
  return {low_u + i * pitch - pad, low_v + j * pitch - pad, low_u + (i + 1) * pitch + pad,
          low_v + (j + 1) * pitch + pad};
}

bool Face::plane(const Linear& f, double towards, glm::vec3& out) const {
  if (perspective) {
    glm::dvec3 p = f.x * u_axis + f.y * v_axis + f.z * depth_axis;
    p += towards * 32.0 * kUnit * glm::length(p) * depth_axis;
    if (!(glm::length(p) < 1e30)) return false;
    out = glm::vec3(p);
    return true;
  }
  const glm::dvec3 normal = depth_axis + f.x * u_axis + f.y * v_axis;
  const double distance = -f.z - towards * 32.0 * kUnit * farthest * (1.0 + glm::length(normal));
  if (distance < 1e-3 * farthest) return false;
  out = glm::vec3(normal / distance);
  return true;
}

float Face::reciprocal_depth(double nearness) const {
  const double reciprocal = perspective ? nearness : 1.0 / std::max(-nearness, 1e-30);
  return static_cast<float>(std::min(reciprocal * (1.0 + 64.0 * kUnit), 1e30));
}

LightFaces light_faces(const exact::TracedLight& light, const scenes::Bounds& bounds) {
  const bool directional = light.kind == 2;
  const glm::vec3 low = directional ? bounds.min : glm::min(bounds.min, light.position - light.radius);
  const glm::vec3 high = directional ? bounds.max : glm::max(bounds.max, light.position + light.radius);
  // Segments start off their surface by a little (segment_origin), hence the allowance.
  const double diameter = 1.05 * glm::distance(glm::dvec3(low), glm::dvec3(high)) + 1e-6;
  LightFaces result = directional ? directional_face(light, bounds, diameter) : point_faces(light);
  result.diameter = diameter;
  for (Face& face : result.faces) face.farthest = directional ? 5.0 * diameter : diameter;
  return result;
}

}  // namespace gnomon::gpu::light_buffer
