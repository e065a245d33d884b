// Selects the triangles that a frame draws, by occlusion culling in two passes: the first draws the large triangles
// (the occluders), the second all others that the depth of the occluders does not hide. Other than in the usual form of
// the technique (Haar and Aaltonen, "GPU-Driven Rendering Pipelines", SIGGRAPH 2015 course), the occluders do not come
// from the previous frame, so that frames are independent. Culling is conservative and draws keep their order: the
// picture equals that of drawing everything, bit for bit.
#include "gpu/passes/passes.h"
#include "spirv/cull_comp.h"
#include "spirv/depth_tiles_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/cull.comp declares it.
struct Push {
  VkDeviceAddress clusters;
  VkDeviceAddress chunks;
  VkDeviceAddress depth_tiles;
  VkDeviceAddress draws;
  VkDeviceAddress drawn;
  uint32_t first_chunk;
};

uint64_t draws_bytes(const Capacity& c) { return uint64_t{c.cluster_chunks} * sizeof(VkDrawIndirectCommand); }
uint64_t drawn_bytes(const Capacity& c) { return uint64_t{c.triangles} * sizeof(uint32_t); }

// Dispatches one workgroup for each chunk of the groups.
void cull(const FrameContext& frame, const ComputeStep& step, std::span<const scenes::ClusterGroup> groups,
          VkDeviceAddress depth_tiles, const Buffer& draws, const Buffer& drawn) {
  const uint32_t first = groups.front().first_chunk;
  const uint32_t end = groups.back().first_chunk + groups.back().chunk_count;
  if (first == end) return;
  const ResidentScene& scene = frame.scene;
  const Push push{scene.buffers().clusters.address(),
                  scene.buffers().cluster_chunks.address(),
                  depth_tiles,
                  draws.address(),
                  drawn.address(),
                  first};
  bind(frame, step, std::as_bytes(std::span(&push, 1)));
  vkCmdDispatch(frame.commands, end - first, 1, 1);
}

// Culls the occluders, without an occlusion test.
class CullPass : public Pass {
 public:
  explicit CullPass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "cull"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    return {{resource::kOccluderDraws, Use::storage_write, {{}, draws_bytes}},
            {resource::kDrawnOccluders, Use::storage_write, {{}, drawn_bytes}}};
  }
  void record(const FrameContext& frame) const override {
    cull(frame, step_, frame.scene.clusters().occluders, 0, *frame.ports[0].buffer, *frame.ports[1].buffer);
  }

 private:
  ComputeStep step_;
};

class DepthTilesPass : public Pass {
 public:
  explicit DepthTilesPass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "depth_tiles"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto bytes = [](const Capacity& c) { return uint64_t{c.grid().tile_count()} * sizeof(float); };
    return {{resource::kDepth, Use::sampled}, {resource::kDepthTiles, Use::storage_write, {{}, bytes}}};
  }
  void record(const FrameContext& frame) const override {
    const VkDeviceAddress tiles = frame.ports[1].buffer->address();
    bind(frame, step_, std::as_bytes(std::span(&tiles, 1)));
    vkCmdDispatch(frame.commands, (frame.grid.tile_count() + 63) / 64, 1, 1);
  }

 private:
  ComputeStep step_;
};

// Culls all other triangles, also by the depth of the occluders.
class CullHiddenPass : public Pass {
 public:
  explicit CullHiddenPass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "cull_hidden"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    return {{resource::kDepthTiles, Use::storage_read},
            {resource::kDraws, Use::storage_write, {{}, draws_bytes}},
            {resource::kDrawn, Use::storage_write, {{}, drawn_bytes}}};
  }
  void record(const FrameContext& frame) const override {
    cull(frame, step_, frame.scene.clusters().others, frame.ports[0].buffer->address(), *frame.ports[1].buffer,
         *frame.ports[2].buffer);
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_cull_pass(const DevicePtr& device) {
  return pass_of<CullPass>(make_compute_step(device, 0, cull_comp));
}
Result<std::unique_ptr<Pass>> make_depth_tiles_pass(const DevicePtr& device) {
  return pass_of<DepthTilesPass>(make_compute_step(device, 1, depth_tiles_comp));
}
Result<std::unique_ptr<Pass>> make_cull_hidden_pass(const DevicePtr& device) {
  return pass_of<CullHiddenPass>(make_compute_step(device, 0, cull_comp));
}

}  // namespace gnomon::gpu
