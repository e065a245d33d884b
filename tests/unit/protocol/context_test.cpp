// What tiles_context promises beyond what codec_test.cpp asks of every codec.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "protocol/codec.h"
#include "protocol/context/binary_coder.h"
#include "protocol/context/camera_motion.h"
#include "protocol/context/logistic.h"
#include "protocol/split_frame.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::protocol {
namespace {

using tests::Mask;

constexpr FrameId kBefore{77};

// The mask moved by some pixels, as after a turn of the camera.
Mask moved(const Mask& mask, int dx, int dy) {
  return tests::make_mask(mask.grid, [&](uint32_t x, uint32_t y, uint32_t light) {
    const auto inside = [](int at, uint32_t size) {
      return static_cast<uint32_t>(std::clamp(at, 0, static_cast<int>(size) - 1));
    };
    return mask.view().lit(inside(static_cast<int>(x) + dx, mask.grid.width),
                           inside(static_cast<int>(y) + dy, mask.grid.height), light);
  });
}

EncodedMask encoded(const PackedMaskView& mask, const MaskReference* reference,
                    size_t max_payload_bytes = kMaxSlicePayloadBytes) {
  FrameEncoder encoder;
  EncodedMask frame;
  const auto done = encoder.encode(mask, CodecId::tiles_context, max_payload_bytes, frame, reference);
  EXPECT_TRUE(done) << done.error().message;
  return frame;
}

PackedMask all_matters(const Mask& mask) {
  return PackedMask(mask.view(), std::vector<uint64_t>(mask.words.size(), ~uint64_t{0}));
}

ReferenceShelf shelf_of(const Mask& mask) {
  ReferenceShelf shelf;
  shelf.add(std::make_shared<MaskReference>(kBefore, mask.view()));
  return shelf;
}

// Decodes the slices, the last one first.
std::vector<uint64_t> decoded(const EncodedMask& frame, const TileGrid& grid, const ReferenceShelf* shelf) {
  std::vector<uint64_t> words(grid.word_count());
  for (size_t i = frame.slices.size(); i-- > 0;) {
    const auto result = decode_slice(frame.slices[i], frame.payload(i), grid, words, shelf);
    EXPECT_TRUE(result) << result.error().message;
    EXPECT_LE(frame.payload(i).size(), kMaxSlicePayloadBytes);
  }
  return words;
}

TEST(BinaryCoder, BitsOfAnyProbabilityComeBack) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 200; ++run) {
    std::vector<std::pair<bool, context::Probability>> bits(random() % 3000);
    for (auto& [bit, one] : bits) {
      one = random() % 3 == 0 ? 32 : random() % 2 == 0 ? 65503 : 1 + static_cast<uint32_t>(random() % 65535);
      bit = random() % 65536 < (random() % 4 == 0 ? 32768 : one);
    }
    std::vector<uint8_t> bytes;
    context::BinaryEncoder encoder(bytes);
    for (const auto& [bit, one] : bits) encoder.code(bit, one);
    const size_t most = encoder.size();
    encoder.finish();
    EXPECT_LE(bytes.size(), most);
    context::BinaryDecoder decoder(bytes);
    for (const auto& [bit, one] : bits) ASSERT_EQ(decoder.code(false, one), bit);
    EXPECT_TRUE(decoder.at_end());
  }
}

TEST(BinaryCoder, WhatCameAfterAMarkCanBeTakenBack) {
  std::mt19937_64 random(2);
  for (int run = 0; run < 200; ++run) {
    std::vector<uint8_t> bytes, alone;
    context::BinaryEncoder encoder(bytes), same(alone);
    const auto code = [&](auto& coder, uint64_t seed) {
      std::mt19937_64 bits(seed);
      for (uint64_t i = bits() % 200; i > 0; --i) coder.code(bits() % 5 == 0, 9000);
    };
    const uint64_t first = random(), second = random();
    code(encoder, first);
    code(same, first);
    const auto mark = encoder.mark();
    code(encoder, second);
    encoder.return_to(mark);
    encoder.finish();
    same.finish();
    ASSERT_EQ(bytes, alone);
  }
}

TEST(Logistic, SquashGivesTheProbability) {
  for (int stretched = -2000; stretched <= 2000; stretched += 7) {
    EXPECT_NEAR(context::squash(stretched), 65536.0 / (1.0 + std::exp(-stretched / 256.0)), 2.0) << stretched;
  }
  EXPECT_EQ(context::squash(0), 32768u);
  EXPECT_GT(context::squash(-100000), 0u);
  EXPECT_LT(context::squash(100000), 65536u);
}

TEST(Context, FreeBitsMayChangeAndNoOthers) {
  std::mt19937_64 random(4);
  for (const Mask& mask :
       {tests::foliage({300, 170, 3}, 1), tests::noise({123, 77, 2}, 2), tests::room({640, 360, 5}, 3)}) {
    std::vector<uint64_t> care(mask.words.size());
    for (uint64_t& c : care) c = random() % 3 == 0 ? 0 : random() % 2 == 0 ? ~uint64_t{0} : random();
    const PackedMask packed(mask.view(), care);
    const std::vector<uint64_t> words = decoded(encoded(packed.view(), nullptr), mask.grid, nullptr);
    for (size_t i = 0; i < words.size(); ++i) ASSERT_EQ((words[i] ^ mask.words[i]) & care[i], 0u);
  }
}

TEST(Context, WithAReferenceFramesComeBackAsTheyWere) {
  for (const TileGrid& grid : {TileGrid{640, 360, 3}, TileGrid{123, 77, 2}, TileGrid{8, 8, 1}, TileGrid{1, 300, 4},
                               TileGrid{40, 24, 64}}) {
    const Mask before = tests::foliage(grid, 1);
    const ReferenceShelf shelf = shelf_of(before);
    for (const Mask& mask : {before, moved(before, 9, -5), tests::noise(grid, 2), tests::all_lit(grid),
                             tests::all_dark(grid), tests::checkerboard(grid, 1)}) {
      const EncodedMask frame = encoded(all_matters(mask).view(), shelf.find(kBefore));
      EXPECT_EQ(decoded(frame, grid, &shelf), mask.words);
    }
  }
}

TEST(Context, AFrameThatIsSplitHasTheSameSlices) {
  const TileGrid grid{1280, 720, 4};
  const Mask mask = tests::noise(grid, 1), before = tests::foliage(grid, 1), sparse = moved(before, 3, 3);
  const auto reference = std::make_shared<MaskReference>(kBefore, before.view());
  for (const Mask* of : {&mask, &before, &sparse}) {
    for (const MaskReferencePtr& kept : {MaskReferencePtr(), MaskReferencePtr(reference)}) {
      const PackedMask packed = all_matters(*of);
      SplitFrame split = SplitFrame::of_context(packed.view(), kMaxSlicePayloadBytes, kept);
      std::vector<std::thread> threads;
      for (size_t unit = split.unit_count(); unit-- > 0;)
        threads.emplace_back([&split, unit] { split.encode(unit); });
      for (std::thread& thread : threads) thread.join();
      EncodedMask joined;
      ASSERT_TRUE(split.join(joined));
      const EncodedMask whole = encoded(packed.view(), kept.get());
      EXPECT_EQ(joined.slices, whole.slices);
      EXPECT_EQ(joined.bytes, whole.bytes);
      EXPECT_EQ(joined.offsets, whole.offsets);
      EXPECT_TRUE(std::equal(split.decoded().words.begin(), split.decoded().words.end(), of->words.begin()));
    }
  }
}

TEST(Context, AReferenceSavesBytes) {
  const Mask before = tests::foliage({960, 540, 3}, 1);
  const ReferenceShelf shelf = shelf_of(before);
  const Mask mask = moved(before, 7, 3);
  const size_t alone = encoded(all_matters(mask).view(), nullptr).bytes.size();
  const size_t referenced = encoded(all_matters(mask).view(), shelf.find(kBefore)).bytes.size();
  EXPECT_LT(referenced, alone / 2);
}

// Bytes of the frame's payloads and slice headers.
size_t cost(const EncodedMask& frame) { return frame.bytes.size() + frame.slices.size() * kSliceHeaderBytes; }

TEST(Context, AReferenceNeverCostsBytes) {
  const TileGrid grid{640, 360, 4};
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    const Mask before = tests::room(grid, seed);
    const ReferenceShelf shelf = shelf_of(before);
    for (const Mask& mask : {before, moved(before, 3, -2), moved(before, 60, 45), tests::room(grid, seed + 50),
                             tests::foliage(grid, seed), tests::noise(grid, seed), tests::all_lit(grid)}) {
      const EncodedMask referenced = encoded(all_matters(mask).view(), shelf.find(kBefore));
      EXPECT_LE(cost(referenced), cost(encoded(all_matters(mask).view(), nullptr))) << "seed " << seed;
      EXPECT_EQ(decoded(referenced, grid, &shelf), mask.words);
    }
  }
}

// A camera 90 degrees wide that looks along -Z, turned to the left by an angle (radians).
CameraView turned_left(double angle) {
  return {.orientation = {0, static_cast<float>(std::sin(angle / 2)), 0, static_cast<float>(std::cos(angle / 2))},
          .tan_up = 0.5f,
          .tan_down = 0.5f};
}

TEST(Context, NoiseThatItsReferenceHasIsTriedAlone) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    for (const TileGrid& grid :
         {TileGrid{8, 8, 1}, TileGrid{256, 8, 1}, TileGrid{264, 40, 1}, TileGrid{520, 8, 2}}) {
      const Mask mask = tests::noise(grid, seed);
      const ReferenceShelf shelf = shelf_of(mask);
      for (const size_t most : {kMinPayloadBytes, kMaxSlicePayloadBytes}) {
        const EncodedMask frame = encoded(all_matters(mask).view(), shelf.find(kBefore), most);
        EXPECT_EQ(decoded(frame, grid, &shelf), mask.words);
      }
    }
  }
}

TEST(CameraMotion, WhatACameraSeesIsFoundInTheOthersPicture) {
  const TileGrid grid{800, 400, 1};
  const context::CameraMotion turn(turned_left(0.1), turned_left(0), grid);
  EXPECT_EQ(turn.at(400, 200, 0), (context::Motion{-40, 0})) << "400 pixels, times the tangent of the angle";
  EXPECT_EQ(turn.at(400, 200, 3), turn.at(400, 200, 0)) << "near or far is the same to a camera that only turns";
  CameraView aside = turned_left(0);
  aside.position = {0.5f, 0, 0};
  const context::CameraMotion step(aside, turned_left(0), grid);
  EXPECT_EQ(step.at(100, 100, 0), (context::Motion{0, 0}));
  EXPECT_EQ(step.at(100, 100, 0.5f), (context::Motion{100, 0}));
  EXPECT_NEAR(step.nearness_step(100, 100, 4), 0.02f, 1e-4);
  const context::CameraMotion about(turned_left(0), turned_left(3.1), grid);
  EXPECT_FALSE(about.at(400, 200, 0)) << "it was behind the other camera";
}

TEST(Context, WhereTheCameraHasTurnedFarItsMotionFindsTheReference) {
  const TileGrid grid{1280, 720, 2};
  const Mask before = tests::foliage(grid, 1);
  constexpr int kPixels = 170;
  CameraView camera = turned_left(0);
  camera.tan_left = camera.tan_right = 0.1f;  // so narrow that a turn moves all of it by nearly the same
  camera.tan_up = camera.tan_down = 0.1f * 720 / 1280;
  const CameraView earlier = camera;
  camera.orientation = turned_left(std::atan(kPixels * 0.2 / 1280)).orientation;
  const Mask mask = moved(before, -kPixels, 0);
  const MaskReference reference(kBefore, before.view(), earlier);
  const ReferenceShelf shelf = shelf_of(before);
  const auto bytes = [&](const MaskReference& of, const std::optional<CameraView>& now) {
    FrameEncoder encoder;
    EncodedMask frame;
    EXPECT_TRUE(
        encoder.encode(all_matters(mask).view(), CodecId::tiles_context, kMaxSlicePayloadBytes, frame, &of, now));
    EXPECT_EQ(decoded(frame, grid, &shelf), mask.words);
    return frame.bytes.size();
  };
  EXPECT_LT(bytes(reference, camera), 0.6 * static_cast<double>(bytes(reference, {})));
}

// Cameras are only a hint to the search: wrong ones never change what is decoded.
TEST(Context, CamerasOfAnythingLoseNothing) {
  std::mt19937_64 random(6);
  std::normal_distribution<float> any(0, 1);
  const TileGrid grid{200, 120, 2};
  const Mask before = tests::foliage(grid, 1), mask = moved(before, 11, 4);
  const PackedMask packed = all_matters(mask);
  const ReferenceShelf shelf = shelf_of(before);
  const auto camera = [&] {
    CameraView made = turned_left(any(random) * 4);
    made.position = {any(random), any(random), any(random) * 1e4f};
    made.tan_left = -any(random);
    made.tan_right = 0.01f - made.tan_left + std::abs(any(random));
    return made;
  };
  for (int i = 0; i < 40; ++i) {
    const MaskReference reference(kBefore, before.view(), camera());
    FrameEncoder encoder;
    EncodedMask frame;
    ASSERT_TRUE(
        encoder.encode(packed.view(), CodecId::tiles_context, kMaxSlicePayloadBytes, frame, &reference, camera()));
    ASSERT_EQ(decoded(frame, grid, &shelf), mask.words);
  }
}

TEST(Context, AReferenceThatIsMissingOrAnotherIsAnError) {
  const TileGrid grid{320, 200, 2};
  const Mask before = tests::foliage(grid, 1);
  const ReferenceShelf shelf = shelf_of(before);
  const EncodedMask frame = encoded(all_matters(moved(before, 2, 1)).view(), shelf.find(kBefore));
  Mask damaged = before;
  damaged.words[damaged.words.size() / 2] ^= 1;
  ReferenceShelf other_shape_made;
  other_shape_made.add(std::make_shared<MaskReference>(kBefore, tests::foliage({320, 208, 2}, 1).view()));
  const ReferenceShelf empty, of_damaged = shelf_of(damaged), other_shape = other_shape_made;
  std::vector<uint64_t> words(grid.word_count(), 0x5555);
  for (const ReferenceShelf* wrong :
       {static_cast<const ReferenceShelf*>(nullptr), &empty, &of_damaged, &other_shape})
    for (size_t i = 0; i < frame.slices.size(); ++i)
      EXPECT_FALSE(decode_slice(frame.slices[i], frame.payload(i), grid, words, wrong));
  EXPECT_EQ(words, std::vector<uint64_t>(grid.word_count(), 0x5555));
}

TEST(Context, AShelfKeepsTheNewestFrames) {
  ReferenceShelf shelf;
  const Mask mask = tests::all_lit({8, 8, 1});
  for (uint32_t frame = 1; frame <= ReferenceShelf::kFrames + 3; ++frame)
    shelf.add(std::make_shared<MaskReference>(FrameId{frame}, mask.view()));
  EXPECT_FALSE(shelf.find(FrameId{3}));
  EXPECT_TRUE(shelf.find(FrameId{4}));
  EXPECT_TRUE(shelf.find(FrameId{ReferenceShelf::kFrames + 3}));
}

TEST(Context, DamagedSlicesWithAReferenceTouchNoOtherTiles) {
  const TileGrid grid{400, 240, 3};
  const Mask before = tests::foliage(grid, 1);
  const ReferenceShelf shelf = shelf_of(before);
  const EncodedMask frame =
      encoded(all_matters(moved(before, -4, 6)).view(), shelf.find(kBefore), kMinPayloadBytes);
  constexpr uint64_t kCanary = 0xdeadbeefcafef00d;
  std::mt19937_64 random(5);
  for (int i = 0; i < 1500; ++i) {
    const size_t slice = random() % frame.slices.size();
    const SliceHeader& header = frame.slices[slice];
    std::vector<uint8_t> payload(frame.payload(slice).begin(), frame.payload(slice).end());
    for (uint64_t flips = 1 + random() % 3; flips > 0; --flips)
      payload[9 + random() % (payload.size() - 9)] ^= static_cast<uint8_t>(1u << random() % 8);
    if (random() % 4 == 0) payload.resize(9 + random() % (payload.size() - 9));
    if (random() % 16 == 0) payload.resize(random() % 12);
    std::vector<uint64_t> words(grid.word_count(), kCanary);
    (void)decode_slice(header, payload, grid, words, &shelf);
    for (size_t word = 0; word < words.size(); ++word) {
      const size_t light = word / grid.tile_count(), tile = word % grid.tile_count();
      const bool own =
          light - header.first_light < header.light_count && tile - header.first_tile < header.tile_count;
      ASSERT_TRUE(own || words[word] == kCanary);
    }
  }
}

TEST(Context, TheLargestPictureComesBackAsItWasWithAReference) {
  const auto stripes = [](uint32_t shift) {
    return tests::make_mask({kMaxSide, 4320, 1}, [shift](uint32_t x, uint32_t y, uint32_t) {
      return ((x + shift + 2 * y) >> 9 & 1) != 0;
    });
  };
  const Mask mask = stripes(30);
  const ReferenceShelf shelf = shelf_of(stripes(0));
  EXPECT_EQ(decoded(encoded(all_matters(mask).view(), shelf.find(kBefore)), mask.grid, &shelf), mask.words);
}

}  // namespace
}  // namespace gnomon::protocol
