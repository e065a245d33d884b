// Every triangle tested in C++ for every bit of a frame, from the frame's own surface points.
#pragma once

#include <cstddef>
#include <optional>

#include "common/light_planes.h"
#include "scenes/scene.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::test {

struct Count {
  size_t surfaces = 0, lit = 0, dark = 0, differing = 0;

  void operator+=(const Count& other) {
    surfaces += other.surfaces;
    lit += other.lit;
    dark += other.dark;
    differing += other.differing;
  }
};

// The planes that a frame's mask has of each light.
LightPlanes planes_of(const scenes::Scene& scene, SampleCounts samples);

// `scene`: at rest, as the frame shows it; without alpha tests; `frame` hard.
Count compare(const scenes::Scene& scene, const gpu::CameraView& camera, const gpu::ProbedFrame& frame);

struct SoftCount {
  size_t asked = 0;      // pairs of pixel and light
  size_t penumbrae = 0;  // of these, that see some points of an area light and others not
  size_t lit = 0, dark = 0;
  size_t differing = 0;  // by a plane of their mask or by a valid bit
};

// As compare, for a soft frame. Its occlusion is not looked at.
SoftCount compare_soft(const scenes::Scene& scene, const gpu::CameraView& camera, const gpu::ProbedFrame& frame);

struct OcclusionCount {
  size_t counted = 0;  // pixels
  size_t open = 0, partly = 0, enclosed = 0;
  size_t differing = 0;  // by a plane of their mask or by a valid bit, also of pixels that count nothing
};

// The occlusion of a frame's ambient light. `scene`: at rest, as the frame shows it; without alpha tests.
OcclusionCount compare_occlusion(const scenes::Scene& scene, const gpu::CameraView& camera,
                                 const gpu::ProbedFrame& frame);

// What the planes of a light have of one pixel: the bits of the mask and those that are valid, plane by plane from bit 0.
struct PlaneBits {
  uint32_t mask = 0, valid = 0;
};
// `seen`: nullopt if the pair is not asked.
PlaneBits plane_bits(std::optional<uint32_t> seen, uint32_t samples);

}  // namespace gnomon::test
