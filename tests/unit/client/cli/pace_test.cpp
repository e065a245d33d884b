// The small parts around a stream: pacing, modes, percentiles, addresses.
#include <gtest/gtest.h>

#include "client/cli/camera_pacer.h"
#include "client/cli/latency.h"
#include "client/net/address.h"
#include "client/prediction/mode.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

const TimePoint kStart = TimePoint{} + 1h;

TEST(CameraPacer, KeepsItsRateWhateverIsInFlightWithoutAWindow) {
  CameraPacer pacer({.rate_hz = 100, .max_in_flight = 0}, kStart);
  TimePoint now = kStart;
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(pacer.next_send(static_cast<size_t>(i)), kStart + i * 10ms);
    now = kStart + i * 10ms;
    pacer.sent(now);
  }
}

TEST(CameraPacer, DoesNotMakeUpForAPause) {
  CameraPacer pacer({.rate_hz = 100, .max_in_flight = 0}, kStart);
  pacer.sent(kStart);
  pacer.sent(kStart + 5s);
  EXPECT_EQ(pacer.next_send(0), kStart + 5s);
  pacer.sent(kStart + 5s);
  EXPECT_EQ(pacer.next_send(0), kStart + 5s + 10ms);
}

TEST(CameraPacer, AFullWindowWaitsForAnAnswerAndMovesOnWhenItMustBeLost) {
  CameraPacer pacer({.rate_hz = 0, .max_in_flight = 2}, kStart);
  EXPECT_LE(pacer.next_send(0), kStart);
  pacer.sent(kStart + 1ms);
  EXPECT_LE(pacer.next_send(1), kStart + 1ms) << "room for another";
  pacer.sent(kStart + 2ms);
  EXPECT_EQ(pacer.next_send(2), kStart + 2ms + pacer.answer_patience());
  EXPECT_LE(pacer.next_send(1), kStart + 2ms) << "an answer makes room at once";
}

TEST(CameraPacer, PatienceFollowsTheServer) {
  CameraPacer pacer({.rate_hz = 0, .max_in_flight = 1}, kStart);
  EXPECT_GE(pacer.answer_patience(), 5s) << "nothing known yet";
  for (int i = 0; i < 50; ++i) pacer.answered(20ms);
  EXPECT_EQ(pacer.answer_patience(), 1s) << "never hasty";
  for (int i = 0; i < 50; ++i) pacer.answered(i % 2 == 0 ? 4s : 8s);
  EXPECT_GE(pacer.answer_patience(), 8s) << "a slow server's usual answers are waited for";
  EXPECT_LE(pacer.answer_patience(), 20s);
}

TEST(Mode, NamesRoundTripAndOthersAreRefusedWithWhatIsAllowed) {
  for (const Mode mode : {Mode::sequential, Mode::non_sequential, Mode::queued, Mode::predicted, Mode::automatic})
    EXPECT_EQ(*parse_mode(to_string(mode)), mode);
  const auto unknown = parse_mode("telepathic");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message,
            "unknown mode 'telepathic': allowed are sequential, non-sequential, queued, predicted, auto");
  EXPECT_EQ(max_in_flight(Mode::sequential), 1u);
  EXPECT_GT(max_in_flight(Mode::queued), 1u);
}

TEST(Latencies, PercentilesAreNearestRanks) {
  Latencies latencies;
  EXPECT_EQ(latencies.percentile(0.5), 0ns);
  for (int i = 100; i >= 1; --i) latencies.add(i * 1ms);
  EXPECT_EQ(latencies.percentile(0), 1ms);
  EXPECT_EQ(latencies.percentile(0.5), 50ms);
  EXPECT_EQ(latencies.percentile(0.99), 99ms);
  EXPECT_EQ(latencies.percentile(1), 100ms);
  Latencies both;
  both.add(1s);
  both.add(latencies);
  EXPECT_EQ(both.percentile(1), 1s);
  EXPECT_EQ(both.count(), 101u);
}

TEST(Address, TakesNamesAndBothKindsOfNumericAddresses) {
  EXPECT_EQ(parse_address("localhost:7311")->host, "localhost");
  EXPECT_EQ(parse_address("[::1]:80")->host, "::1");
  EXPECT_EQ(parse_address("[::1]:80")->port, 80);
  for (const char* text : {"[::1]:80", "127.0.0.1:65535", "edge.example:1"}) {
    EXPECT_EQ(to_string(*parse_address(text)), text);
  }
  for (const char* text : {"", "host", "host:", "host:0", "host:65536", "host:7x", ":7311", "::1:80", "[]:1"}) {
    const auto address = parse_address(text);
    ASSERT_FALSE(address) << text;
    EXPECT_NE(address.error().message.find("HOST:PORT"), std::string::npos);
  }
}

}  // namespace
}  // namespace gnomon::client
