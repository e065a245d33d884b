// Any block of LZ4, given any room: the decoder of browsers takes what the library takes, and writes no further.
#include <lz4.h>

#include <algorithm>
#include <vector>

#include "tests/fuzz/target.h"
#include "web/wasm/lz4_block.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon;
  using namespace gnomon::fuzz;
  std::span<const uint8_t> input(data, size);
  const size_t room = 1 + take_number(input, 65'535);
  std::vector<uint8_t> expected(room), got(room);
  const int written =
      LZ4_decompress_safe(reinterpret_cast<const char*>(input.data()), reinterpret_cast<char*>(expected.data()),
                          static_cast<int>(input.size()), static_cast<int>(room));
  const auto unpacked = web::unpack_lz4_block(input, got);
  require(unpacked.has_value() == (written >= 0), "both take the block or neither does");
  if (!unpacked) return 0;
  require(*unpacked == static_cast<size_t>(written), "both write as many bytes");
  require(std::equal(got.begin(), got.begin() + written, expected.begin()), "both write the same bytes");
  return 0;
}
