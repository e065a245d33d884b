#include <algorithm>

#include "gpu/passes/passes.h"

namespace gnomon::gpu {
namespace {

uint64_t bytes_of(std::string_view source, const Capacity& size) {
  const TileGrid grid = size.grid();
  if (source == resource::kDraws || source == resource::kOccluderDraws)
    return uint64_t{size.cluster_chunks} * sizeof(VkDrawIndirectCommand);
  if (source == resource::kMasks || source == resource::kValidBits) return grid.word_count() * sizeof(uint64_t);
  if (source == resource::kAveraged) return averaged_bytes(grid.width, grid.height);
  const uint64_t pixels = uint64_t{grid.width} * grid.height;
  return pixels * (source == resource::kSurface ? sizeof(SurfaceSample) : sizeof(uint32_t));
}

class ReadbackPass : public Pass {
 public:
  ReadbackPass(std::string_view name, std::string_view source, std::string_view target)
      : name_(name), source_(source), target_(target) {}

  std::string_view name() const override { return name_; }
  const PassLayout* layout() const override { return nullptr; }
  RunsIn runs_in() const override { return RunsIn::last_band; }
  std::vector<Port> ports() const override {
    const auto bytes = [source = source_](const Capacity& c) { return bytes_of(source, c); };
    return {{source_, Use::copy_source}, {target_, Use::copy_target, {{}, bytes, MemoryUse::readback}}};
  }
  void record(const FrameContext& frame) const override {
    const VkBufferCopy region{0, 0, bytes_of(source_, frame.size())};
    if (region.size == 0) return;  // no lights, or no triangles
    vkCmdCopyBuffer(frame.commands, frame.ports[0].buffer->handle(), frame.ports[1].buffer->handle(), 1, &region);
  }

 private:
  std::string_view name_, source_, target_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_readback_pass(std::string_view name, std::string_view source,
                                                 std::string_view target) {
  return std::unique_ptr<Pass>(std::make_unique<ReadbackPass>(name, source, target));
}

}  // namespace gnomon::gpu
