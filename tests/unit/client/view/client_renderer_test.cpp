// What a client that accumulates makes of one mask after another (ClientRenderer::Options::soft_accumulate).
#include "client/view/client_renderer.h"

#include <gtest/gtest.h>

#include "gpu/wire/translate.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::client {
namespace {

constexpr ViewSize kSize{64, 40, 0, 0};
constexpr uint32_t kMost = 16;

scenes::ScenePtr lamp_over_floor() {
  scenes::Light lamp = test::point_light({-1.5f, 3.0f, 1.0f});
  lamp.intensity = 6.0f;
  lamp.area = {scenes::LightShape::sphere, {0.1f, 0, 0}, {0, 0.1f, 0}};
  return test::square_over_floor(lamp);
}

struct Client {
  scenes::ScenePtr scene = lamp_over_floor();
  ClientRenderer renderer;

  explicit Client(bool accumulates)
      : renderer(ClientRenderer::create(scene, kSize,
                                        {.device = test::device_options().device, .soft_accumulate = accumulates})
                     .value()) {}

  // A mask in which every pixel sees that many points of the lamp.
  Picture shown(uint32_t index, uint32_t count, bool other_lights = false) {
    auto masks = std::make_shared<ReceivedMasks>();
    masks->index = index;
    masks->camera = gpu::to_wire(test::look_at({0.0f, 4.0f, 3.0f}, {0, 0, 0}, 0.5f, kSize.width, kSize.height));
    masks->lights = gpu::to_wire(scene->lights);
    if (other_lights) masks->lights[0].position[0] += 0.25f;
    AssembledFrame& mask = masks->mask;
    mask.planes = LightPlanes({true}, kMost);
    mask.grid = {kSize.width, kSize.height, mask.planes.total()};
    for (uint32_t plane = 0; plane < mask.planes.total(); ++plane)
      mask.words.insert(mask.words.end(), mask.grid.tile_count(), (count >> (4 - plane)) & 1 ? ~uint64_t{0} : 0);
    mask.arrived.assign(mask.words.size(), true);
    return renderer.shade({.index = index, .newest = index, .camera = masks->camera, .seen = masks}).value();
  }
};

TEST(ClientThatAccumulates, ShowsNothingThatIsOlderThanFourMasks) {
  Client plain(false), accumulating(true);
  const auto alone = plain.shown(0, 8).rgba;
  EXPECT_NE(plain.shown(1, 9).rgba, alone);
  EXPECT_EQ(accumulating.shown(0, 9).rgba, plain.shown(2, 9).rgba) << "the first";
  for (uint32_t index = 1; index <= 3; ++index)
    EXPECT_NE(accumulating.shown(index, 8).rgba, alone) << index << ": the first still counts";
  EXPECT_EQ(accumulating.shown(4, 8).rgba, alone);
}

TEST(ClientThatAccumulates, DropsWhatItKnowsWhenTheLightsChange) {
  Client plain(false), accumulating(true);
  for (uint32_t index = 0; index < 4; ++index) accumulating.shown(index, 9);
  EXPECT_EQ(accumulating.shown(4, 8, true).rgba, plain.shown(0, 8, true).rgba);
  EXPECT_NE(accumulating.shown(5, 9, true).rgba, plain.shown(1, 9, true).rgba) << "and begins anew";
}

TEST(ClientThatAccumulates, ShowsTheSameMaskTwiceAsItIs) {
  Client accumulating(true);
  accumulating.shown(0, 9);
  const auto once = accumulating.shown(1, 8).rgba;
  EXPECT_EQ(accumulating.shown(1, 8).rgba, once) << "a mask counts once, however often it is drawn";
}

}  // namespace
}  // namespace gnomon::client
