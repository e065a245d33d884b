#include "scenes/assets/plants.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets {
namespace {

glm::vec3 around(float angle) { return {std::cos(angle), 0.0f, std::sin(angle)}; }

// The placement of a leaf at `root` that grows towards `outwards`, with its upper side facing up as far as possible.
glm::mat4 leaf_frame(glm::vec3 root, glm::vec3 outwards) {
  const glm::vec3 y = glm::normalize(outwards);
  const glm::vec3 up = std::abs(y.y) > 0.97f ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0);
  const glm::vec3 x = glm::normalize(glm::cross(y, up));
  const glm::vec3 z = glm::cross(x, y);
  return glm::mat4(glm::vec4(x, 0), glm::vec4(y, 0), glm::vec4(z, 0), glm::vec4(root, 1));
}

}  // namespace

Mesh leaf(float length, float width, float droop, int detail) {
  return sheet(detail > 4 ? 4 : 2, detail, 0.0018f, [=](float u, float v) {
    const float side = 2 * u - 1;
    const float outline = std::pow(std::sin(glm::pi<float>() * (0.03f + 0.95f * std::pow(v, 0.85f))), 0.8f);
    const float x = side * 0.5f * width * outline;
    const float fold = 0.22f * std::abs(x);
    return glm::vec3(x, length * (v - 0.12f * droop * v * v), fold - droop * length * v * v);
  });
}

Shrub fig_tree(float height, uint32_t seed) {
  Random random(seed);
  Shrub shrub;
  for (int stem = 0; stem < 3; ++stem) {
    const float turn = random.range(0.0f, 6.28f);
    const float top = height * random.range(0.75f, 0.95f);
    const glm::vec3 lean = around(turn) * random.range(0.12f, 0.26f);
    const std::vector<glm::vec3> path = curve(
        std::vector<glm::vec3>{around(turn) * 0.03f, lean * 0.25f + glm::vec3(0, top * 0.35f, 0),
                               lean * 0.8f + glm::vec3(0.02f, top * 0.7f, 0.02f), lean + glm::vec3(0, top, 0)},
        6);
    append(shrub.wood, tube(
                           path, [](float t) { return 0.016f - 0.009f * t; }, 8));
    const int leaves = 20;
    for (int i = 0; i < leaves; ++i) {
      const float t = 0.30f + 0.70f * static_cast<float>(i) / static_cast<float>(leaves - 1);
      const glm::vec3 root = path[static_cast<size_t>(t * static_cast<float>(path.size() - 1))];
      const float angle = turn + 2.4f * static_cast<float>(i) + random.range(-0.3f, 0.3f);
      const glm::vec3 outwards = around(angle) + glm::vec3(0, random.range(0.25f, 0.6f) + 0.7f * t, 0);
      const float size = random.range(0.20f, 0.30f) * (1.15f - 0.35f * t);
      append(shrub.leaves, leaf(size, size * 0.62f, random.range(0.25f, 0.5f), 6), leaf_frame(root, outwards));
    }
  }
  return shrub;
}

Shrub fern(float spread, int fronds, uint32_t seed) {
  Random random(seed);
  Shrub shrub;
  const Mesh leaflet = leaf(0.10f, 0.030f, 0.25f, 2);
  for (int f = 0; f < fronds; ++f) {
    const float angle = 2.4f * static_cast<float>(f) + random.range(-0.2f, 0.2f);
    const glm::vec3 out = around(angle), side = around(angle + glm::half_pi<float>());
    const float reach = spread * random.range(0.7f, 1.0f), rise = spread * random.range(0.5f, 0.95f);
    const std::vector<glm::vec3> path =
        curve(std::vector<glm::vec3>{glm::vec3(0), out * 0.3f * reach + glm::vec3(0, 0.8f * rise, 0),
                                     out * 0.75f * reach + glm::vec3(0, rise, 0),
                                     out * reach + glm::vec3(0, 0.62f * rise, 0)},
              6);
    append(shrub.wood, tube(
                           path, [](float t) { return 0.004f - 0.003f * t; }, 5));
    for (size_t i = 4; i + 1 < path.size(); ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(path.size());
      const glm::vec3 along = glm::normalize(path[i + 1] - path[i]);
      const float size = 1.25f * std::sin(glm::pi<float>() * (0.12f + 0.85f * t)) + 0.25f;
      for (const float hand : {-1.0f, 1.0f}) {
        const glm::mat4 frame = leaf_frame(path[i], hand * side + 0.55f * along + glm::vec3(0, 0.1f, 0));
        append(shrub.leaves, leaflet, frame * scaled(size));
      }
    }
  }
  return shrub;
}

Shrub snake_plant(float height, int blades, uint32_t seed) {
  Random random(seed);
  Shrub shrub;
  for (int i = 0; i < blades; ++i) {
    const float angle = 2.4f * static_cast<float>(i);
    const float radius = 0.10f * std::sqrt(static_cast<float>(i) / static_cast<float>(blades));
    const float tall = height * random.range(0.6f, 1.0f), wide = random.range(0.05f, 0.075f);
    const float twist = random.range(-0.9f, 0.9f), lean = random.range(0.05f, 0.2f);
    const Mesh blade = sheet(4, 10, 0.004f, [=](float u, float v) {
      const float x = (2 * u - 1) * 0.5f * wide * std::pow(std::max(1 - v * v * v, 0.0f), 0.8f) *
                      (0.7f + 0.9f * v * (1 - v) * 2);
      const float cup = 6.0f * x * x;
      const float c = std::cos(twist * v), s = std::sin(twist * v);
      return glm::vec3(c * x - s * cup, tall * v, s * x + c * cup - lean * tall * v * v);
    });
    append(shrub.leaves, blade, at(around(angle) * radius) * turned(-glm::degrees(angle) - 90.0f));
  }
  return shrub;
}

Shrub ivy(glm::vec2 size, int stems, bool hanging, uint32_t seed) {
  Random random(seed);
  Shrub shrub;
  // A card bent along its middle, so that no two neighbours lie in one plane.
  const Mesh card = surface(2, 1, [](float u, float v) {
    return glm::vec3(u - 0.5f, 1 - v, 0.16f * (1 - std::abs(2 * u - 1)) + 0.1f * v);
  });
  Mesh facing = card;  // its front is along du x dv; texture rows run downwards, so that this is turned round
  for (glm::uvec3& t : facing.triangles) std::swap(t.y, t.z);
  for (glm::vec3& n : facing.normals) n = -n;

  const float rise = hanging ? -1.0f : 1.0f;
  for (int s = 0; s < stems; ++s) {
    glm::vec2 tip(random.range(-0.3f, 0.3f) * size.x, 0.0f);
    float heading = random.range(-0.7f, 0.7f);
    std::vector<glm::vec3> path{{tip, 0.01f}};
    const float reach = size.y * random.range(0.5f, 1.0f);
    while (rise * tip.y < reach && path.size() < 60) {
      heading = 0.8f * heading + random.range(-0.45f, 0.45f);
      if (std::abs(tip.x) > 0.5f * size.x) heading = -0.5f * tip.x;
      tip += 0.12f * glm::vec2(std::sin(heading), rise * std::cos(heading));
      path.emplace_back(tip, 0.012f + 0.01f * random.unit());
      for (int k = 0; k < 3; ++k) {
        const glm::vec3 root = path.back() + glm::vec3(random.range(-0.1f, 0.1f), random.range(-0.1f, 0.1f),
                                                       random.range(0.01f, 0.07f));
        const glm::mat4 lie = at(root) *
                              turned(random.range(-70.0f, 70.0f) + 180.0f * (random.below(3) > 0), {0, 0, 1}) *
                              turned(random.range(-40.0f, 30.0f), {1, 0, 0}) * turned(random.range(-35.0f, 35.0f));
        append(shrub.leaves, facing, lie * scaled(random.range(0.10f, 0.17f)));
      }
    }
    if (path.size() > 3)
      append(shrub.wood, tube(
                             path, [](float t) { return 0.011f - 0.007f * t; }, 5));
  }
  return shrub;
}

}  // namespace gnomon::scenes::assets
