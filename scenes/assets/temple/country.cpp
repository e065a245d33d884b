#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"
#include "scenes/assets/temple/props.h"

namespace gnomon::scenes::assets::temple {
namespace {

constexpr float kLevel = -0.42f;  // of the land by the temple
constexpr glm::vec2 kMiddle{0.0f, -15.0f};

// Level about the temple, then rising into hills.
float land_height(glm::vec2 p) {
  const float away = std::max(glm::distance(p, kMiddle) - 26.0f, 0.0f);
  return kLevel + 0.0022f * away * away * (1.2f + std::sin(0.11f * p.x) * std::cos(0.09f * p.y));
}

Model cypress(const Palette& palette) {
  Model model{"cypress", {}};
  append(model.in(palette.cypress), barrel(18, 20, [](float u, float v) {
           const float a = 6.2831853f * u;
           const float outline = 0.75f * std::pow(std::sin(3.14159f * (0.05f + 0.94f * std::pow(v, 0.6f))), 0.9f);
           const float tufts =
               1.0f + 0.14f * std::sin(5 * a + 9 * v) * std::sin(17 * v) + 0.08f * std::sin(9 * a - 31 * v);
           const float r = outline * tufts + 0.004f;
           return glm::vec3(r * std::cos(a), 0.45f + 5.6f * v, -r * std::sin(a));
         }));
  append(model.in(palette.ivy_stem), cylinder(0.11f, -0.4f, 0.8f, 10, 0.01f));
  return model;
}

}  // namespace

void add_country(Stage& stage, const Palette& palette) {
  Model land{"land", {}};
  append(land.in(palette.earth), sheet(40, 40, 0.5f, [](float u, float v) {
           const glm::vec2 p = kMiddle + 160.0f * glm::vec2(u - 0.5f, 0.5f - v);
           return glm::vec3(p.x, land_height(p), p.y);
         }));
  stage.place(std::move(land));

  Random random(51);
  const uint32_t tree = stage.add(cypress(palette));
  const glm::vec2 groves[] = {{-4.2f, 12.0f},  {4.6f, 11.0f},    {-1.9f, 21.0f},   {2.8f, 24.0f},
                              {-13.5f, -5.0f}, {-14.8f, -12.0f}, {-13.0f, -20.0f}, {13.2f, -6.5f},
                              {15.0f, -12.5f}, {13.6f, -21.0f},  {-7.5f, 19.0f},   {8.0f, 17.0f}};
  for (const glm::vec2& p : groves) {
    const float size = random.range(0.8f, 1.25f);
    stage.place(tree, at(p.x, land_height(p), p.y) * turned(random.range(0.0f, 360.0f)) * scaled(size, size, size));
  }
}

}  // namespace gnomon::scenes::assets::temple
