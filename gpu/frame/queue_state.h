// One queue of the device: the submits that wait to be started on it, and the thread that waits for their ends.
#pragma once

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
  std::function<void(FrameDone)> on_done;  // null: the frame was abandoned, and only its slot is given back
};

// The render loop's, but for the completion thread inside. Each slot keeps to one queue for ever.
class QueueState {
 public:
  // `number`: of the device's queues.
  QueueState(std::shared_ptr<SlotPool> pool, size_t number);
  ~QueueState();  // waits for the submits that were started, and delivers them

  // The submit starts at the next start().
  void pend(InFlight submit);
  // Starts what is pending with one call of the driver. Returns the frames of which a submit could not be started; these
  // are delivered as lost or out of memory.
  std::vector<JobId> start();
  // The slot is given back when the device has passed all that was started before.
  void give_back_later(size_t slot);

 private:
  struct Started {
    InFlight submit;
    uint64_t timeline = 0;
    bool out_of_memory = false;  // why it never started
  };

  void complete();
  FrameDone finish(const Started& started);

  const std::shared_ptr<SlotPool> pool_;
  Queue& queue_;
  std::vector<InFlight> pending_;
  std::vector<VkCommandBuffer> commands_;  // of the pending ones
  Inbox<Started> started_;
  std::vector<uint64_t> slot_gpu_ns_;  // of the slot's frame, its bands so far; the completion thread's
  std::thread completion_;
};

}  // namespace gnomon::gpu
