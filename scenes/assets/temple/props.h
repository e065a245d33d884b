// The models of the sun temple. Each has its origin on the ground and faces +Z.
#pragma once

#include <cstdint>

#include "scenes/assets/stage.h"

namespace gnomon::scenes::assets::temple {

// The nave runs along Z from the gate (z = 0) to the apse wall (z = -kLength); x = 0 is its middle.
inline constexpr float kLength = 30.0f;
inline constexpr float kHalfWidth = 7.0f;  // to the inner face of the side walls
inline constexpr float kColumnX = 3.6f;    // the two rows of columns
inline constexpr float kColumnHeight = 6.4f;
inline constexpr float kBay = 3.6f;           // from column to column
inline constexpr int kColumns = 7;            // in a row
inline constexpr float kFirstColumn = -2.4f;  // z of the first
inline constexpr float kBeam = 0.85f;         // height of the architrave over the columns
inline constexpr float kDais = 0.9f;          // height of the platform before the apse, reached by steps
inline constexpr float kDaisFront = -23.4f;

// Materials by name; each is an index into Stage::materials.
struct Palette {
  explicit Palette(Stage& stage);

  uint32_t limestone, sandstone, paving[3], joint, red_band, blue_band, marble, granite, bronze, gold;
  uint32_t terracotta, coal, ivy_leaf, ivy_stem, earth, cypress, block[3], cloth;
};

void add_ground(Stage& stage, const Palette& palette);   // paving, steps, dais
void add_walls(Stage& stage, const Palette& palette);    // courses of blocks, windows, gate, apse
void add_country(Stage& stage, const Palette& palette);  // the landscape seen through gate and windows
void add_roof(Stage& stage, const Palette& palette);     // beams, coffers, the broken bay

Model column(const Palette& palette);  // base, fluted shaft, leafed capital; kColumnHeight high
Model broken_column(const Palette& palette);
Model sun_disk(const Palette& palette);  // centred on the origin, 1.5 m in radius, its back at z = 0

Model guardian(const Palette& palette);  // a robed figure with a staff, 2.3 m without its plinth
Model bearer(const Palette& palette);    // a robed figure that holds up a bowl
Model sphinx(const Palette& palette);
Model plinth(const Palette& palette, float width, float height);

Model brazier(const Palette& palette);       // its fire kFireHeight over the ground
Model hanging_lamp(const Palette& palette);  // hangs from the origin; its flame kLampDrop below
Model urn(const Palette& palette, int shape);
Model altar(const Palette& palette);
Model rubble(const Palette& palette, uint32_t seed, float spread, int stones);
Model ivy_wall(const Palette& palette, glm::vec2 size, bool hanging, uint32_t seed);
Model banner(const Palette& palette, uint32_t seed);
inline constexpr float kFireHeight = 1.85f, kLampDrop = 2.6f;

}  // namespace gnomon::scenes::assets::temple
