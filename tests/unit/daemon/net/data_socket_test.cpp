// The data socket's sending: with and without segmentation offload the same datagrams arrive.
#include "daemon/net/data_socket.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using asio::ip::udp;
using Datagrams = std::vector<std::vector<uint8_t>>;

class DataSocketTest : public testing::TestWithParam<asio::ip::address> {
 protected:
  void SetUp() override {
    asio::error_code error;
    receiver_.open(udp::endpoint(GetParam(), 0).protocol(), error);
    if (!error) receiver_.bind({GetParam(), 0}, error);
    if (error) GTEST_SKIP() << "this machine has no " << GetParam() << ": " << error.message();
    receiver_.set_option(asio::socket_base::receive_buffer_size(4 << 20));
    sender_ = std::move(*DataSocket::open(io_, {GetParam(), 0}));
  }

  // The datagrams that arrive when these are sent.
  Datagrams through(const Datagrams& sent) {
    asio::error_code error;
    EXPECT_EQ(sender_->send(sent, receiver_.local_endpoint(), error), sent.size()) << error.message();
    Datagrams got;
    receiver_.non_blocking(true);  // loopback delivers within the call
    for (std::vector<uint8_t> datagram(65536);;) {
      const size_t bytes = receiver_.receive(asio::buffer(datagram), 0, error);
      if (error) return got;
      got.emplace_back(datagram.begin(), datagram.begin() + static_cast<long>(bytes));
    }
  }

  static Datagrams of_sizes(const std::vector<size_t>& sizes) {
    Datagrams made;
    for (const size_t size : sizes) made.emplace_back(size, static_cast<uint8_t>(made.size() + 1));
    return made;
  }

  asio::io_context io_;
  udp::socket receiver_{io_};
  std::unique_ptr<DataSocket> sender_;
};

TEST_P(DataSocketTest, DatagramsArriveAsTheyWereSent) {
  for (const auto& sizes : std::vector<std::vector<size_t>>{{100},
                                                            {100, 200, 300},
                                                            {300, 200, 100},
                                                            std::vector<size_t>(10, 1200),
                                                            std::vector<size_t>(200, 1200),
                                                            {1200, 1200, 1200, 700, 1200, 1200, 50, 60, 60},
                                                            std::vector<size_t>(20, 8952)}) {
    const Datagrams sent = of_sizes(sizes);
    EXPECT_EQ(through(sent), sent) << sizes.size() << " datagrams, the first of " << sizes[0] << " bytes";
  }
}

TEST_P(DataSocketTest, WhatThePathsFirstHopRefusesIsAnError) {
  asio::error_code error;
  EXPECT_EQ(sender_->send(of_sizes({65535}), receiver_.local_endpoint(), error), 0u);
  EXPECT_EQ(error, asio::error::message_size);
  EXPECT_EQ(through(of_sizes({100, 100})).size(), 2u) << "and the socket goes on";
}

// As a stranger's datagram may name port 0 as its own.
TEST_P(DataSocketTest, WhatOneAddressRefusesChangesNothingForOthers) {
  if (!sender_->segments()) GTEST_SKIP() << "this kernel cuts no buffers";
  asio::error_code error;
  EXPECT_EQ(sender_->send(of_sizes({1200, 1200}), {GetParam(), 0}, error), 0u);
  EXPECT_TRUE(error);
  EXPECT_TRUE(sender_->segments());
}

INSTANTIATE_TEST_SUITE_P(Addresses, DataSocketTest,
                         testing::Values(asio::ip::make_address("127.0.0.1"), asio::ip::make_address("::1")));

}  // namespace
}  // namespace gnomon::daemon
