// The one clock of the program, which is monotonic. Policy code takes a TimePoint as an argument and never reads the
// clock itself.
#pragma once

#include <chrono>
#include <cstdint>

namespace gnomon {

using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;
using Nanoseconds = std::chrono::nanoseconds;

inline double to_seconds(Nanoseconds d) { return std::chrono::duration<double>(d).count(); }
inline double to_milliseconds(Nanoseconds d) { return std::chrono::duration<double, std::milli>(d).count(); }
inline int64_t to_microseconds(Nanoseconds d) {
  return std::chrono::duration_cast<std::chrono::microseconds>(d).count();
}

}  // namespace gnomon
