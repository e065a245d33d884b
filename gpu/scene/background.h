// Work beside the frames: runs jobs on threads of its own, and the functions that they return on the owner's thread.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/fair_queue.h"
#include "common/inbox.h"
#include "gpu/renderer.h"

namespace gnomon::gpu {

class Background {
 public:
  using Finish = std::function<void()>;

  // `threads`: jobs of several owners at a time, of one owner at most half as many (or one). `niceness`: by how much the
  // threads and those that the work starts are nicer than the process (nice(2)).
  explicit Background(uint32_t threads = 1, int niceness = 0)
      : most_threads_(threads), niceness_(niceness), jobs_(threads) {}
  // `unlimited`: an owner that may have every thread.
  Background(uint32_t threads, SceneOwner unlimited)
      : most_threads_(threads), niceness_(0), jobs_(threads, unlimited) {}
  ~Background();  // waits for the jobs in progress; other jobs, and results that were not finished, are dropped

  // The owner's thread. `work` is called on a thread, its result is queued for finish(), then `wake` is called. Owners of
  // scenes take turns; jobs of one begin in order.
  void run(SceneOwner owner, std::function<Finish()> work, std::function<void()> wake);
  // The owner's thread. Calls the queued results in order; does not block.
  void finish();

 private:
  struct Job {
    SceneOwner owner{};
    std::function<Finish()> work;
    std::function<void()> wake;
  };
  using JobPtr = std::shared_ptr<Job>;
  void add_thread();
  void serve();
  JobPtr next();  // blocks; nullptr at the end

  const uint32_t most_threads_;
  const int niceness_;
  std::mutex mutex_;
  std::condition_variable changed_;
  FairQueue<SceneOwner, JobPtr> jobs_;  // guarded by mutex_
  bool ending_ = false;                 // guarded by mutex_
  Inbox<Finish> finished_;
  std::vector<std::thread> threads_;  // started as jobs come
};

}  // namespace gnomon::gpu
