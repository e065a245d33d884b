// Inbox<T>: a queue to the thread that owns the state which the values change. Many threads push, one takes.
//
// A consumer that waits on one inbox needs no other lock. After close(), pushes are refused, queued values are still
// delivered, and then every take() returns an empty batch at once.
#pragma once

#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include "common/clock.h"
#include "common/within_memory.h"

namespace gnomon {

template <class T>
class Inbox {
 public:
  // Any thread. Returns false and drops the value if the inbox is closed.
  bool push(T value) {
    {
      std::lock_guard lock(mutex_);
      if (closed_) return false;
      queue_.push_back(std::move(value));
    }
    ready_.notify_one();
    return true;
  }

  // As push(), but waits until there is memory for the value: for what must not be lost. The consumer, who may free some,
  // is not held up meanwhile.
  bool push_surely(T value) {
    bool pushed = false;
    until_memory_suffices([&] {
      std::lock_guard lock(mutex_);
      if (closed_) return;
      queue_.push_back(std::move(value));  // moves nothing if it fails
      pushed = true;
    });
    if (pushed) ready_.notify_one();
    return pushed;
  }

  // The consumer's thread. Replaces `batch` with all queued values; if there are none, waits for the first one until
  // `deadline`. An empty batch means that the deadline has passed or that the inbox is closed and drained.
  void take(std::vector<T>& batch, TimePoint deadline) {
    batch.clear();
    std::unique_lock lock(mutex_);
    ready_.wait_until(lock, deadline, [this] { return closed_ || !queue_.empty(); });
    batch.swap(queue_);
  }

  // As above, without a deadline: an empty batch means that the inbox is closed and drained.
  void take(std::vector<T>& batch) {
    batch.clear();
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return closed_ || !queue_.empty(); });
    batch.swap(queue_);
  }

  // Any thread. Idempotent.
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
