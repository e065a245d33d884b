// Workers that encode masks into slices. A frame's lease is dropped as soon as its mask has been read.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "daemon/encode/cores.h"
#include "daemon/frame/frame_sink.h"
#include "daemon/metrics/metrics.h"
#include "protocol/split_frame.h"

namespace gnomon::daemon {

// A large frame takes milliseconds: its units are spread over all idle workers, so that its client waits for the longest
// unit and not for their sum. The slices do not depend on their number. A frame of raw32_lz4 is encoded by one worker.
//
// The queue needs no limit of its own: every frame in it holds one of the device's frame slots.
class EncodePool {
 public:
  // `near`: the cores near each device. If some are known and there is a worker for each device, workers are assigned
  // to devices in turn, are bound to the cores near theirs and prefer its frames. The workers call sink.on_encoded().
  EncodePool(uint32_t threads, std::vector<Cores> near, Metrics& metrics, FrameSink& sink);
  ~EncodePool();  // queued frames are discarded and their leases dropped

  void push(RenderedFrame frame);  // any thread

 private:
  // A frame that several workers encode.
  struct Shared {
    EncodedFrame out;
    gpu::FrameLease mask;  // dropped once all units are encoded, or at once where `frame` has copied it
    protocol::SplitFrame frame;
    std::atomic<size_t> next{0}, done{0};  // units
    std::atomic<bool> failed = false;      // a unit ran out of memory
  };
  using SharedPtr = std::shared_ptr<Shared>;
  using Work = std::variant<RenderedFrame, SharedPtr>;

  void work(std::optional<uint32_t> home);  // `home`: the worker's device, if it has one
  // Waits for a shared frame or one from the queue; nullopt if the pool ends. Shared frames come first, as they were
  // pushed earlier.
  std::optional<Work> take(std::optional<uint32_t> home);
  void begin(RenderedFrame& frame, protocol::FrameEncoder& encoder);
  void encode(RenderedFrame& frame, protocol::FrameEncoder& encoder);
  SharedPtr share(RenderedFrame& frame);
  void help(Shared& shared);
  void finish(Shared& shared);
  void deliver(EncodedFrame out, const Result<void>& result);

  const std::vector<Cores> near_;
  Metrics& metrics_;
  FrameSink& sink_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<RenderedFrame> queue_;
  std::deque<SharedPtr> shared_;
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace gnomon::daemon
