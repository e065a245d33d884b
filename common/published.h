// A value that one thread publishes and others look at.
#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace gnomon {

// The newest value that one thread published, for others to look at. Neither side waits for the other's work: what
// is locked is the exchange of a pointer.
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
