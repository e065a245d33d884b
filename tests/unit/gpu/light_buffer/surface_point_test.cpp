// The point of a triangle that a pixel shows, in the arithmetic of the shaders (gpu/shaders/exact.glsl), against doubles.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "gpu/exact_cpp.h"

namespace gnomon::gpu {
namespace {

struct Look {
  glm::vec3 camera, forward, ray;  // the ray has length 1 along `forward`
  glm::vec3 corners[3];
  glm::dvec3 target;  // the point of the triangle that the ray meets

  double depth_of(const glm::dvec3& point) const {
    return glm::dot(point - glm::dvec3(camera), glm::dvec3(forward));
  }
  double nearest() const { return std::min({depth_of(corners[0]), depth_of(corners[1]), depth_of(corners[2])}); }
  double farthest() const { return std::max({depth_of(corners[0]), depth_of(corners[1]), depth_of(corners[2])}); }
  exact::SurfacePoint surface() const {
    return exact::surface_point(camera, forward, ray, corners[0], corners[1], corners[2]);
  }
};

float most(const glm::vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

class Looks {
 public:
  explicit Looks(uint32_t seed) : random_(seed) {}

  // A triangle in front of a camera, from that seen under an angle whose sine is at least 0.1; or edge-on, but for the
  // rounding of its corners.
  Look next(bool edge_on) {
    for (;;) {
      Look look;
      look.camera = point(20.0f);
      look.forward = glm::normalize(point(1.0f));
      for (glm::vec3& corner : look.corners) corner = look.camera + 6.0f * look.forward + point(4.0f);
      if (edge_on) look.corners[2] = in_a_plane_with_the_camera(look);
      if (look.nearest() < 0.5) continue;
      const glm::dvec3 a(look.corners[0]), b(look.corners[1]), c(look.corners[2]);
      const double u = share(), v = share() * (1 - u);
      look.target = a + u * (b - a) + v * (c - a);
      const glm::dvec3 along = look.target - glm::dvec3(look.camera), normal = glm::cross(b - a, c - a);
      if (glm::length(normal) < 0.1) continue;
      const double sine = std::abs(glm::dot(glm::normalize(normal), glm::normalize(along)));
      if (edge_on ? sine > 1e-5 : sine < 0.1) continue;
      look.ray = glm::vec3(along / look.depth_of(look.target));
      return look;
    }
  }

 private:
  double share() { return std::uniform_real_distribution<double>(0.01, 0.99)(random_); }
  glm::vec3 point(float reach) {
    std::uniform_real_distribution<float> within(-reach, reach);
    return {within(random_), within(random_), within(random_)};
  }
  glm::vec3 in_a_plane_with_the_camera(const Look& look) {
    const auto u = static_cast<float>(share()), v = static_cast<float>(2 * share());
    return look.camera + u * (look.corners[0] - look.camera) + v * (look.corners[1] - look.camera);
  }

  std::mt19937 random_;
};

TEST(SurfacePoint, IsWhereThePixelsRayMeetsTheTriangle) {
  Looks looks(1);
  for (int i = 0; i < 20'000; ++i) {
    const Look look = looks.next(false);
    const exact::SurfacePoint surface = look.surface();
    ASSERT_LT(glm::distance(glm::dvec3(surface.position), look.target), 1e-3) << "look " << i;
    ASSERT_LT(glm::dot(surface.normal, look.ray), 0.0f) << "look " << i;
    ASSERT_NEAR(glm::length(surface.normal), 1.0f, 1e-5f) << "look " << i;
    const glm::vec3 off = exact::segment_origin(look.camera, surface) - surface.position;
    ASSERT_GT(glm::dot(off, surface.normal), 0.0f) << "look " << i;
    // A part of the largest coordinate, in which floats are rounded.
    const float largest = std::max(most(look.camera), most(surface.position));
    ASSERT_NEAR(glm::length(off) / largest * 65536, 1.0f, 0.15f) << "look " << i;
  }
}

TEST(SurfacePoint, OfATriangleSeenEdgeOnIsAmongItsDepths) {
  Looks looks(2);
  for (int i = 0; i < 20'000; ++i) {
    const Look look = looks.next(true);
    const double depth = look.depth_of(glm::dvec3(look.surface().position));
    ASSERT_GT(depth, look.nearest() - 1e-4) << "look " << i;
    ASSERT_LT(depth, look.farthest() + 1e-4) << "look " << i;
  }
}

}  // namespace
}  // namespace gnomon::gpu
