// A value that one thread publishes and other threads read.
#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace gnomon {

// Holds the value that was published last; a default-constructed T before that. The lock covers only the exchange of a
// pointer, so that neither side waits while the other builds or reads a value. Any thread.
template <class T>
class Published {
 public:
  void publish(T value) {
    auto next = std::make_shared<const T>(std::move(value));
    std::lock_guard lock(mutex_);
    value_.swap(next);
  }

  std::shared_ptr<const T> get() const {
    std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const T> value_ = std::make_shared<const T>();
};

}  // namespace gnomon
