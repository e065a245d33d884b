#include "protocol/text.h"

#include <gtest/gtest.h>

namespace gnomon::protocol {
namespace {

TEST(WireText, TakesUtf8WithoutControlCharacters) {
  for (const char* text : {"", "gnomon-client 0.1", "~ !", "é", "語", "𝄞", "\xc2\xa0", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_TRUE(is_wire_text(text)) << text;
    EXPECT_EQ(wire_text(text, 1000), text);
  }
}

TEST(WireText, RefusesControlCharactersAndWhatIsNotUtf8) {
  const std::string bad[] = {
      "a\nb",
      "\t",
      std::string(1, '\0'),
      "\x7f",
      "\xc2\x85",  // control characters
      "\x80",
      "\xff",
      "\xc3",
      "a\xe2\x82",
      "\xe2\x28\xa1",  // stray and missing bytes
      "\xc0\xaf",
      "\xe0\x80\xaf",
      "\xf0\x80\x80\xaf",  // overlong
      "\xed\xa0\x80",
      "\xf4\x90\x80\x80",
      "\xf5\x80\x80\x80",  // surrogates, beyond U+10FFFF
  };
  for (const std::string& text : bad) {
    EXPECT_FALSE(is_wire_text(text)) << text;
    const std::string cleaned = wire_text(text, 1000);
    EXPECT_TRUE(is_wire_text(cleaned)) << cleaned;
    EXPECT_EQ(cleaned.size(), text.size()) << "one '?' for every byte at fault";
  }
  EXPECT_EQ(wire_text("a\nb\xff é", 1000), "a?b? é");
}

TEST(WireText, IsCutBetweenCharacters) {
  EXPECT_EQ(wire_text("abc", 2), "ab");
  EXPECT_EQ(wire_text("é語", 4), "é");
  EXPECT_EQ(wire_text("é語", 5), "é語");
  EXPECT_EQ(wire_text("é", 0), "");
}

}  // namespace
}  // namespace gnomon::protocol
