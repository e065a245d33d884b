// What `gnomonctl init` writes is what gnomond takes.
#include "daemon/ctl/init.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "daemon/config/config.h"
#include "daemon/config/token_files.h"
#include "daemon/ctl/new_file.h"
#include "daemon/security/certificates.h"

namespace gnomon::ctl {
namespace {

namespace fs = std::filesystem;

class Init : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (fs::temp_directory_path() / "gnomon_init_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    std::ofstream(folder_ / "hall.glb") << "glTF";
    request_.out = folder_ / "etc";
    request_.hosts = {"edge.example", "192.0.2.7"};
    request_.tenants = {"lab", "arcade"};
    request_.scenes = {"show=" + (folder_ / "hall.glb").string()};
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string made(const std::string& file) { return read_file(request_.out / file); }

  fs::path folder_;
  InitRequest request_;
};

TEST_F(Init, WritesWhatGnomondTakes) {
  const auto steps = init(request_);
  ASSERT_TRUE(steps) << steps.error().message;
  auto config = daemon::read_config(request_.out / "gnomond.yaml", {});
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_TRUE(daemon::find_files(*config, request_.out, "/nowhere").empty());
  EXPECT_TRUE(daemon::read_token_files(*config).empty());
  EXPECT_EQ(config->server.mode, daemon::ServerMode::production);
  EXPECT_EQ(config->server.listen, "0.0.0.0");
  EXPECT_EQ(config->server.tls.certificate, request_.out / "credentials/server.pem");
  ASSERT_EQ(config->scenes.list.size(), 1u);
  EXPECT_EQ(config->scenes.list[0].name, "show");
  ASSERT_EQ(config->tenants.size(), 2u);
  for (const auto& tenant : config->tenants) {
    std::string token = made("private/clients/" + tenant.name + "/token");
    token.pop_back();
    ASSERT_EQ(tenant.token_sha256.size(), 1u);
    EXPECT_EQ(tenant.token_sha256[0], daemon::hash_of(token)) << tenant.name;
    EXPECT_EQ(made("private/clients/" + tenant.name + "/ca.pem"), made("private/ca.pem"));
  }
  EXPECT_NE(made("systemd/gnomond.socket.d/gnomon.conf").find("\nListenStream=\n"), std::string::npos);
  EXPECT_NE(made("systemd/gnomond.socket.d/gnomon.conf").find("\nListenDatagram=0.0.0.0:7600\n"),
            std::string::npos);
  EXPECT_NE(
      steps->find("gnomon-client --server edge.example:7600 --ca ca.pem --tenant lab --token-file token --scene "
                  "show"),
      std::string::npos)
      << *steps;
}

TEST_F(Init, SecretsAreNobodyElses) {
  ASSERT_TRUE(init(request_));
  for (const char* file : {"credentials/server-key.pem", "private/ca-key.pem", "private/clients/lab/token"}) {
    const auto others = fs::status(request_.out / file).permissions() & fs::perms::others_all;
    EXPECT_EQ(others, fs::perms::none) << file;
  }
  EXPECT_EQ(fs::status(request_.out / "private").permissions() & ~fs::perms::owner_all, fs::perms::none);
}

TEST_F(Init, ASecondTimeKeepsTheAuthorityTheTokensAndTheConfigurationBefore) {
  ASSERT_TRUE(init(request_));
  const std::string authority = made("private/ca.pem"), token = made("private/clients/lab/token");
  const std::string certificate = made("credentials/server.pem"), config = made("gnomond.yaml");
  request_.hosts = {"other.example"};
  request_.tenants = {"lab"};
  ASSERT_TRUE(init(request_));
  EXPECT_EQ(made("private/ca.pem"), authority) << "clients that have it go on";
  EXPECT_EQ(made("private/clients/lab/token"), token);
  EXPECT_NE(made("credentials/server.pem"), certificate);
  EXPECT_NE(made("gnomond.yaml"), config);
  EXPECT_EQ(made("gnomond.yaml.before"), config);
}

TEST_F(Init, RefusesWhatItCannotMake) {
  const auto refused = [&](InitRequest request) {
    const auto done = init(request);
    return done ? std::string() : done.error().message;
  };
  InitRequest request = request_;
  request.hosts.clear();
  EXPECT_NE(refused(request).find("--host is missing"), std::string::npos);
  request = request_;
  request.tenants = {"../lab"};
  EXPECT_NE(refused(request).find("--tenant ../lab"), std::string::npos);
  request = request_;
  request.scenes = {"show=/no/such.glb"};
  EXPECT_NE(refused(request).find("/no/such.glb is no file"), std::string::npos);
  EXPECT_FALSE(fs::exists(request_.out)) << "nothing was written";
  ASSERT_TRUE(init(request_));
  fs::remove(request_.out / "private/ca-key.pem");
  EXPECT_NE(refused(request_).find("ca-key.pem beside it is not"), std::string::npos);
}

TEST_F(Init, AsksForWhatWasNotSaidAndProposesTheUsual) {
  InitRequest request;
  request.tenants = {"lab"};
  std::istringstream answers("edge.example 192.0.2.7\n\nyes\n");
  std::ostringstream questions;
  ask_for_missing(request, answers, questions);
  EXPECT_EQ(request.hosts, (std::vector<std::string>{"edge.example", "192.0.2.7"}));
  EXPECT_EQ(request.tenants, (std::vector<std::string>{"lab"}));
  EXPECT_EQ(request.scenes, (std::vector<std::string>{"living_room", "temple"}));
  EXPECT_EQ(questions.str().find("Tenants"), std::string::npos) << "it was said";
  EXPECT_NE(questions.str().find("browsers too, at https://edge.example:7600/"), std::string::npos);
  EXPECT_EQ(request.browsers, true);
  std::istringstream silence;
  for (const bool said : {true, false}) {
    InitRequest unsaid;
    if (said) unsaid.browsers = true;
    ask_for_missing(unsaid, silence, questions);
    EXPECT_EQ(unsaid.browsers, said) << "an empty answer serves no browsers";
  }
}

TEST_F(Init, BrowsersAreServedWhereThatIsSaid) {
  const auto without = init(request_);
  ASSERT_TRUE(without);
  EXPECT_FALSE(daemon::read_config(request_.out / "gnomond.yaml", {})->web.listen);
  EXPECT_NE(without->find("Browsers are not served; `web: {listen: true}`"), std::string::npos) << *without;
  request_.browsers = true;
  const auto with = init(request_);
  ASSERT_TRUE(with);
  EXPECT_TRUE(daemon::read_config(request_.out / "gnomond.yaml", {})->web.listen);
  EXPECT_NE(with->find("https://edge.example:7600/#scene=show&tenant=lab"), std::string::npos) << *with;
  EXPECT_EQ(with->find("Browsers are not served"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::ctl
