#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {
namespace {

void add_box(Mesh& mesh, glm::vec3 low, glm::vec3 high, float bevel = 0.004f) {
  append(mesh, bevel_box(low, high, bevel));
}

void add_square_frame(Mesh& mesh, float width, float height, float bar, float back, float front) {
  const float x = 0.5f * width, y = 0.5f * height;
  add_box(mesh, {-x, -y, back}, {-x + bar, y, front});
  add_box(mesh, {x - bar, -y, back}, {x, y, front});
  add_box(mesh, {-x + bar - 0.003f, -y, back + 0.001f}, {x - bar + 0.003f, -y + bar, front - 0.001f});
  add_box(mesh, {-x + bar - 0.003f, y - bar, back + 0.001f}, {x - bar + 0.003f, y, front - 0.001f});
}

}  // namespace

Model coffee_table(const Palette& palette) {
  Model model{"coffee table", {}};
  append(model.in(palette.walnut), lathe({{0, 0.375f},
                                          {0.30f, 0.376f},
                                          {0.44f, 0.382f},
                                          {0.52f, 0.392f},
                                          {0.548f, 0.402f},
                                          {0.556f, 0.410f},
                                          {0.554f, 0.416f},
                                          {0.546f, kCoffeeTop},
                                          {0.546f, kCoffeeTop},
                                          {0, kCoffeeTop}},
                                         64));
  append(model.in(palette.walnut),
         turned_vessel({{0, 0.10f}, {0.13f, 0.10f}, {0.15f, 0.115f}, {0.13f, 0.13f}, {0, 0.13f}}, 32, 2));
  for (int i = 0; i < 3; ++i) {
    const glm::mat4 turn = turned(120.0f * static_cast<float>(i) + 20.0f);
    append(model.in(palette.walnut),
           tube(
               curve(std::vector<glm::vec3>{{0.12f, 0.385f, 0},
                                            {0.17f, 0.30f, 0},
                                            {0.13f, 0.115f, 0},
                                            {0.33f, 0.035f, 0},
                                            {0.44f, -0.002f, 0}},
                     6),
               [](float t) { return 0.024f - 0.010f * t; }, 12),
           turn);
  }
  return model;
}

Model dining_table(const Palette& palette) {
  Model model{"dining table", {}};
  Mesh& wood = model.in(palette.oak);
  // Three boards with bread-board ends, on trestles.
  for (int i = 0; i < 4; ++i) {
    const float x = -0.47f + 0.235f * static_cast<float>(i);
    add_box(wood, {x, kTableTop - 0.036f, -0.88f}, {x + 0.2335f, kTableTop, 0.88f}, 0.004f);
  }
  for (const float z : {-0.92f, 0.92f})
    add_box(wood, {-0.472f, kTableTop - 0.037f, z - 0.045f}, {0.472f, kTableTop + 0.001f, z + 0.045f}, 0.005f);
  for (const float z : {-0.62f, 0.62f}) {
    for (const float x : {-1.0f, 1.0f}) {
      append(wood, tube(
                       {{0.39f * x, -0.002f, z}, {0.27f * x, kTableTop - 0.03f, z}},
                       [](float t) { return 0.026f + 0.012f * t; }, 14));
    }
    add_box(wood, {-0.37f, kTableTop - 0.10f, z - 0.022f}, {0.37f, kTableTop - 0.03f, z + 0.022f}, 0.008f);
    add_box(wood, {-0.34f, 0.27f, z - 0.018f}, {0.34f, 0.32f, z + 0.018f}, 0.008f);
  }
  add_box(wood, {-0.025f, 0.265f, -0.66f}, {0.025f, 0.325f, 0.66f}, 0.008f);
  // A runner of cloth along the middle.
  append(model.in(palette.rose), sheet(4, 24, 0.003f, [](float u, float v) {
           return glm::vec3((u - 0.5f) * 0.30f, kTableTop + 0.004f + 0.0008f * std::sin(40 * v + 9 * u),
                            (0.5f - v) * 1.55f);
         }));
  return model;
}

Model sideboard(const Palette& palette) {
  Model model{"sideboard", {}};
  Mesh& wood = model.in(palette.walnut);
  const float w = 0.9f, d = 0.22f, low = 0.17f;
  add_box(wood, {-w, low, -d}, {w, low + 0.022f, d});
  add_box(wood, {-w - 0.01f, kSideboardTop - 0.024f, -d - 0.003f}, {w + 0.01f, kSideboardTop, d + 0.01f}, 0.006f);
  for (const float x : {-w, w - 0.022f})
    add_box(wood, {x + 0.001f, low + 0.01f, -d + 0.001f}, {x + 0.021f, kSideboardTop - 0.01f, d - 0.001f});
  add_box(wood, {-w + 0.01f, low + 0.01f, -d + 0.002f}, {w - 0.01f, kSideboardTop - 0.01f, -d + 0.014f});
  // Two sliding doors of slats, drawers between.
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < 22; ++i) {
      const float x = side * 0.595f - 0.265f + 0.0243f * static_cast<float>(i);
      add_box(wood, {x, low + 0.03f, d - 0.035f}, {x + 0.016f, kSideboardTop - 0.035f, d - 0.012f}, 0.005f);
    }
    add_box(wood, {side * 0.595f - 0.275f, low + 0.026f, d - 0.045f},
            {side * 0.595f + 0.275f, kSideboardTop - 0.030f, d - 0.03f});
  }
  for (int i = 0; i < 3; ++i) {
    const float y = low + 0.03f + 0.128f * static_cast<float>(i);
    add_box(wood, {-0.30f, y, d - 0.04f}, {0.30f, y + 0.121f, d - 0.008f}, 0.006f);
    append(
        model.in(palette.brass),
        turned_vessel(
            {{0, -0.004f}, {0.008f, 0}, {0.007f, 0.010f}, {0.015f, 0.020f}, {0.012f, 0.027f}, {0, 0.028f}}, 20, 3),
        at(0, y + 0.06f, d - 0.009f) * turned(90, {1, 0, 0}));
  }
  for (const float x : {-0.74f, 0.74f}) {
    for (const float z : {-0.15f, 0.15f}) {
      append(model.in(palette.walnut), tube(
                                           {{1.06f * x, -0.002f, 1.15f * z}, {x, low + 0.01f, z}},
                                           [](float t) { return 0.012f + 0.009f * t; }, 12));
    }
  }
  return model;
}

Model lattice_screen(const Palette& palette) {
  Model model{"lattice screen", {}};
  const float w = 0.62f, h = 1.72f;
  for (int i = 0; i < 2; ++i) {
    const float side = i == 0 ? -1.0f : 1.0f;
    const glm::mat4 panel = turned(side * 16.0f) * at(side * 0.5f * w, 0.06f + 0.5f * h, 0);
    Mesh frame;
    add_square_frame(frame, w - 0.01f, h, 0.045f, -0.016f, 0.016f);
    for (const float x : {-0.5f * w + 0.03f, 0.5f * w - 0.03f})
      append(frame, cylinder(0.016f, -0.5f * h - 0.062f, -0.5f * h + 0.02f, 12, 0.003f), at(x, 0, 0));
    append(model.in(palette.walnut), frame, panel);
    for (int k = 0; k < 3; ++k) {  // square cut-outs one above the other
      const float tall = (h - 0.08f) / 3;
      Mesh cut = surface(
          1, 1, [=](float u, float v) { return glm::vec3((u - 0.5f) * (w - 0.06f), (v - 0.5f) * tall, 0); });
      append(model.in(palette.screen), cut, panel * at(0, (static_cast<float>(k) - 1) * tall, 0));
    }
  }
  return model;
}

Model picture(const Palette& palette, float width, float height, uint32_t seed) {
  Random random(seed);
  Model model{"picture", {}};
  add_square_frame(model.in(palette.oak), width, height, 0.022f, -0.004f, 0.030f);
  add_box(model.in(palette.paper), {-0.5f * width + 0.01f, -0.5f * height + 0.01f, -0.003f},
          {0.5f * width - 0.01f, 0.5f * height - 0.01f, 0.010f}, 0.001f);
  // Cut paper: discs and hills in layers, each a little nearer.
  const float s = std::min(width, height);
  float z = 0.0095f;
  const auto piece = [&](uint32_t colour, const std::vector<glm::vec2>& outline) {
    append(model.in(colour), prism(outline, 0.0022f), at(0, 0, z));
    z += 0.0016f;
  };
  const auto disc = [&](glm::vec2 centre, float radius) {
    std::vector<glm::vec2> outline;
    for (int i = 0; i < 48; ++i) {
      const float a = 6.2831853f * static_cast<float>(i) / 48;
      outline.push_back(centre + radius * glm::vec2(std::cos(a), std::sin(a)));
    }
    return outline;
  };
  piece(palette.art[random.below(2)],
        disc({random.range(-0.12f, 0.12f) * width, random.range(0.05f, 0.15f) * height},
             random.range(0.17f, 0.24f) * s));
  for (int layer = 0; layer < 3; ++layer) {
    const float base = -0.36f * height, phase = random.range(0.0f, 6.0f),
                swing = random.range(0.03f, 0.07f) * height;
    const float top = (0.05f - 0.12f * static_cast<float>(layer)) * height;
    append(model.in(palette.art[2 + (static_cast<uint32_t>(layer) + seed) % 3]),
           sheet(28, 1, 0.003f, [=](float u, float v) {
             const float x = 0.72f * (u - 0.5f);
             return glm::vec3(x * width, glm::mix(base, top + swing * std::sin(7 * x + phase), v), z + 0.0022f);
           }));
    z += 0.0016f;
  }
  return model;
}

}  // namespace gnomon::scenes::assets::room
