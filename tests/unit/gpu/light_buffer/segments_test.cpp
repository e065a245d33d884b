// Which segments are traced, and which triangles they meet, where two numbers of gpu/shaders/exact.glsl are equal or nearly
// so: what scenes made at random do not ask.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>

#include "gpu/exact_cpp.h"

namespace gnomon::gpu {
namespace {

constexpr uint32_t kPoint = 0, kSpot = 1, kDirectional = 2;
const glm::vec3 kUp(0, 1, 0), kOrigin(1, 2, 3);

exact::TracedLight light_at(const glm::vec3& position, float reach = 0) {
  exact::TracedLight light{};
  light.position = position;
  light.reach = reach;
  light.kind = kPoint;
  return light;
}

bool traced(const exact::TracedLight& light) { return exact::segment_to_light(kOrigin, kUp, light).traced; }

TEST(Segments, InTheSurfacesPlaneAreNotTraced) {
  EXPECT_FALSE(traced(light_at({5, 2, 3})));
  EXPECT_TRUE(traced(light_at({5, 2.001f, 3})));
  exact::TracedLight sun{};
  sun.kind = kDirectional;
  sun.reach = 100;
  sun.direction = {1, 0, 0};
  EXPECT_FALSE(traced(sun));
  sun.direction = {1, -0.001f, 0};
  EXPECT_TRUE(traced(sun));
  EXPECT_FALSE(exact::sample_segment(kOrigin, kUp, {5, 2, 3}).traced);
  EXPECT_TRUE(exact::sample_segment(kOrigin, kUp, {5, 2.001f, 3}).traced);
  // The sphere of the ambient light's segments touches the surface in the point opposite to its normal.
  EXPECT_FALSE(exact::occlusion_segment(kOrigin, kUp, -kUp, 2).traced);
  EXPECT_TRUE(exact::occlusion_segment(kOrigin, kUp, {0.6f, -0.8f, 0}, 2).traced);
}

TEST(Segments, ReachAsFarAsTheLightsRange) {
  EXPECT_TRUE(traced(light_at({1, 6, 3}, 4)));
  EXPECT_FALSE(traced(light_at({1, 6, 3}, 3.99f)));
  EXPECT_TRUE(traced(light_at({1, 6, 3}, 0))) << "without a range";
}

TEST(Segments, LieInTheSpotsCone) {
  exact::TracedLight spot = light_at({5, 5, 3});  // 4 aside of the point, 3 above it
  spot.kind = kSpot;
  spot.direction = {0, -1, 0};
  spot.outer_cone_cos = 0.59f;
  EXPECT_TRUE(traced(spot));
  spot.outer_cone_cos = 0.61f;
  EXPECT_FALSE(traced(spot));
  spot.direction = {0, 1, 0};
  spot.outer_cone_cos = 0.59f;
  EXPECT_FALSE(traced(spot)) << "behind the light";
  spot.direction = {0, 0, 1};
  spot.outer_cone_cos = 0;
  EXPECT_FALSE(traced(spot)) << "a hemisphere has no rim";
}

// Whichever corner is the first, and whichever way they run.
bool meets_at(const glm::vec3& origin, const glm::vec3& direction, float scale) {
  const std::array<glm::vec3, 3> corners{glm::vec3(0, 0, 0), glm::vec3(4, 0, 0), glm::vec3(0, 4, 0)};
  int found = 0;
  for (size_t a = 0; a < 3; ++a) {
    for (const auto& [b, c] : {std::pair((a + 1) % 3, (a + 2) % 3), std::pair((a + 2) % 3, (a + 1) % 3)})
      found += exact::segment_meets_triangle(scale * origin, scale * direction, scale * corners[a],
                                             scale * corners[b], scale * corners[c])
                   ? 1
                   : 0;
  }
  EXPECT_TRUE(found == 0 || found == 6) << found;
  return found != 0;
}

// However small everything is.
bool meets(const glm::vec3& origin, const glm::vec3& direction) {
  const bool met = meets_at(origin, direction, 1.0f);
  EXPECT_EQ(met, meets_at(origin, direction, 0.125f));
  return met;
}

TEST(Segments, MeetATriangleBetweenTheirEnds) {
  for (const float side : {1.0f, -1.0f}) {
    EXPECT_TRUE(meets({1, 1, 2 * side}, {0, 0, -4 * side}));
    EXPECT_TRUE(meets({1, 1, 2 * side}, {0, 0, -2.001f * side}));
    EXPECT_FALSE(meets({1, 1, 2 * side}, {0, 0, -2 * side})) << "it ends there";
    EXPECT_FALSE(meets({1, 1, 2 * side}, {0, 0, -1.999f * side}));
    EXPECT_FALSE(meets({1, 1, 0}, {0, 0, -2 * side})) << "it starts there";
    EXPECT_FALSE(meets({1, 1, 2 * side}, {0, 0, 4 * side})) << "away from it";
  }
  EXPECT_FALSE(meets({1, 1, 2}, {1, 0, 0})) << "along the plane";
}

TEST(Segments, MeetATrianglesEdgesAndNothingBesideThem) {
  for (const glm::vec3 inside : {glm::vec3(2, 0, 2), glm::vec3(0, 2, 2), glm::vec3(2, 2, 2), glm::vec3(0, 0, 2)})
    EXPECT_TRUE(meets(inside, {0, 0, -4})) << inside.x << " " << inside.y;
  for (const glm::vec3 beside : {glm::vec3(2, -0.001f, 2), glm::vec3(-0.001f, 2, 2), glm::vec3(2.001f, 2, 2)})
    EXPECT_FALSE(meets(beside, {0, 0, -4})) << beside.x << " " << beside.y;
}

// Whether some point between origin and origin + direction lies within `margin` of the box.
bool passes(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& low, const glm::dvec3& high,
            double margin) {
  double first = 0, last = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (low[axis] - margin - origin[axis]) / direction[axis];
    const double b = (high[axis] + margin - origin[axis]) / direction[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last;
}

// There every number of the test is rounding, and of either sign.
TEST(Segments, InATrianglesPlaneMeetItNearItsBoxOnly) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1, 1);
  const auto point = [&] { return glm::vec3(any(random), any(random), any(random)); };
  int met = 0;
  for (int i = 0; i < 200'000; ++i) {
    const glm::vec3 origin = point(), u = point(), v = point(),
                    direction = 4.0f * any(random) * u + 4.0f * any(random) * v;
    std::array<glm::vec3, 3> corners;
    const glm::vec3 middle = origin + 4.0f * any(random) * u + 4.0f * any(random) * v;
    for (glm::vec3& corner : corners) corner = middle + 0.2f * any(random) * u + 0.2f * any(random) * v;
    if (!exact::segment_meets_triangle(origin, direction, corners[0], corners[1], corners[2])) continue;
    ++met;
    const glm::vec3 low = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::vec3 high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    const glm::vec3 far = glm::max(glm::abs(low - origin), glm::abs(high - origin));
    const double margin = 1.001 * std::max({far.x, far.y, far.z}) / 4096;
    ASSERT_TRUE(passes(origin, direction, low, high, margin)) << "triangle " << i;
  }
  EXPECT_GT(met, 100);
  RecordProperty("met", met);
}

}  // namespace
}  // namespace gnomon::gpu
