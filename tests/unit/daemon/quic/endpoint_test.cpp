// The QUIC endpoint against ngtcp2's client, over a link in virtual time: sessions, datagrams, loss, and what strangers
// send.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <random>

#include "daemon/quic/connection.h"
#include "tests/unit/daemon/quic/quic_client.h"

namespace gnomon::daemon::quic {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<uint8_t>;

class QuicTest : public testing::Test {
 protected:
  static constexpr auto kDelay = 10ms;  // one way

  QuicTest() {
    const auto identity = make_certificate({.name = "test", .hosts = {"here"}, .lasts = 24h});
    options_.identity = *identity;
    options_.local = address_of("192.0.2.1", 7600);
  }

  void open_endpoint() { endpoint_ = std::move(*make_endpoint(options_)); }

  QuicClient& add_client(const char* host = "192.0.2.2",
                         QuicClient::Request request = QuicClient::session_request("/session?ticket=abc")) {
    clients_.push_back(std::make_unique<QuicClient>(address_of(host, static_cast<uint16_t>(4000 + clients_.size())),
                                                    options_.local, std::move(request), now_));
    return *clients_.back();
  }

  // Everything that happens within the time: packets arrive kDelay after they were sent, unless lost.
  void run(Nanoseconds time) {
    for (const TimePoint end = now_ + time; now_ < end; now_ += 1ms) step();
  }

  void step() {
    for (const auto& client : clients_) client->expire(now_);
    if (endpoint_->wake_at() <= now_) endpoint_->expire(now_);
    while (!flying_.empty() && flying_.front().at <= now_) {
      const Flying flying = std::move(flying_.front());
      flying_.pop_front();
      if (flying.to == options_.local) {
        endpoint_->receive(flying.bytes, flying.from, now_);
      } else {
        for (const auto& client : clients_) {
          if (client->address() == flying.to) client->receive(flying.bytes, now_);
        }
      }
    }
    handle_events();
    for (const auto& client : clients_) {
      for (Bytes& packet : client->take_packets(now_)) {
        send({now_ + kDelay, client->address(), options_.local, std::move(packet)});
      }
    }
    for (Packet& packet : endpoint_->take_packets(now_)) {
      send({now_ + kDelay, options_.local, packet.to, std::move(packet.bytes)});
    }
  }

  struct Flying {
    TimePoint at;
    Address from, to;
    Bytes bytes;
  };

  void send(Flying flying) {
    if (losses_(random_)) return;
    flying_.push_back(std::move(flying));
  }

  void handle_events() {
    for (Event& event : endpoint_->take_events()) {
      if (const auto* asked = std::get_if<SessionAsked>(&event.what)) {
        asked_.push_back(*asked);
        last_ = event.connection;
        if (answer_ == 200) {
          endpoint_->accept(event.connection, now_);
        } else if (answer_ != 0) {
          endpoint_->refuse(event.connection, answer_, now_);
        }
      }
      if (auto* datagram = std::get_if<Datagram>(&event.what)) datagrams_.push_back(std::move(datagram->bytes));
      if (const auto* outcome = std::get_if<Outcome>(&event.what)) outcomes_.push_back(*outcome);
      if (std::holds_alternative<Room>(event.what)) ++rooms_;
      if (std::holds_alternative<Closed>(event.what)) ++closed_;
    }
  }

  Options options_;
  std::unique_ptr<Endpoint> endpoint_;
  std::vector<std::unique_ptr<QuicClient>> clients_;
  std::deque<Flying> flying_;
  std::mt19937 random_{1};
  std::bernoulli_distribution losses_{0};
  int answer_ = 200;  // to sessions; 0: none
  std::vector<SessionAsked> asked_;
  std::vector<Bytes> datagrams_;
  std::vector<Outcome> outcomes_;
  ConnectionId last_ = 0;
  size_t rooms_ = 0, closed_ = 0;
  TimePoint now_{1h};
};

TEST_F(QuicTest, SessionIsAskedForAndCarriesDatagramsBothWays) {
  open_endpoint();
  QuicClient& client = add_client();
  run(200ms);
  ASSERT_EQ(asked_.size(), 1u);
  EXPECT_EQ(asked_[0].path, "/session?ticket=abc");
  EXPECT_EQ(asked_[0].origin, "https://here:7600");
  EXPECT_EQ(asked_[0].authority, "here:7600");
  EXPECT_EQ(client.status(), 200);
  EXPECT_EQ(endpoint_->half_open(), 0u);

  client.send_datagram({1, 2, 3});
  EXPECT_TRUE(endpoint_->send(last_, 7, Bytes{4, 5}, Bytes{6}, now_));
  run(50ms);
  EXPECT_EQ(datagrams_, std::vector<Bytes>{(Bytes{1, 2, 3})});
  EXPECT_EQ(client.take_datagrams(), std::vector<Bytes>{(Bytes{4, 5, 6})});
  run(100ms);
  ASSERT_EQ(outcomes_.size(), 1u);
  EXPECT_EQ(outcomes_[0].number, 7u);
  EXPECT_TRUE(outcomes_[0].arrived);
}

TEST_F(QuicTest, LongestDatagramFitsFromTheStart) {
  open_endpoint();
  QuicClient& client = add_client();
  run(100ms);
  const Bytes head(9, 1), body(kMostDatagramBytes - head.size(), 2);
  EXPECT_TRUE(endpoint_->send(last_, 1, head, body, now_));
  run(50ms);
  const auto got = client.take_datagrams();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].size(), kMostDatagramBytes);
}

TEST_F(QuicTest, WhatIsLostIsToldAndRoomFollowsARefusal) {
  open_endpoint();
  QuicClient& client = add_client();
  run(100ms);
  losses_ = std::bernoulli_distribution(0.02);
  uint64_t sent = 0;
  size_t refused = 0, received = 0;
  for (int i = 0; i < 3000; ++i) {
    const bool taken = endpoint_->send(last_, sent + 1, Bytes(9), Bytes(1000), now_);
    sent += taken;
    refused += !taken;
    if (!taken || i % 20 == 0) run(1ms);
    received += client.take_datagrams().size();
  }
  losses_ = std::bernoulli_distribution(0);
  run(2s);
  received += client.take_datagrams().size();
  const auto lost = static_cast<size_t>(
      std::count_if(outcomes_.begin(), outcomes_.end(), [](const Outcome& o) { return !o.arrived; }));
  EXPECT_GT(refused, 0u);
  EXPECT_GT(rooms_, 0u);
  EXPECT_GT(lost, 0u);
  EXPECT_EQ(outcomes_.size(), sent) << "each datagram has arrived or is lost";
  EXPECT_LT(received, sent);
  EXPECT_GE(received + lost, sent);
}

// Its callers read the clock apart from each other, and hand over what they have read in any order.
TEST_F(QuicTest, TimeThatGoesBackDoesNoHarm) {
  open_endpoint();
  QuicClient& client = add_client();
  run(100ms);
  EXPECT_TRUE(endpoint_->send(last_, 1, Bytes{1}, Bytes{2}, now_ + 5ms));
  EXPECT_TRUE(endpoint_->send(last_, 2, Bytes{3}, Bytes{4}, now_));
  run(100ms);
  EXPECT_EQ(client.take_datagrams().size(), 2u);
}

TEST_F(QuicTest, ClientThatMovesIsFollowed) {
  open_endpoint();
  QuicClient& client = add_client();
  run(200ms);
  client.move_to(address_of("198.51.100.7", 5555));
  client.send_datagram({1});
  run(500ms);
  EXPECT_TRUE(endpoint_->send(last_, 1, Bytes{2}, {}, now_));
  run(200ms);
  EXPECT_EQ(client.take_datagrams(), std::vector<Bytes>{Bytes{2}});
}

TEST_F(QuicTest, RefusedSessionIsToldTheStatusAndIsGone) {
  open_endpoint();
  answer_ = 403;
  QuicClient& client = add_client();
  run(300ms);
  EXPECT_EQ(client.status(), 403);
  EXPECT_TRUE(client.is_over());
  EXPECT_EQ(endpoint_->connections(), 0u);
  EXPECT_EQ(closed_, 0u);
}

TEST_F(QuicTest, OtherRequestsEndTheConnection) {
  open_endpoint();
  QuicClient& client =
      add_client("192.0.2.2", {{":method", "GET"}, {":scheme", "https"}, {":authority", "here"}, {":path", "/"}});
  run(300ms);
  EXPECT_TRUE(asked_.empty());
  EXPECT_TRUE(client.is_over());
  EXPECT_EQ(client.error_code(), 0x10eu);
  EXPECT_EQ(endpoint_->connections(), 0u);
}

TEST_F(QuicTest, ConnectionWithoutASessionIsDroppedAfterTheTime) {
  open_endpoint();
  answer_ = 0;
  add_client();
  run(options_.limits.patience - 500ms);
  EXPECT_EQ(endpoint_->half_open(), 1u);
  run(1s);
  EXPECT_EQ(endpoint_->connections(), 0u);
}

TEST_F(QuicTest, ClientThatLeavesOrFallsSilentIsToldOf) {
  open_endpoint();
  QuicClient& leaving = add_client();
  add_client();
  run(200ms);
  EXPECT_EQ(endpoint_->connections(), 2u);
  leaving.close(now_);
  run(100ms);
  EXPECT_EQ(closed_, 1u);
  losses_ = std::bernoulli_distribution(1);
  run(options_.limits.silence + 2s);
  EXPECT_EQ(closed_, 2u);
  EXPECT_EQ(endpoint_->connections(), 0u);
}

TEST_F(QuicTest, AboveTheThresholdAnAddressIsProvedFirst) {
  options_.limits.retry_above = 1;
  open_endpoint();
  answer_ = 0;
  QuicClient& first = add_client("192.0.2.2");
  run(100ms);
  QuicClient& second = add_client("192.0.2.3");
  run(5ms);
  EXPECT_FALSE(first.was_retried());
  run(195ms);
  EXPECT_TRUE(second.was_retried());
  EXPECT_EQ(asked_.size(), 2u) << "the second is let in with its token";
}

TEST_F(QuicTest, OneAddressAndAllTogetherHaveABound) {
  options_.limits.per_network = 2;
  options_.limits.half_open = 3;
  options_.limits.retry_above = 100;
  open_endpoint();
  answer_ = 0;
  for (int i = 0; i < 4; ++i) add_client("192.0.2.2");
  run(200ms);
  EXPECT_EQ(endpoint_->connections(), 2u);
  for (const char* host : {"192.0.2.3", "2001:db8::1", "2001:db8::2"}) {
    if (std::string(host).find(':') == std::string::npos) add_client(host);
  }
  add_client("192.0.2.4");
  run(200ms);
  EXPECT_EQ(endpoint_->half_open(), 3u);
}

// A connection that its first packets close again holds no place, and costs a handshake nevertheless.
TEST_F(QuicTest, HandshakesOfANetworkHaveARate) {
  options_.limits.per_network = 4;
  options_.limits.per_network_per_s = 1;
  options_.limits.retry_above = 0;
  open_endpoint();
  const auto send_all_of = [&](QuicClient& client) {
    for (const Bytes& packet : client.take_packets(now_)) endpoint_->receive(packet, client.address(), now_);
    return endpoint_->take_packets(now_);
  };
  const auto answered_of = [&](int clients, const char* host) {
    int answered = 0;
    for (int i = 0; i < clients; ++i) {
      QuicClient& client = add_client(host);
      for (const Packet& retry : send_all_of(client)) client.receive(retry.bytes, now_);
      EXPECT_TRUE(client.was_retried());
      const auto answer = send_all_of(client);
      answered += answer.empty() ? 0 : 1;
      for (const Packet& packet : answer) client.receive(packet.bytes, now_);
      client.close(now_);
      send_all_of(client);
      EXPECT_EQ(endpoint_->connections(), 0u) << "it has closed";
    }
    return answered;
  };
  EXPECT_EQ(answered_of(20, "192.0.2.2"), 4);
  EXPECT_EQ(answered_of(3, "192.0.2.3"), 3) << "others are not to suffer";
  now_ += 2s;
  EXPECT_EQ(answered_of(20, "192.0.2.2"), 2);
}

// Who writes another's address into its packets spends nothing of the other's.
TEST_F(QuicTest, UnprovedHandshakesCountForNobody) {
  options_.limits.per_network = 4;
  options_.limits.per_network_per_s = 1;
  options_.limits.retry_above = 1000;
  open_endpoint();
  for (int i = 0; i < 20; ++i) {
    QuicClient& client = add_client("192.0.2.2");
    for (const Bytes& packet : client.take_packets(now_)) endpoint_->receive(packet, client.address(), now_);
    EXPECT_FALSE(endpoint_->take_packets(now_).empty());
    client.close(now_);
    for (const Bytes& packet : client.take_packets(now_)) endpoint_->receive(packet, client.address(), now_);
    endpoint_->take_packets(now_);
  }
}

// Whoever can write any sender's address into its packets has no network.
TEST_F(QuicTest, BeyondARateAddressesAreProvedFirst) {
  options_.limits.unvalidated_per_s = 3;
  options_.limits.retry_above = 1000;
  open_endpoint();
  for (int i = 0; i < 10; ++i) add_client(("192.0.2." + std::to_string(10 + i)).c_str());
  run(200ms);
  EXPECT_EQ(
      std::count_if(clients_.begin(), clients_.end(), [](const auto& client) { return client->was_retried(); }), 7);
  EXPECT_EQ(asked_.size(), 10u) << "they are let in with their tokens";
}

// First packets of a client, cut and bent: no crash, and at most one answer each, no longer than what asked for it
// three times over.
TEST_F(QuicTest, MalformedFirstPacketsAreHarmless) {
  options_.limits.half_open = options_.limits.per_network = 100000;
  options_.limits.retry_above = 10;
  open_endpoint();
  QuicClient& client = add_client();
  const auto first = client.take_packets(now_);
  ASSERT_FALSE(first.empty());
  const Address from = address_of("203.0.113.9", 99);
  const auto flood = [&](const Bytes& packet) {
    endpoint_->receive(packet, from, now_);
    size_t answered = 0;
    for (const Packet& answer : endpoint_->take_packets(now_)) answered += answer.bytes.size();
    EXPECT_LE(answered, 3 * packet.size());
    endpoint_->take_events();
  };
  for (size_t size = 0; size < first[0].size(); size += size < 64 ? 1 : 37) {
    flood(Bytes(first[0].begin(), first[0].begin() + static_cast<std::ptrdiff_t>(size)));
  }
  std::mt19937 random(3);
  for (int i = 0; i < 400; ++i) {
    Bytes packet = first[0];
    for (int bent = 0; bent < 1 + i % 4; ++bent) {
      packet[random() % (bent == 0 ? 60 : packet.size())] = static_cast<uint8_t>(random());
    }
    flood(packet);
  }
  flood(Bytes(1200, 0xff));
  EXPECT_LE(endpoint_->half_open(), 10u);
  Bytes unknown = first[0];
  unknown[4] = 0x55;  // a version that we do not speak
  endpoint_->receive(unknown, from, now_);
  const auto answer = endpoint_->take_packets(now_);
  ASSERT_EQ(answer.size(), 1u);
  EXPECT_LT(answer[0].bytes.size(), 100u);
}

TEST_F(QuicTest, CertificateThatCannotBeUsedIsSaid) {
  options_.identity.key = "nonsense";
  EXPECT_FALSE(make_endpoint(options_));
  options_.identity = *make_certificate({.name = "test", .hosts = {"here"}, .lasts = 1h});
  open_endpoint();
  EXPECT_FALSE(endpoint_->set_identity({"x", "y"}));
  EXPECT_TRUE(endpoint_->set_identity(*make_certificate({.name = "next", .hosts = {"here"}, .lasts = 1h})));
  add_client();
  run(200ms);
  EXPECT_EQ(asked_.size(), 1u);
}

}  // namespace
}  // namespace gnomon::daemon::quic
