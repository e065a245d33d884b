// The relay with real sockets. link_test.cpp tests what happens to packets; these tests check that packets reach the
// right socket.
#include "tests/tools/netsim/relay.h"

#include <gtest/gtest.h>

#include <asio/ip/tcp.hpp>
#include <asio/write.hpp>

namespace gnomon::netsim {
namespace {

using asio::ip::tcp;
using asio::ip::udp;
using namespace std::chrono_literals;

class RelayTest : public testing::Test {
 protected:
  void open(Schedule up = {Phase{}}, Schedule down = {Phase{}}) {
    RelayOptions options;
    options.tcp_ports = {acceptor_.local_endpoint().port()};
    options.udp_ports = {server_.local_endpoint().port()};
    options.up = std::move(up);
    options.down = std::move(down);
    auto made = Relay::open(io_, options);
    ASSERT_TRUE(made) << made.error().message;
    relay_ = std::move(*made);
    echo();
  }

  // Waits for the condition; the limit only bounds a failing test.
  bool until(const std::function<bool()>& done) {
    const TimePoint end = Clock::now() + 20s;
    while (!done()) {
      if (io_.run_one_until(end) == 0) return done();
    }
    return true;
  }

  void echo() {
    server_.async_receive_from(asio::buffer(at_server_), from_,
                               [this](const asio::error_code& error, size_t count) {
                                 if (error) return;
                                 peers_.insert(from_);
                                 server_.send_to(asio::buffer(at_server_, count), from_);
                                 echo();
                               });
  }

  udp::endpoint relayed() { return {asio::ip::make_address("127.0.0.2"), server_.local_endpoint().port()}; }

  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_, {asio::ip::address_v4::loopback(), 0}};
  udp::socket server_{io_, {asio::ip::address_v4::loopback(), 0}};
  std::array<uint8_t, 2048> at_server_{};
  udp::endpoint from_;
  std::set<udp::endpoint> peers_;
  std::unique_ptr<Relay> relay_;
};

TEST_F(RelayTest, DatagramsComeBackToWhoSentThem) {
  open();
  udp::socket one(io_, udp::endpoint(udp::v4(), 0)), two(io_, udp::endpoint(udp::v4(), 0));
  std::string got_one(10, ' '), got_two(10, ' ');
  size_t size_one = 0, size_two = 0;
  one.async_receive(asio::buffer(got_one), [&](const asio::error_code&, size_t count) { size_one = count; });
  two.async_receive(asio::buffer(got_two), [&](const asio::error_code&, size_t count) { size_two = count; });
  one.send_to(asio::buffer("first", 5), relayed());
  two.send_to(asio::buffer("second", 6), relayed());
  ASSERT_TRUE(until([&] { return size_one > 0 && size_two > 0; }));
  EXPECT_EQ(got_one.substr(0, size_one), "first");
  EXPECT_EQ(got_two.substr(0, size_two), "second");
  EXPECT_EQ(peers_.size(), 2u) << "the server tells its clients apart";
  EXPECT_EQ(relay_->counters().datagrams, 4u);
}

TEST_F(RelayTest, EachDirectionHasItsOwnLuck) {
  Profile dead;
  dead.loss = 1;
  open({Phase{}}, {{0s, dead}});
  udp::socket client(io_, udp::endpoint(udp::v4(), 0));
  client.send_to(asio::buffer("lost", 4), relayed());
  ASSERT_TRUE(until([&] { return relay_->counters().lost == 1; }));
  EXPECT_EQ(peers_.size(), 1u) << "it came to the server, the answer was lost";
}

// Through losses and a slow link TCP's bytes arrive completely and in order.
TEST_F(RelayTest, AStreamArrivesWholeAndInOrder) {
  Profile bad;
  ASSERT_TRUE(apply("loss=20%,rate=50mbit,queue=2ms,delay=100us", bad));
  open({{0s, bad}}, {{0s, bad}});
  std::string sent(200000, ' '), got;
  for (size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<char>('a' + i % 26 + i / 26 % 3);
  tcp::socket client(io_), peer(io_);
  bool ended = false;
  std::array<char, 4096> chunk;
  std::function<void()> read = [&] {
    peer.async_read_some(asio::buffer(chunk), [&](const asio::error_code& error, size_t count) {
      got.append(chunk.data(), count);
      ended = bool(error);
      if (!ended) read();
    });
  };
  acceptor_.async_accept(peer, [&](const asio::error_code& error) {
    ASSERT_FALSE(error);
    read();
  });
  client.async_connect(
      {asio::ip::make_address("127.0.0.2"), acceptor_.local_endpoint().port()}, [&](const asio::error_code& error) {
        ASSERT_FALSE(error);
        asio::async_write(client, asio::buffer(sent),
                          [&](const asio::error_code&, size_t) { client.shutdown(tcp::socket::shutdown_send); });
      });
  ASSERT_TRUE(until([&] { return ended; }));
  EXPECT_TRUE(got == sent) << got.size() << " bytes of " << sent.size();
}

TEST_F(RelayTest, AnAddressThatIsTakenIsNamed) {
  RelayOptions options;
  options.listen = "127.0.0.1";
  options.udp_ports = {server_.local_endpoint().port()};
  const auto made = Relay::open(io_, options);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find(std::to_string(options.udp_ports[0])), std::string::npos);
}

}  // namespace
}  // namespace gnomon::netsim
