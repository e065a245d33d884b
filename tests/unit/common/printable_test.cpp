#include "common/printable.h"

#include <gtest/gtest.h>

namespace gnomon {
namespace {

TEST(Printable, WhatPeopleWriteStays) {
  for (const char* text : {"", "living_room", "scène 日本 🦊", "a\\b \"c\" d=e"}) {
    EXPECT_EQ(without_controls(text), text);
  }
}

TEST(Printable, ControlsOfEveryRangeAreWrittenOut) {
  EXPECT_EQ(without_controls("a\nb\x1b[31m\x7f"), "a\\u000ab\\u001b[31m\\u007f");
  EXPECT_EQ(without_controls(std::string_view("\0", 1)), "\\u0000");
  EXPECT_EQ(without_controls("\xc2\x80-\xc2\x85-\xc2\x9b-\xc2\x9f-\xc2\xa0"),
            "\\u0080-\\u0085-\\u009b-\\u009f-\xc2\xa0");
  EXPECT_EQ(without_controls("\u202e\u2028\u2066\u200f\ufeff"), "\\u202e\\u2028\\u2066\\u200f\\ufeff");
}

// A terminal that knows no UTF-8 takes single bytes from 0x80 on for controls.
TEST(Printable, BytesThatAreNoUtf8AreReplaced) {
  EXPECT_EQ(without_controls("\x9b\x33\x31m"), "\\ufffd31m");
  EXPECT_EQ(without_controls("\xc2"), "\\ufffd");
  EXPECT_EQ(without_controls("\xe2\x80"), "\\ufffd\\ufffd");
  EXPECT_EQ(without_controls("\xc0\x9b"), "\\ufffd\\ufffd") << "longer than it needs to be";
  EXPECT_EQ(without_controls("\xe0\x82\x9b"), "\\ufffd\\ufffd\\ufffd") << "longer than it needs to be";
  EXPECT_EQ(without_controls("\xed\xa0\x80"), "\\ufffd\\ufffd\\ufffd") << "half of a surrogate pair";
  EXPECT_EQ(without_controls("\xf4\x90\x80\x80"), "\\ufffd\\ufffd\\ufffd\\ufffd") << "beyond Unicode";
}

TEST(Printable, WhatIsKeptIsKept) { EXPECT_EQ(without_controls("a\nb\tc", "\n"), "a\nb\\u0009c"); }

}  // namespace
}  // namespace gnomon
