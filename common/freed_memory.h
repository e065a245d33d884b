// Returns memory to the system that was freed but that the allocator keeps in its arenas.
#pragma once

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace gnomon {

// To be called after a large build has freed its scratch memory. Blocks for some milliseconds. Any thread.
inline void give_back_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace gnomon
