// How a session is opened or fails to open, against a scripted server.
#include <gtest/gtest.h>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/watched.h"

namespace gnomon::client {
namespace {

using namespace tests;
using namespace std::chrono_literals;

TEST(Connection, SaysHelloAndIsWelcomed) {
  std::optional<protocol::Message> hello, bye;
  {
    FakeServer server([&](Peer& peer) {
      hello = peer.read();
      peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
      bye = peer.read();
    });
    auto options = options_for(server.address());
    options.connect.hello.tenant = "museum";
    options.connect.hello.token = "secret";
    Watched watched(options);
    const auto opened = watched.stream.wait_open();
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(watched.stream.grid(), kGrid);
    EXPECT_EQ(watched.stream.scene().name, "little");
    EXPECT_EQ(watched.stream.connection().state(), Connection::State::open);
    watched.stream.close("seen enough");
    EXPECT_EQ(watched.stream.connection().state(), Connection::State::closed);
    EXPECT_FALSE(watched.stream.connection().failure()) << "closing on purpose is no failure";
  }
  ASSERT_TRUE(hello && bye);
  EXPECT_EQ(std::get<protocol::Hello>(*hello).tenant, "museum");
  EXPECT_EQ(std::get<protocol::Hello>(*hello).token, "secret");
  EXPECT_EQ(std::get<protocol::Bye>(*bye).reason, "seen enough");
}

// Whether datagrams are chosen or found to pass: the server hears of the address before the first camera.
TEST(Connection, ProvesItsAddressAsSoonAsItIsWelcome) {
  for (const Transport transport : {Transport::automatic, Transport::udp}) {
    bool pinged = false, offered = false;
    std::vector<std::optional<uint64_t>> tokens;
    {
      FakeServer server([&](Peer& peer) {
        const auto hello = peer.read();
        offered = (std::get<protocol::Hello>(*hello).features & protocol::kFeaturePaths) != 0;
        auto welcome = tests::small_welcome(kWidth, kHeight, kLights);
        welcome.features = protocol::kFeaturePaths;
        peer.welcome(welcome);
        pinged = peer.read_ping();
        for (const uint64_t token : {uint64_t{0x0123456789abcdef}, uint64_t{7}}) {
          peer.challenge(token);
          tokens.push_back(peer.read_path_response());
        }
        peer.hang_up();
      });
      auto options = options_for(server.address());
      options.connect.transport = transport;
      Watched watched(options);
      ASSERT_TRUE(watched.stream.wait_open());
      watched.loop.run_until(Clock::now() + 5s,
                             [&] { return watched.stream.connection().state() == Connection::State::closed; });
    }
    EXPECT_TRUE(offered);
    EXPECT_TRUE(pinged);
    EXPECT_EQ(tokens, (std::vector<std::optional<uint64_t>>{0x0123456789abcdef, 7}));
  }
}

TEST(Connection, ARefusalSaysWhyAndWhatWouldFit) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.write(protocol::Refused{protocol::RefusalCode::over_capacity, "the device is full", 1280, 720, 30});
  });
  Watched watched(options_for(server.address()));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().message, "refused (over_capacity): the device is full; would fit: 1280x720 at 30 Hz");
  ASSERT_TRUE(watched.stream.connection().refusal());
  EXPECT_EQ(watched.stream.connection().refusal()->code, protocol::RefusalCode::over_capacity);
}

TEST(Connection, WhatAServerSaysStaysOneLineAsItReads) {
  const auto heard = [](const protocol::Message& said) {
    FakeServer server([&](Peer& peer) {
      peer.read();
      peer.write(said);
      peer.read();
    });
    Watched watched(options_for(server.address()));
    const auto opened = watched.stream.wait_open();
    return opened ? std::string("opened") : opened.error().message;
  };
  // The protocol has no control characters; these turn the direction of writing, and break the line.
  const std::string text = "no\u202egnp.exe\u2028root@here:~# ";
  const std::string shown = "no\\u202egnp.exe\\u2028root@here:~# ";
  EXPECT_EQ(heard(protocol::Refused{protocol::RefusalCode::internal, text}), "refused (internal): " + shown);
  EXPECT_EQ(heard(protocol::Bye{text}), "the server ended the session: " + shown);
}

TEST(Connection, NobodyListeningIsOneClearLine) {
  Address address;
  {
    FakeServer server([](Peer& peer) { peer.hang_up(); });
    address = server.address();
    Watched first(options_for(address));
    EXPECT_FALSE(first.stream.wait_open());
  }
  Watched watched(options_for(address));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().message.rfind("cannot reach " + to_string(address) + ": ", 0), 0u)
      << opened.error().message;
}

TEST(Connection, MalformedBytesCloseWithAReason) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.write_bytes(std::vector<uint8_t>(4096, 0xff));
    peer.read();
  });
  Watched watched(options_for(server.address()));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("malformed"), std::string::npos) << opened.error().message;
}

TEST(Connection, AnEndBeforeWelcomeIsAnError) {
  FakeServer server([](Peer& peer) { peer.read(); });
  Watched watched(options_for(server.address()));
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("closed the connection"), std::string::npos);
}

TEST(Connection, ASilentServerIsGivenUp) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.read();  // the client closes
  });
  auto options = options_for(server.address());
  options.connect.timeout = 100ms;
  Watched watched(options);
  const auto opened = watched.stream.wait_open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("no answer from 127.0.0.1:"), std::string::npos);
}

TEST(Connection, IsPatientAsLongAsTheServerSaysWhatItWaitsFor) {
  std::optional<protocol::Message> hello;
  {
    FakeServer server([&](Peer& peer) {
      hello = peer.read();
      for (uint8_t i = 0; i < 5; ++i) {
        std::this_thread::sleep_for(300ms);
        peer.write(protocol::Waiting{"the scene is being read", static_cast<uint8_t>(20 * i)});
      }
      peer.welcome(tests::small_welcome(kWidth, kHeight, kLights));
      peer.read();
    });
    auto options = options_for(server.address());
    options.connect.timeout = 1s;
    Watched watched(options);
    const auto opened = watched.stream.wait_open();
    ASSERT_TRUE(opened) << opened.error().message;
    ASSERT_EQ(watched.messages.size(), 5u);
    EXPECT_EQ(watched.messages.back(), (protocol::Message{protocol::Waiting{"the scene is being read", 80}}));
  }
  ASSERT_TRUE(hello);
  EXPECT_NE(std::get<protocol::Hello>(*hello).features & protocol::kFeatureWaiting, 0u);
}

TEST(Connection, AWelcomeLargerThanAskedForIsRefused) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(kWidth, kHeight + 1, kLights));
    peer.read();
  });
  Watched watched(options_for(server.address()));
  EXPECT_FALSE(watched.stream.wait_open());
}

}  // namespace
}  // namespace gnomon::client
