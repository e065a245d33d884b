// A scene of any size: a hall with a given number of vessels and lights.
#pragma once

#include <cstdint>

#include "scenes/scene.h"

namespace gnomon::bench {

// A scene of at most `triangles` triangles, to within those of one vessel (but at least the hall with one vessel), and
// `lights` point lights. Vessels are instances of one mesh on a square grid on the floor: the more, the smaller. The
// camera's rest pose sees all of them, and so does the path of orbit_pose. The same arguments give the same scene.
scenes::ScenePtr growth_scene(uint64_t triangles, uint32_t lights);

}  // namespace gnomon::bench
