#include <cmath>

#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {
namespace {

constexpr int kDetail = 7;  // spans of a cushion's side

void add_leg(Model& model, uint32_t material, glm::vec3 top, glm::vec3 foot, float thick) {
  append(model.in(material), tube(
                                 {foot, top}, [=](float t) { return thick * (0.6f + 0.4f * t); }, 10));
}

glm::mat4 leaning(glm::vec3 position, float back, float turn) {
  return at(position) * turned(turn) * turned(90.0f - back, {1, 0, 0});
}

}  // namespace

// 2.7 m wide with a long seat at its left, its back along z = -0.45.
Model sofa(const Palette& palette) {
  Model model{"sofa", {}};
  Mesh& cloth = model.in(palette.sofa);
  append(cloth, rounded_box({2.70f, 0.22f, 0.94f}, 0.05f, 3), at(0, 0.25f, 0));
  append(cloth, rounded_box({0.93f, 0.218f, 0.80f}, 0.05f, 3), at(-0.884f, 0.25f, 0.78f));
  append(cloth, rounded_box({2.69f, 0.62f, 0.20f}, 0.08f, 4), at(0, 0.45f, -0.37f));
  append(cloth, rounded_box({0.19f, 0.42f, 0.93f}, 0.075f, 4), at(-1.25f, 0.39f, 0.006f));
  append(cloth, rounded_box({0.19f, 0.42f, 0.93f}, 0.075f, 4), at(1.25f, 0.39f, 0.006f));
  append(cloth, cushion({0.76f, 0.16f, 1.40f}, 0.025f, kDetail, 1), at(-0.775f, 0.435f, 0.43f));
  append(cloth, cushion({0.77f, 0.16f, 0.70f}, 0.030f, kDetail, 2), at(0.0f, 0.435f, 0.08f));
  append(cloth, cushion({0.77f, 0.16f, 0.70f}, 0.030f, kDetail, 3), at(0.77f, 0.435f, 0.08f));
  for (int i = 0; i < 3; ++i) {
    const auto seed = static_cast<uint32_t>(4 + i);
    append(cloth, cushion({0.75f, 0.17f, 0.46f}, 0.040f, kDetail, seed),
           leaning({-0.77f + 0.77f * static_cast<float>(i), 0.70f, -0.20f}, 16.0f, 0));
  }
  const Mesh pillow = cushion({0.46f, 0.10f, 0.46f}, 0.055f, kDetail, 9);
  append(model.in(palette.mustard), pillow, leaning({-0.92f, 0.71f, 0.03f}, 24.0f, 28.0f));
  append(model.in(palette.rose), pillow, leaning({-0.62f, 0.69f, 0.08f}, 32.0f, -12.0f));
  append(model.in(palette.cream), pillow, leaning({0.98f, 0.71f, 0.03f}, 24.0f, -30.0f));
  append(model.in(palette.mustard), cushion({0.55f, 0.10f, 0.32f}, 0.05f, kDetail, 12),
         leaning({0.66f, 0.64f, 0.10f}, 34.0f, -8.0f));
  // A throw over the end of the long seat.
  append(model.in(palette.cream),
         sheet(30, 10, 0.008f,
               [](float u, float v) {
                 const float across = (u - 0.5f) * 1.12f, inner = 0.40f;
                 const float over = std::max(std::abs(across) - inner, 0.0f);
                 const float x = std::copysign(
                     std::min(std::abs(across), inner) + std::min(over, 0.02f) + 0.02f * (over > 0), across);
                 const float ripple = 0.006f * std::sin(19 * v + 3 * u) + 0.004f * std::sin(31 * u);
                 return glm::vec3(
                     x, 0.572f - 0.9f * std::max(over - 0.01f, 0.0f) + ripple - 0.03f * std::abs(u - 0.5f),
                     0.42f - 0.45f * v);
               }),
         at(-0.775f, 0, 0.60f));
  for (const float x : {-1.22f, -0.05f, 1.22f}) {
    for (const float z : {-0.36f, 0.36f}) add_leg(model, palette.walnut, {x, 0.16f, z}, {x, -0.002f, z}, 0.024f);
  }
  for (const float x : {-1.25f, -0.52f})
    add_leg(model, palette.walnut, {x, 0.16f, 1.08f}, {x, -0.002f, 1.08f}, 0.024f);
  return model;
}

Model armchair(const Palette& palette) {
  Model model{"armchair", {}};
  Mesh& hide = model.in(palette.leather);
  append(hide, cushion({0.60f, 0.16f, 0.62f}, 0.03f, kDetail, 31), at(0, 0.40f, 0.04f));
  append(hide, cushion({0.60f, 0.14f, 0.56f}, 0.04f, kDetail, 32), leaning({0, 0.67f, -0.27f}, 20.0f, 0));
  Mesh& wood = model.in(palette.walnut);
  for (const float side : {-1.0f, 1.0f}) {
    // One bent frame a side: front leg, arm, back leg.
    const std::vector<glm::vec3> bow = curve(std::vector<glm::vec3>{{side * 0.36f, -0.002f, 0.40f},
                                                                    {side * 0.35f, 0.35f, 0.37f},
                                                                    {side * 0.35f, 0.575f, 0.27f},
                                                                    {side * 0.35f, 0.60f, 0.0f},
                                                                    {side * 0.35f, 0.57f, -0.25f},
                                                                    {side * 0.35f, 0.33f, -0.38f},
                                                                    {side * 0.36f, -0.002f, -0.50f}},
                                             5);
    append(wood, tube(
                     bow, [](float t) { return 0.019f + 0.009f * std::sin(3.14159f * t); }, 10));
    append(wood, tube({{side * 0.33f, 0.30f, -0.33f}, {side * 0.31f, 1.0f, -0.48f}}, 0.016f, 8));
  }
  for (const float z : {-0.30f, 0.34f}) append(wood, tube({{-0.35f, 0.31f, z}, {0.35f, 0.31f, z}}, 0.017f, 8));
  append(wood, tube({{-0.31f, 0.93f, -0.462f}, {0.31f, 0.93f, -0.462f}}, 0.015f, 8));
  for (int i = -2; i <= 2; ++i) {
    const float x = 0.11f * static_cast<float>(i);
    append(wood, tube({{x, 0.305f, -0.30f}, {x, 0.93f, -0.458f}}, 0.009f, 7));
  }
  return model;
}

Model dining_chair(const Palette& palette) {
  Model model{"dining chair", {}};
  Mesh& wood = model.in(palette.oak);
  append(model.in(palette.cream), cushion({0.44f, 0.05f, 0.43f}, 0.014f, 6, 41), at(0, 0.465f, 0.02f));
  append(wood, rounded_box({0.46f, 0.034f, 0.45f}, 0.015f, 3), at(0, 0.432f, 0.02f));
  for (const float side : {-1.0f, 1.0f}) {
    add_leg(model, palette.oak, {side * 0.185f, 0.43f, 0.19f}, {side * 0.215f, -0.002f, 0.23f}, 0.021f);
    const std::vector<glm::vec3> post = curve(std::vector<glm::vec3>{{side * 0.215f, -0.002f, -0.24f},
                                                                     {side * 0.19f, 0.43f, -0.17f},
                                                                     {side * 0.20f, 0.70f, -0.21f},
                                                                     {side * 0.20f, 0.83f, -0.26f}},
                                              5);
    append(wood, tube(
                     post, [](float t) { return 0.014f + 0.007f * (1 - std::abs(2 * t - 1)); }, 10));
    append(wood, tube({{side * 0.20f, 0.20f, 0.21f}, {side * 0.202f, 0.20f, -0.21f}}, 0.010f, 7));
  }
  // A bent top rail and spindles.
  const std::vector<glm::vec3> rail = curve(std::vector<glm::vec3>{{-0.235f, 0.80f, -0.19f},
                                                                   {-0.19f, 0.82f, -0.26f},
                                                                   {0, 0.83f, -0.30f},
                                                                   {0.19f, 0.82f, -0.26f},
                                                                   {0.235f, 0.80f, -0.19f}},
                                            4);
  append(wood, tube(
                   rail, [](float t) { return 0.015f + 0.012f * std::sin(3.14159f * t); }, 10));
  for (int i = -2; i <= 2; ++i) {
    const float x = 0.062f * static_cast<float>(i);
    append(wood, tube(curve(std::vector<glm::vec3>{{x, 0.44f, -0.17f},
                                                   {1.05f * x, 0.62f, -0.235f},
                                                   {1.15f * x, 0.825f, -0.295f + 1.2f * x * x}},
                            3),
                      0.0075f, 7));
  }
  return model;
}

Model pouf(const Palette& palette) {
  Model model{"pouf", {}};
  append(model.in(palette.mustard), barrel(64, 14, [](float u, float v) {
           const float angle = 6.2831853f * u, rise = 3.14159f * (v - 0.5f);
           const float rib = 1.0f + 0.05f * std::pow(std::abs(std::sin(8 * angle)), 0.7f) * std::cos(rise);
           const float r = 0.29f * std::pow(std::max(std::cos(rise), 0.0f), 0.5f) * rib + 0.012f;
           return glm::vec3(r * std::cos(angle), 0.185f + 0.185f * std::sin(rise), -r * std::sin(angle));
         }));
  return model;
}

}  // namespace gnomon::scenes::assets::room
