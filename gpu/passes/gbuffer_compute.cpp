// Rasterises the world mesh into triangle ids by compute shaders only, for devices that have few graphics units beside
// their compute units. Clusters that may show become runs of triangles; each small triangle is drawn by one invocation,
// large ones are divided into blocks of pixels (shaders/raster.glsl names the sources of the method).
#include <algorithm>
#include <array>

#include "gpu/passes/passes.h"
#include "spirv/cull_runs_comp.h"
#include "spirv/divide_large_comp.h"
#include "spirv/raster_blocks_comp.h"
#include "spirv/raster_large_comp.h"
#include "spirv/raster_runs_comp.h"
#include "spirv/resolve_comp.h"
#include "spirv/visibility_tiles_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/raster.glsl declares them: what precedes a list's entries, and an entry of each list.
constexpr uint64_t kHead = 48;        // the longest
constexpr uint64_t kDividingAt = 16;  // of LargeList's second command
constexpr uint64_t kRunBytes = 8, kTriangleBytes = 4, kPreparedBytes = 104 + 4, kMostDivided = 32768;
constexpr int kBlocksOfCount = 40, kPlaceBits = 17;
constexpr uint64_t kBlockBytes = 4;
constexpr uint32_t kRunTriangles = 64, kTilesAtATime = 8;
constexpr uint32_t kMostWorkgroups = 65535;  // of a dispatch that every device allows
constexpr uint32_t kDoubleSided = 0x80000000u, kMasked = 0x40000000u;
// Blocks of divided triangles: how often, on average, each tile of the picture may be covered.
constexpr uint32_t kDividedLayers = 48;

struct CullPush {
  VkDeviceAddress clusters, chunks, depth_tiles, runs;
  uint32_t first_chunk;
};
struct RunsPush {
  VkDeviceAddress visibility, large, runs, depth_tiles;
  uint32_t first, count, marks, most_blocks;
};

uint64_t depth_tiles_bytes(const Capacity& c) { return uint64_t{c.grid().tile_count()} * sizeof(float); }
uint64_t visibility_bytes(const Capacity& c) { return uint64_t{c.grid().tile_count()} * kTileSize * kTileSize * 8; }
// An upper bound: each cluster, which becomes a run, has at least one triangle.
uint64_t runs_bytes(const Capacity& c) { return kHead + kRunBytes * c.triangles; }
uint64_t all_triangles(const Capacity& c) { return uint64_t{c.triangles} + c.moving_triangles; }
uint64_t large_bytes(const Capacity& c) {
  return kHead + kPreparedBytes * kMostDivided + kTriangleBytes * all_triangles(c);
}
// Of pictures with more tiles than an entry of BlockList can number, nothing is divided.
constexpr uint32_t kMostTiles = 1u << kPlaceBits;
uint64_t blocks_bytes(const Capacity& c) {
  return kHead + kBlockBytes * kDividedLayers * std::min(c.grid().tile_count(), kMostTiles);
}

// None, too, if the numbers of all triangles and their blocks might not fit into LargeList::divided.
uint32_t most_divided_blocks(const Capacity& c) {
  const uint64_t triangles = all_triangles(c), tiles = c.grid().tile_count();
  const bool fit =
      tiles <= kMostTiles && triangles >> (64 - kBlocksOfCount) == 0 && (triangles * tiles) >> kBlocksOfCount == 0;
  return fit ? static_cast<uint32_t>(kDividedLayers * tiles) : 0;
}

std::span<const std::byte> bytes_of(const auto& push) { return std::as_bytes(std::span(&push, 1)); }

void dispatch_indirect(const FrameContext& frame, const Buffer& list, uint64_t command_at = 0) {
  vkCmdDispatchIndirect(frame.commands, list.handle(), command_at);
}

// Dispatches a pass over the whole picture. Workgroups take turns, so that any number of them processes all tiles.
void dispatch_picture(const FrameContext& frame, const ComputeStep& step, std::span<const std::byte> push) {
  bind(frame, step, push);
  const uint32_t workgroups = (frame.grid.tile_count() + kTilesAtATime - 1) / kTilesAtATime;
  vkCmdDispatch(frame.commands, std::min(workgroups, kMostWorkgroups), 1, 1);
}

// Clears the picture, empties every list, and has nothing hidden yet.
class ClearPass : public Pass {
 public:
  std::string_view name() const override { return "clear"; }
  const PassLayout* layout() const override { return nullptr; }
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::fill_target, {{}, visibility_bytes}},
            {resource::kDepthTiles, Use::fill_target, {{}, depth_tiles_bytes}},
            {resource::kOccluderRuns, Use::fill_target, {{}, runs_bytes}},
            {resource::kOccluderLarge, Use::fill_target, {{}, large_bytes}},
            {resource::kOccluderBlocks, Use::fill_target, {{}, blocks_bytes}},
            {resource::kRuns, Use::fill_target, {{}, runs_bytes}},
            {resource::kLarge, Use::fill_target, {{}, large_bytes}},
            {resource::kBlocks, Use::fill_target, {{}, blocks_bytes}}};
  }
  void record(const FrameContext& frame) const override {
    std::array<uint64_t, 8> bytes{visibility_bytes(frame.size()), depth_tiles_bytes(frame.size())};
    std::fill(bytes.begin() + 2, bytes.end(), kHead);
    for (size_t i = 0; i < bytes.size(); ++i)
      vkCmdFillBuffer(frame.commands, frame.ports[i].buffer->handle(), 0, bytes[i], 0);
  }
};

class ComputePass : public Pass {
 public:
  ComputePass(std::string_view name, ComputeStep step) : step_(std::move(step)), name_(name) {}
  std::string_view name() const override { return name_; }
  const PassLayout* layout() const override { return &step_.layout; }

 protected:
  // One workgroup for each chunk of the groups.
  void cull(const FrameContext& frame, std::span<const scenes::ClusterGroup> groups, VkDeviceAddress depth_tiles,
            const Buffer& runs) const {
    const uint32_t first = groups.front().first_chunk;
    const uint32_t end = groups.back().first_chunk + groups.back().chunk_count;
    if (first == end) return;
    const CullPush push{frame.scene.buffers().clusters.address(), frame.scene.buffers().cluster_chunks.address(),
                        depth_tiles, runs.address(), first};
    bind(frame, step_, bytes_of(push));
    vkCmdDispatch(frame.commands, end - first, 1, 1);
  }

  ComputeStep step_;

 private:
  std::string_view name_;
};

class CullRunsPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::vector<Port> ports() const override { return {{resource::kOccluderRuns, Use::storage_update}}; }
  void record(const FrameContext& frame) const override {
    cull(frame, frame.scene.clusters().occluders, 0, *frame.ports[0].buffer);
  }
};

class CullHiddenRunsPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::vector<Port> ports() const override {
    return {{resource::kDepthTiles, Use::storage_read}, {resource::kRuns, Use::storage_update}};
  }
  void record(const FrameContext& frame) const override {
    cull(frame, frame.scene.clusters().others, frame.ports[0].buffer->address(), *frame.ports[1].buffer);
  }
};

class OccluderRunsPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_update},
            {resource::kOccluderLarge, Use::storage_update},
            {resource::kOccluderRuns, Use::indirect_read}};
  }
  void record(const FrameContext& frame) const override {
    const Buffer& runs = *frame.ports[2].buffer;
    const RunsPush push{
        frame.ports[0].buffer->address(), frame.ports[1].buffer->address(), runs.address(), 0, 0, 0, 0,
        most_divided_blocks(frame.size())};
    bind(frame, step_, bytes_of(push));
    dispatch_indirect(frame, runs);
  }
};

// Draws the runs of the other triangles, and the moving triangles, which have no clusters.
class TriangleRunsPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_update},
            {resource::kLarge, Use::storage_update},
            {resource::kRuns, Use::indirect_read},
            {resource::kDepthTiles, Use::storage_read}};
  }
  void record(const FrameContext& frame) const override {
    const Buffer& runs = *frame.ports[2].buffer;
    RunsPush push{frame.ports[0].buffer->address(),
                  frame.ports[1].buffer->address(),
                  runs.address(),
                  frame.ports[3].buffer->address(),
                  0,
                  0,
                  0,
                  most_divided_blocks(frame.size())};
    bind(frame, step_, bytes_of(push));
    dispatch_indirect(frame, runs);
    push.runs = 0;
    for (const scenes::ClusterGroup& group : frame.posed.draws) {
      if (group.triangle_count == 0) continue;
      push.first = frame.scene.moving_place(frame.slot).first_triangle + group.first_triangle;
      push.count = group.triangle_count;
      push.marks = (group.double_sided ? kDoubleSided : 0) | (group.masked ? kMasked : 0);
      bind(frame, step_, bytes_of(push));
      vkCmdDispatch(frame.commands, (push.count + kRunTriangles - 1) / kRunTriangles, 1, 1);
    }
  }
};

// Divides large triangles, and draws those that are not divided. Ports: the picture, both lists and the depth tiles.
class LargePass : public Pass {
 public:
  LargePass(std::string_view name, ComputeStep divide, ComputeStep draw)
      : divide_(std::move(divide)), draw_(std::move(draw)), name_(name) {}
  std::string_view name() const override { return name_; }
  const PassLayout* layout() const override { return &divide_.layout; }
  void record(const FrameContext& frame) const override {
    const Buffer& large = *frame.ports[1].buffer;
    const VkDeviceAddress depth_tiles = frame.ports[3].buffer->address();
    const std::array divide{large.address(), frame.ports[2].buffer->address(), depth_tiles};
    bind(frame, divide_, bytes_of(divide));
    dispatch_indirect(frame, large, kDividingAt);
    const std::array draw{frame.ports[0].buffer->address(), large.address(), depth_tiles};
    bind(frame, draw_, bytes_of(draw));
    dispatch_indirect(frame, large);
  }

 private:
  ComputeStep divide_, draw_;
  std::string_view name_;
};

class LargeOccludersPass : public LargePass {
 public:
  using LargePass::LargePass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_update},
            {resource::kOccluderLarge, Use::indirect_read},
            {resource::kOccluderBlocks, Use::storage_update},
            {resource::kDepthTiles, Use::storage_update}};
  }
};

class LargeTrianglesPass : public LargePass {
 public:
  using LargePass::LargePass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_update},
            {resource::kLarge, Use::indirect_read},
            {resource::kBlocks, Use::storage_update},
            {resource::kDepthTiles, Use::storage_update}};
  }
};

// Ports: as of LargePass.
class BlocksPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  void record(const FrameContext& frame) const override {
    std::array<VkDeviceAddress, 4> push{};
    for (size_t i = 0; i < push.size(); ++i) push[i] = frame.ports[i].buffer->address();
    bind(frame, step_, bytes_of(push));
    dispatch_indirect(frame, *frame.ports[2].buffer);
  }
};

class OccluderBlocksPass : public BlocksPass {
 public:
  using BlocksPass::BlocksPass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_update},
            {resource::kOccluderLarge, Use::storage_read},
            {resource::kOccluderBlocks, Use::indirect_read},
            {resource::kDepthTiles, Use::storage_read}};
  }
};

class TriangleBlocksPass : public BlocksPass {
 public:
  using BlocksPass::BlocksPass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_update},
            {resource::kLarge, Use::storage_read},
            {resource::kBlocks, Use::indirect_read},
            {resource::kDepthTiles, Use::storage_read}};
  }
};

class VisibilityTilesPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_read}, {resource::kDepthTiles, Use::storage_write}};
  }
  void record(const FrameContext& frame) const override {
    const std::array push{frame.ports[0].buffer->address(), frame.ports[1].buffer->address()};
    dispatch_picture(frame, step_, bytes_of(push));
  }
};

class ResolvePass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::vector<Port> ports() const override {
    return {{resource::kVisibility, Use::storage_read},
            {resource::kTriangleId, Use::storage_write, {VK_FORMAT_R32_UINT, {}}}};
  }
  void record(const FrameContext& frame) const override {
    const VkDeviceAddress visibility = frame.ports[0].buffer->address();
    dispatch_picture(frame, step_, bytes_of(visibility));
  }
};

Result<ComputeStep> make_step(const DevicePtr& device, std::span<const uint32_t> shader,
                              uint32_t storage_images = 0) {
  if (!device->features().atomic_int64)
    return Error{"rasterising in compute needs 64-bit atomics, which device '" + device->info().name + "' lacks"};
  return make_compute_step(device, 0, shader, storage_images);
}

template <class Made>
Result<std::unique_ptr<Pass>> make(std::string_view name, const DevicePtr& device, std::span<const uint32_t> shader,
                                   uint32_t storage_images = 0) {
  auto step = make_step(device, shader, storage_images);
  if (!step) return step.error();
  return std::unique_ptr<Pass>(std::make_unique<Made>(name, std::move(*step)));
}

template <class Made>
Result<std::unique_ptr<Pass>> make_large(std::string_view name, const DevicePtr& device) {
  auto divide = make_step(device, divide_large_comp);
  if (!divide) return divide.error();
  auto draw = make_step(device, raster_large_comp);
  if (!draw) return draw.error();
  return std::unique_ptr<Pass>(std::make_unique<Made>(name, std::move(*divide), std::move(*draw)));
}

}  // namespace

Result<std::unique_ptr<Pass>> make_clear_visibility_pass(const DevicePtr&) {
  return std::unique_ptr<Pass>(std::make_unique<ClearPass>());
}
Result<std::unique_ptr<Pass>> make_cull_runs_pass(const DevicePtr& device) {
  return make<CullRunsPass>("cull", device, cull_runs_comp);
}
Result<std::unique_ptr<Pass>> make_cull_hidden_runs_pass(const DevicePtr& device) {
  return make<CullHiddenRunsPass>("cull_hidden", device, cull_runs_comp);
}
Result<std::unique_ptr<Pass>> make_occluder_runs_pass(const DevicePtr& device) {
  return make<OccluderRunsPass>("occluders", device, raster_runs_comp);
}
Result<std::unique_ptr<Pass>> make_large_occluders_pass(const DevicePtr& device) {
  return make_large<LargeOccludersPass>("occluders_large", device);
}
Result<std::unique_ptr<Pass>> make_occluder_blocks_pass(const DevicePtr& device) {
  return make<OccluderBlocksPass>("occluder_blocks", device, raster_blocks_comp);
}
Result<std::unique_ptr<Pass>> make_visibility_tiles_pass(const DevicePtr& device) {
  return make<VisibilityTilesPass>("depth_tiles", device, visibility_tiles_comp);
}
Result<std::unique_ptr<Pass>> make_triangle_runs_pass(const DevicePtr& device) {
  return make<TriangleRunsPass>("triangles", device, raster_runs_comp);
}
Result<std::unique_ptr<Pass>> make_large_triangles_pass(const DevicePtr& device) {
  return make_large<LargeTrianglesPass>("large", device);
}
Result<std::unique_ptr<Pass>> make_blocks_pass(const DevicePtr& device) {
  return make<TriangleBlocksPass>("blocks", device, raster_blocks_comp);
}
Result<std::unique_ptr<Pass>> make_resolve_pass(const DevicePtr& device) {
  return make<ResolvePass>("resolve", device, resolve_comp, 1);
}

}  // namespace gnomon::gpu
