// Work beside the frames: runs jobs on one thread, and the functions that they return on the owner's thread.
#pragma once

#include <functional>
#include <thread>

#include "common/inbox.h"

namespace gnomon::gpu {

class Background {
 public:
  using Finish = std::function<void()>;

  // `niceness`: by how much the thread and those that the work starts are nicer than the process (nice(2)).
  explicit Background(int niceness = 0) : niceness_(niceness) {}
  ~Background();  // waits for the job in progress; other jobs, and results that were not finished, are dropped

  // The owner's thread. Jobs run on the thread one after the other: `work` is called, its result is queued for
  // finish(), then `wake` is called.
  void run(std::function<Finish()> work, std::function<void()> wake);
  // The owner's thread. Calls the queued results in order; does not block.
  void finish();

 private:
  struct Job {
    std::function<Finish()> work;
    std::function<void()> wake;
  };
  void serve();

  const int niceness_;
  Inbox<Job> jobs_;
  Inbox<Finish> finished_;
  std::thread thread_;  // started by the first job
};

}  // namespace gnomon::gpu
