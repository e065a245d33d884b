// One slice's header and payload, of any codec: tiles or an error, and nobody else's tiles are touched.
#include <algorithm>

#include "protocol/codec.h"
#include "tests/fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon;
  using namespace gnomon::fuzz;
  std::span<const uint8_t> input(data, size);
  const TileGrid grid{1 + take_number(input, 300), 1 + take_number(input, 200), 1 + take_number(input, 7)};
  protocol::SliceHeader header;
  header.slice_count = 1;
  header.codec = static_cast<protocol::CodecId>(take_number(input, 3));
  header.first_tile = take_number(input, grid.tile_count());
  header.tile_count = take_number(input, grid.tile_count());
  header.first_light = static_cast<uint16_t>(take_number(input, grid.planes));
  header.light_count = static_cast<uint16_t>(take_number(input, grid.planes));

  constexpr uint64_t kUntouched = 0x0123456789abcdef;
  std::vector<uint64_t> words(grid.word_count(), kUntouched);
  const auto decoded = protocol::decode_slice(header, input, grid, words);
  for (uint32_t light = 0; light < grid.planes; ++light) {
    for (uint32_t tile = 0; tile < grid.tile_count(); ++tile) {
      const bool mine =
          light - header.first_light < header.light_count && tile - header.first_tile < header.tile_count;
      const uint64_t word = words[size_t{light} * grid.tile_count() + tile];
      require(mine || word == kUntouched, "other slices' tiles are as they were");
    }
  }
  (void)decoded;
  return 0;
}
