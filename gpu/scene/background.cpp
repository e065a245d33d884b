#include "gpu/scene/background.h"

#include <system_error>
#include <utility>

#include "common/freed_memory.h"
#include "common/niceness.h"

namespace gnomon::gpu {

Background::~Background() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Background::run(SceneOwner owner, std::function<Finish()> work, std::function<void()> wake) {
  JobPtr job;
  until_memory_suffices([&] { job = std::make_shared<Job>(); });
  *job = {owner, std::move(work), std::move(wake)};
  until_memory_suffices([&] {
    std::lock_guard lock(mutex_);
    jobs_.push(owner, job);
  });
  if (threads_.size() < most_threads_) add_thread();
  changed_.notify_one();
}

// One thread is enough for all jobs, only later.
void Background::add_thread() {
  try {
    threads_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {
    if (threads_.empty()) throw;
  }
}

void Background::serve() {
  if (niceness_ != 0) be_nicer(niceness_);
  while (const JobPtr job = next()) {
    finished_.push_surely(job->work());
    job->wake();
    *job = {job->owner, {}, {}};  // what it holds is freed before the next one begins
    give_back_freed_memory();
    {
      std::lock_guard lock(mutex_);
      jobs_.done(job->owner);
    }
    changed_.notify_all();
  }
}

Background::JobPtr Background::next() {
  std::unique_lock lock(mutex_);
  std::optional<JobPtr> job;
  changed_.wait(lock, [&] { return ending_ || (job = jobs_.start()); });
  return ending_ ? nullptr : *job;
}

void Background::finish() {
  std::vector<Finish> batch;
  finished_.take(batch, TimePoint::min());
  for (const Finish& finish : batch) finish();
}

}  // namespace gnomon::gpu
