// A renderer's plans and frame slots: one variant for scenes at rest, and another one with the passes for motion, which
// is made when something first moves.
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

// Slot i of both variants is the same frame in flight: at most one of the two is in use at a time. A PlanVariant keeps
// its address. All calls: the render loop's thread, unless stated otherwise.
class PlanVariants {
 public:
  // `tracer` may be null if no pass traces; it outlives the variants. Error: see FramePlan::compile.
  static Result<PlanVariants> create(const DevicePtr& device, const std::vector<std::string>& passes,
                                     const Tracer* tracer, uint32_t slots);

  // The variant for frames of `posed`, which is made now if need be. Error: out of memory.
  Result<PlanVariant*> variant_for(const PosedScene& posed);
  // The variant for motion takes long to make. make_motion makes it on any thread; give_motion hands it over on the
  // render loop's thread, so that variant_for finds it. give_motion does nothing if there is one already.
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
