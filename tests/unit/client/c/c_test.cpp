// What libgnomon gives an engine that links it, against a scripted server.
#include <atomic>
#include <cstring>
#include <future>
#include <thread>

#include "tests/unit/client/c/c_client.h"
#include "tests/unit/client/stream/sliced.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::tests::c {
namespace {

TEST(C, TheVersionIsThatOfItsHeader) {
  EXPECT_STREQ(gnomon_version(), GNOMON_VERSION_TEXT);
  EXPECT_EQ(gnomon_version_number(), static_cast<uint32_t>(GNOMON_VERSION_NUMBER));
}

TEST(C, SaysHelloAsTheOptionsHaveIt) {
  std::optional<protocol::Message> said, bye;
  {
    FakeServer server([&](Peer& peer) {
      said = peer.read();
      peer.welcome(welcome());
      bye = peer.read();
    });
    Wanted wanted(server.address());
    wanted.options.tenant = "museum";
    wanted.options.token = "secret";
    wanted.options.program = "an engine";
    wanted.options.codec = "tiles_context";
    wanted.options.rate_hz = 72;
    Client client(wanted);
    ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
    EXPECT_EQ(gnomon_close(client.handle, "seen enough"), GNOMON_OK);
  }
  ASSERT_TRUE(said && bye);
  const auto& hello = std::get<protocol::Hello>(*said);
  EXPECT_EQ(hello.tenant, "museum");
  EXPECT_EQ(hello.token, "secret");
  EXPECT_EQ(hello.client, "an engine");
  EXPECT_EQ(hello.scene, "little");
  EXPECT_EQ(hello.codecs, std::vector{protocol::CodecId::tiles_context});
  EXPECT_EQ(hello.rate_hz, 72);
  EXPECT_EQ((std::array{hello.width, hello.height, hello.border_x, hello.border_y}),
            (std::array<uint16_t, 4>{kGrid.width, kGrid.height, kBorder, kBorder}));
  EXPECT_EQ(std::get<protocol::Bye>(*bye).reason, "seen enough");
}

TEST(C, AClientOfAFleetSaysItsSceneAndMovesWithoutAGap) {
  std::atomic<int> connections = 0;
  std::atomic<bool> answered = false;
  std::array<std::string, 2> names;
  const auto sent = foliage(kGrid, 7);
  {
    FakeServer fleet(
        [&](Peer& peer) {
          const int number = ++connections;
          names[static_cast<size_t>(number - 1)] = peer.asked_name();
          peer.read();
          peer.welcome(welcome());
          if (number == 1) peer.write(protocol::Draining{0, protocol::Draining::kMoveNow});
          const auto camera = peer.read_new_camera();
          if (camera) peer.send_frame(camera->frame, sent.view());
          answered = answered || number == 2;
          while (peer.read()) {  // until the client goes: it may say something before
          }
        },
        2, FakeServer::usual_identity(), FakeServer::Turns::at_once);
    Wanted wanted(fleet.address());
    wanted.options.fleet = "gnomon.example";
    Client client(wanted);
    ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
    gnomon_statistics figures{};
    figures.size = sizeof figures;
    for (int i = 0; i < 2000 && figures.moved == 0; ++i) {
      const gnomon_camera camera = camera_at(static_cast<float>(i));
      ASSERT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_OK) << client.error();
      gnomon_mask* mask = nullptr;
      if (gnomon_poll(client.handle, 5, &mask) == GNOMON_OK) gnomon_mask_free(mask);
      EXPECT_EQ(client.state(), GNOMON_OPEN) << "all along";
      ASSERT_EQ(gnomon_get_statistics(client.handle, &figures), GNOMON_OK);
    }
    EXPECT_EQ(figures.moved, 1u);
    EXPECT_EQ(figures.reconnects, 0u);
    EXPECT_EQ(gnomon_close(client.handle, ""), GNOMON_OK);
  }
  EXPECT_EQ(names[0], client::server_name({.fleet = "gnomon.example"}, "", "little"));
  EXPECT_EQ(names[1], names[0]);
}

TEST(C, MasksAreBitForBitWhatTheServerSent) {
  const auto sent = foliage(kGrid, 7);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(welcome());
    const auto camera = peer.read_new_camera();
    if (camera) peer.send_frame(camera->frame, sent.view());
    peer.read();
  });
  gnomon_mask* mask = nullptr;
  {
    Client client{Wanted(server.address())};
    ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
    const gnomon_camera camera = camera_at(3);
    uint32_t index = 99;
    ASSERT_EQ(gnomon_look(client.handle, &camera, &index), GNOMON_OK) << client.error();
    EXPECT_EQ(index, 0u);
    ASSERT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_OK) << client.error();
    gnomon_mask* second = mask;
    EXPECT_EQ(gnomon_poll(client.handle, 0, &second), GNOMON_NOTHING) << "given once";
    EXPECT_EQ(second, nullptr);
  }
  // The mask outlives its client.
  gnomon_mask_view view{};
  view.size = sizeof view;
  ASSERT_EQ(gnomon_mask_get_view(mask, &view), GNOMON_OK);
  EXPECT_EQ((TileGrid{view.width, view.height, view.lights}), kGrid);
  EXPECT_EQ(view.camera.position[0], 3);
  EXPECT_EQ(view.missing_tile_count, 0u);
  ASSERT_EQ(view.word_count, sent.words.size());
  EXPECT_EQ(std::memcmp(view.words, sent.words.data(), sizeof(uint64_t) * view.word_count), 0);
  for (uint32_t light = 0; light < kGrid.planes; ++light) {
    for (uint32_t y = 0; y < kGrid.height; ++y) {
      for (uint32_t x = 0; x < kGrid.width; ++x) {
        ASSERT_EQ(gnomon_mask_lit(mask, light, x, y), sent.view().lit(x, y, light))
            << light << ' ' << x << ' ' << y;
      }
    }
  }
  gnomon_light light{};
  light.size = sizeof light;
  EXPECT_EQ(gnomon_mask_get_light(mask, 1, &light), GNOMON_OK);
  EXPECT_EQ(gnomon_mask_get_light(mask, kGrid.planes, &light), GNOMON_BAD_ARGUMENT);
  EXPECT_EQ(gnomon_mask_lit(mask, kGrid.planes, 0, 0), -1);
  EXPECT_EQ(gnomon_mask_lit(mask, 0, kGrid.width, 0), -1);
  EXPECT_EQ(gnomon_mask_lit(mask, 0, 0, kGrid.height), -1);
  EXPECT_EQ(gnomon_mask_has_tile(mask, 0, view.tiles_x, 0), -1);
  gnomon_mask_free(mask);
}

TEST(C, WhatDidNotArriveIsNamedAndLit) {
  const auto dark = all_dark(kGrid);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(welcome());
    const auto camera = peer.read_new_camera();
    if (!camera) return;
    auto encoded = sliced(camera->frame, dark.view(), protocol::kMaxSlicePayloadBytes);
    ASSERT_EQ(encoded.slices.size(), 1u);
    // Only one slice of two: the first row of tiles of the first light.
    protocol::SliceHeader part = encoded.slices[0];
    part.slice_count = 2;
    part.tile_count = kGrid.tiles_x();
    part.light_count = 1;
    const std::vector<uint8_t> payload(1 + (part.tile_count + 3) / 4);  // plain bytes: every tile is dark
    peer.send_slice(part, payload);
    peer.read();
  });
  Client client{Wanted(server.address())};
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  const gnomon_camera camera = camera_at(0);
  ASSERT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_OK);
  gnomon_mask* mask = nullptr;
  ASSERT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_OK) << client.error();
  gnomon_mask_view view{};
  view.size = sizeof view;
  ASSERT_EQ(gnomon_mask_get_view(mask, &view), GNOMON_OK);
  EXPECT_EQ(view.missing_tile_count, kGrid.tile_count()) << "each lacks the second light";
  EXPECT_EQ(view.missing_tiles[1], 1u);
  EXPECT_EQ(gnomon_mask_has_tile(mask, 0, 1, 0), 1);
  EXPECT_EQ(gnomon_mask_has_tile(mask, 1, 1, 0), 0);
  EXPECT_EQ(gnomon_mask_has_tile(mask, 0, 1, 1), 0);
  EXPECT_EQ(gnomon_mask_lit(mask, 0, 8, 0), 0);
  EXPECT_EQ(gnomon_mask_lit(mask, 1, 8, 0), 1);
  EXPECT_EQ(gnomon_mask_lit(mask, 0, 8, 8), 1);
  gnomon_mask_free(mask);
  gnomon_statistics figures{};
  figures.size = sizeof figures;
  ASSERT_EQ(gnomon_get_statistics(client.handle, &figures), GNOMON_OK);
  EXPECT_EQ(figures.partial_masks, 1u);
  EXPECT_EQ(figures.lost_slices, 1u);
}

TEST(C, TheNewestMaskIsGivenAndOthersAreCounted) {
  std::promise<void> sent;
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(welcome());
    const auto first = peer.read_new_camera();
    const auto second = peer.read_new_camera();
    if (first) peer.send_frame(first->frame, all_lit(kGrid).view());
    if (second) peer.send_frame(second->frame, all_lit(kGrid).view());
    sent.set_value();
    peer.read();
  });
  Client client{Wanted(server.address())};
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  for (const float x : {1.0f, 2.0f}) {
    const gnomon_camera camera = camera_at(x);
    ASSERT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_OK);
  }
  sent.get_future().wait();  // meanwhile the engine does not poll
  gnomon_mask* mask = nullptr;
  ASSERT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_OK) << client.error();
  gnomon_mask_view view{};
  view.size = sizeof view;
  ASSERT_EQ(gnomon_mask_get_view(mask, &view), GNOMON_OK);
  EXPECT_EQ(view.index, 1u);
  EXPECT_EQ(view.camera.position[0], 2);
  gnomon_mask_free(mask);
  gnomon_statistics figures{};
  figures.size = sizeof figures;
  ASSERT_EQ(gnomon_get_statistics(client.handle, &figures), GNOMON_OK);
  EXPECT_EQ(figures.masks, 2u);
  EXPECT_EQ(figures.not_given, 1u);
}

TEST(C, FindsALostServerAgainAndCountsCamerasOn) {
  int connections = 0;
  FakeServer server(
      [&](Peer& peer) {
        peer.read();
        peer.welcome(welcome());
        const auto camera = peer.read_new_camera();
        if (++connections == 1) return peer.write(protocol::Bye{"a new version is installed"});
        if (camera) peer.send_frame(camera->frame, all_lit(kGrid).view());
        peer.read();
      },
      2);
  Client client{Wanted(server.address())};
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  const gnomon_camera camera = camera_at(0);
  uint32_t index = 0;
  gnomon_mask* mask = nullptr;
  ASSERT_EQ(gnomon_look(client.handle, &camera, &index), GNOMON_OK);
  for (uint32_t ms = 0; ms < kPatienceMs && client.state() == GNOMON_OPEN; ms += 10) {
    EXPECT_EQ(gnomon_poll(client.handle, 10, &mask), GNOMON_NOTHING) << "no error: it is looked for";
  }
  EXPECT_EQ(client.state(), GNOMON_LOST);
  EXPECT_EQ(gnomon_look(client.handle, &camera, &index), GNOMON_NOT_OPEN);
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  ASSERT_EQ(gnomon_look(client.handle, &camera, &index), GNOMON_OK);
  EXPECT_EQ(index, 1u);
  ASSERT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_OK) << client.error();
  gnomon_mask_view view{};
  view.size = sizeof view;
  ASSERT_EQ(gnomon_mask_get_view(mask, &view), GNOMON_OK);
  EXPECT_EQ(view.index, 1u);
  gnomon_mask_free(mask);
  gnomon_statistics figures{};
  figures.size = sizeof figures;
  ASSERT_EQ(gnomon_get_statistics(client.handle, &figures), GNOMON_OK);
  EXPECT_EQ(figures.reconnects, 1u);
  EXPECT_EQ(figures.masks, 1u);
  EXPECT_EQ(figures.unanswered, 1u) << "the camera whose session ended";
  gnomon_scene scene{};
  scene.size = sizeof scene;
  ASSERT_EQ(gnomon_get_scene(client.handle, &scene), GNOMON_OK);
  EXPECT_EQ(scene.revision, 2u);
}

TEST(C, ClientsOnDifferentThreadsShareNothing) {
  const auto fly = [](const Wanted& wanted, float x, float& seen) {
    Client client(wanted);
    const gnomon_camera camera = camera_at(x);
    gnomon_mask* mask = nullptr;
    gnomon_mask_view view{};
    view.size = sizeof view;
    if (client.wait() != GNOMON_OK || gnomon_look(client.handle, &camera, nullptr) != GNOMON_OK) return;
    if (gnomon_poll(client.handle, kPatienceMs, &mask) != GNOMON_OK) return;
    gnomon_mask_get_view(mask, &view);
    seen = view.camera.position[0];
    gnomon_mask_free(mask);
  };
  const auto answer = [](Peer& peer) {
    peer.read();
    peer.welcome(welcome());
    const auto camera = peer.read_new_camera();
    if (camera) peer.send_frame(camera->frame, room(kGrid, 1).view());
    peer.read();
  };
  FakeServer left(answer), right(answer);
  const Wanted of_left(left.address()), of_right(right.address());
  float seen_left = 0, seen_right = 0;
  std::thread other([&] { fly(of_right, 2, seen_right); });
  fly(of_left, 1, seen_left);
  other.join();
  EXPECT_EQ(seen_left, 1);
  EXPECT_EQ(seen_right, 2);
}

TEST(C, TellsTheSceneAndItsLights) {
  FakeServer server([](Peer& peer) {
    peer.read();
    auto message = welcome();
    message.features = protocol::kFeatureMoments;
    message.scene.content_hash = {1, 2, 3};
    message.scene.triangles = 12;
    message.scene.lights[1].kind = protocol::LightKind::spot;
    message.scene.lights[1].position = {4, 5, 6};
    message.lights_version = 8;
    message.motions = {{.node = "fan", .kind = 0, .vector = {0, 1, 0}, .period_us = 500'000}};
    const auto lights = message.scene.lights;
    peer.welcome(std::move(message));
    if (!peer.read_new_camera()) return;
    protocol::LightsChanged changed{lights, 9};
    changed.lights[0].intensity = 77;
    peer.write(changed);
    peer.read();
  });
  Client client{Wanted(server.address())};
  gnomon_scene scene{};
  scene.size = sizeof scene;
  ASSERT_EQ(gnomon_get_scene(client.handle, &scene), GNOMON_OK);
  EXPECT_EQ(scene.revision, 0u) << "nothing is known yet";
  EXPECT_STREQ(scene.name, "");
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  ASSERT_EQ(gnomon_get_scene(client.handle, &scene), GNOMON_OK);
  EXPECT_STREQ(scene.name, "little");
  EXPECT_EQ(scene.content_hash[2], 3);
  EXPECT_EQ(scene.triangles, 12u);
  EXPECT_EQ(scene.lights_version, 8u);
  ASSERT_EQ(scene.lights, 2u);
  ASSERT_EQ(scene.motions, 1u);
  const uint32_t before = scene.revision;
  gnomon_light light{};
  light.size = sizeof light;
  ASSERT_EQ(gnomon_get_light(client.handle, 1, &light), GNOMON_OK);
  EXPECT_EQ(light.kind, GNOMON_SPOT);
  EXPECT_EQ(light.position[2], 6);
  gnomon_motion motion{};
  motion.size = sizeof motion;
  ASSERT_EQ(gnomon_get_motion(client.handle, 0, &motion), GNOMON_OK);
  EXPECT_STREQ(motion.node, "fan");
  EXPECT_EQ(motion.period_us, 500'000u);

  const gnomon_camera camera = camera_at(0);
  ASSERT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_OK);
  gnomon_mask* mask = nullptr;
  for (uint32_t ms = 0; ms < kPatienceMs && scene.revision == before; ms += 10) {
    EXPECT_EQ(gnomon_poll(client.handle, 10, &mask), GNOMON_NOTHING);
    ASSERT_EQ(gnomon_get_scene(client.handle, &scene), GNOMON_OK);
  }
  EXPECT_EQ(scene.lights_version, 9u);
  ASSERT_EQ(gnomon_get_light(client.handle, 0, &light), GNOMON_OK);
  EXPECT_EQ(light.intensity, 77);
}

}  // namespace
}  // namespace gnomon::tests::c
