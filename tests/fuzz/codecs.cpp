// Any mask with any bits that do not matter, through every codec and back: those that matter are what they were.
#include <cstring>

#include "common/packed_mask.h"
#include "protocol/codec.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {
namespace {

// Words of few kinds, as masks are: dark, lit, edges, noise.
uint64_t take_word(std::span<const uint8_t>& input) {
  const uint32_t kind = take_number(input, 3);
  if (kind == 0) return 0;
  if (kind == 1) return ~uint64_t{0};
  uint64_t word = 0;
  const auto bytes = take(input, kind == 2 ? 1 : 8);
  std::memcpy(&word, bytes.data(), bytes.size());
  return kind == 2 ? word * 0x0101010101010101 : word;
}

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon;
  using namespace gnomon::fuzz;
  std::span<const uint8_t> input(data, size);
  const TileGrid grid{1 + take_number(input, 150), 1 + take_number(input, 80), 1 + take_number(input, 4)};
  const size_t room = protocol::kMinPayloadBytes + take_number(input, 600);
  std::vector<uint64_t> words(grid.word_count()), valid_bits(grid.word_count());
  for (size_t i = 0; i < words.size(); ++i) {
    valid_bits[i] = take_word(input);
    words[i] = take_word(input) & valid_bits[i];
  }
  const PackedMask packed(TileMaskView{grid, words}, valid_bits);
  protocol::FrameEncoder encoder;
  protocol::EncodedMask frame;
  for (const protocol::CodecId codec : protocol::kCodecs) {
    require(encoder.encode(packed.view(), codec, room, frame).has_value(), "a mask of this size can be encoded");
    std::vector<uint64_t> decoded(grid.word_count());
    for (size_t i = 0; i < frame.slices.size(); ++i) {
      require(frame.payload(i).size() <= room, "payloads are no longer than they may be");
      require(protocol::decode_slice(frame.slices[i], frame.payload(i), grid, decoded).has_value(),
              "a slice decodes");
    }
    for (size_t i = 0; i < words.size(); ++i) {
      require((decoded[i] & valid_bits[i]) == words[i], "bits that matter are what they were");
    }
  }
  return 0;
}
