// The reference client's picture against the formula, and against the mask.
#include "gpu/picture/reference_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 160, kHeight = 100;

struct Given {
  scenes::ScenePtr scene;
  CameraView camera = look_at({3.0f, 4.0f, 5.0f}, {0, 0, 0}, 0.9f, kWidth, kHeight);
  std::unique_ptr<ReferenceView> view;
  ProbedFrame frame;

  explicit Given(scenes::ScenePtr s) : scene(std::move(s)) {
    auto made = ReferenceView::create(device_options(), scene);
    EXPECT_TRUE(made) << made.error().message;
    view = std::move(*made);
    auto probe = SurfaceProbe::create(device_options("bvh"), scene);
    EXPECT_TRUE(probe) << probe.error().message;
    auto probed = probe->render(camera, kWidth, kHeight);
    EXPECT_TRUE(probed) << probed.error().message;
    frame = std::move(*probed);
  }
  RgbaImage render(const TileMaskView& mask, const ShadeOptions& options) {
    auto image = view->render(camera, kWidth, kHeight, mask, options);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }
};

ShadeOptions linear_options() {
  ShadeOptions options;
  options.tonemap = ShadeOptions::Tonemap::clamp;
  return options;
}

double to_srgb(double c) {
  c = std::min(1.0, std::max(0.0, c));
  return 255.0 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055);
}

TEST(ReferenceViewTest, ShadesByTheFormula) {
  scenes::Light light = point_light({0.7f, 3.0f, -0.4f});
  light.color = {1.0f, 0.5f, 0.25f};
  light.intensity = 9.0f;
  Given given(square_over_floor(light));
  const RgbaImage image = given.render(given.frame.mask(), linear_options());
  size_t lit = 0, dark = 0;
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      const SurfaceSample& s = given.frame.samples[size_t{y} * kWidth + x];
      const uint8_t* pixel = &image.rgba[4 * (size_t{y} * kWidth + x)];
      glm::vec3 expected(0.0f);
      if (s.triangle != 0 && given.frame.mask().lit(x, y, 0)) {
        const glm::vec3 to_light = light.position - s.position;
        const float n_dot_l = std::max(0.0f, glm::dot(glm::normalize(to_light), s.normal));
        expected = light.color * (light.intensity / glm::dot(to_light, to_light) * n_dot_l / 3.14159265f);
        ++lit;
      } else {
        ++dark;
      }
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(pixel[c], to_srgb(expected[c]), 1.5) << x << "," << y;
      ASSERT_EQ(pixel[3], 255);
    }
  EXPECT_GT(lit, 1000u);
  EXPECT_GT(dark, 1000u);
}

TEST(ReferenceViewTest, ALightBehindTheFaceIsDarkWhateverTheMaskSays) {
  Given given(square_over_floor(point_light({0, -3, 0})));
  const std::vector<uint64_t> all_lit(given.frame.words.size(), ~uint64_t{0});
  const RgbaImage image = given.render({given.frame.grid, all_lit}, linear_options());
  for (size_t i = 0; i < image.rgba.size(); i += 4) ASSERT_EQ(image.rgba[i], 0);
}

TEST(ReferenceViewTest, OnlyOneLightShowsThatLight) {
  auto scene = std::make_shared<scenes::Scene>(*square_over_floor(point_light({0.7f, 3.0f, -0.4f})));
  scene->lights.push_back(point_light({-2.0f, 2.0f, 1.0f}));
  Given given(scene);
  std::vector<uint64_t> first_only = given.frame.words;
  std::fill(first_only.begin() + given.frame.grid.tile_count(), first_only.end(), 0);
  ShadeOptions only = linear_options();
  only.only_light = 0;
  EXPECT_EQ(given.render(given.frame.mask(), only).rgba,
            given.render({given.frame.grid, first_only}, linear_options()).rgba);
  EXPECT_NE(given.render(given.frame.mask(), only).rgba, given.render(given.frame.mask(), linear_options()).rgba);
}

TEST(ReferenceViewTest, MaterialOfALightIsBlackWhereItDoesNotShine) {
  auto scene =
      std::make_shared<scenes::Scene>(*square_over_floor(spot_light({0.7f, 3.0f, -0.4f}, {0, -1, 0}, 0.8f)));
  Given given(scene);
  std::vector<uint64_t> any = given.frame.words;  // what does not matter may be 1
  for (size_t i = 0; i < any.size(); ++i) any[i] |= ~given.frame.valid_bits[i];
  ShadeOptions options = linear_options();
  options.view = ShadeOptions::View::material;
  options.only_light = 0;
  const RgbaImage image = given.render({given.frame.grid, any}, options);
  EXPECT_EQ(image.rgba, given.render(given.frame.mask(), options).rgba);
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x)
      ASSERT_EQ(image.rgba[4 * (size_t{y} * kWidth + x)] != 0, given.frame.mask().lit(x, y, 0)) << x << "," << y;
}

TEST(ReferenceViewTest, MaterialAndBackgroundNeedNoLight) {
  auto scene = std::make_shared<scenes::Scene>(*square_over_floor(point_light({0.7f, 3.0f, -0.4f})));
  scene->materials[0].base_color = {0.25f, 0.5f, 1.0f, 1.0f};
  Given given(scene);
  ShadeOptions options = linear_options();
  options.view = ShadeOptions::View::material;
  options.background = {0.1f, 0.2f, 0.3f};
  const RgbaImage image = given.render(given.frame.mask(), options);
  for (size_t i = 0; i < given.frame.samples.size(); ++i) {
    const uint32_t triangle = given.frame.samples[i].triangle;
    if (triangle > 2) continue;
    const glm::vec3 expected = triangle ? glm::vec3(0.25f, 0.5f, 1.0f) : options.background;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(image.rgba[4 * i + static_cast<size_t>(c)], to_srgb(expected[c]), 1.5);
  }
}

TEST(ReferenceViewTest, SuggestedExposureFollowsTheLight) {
  scenes::Light dim = point_light({0.7f, 3.0f, -0.4f}), bright = dim;
  bright.intensity = 100.0f;
  Given a(square_over_floor(dim)), b(square_over_floor(bright));
  const auto exposure_a = a.view->suggest_exposure(a.camera), exposure_b = b.view->suggest_exposure(b.camera);
  ASSERT_TRUE(exposure_a && exposure_b);
  EXPECT_NEAR(*exposure_a / *exposure_b, 100.0f, 1.0f);
}

TEST(ReferenceViewTest, RefusesAMaskOfAnotherShape) {
  Given given(square_over_floor(point_light({0.7f, 3.0f, -0.4f})));
  const TileGrid other{kWidth, kHeight, 2};
  const std::vector<uint64_t> words(other.word_count());
  EXPECT_FALSE(given.view->render(given.camera, kWidth, kHeight, {other, words}, {}));
  EXPECT_FALSE(given.view->render(given.camera, kWidth + 8, kHeight, given.frame.mask(), {}));
}

}  // namespace
}  // namespace gnomon::test
