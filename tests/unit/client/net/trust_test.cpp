// Which servers a client accepts: the one whose certificate it was given the fingerprint of, or one whose certificate
// its authority has signed for the name that it connected to; within the certificate's validity period in either case.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/watched.h"

namespace gnomon::client {
namespace {

using daemon::CertificateOptions;
using daemon::Identity;
using tests::FakeServer;
using tests::Peer;
using namespace std::chrono_literals;

constexpr const char* kHere = "127.0.0.1";

Identity made(const CertificateOptions& options, const Identity* issuer = nullptr) {
  return daemon::make_certificate(options, issuer).value();
}

// "opened", or why the client does not accept a server with that certificate.
std::string verdict(const Identity& identity, const Trust& trust) {
  FakeServer server(
      [](Peer& peer) {
        if (peer.read()) peer.welcome(tests::small_welcome(tests::kWidth, tests::kHeight, tests::kLights));
      },
      1, identity);
  auto options = tests::options_for(server.address());
  options.connect.trust = trust;
  tests::Watched watched(options);
  const auto opened = watched.stream.wait_open();
  return opened ? "opened" : opened.error().message;
}

std::string refused_for(const std::string& verdict) {
  const std::string is_refused = " is refused: ";
  const size_t at = verdict.find(is_refused);
  return at == std::string::npos ? "not refused: " + verdict : verdict.substr(at + is_refused.size());
}

TEST(Trust, APinIsForOneCertificate) {
  const Identity one = made({.name = "one", .hosts = {}, .lasts = 1h});
  const Identity another = made({.name = "one", .hosts = {}, .lasts = 1h});
  EXPECT_EQ(verdict(one, FakeServer::trust(one)), "opened");
  EXPECT_EQ(refused_for(verdict(another, FakeServer::trust(one))),
            "it is not the one expected; the server shows " + FakeServer::trust(another).pin);
}

TEST(Trust, APinnedCertificateHasItsTimeToo) {
  const Identity old = made({.name = "old", .hosts = {}, .lasts = -60s});
  const Identity early = made({.name = "early", .hosts = {}, .starts_in = 1h, .lasts = 2h});
  EXPECT_EQ(refused_for(verdict(old, FakeServer::trust(old))), "certificate has expired");
  EXPECT_EQ(refused_for(verdict(early, FakeServer::trust(early))), "certificate is not yet valid");
}

class Signed : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (std::filesystem::temp_directory_path() / "gnomon_trust_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    std::ofstream(folder_ / "ca.pem") << authority_.certificate;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Trust trust() const { return {.authorities = folder_ / "ca.pem"}; }

  std::filesystem::path folder_;
  const Identity authority_ =
      made({.name = "authority", .hosts = {}, .use = CertificateOptions::Use::authority, .lasts = 1h});
};

TEST_F(Signed, ByItsAuthorityForThatName) {
  EXPECT_EQ(verdict(made({.name = "server", .hosts = {kHere}, .lasts = 1h}, &authority_), trust()), "opened");
  EXPECT_EQ(
      refused_for(verdict(made({.name = "server", .hosts = {"10.0.0.1"}, .lasts = 1h}, &authority_), trust())),
      "IP address mismatch");
}

TEST_F(Signed, AndNotExpiredNorByStrangers) {
  EXPECT_EQ(refused_for(verdict(made({.name = "server", .hosts = {kHere}, .lasts = -60s}, &authority_), trust())),
            "certificate has expired");
  const Identity stranger =
      made({.name = "authority", .hosts = {}, .use = CertificateOptions::Use::authority, .lasts = 1h});
  const auto foreign = made({.name = "server", .hosts = {kHere}, .lasts = 1h}, &stranger);
  EXPECT_NE(refused_for(verdict(foreign, trust())).find("certificate"), std::string::npos);
  const auto own = made({.name = "server", .hosts = {kHere}, .lasts = 1h});
  const std::string self_signed = refused_for(verdict(own, trust()));
  EXPECT_TRUE(self_signed.starts_with("self-signed certificate; ")) << self_signed;
  EXPECT_NE(self_signed.find("(--pin " + FakeServer::trust(own).pin + ")"), std::string::npos) << self_signed;
}

}  // namespace
}  // namespace gnomon::client
