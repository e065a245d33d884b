#include <cmath>

#include "scenes/assets/plants.h"
#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"
#include "scenes/assets/temple/props.h"

namespace gnomon::scenes::assets::temple {

Model brazier(const Palette& palette) {
  Model model{"brazier", {}};
  Mesh& bronze = model.in(palette.bronze);
  append(bronze, turned_vessel({{0, 1.02f},
                                {0.10f, 1.025f},
                                {0.30f, 1.10f},
                                {0.43f, 1.24f},
                                {0.47f, 1.32f},
                                {0.45f, 1.335f},
                                {0.40f, 1.26f},
                                {0.28f, 1.17f},
                                {0, 1.14f}},
                               40, 2));
  append(bronze,
         turned_vessel({{0, 0.90f}, {0.06f, 0.90f}, {0.09f, 0.95f}, {0.06f, 1.0f}, {0.10f, 1.04f}, {0, 1.05f}}, 24,
                       2));
  for (int i = 0; i < 3; ++i) {
    const glm::mat4 turn = turned(120.0f * static_cast<float>(i));
    append(bronze,
           tube(
               curve(std::vector<glm::vec3>{{0.34f, 1.16f, 0},
                                            {0.30f, 0.95f, 0},
                                            {0.14f, 0.66f, 0},
                                            {0.20f, 0.32f, 0},
                                            {0.40f, 0.07f, 0},
                                            {0.50f, 0.035f, 0}},
                     4),
               [](float t) { return 0.036f - 0.012f * std::sin(3.14159f * t) + 0.02f * std::pow(t, 8.0f); }, 8),
           turn);
    append(bronze, sphere(0.05f, 10), turn * at(0.50f, 0.045f, 0));
  }
  append(bronze, lathe({{0.19f, 0.40f}, {0.205f, 0.385f}, {0.22f, 0.40f}, {0.205f, 0.415f}, {0.19f, 0.40f}}, 40));
  Random random(7);
  for (int i = 0; i < 26; ++i) {  // coals
    const float a = 2.4f * static_cast<float>(i), r = 0.065f * std::sqrt(static_cast<float>(i));
    const glm::vec3 half{random.range(0.04f, 0.065f), random.range(0.03f, 0.045f), random.range(0.04f, 0.06f)};
    append(model.in(palette.coal), bevel_box(-half, half, 0.015f),
           at(r * std::cos(a), 1.33f - 0.9f * r * r + random.range(-0.01f, 0.02f), r * std::sin(a)) *
               turned(random.range(0, 360), {0.5f, 0.7f, 0.5f}));
  }
  return model;
}

Model hanging_lamp(const Palette& palette) {
  Model model{"hanging lamp", {}};
  Mesh& bronze = model.in(palette.bronze);
  const float dish = -kLampDrop - 0.14f;
  append(bronze, turned_vessel({{0, dish - 0.09f},
                                {0.02f, dish - 0.08f},
                                {0.06f, dish - 0.05f},
                                {0.20f, dish},
                                {0.23f, dish + 0.05f},
                                {0.215f, dish + 0.055f},
                                {0.17f, dish + 0.02f},
                                {0, dish - 0.01f}},
                               36, 2));
  append(bronze, sphere(0.03f, 16), at(0, dish - 0.11f, 0));
  append(bronze, sphere(0.05f, 18), at(0, -1.35f, 0));
  // One chain from the ceiling, three from there to the dish; links alternate.
  const auto chain = [&](glm::vec3 from, glm::vec3 to) {
    std::vector<glm::vec3> oval;
    for (int k = 0; k <= 6; ++k) {
      const float a = 6.2831853f * static_cast<float>(k) / 6;
      oval.emplace_back(0.020f * std::cos(a), 0.038f * std::sin(a), 0);
    }
    const Mesh link = tube(oval, 0.0055f, 4);
    const int links = static_cast<int>(glm::distance(from, to) / 0.062f);
    for (int i = 0; i < links; ++i) {
      const glm::vec3 p = glm::mix(from, to, (static_cast<float>(i) + 0.5f) / static_cast<float>(links));
      append(bronze, link, at(p) * pointing(to - from) * turned(i % 2 ? 90.0f : 0.0f));
    }
  };
  chain({0, 0.02f, 0}, {0, -1.31f, 0});
  for (int i = 0; i < 3; ++i) {
    const float a = 2.0944f * static_cast<float>(i);
    chain({0.03f * std::cos(a), -1.38f, 0.03f * std::sin(a)},
          {0.215f * std::cos(a), dish + 0.05f, 0.215f * std::sin(a)});
  }
  append(
      model.in(palette.coal),
      turned_vessel({{0, dish - 0.02f}, {0.16f, dish + 0.01f}, {0.14f, dish + 0.028f}, {0, dish + 0.035f}}, 32, 3));
  return model;
}

Model urn(const Palette& palette, int shape) {
  const std::vector<glm::vec2> shapes[] = {{{0, -0.005f},
                                            {0.15f, -0.003f},
                                            {0.16f, 0.04f},
                                            {0.11f, 0.09f},
                                            {0.24f, 0.28f},
                                            {0.36f, 0.58f},
                                            {0.33f, 0.82f},
                                            {0.17f, 0.98f},
                                            {0.15f, 1.06f},
                                            {0.22f, 1.13f},
                                            {0.20f, 1.14f},
                                            {0.125f, 1.05f},
                                            {0.14f, 0.95f},
                                            {0, 0.85f}},
                                           {{0, -0.005f},
                                            {0.10f, -0.003f},
                                            {0.12f, 0.03f},
                                            {0.20f, 0.20f},
                                            {0.27f, 0.45f},
                                            {0.22f, 0.72f},
                                            {0.10f, 0.86f},
                                            {0.08f, 0.98f},
                                            {0.12f, 1.04f},
                                            {0.10f, 1.045f},
                                            {0.06f, 0.97f},
                                            {0, 0.86f}}};
  Model model{"urn", {}};
  append(model.in(palette.terracotta), turned_vessel(shapes[shape], 32, 2));
  const float reach = shape == 0 ? 0.33f : 0.24f, low = shape == 0 ? 0.76f : 0.66f,
              high = shape == 0 ? 1.03f : 0.93f, neck = shape == 0 ? 0.155f : 0.085f;
  for (const float side : {-1.0f, 1.0f}) {
    append(model.in(palette.terracotta), tube(curve(std::vector<glm::vec3>{{side * (reach - 0.01f), low, 0},
                                                                           {side * (reach + 0.09f), low + 0.12f, 0},
                                                                           {side * (neck + 0.14f), high + 0.02f, 0},
                                                                           {side * neck, high, 0}},
                                                    4),
                                              0.022f, 7));
  }
  if (shape == 0)
    append(model.in(palette.blue_band),
           lathe({{0.352f, 0.54f}, {0.368f, 0.55f}, {0.372f, 0.60f}, {0.362f, 0.65f}, {0.345f, 0.66f}}, 32));
  return model;
}

Model altar(const Palette& palette) {
  Model model{"altar", {}};
  Mesh& stone = model.in(palette.marble);
  append(stone, bevel_box({-1.15f, -0.02f, -0.55f}, {1.15f, 0.14f, 0.55f}, 0.02f));
  append(stone, bevel_box({-1.0f, 0.13f, -0.42f}, {1.0f, 0.86f, 0.42f}, 0.02f));
  append(stone, rounded_box({2.36f, 0.15f, 1.14f}, 0.05f, 4), at(0, 0.93f, 0));
  for (int i = 0; i < 5; ++i) {  // gilded suns on its front
    append(model.in(palette.gold),
           lathe(curve(
                     std::vector<glm::vec2>{
                         {0, -0.02f}, {0.13f, -0.02f}, {0.14f, 0.01f}, {0.10f, 0.02f}, {0.05f, 0.035f}, {0, 0.04f}},
                     2),
                 24),
           at(-0.76f + 0.38f * static_cast<float>(i), 0.5f, 0.42f) * turned(90, {1, 0, 0}));
  }
  append(model.in(palette.gold), turned_vessel({{0, 1.003f},
                                                {0.13f, 1.003f},
                                                {0.10f, 1.03f},
                                                {0.04f, 1.08f},
                                                {0.05f, 1.13f},
                                                {0.20f, 1.20f},
                                                {0.26f, 1.29f},
                                                {0.245f, 1.295f},
                                                {0.18f, 1.22f},
                                                {0, 1.17f}},
                                               36, 2));
  for (const float x : {-0.75f, 0.75f}) {
    append(model.in(palette.gold),
           turned_vessel({{0, 1.003f},
                          {0.09f, 1.004f},
                          {0.05f, 1.04f},
                          {0.022f, 1.10f},
                          {0.03f, 1.20f},
                          {0.02f, 1.33f},
                          {0.05f, 1.37f},
                          {0.045f, 1.375f},
                          {0, 1.36f}},
                         20, 2),
           at(x, 0, 0));
  }
  return model;
}

Model rubble(const Palette& palette, uint32_t seed, float spread, int stones) {
  Random random(seed);
  Model model{"rubble", {}};
  for (int i = 0; i < stones; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(stones);
    const float size = 0.48f * std::pow(1 - share, 2.0f) + 0.05f;
    const float a = random.range(0.0f, 6.28f), r = spread * std::sqrt(random.unit()) * (0.35f + 0.65f * share);
    Mesh stone =
        rounded_box(size * glm::vec3(random.range(0.8f, 1.5f), random.range(0.5f, 0.9f), random.range(0.7f, 1.2f)),
                    0.10f * size, 1, 3);
    const glm::vec3 phase{random.range(0, 6.0f), random.range(0, 6.0f), random.range(0, 6.0f)};
    deform(stone, [&](glm::vec3 p) {
      const glm::vec3 q = p * (7.0f / size) * 0.5f + phase;
      return p * (1.0f + 0.10f * std::sin(q.x + q.y) * std::sin(q.z - q.y) + 0.06f * std::sin(2.1f * q.x + q.z));
    });
    append(model.in(palette.block[random.below(3)]), stone,
           at(r * std::cos(a), 0.22f * size, r * std::sin(a)) *
               turned(random.range(0, 360), {random.range(-0.3f, 0.3f), 1, random.range(-0.3f, 0.3f)}));
  }
  return model;
}

Model ivy_wall(const Palette& palette, glm::vec2 size, bool hanging, uint32_t seed) {
  const Shrub plant = ivy(size, static_cast<int>(6 * size.x), hanging, seed);
  Model model{"ivy", {}};
  append(model.in(palette.ivy_stem), plant.wood);
  append(model.in(palette.ivy_leaf), plant.leaves);
  return model;
}

Model banner(const Palette& palette, uint32_t seed) {
  const float phase = static_cast<float>(seed);
  Model model{"banner", {}};
  append(model.in(palette.cloth), sheet(16, 20, 0.006f, [=](float u, float v) {
           const float fall = 1 - v, fold = 0.05f * fall * std::sin(13 * u + 2 * fall + phase) +
                                            0.03f * std::sin(3 * fall + phase);
           const float point = 0.28f * (0.5f - std::abs(u - 0.5f)) * 2 * fall;
           return glm::vec3((u - 0.5f) * (1.0f - 0.06f * fall), -2.6f * fall - point, fold + 0.02f);
         }));
  append(model.in(palette.gold), tube({{-0.60f, 0.0f, 0.02f}, {0.60f, 0.0f, 0.02f}}, 0.025f, 12));
  for (const float x : {-0.60f, 0.60f}) append(model.in(palette.gold), sphere(0.055f, 16), at(x, 0, 0.02f));
  return model;
}

}  // namespace gnomon::scenes::assets::temple
