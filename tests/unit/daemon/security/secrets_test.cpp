// Unit tests of tokens, certificates and connection rates.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "daemon/net/connection_rate.h"
#include "daemon/security/certificates.h"
#include "daemon/security/tokens.h"
#include "daemon/session/credentials.h"
#include "protocol/pin.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::RefusalCode;

TEST(Tokens, AreAllDifferentAndLong) {
  std::set<std::string> seen;
  for (int i = 0; i < 100; ++i) seen.insert(make_token());
  EXPECT_EQ(seen.size(), 100u);
  for (const std::string& token : seen) EXPECT_EQ(token.size(), 64u);
}

TEST(Tokens, HashIsSha256AndSurvivesItsText) {
  const TokenHash hash = hash_of("abc");
  EXPECT_EQ(to_hex(hash), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(parse_token_hash(to_hex(hash)), hash);
  for (const std::string& wrong : {std::string(), std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'g'),
                                   std::string(62, 'a') + "+1"}) {
    EXPECT_FALSE(parse_token_hash(wrong)) << wrong;
  }
}

TEST(Tokens, AreFoundAmongOthers) {
  const std::vector<TokenHash> allowed = {hash_of("a"), hash_of("b")};
  EXPECT_TRUE(is_among(hash_of("a"), allowed));
  EXPECT_TRUE(is_among(hash_of("b"), allowed));
  EXPECT_FALSE(is_among(hash_of("c"), allowed));
  EXPECT_FALSE(is_among(hash_of("a"), {}));
}

TEST(Pin, SurvivesItsTextAndTakesOpensslsForm) {
  const auto identity = make_certificate({.name = "x", .hosts = {}, .lasts = 1h}).value();
  const auto pin = pin_of_pem(identity.certificate).value();
  EXPECT_EQ(protocol::parse_pin(protocol::to_string(pin)).value(), pin);
  std::string with_colons = "sha256:";
  for (size_t i = 0; i < 64; i += 2) {
    if (i) with_colons += ':';
    for (const char digit : protocol::to_string(pin).substr(7 + i, 2))
      with_colons += static_cast<char>(toupper(digit));
  }
  EXPECT_EQ(protocol::parse_pin(with_colons).value(), pin);
  for (const char* wrong : {"", "sha256:", "sha1:00", "sha256:0", "00"})
    EXPECT_FALSE(protocol::parse_pin(wrong)) << wrong;
  EXPECT_FALSE(pin_of_pem("nothing"));
}

struct Identified {
  std::optional<TenantId> tenant;
  RefusalCode code{};
  Fault fault{};
  std::string text;
};

struct Credentials : testing::Test {
  TenantDirectory directory =
      TenantDirectory().with({{.name = "studio", .token_sha256 = {hash_of("s1"), hash_of("s2")}},
                              {.name = "arcade", .token_sha256 = {hash_of("a")}},
                              {.name = "lobby", .open = true},
                              {.name = "vault"}});

  Identified ask(const std::string& tenant, const std::string& token,
                 const std::vector<std::string>& certificate = {}, ServerMode mode = ServerMode::production) {
    protocol::Hello hello;
    hello.tenant = tenant;
    hello.token = token;
    const auto who = identify(hello, certificate, directory, mode);
    if (const auto* id = std::get_if<TenantId>(&who)) return {*id, {}, {}, {}};
    const Rejected& rejected = std::get<Rejected>(who);
    return {std::nullopt, rejected.refused.code, rejected.fault, rejected.refused.text};
  }
};

TEST_F(Credentials, ATokenIsGoodForItsTenantAlone) {
  EXPECT_EQ(ask("studio", "s1").tenant, TenantId{0});
  EXPECT_EQ(ask("studio", "s2").tenant, TenantId{0});
  EXPECT_EQ(ask("arcade", "a").tenant, TenantId{1});
  for (const char* token : {"", "a", "S1", "s1 "}) {
    const Identified got = ask("studio", token);
    EXPECT_FALSE(got.tenant) << token;
    EXPECT_EQ(got.code, RefusalCode::bad_token);
    EXPECT_EQ(got.fault, Fault::refused_bad_token);
  }
  EXPECT_EQ(ask("lobby", "").tenant, TenantId{2});
}

TEST_F(Credentials, StrangersDoNotLearnWhichTenantsThereAre) {
  const Identified wrong_token = ask("studio", "x"), no_such = ask("nobody", "x"), no_name = ask("", "");
  for (const Identified& got : {no_such, no_name}) {
    EXPECT_EQ(got.code, wrong_token.code);
    EXPECT_EQ(got.text, wrong_token.text);
    EXPECT_EQ(got.fault, Fault::refused_unknown_tenant) << "the operator sees the difference";
  }
}

TEST_F(Credentials, ACertificateIsGoodForTheTenantsItNames) {
  EXPECT_EQ(ask("arcade", "", {"arcade"}).tenant, TenantId{1});
  EXPECT_EQ(ask("", "", {"host.example", "arcade"}).tenant, TenantId{1}) << "and says which it is";
  EXPECT_EQ(ask("vault", "", {"vault"}).tenant, TenantId{3});
  EXPECT_EQ(ask("studio", "", {"arcade"}).code, RefusalCode::bad_token);
  EXPECT_EQ(ask("studio", "s1", {"arcade"}).tenant, TenantId{0}) << "its token still counts";
  EXPECT_EQ(ask("nobody", "", {"arcade"}).code, RefusalCode::unknown_tenant) << "no stranger";
  EXPECT_FALSE(ask("vault", "").tenant) << "without a token of its own";
}

TEST_F(Credentials, InDemoModeTenantsWithoutTokensAreOpen) {
  EXPECT_EQ(ask("vault", "", {}, ServerMode::demo).tenant, TenantId{3});
  EXPECT_EQ(ask("studio", "", {}, ServerMode::demo).code, RefusalCode::bad_token);
  directory = TenantDirectory().with({{.name = "studio"}});
  EXPECT_EQ(ask("nobody", "", {}, ServerMode::demo).code, RefusalCode::unknown_tenant) << "nothing is secret there";
}

TEST_F(Credentials, AClosedTenantIsAsGoodAsNone) {
  directory = directory.with({{.name = "arcade", .token_sha256 = {hash_of("a")}}});
  EXPECT_EQ(ask("studio", "s1").code, RefusalCode::bad_token);
  EXPECT_EQ(ask("studio", "s1").fault, Fault::refused_unknown_tenant);
}

TEST(Tenants, ThatNobodyCouldConnectAsAreAnError) {
  Config config;
  const auto checked = check_tenants(config);
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().message.find("gnomonctl make-token"), std::string::npos) << checked.error().message;
  config.tenants[0].open = true;
  EXPECT_TRUE(check_tenants(config));
  config.tenants[0] = {.name = "a", .token_sha256 = {hash_of("x")}};
  EXPECT_TRUE(check_tenants(config));
  config.tenants[0].token_sha256.clear();
  config.server.tls.client_ca = "ca.pem";
  EXPECT_TRUE(check_tenants(config));
}

TEST(ConnectionRate, GivesABurstThenARate) {
  ConnectionRate rate(5, 10);
  const auto here = asio::ip::make_address("192.0.2.1"), there = asio::ip::make_address("192.0.2.2");
  TimePoint now{1h};
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(rate.admit(here, now)) << i;
  EXPECT_FALSE(rate.admit(here, now));
  EXPECT_TRUE(rate.admit(there, now)) << "others are not to suffer";
  now += 100ms;
  EXPECT_TRUE(rate.admit(here, now));
  EXPECT_FALSE(rate.admit(here, now));
  now += 1h;
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(rate.admit(here, now)) << i;
  EXPECT_FALSE(rate.admit(here, now)) << "no more is saved up";
}

TEST(ConnectionRate, CountsAHomesIpv6AddressesAsOne) {
  ConnectionRate rate(1, 1);
  EXPECT_TRUE(rate.admit(asio::ip::make_address("2001:db8:1:2::1"), TimePoint(1h)));
  EXPECT_FALSE(rate.admit(asio::ip::make_address("2001:db8:1:2:ffff::2"), TimePoint(1h)));
  EXPECT_TRUE(rate.admit(asio::ip::make_address("2001:db8:1:3::1"), TimePoint(1h)));
  EXPECT_TRUE(rate.admit(asio::ip::make_address("192.0.2.1"), TimePoint(1h)));
  EXPECT_FALSE(rate.admit(asio::ip::make_address("::ffff:192.0.2.1"), TimePoint(1h))) << "the same, mapped";
}

TEST(ConnectionRate, RemembersABoundedNumberOfAddresses) {
  ConnectionRate rate(2, 1);
  for (uint32_t i = 0; i < 3 * ConnectionRate::kMaxAddresses; ++i) {
    EXPECT_TRUE(rate.admit(asio::ip::address_v4(i), TimePoint(1h)));
    ASSERT_LE(rate.size(), ConnectionRate::kMaxAddresses);
  }
}

}  // namespace
}  // namespace gnomon::daemon
