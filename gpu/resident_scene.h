// A scene on the device: its world mesh, materials and lights, and what a tracer built from it.
#pragma once

#include <memory>
#include <vector>

#include "gpu/clusters.h"
#include "gpu/frame_uniforms.h"
#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {

class ResidentScene {
 public:
  // Blocking. `tracer` is null for a scene that is only looked at. Error: out of memory, device lost, or more lights
  // than kMaxLights.
  static Result<std::unique_ptr<ResidentScene>> create(const DevicePtr& device, const scenes::ScenePtr& scene,
                                                       const Tracer* tracer);

  const scenes::Scene& scene() const { return *scene_; }
  uint32_t triangle_count() const { return triangle_count_; }
  uint32_t light_count() const { return static_cast<uint32_t>(lights_.size()); }
  const Buffer& positions() const { return positions_; }
  const Buffer& uvs() const { return uvs_; }
  const Buffer& triangles() const { return triangles_; }
  const Clusters& clusters() const { return clusters_; }
  const Buffer& cluster_buffer() const { return cluster_buffer_; }  // Cluster for each
  const Buffer& chunk_buffer() const { return chunk_buffer_; }      // ClusterChunk for each
  const TracedScene& traced() const { return *traced_; }            // precondition: made with a tracer
  uint64_t memory_bytes() const;                                    // on the device, the tracer's included

  // Fills the scene's part: addresses and lights.
  void describe(FrameUniforms& frame) const;

 private:
  Result<void> upload_mesh(const DevicePtr& device, const scenes::WorldMesh& mesh);
  Result<void> upload_clusters(const DevicePtr& device);
  Result<void> upload_materials(const DevicePtr& device);

  scenes::ScenePtr scene_;
  uint32_t triangle_count_ = 0;
  Clusters clusters_;
  std::vector<exact::TracedLight> lights_;
  Buffer positions_, normals_, uvs_, triangles_, triangle_materials_, materials_, cluster_buffer_, chunk_buffer_;
  std::vector<Buffer> textures_;
  std::unique_ptr<TracedScene> traced_;
};

// `reach` of a directional light is the scene's diagonal, twice.
exact::TracedLight traced_light(const scenes::Light& light, const scenes::Bounds& bounds);

}  // namespace gnomon::gpu
