#include <gtest/gtest.h>

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "client/media/label.h"
#include "client/media/montage.h"
#include "client/media/png.h"

namespace gnomon::client {
namespace {

namespace fs = std::filesystem;

Picture gradient(uint32_t width, uint32_t height) {
  Picture picture(width, height);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      uint8_t* p = picture.pixel(x, y);
      p[0] = static_cast<uint8_t>(x + 1);
      p[1] = static_cast<uint8_t>(y + 1);
      p[2] = 77;
      p[3] = 255;
    }
  }
  return picture;
}

class PngFile : public testing::Test {
 protected:
  PngFile() : folder_(fs::temp_directory_path() / ("gnomon-png-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~PngFile() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(PngFile, ComesBackAsItWasWritten) {
  Picture picture = gradient(61, 37);
  for (uint32_t x = 0; x < 61; ++x) picture.pixel(x, 5)[3] = static_cast<uint8_t>(4 * x);
  ASSERT_TRUE(write_png(folder_ / "a.png", picture));
  const auto back = read_png(folder_ / "a.png");
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, picture);
}

TEST_F(PngFile, ErrorsNameTheFile) {
  const auto written = write_png(folder_ / "missing" / "a.png", gradient(2, 2));
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("missing/a.png"), std::string::npos);
  std::ofstream(folder_ / "no.png") << "this is no picture";
  const auto read = read_png(folder_ / "no.png");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("no.png"), std::string::npos);
}

TEST(Montage, CropKeepsItsPart) {
  const Picture shown = crop(gradient(60, 40), 10, 10, 40, 20);
  EXPECT_EQ(shown.width, 40u);
  EXPECT_EQ(shown.pixel(0, 0)[0], 11);
  EXPECT_EQ(shown.pixel(0, 0)[1], 11);
  EXPECT_EQ(shown.pixel(39, 19)[0], 50);
}

TEST(Montage, HoldsAPanelForEachLightAndTheShadedPictureUnscaled) {
  const Picture shaded = gradient(160, 90);
  EXPECT_EQ(montage({}, shaded), shaded);
  for (size_t lights : {1u, 3u, 8u, 40u}) {
    std::vector<Picture> panels(lights, Picture(160, 90));
    for (size_t i = 0; i < lights; ++i) {
      for (size_t p = 0; p < panels[i].rgba.size(); ++p)
        panels[i].rgba[p] = p % 4 == 3 ? 255 : static_cast<uint8_t>(100 + i);
    }
    const Picture whole = montage(panels, shaded);
    ASSERT_GE(whole.height, shaded.height);
    const uint32_t left = whole.width - shaded.width;
    for (uint32_t y = 0; y < shaded.height; ++y) {
      ASSERT_EQ(0, std::memcmp(whole.pixel(left, y), shaded.pixel(0, y), size_t{4} * shaded.width));
    }
    std::vector<bool> found(lights);
    for (uint32_t y = 0; y < whole.height; ++y) {
      for (uint32_t x = 0; x < left; ++x) {
        const uint8_t value = whole.pixel(x, y)[0];
        if (value >= 100 && value < 100 + lights) found[value - 100u] = true;
      }
    }
    for (size_t i = 0; i < lights; ++i) EXPECT_TRUE(found[i]) << "panel " << i << " of " << lights;
  }
}

TEST(Comparison, BesideKeepsBothAndDifferenceShowsWhereTheyPart) {
  const Picture a = gradient(20, 10);
  Picture b = a;
  b.pixel(7, 3)[1] += 9;
  const Picture both = beside(a, b);
  EXPECT_EQ(both.height, 10u);
  EXPECT_EQ(crop(both, 0, 0, 20, 10), a);
  EXPECT_EQ(crop(both, both.width - 20, 0, 20, 10), b);
  const Picture off = difference(a, b, 4);
  for (uint32_t y = 0; y < 10; ++y)
    for (uint32_t x = 0; x < 20; ++x) EXPECT_EQ(off.pixel(x, y)[1], x == 7 && y == 3 ? 36 : 0);
  EXPECT_EQ(difference(a, b, 100).pixel(7, 3)[1], 255) << "as strong as a byte can say";
}

TEST(Label, IsReadableWhereItStandsAndLeavesTheRestAlone) {
  Picture picture(200, 60), other(200, 60);
  write_label(picture, 20, 10, 190, "shown", 2);
  write_label(other, 20, 10, 190, "traced", 2);
  EXPECT_NE(picture, other);
  const auto count = [](const Picture& p, uint8_t value) {
    size_t found = 0;
    for (size_t i = 0; i < p.rgba.size(); i += 4) found += p.rgba[i] == value;
    return found;
  };
  EXPECT_GT(count(picture, 245), 100u) << "letters";
  for (uint32_t y = 0; y < 60; ++y) {
    for (uint32_t x = 0; x < 200; ++x) {
      const bool outside = x < 20 || y < 10 || x >= 190 || y >= 10 + 30;
      ASSERT_TRUE(!outside || picture.pixel(x, y)[0] == 0) << x << "," << y;
    }
  }
  Picture accented(200, 60), replaced(200, 60);  // the font has no such letters
  write_label(accented, 20, 10, 190, "Lumi\xc3\xa8re\x01\x7f", 2);
  write_label(replaced, 20, 10, 190, "Lumi??re??", 2);
  EXPECT_EQ(accented, replaced);
  // What does not fit is cut at `right`, and in a picture that is too small for any letter.
  Picture cut(200, 60), tiny(3, 2);
  write_label(cut, 20, 10, 40, "a long text that is cut", 2);
  for (uint32_t y = 0; y < 60; ++y) ASSERT_EQ(cut.pixel(40, y)[0], 0);
  write_label(tiny, 0, 0, 3, "nothing", 1);
}

}  // namespace
}  // namespace gnomon::client
