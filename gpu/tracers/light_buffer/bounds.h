// The two planes of a node, fitted to the footprints that meet it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gpu/tracers/light_buffer/footprint.h"

namespace gnomon::gpu::light_buffer {

// The footprint that covers the whole rectangle nearest to the light; nullptr: none does.
const Footprint* find_cover(std::span<const Footprint* const> met, const Rect& rect);

// Is all that the rectangle shows of `f` behind `cover`? Then whatever `f` darkens is dark by the cover.
bool hidden(const Footprint& f, const Footprint& cover, const Rect& rect);

// A plane in front of all footprints, as tight as one plane can be made cheaply. False: an unbounded footprint is
// among them.
bool fit_near_plane(std::span<const Footprint* const> met, const Rect& rect, Linear& plane);

// Nearness of the nearest part of `f` that the rectangle shows; infinite for an unbounded one.
double nearest_in(const Footprint& f, const Rect& rect);

}  // namespace gnomon::gpu::light_buffer
