// A client of a fleet: which server its door sends it to, and where it goes on when something there ends.
#include <gtest/gtest.h>

#include <fstream>

#include "client/net/fleet_route.h"
#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/watched.h"

namespace gnomon::client {
namespace {

using namespace tests;
using namespace std::chrono_literals;
using protocol::RefusalCode;

constexpr const char* kFleet = "gnomon.example";

// What the door of a server at `home` says of it.
protocol::Welcome welcome_of(const Address& home) {
  auto welcome = small_welcome(kWidth, kHeight, kLights);
  welcome.features = protocol::kFeatureResume | protocol::kFeatureFleet;
  welcome.silence_timeout_ms = 5000;
  welcome.data_host = welcome.home_host = home.host;
  welcome.home_port = home.port;
  return welcome;
}

StreamOptions options_of_fleet(const Address& door) {
  auto options = options_for(door);
  options.connect.trust.fleet = kFleet;
  return options;
}

std::string name_of_little() { return server_name(options_of_fleet({}).connect.trust, "", "little"); }

template <class M>
bool is_a(const std::optional<protocol::Message>& message) {
  return message && std::holds_alternative<M>(*message);
}

TEST(Fleet, TheServerNameIsOfTheScene) {
  Trust trust;
  trust.fleet = kFleet;
  // printf temple | sha256sum
  EXPECT_EQ(server_name(trust, "192.0.2.7", "temple"), "s-67425801bf1a60fe.gnomon.example");
  EXPECT_NE(server_name(trust, "192.0.2.7", "living_room"), server_name(trust, "192.0.2.7", "temple"));
  EXPECT_EQ(server_name({}, "node.example", "temple"), "node.example");
  EXPECT_EQ(server_name({}, "192.0.2.7", "temple"), "") << "an address is no server name";
}

TEST(Fleet, ADoorIsToldTheSceneAndTrustedForTheFleetsName) {
  using Use = daemon::CertificateOptions::Use;
  const auto authority =
      daemon::make_certificate({.name = "ca", .hosts = {}, .use = Use::authority, .lasts = 1h}).value();
  const auto node = daemon::make_certificate({.name = kFleet, .hosts = {kFleet}, .lasts = 1h}, &authority).value();
  const std::string file = testing::TempDir() + "fleet_ca.pem";
  std::ofstream(file) << authority.certificate;
  std::string asked;
  {
    FakeServer door(
        [&](Peer& peer) {
          asked = peer.asked_name();
          if (peer.read()) peer.welcome(small_welcome(kWidth, kHeight, kLights));
        },
        1, node);
    auto options = options_of_fleet(door.address());
    options.connect.trust.pin.clear();
    options.connect.trust.authorities = file;
    Watched watched(options);
    const auto opened = watched.stream.wait_open();
    EXPECT_TRUE(opened) << opened.error().message;
  }
  EXPECT_EQ(asked, name_of_little());
}

TEST(Fleet, TheDoorIsAskedAgainWhenOneServerHasNoRoom) {
  for (const RefusalCode code : {RefusalCode::over_capacity, RefusalCode::draining, RefusalCode::internal}) {
    int asked = 0;
    {
      FakeServer door(
          [&](Peer& peer) {
            if (!is_a<protocol::Hello>(peer.read())) return;
            if (++asked < 3) return peer.write(protocol::Refused{code, "try another one"});
            peer.welcome(small_welcome(kWidth, kHeight, kLights));
          },
          3);
      Watched watched(options_of_fleet(door.address()));
      const auto opened = watched.stream.wait_open();
      EXPECT_TRUE(opened) << opened.error().message;
    }
    EXPECT_EQ(asked, 3) << protocol::to_string(code);
  }
}

TEST(Fleet, OtherRefusalsHoldForAllServers) {
  FakeServer door([](Peer& peer) {
    peer.read();
    peer.write(protocol::Refused{RefusalCode::bad_token, "no"});
  });
  Watched watched(options_of_fleet(door.address()));
  EXPECT_FALSE(watched.stream.wait_open());
}

TEST(Fleet, TheDoorIsNotAskedForEver) {
  FleetRoute route({"192.0.2.1", 7600}, true), alone({"192.0.2.1", 7600}, false);
  for (int i = 0; i < 5; ++i) {
    const auto wait = route.ask_door_again(RefusalCode::over_capacity);
    ASSERT_TRUE(wait) << i;
    EXPECT_GE(*wait, 300ms);
    EXPECT_LE(*wait, 600ms);
  }
  EXPECT_FALSE(route.ask_door_again(RefusalCode::over_capacity));
  EXPECT_FALSE(alone.ask_door_again(RefusalCode::over_capacity)) << "there is no other server";
}

TEST(Fleet, ASessionIsResumedAtItsServerAndNotAtTheDoor) {
  std::optional<protocol::Message> at_home;
  std::string name_at_home;
  {
    FakeServer home([&](Peer& peer) {
      name_at_home = peer.asked_name();
      at_home = peer.read();
      peer.write(protocol::Refused{RefusalCode::unknown_session, "it is over"});
      peer.read();
    });
    FakeServer door([&](Peer& peer) {
      peer.read();
      peer.welcome(welcome_of(home.address()));
      peer.hang_up();
    });
    Watched watched(options_of_fleet(door.address()));
    ASSERT_TRUE(watched.stream.wait_open());
    EXPECT_TRUE(watched.until([&] { return watched.stream.connection().failure().has_value(); }));
  }
  EXPECT_TRUE(is_a<protocol::Resume>(at_home));
  EXPECT_EQ(name_at_home, name_of_little());
}

TEST(Fleet, WhereTheServerIsGoneTheDoorIsAskedToResume) {
  const Address nobody = FakeServer([](Peer&) {}, 0).address();
  std::optional<protocol::Message> again;
  {
    int connections = 0;
    FakeServer door(
        [&](Peer& peer) {
          if (++connections == 2) {
            again = peer.read();
            return peer.write(protocol::Refused{RefusalCode::unknown_session, "it was another one's"});
          }
          peer.read();
          peer.welcome(welcome_of(nobody));
          peer.hang_up();
        },
        2);
    Watched watched(options_of_fleet(door.address()));
    ASSERT_TRUE(watched.stream.wait_open());
    EXPECT_TRUE(watched.until([&] { return watched.stream.connection().failure().has_value(); }));
  }
  EXPECT_TRUE(is_a<protocol::Resume>(again));
}

TEST(Fleet, AddressesThatAreNoneEndTheSession) {
  FakeServer door([](Peer& peer) {
    peer.read();
    auto welcome = welcome_of({"elsewhere.example", 7600});
    welcome.data_host = "127.0.0.1";
    peer.welcome(welcome);
    peer.read();
  });
  Watched watched(options_of_fleet(door.address()));
  EXPECT_FALSE(watched.stream.wait_open());
}

TEST(Fleet, DatagramsGoToTheServerItself) {
  auto welcome = welcome_of({"192.0.2.7", 7600});
  welcome.data_port = 7601;
  EXPECT_EQ(to_string(FleetRoute::data_address(welcome, "10.0.0.1")), "192.0.2.7:7601");
  welcome.features = 0;
  EXPECT_EQ(to_string(FleetRoute::data_address(welcome, "10.0.0.1")), "10.0.0.1:7601");
}

}  // namespace
}  // namespace gnomon::client
