// Predicts a client's view before its masks arrive: finds each pixel's surface in a view whose masks have arrived.
#include <array>

#include "gpu/passes/passes.h"
#include "gpu/passes/seen_view.h"
#include "spirv/ids_comp.h"
#include "spirv/predict_comp.h"

namespace gnomon::gpu {
namespace {

uint64_t word_for_each_pixel(const Capacity& size) { return uint64_t{size.width} * size.height * sizeof(uint32_t); }

class IdsPass : public Pass {
 public:
  IdsPass(ComputeStep step, bool kept) : step_(std::move(step)), kept_(kept) {}

  std::string_view name() const override { return kept_ ? "keep_ids" : "ids"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    return {{resource::kTriangleId, Use::sampled},
            {resource::kIds, Use::storage_write, {{}, word_for_each_pixel, MemoryUse::device, kept_}}};
  }
  void record(const FrameContext& frame) const override {
    const VkDeviceAddress ids = frame.ports[1].buffer->address();
    dispatch_tiles(frame, step_, std::as_bytes(std::span(&ids, 1)));
  }

 private:
  ComputeStep step_;
  bool kept_;
};

class PredictPass : public Pass {
 public:
  explicit PredictPass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "predict"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto view = [](const Capacity&) { return sizeof(SeenView); };
    return {{resource::kSeenView, Use::storage_read, {{}, view, MemoryUse::upload}},
            {resource::kSeenIds, Use::storage_read, given_buffer()},
            {resource::kIds, Use::storage_read, given_buffer()},  // given, unless an earlier pass writes them
            {resource::kSources, Use::storage_write, {{}, word_for_each_pixel}}};
  }
  void record(const FrameContext& frame) const override {
    const std::array addresses{frame.ports[0].buffer->address(), frame.ports[1].buffer->address(),
                               frame.ports[2].buffer->address(), frame.ports[3].buffer->address()};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(addresses)));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_ids_pass(const DevicePtr& device, bool kept) {
  return pass_of<IdsPass>(make_compute_step(device, 1, ids_comp), kept);
}
Result<std::unique_ptr<Pass>> make_predict_pass(const DevicePtr& device) {
  return pass_of<PredictPass>(make_compute_step(device, 0, predict_comp));
}

}  // namespace gnomon::gpu
