// Soft shadows between a client and a complete daemon: who gets how many samples, and what slices then hold.
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

class Soft : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    write_scene(folder_ / "triangle.gltf", true, R"("extras": {"gnomon": {"light": {"radius": 0.25}}}, )");
    make_renderers_ = {[this]() -> Result<std::unique_ptr<gpu::Renderer>> {
      return std::unique_ptr<gpu::Renderer>(std::make_unique<SelfRunningFakeRenderer>(
          3, kLights, frame_time_, std::make_shared<std::atomic<bool>>(false), std::vector<bool>{true}));
    }};
  }

  static protocol::Hello hello(uint8_t samples, const std::string& scene = kScene) {
    protocol::Hello hello = TestClient::hello(scene);
    hello.features |= protocol::kFeatureSoft;
    hello.samples = samples;
    return hello;
  }

  static std::vector<uint64_t> sent_words(const TileGrid& grid, float x) {
    gpu::CameraView camera;
    camera.position.x = x;
    std::vector<uint64_t> sent(grid.word_count());
    for (size_t i = 0; i < sent.size(); ++i) sent[i] = fake_word(camera, i);
    return sent;
  }

  static bool occlusion_is_right(const TestClient& client, const std::vector<uint64_t>& words, float x) {
    const LightPlanes planes = client.planes();
    const TileGrid grid{client.welcome().width, client.welcome().height, planes.total()};
    const std::vector<uint64_t> sent = sent_words(grid, x);
    bool some = false;
    for (uint32_t y = 0; y < grid.height; ++y)
      for (uint32_t at = 0; at < grid.width; ++at) {
        const uint32_t open = planes.open_segments({grid, words}, at, y);
        if (open != planes.open_segments({grid, sent}, at, y)) return false;
        some = some || (open > 0 && open < kOcclusionSegments);
      }
    return some;
  }

  // Whether every pixel of the frame of a camera at `x` has the count that the renderer's planes mean.
  static bool counts_are_right(const TestClient& client, const std::vector<uint64_t>& words, float x) {
    const LightPlanes planes = client.planes();
    const TileGrid grid{client.welcome().width, client.welcome().height, planes.total()};
    const std::vector<uint64_t> sent = sent_words(grid, x);
    if (words.size() != sent.size()) return false;
    bool some = false;
    for (uint32_t y = 0; y < grid.height; ++y)
      for (uint32_t at = 0; at < grid.width; ++at) {
        const uint32_t seen = planes.seen({grid, words}, at, y, 0);
        if (seen != planes.seen({grid, sent}, at, y, 0)) return false;
        some = some || (seen > 0 && seen < planes.samples(0));
      }
    return some || planes.is_hard();
  }
};

TEST_F(Soft, SlicesHaveTheCountsOfTheGrantedSamples) {
  start();
  for (const uint8_t samples : {16, 4, 1, 0}) {
    TestClient c = client();
    ASSERT_TRUE(c.join(hello(samples)));
    EXPECT_EQ(c.welcome().samples, std::max<uint8_t>(samples, 1));
    ASSERT_EQ(c.welcome().areas.size(), 1u);
    EXPECT_EQ(c.welcome().areas[0].shape, 1);
    EXPECT_EQ(c.welcome().areas[0].u[0], 0.25f);
    c.send_view(1, 2);
    EXPECT_TRUE(counts_are_right(c, c.receive_frame(1), 2)) << int{samples};
  }
}

TEST_F(Soft, CountsComeWithEveryCodecAndByReference) {
  start();
  for (const auto codec : protocol::kCodecs) {
    TestClient c = client();
    protocol::Hello wanted = hello(16);
    wanted.codecs = {codec};
    if (codec == protocol::CodecId::tiles_context) wanted.features |= protocol::kFeatureReferences;
    ASSERT_TRUE(c.join(wanted));
    for (uint32_t frame = 1; frame <= 4; ++frame) {
      c.send_view(frame, 2);
      EXPECT_TRUE(counts_are_right(c, c.receive_frame(frame), 2)) << protocol::to_string(codec) << frame;
    }
    EXPECT_EQ(c.referred(), codec == protocol::CodecId::tiles_context);
  }
}

TEST_F(Soft, ClientsWithoutTheFeatureGetBits) {
  start();
  TestClient c = client();
  protocol::Hello hard = hello(16);
  hard.features &= ~protocol::kFeatureSoft;
  ASSERT_TRUE(c.join(hard));
  EXPECT_EQ(c.welcome().features & protocol::kFeatureSoft, 0u);
  c.send_view(1, 2);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(1), 2));
}

TEST_F(Soft, ServerAndTenantAllowNoMoreThanTheySay) {
  config_.tenants = {{.name = "default"}, {.name = "four", .max_samples = 4}};
  start();
  const auto granted = [&](uint8_t wanted, const std::string& tenant) {
    TestClient c = client();
    protocol::Hello asked = hello(wanted);
    asked.tenant = tenant;
    EXPECT_TRUE(c.join(asked));
    return c.welcome().samples;
  };
  EXPECT_EQ(granted(16, ""), 16);
  EXPECT_EQ(granted(16, "four"), 4);
  EXPECT_EQ(granted(1, "four"), 1);
  EXPECT_EQ(granted(63, ""), 16) << "the next fewer that there are";
  EXPECT_EQ(granted(15, ""), 4);
  EXPECT_EQ(granted(3, ""), 1);
  daemon_.reset();
  config_.render.max_samples = 4;
  start();
  EXPECT_EQ(granted(16, ""), 4);
}

TEST_F(Soft, OcclusionIsGrantedToWhoAsksAndMayHaveIt) {
  config_.tenants = {{.name = "default"},
                     {.name = "half", .max_occlusion = Occlusion::half},
                     {.name = "none", .max_occlusion = Occlusion::none}};
  start();
  const auto granted = [&](SampleCounts wanted, const std::string& tenant, const std::string& scene = kScene) {
    TestClient c = client();
    protocol::Hello asked = hello(to_byte(wanted), scene);
    asked.tenant = tenant;
    EXPECT_TRUE(c.join(asked));
    return sample_counts_of(c.welcome().samples);
  };
  const SampleCounts full{16, Occlusion::full};
  EXPECT_EQ(granted(full, ""), full);
  EXPECT_EQ(granted(full, "half"), (SampleCounts{16, Occlusion::half}));
  EXPECT_EQ(granted(full, "none"), SampleCounts{16});
  EXPECT_EQ(granted({1, Occlusion::half}, ""), (SampleCounts{1, Occlusion::half}));
  EXPECT_EQ(granted(full, "", "another.gltf"), (SampleCounts{1, Occlusion::full})) << "needs no area light";
  const auto granted_byte = [&](uint8_t byte) {
    TestClient c = client();
    EXPECT_TRUE(c.join(hello(byte)));
    return sample_counts_of(c.welcome().samples);
  };
  EXPECT_EQ(granted_byte(255), full) << "of what there is";
  EXPECT_EQ(granted_byte(0xc0), (SampleCounts{1, Occlusion::full}));
  daemon_.reset();
  config_.render.passes = {"soft_shadows"};
  start();
  EXPECT_EQ(granted(full, ""), SampleCounts{16});
}

TEST_F(Soft, SlicesHaveThePlanesOfOcclusion) {
  start();
  for (const auto codec : protocol::kCodecs) {
    TestClient c = client();
    protocol::Hello wanted = hello(to_byte({4, Occlusion::full}));
    wanted.codecs = {codec};
    if (codec == protocol::CodecId::tiles_context) wanted.features |= protocol::kFeatureReferences;
    ASSERT_TRUE(c.join(wanted));
    for (uint32_t frame = 1; frame <= 3; ++frame) {
      c.send_view(frame, 2);
      const auto words = c.receive_frame(frame);
      ASSERT_TRUE(counts_are_right(c, words, 2)) << protocol::to_string(codec) << frame;
      EXPECT_TRUE(occlusion_is_right(c, words, 2)) << protocol::to_string(codec) << frame;
    }
  }
}

TEST_F(Soft, WithoutAreaLightsThereIsNothingToSample) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(hello(16, "another.gltf")));
  EXPECT_EQ(c.welcome().samples, 1);
  ASSERT_EQ(c.welcome().areas.size(), 1u);
  EXPECT_EQ(c.welcome().areas[0], protocol::AreaInfo{});
}

TEST_F(Soft, AResumedSessionKeepsItsSamples) {
  start();
  TestClient c = client();
  protocol::Hello wanted = hello(4);
  wanted.samples = to_byte({4, Occlusion::half});
  wanted.features |= protocol::kFeatureResume;
  ASSERT_TRUE(c.join(wanted));
  c.send_view(1, 1);
  EXPECT_TRUE(counts_are_right(c, c.receive_frame(1), 1));
  c.lose_control();
  TestClient again = client();
  ASSERT_TRUE(again.resume(c));
  EXPECT_EQ(again.welcome().samples, to_byte({4, Occlusion::half}));
  EXPECT_EQ(again.welcome().areas.size(), 1u);
  again.send_view(2, 3);
  EXPECT_TRUE(counts_are_right(again, again.receive_frame(2), 3));
}

}  // namespace
}  // namespace gnomon::daemon
