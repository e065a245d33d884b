// Counts accumulate over masks: what several of them say of a surface is averaged, and what the newest contradicts is not.
#include <gtest/gtest.h>

#include <cmath>

#include "gpu/picture/reference_view.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 64, kHeight = 40;
constexpr uint32_t kMost = 16;

struct Shift {
  int x = 0, y = 0;  // pixels
};

// A floor under two lights, of which the second is an area light, and ambient light.
struct Given {
  std::shared_ptr<scenes::Scene> scene;
  LightPlanes planes;
  TileGrid grid;
  std::unique_ptr<ReferenceView> view;

  explicit Given(Occlusion occlusion = Occlusion::none, bool moves = false)
      : scene(std::make_shared<scenes::Scene>(*square_over_floor(point_light({9.0f, 9.0f, 9.0f})))),
        planes({false, true}, {kMost, occlusion}),
        grid{kWidth, kHeight, planes.total()} {
    scene->lights.push_back(point_light({-1.5f, 3.0f, 1.0f}));
    scene->lights.back().intensity = 6.0f;
    if (moves) {
      scene->moving_nodes = {swing({-1.5f, 3.0f, 1.0f}, {-1.2f, 3.0f, 1.0f})};
      scene->period = std::chrono::seconds(2);
      scene->lights.back().moved_by = 0;
    }
    auto made = ReferenceView::create(device_options(), scene);
    EXPECT_TRUE(made) << made.error().message;
    view = std::move(*made);
  }

  // From one eye, its pixels shifted: pixel (x, y) shows what (x + shift.x, y + shift.y) shows without.
  static CameraView camera(Shift shift = {}) {
    CameraView made = look_at({0.0f, 4.0f, 3.0f}, {0, 0, 0}, 0.5f, kWidth, kHeight);
    const float pixel = 2 * made.tan_up / kHeight;
    const float right = pixel * static_cast<float>(shift.x), down = pixel * static_cast<float>(shift.y);
    made.tan_left -= right;
    made.tan_right += right;
    made.tan_up -= down;
    made.tan_down += down;
    return made;
  }

  // The first light is dark; `light(x, y)` points of the second are seen, and `open(x, y)` segments are open.
  template <class Light, class Open>
  std::vector<uint64_t> words(Light light, Open open) const {
    std::vector<uint64_t> words(grid.word_count());
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        write(words, x, y, planes.first(1), kMost, light(x, y));
        if (planes.occlusion() != Occlusion::none)
          write(words, x, y, planes.first_of_occlusion(), kOcclusionSegments, open(x, y));
      }
    return words;
  }

  void write(std::vector<uint64_t>& words, uint32_t x, uint32_t y, uint32_t plane, uint32_t most,
             uint32_t n) const {
    const uint32_t below = planes_of(most) - 1;
    for (uint32_t i = 0; i <= below; ++i)
      if ((n >> (below - i)) & 1)
        words[size_t{plane + i} * grid.tile_count() + size_t{y / 8} * grid.tiles_x() + x / 8] |=
            uint64_t{1} << (y % 8 * 8 + x % 8);
  }

  template <class Light>
  SeenMasks see(Light light, Shift shift = {}) {
    return see(
        light, [](auto, auto) { return kOcclusionSegments; }, shift);
  }
  template <class Light, class Open>
  SeenMasks see(Light light, Open open, Shift shift) {
    auto seen = (*view->reprojection())->see(camera(shift), {grid, words(light, open)}, {}, planes);
    EXPECT_TRUE(seen) << seen.error().message;
    return std::move(*seen);
  }

  void accumulate(SeenMasks& newest, std::vector<SeenMasks> earlier) {
    const auto done = (*view->reprojection())->accumulate(newest, earlier);
    ASSERT_TRUE(done) << done.error().message;
  }

  RgbaImage picture(const SeenMasks& seen, Samples samples = Samples::one, bool filter = false) {
    ShadeOptions options;
    options.tonemap = ShadeOptions::Tonemap::clamp;
    options.planes = planes;
    options.samples = samples;
    options.soft_filter = filter;
    if (planes.occlusion() != Occlusion::none) options.ambient = glm::vec3(0.8f);
    auto image = view->predict(camera(), kWidth, kHeight, seen, options);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }
};

double linear(uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

// Root mean square of the difference of two pictures' shares of what `all` shows.
double apart(const RgbaImage& image, const RgbaImage& other, const RgbaImage& all) {
  double sum = 0;
  size_t shown = 0;
  for (size_t i = 0; i < all.rgba.size(); i += 4) {
    if (all.rgba[i] <= 64) continue;
    const double off = (linear(image.rgba[i]) - linear(other.rgba[i])) / linear(all.rgba[i]);
    sum += off * off;
    ++shown;
  }
  EXPECT_GT(shown, 500u);
  return std::sqrt(sum / static_cast<double>(shown));
}

// Counts that depend on the place in a 4x4 block alone; their mean is 7.5.
uint32_t grain(uint32_t x, uint32_t y) { return 6 + (5 * (x % 4 + 4 * (y % 4)) + 3) % 16 / 4; }

constexpr auto whole = [](auto, auto) { return kMost; };
constexpr auto dark = [](auto, auto) { return 0u; };

TEST(Accumulation, OfTheSameMasksIsTheSamePicture) {
  for (const Occlusion occlusion : {Occlusion::none, Occlusion::half, Occlusion::full}) {
    Given given(occlusion);
    const auto light = [](uint32_t x, uint32_t y) { return (3 * x + 5 * y) % (kMost + 1); };
    const auto open = [](uint32_t x, uint32_t y) { return (5 * x + 2 * y) % (kOcclusionSegments + 1); };
    const SeenMasks alone = given.see(light, open, {});
    for (const size_t earlier : {1, 2, 3}) {
      SeenMasks newest = given.see(light, open, {});
      given.accumulate(newest, std::vector<SeenMasks>(earlier, alone));
      ASSERT_TRUE(newest.shares);
      for (const Samples samples : {Samples::one, Samples::four})
        for (const bool filter : {false, true})
          EXPECT_EQ(given.picture(newest, samples, filter).rgba, given.picture(alone, samples, filter).rgba)
              << earlier << " " << filter;
    }
  }
}

TEST(Accumulation, OfMasksThatSawOtherPointsIsNearerToTheirMean) {
  Given given;
  const RgbaImage all = given.picture(given.see(whole));
  // All sixteen patterns of a block together, halves as two pixels in turn would show them.
  const RgbaImage seven = given.picture(given.see([](auto, auto) { return 7u; }));
  const RgbaImage eight = given.picture(given.see([](auto, auto) { return 8u; }));
  RgbaImage mean = seven;
  for (size_t i = 0; i < mean.rgba.size(); ++i)
    mean.rgba[i] = static_cast<uint8_t>((seven.rgba[i] + eight.rgba[i]) / 2);
  SeenMasks newest = given.see(grain);
  const double own = apart(given.picture(newest), mean, all);
  double before = own;
  std::vector<SeenMasks> earlier;
  for (const Shift shift : {Shift{1, 2}, Shift{2, -3}, Shift{-1, 1}}) {
    earlier.push_back(given.see(grain, shift));
    given.accumulate(newest, earlier);
    const double now = apart(given.picture(newest), mean, all);
    EXPECT_LT(now, before) << earlier.size();
    before = now;
  }
  EXPECT_LT(before, 0.7 * own) << "half of it if they were independent";
}

// At an edge sharper than the pixels around, other masks say what lies a fraction of a pixel beside it.
TEST(Accumulation, NextToASharpEdgeTheNewestStandsAlone) {
  Given given;
  const auto edge = [](uint32_t x, auto) { return x < kWidth / 2 ? 0u : kMost; };
  const auto beside = [](uint32_t x, auto) { return x < kWidth / 2 + 1 ? 0u : kMost; };
  const SeenMasks alone = given.see(edge);
  SeenMasks newest = given.see(edge);
  given.accumulate(newest, {given.see(beside)});
  EXPECT_EQ(given.picture(newest).rgba, given.picture(alone).rgba);
  const auto soft = [](uint32_t x, auto) { return x < kWidth / 2 ? 1u : kMost; };  // no pixel is wholly dark
  SeenMasks softer = given.see(soft);
  given.accumulate(softer, {given.see(beside)});
  EXPECT_NE(given.picture(softer).rgba, given.picture(given.see(soft)).rgba);
}

// A shadow that has gone, and one that has come.
TEST(Accumulation, WhatTheNewestMaskContradictsIsRejected) {
  Given given;
  const SeenMasks was_dark = given.see(dark), was_lit = given.see(whole);
  SeenMasks lit = given.see(whole), shaded = given.see(dark);
  given.accumulate(lit, {was_dark, was_dark, was_dark});
  EXPECT_EQ(given.picture(lit).rgba, given.picture(was_lit).rgba);
  given.accumulate(shaded, {was_lit, was_lit, was_lit});
  EXPECT_EQ(given.picture(shaded).rgba, given.picture(was_dark).rgba);
}

TEST(Accumulation, OnePointBeyondTheNeighboursStillCounts) {
  Given given;
  const auto even = [](uint32_t n) { return [n](auto, auto) { return n; }; };
  const RgbaImage all = given.picture(given.see(whole));
  SeenMasks newest = given.see(even(8));
  const RgbaImage alone = given.picture(newest);
  given.accumulate(newest, {given.see(even(9)), given.see(even(9)), given.see(even(9))});
  EXPECT_GT(apart(given.picture(newest), alone, all), 0.03) << "3/4 of a point more";
  for (const uint32_t too_far : {6u, 10u}) {
    given.accumulate(newest, {given.see(even(too_far))});
    EXPECT_EQ(given.picture(newest).rgba, alone.rgba) << too_far;
  }
}

TEST(Accumulation, WhatNoEarlierMaskShowsHasTheNewestAlone) {
  Given given;
  SeenMasks newest = given.see(grain);
  const RgbaImage alone = given.picture(newest);
  given.accumulate(newest, {given.see([](auto, auto) { return 8u; }, {int{kWidth} / 2, 0})});
  const RgbaImage some = given.picture(newest);
  size_t left = 0, right = 0;
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      const size_t at = 4 * (size_t{y} * kWidth + x);
      (x < kWidth / 2 ? left : right) += some.rgba[at] != alone.rgba[at];
    }
  EXPECT_EQ(left, 0u) << "not seen before";
  EXPECT_GT(right, 300u);
}

TEST(Accumulation, HalfSizeOcclusionTakesOnlyWhatCounts) {
  Given given(Occlusion::half);
  // Pixels without a number say anything.
  const auto open = [](uint32_t x, uint32_t y) {
    return ((x | y) & 1) != 0 ? (5 * x + 3 * y) % 9 : (x / 2 + y / 2) % 2 ? 5u : 3u;
  };
  const RgbaImage all = given.picture(given.see(dark));
  const RgbaImage mean = given.picture(given.see(dark, [](auto, auto) { return 4u; }, {}));
  SeenMasks newest = given.see(dark, open, {});
  const RgbaImage alone = given.picture(newest);
  given.accumulate(newest, {given.see(dark, open, {1, 2}), given.see(dark, open, {0, 1})});
  EXPECT_EQ(given.picture(newest).rgba, alone.rgba) << "by an odd number of pixels";
  given.accumulate(newest,
                   {given.see(dark, open, {2, 0}), given.see(dark, open, {4, 2}), given.see(dark, open, {2, 2})});
  EXPECT_LT(apart(given.picture(newest), mean, all), 0.6 * apart(alone, mean, all));
}

TEST(Accumulation, LightsThatMoveHaveTheNewestAlone) {
  for (const bool moves : {false, true}) {
    Given given(Occlusion::none, moves);
    SeenMasks newest = given.see(grain);
    const RgbaImage alone = given.picture(newest);
    given.accumulate(newest, {given.see([](auto, auto) { return 8u; })});
    EXPECT_EQ(given.picture(newest).rgba == alone.rgba, moves);
  }
}

TEST(Accumulation, SharesThatAreKnownAreShown) {
  Given given;
  const SeenMasks half = given.see([](auto, auto) { return kMost / 2; });
  SeenMasks known = given.see(dark);
  Reprojection& reprojection = **given.view->reprojection();
  EXPECT_FALSE(reprojection.give_shares(known, std::vector<uint32_t>(kWidth)));
  ASSERT_TRUE(reprojection.give_shares(known, std::vector<uint32_t>(kWidth * kHeight, kWholeShare / 2)));
  EXPECT_EQ(given.picture(known).rgba, given.picture(half).rgba);
}

TEST(Accumulation, RefusesMasksOfOtherShapes) {
  Given given;
  SeenMasks newest = given.see(grain), other = given.see(grain);
  Reprojection& reprojection = **given.view->reprojection();
  EXPECT_FALSE(reprojection.accumulate(newest, std::vector<SeenMasks>(4, other)));
  other.planes = {};
  EXPECT_FALSE(reprojection.accumulate(newest, std::vector<SeenMasks>(1, other)));
  EXPECT_FALSE(newest.shares);
}

}  // namespace
}  // namespace gnomon::test
