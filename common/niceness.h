// Precedence of threads: who works beside frames is nicer than those that frames wait for.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

namespace gnomon {

// Makes the calling thread, and those that it starts from then on, nicer than it was by so much (nice(2)): also where the
// whole process has been made nicer. On Linux each thread has a niceness of its own.
inline void be_nicer(int by) {
  const auto thread = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + by);
}

}  // namespace gnomon
