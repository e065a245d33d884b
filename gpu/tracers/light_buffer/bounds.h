// Fits the near plane and the cover plane of a node to the footprints that meet it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gpu/tracers/light_buffer/footprint.h"

namespace gnomon::gpu::light_buffer {

// Of the footprints that cover the complete rectangle, the one nearest to the light; nullptr if none covers it.
const Footprint* find_cover(std::span<const Footprint* const> met, const Rect& rect);

// Whether everything that the rectangle shows of `f` is behind `cover`, so that `cover` darkens whatever `f` does.
bool hidden(const Footprint& f, const Footprint& cover, const Rect& rect);

// The nearness of the nearest part of `f` that the rectangle shows; infinite if `f` is unbounded. Never NaN.
double nearest_in(const Footprint& f, const Rect& rect);

// Sets `plane` to a plane in front of all footprints, fitted tightly but not optimally. `nearness`: of each, by nearest_in;
// those nearest to the light come first. Returns false if one of the footprints is unbounded.
bool fit_near_plane(std::span<const Footprint* const> met, std::span<const double> nearness, const Rect& rect,
                    Linear& plane);

}  // namespace gnomon::gpu::light_buffer
