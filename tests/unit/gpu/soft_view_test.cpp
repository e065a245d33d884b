// The reference client's picture of soft shadows: counts of sample points in the place of bits.
#include <gtest/gtest.h>

#include <cmath>

#include "gpu/picture/reference_view.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/plane_bits.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 64, kHeight = 40;
constexpr uint32_t kSamples = 16;

// A floor under two lights, of which the second is an area light.
struct Given {
  scenes::ScenePtr scene;
  CameraView camera = look_at({0.0f, 4.0f, 3.0f}, {0, 0, 0}, 0.5f, kWidth, kHeight);
  std::unique_ptr<ReferenceView> view;
  LightPlanes planes{{false, true}, kSamples};
  TileGrid grid{kWidth, kHeight, planes.total()};

  Given() {
    auto made_scene = std::make_shared<scenes::Scene>(*square_over_floor(point_light({9.0f, 9.0f, 9.0f})));
    made_scene->lights.push_back(point_light({-1.5f, 3.0f, 1.0f}));
    made_scene->lights.back().intensity = 6.0f;
    scene = made_scene;
    auto made = ReferenceView::create(device_options(), scene);
    EXPECT_TRUE(made) << made.error().message;
    view = std::move(*made);
  }

  // The first light is dark; `count(x, y)` points of the second are seen.
  template <class Count>
  std::vector<uint64_t> mask(Count count) const {
    std::vector<uint64_t> words(grid.word_count());
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const uint32_t seen = count(x, y);
        const uint32_t bits = seen == kSamples ? 0b10101u : seen;  // what does not matter is anything
        set_plane_bits(words, grid, planes.first(1), 5, x, y, bits);
      }
    return words;
  }

  ShadeOptions options() const {
    ShadeOptions made;
    made.tonemap = ShadeOptions::Tonemap::clamp;
    made.planes = planes;
    return made;
  }

  RgbaImage picture(const std::vector<uint64_t>& words, const ShadeOptions& shading) {
    auto image = view->render(camera, kWidth, kHeight, {grid, words}, shading);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }
};

double linear(uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

TEST(SoftViewTest, CountsScaleTheLight) {
  Given given;
  const RgbaImage all = given.picture(given.mask([](auto, auto) { return kSamples; }), given.options());
  for (const uint32_t seen : {0u, 1u, 6u, 8u, 15u}) {
    const RgbaImage some = given.picture(given.mask([=](auto, auto) { return seen; }), given.options());
    size_t shown = 0;
    for (size_t i = 0; i < all.rgba.size(); i += 4) {
      shown += all.rgba[i] > 64;
      ASSERT_NEAR(linear(some.rgba[i]), linear(all.rgba[i]) * seen / kSamples, 0.006) << i / 4;
    }
    EXPECT_GT(shown, 500u);
  }
}

TEST(SoftViewTest, EachPixelHasItsOwnCountUnlessItIsFiltered) {
  Given given;
  const auto checkers = [](uint32_t x, uint32_t y) { return (x + y) % 2 ? kSamples : 0u; };
  const RgbaImage all = given.picture(given.mask([](auto, auto) { return kSamples; }), given.options());
  const RgbaImage exact = given.picture(given.mask(checkers), given.options());
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      const size_t at = 4 * (size_t{y} * kWidth + x);
      ASSERT_EQ(exact.rgba[at], checkers(x, y) ? all.rgba[at] : 0) << x << "," << y;
    }
  ShadeOptions filtered = given.options();
  filtered.soft_filter = true;
  EXPECT_EQ(given.picture(given.mask(checkers), filtered).rgba, exact.rgba)
      << "an edge that is sharper than the window";
  const auto grain = [](uint32_t x, uint32_t y) { return (x + y) % 2 ? kSamples - 2 : 2u; };
  const RgbaImage smooth = given.picture(given.mask(grain), filtered);
  size_t halves = 0, shown = 0;
  for (size_t at = 0; at < all.rgba.size(); at += 4) {
    if (all.rgba[at] <= 64) continue;
    ++shown;
    halves += std::abs(linear(smooth.rgba[at]) - linear(all.rgba[at]) / 2) < 0.01;
  }
  EXPECT_GT(halves, shown * 8 / 10) << "all but those at the edges of surfaces and of the picture";
  const RgbaImage even = given.picture(given.mask([](auto, auto) { return 6u; }), filtered);
  EXPECT_EQ(even.rgba, given.picture(given.mask([](auto, auto) { return 6u; }), given.options()).rgba);
}

TEST(SoftViewTest, PredictionTakesTheCountOfTheSourcePixel) {
  Given given;
  const auto words = given.mask([](uint32_t x, uint32_t) { return x * kSamples / kWidth; });
  const auto reprojection = given.view->reprojection();
  ASSERT_TRUE(reprojection) << reprojection.error().message;
  const auto seen = (*reprojection)->see(given.camera, {given.grid, words}, {}, given.planes);
  ASSERT_TRUE(seen) << seen.error().message;
  const auto predicted = given.view->predict(given.camera, kWidth, kHeight, *seen, given.options());
  ASSERT_TRUE(predicted) << predicted.error().message;
  EXPECT_EQ(predicted->rgba, given.picture(words, given.options()).rgba) << "from the same camera";
}

TEST(SoftViewTest, AMaskOfOtherPlanesIsRefused) {
  Given given;
  const auto words = given.mask([](auto, auto) { return 3u; });
  ShadeOptions hard = given.options();
  hard.planes = {};
  EXPECT_FALSE(given.view->render(given.camera, kWidth, kHeight, {given.grid, words}, hard));
}

}  // namespace
}  // namespace gnomon::test
