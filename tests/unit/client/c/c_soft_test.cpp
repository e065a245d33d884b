// Soft shadows as libgnomon gives them to an engine.
#include "common/light_planes.h"
#include "tests/unit/client/c/c_client.h"
#include "tests/unit/client/stream/sliced.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::tests::c {
namespace {

TEST(CSoft, AreaLightsHaveCounts) {
  const LightPlanes planes({false, true}, 4);
  const TileGrid grid{kGrid.width, kGrid.height, planes.total()};
  const auto sent = foliage(grid, 7);
  protocol::Hello asked;
  FakeServer server([&](Peer& peer) {
    asked = std::get<protocol::Hello>(peer.read().value());
    auto soft = welcome();
    soft.features = protocol::kFeatureSoft;
    soft.samples = 4;
    soft.areas = {{}, {3, {1, 0, 0}, {0, 1, 0}}};
    peer.welcome(soft);
    if (const auto camera = peer.read_new_camera()) peer.send_frame(camera->frame, sent.view());
    peer.read();
  });
  Wanted wanted(server.address());
  wanted.options.samples = 16;
  Client client{wanted};
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  EXPECT_EQ(asked.samples, 16);
  gnomon_session session{};
  session.size = sizeof session;
  ASSERT_EQ(gnomon_get_session(client.handle, &session), GNOMON_OK);
  EXPECT_EQ(session.samples, 4u);
  const gnomon_camera camera = camera_at(3);
  ASSERT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_OK) << client.error();
  gnomon_mask* mask = nullptr;
  ASSERT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_OK) << client.error();
  gnomon_mask_view view{};
  view.size = sizeof view;
  ASSERT_EQ(gnomon_mask_get_view(mask, &view), GNOMON_OK);
  EXPECT_EQ(view.lights, 2u);
  EXPECT_EQ(view.planes, 4u);
  EXPECT_EQ(view.samples, 4u);
  EXPECT_EQ(view.word_count, grid.word_count());
  EXPECT_EQ(gnomon_mask_samples(mask, 0), 1);
  EXPECT_EQ(gnomon_mask_samples(mask, 1), 4);
  EXPECT_EQ(gnomon_mask_first_plane(mask, 1), 1);
  EXPECT_EQ(gnomon_mask_samples(mask, 2), -1);
  EXPECT_EQ(gnomon_mask_first_plane(mask, 2), -1);
  EXPECT_EQ(gnomon_mask_seen(mask, 2, 0, 0), -1);
  EXPECT_EQ(gnomon_mask_has_tile(mask, 1, 0, 0), 1);
  for (uint32_t light = 0; light < 2; ++light)
    for (uint32_t y = 0; y < grid.height; ++y)
      for (uint32_t x = 0; x < grid.width; ++x) {
        const auto seen = planes.seen(sent.view(), x, y, light);
        ASSERT_EQ(gnomon_mask_seen(mask, light, x, y), static_cast<int>(seen)) << light << ' ' << x << ' ' << y;
        ASSERT_EQ(gnomon_mask_lit(mask, light, x, y), 2 * seen >= planes.samples(light));
      }
  gnomon_mask_free(mask);
}

TEST(CSoft, OcclusionComesBesideTheLights) {
  for (const Occlusion occlusion : {Occlusion::half, Occlusion::full}) {
    const LightPlanes planes({false, false}, {1, occlusion});
    const TileGrid grid{kGrid.width, kGrid.height, planes.total()};
    const auto sent = foliage(grid, 7);
    protocol::Hello asked;
    FakeServer server([&](Peer& peer) {
      asked = std::get<protocol::Hello>(peer.read().value());
      auto with = welcome();
      with.features = protocol::kFeatureSoft;
      with.samples = to_byte({1, occlusion});
      with.areas.resize(2);
      peer.welcome(with);
      if (const auto camera = peer.read_new_camera()) peer.send_frame(camera->frame, sent.view());
      peer.read();
    });
    Wanted wanted(server.address());
    wanted.options.occlusion = GNOMON_OCCLUSION_FULL;
    Client client{wanted};
    ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
    EXPECT_EQ(asked.samples, to_byte({1, Occlusion::full}));
    gnomon_session session{};
    session.size = sizeof session;
    ASSERT_EQ(gnomon_get_session(client.handle, &session), GNOMON_OK);
    EXPECT_EQ(session.occlusion, static_cast<gnomon_occlusion>(occlusion));
    const gnomon_camera camera = camera_at(3);
    ASSERT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_OK) << client.error();
    gnomon_mask* mask = nullptr;
    ASSERT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_OK) << client.error();
    gnomon_mask_view view{};
    view.size = sizeof view;
    ASSERT_EQ(gnomon_mask_get_view(mask, &view), GNOMON_OK);
    EXPECT_EQ(view.lights, 2u);
    EXPECT_EQ(view.planes, 6u);
    EXPECT_EQ(view.occlusion_plane, 2u);
    EXPECT_EQ(view.occlusion, static_cast<gnomon_occlusion>(occlusion));
    for (uint32_t y = 0; y < grid.height; ++y)
      for (uint32_t x = 0; x < grid.width; ++x) {
        const bool own = occlusion == Occlusion::full || (x % 2 == 0 && y % 2 == 0);
        const int open = own ? static_cast<int>(planes.open_segments(sent.view(), x, y)) : -1;
        ASSERT_EQ(gnomon_mask_open(mask, x, y), open) << x << ' ' << y;
      }
    EXPECT_EQ(gnomon_mask_open(mask, grid.width, 0), -1);
    gnomon_mask_free(mask);
  }
}

TEST(CSoft, ThereIsNoOtherOcclusion) {
  for (const int occlusion : {3, 258, -1}) {
    Wanted wanted({"localhost", 1});
    wanted.options.occlusion = static_cast<gnomon_occlusion>(occlusion);
    Client client{wanted};
    EXPECT_EQ(client.opened, GNOMON_BAD_ARGUMENT) << occlusion;
    EXPECT_NE(client.error().find("occlusion"), std::string::npos);
  }
}

TEST(CSoft, OtherNumbersOfSamplesAreAnError) {
  for (const uint32_t samples : {2u, 8u, 64u, 300u}) {
    Wanted wanted({"localhost", 1});
    wanted.options.samples = samples;
    Client client{wanted};
    EXPECT_EQ(client.opened, GNOMON_BAD_ARGUMENT) << samples;
    EXPECT_NE(client.error().find("samples"), std::string::npos);
  }
}

}  // namespace
}  // namespace gnomon::tests::c
