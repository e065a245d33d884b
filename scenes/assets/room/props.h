// The models of the living room. Each has its origin on the floor (or where it hangs) and faces +Z.
#pragma once

#include <cstdint>

#include "scenes/assets/stage.h"

namespace gnomon::scenes::assets::room {

// The room's inner size in metres: x to the east, z to the south, the window in the west wall (x = 0).
inline constexpr float kWidth = 8.0f, kDepth = 5.6f, kHeight = 2.9f;
inline constexpr float kWindowLow = 0.30f, kWindowHigh = 2.45f, kWindowNorth = 1.1f, kWindowSouth = 4.5f;

// Materials by name; each is an index into Stage::materials.
struct Palette {
  explicit Palette(Stage& stage);

  uint32_t plaster, blush_wall, ceiling, floor[4], floor_gap, white_paint;
  uint32_t walnut, oak, black_metal, brass, chrome, glass_green;
  uint32_t sofa, mustard, rose, cream, leather, rug_field, rug_border, curtain, blind;
  uint32_t porcelain, stoneware, terracotta, paper, soil, bark, fig_leaf, fern_leaf, snake_leaf;
  uint32_t lemon, orange, apple, screen, bulb, shade, rattan, book[8], art[5];
};

void add_shell(Stage& stage, const Palette& palette);  // floor, walls, ceiling, window, door
void add_window_dressing(Stage& stage, const Palette& palette);

Model sofa(const Palette& palette);
Model armchair(const Palette& palette);
Model dining_chair(const Palette& palette);
Model pouf(const Palette& palette);

Model rug(const Palette& palette);
Model curtain(const Palette& palette, uint32_t seed);  // hangs from the origin, 0.62 m wide

Model coffee_table(const Palette& palette);  // top at 0.42 m
Model dining_table(const Palette& palette);  // top at kTableTop, long side along Z
Model sideboard(const Palette& palette);     // top at 0.62 m
Model lattice_screen(const Palette& palette);
Model picture(const Palette& palette, float width, float height, uint32_t seed);  // its back at z = 0, centred
inline constexpr float kTableTop = 0.75f, kCoffeeTop = 0.42f, kSideboardTop = 0.62f;

Model bookcase(const Palette& palette);
Model record_player(const Palette& palette);
Model book_pile(const Palette& palette, uint32_t seed);

Model place_setting(const Palette& palette);
Model carafe(const Palette& palette);
Model fruit_bowl(const Palette& palette);
Model teapot(const Palette& palette);
Model cup(const Palette& palette);
Model vase(int shape, uint32_t material);
Model flower_vase(const Palette& palette);

Model pendant(const Palette& palette);   // hangs from the origin; its bulb kPendantDrop below
Model arc_lamp(const Palette& palette);  // its bulb at kArcBulb
inline constexpr float kPendantDrop = 1.15f;
inline constexpr glm::vec3 kArcBulb{0.0f, 1.98f, 1.25f};

}  // namespace gnomon::scenes::assets::room
