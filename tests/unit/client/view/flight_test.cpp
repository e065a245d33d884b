// A flight of the reference client against a scripted server.
#include "client/view/flight.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/watched.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace tests;
using namespace std::chrono_literals;

// Where the client has no GPU a drawing may take longer than the server bears silence.
TEST(Flight, SaysByeBeforeItDrawsWhatWasAnsweredLast) {
  const auto mask = tests::noise(kGrid, 1);
  std::atomic<bool> bye{false}, over{false};
  FakeServer server([&](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
    for (int frame = 0; frame < 2; ++frame) {
      const auto camera = peer.read_new_camera();
      if (camera) peer.send_frame(camera->frame, mask.view());
    }
    while (const auto message = peer.read()) {
      if (std::holds_alternative<protocol::Bye>(*message)) bye = true;
      if (bye) break;
    }
    over = true;
  });
  FlightOptions options;
  options.stream = tests::options_for(server.address());
  options.size = {kWidth, kHeight, 0, 0};
  options.frames = 2;
  Flight flight(std::move(options));
  ASSERT_TRUE(flight.open());
  int drawn = 0;
  const auto draw = [&](const Showing&) -> Result<void> {
    if (++drawn < 2) return {};
    while (!over) std::this_thread::sleep_for(1ms);  // the loop does not run, whatever this takes
    EXPECT_TRUE(bye);
    return {};
  };
  Progress progress;
  const auto flown = flight.fly(CameraPath::orbit(flight.welcome().scene), draw, progress);
  EXPECT_TRUE(flown) << flown.error().message;
  EXPECT_EQ(drawn, 2);
  EXPECT_EQ(flight.figures().counters.complete, 2u);
}

}  // namespace
}  // namespace gnomon::client
