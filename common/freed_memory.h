// Memory that was freed and that the allocator keeps for each thread that ever had it.
#pragma once

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace gnomon {

// After something large was made and its scratch memory freed: the system gets that back. Takes some milliseconds. Any
// thread.
inline void give_back_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace gnomon
