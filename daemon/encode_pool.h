// Workers that turn masks into slices. A finished frame's lease is dropped as soon as its mask has been read.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "daemon/frame.h"
#include "daemon/metrics.h"

namespace gnomon::daemon {

// The queue needs no limit of its own: every frame in it holds one of the device's frame slots.
class EncodePool {
 public:
  // `encoded` is called from the workers.
  EncodePool(uint32_t threads, Metrics& metrics, std::function<void(EncodedFrame)> encoded);
  ~EncodePool();  // what is queued is thrown away, its leases dropped

  void push(RenderedFrame frame);  // any thread

 private:
  void work();
  bool take(RenderedFrame& frame);

  Metrics& metrics_;
  std::function<void(EncodedFrame)> encoded_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<RenderedFrame> queue_;
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace gnomon::daemon
