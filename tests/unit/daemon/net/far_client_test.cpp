// A client far away that asks at a steady rate. Whatever arrives late or is answered twice on such a path, the client's
// frames are right, and it does not take any of them for those of a broken server.
#include "client/stream/visibility_stream.h"
#include "client/view/client_renderer.h"
#include "gpu/wire/translate.h"
#include "protocol/pin.h"
#include "tests/tools/netsim/relay.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr uint16_t kWidth = 640, kHeight = 480;
constexpr uint32_t kFrames = 60;  // complete frames to wait for
constexpr auto kEvery = 16667us;  // between cameras

// The simulated link between client and server, on a thread of its own.
class Link {
 public:
  Link(const Daemon& daemon, const netsim::Profile& each_way) {
    netsim::RelayOptions options;
    options.tcp_ports = {daemon.control_port()};
    options.udp_ports = daemon.server().data_ports();
    options.up = options.down = {{.from = {}, .profile = each_way}};
    auto opened = netsim::Relay::open(io_, options);
    EXPECT_TRUE(opened) << opened.error().message;
    relay_ = std::move(*opened);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Link() {
    io_.stop();
    thread_.join();
  }

 private:
  asio::io_context io_{1};
  std::unique_ptr<netsim::Relay> relay_;
  std::thread thread_;
};

protocol::CameraView camera_at(uint32_t frame) {
  protocol::CameraView camera;
  camera.position = {static_cast<float>(frame), 0, 0};
  return camera;
}

class FarClient : public Served, public testing::WithParamInterface<std::pair<const char*, protocol::CodecId>> {};

TEST_P(FarClient, GetsWhatItAskedForAndNothingWrong) {
  frame_time_ = 3ms;
  config_.scheduler.quantum = 0us;  // no bands, as the fake renderer's delay applies to each band
  start();
  netsim::Profile profile;
  std::stringstream settings(GetParam().first);
  for (std::string one; std::getline(settings, one, ',');) ASSERT_TRUE(netsim::apply(one, profile));
  const Link link(*daemon_, profile);

  client::Loop loop;
  client::StreamOptions options;
  options.connect.server = {"127.0.0.2", daemon_->control_port()};
  options.connect.trust.pin = protocol::to_string(daemon_->pin());
  options.connect.hello = TestClient::hello(kScene);
  options.connect.hello.width = kWidth;
  options.connect.hello.height = kHeight;
  options.connect.hello.rate_hz = 60;
  options.connect.hello.codecs = {GetParam().second};
  uint32_t whole = 0, other = 0;
  client::VisibilityStream stream(loop, options, {.answer = [&](const client::Answer& answer) {
                                    if (!answer.mask.complete()) return;
                                    ++whole;
                                    const auto view = gpu::from_wire(answer.camera);
                                    for (size_t word = 0; word < answer.mask.words.size(); ++word)
                                      other += answer.mask.words[word] != fake_word(view, word);
                                  }});
  ASSERT_TRUE(stream.wait_open());
  uint32_t asked = 0;
  client::Timer pace(loop, [&] {
    stream.ask(camera_at(++asked));
    if (whole < kFrames) pace.arm(Clock::now() + kEvery);
  });
  pace.arm(Clock::now());
  EXPECT_TRUE(loop.run_until(Clock::now() + 60s, [&] { return whole >= kFrames; })) << whole;
  const auto& counters = stream.counters();
  EXPECT_EQ(other, 0u) << "words";
  EXPECT_EQ(counters.invalid_slices, 0u);
}

INSTANTIATE_TEST_SUITE_P(Paths, FarClient,
                         testing::Values(std::pair{"delay=115ms,loss=2%", protocol::CodecId::tiles_lz4},
                                         std::pair{"delay=115ms,loss=2%", protocol::CodecId::tiles_context}));

}  // namespace
}  // namespace gnomon::daemon
