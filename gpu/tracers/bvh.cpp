// Tracer "bvh": a bounding volume hierarchy in plain compute. Runs on every device.
#include "common/clock.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_bvh_comp.h"
#include "spirv/trace_bvh_pairs_comp.h"

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
  BvhScene(Buffer nodes, Buffer triangles, uint32_t node_count)
      : nodes_(std::move(nodes)), triangles_(std::move(triangles)) {
    push_ = {nodes_.address(), triangles_.address(), node_count};
  }
  uint64_t memory_bytes() const override { return nodes_.bytes() + triangles_.bytes(); }
  std::span<const std::byte> push_constants() const override { return std::as_bytes(std::span(&push_, 1)); }

 private:
  Buffer nodes_, triangles_;
  Push push_;
};

class BvhTracer : public Tracer {
 public:
  BvhTracer(DevicePtr device, StructureBuildsPtr builds) : device_(std::move(device)), builds_(std::move(builds)) {}

  std::string_view name() const override { return "bvh"; }
  TraceShader shader() const override { return {device_->features().choose(trace_bvh_pairs_comp, trace_bvh_comp)}; }
  bool is_hierarchy() const override { return true; }
  Result<std::unique_ptr<TracedScene>> build_hierarchy(const TracerInput& input) const override {
    return build(input);
  }

  Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const override {
    const TimePoint start = Clock::now();
    const auto bvh = builds_->bvh(input.mesh);
    if (!bvh) return bvh.error();
    auto nodes = upload(device_, std::as_bytes(std::span(bvh->nodes)));
    if (!nodes) return nodes.error();
    auto triangles = upload(device_, std::as_bytes(std::span(bvh->triangles)));
    if (!triangles) return triangles.error();
    std::unique_ptr<TracedScene> scene = std::make_unique<BvhScene>(std::move(*nodes), std::move(*triangles),
                                                                    static_cast<uint32_t>(bvh->nodes.size()));
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
