// Scenes made to be hard for tracers: what light buffers, which sort triangles by direction, sort worst.
#pragma once

#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace gnomon::bench {

// meadow   a million blades of grass under four lamps that hang low
// bush     two lamps inside a ball of leaves, two outside
// clutter  shelves' worth of small round things, heaped on a floor
// bars     long thin bars across a hall in all directions, some close to the lamps
// sheets   large sheets that hang side by side, all of them seen edge-on by some lamp
// hills    a fine height field with lamps low above it
std::vector<std::string_view> made_scene_names();

// nullptr if no scene has that name. The same name gives the same scene.
scenes::ScenePtr made_scene(std::string_view name);

}  // namespace gnomon::bench
