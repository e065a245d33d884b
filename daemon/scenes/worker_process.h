// Runs gnomon-scene-worker once: gives it a task, waits for it, and maps what it left.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <utility>

#include "common/result.h"
#include "daemon/worker/task.h"

namespace gnomon::daemon {

// What a worker left, in a sealed file that nobody can change any more. Untrusted. Move-only.
class Outcome {
 public:
  Outcome(void* data, size_t size) : data_(data), size_(size) {}
  Outcome(Outcome&& other) noexcept : data_(std::exchange(other.data_, nullptr)), size_(other.size_) {}
  Outcome& operator=(Outcome&&) = delete;
  ~Outcome();

  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data_), data_ ? size_ : 0}; }

 private:
  void* data_;  // nullptr: empty
  size_t size_;
};

using OnProgress = std::function<void(size_t light, double share)>;

// How long to wait for a worker, who can end it before, and who is told how far it is, on the waiting thread.
struct Patience {
  std::chrono::milliseconds time{0};
  std::stop_token stop = {};
  OnProgress on_progress = {};
};

// Blocks; any thread. The error says why there is no outcome: it could not be started, met a limit, crashed or was
// stopped.
Result<Outcome> run_worker(const std::filesystem::path& program, const WorkerTask& task, const Patience& patience);

}  // namespace gnomon::daemon
