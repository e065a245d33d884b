// A loop spread over threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace gnomon {

// Calls body(0) ... body(count - 1), each once, in any order, on up to `threads` threads including the caller's;
// returns when all calls have returned. `body` must not throw.
template <class Body>
void parallel_for(size_t count, unsigned threads, const Body& body) {
  std::atomic<size_t> next{0};
  const auto work = [&] {
    for (size_t i = next++; i < count; i = next++) body(i);
  };
  std::vector<std::jthread> others;
  for (size_t t = 1; t < std::min<size_t>(threads, count); ++t) others.emplace_back(work);
  work();
}

}  // namespace gnomon
