// A resident scene at one time: the geometry that moves, where its lights are, and what answers for each of them.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "gpu/scene/clusters.h"
#include "gpu/scene/frame_uniforms.h"
#include "gpu/tracers/bvh_build.h"
#include "gpu/tracers/tracer.h"
#include "scenes/motion.h"

namespace gnomon::gpu {

// Immutable; a frame keeps it until the next one of its slot.
//
// A light moves when it is not where the tracer built for it: then a hierarchy of the geometry that rests answers for
// it. Tracers that do not build for lights answer for all of them. Whatever they say, geometry that moves is asked too.
struct PosedScene {
  scenes::SceneTime time{};
  scenes::WorldMesh mesh;           // of what moves
  Bvh bvh;                          // over it, where anything is traced
  std::vector<ClusterGroup> draws;  // its triangles by pipeline state; without chunks
  std::vector<exact::TracedLight> lights;
  std::vector<exact::TracedLight> resting_lights;         // the same, but those that move reach nothing
  std::array<uint32_t, kMaxLights / 32> moving_lights{};  // a bit for each light
  std::shared_ptr<const TracedScene> traced;              // null: the scene is only looked at
  std::shared_ptr<const TracedScene> static_bvh;          // of what rests; null: no light moves

  bool any_light_moves() const {
    return std::any_of(moving_lights.begin(), moving_lights.end(), [](uint32_t bits) { return bits != 0; });
  }
  bool at_rest() const { return mesh.triangles.empty() && !any_light_moves(); }
};

using PosedScenePtr = std::shared_ptr<const PosedScene>;

// One that reaches no surface: its bits are 0 whatever is asked, and a tracer builds next to nothing for it.
exact::TracedLight silenced_light(const scenes::Bounds& bounds);

bool same_light(const exact::TracedLight& a, const exact::TracedLight& b);

// Groups of `mesh`, in the order of its triangles.
std::vector<ClusterGroup> draws_of(const scenes::Scene& scene, const scenes::WorldMesh& mesh);

}  // namespace gnomon::gpu
