// A scene on the device: its world mesh, materials and lights, and what a tracer built from it.
//
// Resting geometry is uploaded once. Moving geometry has a place behind it in the same buffers for each frame in
// flight, into which each frame copies its pose, so that one numbering covers all triangles.
#pragma once

#include <memory>
#include <vector>

#include "gpu/scene/area_lights.h"
#include "gpu/scene/frame_uniforms.h"
#include "gpu/scene/posed_scene.h"
#include "gpu/scene/traced_lights.h"
#include "gpu/tracers/tracer.h"
#include "gpu/vulkan/texels.h"
#include "scenes/geometry/geometry.h"

namespace gnomon::gpu {

// What a scene waits for before it is resident.
enum class Built {
  everything,    // the tracer's complete build
  what_is_quick  // short builds only; instead of a long one, a hierarchy is traced for all lights until give_traced
};

// Lights as they are traced: to their middles, or to points all over them.
enum class Shadows { hard, soft };

// The buffers of a scene that shaders read.
struct SceneBuffers {
  Buffer positions, normals, uvs;  // of each vertex
  Buffer triangles, triangle_materials, materials;
  Buffer clusters, cluster_chunks;  // Cluster and ClusterChunk, of the resting geometry
  Buffer corners;                   // three vec4 for each resting triangle; only where they are loaded as texels
  std::vector<Buffer> textures;
};

// The start of a slot's moving geometry in the scene's buffers.
struct MovingPlace {
  uint32_t first_vertex = 0, first_triangle = 0;
};

class ResidentScene {
 public:
  // Blocking; any thread. `tracer` is null for a scene that is only drawn. `slots`: number of frames in flight. Error:
  // out of memory, device lost, or more lights than kMaxLights.
  static Result<std::unique_ptr<ResidentScene>> create(const DevicePtr& device, const scenes::ScenePtr& scene,
                                                       const Tracer* tracer, uint32_t slots = 1,
                                                       Built built = Built::everything);

  const scenes::Scene& scene() const { return *scene_; }
  const scenes::ScenePtr& scene_ptr() const { return scene_; }
  uint32_t triangle_count() const { return triangle_count_; }
  uint32_t light_count() const { return static_cast<uint32_t>(scene_->lights.size()); }
  const AreaLights& area_lights() const { return area_lights_; }
  const SceneBuffers& buffers() const { return buffers_; }
  // The corners, for passes that trace; VK_NULL_HANDLE where the device loads no texels.
  VkDescriptorSet texels() const { return texels_.handle(); }
  const scenes::Clusters& clusters() const { return geometry_->clusters; }
  const TracedScene& traced() const { return *traced_.traced; }  // precondition: made with a tracer
  uint64_t memory_bytes() const;                                 // on the device, the tracer's included

  // The place of the moving geometry of a slot's frames, and its largest size.
  MovingPlace moving_place(uint32_t slot) const {
    return {vertex_count_ + slot * moving_size_.vertices, triangle_count_ + slot * moving_size_.triangles};
  }
  const scenes::MovingMeshSize& moving_size() const { return moving_size_; }

  // The scene posed at that time. The object is reused while neither the time, the lights nor the tracer's structures
  // change. Precondition: the time is within the scene's period.
  PosedScenePtr pose(scenes::SceneTime time) const;

  // Replaces the lights for later frames by as many others; lights that animations move keep moving with them. Error:
  // another number of lights.
  Result<void> set_lights(std::vector<scenes::Light> lights);
  const std::vector<scenes::Light>& lights() const { return lights_; }

  // Later frames use `traced` for the lights that are where it was built for: hard frames, or soft ones for what
  // build_for_areas made.
  void give_traced(TracedLights traced, Shadows shadows = Shadows::hard);
  // Whether the scene was made without the tracer's build, and give_traced() has not been called yet.
  bool unbuilt() const { return unbuilt_; }

  LightState light_state() const;

  // Sets the members that depend on the scene: addresses and lights.
  void describe(FrameUniforms& frame, const PosedScene& posed) const;

 private:
  Result<void> upload_mesh(const DevicePtr& device, const scenes::WorldMesh& mesh, uint32_t slots);
  Result<void> upload_corners(const DevicePtr& device, const scenes::WorldMesh& mesh);
  Result<void> build_traced(const Tracer& tracer, const scenes::WorldMesh& mesh, Built built);
  Result<void> upload_clusters(const DevicePtr& device);
  // `drawn`: textures get the levels that shading filters through.
  Result<void> upload_materials(const DevicePtr& device, bool drawn);

  scenes::ScenePtr scene_;
  uint32_t vertex_count_ = 0, triangle_count_ = 0;  // of the resting geometry
  scenes::MovingMeshSize moving_size_;
  scenes::GeometryPtr geometry_;
  std::vector<scenes::Light> lights_;
  AreaLights area_lights_;
  bool built_for_lights_ = false;
  bool unbuilt_ = false;
  SceneBuffers buffers_;
  TexelSet texels_;
  TracedLights traced_;
  // Of the resting geometry: for lights that are not where the tracer built for them, the points of area lights, and the
  // occlusion of ambient light. May be traced_.traced itself.
  std::shared_ptr<const TracedScene> static_bvh_;
  mutable MovingBvh moving_bvh_;
  mutable PosedScenePtr posed_;  // the last result of pose()
};

// Builds what `tracer`, which builds for lights, needs for a scene with these lights. Blocking; any thread. Error: out
// of memory, device lost, stopped.
Result<TracedLights> build_for_lights(const Tracer& tracer, const scenes::Scene& scene,
                                      const std::vector<scenes::Light>& lights, const BuildWatch& watch = {});
// As build_for_lights, for the extents of the area lights alone. Precondition: the tracer has a soft_shader().
Result<TracedLights> build_for_areas(const Tracer& tracer, const scenes::Scene& scene,
                                     const std::vector<scenes::Light>& lights, const BuildWatch& watch = {});

// The light as tracers use it. The `reach` of a directional light is twice the scene's diagonal.
exact::TracedLight traced_light(const scenes::Light& light, const scenes::Bounds& bounds);

}  // namespace gnomon::gpu
