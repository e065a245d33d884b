// Rasterises the world mesh into triangle ids.
#include <array>

#include "gpu/passes/passes.h"
#include "spirv/gbuffer_masked_frag.h"
#include "spirv/gbuffer_masked_vert.h"
#include "spirv/gbuffer_opaque_frag.h"
#include "spirv/gbuffer_opaque_vert.h"

namespace gnomon::gpu {
namespace {

constexpr VkFormat kIdFormat = VK_FORMAT_R32_UINT;
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

struct Raster {
  PassLayout layout;
  Pipeline opaque, masked;
};

Result<Raster> make_raster(const DevicePtr& device) {
  auto layout = make_pass_layout(device, 0);
  if (!layout) return layout.error();
  auto opaque =
      make_raster_pipeline(device, *layout, {gbuffer_opaque_vert, gbuffer_opaque_frag, {kIdFormat}, kDepthFormat});
  if (!opaque) return opaque.error();
  auto masked =
      make_raster_pipeline(device, *layout, {gbuffer_masked_vert, gbuffer_masked_frag, {kIdFormat}, kDepthFormat});
  if (!masked) return masked.error();
  return Raster{std::move(*layout), std::move(*opaque), std::move(*masked)};
}

// Ports 0 and 1: triangle ids and depth.
void begin_rendering(const FrameContext& frame, VkAttachmentLoadOp load, VkAttachmentStoreOp store_depth) {
  VkRenderingAttachmentInfo id{};
  id.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
  id.imageView = frame.ports[0].image->view();
  id.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  id.loadOp = load;
  id.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  VkRenderingAttachmentInfo depth = id;
  depth.imageView = frame.ports[1].image->view();
  depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  depth.storeOp = store_depth;
  VkRenderingInfo rendering{};
  rendering.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
  rendering.renderArea.extent = {frame.grid.width, frame.grid.height};
  rendering.layerCount = 1;
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachments = &id;
  rendering.pDepthAttachment = &depth;
  vkCmdBeginRendering(frame.commands, &rendering);
}

// `drawn`: address of the numbers of the triangles drawn, 0: all of them.
void bind(const FrameContext& frame, const Raster& raster, VkDeviceAddress drawn) {
  const VkExtent2D size{frame.grid.width, frame.grid.height};
  const VkViewport viewport{0, 0, static_cast<float>(size.width), static_cast<float>(size.height), 0, 1};
  const VkRect2D scissor{{0, 0}, size};
  vkCmdSetViewport(frame.commands, 0, 1, &viewport);
  vkCmdSetScissor(frame.commands, 0, 1, &scissor);
  vkCmdBindDescriptorSets(frame.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, raster.layout.pipeline.get(), 0, 1,
                          &frame.descriptors, 0, nullptr);
  push_constants(frame.commands, raster.layout.pipeline.get(), std::as_bytes(std::span(&drawn, 1)));
}

// `draw` records the draws of one group, its state set.
template <class Draw>
void draw_groups(const FrameContext& frame, const Raster& raster, std::span<const scenes::ClusterGroup> groups,
                 Draw draw) {
  for (const scenes::ClusterGroup& group : groups) {
    if (group.triangle_count == 0) continue;
    vkCmdBindPipeline(frame.commands, VK_PIPELINE_BIND_POINT_GRAPHICS,
                      group.masked ? raster.masked.get() : raster.opaque.get());
    vkCmdSetCullMode(frame.commands, group.double_sided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
    draw(group);
  }
}

void draw_all(const FrameContext& frame, const Raster& raster, std::span<const scenes::ClusterGroup> groups) {
  draw_groups(frame, raster, groups, [&](const scenes::ClusterGroup& group) {
    vkCmdDraw(frame.commands, 3 * group.triangle_count, 1, 3 * group.first_triangle, 0);
  });
}

void draw_culled(const FrameContext& frame, const Raster& raster, std::span<const scenes::ClusterGroup> groups,
                 const Buffer& draws) {
  constexpr uint32_t stride = sizeof(VkDrawIndirectCommand);
  draw_groups(frame, raster, groups, [&](const scenes::ClusterGroup& group) {
    vkCmdDrawIndirect(frame.commands, draws.handle(), uint64_t{stride} * group.first_chunk, group.chunk_count,
                      stride);
  });
}

// Draws the moving geometry, after all resting geometry.
void draw_moving(const FrameContext& frame, const Raster& raster) {
  if (frame.posed.draws.empty()) return;
  bind(frame, raster, 0);
  const uint32_t first = frame.scene.moving_place(frame.slot).first_triangle;
  draw_groups(frame, raster, frame.posed.draws, [&](const scenes::ClusterGroup& group) {
    vkCmdDraw(frame.commands, 3 * group.triangle_count, 1, 3 * (first + group.first_triangle), 0);
  });
}

class RasterPass : public Pass {
 public:
  explicit RasterPass(Raster raster) : raster_(std::move(raster)) {}
  const PassLayout* layout() const override { return &raster_.layout; }

 protected:
  static std::vector<Port> targets() {
    return {{resource::kTriangleId, Use::color_target, {kIdFormat, {}}},
            {resource::kDepth, Use::depth_target, {kDepthFormat, {}}}};
  }
  static std::vector<Port> targets_and(std::string_view draws, std::string_view drawn) {
    std::vector<Port> ports = targets();
    ports.push_back({draws, Use::indirect});
    ports.push_back({drawn, Use::vertex_read});
    return ports;
  }
  // Ports 2 and 3: the draws and the triangles that they name.
  void record_culled(const FrameContext& frame, std::span<const scenes::ClusterGroup> groups) const {
    bind(frame, raster_, frame.ports[3].buffer->address());
    draw_culled(frame, raster_, groups, *frame.ports[2].buffer);
  }

  Raster raster_;
};

// Draws the large triangles, whose depth then hides others.
class OccludersPass : public RasterPass {
 public:
  using RasterPass::RasterPass;
  std::string_view name() const override { return "occluders"; }
  std::vector<Port> ports() const override {
    return targets_and(resource::kOccluderDraws, resource::kDrawnOccluders);
  }
  void record(const FrameContext& frame) const override {
    begin_rendering(frame, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE);
    record_culled(frame, frame.scene.clusters().occluders);
    vkCmdEndRendering(frame.commands);
  }
};

// Draws the other triangles, over the occluders.
class GBufferPass : public RasterPass {
 public:
  using RasterPass::RasterPass;
  std::string_view name() const override { return "gbuffer"; }
  std::vector<Port> ports() const override { return targets_and(resource::kDraws, resource::kDrawn); }
  void record(const FrameContext& frame) const override {
    begin_rendering(frame, VK_ATTACHMENT_LOAD_OP_LOAD, VK_ATTACHMENT_STORE_OP_DONT_CARE);
    record_culled(frame, frame.scene.clusters().others);
    draw_moving(frame, raster_);
    vkCmdEndRendering(frame.commands);
  }
};

class GBufferAllPass : public RasterPass {
 public:
  using RasterPass::RasterPass;
  std::string_view name() const override { return "gbuffer_all"; }
  std::vector<Port> ports() const override { return targets(); }
  void record(const FrameContext& frame) const override {
    begin_rendering(frame, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_DONT_CARE);
    bind(frame, raster_, 0);
    draw_all(frame, raster_, frame.scene.clusters().occluders);
    draw_all(frame, raster_, frame.scene.clusters().others);
    draw_moving(frame, raster_);
    vkCmdEndRendering(frame.commands);
  }
};

template <class Made>
Result<std::unique_ptr<Pass>> make(const DevicePtr& device) {
  auto raster = make_raster(device);
  if (!raster) return raster.error();
  return std::unique_ptr<Pass>(std::make_unique<Made>(std::move(*raster)));
}

}  // namespace

Result<std::unique_ptr<Pass>> make_occluders_pass(const DevicePtr& device) { return make<OccludersPass>(device); }
Result<std::unique_ptr<Pass>> make_gbuffer_pass(const DevicePtr& device) { return make<GBufferPass>(device); }
Result<std::unique_ptr<Pass>> make_gbuffer_all_pass(const DevicePtr& device) {
  return make<GBufferAllPass>(device);
}

}  // namespace gnomon::gpu
