// Who gets a place among connections without a session, in virtual time.
#include <gtest/gtest.h>

#include "daemon/net/half_open_places.h"
#include "daemon/net/words_for_clients.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

ClientNetwork at(const char* address) { return network_of(asio::ip::make_address(address)); }

TEST(ClientNetworks, CountAHomesIpv6AddressesAsOne) {
  EXPECT_EQ(at("2001:db8:1:2::1"), at("2001:db8:1:2:ffff::2"));
  EXPECT_NE(at("2001:db8:1:2::1"), at("2001:db8:1:3::1"));
  EXPECT_NE(at("192.0.2.1"), at("192.0.2.2"));
  EXPECT_EQ(at("192.0.2.1"), at("::ffff:192.0.2.1")) << "the same, mapped";
}

TEST(HalfOpenPlaces, OneAddressPushesOutItsOwnAlone) {
  HalfOpenPlaces<int> places(8);
  ASSERT_FALSE(places.take(0, at("192.0.2.1")));
  for (int i = 1; i <= 1000; ++i) {
    const auto out = places.take(i, at("198.51.100.7"));
    EXPECT_NE(out, 0) << "of another address, and the oldest of all";
    if (i > 7) {
      EXPECT_EQ(out, i - 7) << "its oldest";
    }
  }
  EXPECT_EQ(places.taken(), 8u);
  EXPECT_TRUE(places.give_back(0));
  EXPECT_FALSE(places.give_back(0));
}

TEST(HalfOpenPlaces, ANetworkOfManyAddressesIsOneAddress) {
  HalfOpenPlaces<int> places(8);
  places.take(0, at("192.0.2.1"));
  for (int i = 1; i <= 1000; ++i) {
    const std::string address = "2001:db8::" + std::to_string(i);
    EXPECT_NE(places.take(i, at(address.c_str())), 0);
  }
}

TEST(HalfOpenPlaces, WhoComesLaterFromElsewhereFindsAPlace) {
  HalfOpenPlaces<int> places(4);
  for (int i = 0; i < 4; ++i) places.take(i, at("192.0.2.1"));
  EXPECT_EQ(places.take(10, at("192.0.2.2")), 0);
  EXPECT_EQ(places.take(11, at("192.0.2.3")), 1);
  EXPECT_EQ(places.take(12, at("192.0.2.4")), 2);
  EXPECT_EQ(places.take(13, at("192.0.2.5")), 3) << "of equals the oldest";
}

TEST(WordsForClients, SayHowMuchOfASceneIsRead) {
  Health health;
  SceneUnderWay scene{.name = "temple", .stage = SceneUnderWay::Stage::reading, .share = 0.437};
  EXPECT_EQ(what_is_waited_for(health, scene), (protocol::Waiting{"the server is starting"}));
  health.serving = true;
  EXPECT_EQ(what_is_waited_for(health, scene), (protocol::Waiting{"the scene is being read", 43}));
  scene.share = std::nullopt;
  EXPECT_EQ(what_is_waited_for(health, scene).percent, protocol::Waiting::kUnknown);
  scene = {.name = "temple", .stage = SceneUnderWay::Stage::preparing};
  EXPECT_EQ(what_is_waited_for(health, scene), (protocol::Waiting{"the scene is being prepared on the devices"}));
}

}  // namespace
}  // namespace gnomon::daemon
