// What a proxy says of whose connection it passes on, as bytes; and what a door is told of a node.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "daemon/net/door_sign.h"
#include "daemon/net/proxy_greeting.h"
#include "daemon/net/proxy_header.h"
#include "tests/unit/daemon/net/proxy_bytes.h"

namespace gnomon::daemon {
namespace {

constexpr const char* kRefused = "refused";
constexpr const char* kNobody = "nobody";

// The client that the header names.
std::string read(const std::vector<uint8_t>& header) {
  const ProxyStart start(header.data(), kProxyStartBytes);
  const auto rest = proxy_rest_bytes(start);
  if (!rest || header.size() < kProxyStartBytes + *rest) return kRefused;
  const auto client = client_of_proxy(start, std::span(header).subspan(kProxyStartBytes, *rest));
  if (!client) return kRefused;
  return *client ? (*client)->to_string() : kNobody;
}

TEST(ProxyHeader, NamesTheClientAndNotTheProxy) {
  EXPECT_EQ(read(proxy_bytes("192.0.2.7")), "192.0.2.7");
  EXPECT_EQ(read(proxy_bytes("2001:db8::7")), "2001:db8::7");
}

TEST(ProxyHeader, PassesOverWhatAProxyAdds) {
  auto header = proxy_bytes("192.0.2.7");
  header.insert(header.end(), {0x04, 0x00, 0x01, 0x00});  // a TLV of type NOOP
  header[15] = static_cast<uint8_t>(header.size() - kProxyStartBytes);
  EXPECT_EQ(read(header), "192.0.2.7");
}

TEST(ProxyHeader, IsToldFromAClientByItsFirstBytes) {
  const auto header = proxy_bytes("192.0.2.7");
  EXPECT_TRUE(is_proxy_start(header));
  EXPECT_TRUE(is_proxy_start(std::span(header).first(12)));
  EXPECT_FALSE(is_proxy_start(std::span(header).first(11)));
  const std::string version_1 = "PROXY TCP4 192.0.2.7 192.0.2.1 12345 7600\r\n";
  const std::vector<uint8_t> text(version_1.begin(), version_1.end());
  EXPECT_TRUE(is_proxy_start(text));
  const std::vector<uint8_t> hello{0x16, 0x03, 0x01, 0x02, 0x00, 0x01};
  EXPECT_FALSE(is_proxy_start(hello));
  EXPECT_FALSE(is_proxy_start({}));
}

TEST(ProxyHeader, NamesNobodyWhereTheProxySpeaksForItself) {
  auto local = proxy_bytes("192.0.2.7"), unspecified = local;
  local[12] = 0x20;
  unspecified[13] = 0;
  EXPECT_EQ(read(local), kNobody);
  EXPECT_EQ(read(unspecified), kNobody);
}

TEST(ProxyHeader, RefusesWhatIsNotOne) {
  const auto good = proxy_bytes("192.0.2.7");
  for (const size_t at : {size_t{0}, size_t{11}, size_t{12}, size_t{13}}) {
    auto broken = good;
    broken[at] ^= 0x40;
    EXPECT_EQ(read(broken), kRefused) << at;
  }
  auto datagrams = good, too_short = good, too_long = good;
  datagrams[13] = 0x12;
  too_short[15] = 11;
  too_long[14] = 0xff;
  EXPECT_EQ(read(datagrams), kRefused);
  EXPECT_EQ(read(too_short), kRefused);
  EXPECT_EQ(read(too_long), kRefused);
}

TEST(ProxyHeader, AnyBytesAfterTheSignatureGiveAnAddressOrAnError) {
  std::mt19937 random(5);
  size_t named = 0;
  for (int i = 0; i < 100'000; ++i) {
    auto header = proxy_bytes("2001:db8::7");
    for (size_t at = 12; at < header.size(); ++at) header[at] = random() % 4 == 0 ? header[at] : uint8_t(random());
    const std::string client = read(header);
    named += client != kRefused && client != kNobody;
  }
  EXPECT_GT(named, 0u);
}

TEST(ProxyAddresses, MayBeNetworks) {
  const ProxyAddresses proxies({"10.64.0.0/10", "2001:db8::/32"});
  for (const char* inside : {"10.64.0.0", "10.127.255.255", "::ffff:10.100.1.1", "2001:db8:ffff::1"})
    EXPECT_TRUE(proxies.contains(asio::ip::make_address(inside))) << inside;
  for (const char* outside : {"10.63.255.255", "10.128.0.0", "::ffff:11.0.0.1", "2001:db9::1", "::"})
    EXPECT_FALSE(proxies.contains(asio::ip::make_address(outside))) << outside;
}

TEST(ProxyAddresses, AreTheConfiguredOnesAndNoOthers) {
  const ProxyAddresses proxies({"10.0.0.1", "2001:db8::1"});
  EXPECT_TRUE(proxies.contains(asio::ip::make_address("10.0.0.1")));
  EXPECT_TRUE(proxies.contains(asio::ip::make_address("::ffff:10.0.0.1"))) << "as a socket of :: shows it";
  EXPECT_TRUE(proxies.contains(asio::ip::make_address("2001:db8::1")));
  EXPECT_FALSE(proxies.contains(asio::ip::make_address("10.0.0.2")));
  EXPECT_FALSE(proxies.contains(asio::ip::make_address("2001:db8::2")));
  EXPECT_FALSE(ProxyAddresses({}).contains(asio::ip::make_address("10.0.0.1")));
}

TEST(DoorSign, SaysThatANodeIsFullUntilItHasRoomAgain) {
  DoorSign sign;
  EXPECT_EQ(sign.line(true, 0.84), "ready up 100%\n");
  EXPECT_EQ(sign.line(true, 0.85), "ready up 1%\n");
  EXPECT_EQ(sign.line(true, 0.76), "ready up 1%\n") << "as a session more would fill it again";
  EXPECT_EQ(sign.line(true, 0.74), "ready up 100%\n");
  EXPECT_EQ(sign.line(true, 0.84), "ready up 100%\n");
  EXPECT_EQ(sign.line(false, 0.2), "drain\n");
  EXPECT_EQ(sign.line(true, 0.2), "ready up 100%\n");
}

}  // namespace
}  // namespace gnomon::daemon
