// Turns a lack of memory into an error of one piece of work, so that it costs a frame, a scene or a session instead of
// the process.
#pragma once

#include <new>

#include "common/result.h"

namespace gnomon {

// Calls `work`, which returns a Result. Error: what it returns, or that there was not enough memory.
template <class Work>
auto within_memory(Work work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{"there is not enough memory for it"};
  }
}

}  // namespace gnomon
