#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {
namespace {

constexpr float kWall = 0.22f;  // thickness
constexpr float kSunk = 0.01f;  // how far parts reach into what they stand on, so that no two faces coincide
constexpr float kDoorWest = 5.35f, kDoorEast = 6.30f, kDoorHigh = 2.12f;

void add_box(Mesh& mesh, glm::vec3 low, glm::vec3 high, float bevel = 0.004f) {
  append(mesh, bevel_box(low, high, bevel));
}

// Boards of random length in staggered rows along X, with a shadow gap between.
void add_floor(Stage& stage, const Palette& palette) {
  constexpr float kBoard = 0.14f, kGap = 0.003f, kThick = 0.02f;
  Random random(11);
  Model boards{"floor boards", {}};
  for (int row = 0; static_cast<float>(row) * kBoard < kDepth; ++row) {
    const float z = static_cast<float>(row) * kBoard;
    for (float x = -random.range(0.0f, 1.6f); x < kWidth;) {
      const float length = random.range(1.3f, 2.2f);
      const float from = std::max(x, -kSunk), to = std::min(x + length, kWidth + kSunk);
      if (to - from > 0.02f) {
        add_box(boards.in(palette.floor[random.below(4)]), {from, -kThick, z}, {to - kGap, 0.0f, z + kBoard - kGap},
                0.0f);
      }
      x += length;
    }
  }
  stage.place(std::move(boards));
  Model ground{"floor", {}};
  add_box(ground.in(palette.floor_gap), {-0.5f, -0.25f, -0.5f}, {kWidth + 0.5f, -0.012f, kDepth + 0.5f});
  stage.place(std::move(ground));
}

void add_walls(Stage& stage, const Palette& palette) {
  const float low = -0.1f, high = kHeight + 0.1f;
  Model walls{"walls", {}};
  Mesh& pale = walls.in(palette.plaster);
  // North and south walls run past the corners; east and west ones end inside them.
  add_box(walls.in(palette.blush_wall), {-0.4f, low, -kWall}, {kWidth + 0.4f, high, 0.0f});
  const float end = kDepth + 0.5f * kWall, start = -0.5f * kWall;
  add_box(pale, {kWidth, low, start}, {kWidth + kWall, high, end});
  // West: four blocks around the window. They do not overlap, and their seams lie within the depth of the frame.
  add_box(pale, {-kWall, low, start}, {0.0f, high, kWindowNorth}, 0.002f);
  add_box(pale, {-kWall, low, kWindowSouth}, {0.0f, high, end}, 0.002f);
  add_box(pale, {-kWall, low, kWindowNorth}, {0.0f, kWindowLow, kWindowSouth}, 0.0005f);
  add_box(pale, {-kWall, kWindowHigh, kWindowNorth}, {0.0f, high, kWindowSouth}, 0.0005f);
  // South: the blocks around the door.
  const float south = kDepth, back = kDepth + kWall;
  add_box(pale, {-0.4f, low, south}, {kDoorWest, high, back}, 0.0005f);
  add_box(pale, {kDoorEast, low, south}, {kWidth + 0.4f, high, back}, 0.0005f);
  add_box(pale, {kDoorWest, kDoorHigh, south}, {kDoorEast, high, back}, 0.0005f);
  stage.place(std::move(walls));
}

void add_ceiling(Stage& stage, const Palette& palette) {
  Model ceiling{"ceiling", {}};
  add_box(ceiling.in(palette.ceiling), {-0.5f, kHeight, -0.5f}, {kWidth + 0.5f, kHeight + 0.2f, kDepth + 0.5f});
  // A cornice of two steps along the walls.
  for (const float step : {0.06f, 0.03f}) {
    Mesh& mesh = ceiling.in(palette.white_paint);
    const float low = kHeight - 0.09f + step, d = step;
    add_box(mesh, {-kSunk, low, -kSunk}, {kWidth + kSunk, kHeight + kSunk, d});
    add_box(mesh, {-kSunk, low, kDepth - d}, {kWidth + kSunk, kHeight + kSunk, kDepth + kSunk});
    add_box(mesh, {-kSunk, low + 0.001f, d - kSunk}, {d, kHeight + kSunk, kDepth - d + kSunk});
    add_box(mesh, {kWidth - d, low + 0.001f, d - kSunk}, {kWidth + kSunk, kHeight + kSunk, kDepth - d + kSunk});
  }
  stage.place(std::move(ceiling));
}

void add_skirting(Stage& stage, const Palette& palette) {
  constexpr float kHigh = 0.09f, kThick = 0.016f;
  Model skirting{"skirting", {}};
  Mesh& mesh = skirting.in(palette.white_paint);
  add_box(mesh, {kThick - kSunk, -kSunk, -kSunk}, {kWidth - kThick + kSunk, kHigh, kThick});
  add_box(mesh, {-kSunk, -kSunk, -kSunk}, {kThick, kHigh - 0.001f, kDepth + kSunk});
  add_box(mesh, {kWidth - kThick, -kSunk, -kSunk}, {kWidth + kSunk, kHigh - 0.001f, kDepth + kSunk});
  add_box(mesh, {kThick - kSunk, -kSunk, kDepth - kThick}, {kDoorWest - 0.085f, kHigh, kDepth + kSunk});
  add_box(mesh, {kDoorEast + 0.085f, -kSunk, kDepth - kThick}, {kWidth - kThick + kSunk, kHigh, kDepth + kSunk});
  stage.place(std::move(skirting));
}

void add_door(Stage& stage, const Palette& palette) {
  Model door{"door", {}};
  Mesh& mesh = door.in(palette.white_paint);
  const float z = kDepth;
  for (const float x : {kDoorWest, kDoorEast}) {
    const float side = x == kDoorWest ? -0.07f : 0.07f;
    add_box(mesh, {std::min(x, x + side), -kSunk, z - 0.022f},
            {std::max(x, x + side), kDoorHigh + 0.071f, z + 0.03f});
  }
  add_box(mesh, {kDoorWest - 0.06f, kDoorHigh, z - 0.021f}, {kDoorEast + 0.06f, kDoorHigh + 0.07f, z + 0.03f});
  add_box(mesh, {kDoorWest + 0.001f, 0.006f, z + 0.03f}, {kDoorEast - 0.001f, kDoorHigh - 0.002f, z + 0.07f});
  const float middle = 0.5f * (kDoorWest + kDoorEast);
  for (const float x : {middle - 0.21f, middle + 0.21f}) {
    add_box(mesh, {x - 0.15f, 0.2f, z + 0.02f}, {x + 0.15f, 0.9f, z + 0.06f}, 0.012f);
    add_box(mesh, {x - 0.15f, 1.05f, z + 0.02f}, {x + 0.15f, 1.95f, z + 0.06f}, 0.012f);
  }
  const glm::vec3 knob(kDoorWest + 0.07f, 1.0f, z);
  append(door.in(palette.brass), sphere(0.028f, 20), at(knob + glm::vec3(0, 0, -0.025f)));
  append(door.in(palette.brass), cylinder(0.012f, -0.02f, 0.04f, 14, 0.001f), at(knob) * turned(90, {1, 0, 0}));
  stage.place(std::move(door));
}

void add_window(Stage& stage, const Palette& palette) {
  Model window{"window", {}};
  Mesh& mesh = window.in(palette.black_metal);
  const float out = -0.16f, in = -0.10f, bar = 0.05f;
  const auto upright = [&](float z, float half) {
    add_box(mesh, {out, kWindowLow - kSunk, z - half}, {in, kWindowHigh + kSunk, z + half});
  };
  const auto rail = [&](float y, float half) {
    add_box(mesh, {out + 0.002f, y - half, kWindowNorth - kSunk}, {in - 0.002f, y + half, kWindowSouth + kSunk});
  };
  upright(kWindowNorth + 0.02f, 0.5f * bar), upright(kWindowSouth - 0.02f, 0.5f * bar);
  rail(kWindowLow + 0.02f, 0.5f * bar), rail(kWindowHigh - 0.02f, 0.5f * bar), rail(0.95f, 0.02f);
  for (int i = 1; i < 4; ++i) upright(glm::mix(kWindowNorth, kWindowSouth, static_cast<float>(i) / 4), 0.018f);
  add_box(window.in(palette.white_paint), {-0.12f, kWindowLow - 0.03f, kWindowNorth - 0.06f},
          {0.10f, kWindowLow + 0.006f, kWindowSouth + 0.06f}, 0.008f);
  stage.place(std::move(window));
}

}  // namespace

void add_shell(Stage& stage, const Palette& palette) {
  add_floor(stage, palette);
  add_walls(stage, palette);
  add_ceiling(stage, palette);
  add_skirting(stage, palette);
  add_door(stage, palette);
  add_window(stage, palette);
}

void add_window_dressing(Stage& stage, const Palette& palette) {
  // A blind half let down: slats that let the low sun through in stripes.
  Model slat{"blind slat", {}};
  const float length = kWindowSouth - kWindowNorth - 0.08f;
  append(slat.in(palette.blind), sheet(6, 5, 0.0025f, [=](float u, float v) {
           const float across = 2 * v - 1;
           return glm::vec3(-0.032f * across, 0.005f * (1 - across * across), (u - 0.5f) * length);
         }));
  const uint32_t model = stage.add(std::move(slat));
  const float middle = 0.5f * (kWindowNorth + kWindowSouth);
  for (int i = 0; i < 24; ++i) {
    const float y = kWindowHigh - 0.07f - 0.062f * static_cast<float>(i);
    stage.place(model, at(-0.045f, y, middle) * turned(14.0f, {0, 0, 1}));
  }
  Model rails{"blind rails", {}};
  add_box(rails.in(palette.white_paint), {-0.085f, kWindowHigh - 0.05f, kWindowNorth + 0.03f},
          {-0.01f, kWindowHigh - 0.004f, kWindowSouth - 0.03f});
  const float bottom = kWindowHigh - 0.07f - 0.062f * 24;
  add_box(rails.in(palette.white_paint), {-0.07f, bottom - 0.012f, kWindowNorth + 0.04f},
          {-0.02f, bottom + 0.012f, kWindowSouth - 0.04f});
  for (const float z : {kWindowNorth + 0.4f, middle, kWindowSouth - 0.4f}) {
    append(rails.in(palette.white_paint), cylinder(0.0035f, bottom, kWindowHigh - 0.02f, 8, 0.0005f),
           at(-0.012f, 0, z));
  }
  const std::vector<glm::vec3> rod{{0.13f, 2.62f, kWindowNorth - 0.75f}, {0.13f, 2.62f, kWindowSouth + 0.75f}};
  append(rails.in(palette.brass), tube(rod, 0.014f, 16));
  for (const glm::vec3& end : rod) append(rails.in(palette.brass), sphere(0.032f, 18), at(end));
  for (const float z : {kWindowNorth - 0.7f, middle, kWindowSouth + 0.7f}) {
    append(rails.in(palette.brass), cylinder(0.010f, -0.01f, 0.13f, 10, 0.001f),
           at(0, 2.60f, z) * turned(-90, {0, 0, 1}));
  }
  stage.place(std::move(rails));
  stage.place(curtain(palette, 3), at(0.13f, 2.62f, kWindowNorth - 0.36f) * turned(90));
  stage.place(curtain(palette, 5), at(0.13f, 2.62f, kWindowSouth + 0.36f) * turned(90));
}

}  // namespace gnomon::scenes::assets::room
