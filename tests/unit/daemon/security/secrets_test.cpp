// Unit tests of tokens, certificates and the life of credentials.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <set>

#include "daemon/security/certificates.h"
#include "daemon/security/expiry_reminder.h"
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
  for (const std::string& token : seen) {
    EXPECT_TRUE(token.starts_with(kTokenMark)) << token;
    EXPECT_EQ(token.size(), kTokenMark.size() + 64);
    EXPECT_FALSE(parse_token_hash(token)) << "one in the place of its hash is noticed";
  }
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

struct Answered {
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

  Answered ask(const std::string& tenant, const std::string& token,
               const std::vector<std::string>& certificate = {}, ServerMode mode = ServerMode::production) {
    protocol::Hello hello;
    hello.tenant = tenant;
    hello.token = token;
    ClientCertificate shown;
    shown.names = certificate;
    const auto who = identify(hello, shown, directory, mode);
    if (const auto* found = std::get_if<Identified>(&who)) return {found->tenant, {}, {}, {}};
    const Rejected& rejected = std::get<Rejected>(who);
    return {std::nullopt, rejected.refused.code, rejected.fault, rejected.refused.text};
  }
};

TEST_F(Credentials, ATokenIsGoodForItsTenantAlone) {
  EXPECT_EQ(ask("studio", "s1").tenant, TenantId{0});
  EXPECT_EQ(ask("studio", "s2").tenant, TenantId{0});
  EXPECT_EQ(ask("arcade", "a").tenant, TenantId{1});
  for (const char* token : {"", "a", "S1", "s1 "}) {
    const Answered got = ask("studio", token);
    EXPECT_FALSE(got.tenant) << token;
    EXPECT_EQ(got.code, RefusalCode::bad_token);
    EXPECT_EQ(got.fault, Fault::refused_bad_token);
  }
  EXPECT_EQ(ask("lobby", "").tenant, TenantId{2});
}

TEST_F(Credentials, StrangersDoNotLearnWhichTenantsThereAre) {
  const Answered wrong_token = ask("studio", "x"), no_token = ask("studio", "");
  const std::array<std::pair<Answered, Answered>, 3> same = {
      {{ask("nobody", "x"), wrong_token}, {ask("nobody", ""), no_token}, {ask("", ""), no_token}}};
  for (const auto& [got, of_a_tenant] : same) {
    EXPECT_EQ(got.code, of_a_tenant.code);
    EXPECT_EQ(got.text, of_a_tenant.text);
    EXPECT_EQ(got.fault, Fault::refused_unknown_tenant) << "the operator sees the difference";
  }
  EXPECT_NE(wrong_token.text, no_token.text) << "what the client sent is no secret";
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

// Why a session may not go on at `now`, one that was opened as `studio` with this credential; empty if it may.
struct LifeOfCredentials : testing::Test {
  TenantDirectory directory = TenantDirectory().with({{.name = "studio", .token_sha256 = {hash_of("s")}}});
  ClientAuthorities authorities = {.trusted = {{1}}, .revoked = {{9}}};
  std::chrono::seconds max_age{0};
  std::chrono::sys_seconds now{1000s};
  ServerMode mode = ServerMode::production;

  std::string objection(const Credential& credential) {
    return objection_to(credential, TenantId{0}, {directory, authorities, mode, max_age}, now).value_or("");
  }
  Credential token(const std::string& text) {
    return {.kind = Credential::Kind::token, .id = hash_of(text), .shown = now};
  }
  Credential certificate(uint8_t id = 2, uint8_t authority = 1) {
    return {.kind = Credential::Kind::certificate, .id = {id}, .authority = {authority}, .expires = now + 1h};
  }
};

TEST_F(LifeOfCredentials, ATokenIsGoodAsLongAsTheTenantHasIt) {
  EXPECT_EQ(objection(token("s")), "");
  directory = directory.with({{.name = "studio", .token_sha256 = {hash_of("t"), hash_of("s")}}});
  EXPECT_EQ(objection(token("s")), "") << "another one is good too";
  directory = directory.with({{.name = "studio", .token_sha256 = {hash_of("t")}}});
  EXPECT_EQ(objection(token("s")), "its token was revoked");
  directory = directory.with({{.name = "arcade", .token_sha256 = {hash_of("s")}}});
  EXPECT_EQ(objection(token("s")), "the tenant is no longer served");
}

TEST_F(LifeOfCredentials, ACertificateIsGoodUntilItExpiresOrItsAuthorityTakesItBack) {
  EXPECT_EQ(objection(certificate()), "");
  EXPECT_EQ(objection(certificate(9)), "its certificate was revoked");
  EXPECT_EQ(objection(certificate(2, 3)), "the authority of its certificate is no longer trusted");
  Credential old = certificate();
  old.expires = now;
  EXPECT_EQ(objection(old), "its certificate has expired");
}

TEST_F(LifeOfCredentials, WhoCameInWithoutAnyStaysWhileTheTenantIsOpen) {
  EXPECT_EQ(objection({}), "the tenant is no longer open to everybody");
  directory = directory.with({{.name = "studio", .open = true}});
  EXPECT_EQ(objection({}), "");
  directory = directory.with({{.name = "studio"}});
  EXPECT_EQ(objection({}), "the tenant is no longer open to everybody");
  mode = ServerMode::demo;
  EXPECT_EQ(objection({}), "");
}

TEST_F(LifeOfCredentials, AnAgeEndsASession) {
  const Credential shown = token("s");
  now += 24h;
  EXPECT_EQ(objection(shown), "") << "by default none";
  max_age = 24h;
  EXPECT_EQ(objection(shown), "it is older than 86400 s: authenticate anew");
  now -= 1s;
  EXPECT_EQ(objection(shown), "");
}

TEST(ExpiryReminder, RemindsOnceADayFromThirtyDaysBefore) {
  using std::chrono::days;
  ExpiryReminder reminder;
  const std::chrono::sys_seconds expires{days(1000)};
  EXPECT_FALSE(reminder.due(expires, expires - days(30) - 1s));
  EXPECT_EQ(reminder.due(expires, expires - days(30)), days(30));
  EXPECT_FALSE(reminder.due(expires, expires - days(29) - 1s));
  EXPECT_EQ(reminder.due(expires, expires - days(29)), days(29));
  EXPECT_EQ(reminder.due(expires, expires - 1s), days(0));
  EXPECT_EQ(reminder.due(expires, expires + days(2)), days(-2)) << "and goes on";
  EXPECT_FALSE(reminder.due(expires + days(400), expires + days(4))) << "until there is another one";
}

}  // namespace
}  // namespace gnomon::daemon
