// Inbox<T>: how a value reaches the thread that owns the state it changes. Many threads push, one takes.
//
// A consumer that sleeps on one inbox needs no other lock. After close() pushes are refused, what is queued is
// still delivered, and then take() returns an empty batch for ever.
#pragma once

#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include "common/clock.h"

namespace gnomon {

template <class T>
class Inbox {
 public:
  // Any thread. False, and the value dropped, once closed.
  bool push(T value) {
    {
      std::lock_guard lock(mutex_);
      if (closed_) return false;
      queue_.push_back(std::move(value));
    }
    ready_.notify_one();
    return true;
  }

  // The owner's thread. Replaces `batch` with everything queued; waits for the first until `deadline`.
  // An empty batch means that the deadline passed or that the inbox is closed and drained.
  void take(std::vector<T>& batch, TimePoint deadline) {
    batch.clear();
    std::unique_lock lock(mutex_);
    ready_.wait_until(lock, deadline, [this] { return closed_ || !queue_.empty(); });
    batch.swap(queue_);
  }

  // The same without a deadline. An empty batch means closed and drained.
  void take(std::vector<T>& batch) {
    batch.clear();
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return closed_ || !queue_.empty(); });
    batch.swap(queue_);
  }

  void close() {
    {
      std::lock_guard lock(mutex_);
      closed_ = true;
    }
    ready_.notify_all();
  }

  bool closed() const {
    std::lock_guard lock(mutex_);
    return closed_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::vector<T> queue_;
  bool closed_ = false;
};

}  // namespace gnomon
