#include "daemon/config/token_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace gnomon::daemon {
namespace {

TEST(TokenFiles, AddToTheHashesOfTheConfiguration) {
  const std::string digits(64, 'a');
  const auto file = std::filesystem::path(testing::TempDir()) / ("gnomon_hashes_" + std::to_string(getpid()));
  const auto hashes = [&](const std::string& text) -> Result<size_t> {
    std::ofstream(file) << text;
    Config config;
    config.tenants = {{.name = "lab", .token_sha256 = {TokenHash{}}, .token_sha256_file = file}, {.name = "hall"}};
    if (const auto errors = read_token_files(config); !errors.empty()) return errors.front();
    EXPECT_TRUE(config.tenants[1].token_sha256.empty());
    return config.tenants[0].token_sha256.size();
  };
  EXPECT_NE(hashes("").error().message.find("the file is empty"), std::string::npos);
  EXPECT_EQ(hashes(digits + "\n\n" + digits + "\n").value(), 3u);
  const auto wrong = hashes(digits + "\nsecret\n");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("tenants.lab.token_sha256_file: " + file.string() + ":2: "),
            std::string::npos);
  EXPECT_EQ(wrong.error().message.find("secret"), std::string::npos) << "it may be a token";
  std::ofstream(file) << digits;
  Config before, after;
  before.tenants = after.tenants = {{.name = "lab", .token_sha256_file = file}};
  EXPECT_TRUE(read_token_files(before).empty());
  std::ofstream(file) << std::string(64, 'b');
  EXPECT_TRUE(read_token_files(after).empty());
  EXPECT_EQ(changes_between(before.values, after.values),
            std::vector<std::string>{"tenants.lab.token_sha256: 1 added, 1 removed"});
  std::filesystem::remove(file);
  Config config;
  config.tenants = {{.name = "lab", .token_sha256_file = file}};
  const auto gone = read_token_files(config);
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_NE(gone.front().message.find("No such file or directory"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::daemon
