#include "gpu/scene/background.h"

#include <sys/resource.h>
#include <unistd.h>

#include <utility>
#include <vector>

#include "common/freed_memory.h"

namespace gnomon::gpu {

Background::~Background() {
  jobs_.close();
  if (thread_.joinable()) thread_.join();
}

void Background::run(std::function<Finish()> work, std::function<void()> wake) {
  jobs_.push_surely({std::move(work), std::move(wake)});
  if (!thread_.joinable()) thread_ = std::thread([this] { serve(); });
}

void Background::serve() {
  // On Linux each thread has a niceness of its own, which threads that it starts inherit.
  if (niceness_ != 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness_);
  std::vector<Job> batch;
  for (jobs_.take(batch); !batch.empty(); jobs_.take(batch)) {
    for (Job& job : batch) {
      if (jobs_.closed()) return;
      finished_.push_surely(job.work());
      job.wake();
      give_back_freed_memory();
    }
  }
}

void Background::finish() {
  std::vector<Finish> batch;
  finished_.take(batch, TimePoint::min());
  for (const Finish& finish : batch) finish();
}

}  // namespace gnomon::gpu
