#include "gpu/passes/passes.h"

namespace gnomon::gpu {
namespace {

uint64_t bytes_of(const Capacity& size) { return size.grid().word_count() * sizeof(uint64_t); }

class UploadMasksPass : public Pass {
 public:
  explicit UploadMasksPass(bool kept) : kept_(kept) {}

  std::string_view name() const override { return kept_ ? "keep_masks" : "upload_masks"; }
  const PassLayout* layout() const override { return nullptr; }
  std::vector<Port> ports() const override {
    return {{resource::kUploadedMasks, Use::copy_source, {{}, bytes_of, MemoryUse::upload}},
            {resource::kGivenMasks, Use::copy_target, {{}, bytes_of, MemoryUse::device, kept_}}};
  }
  void record(const FrameContext& frame) const override {
    const VkBufferCopy region{0, 0, bytes_of(frame.size())};
    if (region.size == 0) return;  // no lights
    vkCmdCopyBuffer(frame.commands, frame.ports[0].buffer->handle(), frame.ports[1].buffer->handle(), 1, &region);
  }

 private:
  bool kept_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_upload_masks_pass(bool kept) {
  return std::unique_ptr<Pass>(std::make_unique<UploadMasksPass>(kept));
}

}  // namespace gnomon::gpu
