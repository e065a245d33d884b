#include "gpu/background.h"

#include <utility>
#include <vector>

namespace gnomon::gpu {

Background::~Background() {
  jobs_.close();
  if (thread_.joinable()) thread_.join();
}

void Background::run(std::function<Finish()> work, std::function<void()> wake) {
  jobs_.push({std::move(work), std::move(wake)});
  if (!thread_.joinable()) thread_ = std::thread([this] { serve(); });
}

void Background::serve() {
  std::vector<Job> batch;
  for (jobs_.take(batch); !batch.empty(); jobs_.take(batch)) {
    for (Job& job : batch) {
      if (jobs_.closed()) return;
      finished_.push(job.work());
      job.wake();
    }
  }
}

void Background::finish() {
  std::vector<Finish> batch;
  finished_.take(batch, TimePoint::min());
  for (const Finish& finish : batch) finish();
}

}  // namespace gnomon::gpu
