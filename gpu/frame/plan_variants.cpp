#include "gpu/frame/plan_variants.h"

namespace gnomon::gpu {

Result<PlanVariants> PlanVariants::create(const DevicePtr& device, const std::vector<std::string>& passes,
                                          const Tracer* tracer, uint32_t slots) {
  PlanVariants variants;
  variants.device_ = device;
  variants.passes_ = passes;
  variants.tracer_ = tracer;
  variants.slots_ = slots;
  auto rest = variants.make({});
  if (!rest) return rest.error();
  variants.give({}, std::move(*rest));
  return variants;
}

Result<PlanVariant*> PlanVariants::variant_for(const PosedScene& posed, SampleCounts samples) {
  const PlanKind kind{!posed.at_rest(), samples.per_light > 1, samples.occlusion != Occlusion::none};
  if (!has(kind)) {
    auto made = make(kind);
    if (!made) return made.error();
    give(kind, std::move(*made));
  }
  return variants_[index(kind)].get();
}

Result<std::unique_ptr<PlanVariant>> PlanVariants::make(PlanKind kind) const {
  auto plan = FramePlan::compile(device_, passes_, tracer_, kind);
  if (!plan) return plan.error();
  auto variant = std::make_unique<PlanVariant>(PlanVariant{std::move(*plan), {}});
  for (uint32_t i = 0; i < slots_; ++i) {
    auto slot = FrameSlot::create(device_, variant->plan, i);
    if (!slot) return slot.error();
    variant->slots.push_back(std::move(*slot));
  }
  return variant;
}

}  // namespace gnomon::gpu
