#include "tests/eval/remote/unit_stream.h"

#include <gtest/gtest.h>

#include <numeric>

namespace gnomon::remote {
namespace {

Unit unit(uint32_t number, bool key, size_t size = 3000) {
  Unit made{FrameId{10 * number}, number, key, std::vector<uint8_t>(size)};
  std::iota(made.bytes.begin(), made.bytes.end(), static_cast<uint8_t>(number));
  return made;
}

void add(UnitAssembler& to, const Unit& unit, size_t without = SIZE_MAX) {
  const auto frame = to_slices(unit, 1000);
  for (size_t i = frame.slices.size(); i-- > 0;)  // backwards: order does not matter
    if (i != without) {
      std::vector<uint8_t> body;
      protocol::append_frame_slice(body, frame.slices[i], frame.payload(i));
      const auto slice = protocol::decode_frame_slice(body);  // what a datagram may hold
      ASSERT_TRUE(slice);
      to.add(*slice);
    }
}

TEST(UnitStream, UnitsComeBackAsTheyWere) {
  UnitAssembler units;
  for (uint32_t i = 1; i < 9; ++i) {
    add(units, unit(i, i == 1, 500 * i));
    const auto back = units.take();
    ASSERT_TRUE(back);
    EXPECT_EQ(back->bytes, unit(i, false, 500 * i).bytes);
    EXPECT_EQ(back->frame, FrameId{10 * i});
    EXPECT_EQ(back->key, i == 1);
  }
}

TEST(UnitStream, KeepsTheirOrder) {
  UnitAssembler units;
  add(units, unit(2, false));
  EXPECT_FALSE(units.take());
  add(units, unit(1, true));
  EXPECT_EQ(units.take()->number, 1u);
  EXPECT_EQ(units.take()->number, 2u);
  EXPECT_FALSE(units.broken());
}

TEST(UnitStream, AfterAGapNothingComesBeforeAKeyUnit) {
  UnitAssembler units;
  add(units, unit(1, true));
  ASSERT_TRUE(units.take());
  add(units, unit(2, false), 1);
  for (uint32_t i = 3; i < 8; ++i) {
    add(units, unit(i, false));
    EXPECT_FALSE(units.take());
  }
  EXPECT_TRUE(units.broken());
  add(units, unit(8, true));
  const auto key = units.take();
  ASSERT_TRUE(key);
  EXPECT_EQ(key->number, 8u);
  EXPECT_FALSE(units.broken());
  add(units, unit(9, false));
  EXPECT_EQ(units.take()->number, 9u);
}

}  // namespace
}  // namespace gnomon::remote
