// What the decoder's code asks of libraries that there are none of here.
#include <lz4.h>

#include "web/wasm/lz4_block.h"

extern "C" {

int LZ4_decompress_safe(const char* from, char* into, int size, int room) {
  const auto written =
      gnomon::web::unpack_lz4_block({reinterpret_cast<const uint8_t*>(from), static_cast<size_t>(size)},
                                    {reinterpret_cast<uint8_t*>(into), static_cast<size_t>(room)});
  return written ? static_cast<int>(*written) : -1;
}

// Working memory of the only thread: it is never given back.
int __cxa_thread_atexit(void (*)(void*), void*, void*) { return 0; }
}
