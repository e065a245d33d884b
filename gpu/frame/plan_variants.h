// A renderer's plans and frame slots: one variant for scenes at rest, and another, made when something first moves, whose
// plan has the passes for that.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gpu/frame/frame_slot.h"

namespace gnomon::gpu {

struct PlanVariant {
  FramePlan plan;
  std::vector<FrameSlot> slots;
};

// PlanVariants stay where they are. Slot i of either variant is one frame in flight: not both at a time.
class PlanVariants {
 public:
  // `tracer` may be null where no pass traces; it outlives the variants. Error: see FramePlan::compile.
  static Result<PlanVariants> create(const DevicePtr& device, const std::vector<std::string>& passes,
                                     const Tracer* tracer, uint32_t slots);

  // The variant for a scene that is posed like this. Error: out of memory.
  Result<PlanVariant*> variant_for(const PosedScene& posed);
  // The variant for motion takes a while to be made: here on any thread, so that variant_for finds it.
  bool has_motion() const { return motion_ != nullptr; }
  Result<std::unique_ptr<PlanVariant>> make_motion() const { return make(true); }
  void give_motion(std::unique_ptr<PlanVariant> variant) {
    if (!motion_) motion_ = std::move(variant);
  }
  uint32_t slots() const { return slots_; }

 private:
  Result<std::unique_ptr<PlanVariant>> make(bool motion) const;

  DevicePtr device_;
  std::vector<std::string> passes_;
  const Tracer* tracer_ = nullptr;
  uint32_t slots_ = 0;
  std::unique_ptr<PlanVariant> rest_, motion_;
};

}  // namespace gnomon::gpu
