// Every triangle tested in C++ for every bit of a frame, from the frame's own surface points.
#pragma once

#include <cstddef>

#include "scenes/scene.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::test {

struct Count {
  size_t surfaces = 0, lit = 0, dark = 0, differing = 0;
};

// `scene`: at rest, as the frame shows it; without alpha tests.
Count compare(const scenes::Scene& scene, const gpu::CameraView& camera, const gpu::ProbedFrame& frame);

}  // namespace gnomon::test
