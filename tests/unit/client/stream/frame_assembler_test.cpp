#include "client/stream/frame_assembler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "protocol/split_frame.h"
#include "tests/unit/client/stream/sliced.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

constexpr TileGrid kGrid{200, 120, 3};

// A frame cut into the slices that datagrams carry.
struct Sliced {
  tests::Mask mask;
  protocol::EncodedMask encoded;

  Sliced(uint32_t frame, uint32_t seed)
      : mask(tests::noise(kGrid, seed)), encoded(tests::sliced(FrameId{frame}, mask.view(), 600)) {}
  size_t count() const { return encoded.slices.size(); }
  protocol::FrameSlice slice(size_t i) const { return {encoded.slices[i], encoded.payload(i)}; }
};

TEST(FrameAssembler, GivesBackTheMaskInWhateverOrderSlicesArrive) {
  std::mt19937 random(1);
  FrameAssembler assembler(kGrid);
  for (uint32_t frame = 1; frame <= 20; ++frame) {
    const Sliced sliced(frame, frame);
    ASSERT_GT(sliced.count(), 5u);
    std::vector<size_t> order(sliced.count());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    for (size_t i = 0; i < order.size(); ++i) {
      const bool last = i + 1 == order.size();
      EXPECT_EQ(assembler.add(sliced.slice(order[i])), last ? SliceOutcome::completed : SliceOutcome::stored);
    }
    auto finished = assembler.take_finished();
    ASSERT_TRUE(finished);
    EXPECT_EQ(finished->frame, FrameId{frame});
    EXPECT_TRUE(finished->complete());
    EXPECT_TRUE(finished->missing_tiles().empty());
    EXPECT_EQ(finished->words, sliced.mask.words);
    assembler.recycle(std::move(*finished));
  }
}

TEST(FrameAssembler, TakesSlicesThatWereDecodedElsewhere) {
  const Sliced sliced(1, 3);
  FrameAssembler assembler(kGrid);
  for (size_t i = 0; i < sliced.count(); ++i) {
    const auto& header = sliced.encoded.slices[i];
    std::vector<uint64_t> own;
    for (uint32_t light = header.first_light; light < header.first_light + header.light_count; ++light) {
      const auto first = sliced.mask.words.begin() + light * kGrid.tile_count() + header.first_tile;
      own.insert(own.end(), first, first + header.tile_count);
    }
    EXPECT_EQ(assembler.add_decoded(sliced.slice(i), std::span(own).first(own.size() - 1)),
              SliceOutcome::malformed);
    const bool last = i + 1 == sliced.count();
    EXPECT_EQ(assembler.add_decoded(sliced.slice(i), own), last ? SliceOutcome::completed : SliceOutcome::stored);
    EXPECT_EQ(assembler.add_decoded(sliced.slice(i), own), last ? SliceOutcome::late : SliceOutcome::duplicate);
  }
  EXPECT_EQ(assembler.take_finished()->words, sliced.mask.words);
}

TEST(FrameAssembler, NamesTheTilesOfALostSliceAndLeavesThemLit) {
  const Sliced sliced(1, 7);
  for (size_t lost = 0; lost < sliced.count(); ++lost) {
    FrameAssembler assembler(kGrid);
    for (size_t i = 0; i < sliced.count(); ++i) {
      if (i == lost) continue;
      EXPECT_EQ(assembler.add(sliced.slice(i)), SliceOutcome::stored);
    }
    EXPECT_FALSE(assembler.take_finished());
    assembler.give_up(FrameId{1});
    const auto finished = assembler.take_finished();
    ASSERT_TRUE(finished);
    EXPECT_FALSE(finished->complete());

    const auto& header = sliced.encoded.slices[lost];
    std::vector<uint32_t> expected(header.tile_count);
    for (uint32_t t = 0; t < header.tile_count; ++t) expected[t] = header.first_tile + t;
    EXPECT_EQ(finished->missing_tiles(), expected);
    for (size_t word = 0; word < kGrid.word_count(); ++word) {
      const uint64_t wanted = finished->arrived[word] ? sliced.mask.words[word] : ~uint64_t{0};
      ASSERT_EQ(finished->words[word], wanted) << "word " << word << ", slice " << lost << " lost";
    }
  }
}

TEST(FrameAssembler, DuplicatesChangeNothing) {
  const Sliced sliced(1, 3);
  FrameAssembler assembler(kGrid);
  for (size_t i = 0; i + 1 < sliced.count(); ++i) {
    EXPECT_EQ(assembler.add(sliced.slice(i)), SliceOutcome::stored);
    EXPECT_EQ(assembler.add(sliced.slice(i)), SliceOutcome::duplicate);
  }
  EXPECT_EQ(assembler.add(sliced.slice(sliced.count() - 1)), SliceOutcome::completed);
  EXPECT_EQ(assembler.add(sliced.slice(0)), SliceOutcome::late);
  EXPECT_EQ(assembler.take_finished()->words, sliced.mask.words);
  EXPECT_FALSE(assembler.take_finished()) << "a frame is handed over once";
}

TEST(FrameAssembler, KeepsTwoInterleavedFramesApart) {
  const Sliced older(4, 1), newer(5, 2);
  FrameAssembler assembler(kGrid);
  for (size_t i = 0; i < std::max(older.count(), newer.count()); ++i) {
    if (i < newer.count()) assembler.add(newer.slice(i));
    if (i < older.count()) assembler.add(older.slice(i));
  }
  std::vector<AssembledFrame> finished;
  while (auto frame = assembler.take_finished()) finished.push_back(std::move(*frame));
  ASSERT_EQ(finished.size(), 2u);
  for (const auto& frame : finished) {
    EXPECT_TRUE(frame.complete());
    EXPECT_EQ(frame.words, frame.frame == FrameId{4} ? older.mask.words : newer.mask.words);
  }
}

TEST(FrameAssembler, GivesUpTheOldestWhenTooManyAreOpen) {
  constexpr size_t kOpen = 3;
  FrameAssembler assembler(kGrid, kOpen);
  for (uint32_t frame = 10; frame < 100; ++frame) {
    EXPECT_EQ(assembler.add(Sliced(frame, frame).slice(0)), SliceOutcome::stored);
    const auto finished = assembler.take_finished();
    if (frame < 10 + kOpen) {
      EXPECT_FALSE(finished);
    } else {
      ASSERT_TRUE(finished);
      EXPECT_EQ(finished->frame.value, frame - kOpen);
      EXPECT_FALSE(finished->complete());
    }
  }
  // Slices of frames older than the open ones are late, whether their frame was given up or never began.
  EXPECT_EQ(assembler.add(Sliced(96, 96).slice(1)), SliceOutcome::late);
  EXPECT_EQ(assembler.add(Sliced(9, 9).slice(1)), SliceOutcome::late);
  EXPECT_FALSE(assembler.take_finished());
}

TEST(FrameAssembler, RefusesSlicesThatContradictGridOrFrame) {
  const Sliced sliced(1, 5);
  FrameAssembler assembler(kGrid);
  const auto with = [&](auto change) {
    auto slice = sliced.slice(1);
    change(slice.header);
    return assembler.add(slice);
  };
  EXPECT_EQ(assembler.add(sliced.slice(0)), SliceOutcome::stored);
  EXPECT_EQ(with([](auto& h) { h.slice_count = 0; }), SliceOutcome::malformed);
  EXPECT_EQ(with([](auto& h) { h.slice_count += 1; }), SliceOutcome::late);
  EXPECT_EQ(with([](auto& h) { h.slice = h.slice_count; }), SliceOutcome::malformed);
  EXPECT_EQ(with([](auto& h) { h.first_tile = kGrid.tile_count(); }), SliceOutcome::malformed);
  EXPECT_EQ(with([](auto& h) { h.tile_count = 0xffffffff; }), SliceOutcome::malformed);
  EXPECT_EQ(with([](auto& h) { h.light_count = 4; }), SliceOutcome::malformed);
  EXPECT_EQ(with([](auto& h) { h.first_light = 0xffff; }), SliceOutcome::malformed);
  // The frame is unharmed.
  for (size_t i = 1; i < sliced.count(); ++i) assembler.add(sliced.slice(i));
  EXPECT_EQ(assembler.take_finished()->words, sliced.mask.words);
}

// A slice that arrives so late that the frame to which it refers is not kept any more.
TEST(FrameAssembler, ASliceWhoseReferenceIsGoneIsAsGoodAsLost) {
  const auto mask = tests::noise(kGrid, 5);
  const auto reference = std::make_shared<protocol::MaskReference>(FrameId{1}, mask.view());
  auto split = protocol::SplitFrame::of_context(
      PackedMask(mask.view(), std::vector<uint64_t>(mask.words.size(), ~uint64_t{0})).view(), 1100, reference);
  for (size_t unit = 0; unit < split.unit_count(); ++unit) split.encode(unit);
  protocol::EncodedMask encoded;
  ASSERT_TRUE(split.join(encoded));
  for (auto& header : encoded.slices) header.frame = FrameId{2};
  FrameAssembler assembler(kGrid);
  EXPECT_EQ(assembler.add({encoded.slices[0], encoded.payload(0)}), SliceOutcome::unreadable);
  EXPECT_EQ(assembler.add({encoded.slices[0], encoded.payload(0)}), SliceOutcome::unreadable) << "still missing";
}

TEST(FrameAssembler, AFrameWithAllSlicesAndAHoleIsMalformed) {
  const Sliced sliced(1, 5);
  FrameAssembler assembler(kGrid);
  for (size_t i = 0; i + 1 < sliced.count(); ++i) assembler.add(sliced.slice(i));
  auto again = sliced.slice(0);  // the last slice's number on the first one's tiles
  again.header.slice = static_cast<uint16_t>(sliced.count() - 1);
  EXPECT_EQ(assembler.add(again), SliceOutcome::malformed);
  const auto finished = assembler.take_finished();
  ASSERT_TRUE(finished);
  EXPECT_FALSE(finished->complete());
}

TEST(FrameAssembler, AnyBytesLeaveItStanding) {
  std::mt19937 random(9);
  FrameAssembler assembler(kGrid, 2);
  std::vector<uint8_t> payload(1100);
  uint64_t finished = 0;
  for (int round = 0; round < 20000; ++round) {
    protocol::SliceHeader header;
    header.frame = FrameId{static_cast<uint32_t>(random() % 8 + round / 100)};
    header.slice_count = static_cast<uint16_t>(random() % 6);
    header.slice = static_cast<uint16_t>(random() % 6);
    header.first_tile = static_cast<uint32_t>(random() % 400);
    header.tile_count = static_cast<uint32_t>(random() % 400);
    header.first_light = static_cast<uint16_t>(random() % 4);
    header.light_count = static_cast<uint16_t>(random() % 4);
    for (auto& byte : payload) byte = static_cast<uint8_t>(random());
    assembler.add({header, std::span(payload).first(random() % payload.size())});
    while (auto frame = assembler.take_finished()) {
      ++finished;
      ASSERT_EQ(frame->words.size(), kGrid.word_count());
      assembler.recycle(std::move(*frame));
    }
  }
  EXPECT_GT(finished, 0u);
}

}  // namespace
}  // namespace gnomon::client
