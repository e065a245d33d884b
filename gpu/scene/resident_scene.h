// A scene on the device: its world mesh, materials and lights, and what a tracer built from it.
//
// What rests is uploaded once. What moves has a place behind it in the same buffers, one for each frame in flight: each
// frame copies it there, posed anew, and shaders find all triangles by one numbering.
#pragma once

#include <memory>
#include <vector>

#include "gpu/scene/clusters.h"
#include "gpu/scene/frame_uniforms.h"
#include "gpu/scene/posed_scene.h"
#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {

// What a tracer built, and for which lights.
struct TracedLights {
  std::shared_ptr<const TracedScene> traced;
  std::vector<exact::TracedLight> built_for;
};

// What a scene waits for before it is resident.
enum class Built {
  everything,    // what the tracer builds
  what_is_quick  // where that takes long, a hierarchy answers for all lights until give_traced
};

// What shaders read of a scene.
struct SceneBuffers {
  Buffer positions, normals, uvs;  // of each vertex
  Buffer triangles, triangle_materials, materials;
  Buffer clusters, cluster_chunks;  // Cluster and ClusterChunk, of what rests
  std::vector<Buffer> textures;
};

// Where what moves begins in the scene's buffers.
struct MovingPlace {
  uint32_t first_vertex = 0, first_triangle = 0;
};

class ResidentScene {
 public:
  // Blocking; any thread. `tracer` is null for a scene that is only looked at. `slots`: frames in flight. Error: out of
  // memory, device lost, or more lights than kMaxLights.
  static Result<std::unique_ptr<ResidentScene>> create(const DevicePtr& device, const scenes::ScenePtr& scene,
                                                       const Tracer* tracer, uint32_t slots = 1,
                                                       Built built = Built::everything);

  const scenes::Scene& scene() const { return *scene_; }
  const scenes::ScenePtr& scene_ptr() const { return scene_; }
  uint32_t triangle_count() const { return triangle_count_; }
  uint32_t light_count() const { return static_cast<uint32_t>(scene_->lights.size()); }
  const SceneBuffers& buffers() const { return buffers_; }
  const Clusters& clusters() const { return clusters_; }
  const TracedScene& traced() const { return *traced_.traced; }  // precondition: made with a tracer
  uint64_t memory_bytes() const;                                 // on the device, the tracer's included

  // Where a slot's frames keep what moves, and the most that it ever is.
  MovingPlace moving_place(uint32_t slot) const {
    return {vertex_count_ + slot * moving_size_.vertices, triangle_count_ + slot * moving_size_.triangles};
  }
  const scenes::MovingMeshSize& moving_size() const { return moving_size_; }

  // The scene at that time, which is within its period. The same again while neither time nor lights change.
  PosedScenePtr pose(scenes::SceneTime time) const;

  // The lights of frames from now on, as many as before; those that animations move stay with these. Error: the
  // tracer builds for lights, one has moved and nothing can answer for it: give a static_bvh first.
  Result<void> set_lights(std::vector<scenes::Light> lights);
  const std::vector<scenes::Light>& lights() const { return lights_; }
  bool needs_static_bvh(const std::vector<scenes::Light>& lights) const;
  void give_static_bvh(std::shared_ptr<const TracedScene> bvh) { static_bvh_ = std::move(bvh); }

  // From now on this answers for the lights that are where it was built for.
  void give_traced(TracedLights traced);
  // What the tracer builds was not there when the scene was made, and has not been given yet.
  bool unbuilt() const { return unbuilt_; }

  LightState light_state() const;

  // Fills the scene's part: addresses and lights.
  void describe(FrameUniforms& frame, const PosedScene& posed) const;

 private:
  Result<void> upload_mesh(const DevicePtr& device, const scenes::WorldMesh& mesh, uint32_t slots);
  Result<void> build_traced(const DevicePtr& device, const Tracer& tracer, const scenes::WorldMesh& mesh,
                            Built built);
  Result<void> upload_clusters(const DevicePtr& device);
  Result<void> upload_materials(const DevicePtr& device);

  scenes::ScenePtr scene_;
  uint32_t vertex_count_ = 0, triangle_count_ = 0;  // of what rests
  scenes::MovingMeshSize moving_size_;
  Clusters clusters_;
  std::vector<scenes::Light> lights_;
  bool built_for_lights_ = false;
  bool unbuilt_ = false;
  SceneBuffers buffers_;
  TracedLights traced_;
  std::shared_ptr<const TracedScene> static_bvh_;
  mutable PosedScenePtr posed_;  // the last one
};

// What `tracer`, which builds for lights, builds for a scene with these. Blocking; any thread. Error: out of memory,
// device lost, stopped.
Result<TracedLights> build_for_lights(const Tracer& tracer, const scenes::Scene& scene,
                                      const std::vector<scenes::Light>& lights, const BuildWatch& watch = {});
// A hierarchy of what rests in the scene. The same.
Result<std::shared_ptr<const TracedScene>> build_static_bvh(const DevicePtr& device, const scenes::Scene& scene);

// `reach` of a directional light is the scene's diagonal, twice.
exact::TracedLight traced_light(const scenes::Light& light, const scenes::Bounds& bounds);

}  // namespace gnomon::gpu
