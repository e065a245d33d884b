// A resident scene at one time: its moving geometry, its lights, and the structures that trace them.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "gpu/builds/moving_bvh.h"
#include "gpu/scene/frame_uniforms.h"
#include "gpu/tracers/tracer.h"
#include "scenes/geometry/clusters.h"
#include "scenes/motion.h"

namespace gnomon::gpu {

// Immutable; a frame keeps it until the next frame of its slot.
//
// A light counts as moving if it is not where the tracer built for it: then a hierarchy of the resting geometry is
// traced for it. Tracers that do not build for lights trace all lights. The moving geometry is traced for every light.
struct PosedScene {
  scenes::SceneTime time{};
  scenes::WorldMesh mesh;                   // the moving geometry
  Bvh bvh;                                  // over `mesh`; empty if nothing is traced
  std::vector<BvhPart> parts;               // of `bvh`
  std::vector<scenes::ClusterGroup> draws;  // triangles of `mesh` by pipeline state; without chunks
  std::vector<exact::TracedLight> lights;
  std::vector<scenes::LightArea> areas;                   // of each light
  std::vector<exact::TracedLight> resting_lights;         // as `lights`, but moving lights reach nothing
  std::array<uint32_t, kMaxLights / 32> moving_lights{};  // a bit for each light
  std::shared_ptr<const TracedScene> traced;              // nullptr if the scene is only drawn
  std::shared_ptr<const TracedScene> static_bvh;          // of the resting geometry; nullptr if nothing is traced

  std::shared_ptr<const TracedScene> area_traced;  // built for extents of area lights; nullptr: none yet
  LightSet area_built;                             // the area lights that are as it was built for

  bool any_light_moves() const {
    return std::any_of(moving_lights.begin(), moving_lights.end(), [](uint32_t bits) { return bits != 0; });
  }
  bool at_rest() const { return mesh.triangles.empty() && !any_light_moves(); }
};

using PosedScenePtr = std::shared_ptr<const PosedScene>;

// A light that reaches no surface: all of its bits are 0, and a tracer builds next to nothing for it.
exact::TracedLight silenced_light(const scenes::Bounds& bounds);

bool same_light(const exact::TracedLight& a, const exact::TracedLight& b);

// Divides `mesh` into groups by pipeline state, in the order of its triangles.
std::vector<scenes::ClusterGroup> draws_of(const scenes::Scene& scene, const scenes::WorldMesh& mesh);

}  // namespace gnomon::gpu
