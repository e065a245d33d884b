#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/assets/random.h"
#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {
namespace {

constexpr float kRugX = 3.3f, kRugZ = 2.3f;

bool in_border(float x, float z) {
  const float edge = std::min(0.5f * kRugX - std::abs(x), 0.5f * kRugZ - std::abs(z));
  const bool frame = edge > 0.14f && edge < 0.20f;
  const float dx = std::fmod(std::abs(x) + 0.30f, 0.60f) - 0.30f,
              dz = std::fmod(std::abs(z) + 0.30f, 0.60f) - 0.30f;
  const bool diamonds = edge > 0.26f && std::abs(std::abs(dx) + std::abs(dz) - 0.24f) < 0.035f;
  return frame || diamonds;
}

}  // namespace

Model rug(const Palette& palette) {
  Random random(21);
  Model model{"rug", {}};
  append(model.in(palette.rug_field), rounded_box({kRugX, 0.016f, kRugZ}, 0.006f, 2), at(0, 0.006f, 0));
  // The pile: one knot a cell, its height uneven, its colour by the pattern.
  constexpr int kKnotsX = 104, kKnotsZ = 72;
  const Mesh pile = surface(kKnotsX, kKnotsZ, [&](float u, float v) {
    const bool rim = u == 0.0f || u == 1.0f || v == 0.0f || v == 1.0f;
    const float y = rim ? 0.010f : random.range(0.0165f, 0.0215f);
    return glm::vec3((u - 0.5f) * (kRugX - 0.02f), y, (0.5f - v) * (kRugZ - 0.02f));
  });
  for (const uint32_t wool : {palette.rug_field, palette.rug_border}) {
    Mesh part = pile;
    std::erase_if(part.triangles, [&](const glm::uvec3& t) {
      // Both triangles of a knot share its diagonal, whose middle is the middle of the knot.
      const glm::vec3 a = pile.positions[t.x], b = pile.positions[t.y], c = pile.positions[t.z];
      const glm::vec3 middle = 0.5f * (glm::min(glm::min(a, b), c) + glm::max(glm::max(a, b), c));
      return in_border(middle.x, middle.z) != (wool == palette.rug_border);
    });
    part.uvs.clear();
    append(model.in(wool), part);
  }
  for (const float side : {-1.0f, 1.0f}) {
    float z = -0.5f * kRugZ + 0.02f;
    while (z < 0.5f * kRugZ) {
      const float x = side * 0.5f * kRugX, bend = random.range(-0.02f, 0.02f);
      append(model.in(palette.rug_field), tube({{x - side * 0.02f, 0.012f, z},
                                                {x + side * 0.03f, 0.010f, z + 0.3f * bend},
                                                {x + side * 0.09f, 0.005f, z + bend}},
                                               0.005f, 5));
      z += 0.045f;
    }
  }
  return model;
}

Model curtain(const Palette& palette, uint32_t seed) {
  Random random(seed);
  const float phase = random.range(0.0f, 6.28f);
  Model model{"curtain", {}};
  append(model.in(palette.curtain), sheet(56, 10, 0.004f, [=](float u, float v) {
           const float fall = 1 - v, pinch = 1.0f - 0.10f * std::sin(glm::pi<float>() * fall);
           const float fold = std::sin(2 * glm::pi<float>() * 7 * u + 0.6f * std::sin(5 * fall + phase));
           const float depth = 0.030f + 0.018f * fall;
           return glm::vec3((u - 0.5f) * 0.62f * pinch, -0.03f - 2.575f * fall,
                            depth * fold + 0.012f * std::sin(11 * u + 4 * fall + phase));
         }));
  for (int i = 0; i < 8; ++i) {
    const Mesh ring =
        lathe({{0.020f, -0.003f}, {0.026f, -0.003f}, {0.026f, 0.003f}, {0.020f, 0.003f}, {0.020f, -0.003f}}, 14);
    append(model.in(palette.brass), ring,
           at(-0.28f + 0.08f * static_cast<float>(i), -0.006f, 0) * turned(90, {0, 0, 1}));
  }
  return model;
}

}  // namespace gnomon::scenes::assets::room
