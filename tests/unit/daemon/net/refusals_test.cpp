// Which Hello is refused, with which code, and which values the refusal says would fit.
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using namespace std::chrono_literals;

// A Hello and its refusal, for every code with which this server can refuse a Hello.
struct Refusal {
  const char* name;
  RefusalCode code;
  std::function<void(protocol::Hello&)> change;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

class Refuses : public Served, public testing::WithParamInterface<Refusal> {};

TEST_P(Refuses, SaysWhyAndCounts) {
  start();
  protocol::Hello hello = TestClient::hello(kScene);
  GetParam().change(hello);
  TestClient c = client();
  c.send(hello);
  const auto refused = c.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, GetParam().code) << refused->text;
  EXPECT_FALSE(refused->text.empty());
  EXPECT_FALSE(c.receive()) << "the server closes after a refusal";
  EXPECT_EQ(count_of(fault_of(GetParam().code)), 1u);
  TestClient honest = client();
  EXPECT_TRUE(honest.join(TestClient::hello(kScene)));
}

INSTANTIATE_TEST_SUITE_P(
    Codes, Refuses,
    testing::Values(
        Refusal{"version", RefusalCode::version, [](auto& h) { h.version_min = h.version_max = 999; }},
        Refusal{"tenant", RefusalCode::unknown_tenant, [](auto& h) { h.tenant = "nobody"; }},
        Refusal{"scene", RefusalCode::unknown_scene, [](auto& h) { h.scene = "nowhere"; }},
        Refusal{"broken_scene", RefusalCode::scene_unavailable, [](auto& h) { h.scene = "broken.gltf"; }},
        Refusal{"scene_without_lights", RefusalCode::scene_unavailable, [](auto& h) { h.scene = "dark.gltf"; }},
        Refusal{"size", RefusalCode::bad_size, [](auto& h) { h.width = 641; }},
        Refusal{"effect", RefusalCode::unknown_pass,
                [](auto& h) {
                  h.passes = {"hard_shadows", "fog"};
                }},
        Refusal{"pass", RefusalCode::unknown_pass,
                [](auto& h) {
                  h.passes = {"gbuffer", "bloom"};
                }}),
    [](const auto& instance) { return instance.param.name; });

TEST_F(Served, ARefusalIsLoggedWithWhoWasRefused) {
  config_.tenants = {{.name = kDefaultTenant}, {.name = "studio", .token_sha256 = {hash_of("s")}}};
  start();
  TestClient usual = client(), stranger = client(), lost = client();
  log::set_level(log::Level::info);
  testing::internal::CaptureStderr();
  protocol::Hello hello = TestClient::hello("nowhere");
  usual.send(hello);
  hello.tenant = "studio";
  stranger.send(hello);
  lost.send(protocol::Resume{.session = SessionId{42}});
  for (TestClient* each : {&usual, &stranger, &lost}) EXPECT_TRUE(each->receive_a<protocol::Refused>());
  const std::string log = testing::internal::GetCapturedStderr();
  log::set_level(log::Level::warning);
  for (const char* line :
       {"warning refused reason=bad_token text=\"no token was sent, and no certificate: this tenant's clients show "
        "one "
        "of them\" tenant=studio address=127.0.0.1\n",
        "info refused reason=unknown_scene text=", " tenant=default address=127.0.0.1\n",
        "info refused reason=unknown_session text=\"no such session, or it is over\" tenant=\"\" session=42 "
        "address=127.0.0.1\n"}) {
    EXPECT_NE(log.find(line), std::string::npos) << line << " is not in\n" << log;
  }
}

TEST_F(Served, ARefusedSizeSaysWhatWouldFit) {
  start();
  TestClient c = client();
  c.send(TestClient::hello(kScene, 2000, 100));
  const auto refused = c.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->fit_width, 640);
  EXPECT_EQ(refused->fit_height, 100);
}

TEST_F(Served, WhoseFramesFindNoMemoryAtTheLeastSizeIsRefused) {
  config_.tenants = {{.name = kDefaultTenant}, {.name = "modest", .least_size_percent = 50}};
  make_renderers_ = {[]() -> Result<std::unique_ptr<gpu::Renderer>> {
    auto made = std::make_unique<SelfRunningFakeRenderer>(3, kLights, 0ms);
    made->most_pixels = 64 * 48;
    return std::unique_ptr<gpu::Renderer>(std::move(made));
  }};
  start();
  protocol::Hello hello = TestClient::hello(kScene, 128, 96);
  TestClient proud = client(), modest = client(), small = client();
  proud.send(hello);
  const auto refused = proud.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::over_capacity);
  EXPECT_EQ(refused->text, "no memory for its frames: no memory, says the test");
  EXPECT_EQ(count_of(Fault::refused_over_capacity), 1u);
  hello.tenant = "modest";
  EXPECT_TRUE(modest.join(hello)) << "64x48 would do";
  ASSERT_TRUE(small.join(TestClient::hello(kScene, 64, 48)));
  small.send_view(1, 1);
  EXPECT_TRUE(is_frame_of(small, small.receive_frame(1), 1));
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"default\"} 1")) << "who is refused has no permit";
}

TEST_F(Served, NoSessionHasARateBeyondWhatAScreenShows) {
  start();
  protocol::Hello hello = TestClient::hello(kScene);
  hello.rate_hz = std::numeric_limits<float>::max();
  TestClient client = this->client();
  ASSERT_TRUE(client.join(hello));
  EXPECT_EQ(client.welcome().rate_hz, 1000);
}

TEST_F(Served, ARefusalForATenantsLimitSaysWhatWouldFit) {
  config_.tenants = {{.name = kDefaultTenant, .max_vbps = 50, .max_width = 200}};
  start();
  protocol::Hello hello = TestClient::hello(kScene);
  hello.rate_hz = 30;
  TestClient first = client(), second = client(), third = client();
  ASSERT_TRUE(first.join(hello));
  second.send(hello);
  const auto refused = second.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::over_capacity);
  EXPECT_EQ(refused->fit_rate_hz, 20);
  EXPECT_EQ(refused->fit_width, 0) << "no size would help";
  EXPECT_NE(refused->text.find("visibility buffers"), std::string::npos);
  hello.rate_hz = refused->fit_rate_hz;
  EXPECT_TRUE(third.join(hello));

  TestClient wide = client();
  wide.send(TestClient::hello(kScene, 400, 100));
  const auto too_wide = wide.receive_a<protocol::Refused>();
  ASSERT_TRUE(too_wide);
  EXPECT_EQ(too_wide->code, RefusalCode::bad_size);
  EXPECT_EQ(too_wide->fit_width, 200);
}

}  // namespace
}  // namespace gnomon::daemon
