#include "daemon/encode_pool.h"

#include <utility>

namespace gnomon::daemon {

EncodePool::EncodePool(uint32_t threads, Metrics& metrics, std::function<void(EncodedFrame)> encoded)
    : metrics_(metrics), encoded_(std::move(encoded)) {
  for (uint32_t i = 0; i < threads; ++i) workers_.emplace_back([this] { work(); });
}

EncodePool::~EncodePool() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  ready_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void EncodePool::push(RenderedFrame frame) {
  {
    std::lock_guard lock(mutex_);
    queue_.push_back(std::move(frame));
  }
  ready_.notify_one();
}

bool EncodePool::take(RenderedFrame& frame) {
  std::unique_lock lock(mutex_);
  ready_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
  if (stopping_) return false;
  frame = std::move(queue_.front());
  queue_.pop_front();
  return true;
}

void EncodePool::work() {
  protocol::FrameEncoder encoder;
  RenderedFrame frame;
  while (take(frame)) {
    EncodedFrame out{frame.meta, {}};
    out.meta.encode_began = Clock::now();
    const size_t header = protocol::kSliceHeaderBytes + (frame.meta.moment ? protocol::kMomentBytes : 0);
    const size_t room = frame.meta.slice_body_bytes - header;
    const auto result = encoder.encode(frame.mask.mask(), frame.meta.codec, room, out.slices);
    frame.mask.drop();
    if (!result) {
      metrics_.dropped(out.meta.tenant, Fault::encode_failed, {{"why", result.error().message}});
      continue;
    }
    out.meta.encoded = Clock::now();
    encoded_(std::move(out));
  }
}

}  // namespace gnomon::daemon
