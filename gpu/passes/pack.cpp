// Packs masks and valid_bits into what the host reads (common/packed_mask.h).
#include <algorithm>

#include "common/packed_mask.h"
#include "gpu/passes/passes.h"
#include "spirv/pack_comp.h"
#include "spirv/readback_comp.h"

namespace gnomon::gpu {
namespace {

constexpr uint32_t kWorkgroup = 64;

uint32_t words_of(const FrameContext& frame) { return static_cast<uint32_t>(frame.grid.word_count()); }
uint64_t groups_of(const Capacity& c) { return PackedMaskView::class_words(c.grid()); }
uint64_t classes_bytes(const Capacity& c) { return groups_of(c) * sizeof(uint32_t); }
uint64_t workgroups_of(const Capacity& c) { return (groups_of(c) + kWorkgroup - 1) / kWorkgroup; }
uint64_t places_bytes(const Capacity& c) { return (groups_of(c) + workgroups_of(c)) * sizeof(uint32_t); }
uint64_t mixed_bytes(const Capacity& c) { return c.grid().word_count() * sizeof(uint64_t); }

// Dispatches an invocation for each group of words, and at least one workgroup.
void dispatch_groups(const FrameContext& frame) {
  vkCmdDispatch(frame.commands, std::max(1u, static_cast<uint32_t>(workgroups_of(frame.size()))), 1, 1);
}

class ComputePass : public Pass {
 public:
  explicit ComputePass(ComputeStep step) : step_(std::move(step)) {}
  const PassLayout* layout() const override { return &step_.layout; }
  RunsIn runs_in() const override { return RunsIn::last_band; }

 protected:
  ComputeStep step_;
};

class PackPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::string_view name() const override { return "pack"; }
  std::vector<Port> ports() const override {
    return {{resource::kMasks, Use::storage_read},
            {resource::kValidBits, Use::storage_read},
            {resource::kClasses, Use::storage_write, {{}, classes_bytes}},
            {resource::kMixedPlaces, Use::storage_write, {{}, places_bytes}}};
  }
  void record(const FrameContext& frame) const override {
    struct {
      VkDeviceAddress masks, valid_bits, classes, mixed_places;
      uint32_t words, words_of_light;
      uint32_t any_untraced;
      uint32_t untraced[kMaxLights / 32];
    } push{frame.ports[0].buffer->address(),
           frame.ports[1].buffer->address(),
           frame.ports[2].buffer->address(),
           frame.ports[3].buffer->address(),
           words_of(frame),
           frame.grid.tile_count(),
           frame.samples.per_light == 1 && frame.untraced.any(),  // trace_soft writes them itself
           {}};
    for (uint32_t light = 0; light < frame.scene.light_count(); ++light) {  // behind them stands occlusion
      push.untraced[light / 32] |= uint32_t{frame.untraced[light]} << (light % 32);
    }
    bind(frame, step_, std::as_bytes(std::span(&push, 1)));
    dispatch_groups(frame);
  }
};

class ReadbackPackedPass : public ComputePass {
 public:
  using ComputePass::ComputePass;
  std::string_view name() const override { return "readback"; }
  std::vector<Port> ports() const override {
    const auto count_bytes = [](const Capacity&) { return uint64_t{sizeof(uint32_t)}; };
    return {{resource::kMasks, Use::storage_read},
            {resource::kValidBits, Use::storage_read},
            {resource::kClasses, Use::storage_read},
            {resource::kMixedPlaces, Use::storage_read},
            {resource::kHostClasses, Use::storage_write, {{}, classes_bytes, MemoryUse::readback}},
            {resource::kHostMixed, Use::storage_write, {{}, mixed_bytes, MemoryUse::readback}},
            {resource::kHostMixedCount, Use::storage_write, {{}, count_bytes, MemoryUse::readback}}};
  }
  void record(const FrameContext& frame) const override {
    struct {
      VkDeviceAddress addresses[7];
      uint32_t words;
    } push{{}, words_of(frame)};
    for (size_t i = 0; i < std::size(push.addresses); ++i) push.addresses[i] = frame.ports[i].buffer->address();
    bind(frame, step_, std::as_bytes(std::span(&push, 1)));
    dispatch_groups(frame);
  }
};

}  // namespace

Result<std::unique_ptr<Pass>> make_pack_pass(const DevicePtr& device) {
  return pass_of<PackPass>(make_compute_step(device, 0, pack_comp));
}
Result<std::unique_ptr<Pass>> make_readback_packed_pass(const DevicePtr& device) {
  return pass_of<ReadbackPackedPass>(make_compute_step(device, 0, readback_comp));
}

}  // namespace gnomon::gpu
