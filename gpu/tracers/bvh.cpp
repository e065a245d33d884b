// Tracer "bvh": a bounding volume hierarchy in plain compute. Runs on every device.
#include "common/clock.h"
#include "gpu/tracers/tracer.h"
#include "gpu/vulkan/texels.h"
#include "spirv/trace_bvh_comp.h"
#include "spirv/trace_bvh_texels_comp.h"

namespace gnomon::gpu {
namespace {

// As shaders/trace_bvh.comp declares it, after the addresses of the masks and of valid_bits.
struct Push {
  VkDeviceAddress nodes = 0;
  VkDeviceAddress triangles = 0;
  uint32_t node_count = 0;
  uint32_t padding = 0;
};

class BvhScene : public TracedScene {
 public:
  // Error: out of memory.
  static Result<std::unique_ptr<TracedScene>> create(const DevicePtr& device, const Bvh& bvh) {
    // The triangles lie behind the nodes, so that one set of texels has both.
    const auto nodes = std::as_bytes(std::span(bvh.nodes)), triangles = std::as_bytes(std::span(bvh.triangles));
    std::vector<std::byte> both(nodes.begin(), nodes.end());
    both.insert(both.end(), triangles.begin(), triangles.end());
    auto buffer = upload(device, both);
    if (!buffer) return buffer.error();
    auto scene = std::make_unique<BvhScene>();
    scene->buffer_ = std::move(*buffer);
    const VkDeviceAddress address = scene->buffer_.address();
    scene->push_ = {address, address + nodes.size(), static_cast<uint32_t>(bvh.nodes.size())};
    if (device->features().loads_texels()) {
      auto texels = TexelSet::create(device, {{{scene->buffer_, VK_FORMAT_R32G32B32A32_UINT}}});
      if (!texels) return texels.error();
      scene->texels_ = std::move(*texels);
    }
    return std::unique_ptr<TracedScene>(std::move(scene));
  }

  uint64_t memory_bytes() const override { return buffer_.bytes(); }
  std::span<const std::byte> push_constants() const override { return std::as_bytes(std::span(&push_, 1)); }
  VkDescriptorSet texels() const override { return texels_.handle(); }

 private:
  Buffer buffer_;
  TexelSet texels_;
  Push push_;
};

class BvhTracer : public Tracer {
 public:
  BvhTracer(DevicePtr device, StructureBuildsPtr builds) : device_(std::move(device)), builds_(std::move(builds)) {}

  std::string_view name() const override { return "bvh"; }
  TraceShader shader() const override {
    if (device_->features().loads_texels()) return {trace_bvh_texels_comp, 0, 1, 1};
    return {trace_bvh_comp};
  }
  bool is_hierarchy() const override { return true; }
  Result<std::unique_ptr<TracedScene>> build_hierarchy(const TracerInput& input) const override {
    return build(input);
  }

  Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const override {
    const TimePoint start = Clock::now();
    const auto bvh = builds_->bvh(input.mesh);
    if (!bvh) return bvh.error();
    auto created = BvhScene::create(device_, *bvh);
    if (!created) return created.error();
    std::unique_ptr<TracedScene> scene = std::move(*created);
    scene->build_seconds = to_seconds(Clock::now() - start);
    return scene;
  }

 private:
  DevicePtr device_;
  StructureBuildsPtr builds_;
};

}  // namespace

std::unique_ptr<Tracer> make_bvh_tracer(const DevicePtr& device, StructureBuildsPtr builds) {
  return std::make_unique<BvhTracer>(device, std::move(builds));
}

}  // namespace gnomon::gpu
