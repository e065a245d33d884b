// Turns a lack of memory into an error of one piece of work, so that it costs a frame, a scene or a session instead of
// the process.
#pragma once

#include <chrono>
#include <new>
#include <thread>

#include "common/log.h"
#include "common/result.h"

namespace gnomon {

// Calls `work`, which returns a Result. Error: what it returns, or that there was no memory, in so few letters that the error
// and its copies allocate nothing.
template <class Work>
auto within_memory(Work work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{"no memory"};
  }
}

// Calls `work`. False if memory ran out: what it had to do is dropped, and the log says so if it can. For threads that
// react to one event after the other, none of which may end the thread.
template <class Work>
bool done_or_dropped(const char* what, Work work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
  }
  try {
    log::error("dropped for want of memory", {{"what", what}});
  } catch (const std::bad_alloc&) {
  }
  return false;
}

// Calls `work` again and again until there is memory for it, with a rest between. For the steps without which nothing
// would ever come again: a timer that is set anew, a socket that is waited for, a finished job that is reported.
template <class Work>
void until_memory_suffices(Work work) {
  constexpr std::chrono::milliseconds kRest{1};
  for (;; std::this_thread::sleep_for(kRest)) {
    try {
      return work();
    } catch (const std::bad_alloc&) {
    }
  }
}

}  // namespace gnomon
