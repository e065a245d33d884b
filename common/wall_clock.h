// The calendar's time, for what outlives the process: dates of certificates, the age of a credential. It may jump, so
// that durations are measured with common/clock.h. Policy code takes it as an argument.
#pragma once

#include <chrono>

namespace gnomon {

inline std::chrono::sys_seconds wall_now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

}  // namespace gnomon
