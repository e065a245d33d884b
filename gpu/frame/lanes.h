// A renderer's plans and frame slots: one lane for scenes at rest, and another, made when something first moves, whose
// plan has the passes for that.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gpu/frame/frame_slot.h"

namespace gnomon::gpu {

struct Lane {
  FramePlan plan;
  std::vector<FrameSlot> slots;
};

// Lanes stay where they are. Slot i of either lane is one frame in flight: not both at a time.
class Lanes {
 public:
  // `tracer` may be null where no pass traces; it outlives the lanes. Error: see FramePlan::compile.
  static Result<Lanes> create(const DevicePtr& device, const std::vector<std::string>& passes, const Tracer* tracer,
                              uint32_t slots);

  // The lane for a scene that is posed like this. Error: out of memory.
  Result<Lane*> lane_for(const PosedScene& posed);
  // The lane for motion takes a while to be made: here on any thread, so that lane_for finds it.
  bool has_motion() const { return motion_ != nullptr; }
  Result<std::unique_ptr<Lane>> make_motion() const { return make(true); }
  void give_motion(std::unique_ptr<Lane> lane) {
    if (!motion_) motion_ = std::move(lane);
  }
  uint32_t slots() const { return slots_; }

 private:
  Result<std::unique_ptr<Lane>> make(bool motion) const;

  DevicePtr device_;
  std::vector<std::string> passes_;
  const Tracer* tracer_ = nullptr;
  uint32_t slots_ = 0;
  std::unique_ptr<Lane> rest_, motion_;
};

}  // namespace gnomon::gpu
