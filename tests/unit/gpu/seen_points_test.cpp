// The places of an area light's points, as C++: no point whose segment a triangle meets is left out, needles that are
// thinner than the rounding included, and most others are.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "gpu/exact_cpp.h"

namespace gnomon::gpu::exact {

using glm::any;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::greaterThanEqual;
using glm::inversesqrt;
using glm::lessThan;
using glm::normalize;
using glm::uvec4;
using glm::vec2;

struct {
  struct {
    uint samples = 0;
    std::vector<vec3> points;
  } soft;
} push;

#define EXACT_FN inline
#define SAMPLE_POINT(n) push.soft.points[n]
#include "gpu/shaders/seen_points.glsl"
#undef EXACT_FN

}  // namespace gnomon::gpu::exact

namespace gnomon::test {
namespace {

using glm::vec3;
using namespace gpu::exact;

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  float between(float least, float most) { return std::uniform_real_distribution<float>(least, most)(engine_); }
  // Every order of magnitude alike.
  float size(float least, float most) { return std::exp(between(std::log(least), std::log(most))); }
  vec3 direction() {
    for (;;) {
      const vec3 v{between(-1, 1), between(-1, 1), between(-1, 1)};
      if (const float length = glm::length(v); length > 0.1f && length < 1) return v / length;
    }
  }

 private:
  std::mt19937 engine_;
};

struct View {
  vec3 origin, middle;
  float radius;
};

// Points within the ball of a light, as seen from near it or far away, in a small scene or a large one.
View look(Random& random, uint samples) {
  View view;
  view.radius = random.size(1e-3f, 10);
  view.middle = random.direction() * random.size(1e-2f, 1e3f);
  view.origin = view.middle + random.direction() * view.radius * random.size(1.2f, 1e3f);
  push.soft.samples = samples;
  push.soft.points.clear();
  for (uint i = 0; i < samples; ++i)
    push.soft.points.push_back(view.middle + random.direction() * view.radius * random.between(0, 0.999f));
  return view;
}

struct Triangle {
  vec3 corners[3];
};

// Of any size and thinness, near a segment to one of the points: beside it, or with a needle's line through it.
Triangle triangle_near(Random& random, const View& view, vec3 point) {
  const vec3 met = view.origin + (point - view.origin) * random.between(0.01f, 0.99f);
  const float length = glm::length(met - view.origin) * random.size(1e-4f, 2);
  const vec3 along = random.direction() * length, across = random.direction() * length * random.size(1e-9f, 1);
  const float from = random.between(-1.2f, 0.2f);
  const vec3 corner = met + along * from - across * random.between(0, 0.6f);
  return {{corner, corner + along, corner + along * random.between(0, 1) + across}};
}

TEST(SeenPoints, NoneThatATriangleHidesIsLeftOut) {
  Random random(20261128);
  uint64_t met = 0, needles = 0;
  for (int round = 0; round < 20'000; ++round) {
    const View view = look(random, round % 4 == 0 ? 4 : 16);
    const SeenPoints points = points_as_seen(view.origin, view.middle - view.origin, view.radius, 0);
    for (int k = 0; k < 20; ++k) {
      const uint aimed = static_cast<uint>(k) % push.soft.samples;
      const Triangle t = triangle_near(random, view, push.soft.points[aimed]);
      const SeenTriangle seen = seen_triangle(view.origin, t.corners[0], t.corners[1], t.corners[2]);
      const uint behind = points_behind(points, seen.a, seen.b, seen.c);
      for (uint i = 0; i < push.soft.samples; ++i) {
        if (!meets_seen_triangle(seen, sample_segment(view.origin, {}, push.soft.points[i]).direction)) continue;
        ASSERT_TRUE(behind & point_bit(i)) << "round " << round << ", triangle " << k << ", point " << i;
        ++met;
        // Not what reals would meet: only the rounding says so.
        const vec3 n = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
        if (glm::length(n) < 1e-6f * glm::dot(seen.a - seen.b, seen.a - seen.b)) ++needles;
      }
    }
  }
  EXPECT_GT(met, 50'000u);
  EXPECT_GT(needles, 500u);
}

TEST(SeenPoints, MostThatASmallTriangleDoesNotHideAre) {
  Random random(7);
  uint64_t left_in = 0, of = 0;
  for (int round = 0; round < 2'000; ++round) {
    const View view = look(random, 16);
    if (glm::length(view.middle - view.origin) < 3 * view.radius ||
        glm::length(view.middle - view.origin) > 50 * view.radius)
      continue;
    const SeenPoints points = points_as_seen(view.origin, view.middle - view.origin, view.radius, 0);
    const vec3 at = (view.middle - view.origin) * 0.9f + random.direction() * view.radius * 0.5f;
    const float size = 0.1f * view.radius;
    const uint behind = points_behind(points, at, at + random.direction() * size, at + random.direction() * size);
    left_in += static_cast<uint64_t>(std::popcount(behind & all_points(16)));
    of += 16;
  }
  EXPECT_GT(of, 5'000u);
  EXPECT_LT(10 * left_in, of);
}

TEST(SeenPoints, EachPointHasABitOfItsOwn) {
  for (const uint samples : {4u, 16u}) {
    uint all = 0;
    for (uint i = 0; i < samples; ++i) {
      EXPECT_EQ(all & point_bit(i), 0u);
      EXPECT_EQ(point_of(static_cast<uint>(std::countr_zero(point_bit(i)))), i);
      all |= point_bit(i);
    }
    EXPECT_EQ(all, all_points(samples));
  }
}

}  // namespace
}  // namespace gnomon::test
