// What every fuzz target is: any bytes in, nothing out, and no crash. Linked with libFuzzer by tests/fuzz/run, and with
// replay.cpp in the test suite.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace gnomon::fuzz {

// A property that holds whatever the bytes are. It is checked in all builds.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

// The next `count` bytes of the input, or as many as there are.
inline std::span<const uint8_t> take(std::span<const uint8_t>& input, size_t count) {
  const auto taken = input.first(count < input.size() ? count : input.size());
  input = input.subspan(taken.size());
  return taken;
}

// A number from 0 to `most` (at most 65,535).
inline uint32_t take_number(std::span<const uint8_t>& input, uint32_t most) {
  uint32_t value = 0;
  for (const uint8_t byte : take(input, 2)) value = value << 8 | byte;
  return value % (most + 1);
}

}  // namespace gnomon::fuzz
