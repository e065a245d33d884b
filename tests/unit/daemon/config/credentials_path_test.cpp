// Paths of the configuration that lie where systemd puts a unit's credentials.
#include <gtest/gtest.h>

#include <cstdlib>

#include "daemon/config/config.h"

namespace gnomon::daemon {
namespace {

constexpr const char* kText =
    "server: {tls: {certificate: '${CREDENTIALS_DIRECTORY}/server.pem', key: credentials/server-key.pem}}\n"
    "scenes: {list: []}\n"
    "tenants: [{name: lab, token_sha256_file: '${CREDENTIALS_DIRECTORY}/lab.sha256'}]\n";

Config found_below(const std::string& folder) {
  auto config = parse_config(kText, "test.yaml", {});
  EXPECT_TRUE(config);
  find_files(*config, folder, "/nowhere");
  return *config;
}

TEST(CredentialsPath, LiesInTheFolderThatSystemdNames) {
  setenv("CREDENTIALS_DIRECTORY", "/run/credentials/gnomond.service", 1);
  const Config config = found_below("/etc/gnomon");
  unsetenv("CREDENTIALS_DIRECTORY");
  EXPECT_EQ(config.server.tls.certificate, "/run/credentials/gnomond.service/server.pem");
  EXPECT_EQ(config.server.tls.key, "/etc/gnomon/credentials/server-key.pem") << "others are as before";
  EXPECT_EQ(config.tenants[0].token_sha256_file, "/run/credentials/gnomond.service/lab.sha256");
}

TEST(CredentialsPath, KeepsItsNameWhereSystemdNamesNone) {
  unsetenv("CREDENTIALS_DIRECTORY");
  EXPECT_EQ(found_below("/etc/gnomon").server.tls.certificate, "/etc/gnomon/${CREDENTIALS_DIRECTORY}/server.pem")
      << "so that the error says what is missing";
}

}  // namespace
}  // namespace gnomon::daemon
