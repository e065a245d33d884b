#include "gpu/scene/background.h"

#include <utility>
#include <vector>

#include "common/freed_memory.h"
#include "common/niceness.h"

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
  if (niceness_ != 0) be_nicer(niceness_);
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
