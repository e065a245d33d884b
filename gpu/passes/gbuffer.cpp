// Rasterises the world mesh into triangle ids. A draw names its first triangle through firstInstance, so that any
// range of triangles, indirect ranges later, can be a draw of its own.
#include <array>

#include "gpu/passes/passes.h"
#include "spirv/gbuffer_masked_frag.h"
#include "spirv/gbuffer_opaque_frag.h"
#include "spirv/gbuffer_vert.h"

namespace gnomon::gpu {
namespace {

constexpr VkFormat kIdFormat = VK_FORMAT_R32_UINT;
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

class GBufferPass : public Pass {
 public:
  GBufferPass(PassLayout layout, Pipeline opaque, Pipeline masked)
      : layout_(std::move(layout)), opaque_(std::move(opaque)), masked_(std::move(masked)) {}

  std::string_view name() const override { return "gbuffer"; }
  const PassLayout* layout() const override { return &layout_; }
  std::vector<Port> ports() const override {
    return {{resource::kTriangleId, Use::color_target, {kIdFormat, {}}},
            {resource::kDepth, Use::depth_target, {kDepthFormat, {}}}};
  }

  void record(const FrameContext& frame) const override {
    const VkExtent2D size{frame.grid.width, frame.grid.height};
    begin(frame, size);
    const VkViewport viewport{0, 0, static_cast<float>(size.width), static_cast<float>(size.height), 0, 1};
    const VkRect2D scissor{{0, 0}, size};
    vkCmdSetViewport(frame.commands, 0, 1, &viewport);
    vkCmdSetScissor(frame.commands, 0, 1, &scissor);
    vkCmdBindDescriptorSets(frame.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.pipeline.get(), 0, 1,
                            &frame.descriptors, 0, nullptr);
    const std::array streams{frame.scene.positions().handle(), frame.scene.uvs().handle()};
    const std::array<VkDeviceSize, 2> offsets{};
    vkCmdBindVertexBuffers(frame.commands, 0, streams.size(), streams.data(), offsets.data());
    vkCmdBindIndexBuffer(frame.commands, frame.scene.triangles().handle(), 0, VK_INDEX_TYPE_UINT32);
    const uint32_t opaque = frame.scene.opaque_count();
    draw(frame, opaque_, 0, opaque);
    draw(frame, masked_, opaque, frame.scene.triangle_count() - opaque);
    vkCmdEndRendering(frame.commands);
  }

 private:
  static void begin(const FrameContext& frame, VkExtent2D size) {
    VkRenderingAttachmentInfo id{};
    id.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
    id.imageView = frame.ports[0].image->view();
    id.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    id.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    id.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingAttachmentInfo depth = id;
    depth.imageView = frame.ports[1].image->view();
    depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    depth.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    VkRenderingInfo rendering{};
    rendering.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
    rendering.renderArea.extent = size;
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &id;
    rendering.pDepthAttachment = &depth;
    vkCmdBeginRendering(frame.commands, &rendering);
  }

  static void draw(const FrameContext& frame, const Pipeline& pipeline, uint32_t first, uint32_t triangles) {
    if (triangles == 0) return;
    vkCmdBindPipeline(frame.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.get());
    vkCmdDrawIndexed(frame.commands, triangles * 3, 1, first * 3, 0, first);
  }

  PassLayout layout_;
  Pipeline opaque_, masked_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_gbuffer_pass(const DevicePtr& device) {
  auto layout = make_pass_layout(device, 0);
  if (!layout) return layout.error();
  RasterPipeline what;
  what.vertex_shader = gbuffer_vert;
  what.streams = {{VK_FORMAT_R32G32B32_SFLOAT, sizeof(glm::vec3)}, {VK_FORMAT_R32G32_SFLOAT, sizeof(glm::vec2)}};
  what.colors = {kIdFormat};
  what.depth = kDepthFormat;
  what.fragment_shader = gbuffer_opaque_frag;
  auto opaque = make_raster_pipeline(device, *layout, what);
  if (!opaque) return opaque.error();
  what.fragment_shader = gbuffer_masked_frag;
  auto masked = make_raster_pipeline(device, *layout, what);
  if (!masked) return masked.error();
  return std::unique_ptr<Pass>(
      std::make_unique<GBufferPass>(std::move(*layout), std::move(*opaque), std::move(*masked)));
}

}  // namespace gnomon::gpu
