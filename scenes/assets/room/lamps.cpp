#include <cmath>

#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {

// A basket of bent ribs about a bulb: it draws fine lines over walls and ceiling.
Model pendant(const Palette& palette) {
  Model model{"pendant", {}};
  const float cord_end = -kPendantDrop + 0.20f;
  append(model.in(palette.black_metal), cylinder(0.004f, cord_end, 0.01f, 8, 0.0005f));
  append(model.in(palette.black_metal),
         turned_vessel({{0, -0.035f}, {0.02f, -0.033f}, {0.05f, -0.012f}, {0.052f, 0.004f}, {0, 0.005f}}, 28, 3));
  append(model.in(palette.brass), cylinder(0.022f, cord_end - 0.055f, cord_end + 0.012f, 20, 0.004f));
  const auto outline = [](float t) {  // radius and height over the bulb along a rib
    const float a = 3.14159f * (0.10f + 0.74f * t);
    return glm::vec2(0.31f * std::sin(a), 0.22f * std::cos(a));
  };
  for (int i = 0; i < 16; ++i) {
    std::vector<glm::vec3> rib;
    for (int k = 0; k <= 14; ++k) {
      const glm::vec2 p = outline(static_cast<float>(k) / 14);
      rib.emplace_back(p.x, p.y, 0);
    }
    append(model.in(palette.rattan), tube(rib, 0.0015f, 5),
           at(0, -kPendantDrop, 0) * turned(22.5f * static_cast<float>(i)));
  }
  for (const float t : {0.0f, 1.0f}) {
    const glm::vec2 p = outline(t);
    const float r = p.x + 0.004f;
    std::vector<glm::vec2> ring;
    for (int k = 0; k <= 6; ++k) {
      const float a = 6.2831853f * static_cast<float>(k % 6) / 6;
      ring.emplace_back(r + 0.0045f * std::cos(a), p.y + 0.0045f * std::sin(a));
    }
    append(model.in(palette.rattan), lathe(ring, 48), at(0, -kPendantDrop, 0));
  }
  // Three spokes hold the basket to the socket.
  for (int i = 0; i < 3; ++i) {
    const glm::vec2 top = outline(0.0f);
    append(model.in(palette.brass),
           tube({{0.02f, cord_end - 0.02f, 0}, {top.x, -kPendantDrop + top.y, 0}}, 0.003f, 8),
           turned(120.0f * static_cast<float>(i)));
  }
  return model;
}

Model arc_lamp(const Palette& palette) {
  Model model{"arc lamp", {}};
  append(model.in(palette.black_metal), lathe(curve(std::vector<glm::vec2>{{0, -0.002f},
                                                                           {0.17f, -0.002f},
                                                                           {0.175f, 0.02f},
                                                                           {0.16f, 0.035f},
                                                                           {0.05f, 0.042f},
                                                                           {0.02f, 0.06f},
                                                                           {0, 0.062f}},
                                                    3),
                                              40));
  const glm::vec3 hang = kArcBulb + glm::vec3(0, 0.17f, 0);
  append(model.in(palette.brass), tube(curve(std::vector<glm::vec3>{{0, 0.05f, 0},
                                                                    {0, 1.10f, -0.05f},
                                                                    {0, 1.88f, 0.10f},
                                                                    {0, 2.33f, 0.55f},
                                                                    {0, 2.38f, 0.95f},
                                                                    hang + glm::vec3(0, 0.06f, 0.0f)},
                                             8),
                                       0.011f, 10));
  // A shallow dome, open below; the bulb sits a little above its rim.
  append(model.in(palette.shade),
         lathe(curve(
                   std::vector<glm::vec2>{
                       {0.215f, -0.012f}, {0.21f, 0.03f}, {0.17f, 0.11f}, {0.09f, 0.165f}, {0, 0.185f}},
                   4),
               44),
         at(kArcBulb));
  append(model.in(palette.shade),
         lathe(curve(
                   std::vector<glm::vec2>{
                       {0, 0.178f}, {0.087f, 0.158f}, {0.164f, 0.105f}, {0.204f, 0.028f}, {0.211f, -0.012f}},
                   4),
               44),
         at(kArcBulb));
  append(model.in(palette.shade),
         lathe({{0.211f, -0.012f}, {0.2115f, -0.0125f}, {0.2145f, -0.0125f}, {0.215f, -0.012f}}, 44), at(kArcBulb));
  append(model.in(palette.brass),
         turned_vessel({{0, 0.17f}, {0.028f, 0.175f}, {0.026f, 0.20f}, {0.012f, 0.235f}, {0, 0.237f}}, 24, 3),
         at(kArcBulb));
  append(model.in(palette.brass), cylinder(0.017f, 0.075f, 0.181f, 20, 0.003f), at(kArcBulb));
  return model;
}

}  // namespace gnomon::scenes::assets::room
