// Work on the rows of a picture, on all of the machine's threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace gnomon::bench {

inline void for_rows(uint32_t rows, const std::function<void(uint32_t)>& row) {
  std::atomic<uint32_t> next = 0;
  const auto work = [&] {
    for (uint32_t y = next++; y < rows; y = next++) row(y);
  };
  std::vector<std::thread> others;
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
}

}  // namespace gnomon::bench
