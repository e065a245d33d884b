// What `gnomonctl init` writes is what gnomond takes.
#include "daemon/ctl/init.h"

#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <fstream>
#include <memory>
#include <sstream>

#include "daemon/config/config.h"
#include "daemon/config/token_files.h"
#include "daemon/ctl/new_file.h"
#include "daemon/security/certificates.h"

namespace gnomon::ctl {
namespace {

namespace fs = std::filesystem;

bool is_good_for(const std::string& pem, const std::string& host) {
  const std::unique_ptr<BIO, decltype(&BIO_free_all)> bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())),
                                                          BIO_free_all);
  const std::unique_ptr<X509, decltype(&X509_free)> read(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr),
                                                         X509_free);
  return read && X509_check_host(read.get(), host.c_str(), host.size(), 0, nullptr) == 1;
}

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

TEST_F(Init, ASecondTimeSaysWhatARunningDaemonNeeds) {
  const std::string start = "1. Start it with what was written:", reload = "     gnomonctl reload\n";
  EXPECT_NE(init(request_)->find(start), std::string::npos);
  request_.tenants.push_back("museum");
  const auto tenant = init(request_);
  EXPECT_NE(tenant->find(reload), std::string::npos) << *tenant;
  EXPECT_EQ(tenant->find(start), std::string::npos) << *tenant;
  request_.browsers = true;
  const auto browsers = init(request_);
  EXPECT_NE(browsers->find("1. Restart it, as a reload does not change web.listen:\n"), std::string::npos)
      << *browsers;
  EXPECT_EQ(browsers->find(reload), std::string::npos) << *browsers;
  request_.port = 7700;
  const auto port = init(request_);
  EXPECT_NE(port->find(start), std::string::npos) << "systemd opens another port: " << *port;
}

TEST_F(Init, ASecondTimeKeepsWhatItIsNotAskedFor) {
  request_.tenants = {"lab", "null", "1.50"};
  ASSERT_TRUE(init(request_));
  const std::string written = made("gnomond.yaml");
  std::string changed = written + "scheduler: {policy: priority}\n";
  changed.replace(changed.find("  mode: production"), 18, "  mode: production\n  max_sessions: 77");
  changed.replace(changed.find("  - name: lab"), 13, "  - name: lab\n    weight: 3");
  ASSERT_TRUE(write_file(request_.out / "gnomond.yaml", changed, 0644));
  InitRequest again;
  again.out = request_.out;
  again.hosts = request_.hosts;
  again.listen = "192.0.2.7";
  again.port = 7700;
  const auto done = init(again);
  ASSERT_TRUE(done) << done.error().message;
  const auto config = daemon::read_config(request_.out / "gnomond.yaml", {});
  ASSERT_TRUE(config) << config.error().message << made("gnomond.yaml");
  EXPECT_EQ(config->server.max_sessions, 77u);
  EXPECT_EQ(config->scheduler.policy, "priority");
  EXPECT_EQ(config->server.listen, "192.0.2.7");
  EXPECT_EQ(config->server.data_port, 7700);
  ASSERT_EQ(config->tenants.size(), 3u) << "nobody said that they are to go";
  EXPECT_EQ(config->tenants[0].weight, 3u);
  EXPECT_EQ(config->tenants[1].name, "null");
  EXPECT_EQ(config->tenants[2].name, "1.50");
  EXPECT_EQ(config->scenes.list.at(0).name, "show");
  again.listen = {};
  again.tenants = {"museum", "lab"};
  ASSERT_TRUE(init(again));
  const auto next = daemon::read_config(request_.out / "gnomond.yaml", {});
  EXPECT_EQ(next->server.listen, "192.0.2.7");
  ASSERT_EQ(next->tenants.size(), 2u) << "those that are said are all";
  EXPECT_EQ(next->tenants[1].weight, 3u);
}

TEST_F(Init, AConfigurationOfAnothersHandIsReplaced) {
  fs::create_directories(request_.out);
  const std::string others = "# The package's\nserver: {max_sessions: 77}\n";
  ASSERT_TRUE(write_file(request_.out / "gnomond.yaml", others, 0644));
  ASSERT_TRUE(init(request_));
  EXPECT_NE(daemon::read_config(request_.out / "gnomond.yaml", {})->server.max_sessions, 77u);
  EXPECT_EQ(made("gnomond.yaml.before"), others);
}

TEST_F(Init, ANodeOfAFleetHasWhatItsDoorAndItsClientsNeed) {
  request_.hosts = {};
  request_.fleet = "gnomon.example";
  request_.public_address = "10.0.0.11";
  request_.proxies = {"10.0.0.2", "10.64.0.0/10"};
  const auto steps = init(request_);
  ASSERT_TRUE(steps) << steps.error().message;
  EXPECT_NE(steps->find("--server gnomon.example:7600 --fleet gnomon.example --ca ca.pem"), std::string::npos)
      << *steps;
  const auto expect_fleet = [&] {
    const auto config = daemon::read_config(request_.out / "gnomond.yaml", {});
    ASSERT_TRUE(config) << config.error().message;
    EXPECT_EQ(config->fleet.name, "gnomon.example");
    EXPECT_EQ(config->fleet.door_listen, "10.0.0.11");
    EXPECT_EQ(config->fleet.door_port, 7602);
    EXPECT_EQ(config->server.public_address, "10.0.0.11");
    EXPECT_EQ(config->server.proxies, (std::vector<std::string>{"10.0.0.2", "10.64.0.0/10"}));
    EXPECT_EQ(config->server.drain_timeout, std::chrono::seconds(40));
    for (const char* host : {"gnomon.example", "s-67425801bf1a60fe.gnomon.example"})
      EXPECT_TRUE(is_good_for(made("credentials/server.pem"), host)) << host;
  };
  expect_fleet();
  InitRequest again;
  again.out = request_.out;
  again.tenants = {"lab"};
  const auto second = init(again);
  ASSERT_TRUE(second) << second.error().message;
  expect_fleet();
  again.door_port = 7612;
  again.door_listen = "10.1.0.11";
  ASSERT_TRUE(init(again));
  const auto config = daemon::read_config(request_.out / "gnomond.yaml", {});
  EXPECT_EQ(config->fleet.door_port, 7612);
  EXPECT_EQ(config->fleet.door_listen, "10.1.0.11");
  EXPECT_EQ(config->server.public_address, "10.0.0.11");
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
  request = request_;
  request.fleet = "gnomon.example";
  EXPECT_NE(refused(request).find("--public-address is missing"), std::string::npos);
  request.public_address = "node1";
  EXPECT_NE(refused(request).find("--proxies is missing"), std::string::npos);
  request.proxies = {"10.0.0.2"};
  EXPECT_NE(refused(request).find("--public-address node1: an IP address is needed"), std::string::npos)
      << refused(request);
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
