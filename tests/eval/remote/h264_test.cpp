#include "tests/eval/remote/h264.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/media/video_file.h"

namespace gnomon::remote {
namespace {

// A gradient with a bright square that moves.
Picture scenery(uint32_t step) {
  Picture picture(128, 96);
  for (uint32_t y = 0; y < picture.height; ++y) {
    for (uint32_t x = 0; x < picture.width; ++x) {
      uint8_t* p = picture.pixel(x, y);
      const bool square = x - 3 * step < 16 && y - 40 < 16;
      p[0] = square ? 240 : static_cast<uint8_t>(x);
      p[1] = square ? 240 : static_cast<uint8_t>(2 * y);
      p[2] = square ? 240 : 90;
      p[3] = 255;
    }
  }
  return picture;
}

double psnr(const Picture& a, const Picture& b) {
  double sum = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i)
    if (i % 4 != 3) sum += std::pow(int{a.rgba[i]} - int{b.rgba[i]}, 2);
  return 10 * std::log10(255.0 * 255.0 / (sum / (static_cast<double>(a.rgba.size()) * 0.75)));
}

H264Encoder encoder() {
  auto made = H264Encoder::create({.width = 128, .height = 96, .fps = 30, .bit_per_s = 2e6});
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

TEST(H264, EachPictureComesAtOnceAndLooksLikeItself) {
  auto encode = encoder();
  auto decode = H264Decoder::create();
  ASSERT_TRUE(decode);
  for (uint32_t i = 0; i < 20; ++i) {
    const auto unit = encode.encode(scenery(i), i == 0);
    ASSERT_TRUE(unit) << unit.error().message;
    const auto picture = decode->decode(*unit);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_GT(psnr(*picture, scenery(i)), 32) << i;
    if (i > 0) {
      EXPECT_LT(psnr(*picture, scenery(i + 3)), 30) << "not some picture, this one";
    }
  }
}

TEST(H264, KeyPicturesDecodeAloneAndOthersDoNot) {
  auto encode = encoder();
  std::vector<std::vector<uint8_t>> units;
  for (uint32_t i = 0; i < 6; ++i) units.push_back(*encode.encode(scenery(i), i == 0 || i == 4));
  auto fresh = H264Decoder::create();
  EXPECT_FALSE(fresh->decode(units[2]));
  const auto picture = fresh->decode(units[4]);
  ASSERT_TRUE(picture);
  EXPECT_GT(psnr(*picture, scenery(4)), 32);
}

TEST(H264, ALowerRateMakesSmallerPictures) {
  auto encode = encoder();
  (void)encode.encode(scenery(0), true);
  const auto bytes_of = [&](double rate) {
    encode.set_rate(rate);
    size_t bytes = 0;
    for (uint32_t i = 0; i < 30; ++i) {
      Picture noisy = scenery(i);
      for (size_t at = 0; at < noisy.rgba.size(); ++at)
        noisy.rgba[at] ^= static_cast<uint8_t>((at * 2654435761u + i * 40503u) >> 13 & 63);
      bytes += encode.encode(noisy)->size();
    }
    return bytes;
  };
  const size_t many = bytes_of(4e6);
  EXPECT_LT(bytes_of(5e5), many / 3);
}

TEST(H264, AnyBytesGiveAPictureOrAnError) {
  auto encode = encoder();
  const auto unit = *encode.encode(scenery(0), true);
  for (size_t i = 0; i < unit.size(); i += 7) {
    auto decode = H264Decoder::create();
    auto damaged = unit;
    damaged[i] ^= 0x55;
    (void)decode->decode(damaged);
    (void)decode->decode(std::span(unit).first(i));
  }
  EXPECT_FALSE(H264Decoder::create()->decode({}));
}

TEST(H264, RefusesPicturesOfAnotherSize) { EXPECT_FALSE(encoder().encode(Picture(64, 64))); }

TEST(VideoFile, SaysWhereItCannotWrite) {
  const auto file = client::VideoFile::create("/nowhere/at/all.mp4", {});
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("/nowhere/at/all.mp4"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::remote
