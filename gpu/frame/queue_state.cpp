#include "gpu/frame/queue_state.h"

#include <utility>

#include "common/within_memory.h"

namespace gnomon::gpu {
namespace {

constexpr uint64_t kNeverStarted = UINT64_MAX;

// Sums the stages by purpose, because the daemon and its operators do not know the passes of a plan.
void add_stages(FrameDone& done, std::vector<StageTime> stages) {
  for (const StageTime& stage : stages) {
    if (stage.pass == "readback") done.readback_ns = stage.gpu_ns;
    if (stage.pass.starts_with("trace")) done.trace_ns += stage.gpu_ns;
  }
  done.stages = std::move(stages);
}

}  // namespace

QueueState::QueueState(std::shared_ptr<SlotPool> pool, size_t number)
    : pool_(std::move(pool)),
      queue_(pool_->device()->queue(number)),
      slot_gpu_ns_(pool_->variants().slots()),
      completion_([this] { complete(); }) {}

QueueState::~QueueState() {
  started_.close();
  completion_.join();
}

void QueueState::pend(InFlight submit) {
  in_flight_.fetch_add(1, std::memory_order_relaxed);
  commands_.push_back(submit.band.commands);
  pending_.push_back(std::move(submit));
}

std::vector<JobId> QueueState::start() {
  std::vector<JobId> refused;
  if (pending_.empty()) return refused;
  const auto first = queue_.submit(commands_, &pool_->device()->queue());
  for (size_t i = 0; i < pending_.size(); ++i) {
    if (!first) refused.push_back(pending_[i].id);
    started_.push_surely({std::move(pending_[i]), first ? *first + i : kNeverStarted, !first && !queue_.lost()});
  }
  pending_.clear();
  commands_.clear();
  return refused;
}

void QueueState::free_later(size_t slot) {
  InFlight nothing;
  nothing.slot = slot;
  started_.push_surely({std::move(nothing), 0, false});
}

void QueueState::complete() {
  std::vector<Started> batch;
  for (started_.take(batch); !batch.empty(); started_.take(batch)) {
    for (Started& started : batch) {
      if (started.submit.on_done) {
        FrameDone done = finish(started);
        in_flight_.fetch_sub(1, std::memory_order_relaxed);
        started.submit.on_done(std::move(done));
      } else {
        pool_->free(started.submit.slot);
      }
    }
  }
}

FrameDone QueueState::finish(const Started& started) {
  const InFlight& submit = started.submit;
  const FramePlan& plan = submit.variant->plan;
  const FrameSlot& slot = submit.variant->slots[submit.slot];
  uint64_t& frame_gpu_ns = slot_gpu_ns_[submit.slot];
  if (submit.first) frame_gpu_ns = 0;
  FrameDone done;
  done.id = submit.id;
  done.complete = submit.last;
  const auto passed = started.timeline == kNeverStarted ? Result<void>(Error{"the device took no work"})
                                                        : queue_.wait(started.timeline);
  Result<FrameTiming> timing = Error{};
  until_memory_suffices(
      [&] { timing = passed ? slot.timing(plan, submit.band.timestamps) : Result<FrameTiming>(passed.error()); });
  done.completed_at = Clock::now();
  if (timing) {
    done.gpu_ns = pool_->device_ns(timing->begin_ns, timing->begin_ns + timing->total_ns);
    done.frame_gpu_ns = frame_gpu_ns += done.gpu_ns;
    add_stages(done, std::move(timing->stages));
  } else {
    done.out_of_memory = started.out_of_memory;
    done.device_lost = !started.out_of_memory;
  }
  if (submit.last) {
    const PackedMaskView mask = timing ? slot.packed(plan, submit.grid) : PackedMaskView{};
    until_memory_suffices([&] { done.mask = SlotPool::lease(pool_, submit.slot, mask); });
  }
  return done;
}

}  // namespace gnomon::gpu
