// Accumulates what masks count over several of them (gpu/passes/accumulation.h).
#include "gpu/passes/accumulation.h"

#include <vector>

#include "gpu/passes/passes.h"
#include "gpu/passes/seen_view.h"
#include "spirv/accumulate_comp.h"

namespace gnomon::gpu {
namespace {

class AccumulatePass : public Pass {
 public:
  explicit AccumulatePass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "accumulate"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto numbers = [](const Capacity&) { return sizeof(Accumulation); };
    const auto views = [](const Capacity&) { return kMostEarlierMasks * sizeof(SeenView); };
    std::vector<Port> ports{{resource::kAccumulation, Use::storage_read, {{}, numbers, MemoryUse::upload}},
                            {resource::kIds, Use::storage_read, given_buffer()},
                            {resource::kGivenMasks, Use::storage_read, given_buffer()},
                            {resource::kShares, Use::storage_write, given_buffer()},
                            {resource::kEarlierViews, Use::storage_read, {{}, views, MemoryUse::upload}}};
    for (const auto& names : {resource::kEarlierIds, resource::kEarlierMasks})
      for (const std::string_view name : names) ports.push_back({name, Use::storage_read, given_buffer()});
    return ports;
  }
  void record(const FrameContext& frame) const override {
    std::vector<VkDeviceAddress> addresses;
    for (size_t port = 0; port < 4; ++port) addresses.push_back(frame.ports[port].buffer->address());
    for (uint32_t e = 0; e < kMostEarlierMasks; ++e)
      addresses.push_back(frame.ports[4].buffer->address() + e * sizeof(SeenView));
    for (size_t port = 5; port < frame.ports.size(); ++port)
      addresses.push_back(frame.ports[port].buffer->address());
    dispatch_tiles(frame, step_, std::as_bytes(std::span(addresses)));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_accumulate_pass(const DevicePtr& device) {
  return pass_of<AccumulatePass>(make_compute_step(device, 0, accumulate_comp));
}

}  // namespace gnomon::gpu
