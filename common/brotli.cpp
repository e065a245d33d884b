#include "common/brotli.h"

#include <brotli/encode.h>

#include <new>

namespace gnomon {

Result<std::vector<std::byte>> brotli(std::span<const std::byte> bytes, int quality) {
  try {
    size_t size = BrotliEncoderMaxCompressedSize(bytes.size());
    std::vector<std::byte> out(size);
    if (size == 0 || BrotliEncoderCompress(quality, BROTLI_MAX_WINDOW_BITS, BROTLI_MODE_GENERIC, bytes.size(),
                                           reinterpret_cast<const uint8_t*>(bytes.data()), &size,
                                           reinterpret_cast<uint8_t*>(out.data())) != BROTLI_TRUE)
      return Error{"it cannot be compressed"};
    out.resize(size);
    out.shrink_to_fit();
    return out;
  } catch (const std::bad_alloc&) {
    return Error{"there is not enough memory to compress it"};
  }
}

}  // namespace gnomon
