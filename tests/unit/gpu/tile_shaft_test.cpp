// The shaft of a tile's segments, as C++: no box that a segment meets is left out, and most that none can meet are.
#include <gtest/gtest.h>

#include <random>

#include "gpu/exact_cpp.h"

namespace gnomon::gpu::exact {

using glm::any;
using glm::lessThan;
using glm::mix;

#define EXACT_FN inline
#include "gpu/shaders/tracers/tile_shaft.glsl"
#undef EXACT_FN

}  // namespace gnomon::gpu::exact

namespace gnomon::test {
namespace {

using glm::vec3;
using namespace gpu::exact;

struct Box {
  vec3 lo, hi;
};

// Whether the segment reaches into the box, in doubles; the box is as meets() widens it for this origin.
bool segment_meets(const ShadowSegment& segment, const Box& box) {
  const glm::dvec3 origin(segment.origin), direction(segment.direction);
  const glm::dvec3 lo = glm::dvec3(box.lo) - origin, hi = glm::dvec3(box.hi) - origin;
  const glm::dvec3 reach = glm::max(glm::abs(lo), glm::abs(hi));
  const double margin = std::max({reach.x, reach.y, reach.z}) / 4095.0;
  double enter = 0, leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double from = lo[axis] - margin, to = hi[axis] + margin;
    if (direction[axis] == 0) {
      if (from > 0 || to < 0) return false;
      continue;
    }
    enter = std::max(enter, std::min(from / direction[axis], to / direction[axis]));
    leave = std::min(leave, std::max(from / direction[axis], to / direction[axis]));
  }
  return enter <= leave;
}

class Random {
 public:
  explicit Random(uint32_t seed) : random_(seed) {}
  float between(float from, float to) { return std::uniform_real_distribution<float>(from, to)(random_); }
  vec3 point(float from, float to) { return {between(from, to), between(from, to), between(from, to)}; }
  bool chance(float share) { return between(0, 1) < share; }
  // From `least` on, evenly in its logarithm.
  float size(float least, float most) { return least * std::pow(most / least, between(0, 1)); }

 private:
  std::mt19937 random_;
};

struct Tile {
  vec3 lo, hi;
  std::vector<vec3> origins;
};

// Some origins are corners of the tile's bounds; some tiles are flat or one point.
Tile made_tile(Random& random, const vec3& at) {
  Tile tile{at, at, {}};
  const float size = random.size(1e-3f, 1.0f);
  for (int axis = 0; axis < 3; ++axis)
    if (random.chance(0.8f)) tile.hi[axis] = tile.lo[axis] + random.between(0, size);
  for (int i = 0; i < 8; ++i)
    tile.origins.emplace_back(i & 1 ? tile.hi.x : tile.lo.x, i & 2 ? tile.hi.y : tile.lo.y,
                              i & 4 ? tile.hi.z : tile.lo.z);
  for (int i = 0; i < 8; ++i)
    tile.origins.push_back(glm::clamp(glm::mix(tile.lo, tile.hi, random.point(0, 1)), tile.lo, tile.hi));
  return tile;
}

TracedLight made_light(Random& random, const vec3& at) {
  TracedLight light{};
  light.position = at + random.point(-2, 2);
  if (random.chance(0.4f)) {
    light.kind = 2;
    light.direction = glm::normalize(random.point(-1, 1));
    if (random.chance(0.2f)) light.direction = {0, -1, 0};
    light.reach = random.size(0.5f, 8.0f);
  }
  return light;
}

ShadowSegment segment_from(const vec3& origin, const TracedLight& light) {
  return {origin, light.kind == 2 ? light.direction * -light.reach : light.position - origin, true};
}

// A small box that touches the segment somewhere, often just so; some are flat.
Box box_on(Random& random, const ShadowSegment& segment) {
  const vec3 touched = segment.origin + random.between(0, 1) * segment.direction;
  const vec3 size = random.chance(0.3f) ? vec3(0.0f) : random.point(0, random.size(1e-4f, 0.5f));
  const vec3 at = random.chance(0.5f) ? glm::round(random.point(0, 1)) : random.point(0, 1);
  return {touched - at * size, touched + (1.0f - at) * size};
}

void expect_meets_what_segments_meet(uint32_t seed, const vec3& at) {
  Random random(seed);
  size_t met = 0, missed = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Tile tile = made_tile(random, at + random.point(-1, 1));
    const TracedLight light = made_light(random, at);
    const TileShaft shaft = shaft_to(light, tile.lo, tile.hi);
    const size_t chosen = static_cast<size_t>(random.between(0, 15.99f));
    const Box box = box_on(random, segment_from(tile.origins[chosen], light));
    for (const vec3& origin : tile.origins) {
      if (!segment_meets(segment_from(origin, light), box)) continue;
      ++met;
      if (!shaft_meets(shaft, box.lo, box.hi)) ++missed;
    }
  }
  EXPECT_EQ(missed, 0u) << "of " << met;
  EXPECT_GT(met, 100'000u);
}

TEST(TileShaft, MeetsEveryBoxThatASegmentMeets) { expect_meets_what_segments_meet(1, vec3(0.0f)); }

TEST(TileShaft, MeetsThemFarFromTheOriginToo) { expect_meets_what_segments_meet(2, {500.0f, -300.0f, 20.0f}); }

// What it is for: of boxes somewhere in the room, those that no segment of a small tile meets are nearly all left out.
TEST(TileShaft, LeavesOutNearlyAllThatNoSegmentMeets) {
  Random random(3);
  size_t apart = 0, left_out = 0;
  for (int i = 0; i < 20'000; ++i) {
    Tile tile = made_tile(random, random.point(-1, 1));
    tile.hi = glm::min(tile.hi, tile.lo + 0.02f);
    const TracedLight light = made_light(random, vec3(0.0f));
    const vec3 lo = random.point(-2, 2);
    const Box box{lo, lo + random.point(0, 0.3f)};
    bool met = false;
    for (const vec3& origin : {tile.lo, 0.5f * (tile.lo + tile.hi), tile.hi})
      met = met || segment_meets(segment_from(origin, light), box);
    apart += !met;
    left_out += !met && !shaft_meets(shaft_to(light, tile.lo, tile.hi), box.lo, box.hi);
  }
  EXPECT_GT(left_out, apart - apart / 50) << "of " << apart;
}

}  // namespace
}  // namespace gnomon::test
