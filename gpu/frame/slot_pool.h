// The frame slots of a renderer, and the objects that frames on the device refer to. Leases share the pool and keep it
// alive after the renderer's destruction.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "gpu/frame/overlap.h"
#include "gpu/frame/plan_variants.h"
#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {

class SlotPool {
 public:
  SlotPool(DevicePtr device, std::unique_ptr<Tracer> tracer, PlanVariants variants)
      : device_(std::move(device)), tracer_(std::move(tracer)), variants_(std::move(variants)) {
    for (size_t i = 0; i < variants_.slots(); ++i) free_.push_back(i);
  }

  const DevicePtr& device() const { return device_; }
  const Tracer& tracer() const { return *tracer_; }
  // Used by the render loop's thread; a slot that was taken may be used by its taker's thread.
  PlanVariants& variants() { return variants_; }
  const PlanVariants& variants() const { return variants_; }

  // `freed` is called whenever free() has given a slot back, on its thread. Precondition: no frame was submitted yet.
  void on_freed(std::function<void()> freed) { freed_ = std::move(freed); }

  // Any thread. The device time of what ran between these times on one of its queues; see Overlap.
  uint64_t device_ns(uint64_t begin_ns, uint64_t end_ns) {
    return device_->queue_count() > 1 ? overlap_.device_ns(begin_ns, end_ns) : end_ns - begin_ns;
  }

  // Any thread.
  uint32_t free_count() const {
    std::lock_guard lock(mutex_);
    return static_cast<uint32_t>(free_.size());
  }
  // Precondition: a slot is free.
  size_t take() {
    std::lock_guard lock(mutex_);
    const size_t slot = free_.back();
    free_.pop_back();
    return slot;
  }
  // Precondition: the slot was taken, and the device has passed its frame.
  void give_back(size_t slot) {
    std::lock_guard lock(mutex_);
    free_.push_back(slot);
  }
  // Gives back the slot of a frame that was submitted, and says so. Precondition: as give_back.
  void free(size_t slot) {
    give_back(slot);
    if (freed_) freed_();
  }
  // A lease that frees the slot when it is dropped. Precondition: as give_back.
  static FrameLease lease(std::shared_ptr<SlotPool> pool, size_t slot, const PackedMaskView& mask) {
    return FrameLease(mask, [pool = std::move(pool), slot] { pool->free(slot); });
  }

 private:
  DevicePtr device_;
  std::unique_ptr<Tracer> tracer_;
  PlanVariants variants_;
  std::function<void()> freed_;
  Overlap overlap_;
  mutable std::mutex mutex_;
  std::vector<size_t> free_;  // guarded by mutex_
};

}  // namespace gnomon::gpu
