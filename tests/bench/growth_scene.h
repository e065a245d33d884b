// A scene that grows: one hall, and in it as many vessels and lamps as are asked for.
#pragma once

#include <cstdint>

#include "scenes/scene.h"

namespace gnomon::bench {

// About `triangles` triangles (within those of one vessel; never fewer than the hall with one) under `lights` point
// lights. Vessels are instances of one mesh on a square grid over the floor: the more, the smaller. The camera's rest
// sees all of them, and so does the path of orbit_pose. The same for the same arguments.
scenes::ScenePtr growth_scene(uint64_t triangles, uint32_t lights);

}  // namespace gnomon::bench
