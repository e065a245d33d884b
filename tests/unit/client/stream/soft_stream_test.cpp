// Soft shadows as a client gets them: planes are known for every frame, and never mistaken for another number's.
#include <gtest/gtest.h>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/sliced.h"
#include "tests/unit/client/stream/watched.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace tests;

// The second of two lights is an area light.
const std::vector<bool> kAreas{false, true};

TileGrid grid_of(SampleCounts samples) { return {kWidth, kHeight, LightPlanes(kAreas, samples).total()}; }

std::vector<protocol::AreaInfo> areas() { return {{}, {1, {0.1f, 0, 0}, {0, 0.1f, 0}}}; }

protocol::Welcome soft_welcome(uint8_t samples) {
  auto welcome = small_welcome(kWidth, kHeight, 2);
  welcome.features = protocol::kFeatureSoft | protocol::kFeatureSizes;
  welcome.samples = samples;
  welcome.areas = areas();
  return welcome;
}

// `told`: the samples that slices state; 0: none.
void send(Peer& peer, FrameId frame, const tests::Mask& mask, uint8_t told = 0) {
  auto encoded = sliced(frame, mask.view(), 700);
  for (size_t i = 0; i < encoded.slices.size(); ++i) {
    if (told > 0) {
      encoded.slices[i].flags |= protocol::kSliceHasSamples;
      encoded.slices[i].samples = told;
    }
    peer.send_slice(encoded.slices[i], encoded.payload(i));
  }
}

StreamOptions soft_options(const Address& server, uint8_t samples = 16) {
  StreamOptions options = options_for(server);
  options.samples = samples;
  return options;
}

// Masks would take as much memory as the server likes.
TEST(SoftStream, AWelcomeWithMoreThanWasAskedForIsRefused) {
  const auto is_taken = [](SampleCounts samples, uint64_t more_features) {
    FakeServer server([&](Peer& peer) {
      peer.read();
      protocol::Welcome welcome = soft_welcome(to_byte(samples));
      welcome.features |= more_features;
      peer.welcome(std::move(welcome));
      peer.read();
    });
    StreamOptions options = options_for(server.address());
    options.samples = {4, Occlusion::half};
    Watched watched(options);
    return watched.stream.wait_open();
  };
  EXPECT_TRUE(is_taken({4, Occlusion::half}, 0));
  EXPECT_FALSE(is_taken({16, Occlusion::half}, 0));
  EXPECT_FALSE(is_taken({4, Occlusion::full}, 0));
  EXPECT_FALSE(is_taken({4, Occlusion::half}, uint64_t{1} << 40));
}

TEST(SoftStream, AsksForSamplesAndCountsThem) {
  const auto mask = noise(grid_of(16), 1);
  protocol::Hello asked;
  FakeServer server([&](Peer& peer) {
    asked = std::get<protocol::Hello>(peer.read().value());
    peer.welcome(soft_welcome(16));
    if (const auto camera = peer.read_new_camera()) send(peer, camera->frame, mask);
    peer.read();
  });
  Watched watched(soft_options(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  EXPECT_EQ(asked.samples, 16);
  EXPECT_NE(asked.features & protocol::kFeatureSoft, 0u);
  EXPECT_EQ(watched.stream.grid(), grid_of(16));
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_EQ(watched.answers[0].words, mask.words);
  EXPECT_EQ(watched.answers[0].planes, LightPlanes(kAreas, 16));
  watched.stream.close("");
}

TEST(SoftStream, WhoWantsHardShadowsDoesNotOfferTheFeature) {
  protocol::Hello asked;
  FakeServer server([&](Peer& peer) {
    asked = std::get<protocol::Hello>(peer.read().value());
    peer.welcome(small_welcome(kWidth, kHeight, 2));
    peer.read();
  });
  Watched watched(soft_options(server.address(), 1));
  ASSERT_TRUE(watched.stream.wait_open());
  EXPECT_EQ(asked.features & protocol::kFeatureSoft, 0u);
  EXPECT_EQ(watched.stream.grid(), kGrid);
  watched.stream.close("");
}

// Datagrams may overtake a message of the control connection, and arrive long after it.
TEST(SoftStream, SlicesOfOtherSamplesAreNeverTakenForThoseInForce) {
  const auto fine = noise(grid_of(16), 1), coarse = noise(grid_of(4), 2);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(soft_welcome(16));
    peer.read_new_camera();
    send(peer, FrameId{1}, coarse, 4);  // before the news
    peer.read_new_camera();
    peer.write(protocol::Degraded{kWidth, kHeight, 30, "load", {}, 4});
    peer.read_new_camera();
    send(peer, FrameId{2}, fine);  // after it
    send(peer, FrameId{2}, coarse, 4);
    peer.read_new_camera();
    peer.write(protocol::Degraded{kWidth, kHeight, 30, "well again", {}, 16});
    peer.read_new_camera();
    send(peer, FrameId{4}, fine);
    peer.read();
  });
  Watched watched(soft_options(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return watched.stream.counters().late_slices > 0; }));
  EXPECT_TRUE(watched.answers.empty());
  watched.stream.ask(camera_at(1));
  ASSERT_TRUE(watched.until([&] { return watched.messages.size() == 1; }));
  EXPECT_EQ(watched.stream.grid(), grid_of(4));
  watched.stream.ask(camera_at(2));
  ASSERT_TRUE(watched.until([&] { return watched.answers.size() == 1; }));
  EXPECT_EQ(watched.answers[0].frame, FrameId{2}) << "asked for before the news, rendered after it";
  EXPECT_EQ(watched.answers[0].words, coarse.words);
  EXPECT_EQ(watched.answers[0].planes, LightPlanes(kAreas, 4));
  watched.stream.ask(camera_at(3));
  ASSERT_TRUE(watched.until([&] { return watched.messages.size() == 2; }));
  watched.stream.ask(camera_at(4));
  ASSERT_TRUE(watched.until([&] { return watched.answers.size() == 2; }));
  EXPECT_EQ(watched.answers[1].planes, LightPlanes(kAreas, 16));
  EXPECT_EQ(watched.answers[1].words, fine.words);
  EXPECT_EQ(watched.stream.counters().invalid_slices, 0u);
  watched.stream.close("");
}

// Occlusion is degraded as points are: told by slices, and never mistaken.
TEST(SoftStream, OcclusionIsAskedForAndTakenAway) {
  const SampleCounts full{4, Occlusion::full}, half{4, Occlusion::half}, none{4};
  const auto whole = noise(grid_of(full), 1), quarter = noise(grid_of(half), 2), without = noise(grid_of(none), 3);
  protocol::Hello asked;
  FakeServer server([&](Peer& peer) {
    asked = std::get<protocol::Hello>(peer.read().value());
    peer.welcome(soft_welcome(to_byte(full)));
    peer.read_new_camera();
    send(peer, FrameId{1}, whole);
    peer.write(protocol::Degraded{kWidth, kHeight, 30, "load", {}, to_byte(half)});
    peer.read_new_camera();
    send(peer, FrameId{2}, whole);  // has as many planes as what is in force
    send(peer, FrameId{2}, quarter, to_byte(half));
    peer.write(protocol::Degraded{kWidth, kHeight, 30, "load", {}, to_byte(none)});
    peer.read_new_camera();
    send(peer, FrameId{3}, without, to_byte(none));
    peer.read();
  });
  StreamOptions options = options_for(server.address());
  options.samples = {16, Occlusion::full};
  Watched watched(options);
  ASSERT_TRUE(watched.stream.wait_open());
  EXPECT_EQ(asked.samples, to_byte({16, Occlusion::full}));
  for (const size_t answers : {1, 2, 3}) {
    watched.stream.ask(camera_at(static_cast<float>(answers)));
    ASSERT_TRUE(watched.until([&] { return watched.answers.size() == answers; })) << answers;
    if (answers < 3) {
      ASSERT_TRUE(watched.until([&] { return watched.messages.size() == answers; }));
    }
  }
  EXPECT_EQ(watched.answers[0].planes, LightPlanes(kAreas, full));
  EXPECT_EQ(watched.answers[0].words, whole.words);
  EXPECT_EQ(watched.answers[1].planes, LightPlanes(kAreas, half));
  EXPECT_EQ(watched.answers[1].words, quarter.words);
  EXPECT_EQ(watched.answers[2].words, without.words);
  watched.stream.close("");
}

// As many lights and planes as before, but of others.
TEST(SoftStream, ASceneWhoseAreasAreOthersLeavesOldFramesBehind) {
  const auto mask = noise(grid_of(16), 1);
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(soft_welcome(16));
    peer.read_new_camera();
    protocol::SceneChanged changed{soft_welcome(16).scene};
    changed.samples = 16;
    changed.areas = areas();
    std::swap(changed.areas[0], changed.areas[1]);
    peer.write(changed);
    const auto camera = peer.read_new_camera();
    if (!camera) return;
    send(peer, FrameId{1}, noise(grid_of(16), 2));
    send(peer, camera->frame, mask);
    peer.read();
  });
  Watched watched(soft_options(server.address()));
  ASSERT_TRUE(watched.stream.wait_open());
  watched.stream.ask(camera_at(0));
  ASSERT_TRUE(watched.until([&] { return !watched.messages.empty(); }));
  watched.stream.ask(camera_at(1));
  ASSERT_TRUE(watched.until([&] { return !watched.answers.empty(); }));
  EXPECT_EQ(watched.answers[0].frame, FrameId{2});
  EXPECT_EQ(watched.answers[0].words, mask.words);
  EXPECT_EQ(watched.answers[0].planes, LightPlanes({true, false}, 16));
  watched.stream.close("");
}

// A frame of fewer planes is not what a slice refers to, whatever its number and bits.
TEST(SoftStream, ReferencesOfAnotherNumberOfPlanesAreNotUsed) {
  const auto fine = noise(grid_of(16), 1), coarse = noise(grid_of(4), 1);
  protocol::ReferenceShelf shelf;
  const auto reference = std::make_shared<protocol::MaskReference>(FrameId{1}, coarse.view());
  shelf.add(reference);
  const std::vector<uint64_t> care(fine.words.size(), ~uint64_t{0});
  const PackedMask packed(fine.view(), care);
  const protocol::MaskReference same(FrameId{1}, fine.view());
  protocol::EncodedMask encoded;
  ASSERT_TRUE(
      protocol::FrameEncoder().encode(packed.view(), protocol::CodecId::tiles_context, 1100, encoded, &same));
  std::vector<uint64_t> words(fine.words.size());
  bool refers = false;
  for (size_t i = 0; i < encoded.slices.size(); ++i) {
    if (encoded.payload(i)[0] == 0) continue;
    refers = true;
    EXPECT_TRUE(protocol::lacks_reference(encoded.slices[i], encoded.payload(i), fine.grid, &shelf));
    EXPECT_FALSE(protocol::decode_slice(encoded.slices[i], encoded.payload(i), fine.grid, words, &shelf));
  }
  EXPECT_TRUE(refers);
}

}  // namespace
}  // namespace gnomon::client
