// A renderer's plans and frame slots: one variant for scenes at rest, and one for each kind of frames that need further
// passes, which is made when such a frame is first asked for.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "gpu/frame/frame_slot.h"

namespace gnomon::gpu {

struct PlanVariant {
  FramePlan plan;
  std::vector<FrameSlot> slots;
};

// Slot i of all variants is the same frame in flight: at most one of them is in use at a time. A PlanVariant keeps
// its address. All calls: the render loop's thread, unless stated otherwise.
class PlanVariants {
 public:
  // `tracer` may be null if no pass traces; it outlives the variants. Error: see FramePlan::compile.
  static Result<PlanVariants> create(const DevicePtr& device, const std::vector<std::string>& passes,
                                     const Tracer* tracer, uint32_t slots);

  // The variant for frames of `posed` with these samples, as in FrameView; it is made now if need be. Error: out of memory.
  Result<PlanVariant*> variant_for(const PosedScene& posed, SampleCounts samples);
  // A variant takes long to make. make() makes it on any thread; give() hands it over on the render loop's thread, so
  // that variant_for finds it. give() does nothing if there is one already.
  bool has(PlanKind kind) const { return variants_[index(kind)] != nullptr; }
  Result<std::unique_ptr<PlanVariant>> make(PlanKind kind) const;
  void give(PlanKind kind, std::unique_ptr<PlanVariant> variant) {
    if (!has(kind)) variants_[index(kind)] = std::move(variant);
  }
  uint32_t slots() const { return slots_; }

 private:
  static size_t index(PlanKind kind) {
    return (kind.motion ? 1 : 0) + (kind.soft ? 2 : 0) + (kind.occlusion ? 4 : 0);
  }

  DevicePtr device_;
  std::vector<std::string> passes_;
  const Tracer* tracer_ = nullptr;
  uint32_t slots_ = 0;
  std::array<std::unique_ptr<PlanVariant>, 8> variants_;
};

}  // namespace gnomon::gpu
