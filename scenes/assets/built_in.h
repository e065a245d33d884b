// The scenes that come with Gnomon. Both are deterministic, and their cameras fly a closed loop.
#pragma once

#include "scenes/assets/stage.h"

namespace gnomon::scenes::assets {

// A furnished living and dining room at dusk: the low sun through a blind, an arc lamp, a pendant.
Stage make_living_room();

// A sun temple open to the sky in places: columns, statues, braziers, lamps, ivy.
Stage make_temple();

}  // namespace gnomon::scenes::assets
