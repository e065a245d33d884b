#include "gpu/frame/lanes.h"

namespace gnomon::gpu {

Result<Lanes> Lanes::create(const DevicePtr& device, const std::vector<std::string>& passes, const Tracer* tracer,
                            uint32_t slots) {
  Lanes lanes;
  lanes.device_ = device;
  lanes.passes_ = passes;
  lanes.tracer_ = tracer;
  lanes.slots_ = slots;
  auto rest = lanes.make(false);
  if (!rest) return rest.error();
  lanes.rest_ = std::move(*rest);
  return lanes;
}

Result<Lane*> Lanes::lane_for(const PosedScene& posed) {
  if (posed.at_rest()) return rest_.get();
  if (!motion_) {
    auto motion = make(true);
    if (!motion) return motion.error();
    motion_ = std::move(*motion);
  }
  return motion_.get();
}

Result<std::unique_ptr<Lane>> Lanes::make(bool motion) const {
  auto plan = FramePlan::compile(device_, passes_, tracer_, motion);
  if (!plan) return plan.error();
  auto lane = std::make_unique<Lane>(Lane{std::move(*plan), {}});
  for (uint32_t i = 0; i < slots_; ++i) {
    auto slot = FrameSlot::create(device_, lane->plan, i);
    if (!slot) return slot.error();
    lane->slots.push_back(std::move(*slot));
  }
  return lane;
}

}  // namespace gnomon::gpu
