// Work beside the frames: done on one thread, and what remains to be done with its result on the owner's.
#pragma once

#include <functional>
#include <thread>

#include "common/inbox.h"

namespace gnomon::gpu {

class Background {
 public:
  using Finish = std::function<void()>;

  // `niceness`: of the thread and of those that the work starts, as nice(2) counts; 0: as the rest of the program.
  explicit Background(int niceness = 0) : niceness_(niceness) {}
  ~Background();  // waits for the work in progress; what it and the others leave is dropped

  // `work` is done on the thread, one after the other; then `wake` is called there, and what `work` returned waits for
  // the owner.
  void run(std::function<Finish()> work, std::function<void()> wake);
  // The owner's thread: what waits, in order.
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
  std::thread thread_;  // from the first job on
};

}  // namespace gnomon::gpu
