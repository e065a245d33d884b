// One queue of the device: the submits that are pending on it, and the thread that waits for their completion.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "common/inbox.h"
#include "gpu/frame/slot_pool.h"

namespace gnomon::gpu {

// One submit: a frame, or a band of one.
struct InFlight {
  JobId id;
  size_t slot = 0;
  PlanVariant* variant = nullptr;
  RecordedBand band;
  bool first = true, last = true;  // of the frame's bands
  TileGrid grid;
  std::function<void(FrameDone)> on_done;  // null: the frame was abandoned, and only its slot is freed
};

// All calls: the render loop's thread; `on_done` is called on the completion thread inside. All bands of a frame use the
// same queue.
class QueueState {
 public:
  // `number`: index among the device's queues.
  QueueState(std::shared_ptr<SlotPool> pool, size_t number);
  ~QueueState();  // waits for the submits that were started, and delivers them

  // Queues the submit for the next start().
  void pend(InFlight submit);
  // Submits that are pending or started and not yet done.
  size_t in_flight() const { return in_flight_.load(std::memory_order_relaxed); }
  // Starts all pending submits with one call of the driver. Returns the frames of which a submit could not be started;
  // these submits are delivered as lost or out of memory.
  std::vector<JobId> start();
  // The slot is free when the device has passed all submits that were started before.
  void free_later(size_t slot);

 private:
  struct Started {
    InFlight submit;
    uint64_t timeline = 0;
    bool out_of_memory = false;  // the reason if it was not started
  };

  void complete();
  FrameDone finish(const Started& started);

  const std::shared_ptr<SlotPool> pool_;
  Queue& queue_;
  std::vector<InFlight> pending_;
  std::vector<VkCommandBuffer> commands_;  // of the pending ones
  std::atomic<size_t> in_flight_{0};       // counted down by the completion thread
  Inbox<Started> started_;
  std::vector<uint64_t> slot_gpu_ns_;  // for each slot: sum over the bands of its frame; the completion thread's
  std::thread completion_;
};

}  // namespace gnomon::gpu
