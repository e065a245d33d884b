#include "protocol/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "protocol/slice_layout.h"
#include "protocol/types.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::protocol {
namespace {

using tests::Mask;

constexpr CodecId kPlainCodecs[] = {CodecId::raw32_lz4, CodecId::tiles_lz4};  // of plain bytes, with or without LZ4
constexpr uint64_t kCanary = 0xdeadbeefcafef00d;

EncodedMask encoded(const Mask& mask, CodecId codec, size_t max_payload_bytes = kMaxSlicePayloadBytes) {
  FrameEncoder encoder;
  EncodedMask frame;
  const auto result = encoder.encode(mask.view(), codec, max_payload_bytes, frame);
  EXPECT_TRUE(result.has_value()) << result.error().message;
  return frame;
}

// Calls `visit` with the index of every word of the slice.
template <class Visit>
void for_words(const SliceHeader& slice, const TileGrid& grid, Visit visit) {
  for (uint32_t light = slice.first_light; light < uint32_t{slice.first_light} + slice.light_count; ++light) {
    for (uint32_t tile = slice.first_tile; tile < slice.first_tile + slice.tile_count; ++tile) {
      visit(size_t{light} * grid.tile_count() + tile);
    }
  }
}

void expect_sound(const EncodedMask& frame, CodecId codec, size_t max_payload_bytes) {
  ASSERT_EQ(frame.offsets.size(), frame.slices.size() + 1);
  EXPECT_EQ(frame.codec, codec);
  for (size_t i = 0; i < frame.slices.size(); ++i) {
    EXPECT_EQ(frame.slices[i].slice, i);
    EXPECT_EQ(frame.slices[i].slice_count, frame.slices.size());
    EXPECT_EQ(frame.slices[i].codec, codec);
    ASSERT_LE(frame.payload(i).size(), max_payload_bytes);
  }
}

// Decodes the slices in random order. Each must write exactly its own words, and all together every word once.
void expect_comes_back(const Mask& mask, const EncodedMask& frame) {
  std::vector<size_t> order(frame.slices.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  std::vector<uint64_t> words(mask.words.size(), kCanary);
  std::vector<uint8_t> covered(mask.words.size());
  for (const size_t slice : order) {
    const auto decoded = decode_slice(frame.slices[slice], frame.payload(slice), mask.grid, words);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    for_words(frame.slices[slice], mask.grid, [&](size_t word) { ++covered[word]; });
  }
  EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](uint8_t times) { return times == 1; }));
  EXPECT_TRUE(words == mask.words);
}

void expect_round_trip(const Mask& mask, size_t max_payload_bytes = kMaxSlicePayloadBytes) {
  for (const CodecId codec : kCodecs) {
    SCOPED_TRACE(testing::Message() << mask.grid.width << "x" << mask.grid.height << " with " << mask.grid.planes
                                    << " lights, codec " << int(codec) << ", payloads to " << max_payload_bytes);
    const EncodedMask frame = encoded(mask, codec, max_payload_bytes);
    expect_sound(frame, codec, max_payload_bytes);
    expect_comes_back(mask, frame);
  }
}

TEST(Codec, EverySizeComesBackAsItWas) {
  constexpr std::pair<uint32_t, uint32_t> kSizes[] = {{1, 1},  {8, 8},   {9, 8},    {7, 17},
                                                      {64, 1}, {1, 300}, {123, 77}, {200, 120}};
  for (const auto& [width, height] : kSizes) {
    for (const uint32_t lights : {1u, 3u, 32u, 33u, 64u}) {
      const TileGrid grid{width, height, lights};
      expect_round_trip(tests::all_dark(grid));
      expect_round_trip(tests::all_lit(grid));
      expect_round_trip(tests::noise(grid, lights), kMinPayloadBytes);
      expect_round_trip(tests::room(grid, lights));
    }
  }
}

TEST(Codec, ManyLightsAreSplitWhereATileDoesNotFit) {
  for (const uint32_t lights : {100u, 112u, 113u, 114u, 127u, 128u, 129u, 200u, kMaxLights}) {
    const TileGrid grid{40, 24, lights};
    for (const size_t payload : {kMinPayloadBytes, kMaxSlicePayloadBytes, size_t{1400}, size_t{9000}}) {
      expect_round_trip(tests::noise(grid, lights), payload);
      expect_round_trip(tests::checkerboard(grid, 3), payload);
    }
  }
}

TEST(Codec, PicturesOfUsualSizeComeBackAsTheyWere) {
  const TileGrid grid{1920, 1080, 3};
  expect_round_trip(tests::room(grid, 1));
  expect_round_trip(tests::checkerboard(grid, 8));
  expect_round_trip(tests::noise({1280, 720, 2}, 1));
  expect_round_trip(tests::foliage({1000, 564, 2}, 1));
}

TEST(Codec, TheLargestPictureComesBackAsItWas) {
  const Mask mask = tests::make_mask({kMaxSide, 4320, 1},
                                     [](uint32_t x, uint32_t y, uint32_t) { return ((x + 2 * y) >> 9 & 1) != 0; });
  expect_round_trip(mask);
}

TEST(Codec, RandomWordsComeBackAsTheyWere) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 150; ++i) {
    const TileGrid grid{static_cast<uint32_t>(1 + random() % 160), static_cast<uint32_t>(1 + random() % 160),
                        static_cast<uint32_t>(1 + random() % 20)};
    Mask mask{grid, std::vector<uint64_t>(grid.word_count())};
    uint64_t word = 0;
    for (uint64_t& w : mask.words) {  // runs of equal words between random ones
      if (random() % 5 == 0) word = random() % 2 ? random() : 0 - random() % 2;
      w = word;
    }
    expect_round_trip(mask, kMinPayloadBytes + random() % 3000);
  }
}

// A packed frame gives the same bytes as the unpacked one.
TEST(Codec, PackedFramesAreCodedAsTheyUnpack) {
  std::mt19937_64 random(4);
  for (const Mask& mask : {tests::foliage({300, 170, 3}, 1), tests::noise({123, 77, 2}, 2),
                           tests::all_lit({64, 64, 1}), tests::all_dark({640, 480, 0})}) {
    std::vector<uint64_t> care(mask.words.size());
    for (uint64_t& c : care) c = random() % 3 == 0 ? 0 : random() % 2 == 0 ? ~uint64_t{0} : random();
    const PackedMask packed(mask.view(), care);
    const Mask filled{mask.grid, unpacked(packed.view())};
    for (const CodecId codec : kPlainCodecs) {
      FrameEncoder encoder;
      EncodedMask frame;
      ASSERT_TRUE(encoder.encode(packed.view(), codec, kMaxSlicePayloadBytes, frame));
      EXPECT_EQ(frame.bytes, encoded(filled, codec).bytes);
      expect_sound(frame, codec, kMaxSlicePayloadBytes);
      expect_comes_back(filled, frame);
    }
  }
}

TEST(Codec, AFrameWithoutLightsHasNoSlices) {
  for (const CodecId codec : kCodecs) {
    EXPECT_TRUE(encoded(tests::all_dark({640, 480, 0}), codec).slices.empty());
  }
}

TEST(Codec, AnEncoderKeepsNothingFromTheFrameBefore) {
  const Mask large = tests::room({640, 480, 5}, 1);
  const Mask small = tests::room({100, 50, 2}, 2);
  FrameEncoder encoder;
  EncodedMask frame;
  for (const CodecId codec : {CodecId::tiles_lz4, CodecId::tiles_context, CodecId::raw32_lz4, CodecId::tiles_lz4}) {
    for (const Mask* mask : {&large, &small, &large}) {
      ASSERT_TRUE(encoder.encode(mask->view(), codec, kMaxSlicePayloadBytes, frame).has_value());
      const EncodedMask fresh = encoded(*mask, codec);
      EXPECT_EQ(frame.slices, fresh.slices);
      EXPECT_EQ(frame.bytes, fresh.bytes);
      EXPECT_EQ(frame.offsets, fresh.offsets);
    }
  }
}

TEST(Codec, SlicesAreNearlyFull) {
  const EncodedMask frame = encoded(tests::foliage({1280, 720, 3}, 1), CodecId::tiles_lz4);
  ASSERT_GT(frame.slices.size(), 10u);
  const size_t room = (frame.slices.size() - 1) * kMaxSlicePayloadBytes;
  EXPECT_GT(frame.offsets[frame.slices.size() - 1], room * 9 / 10);
}

TEST(Codec, TilesTakeLessThanAThirdOfTheBaseline) {
  const Mask mask = tests::foliage({960, 540, 3}, 1);
  EXPECT_LT(encoded(mask, CodecId::tiles_lz4).bytes.size() * 3, encoded(mask, CodecId::raw32_lz4).bytes.size());
}

TEST(Codec, MoreSlicesThanAHeaderCanNumberAreAnError) {
  const TileGrid grid{kMaxSide, 4320, 9};
  Mask mask{grid, std::vector<uint64_t>(grid.word_count())};
  std::mt19937_64 random(4);
  for (uint64_t& word : mask.words) word = random();
  FrameEncoder encoder;
  EncodedMask frame;
  EXPECT_FALSE(encoder.encode(mask.view(), CodecId::tiles_lz4, kMinPayloadBytes, frame).has_value());
  EXPECT_TRUE(frame.slices.empty());
  EXPECT_TRUE(frame.bytes.empty());
  EXPECT_EQ(frame.offsets, std::vector<size_t>{0});
}

// Decodes into words full of canaries. Those outside the slice must survive, whether it decodes or not.
bool decode_beside_canaries(const SliceHeader& slice, std::span<const uint8_t> payload, const TileGrid& grid) {
  std::vector<uint64_t> words(grid.word_count(), kCanary);
  const bool decoded = decode_slice(slice, payload, grid, words).has_value();
  const bool inside = size_t{slice.first_tile} + slice.tile_count <= grid.tile_count() &&
                      size_t{slice.first_light} + slice.light_count <= grid.planes;
  EXPECT_TRUE(inside || !decoded);
  if (inside) for_words(slice, grid, [&](size_t word) { words[word] = kCanary; });
  EXPECT_TRUE(std::all_of(words.begin(), words.end(), [](uint64_t word) { return word == kCanary; }));
  return decoded;
}

TEST(Codec, DamagedPayloadsTouchNoOtherTiles) {
  const Mask mask = tests::foliage({400, 240, 4}, 1);
  std::mt19937_64 random(5);
  for (const CodecId codec : kCodecs) {
    const EncodedMask frame = encoded(mask, codec, kMinPayloadBytes);
    size_t refused = 0;
    for (int i = 0; i < 4000; ++i) {
      const size_t slice = random() % frame.slices.size();
      std::vector<uint8_t> payload(frame.payload(slice).begin(), frame.payload(slice).end());
      for (uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
        payload[random() % payload.size()] ^= static_cast<uint8_t>(1u << random() % 8);
      }
      if (random() % 4 == 0) payload.resize(random() % payload.size());
      refused += !decode_beside_canaries(frame.slices[slice], payload, mask.grid);
    }
    // A flipped bit of tiles_context gives other tiles; only the datagram's seal detects it.
    EXPECT_TRUE(codec == CodecId::tiles_context || refused > 500) << refused;
  }
}

TEST(Codec, DamagedHeadersTouchNoOtherTiles) {
  const Mask mask = tests::room({200, 120, 4}, 1);
  const EncodedMask frame = encoded(mask, CodecId::tiles_lz4);
  std::mt19937_64 random(6);
  for (int i = 0; i < 4000; ++i) {
    const size_t slice = random() % frame.slices.size();
    SliceHeader header = frame.slices[slice];
    const auto any = [&] { return static_cast<uint32_t>(random() >> (random() % 64)); };
    switch (random() % 5) {
      case 0: header.first_tile = any(); break;
      case 1: header.tile_count = any(); break;
      case 2: header.first_light = static_cast<uint16_t>(any()); break;
      case 3: header.light_count = static_cast<uint16_t>(any()); break;
      default: header.codec = static_cast<CodecId>(any());
    }
    decode_beside_canaries(header, frame.payload(slice), mask.grid);
  }
}

TEST(Codec, RandomPayloadsTouchNoOtherTiles) {
  const TileGrid grid{64, 64, 3};
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) {
    SliceHeader header;
    header.tile_count = 1 + static_cast<uint32_t>(random() % 64);
    header.light_count = 3;
    header.codec = kCodecs[random() % std::size(kCodecs)];
    header.first_tile = static_cast<uint32_t>(random() % (65 - header.tile_count));
    std::vector<uint8_t> payload(random() % 100);
    for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random() % 4 ? random() % 20 : random());
    if (!payload.empty()) payload[0] = static_cast<uint8_t>(random() % 3);
    decode_beside_canaries(header, payload, grid);
  }
}

TEST(Codec, EveryTruncationIsAnError) {
  const Mask mask = tests::foliage({200, 120, 2}, 1);
  for (const CodecId codec : kPlainCodecs) {
    const EncodedMask frame = encoded(mask, codec);
    for (size_t slice = 0; slice < frame.slices.size(); ++slice) {
      for (size_t size = 0; size < frame.payload(slice).size(); ++size) {
        EXPECT_FALSE(decode_beside_canaries(frame.slices[slice], frame.payload(slice).first(size), mask.grid));
      }
    }
  }
}

TEST(Codec, AnLz4BlockThatUnpacksToTooMuchIsAnError) {
  // One literal, then a match of a megabyte.
  std::vector<uint8_t> bomb = {1, 0x1f, 0, 1, 0};
  bomb.resize(bomb.size() + (1 << 20) / 255, 0xff);
  bomb.insert(bomb.end(), {0, 0x50, 0, 0, 0, 0, 0});
  SliceHeader header;
  header.tile_count = 4;
  header.light_count = 1;
  EXPECT_FALSE(decode_beside_canaries(header, bomb, {32, 8, 1}));
}

}  // namespace
}  // namespace gnomon::protocol
