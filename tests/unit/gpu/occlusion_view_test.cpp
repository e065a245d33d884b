// The reference client's picture of ambient occlusion: counts of open segments scale the ambient light, and what a mask of
// half size leaves out is filled in from pixels beside it.
#include <gtest/gtest.h>

#include <cmath>

#include "gpu/picture/reference_view.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/plane_bits.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWide = 64, kHigh = 40;

// A square above a floor under a light that reaches nothing.
struct Ambient {
  scenes::ScenePtr scene = square_over_floor(point_light({9.0f, 9.0f, 9.0f}));
  CameraView camera = look_at({0.0f, 4.0f, 3.0f}, {0, 0, 0}, 0.5f, kWide, kHigh);
  std::unique_ptr<ReferenceView> view;
  LightPlanes planes;
  TileGrid grid;

  explicit Ambient(Occlusion occlusion) : planes({false}, {1, occlusion}), grid{kWide, kHigh, planes.total()} {
    auto made = ReferenceView::create(device_options(), scene);
    EXPECT_TRUE(made) << made.error().message;
    view = std::move(*made);
  }

  template <class Count>
  std::vector<uint64_t> mask(Count count) const {
    std::vector<uint64_t> words(grid.word_count());
    for (uint32_t y = 0; y < kHigh; ++y)
      for (uint32_t x = 0; x < kWide; ++x) {
        const uint32_t open = count(x, y);
        const uint32_t bits = open == kOcclusionSegments ? 0b1010u : open;  // what does not matter is anything
        set_plane_bits(words, grid, planes.first_of_occlusion(), 4, x, y, bits);
      }
    return words;
  }

  RgbaImage picture(const std::vector<uint64_t>& words, Samples samples = Samples::one, bool filter = false) {
    ShadeOptions options;
    options.tonemap = ShadeOptions::Tonemap::clamp;
    options.planes = planes;
    options.ambient = glm::vec3(0.8f);
    options.samples = samples;
    options.soft_filter = filter;
    auto image = [&]() -> Result<RgbaImage> {
      if (samples == Samples::one) return view->render(camera, kWide, kHigh, {grid, words}, options);
      const auto seen = (*view->reprojection())->see(camera, {grid, words}, {}, planes);
      if (!seen) return seen.error();
      return view->predict(camera, kWide, kHigh, *seen, options);
    }();
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }
};

double linear_of(uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

// How many of the pixels of surfaces have that share of the ambient light, 0 to 1.
double share_with(const RgbaImage& image, const RgbaImage& all, double share) {
  size_t shown = 0, right = 0;
  for (size_t i = 0; i < all.rgba.size(); i += 4) {
    if (all.rgba[i] <= 64) continue;
    ++shown;
    right += std::abs(linear_of(image.rgba[i]) - linear_of(all.rgba[i]) * share) < 0.006;
  }
  EXPECT_GT(shown, 1000u);
  return static_cast<double>(right) / static_cast<double>(shown);
}

bool counts(uint32_t x, uint32_t y) { return ((x | y) & 1) == 0; }

TEST(OcclusionView, CountsScaleTheAmbientLight) {
  Ambient given(Occlusion::full);
  const RgbaImage all = given.picture(given.mask([](auto, auto) { return kOcclusionSegments; }));
  for (const uint32_t open : {0u, 1u, 5u, 7u}) {
    const auto words = given.mask([=](auto, auto) { return open; });
    EXPECT_EQ(share_with(given.picture(words), all, open / 8.0), 1) << open;
    EXPECT_EQ(share_with(given.picture(words, Samples::one, true), all, open / 8.0), 1) << open;
  }
}

// Pixels without a number say anything; none of it shows.
TEST(OcclusionView, AtHalfSizeOnlyPixelsThatCountAreLookedAt) {
  Ambient given(Occlusion::half);
  for (const Samples samples : {Samples::one, Samples::four}) {
    const RgbaImage all = given.picture(given.mask([](auto, auto) { return kOcclusionSegments; }), samples);
    for (const uint32_t open : {0u, 3u, 7u}) {
      const auto words =
          given.mask([=](uint32_t x, uint32_t y) { return counts(x, y) ? open : (5 * x + 3 * y) % 9; });
      for (const bool filter : {false, true})
        EXPECT_GT(share_with(given.picture(words, samples, filter), all, open / 8.0), 0.97)
            << open << " but for pixels beside which none of their surface counts, " << filter;
    }
  }
}

TEST(OcclusionView, BetweenTwoThatCountLiesTheirMean) {
  Ambient given(Occlusion::half);
  const RgbaImage all = given.picture(given.mask([](auto, auto) { return kOcclusionSegments; }));
  // Stripes two pixels wide: those that count have 2 and 6 in turn, from left to right.
  const RgbaImage some =
      given.picture(given.mask([](uint32_t x, uint32_t y) { return counts(x, y) ? (x % 4 ? 6u : 2u) : 0u; }));
  size_t own = 0, between = 0, shown = 0;
  for (uint32_t y = 0; y < kHigh; ++y)
    for (uint32_t x = 0; x < kWide; ++x) {
      const size_t at = 4 * (size_t{y} * kWide + x);
      if (all.rgba[at] <= 64) continue;
      ++shown;
      const double share = linear_of(some.rgba[at]) / linear_of(all.rgba[at]);
      own += x % 2 == 0 && std::abs(share - (x % 4 ? 0.75 : 0.25)) < 0.01;
      between += x % 2 == 1 && std::abs(share - 0.5) < 0.01;
    }
  EXPECT_GT(own, shown * 46 / 100);
  EXPECT_GT(between, shown * 44 / 100);
}

}  // namespace
}  // namespace gnomon::test
