#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"
#include "scenes/assets/temple/props.h"

namespace gnomon::scenes::assets::temple {
namespace {

constexpr float kTwoPi = 6.2831853f;
constexpr float kBase = 0.42f, kCapital = 0.78f, kFoot = 0.46f;  // heights, and the shaft's radius at its foot
constexpr int kFlutes = 20;

// The shaft's radius: a gentle swelling (entasis), then a sixth narrower at the neck.
float shaft_radius(float t) { return kFoot * (1.0f - 0.16f * t * t + 0.020f * std::sin(3.14159f * t)); }

// How much a flute hollows the shaft out at angle a: round troughs between sharp edges.
float flute_depth(float a) {
  const float within = a * kFlutes / kTwoPi - std::floor(a * kFlutes / kTwoPi);
  return 0.034f * std::sqrt(std::max(std::sin(3.14159f * within), 0.0f));
}

Mesh shaft(float low, float high, int rows) {
  return barrel(kFlutes * 4, rows, [=](float u, float v) {
    const float a = kTwoPi * u;
    const float y = glm::mix(low, high, v);
    const float t = (y - kBase) / (kColumnHeight - kBase - kCapital);
    const float ends = glm::clamp(std::min(t, 1 - t) / 0.02f, 0.0f, 1.0f);
    const float r = shaft_radius(t) - flute_depth(a) * ends;
    return glm::vec3(r * std::cos(a), y, -r * std::sin(a));
  });
}

Mesh base() {
  Mesh mesh = bevel_box({-0.64f, -0.02f, -0.64f}, {0.64f, 0.16f, 0.64f}, 0.015f);
  append(mesh, lathe({{0, 0.15f},       {0.60f, 0.15f}, {0.60f, 0.15f}, {0.625f, 0.165f}, {0.635f, 0.205f},
                      {0.625f, 0.245f}, {0.59f, 0.26f}, {0.59f, 0.26f}, {0.56f, 0.265f},  {0.535f, 0.29f},
                      {0.53f, 0.315f},  {0.55f, 0.33f}, {0.55f, 0.33f}, {0.565f, 0.34f},  {0.57f, 0.37f},
                      {0.555f, 0.40f},  {0.50f, 0.41f}, {0.50f, 0.41f}, {0.47f, 0.43f},   {0, 0.43f}},
                     36));
  return mesh;
}

// An acanthus leaf: broad and lobed, its tip curling out and down. Grows along +Y from the origin, faces +Z.
Mesh acanthus(float height, float width, float curl) {
  return sheet(4, 7, 0.018f, [=](float u, float v) {
    const float side = 2 * u - 1;
    const float lobes = 1.0f - 0.16f * std::abs(std::sin(9.0f * v));
    const float outline =
        std::pow(std::max(1.0f - std::pow(v, 3.0f), 0.02f), 0.6f) * lobes * (0.75f + 0.35f * std::sin(2.6f * v));
    const float turn = 2.7f * std::max(v - 0.55f, 0.0f) / 0.45f;  // radians of the curl so far
    const float y = v < 0.55f ? v * height : 0.55f * height + curl * std::sin(turn);
    const float z = 0.04f * v + (v < 0.55f ? 0.0f : curl * (1 - std::cos(turn)));
    const float groove = 0.015f * std::cos(6.0f * side) + 0.02f * side * side;
    return glm::vec3(0.5f * width * outline * side, y, z + groove);
  });
}

Mesh volute() {
  // A scroll at each corner of the abacus.
  std::vector<glm::vec3> path;
  for (int i = 0; i <= 20; ++i) {
    const float t = static_cast<float>(i) / 20, a = 9.4f * t, r = 0.115f * (1 - 0.8f * t);
    path.emplace_back(r * std::sin(a) + 0.10f * (1 - t), -r * std::cos(a), 0.02f * t);
  }
  return tube(
      path, [](float t) { return 0.030f - 0.014f * t; }, 5);
}

Mesh capital() {
  const float neck = shaft_radius(1.0f);
  Mesh mesh = lathe(curve(std::vector<glm::vec2>{{0, 0.001f},
                                                 {neck + 0.04f, 0.002f},
                                                 {neck + 0.055f, 0.03f},
                                                 {neck + 0.01f, 0.06f},
                                                 {neck, 0.12f},
                                                 {neck + 0.02f, 0.35f},
                                                 {neck + 0.08f, 0.52f},
                                                 {neck + 0.17f, 0.62f},
                                                 {0, 0.625f}},
                          2),
                    32);
  for (int i = 0; i < 8; ++i) {
    const float step = 45.0f * static_cast<float>(i);
    append(mesh, acanthus(0.40f, 0.30f, 0.085f), turned(step) * at(0, 0.05f, neck + 0.015f));
    append(mesh, acanthus(0.62f, 0.30f, 0.10f), turned(step + 22.5f) * at(0, 0.06f, neck + 0.002f));
  }
  for (int i = 0; i < 4; ++i) {
    append(mesh, volute(),
           turned(45.0f + 90.0f * static_cast<float>(i)) * at(0, 0.56f, neck + 0.20f) * turned(-90));
  }
  // The abacus has hollow sides.
  append(mesh, barrel(48, 1, [](float u, float v) {
           const float a = kTwoPi * (u + 0.125f / 6.0f);
           const float edge = 0.60f / std::max(std::abs(std::cos(a)), std::abs(std::sin(a)));
           const float r = std::min(edge, 0.79f) * (1.0f - 0.09f * std::pow(std::abs(std::cos(2 * a)), 2.0f));
           return glm::vec3(r * std::cos(a), 0.63f + 0.16f * v, -r * std::sin(a));
         }));
  return mesh;
}

}  // namespace

Model column(const Palette& palette) {
  Model model{"column", {}};
  Mesh& stone = model.in(palette.limestone);
  append(stone, base());
  append(stone, shaft(kBase, kColumnHeight - kCapital + 0.01f, 16));
  append(stone, capital(), at(0, kColumnHeight - kCapital, 0));
  append(model.in(palette.gold),
         lathe({{0.38f, -0.02f}, {0.405f, -0.02f}, {0.415f, 0.0f}, {0.405f, 0.02f}, {0.38f, 0.02f}}, 32),
         at(0, kColumnHeight - kCapital - 0.03f, 0));
  return model;
}

Model broken_column(const Palette& palette) {
  Model model{"broken column", {}};
  append(model.in(palette.limestone), base());
  // The shaft up to a ragged rim, then inwards over the break.
  append(model.in(palette.limestone), barrel(kFlutes * 4, 18, [](float u, float v) {
           const float a = kTwoPi * u, inwards = std::max(v - 0.7f, 0.0f) / 0.3f;
           const float rim =
               2.1f + 0.26f * std::sin(a + 0.7f) + 0.08f * std::sin(3 * a) + 0.03f * std::sin(8 * a + 1.0f);
           const float rough = 0.045f * std::sin(9 * inwards + 3 * a) * std::sin(14 * inwards) * (1 - inwards);
           const float y = v < 0.7f ? glm::mix(kBase, rim, v / 0.7f) : glm::mix(rim, 2.02f, inwards) + rough;
           const float t = (y - kBase) / (kColumnHeight - kBase - kCapital);
           const float r = (shaft_radius(t) - flute_depth(a) * (1 - inwards)) * (1 - 0.97f * inwards);
           return glm::vec3(r * std::cos(a), y, -r * std::sin(a));
         }));
  return model;
}

Model sun_disk(const Palette& palette) {
  Model model{"sun disk", {}};
  Mesh& gold = model.in(palette.gold);
  append(gold,
         lathe(curve(std::vector<glm::vec2>{{0, -0.05f},
                                            {0.78f, -0.05f},
                                            {0.82f, 0.05f},
                                            {0.74f, 0.12f},
                                            {0.68f, 0.07f},
                                            {0.60f, 0.06f},
                                            {0.45f, 0.12f},
                                            {0.22f, 0.17f},
                                            {0, 0.18f}},
                     3),
               72),
         turned(90, {1, 0, 0}));
  for (int i = 0; i < 32; ++i) {
    const bool tall = i % 2 == 0;
    const float length = tall ? 0.72f : 0.45f, half = tall ? 0.075f : 0.055f;
    append(gold,
           barrel(6, 8,
                  [=](float u, float v) {  // a flame: waving when long, straight when short
                    const float a = kTwoPi * u, w = half * (1 - 0.97f * std::pow(v, 1.4f));
                    const float sway = tall ? 0.035f * std::sin(6.0f * v) : 0.0f;
                    return glm::vec3(sway + w * std::cos(a), 0.80f + length * v, 0.05f - 0.4f * w * std::sin(a));
                  }),
           turned(11.25f * static_cast<float>(i), {0, 0, 1}));
  }
  return model;
}

}  // namespace gnomon::scenes::assets::temple
