// Textures with mip levels, ambient light, sky, and four samples a pixel, in the reference client's picture.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "gpu/picture/reference_view.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 160, kHeight = 96;

// A floor of 8 x 8 metres at height 0.
std::shared_ptr<scenes::Scene> floor_scene(const scenes::Light& light) {
  auto scene = std::make_shared<scenes::Scene>(
      *make_scene({{-4, 0, -4}, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}}, {{0, 1, 2}, {0, 2, 3}}, {light}));
  scene->materials[0].base_color = glm::vec4(0.8f, 0.8f, 0.8f, 1.0f);
  return scene;
}

// The floor with checks of 8 texels each way, `repeats` times across.
std::shared_ptr<scenes::Scene> checked_floor(float repeats) {
  auto scene = floor_scene(point_light({0, 5, 0}));
  scenes::Texture texture;
  texture.width = texture.height = 64;
  for (uint32_t y = 0; y < 64; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      const uint8_t value = (x / 8 + y / 8) % 2 ? 255 : 0;
      texture.rgba.insert(texture.rgba.end(), {value, value, value, 255});
    }
  scene->textures.push_back(std::move(texture));
  scene->materials[0].base_color_texture = 0;
  scene->materials[0].base_color = glm::vec4(1.0f);
  scenes::Primitive& floor = scene->meshes[0].primitives[0];
  floor.uvs = {{0, 0}, {0, repeats}, {repeats, repeats}, {repeats, 0}};
  return scene;
}

struct Pictures {
  explicit Pictures(const scenes::ScenePtr& scene, glm::vec3 eye = {0.3f, 3.0f, 0.4f})
      : camera(look_at(eye, {0, 0, 0}, 0.9f, kWidth, kHeight)) {
    auto made = ReferenceView::create(device_options(), scene);
    EXPECT_TRUE(made) << made.error().message;
    view = std::move(*made);
    words.assign(grid.word_count(), ~uint64_t{0});
  }
  RgbaImage one_sample(const ShadeOptions& options) {
    auto image = view->render(camera, kWidth, kHeight, {grid, words}, options);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }
  RgbaImage four_samples(ShadeOptions options) {
    options.samples = Samples::four;
    const auto reprojection = view->reprojection();
    EXPECT_TRUE(reprojection);
    const auto seen = (*reprojection)->see(camera, {grid, words}, {});
    EXPECT_TRUE(seen) << seen.error().message;
    auto image = view->predict(camera, kWidth, kHeight, *seen, options);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }

  CameraView camera;
  TileGrid grid{kWidth, kHeight, 1};
  std::vector<uint64_t> words;
  std::unique_ptr<ReferenceView> view;
};

double linear(uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

ShadeOptions material_view() {
  ShadeOptions options;
  options.view = ShadeOptions::View::material;
  options.tonemap = ShadeOptions::Tonemap::clamp;
  return options;
}

// The share of pixels that are neither black nor white, and the mean light.
std::pair<double, double> greys_and_mean(const RgbaImage& image) {
  double grey = 0, sum = 0;
  for (size_t i = 0; i < image.rgba.size(); i += 4) {
    grey += image.rgba[i] > 20 && image.rgba[i] < 250;
    sum += linear(image.rgba[i]);
  }
  const double pixels = kWidth * kHeight;
  return {grey / pixels, sum / pixels};
}

// Of a scene that passes textures on as files: where there are no texels, a device reads none.
TEST(TexturedView, ATextureThatWasNotDecodedIsThePlainColour) {
  const auto passing = checked_floor(1);
  passing->textures[0].rgba.clear();
  passing->textures[0].encoded = {0xff, 0xd8};
  const auto plain = checked_floor(1);
  plain->materials[0].base_color_texture = scenes::kNone;
  EXPECT_EQ(Pictures(passing).one_sample(material_view()).rgba, Pictures(plain).one_sample(material_view()).rgba);
}

TEST(TexturedView, NearTexturesAreSharpAndFarOnesTheirMean) {
  const auto [near_grey, near_mean] = greys_and_mean(Pictures(checked_floor(1)).one_sample(material_view()));
  EXPECT_LT(near_grey, 0.25);
  EXPECT_NEAR(near_mean, 0.5, 0.06);
  // 400 checks in a metre: without levels, a moire of black and white.
  const auto [far_grey, far_mean] = greys_and_mean(Pictures(checked_floor(400)).one_sample(material_view()));
  EXPECT_GT(far_grey, 0.999);
  EXPECT_NEAR(far_mean, 0.5, 0.02);
}

TEST(TexturedView, AmbientLightReachesWhatNoLightDoes) {
  auto scene = floor_scene(point_light({0, 5, 0}));
  scene->surroundings.ambient_above = {0.5f, 0.25f, 0.125f};
  scene->surroundings.ambient_below = {9.0f, 9.0f, 9.0f};
  Pictures pictures(scene);
  std::fill(pictures.words.begin(), pictures.words.end(), 0);
  ShadeOptions options;
  options.tonemap = ShadeOptions::Tonemap::clamp;
  const RgbaImage image = pictures.one_sample(options);
  for (size_t i = 0; i < image.rgba.size(); i += 4) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(linear(image.rgba[i + static_cast<size_t>(c)]), 0.8 * scene->surroundings.ambient_above[c], 0.01);
    }
  }
}

TEST(TexturedView, TheSkyShowsInPicturesAloneAndOnlyWhereNoSurfaceIs) {
  auto scene = floor_scene(point_light({0, 5, 0}));
  scene->surroundings.has_sky = true;
  scene->surroundings.sky_zenith = {0.0f, 0.0f, 1.0f};
  scene->surroundings.sky_horizon = {0.0f, 1.0f, 0.0f};
  Pictures pictures(scene, {0.0f, 0.5f, 7.0f});
  std::fill(pictures.words.begin(), pictures.words.end(), 0);
  ShadeOptions options;
  options.tonemap = ShadeOptions::Tonemap::clamp;
  const RgbaImage image = pictures.one_sample(options);
  const uint8_t* top = &image.rgba[4 * (kWidth / 2)];
  EXPECT_EQ(top[0], 0);
  EXPECT_GT(top[1], 0);
  EXPECT_GT(top[2], 100) << "towards the zenith";
  const uint8_t* floor = &image.rgba[4 * (size_t{kHeight} * kWidth - kWidth / 2)];
  EXPECT_EQ(floor[1] + floor[2], 0) << "unlit, and no sky";
  const RgbaImage material = pictures.one_sample(material_view());
  EXPECT_EQ(material.rgba[4 * (kWidth / 2) + 2], 0);
}

// Where one surface fills the picture, each pixel's four samples take that pixel's own bit, whatever the neighbours' are.
TEST(FourSamples, OfOneSurfaceTakeTheirPixelsOwnBits) {
  Pictures pictures(floor_scene(point_light({0, 5, 0})));
  std::mt19937_64 random(3);
  for (uint64_t& word : pictures.words) word = random();
  ShadeOptions options;
  options.tonemap = ShadeOptions::Tonemap::clamp;
  const RgbaImage one = pictures.one_sample(options), four = pictures.four_samples(options);
  size_t lit = 0, dark = 0;
  for (size_t i = 0; i < one.rgba.size(); i += 4) {
    ASSERT_NEAR(one.rgba[i], four.rgba[i], 2) << "pixel " << i / 4 % kWidth << "," << i / 4 / kWidth;
    ++(one.rgba[i] > 0 ? lit : dark);
  }
  EXPECT_GT(lit, 1000u);
  EXPECT_GT(dark, 1000u);
}

TEST(FourSamples, SmoothTheEdgesOfSurfaces) {
  Pictures pictures(floor_scene(point_light({0, 5, 0})), {6.0f, 8.0f, 10.0f});
  const ShadeOptions options = material_view();
  const auto between = [](const RgbaImage& image) {
    std::map<uint8_t, size_t> count;
    for (size_t i = 0; i < image.rgba.size(); i += 4) ++count[image.rgba[i]];
    return count.size();
  };
  const size_t one = between(pictures.one_sample(options)), four = between(pictures.four_samples(options));
  EXPECT_EQ(one, 2u) << "floor and background";
  EXPECT_GE(four, 4u);
  EXPECT_LE(four, 5u) << "0 to 4 samples of a pixel show the floor";
}

}  // namespace
}  // namespace gnomon::test
