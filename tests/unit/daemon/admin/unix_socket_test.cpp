// The operators' socket in the file system, and who they are.
#include "daemon/admin/unix_socket.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <fstream>

#include "daemon/admin/operators.h"

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

class UnixSocketTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (fs::temp_directory_path() / "gnomon_socket_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    path_ = folder_ / "admin.sock";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::unique_ptr<UnixSocket> listen() {
    auto made = UnixSocket::listen(path_, std::nullopt);
    EXPECT_TRUE(made) << made.error().message;
    return made ? std::move(*made) : nullptr;
  }
  std::string refusal() const {
    const auto made = UnixSocket::listen(path_, std::nullopt);
    return made ? "made" : made.error().message;
  }
  int connection() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.native().copy(address.sun_path, sizeof address.sun_path - 1);
    const int made = socket(AF_UNIX, SOCK_STREAM, 0);
    if (connect(made, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return made;
    close(made);
    return -1;
  }

  fs::path folder_, path_;
};

TEST_F(UnixSocketTest, IsForItsAccountAndGroupAloneAndIsRemovedAtTheEnd) {
  auto made = listen();
  struct stat info {};
  ASSERT_EQ(lstat(path_.c_str(), &info), 0);
  EXPECT_TRUE(S_ISSOCK(info.st_mode));
  EXPECT_EQ(info.st_mode & 07777u, 0660u);
  made.reset();
  EXPECT_FALSE(fs::exists(path_));
}

TEST_F(UnixSocketTest, OneOnWhichSomebodyListensIsLeftAlone) {
  const auto made = listen();
  EXPECT_NE(refusal().find("another process listens there"), std::string::npos) << refusal();
  const int still = connection();
  EXPECT_GE(still, 0);
  close(still);
}

TEST_F(UnixSocketTest, OneThatAKilledDaemonLeftIsReplaced) {
  const fs::path kept = folder_ / "kept";
  auto left = listen();
  fs::create_hard_link(path_, kept);
  left.reset();
  fs::rename(kept, path_);
  ASSERT_TRUE(fs::exists(path_));
  EXPECT_EQ(connection(), -1) << "nobody listens";
  const auto made = listen();
  const int now = connection();
  EXPECT_GE(now, 0);
  close(now);
}

TEST_F(UnixSocketTest, WhatIsNoSocketIsNeverRemoved) {
  std::ofstream(path_) << "precious";
  EXPECT_NE(refusal().find("no socket"), std::string::npos) << refusal();
  EXPECT_TRUE(fs::is_regular_file(path_));
}

TEST_F(UnixSocketTest, TheNextOnesFileIsNotRemoved) {
  auto first = listen();
  fs::remove(path_);
  const auto second = listen();
  first.reset();
  EXPECT_TRUE(fs::exists(path_));
}

TEST_F(UnixSocketTest, APathThatIsTooLongOrNowhereIsAnError) {
  path_ = folder_ / std::string(200, 'x');
  EXPECT_NE(refusal().find("longer than"), std::string::npos) << refusal();
  path_ = folder_ / "nowhere" / "admin.sock";
  EXPECT_NE(refusal().find("nowhere"), std::string::npos) << refusal();
}

TEST_F(UnixSocketTest, TheKernelSaysWhoIsThere) {
  const auto made = listen();
  const int from = connection();
  const auto peer = peer_of(from);  // the listening process, which is this one
  ASSERT_TRUE(peer);
  EXPECT_EQ(peer->uid, geteuid());
  EXPECT_NE(std::find(peer->groups.begin(), peer->groups.end(), getegid()), peer->groups.end());
  close(from);
}

TEST(Operators, AreRootTheDaemonsAccountAndTheGroupsMembers) {
  const uid_t other = geteuid() + 1;
  EXPECT_TRUE(may_change({.uid = 0, .groups = {}}, std::nullopt));
  EXPECT_TRUE(may_change({.uid = geteuid(), .groups = {}}, std::nullopt));
  EXPECT_FALSE(may_change({.uid = other, .groups = {0, 20, 40}}, std::nullopt)) << "root's group is not root";
  EXPECT_TRUE(may_change({.uid = other, .groups = {20, 40}}, 40));
  EXPECT_FALSE(may_change({.uid = other, .groups = {20, 41}}, 40));
}

TEST(Operators, AGroupHasToExist) {
  EXPECT_EQ(*group_of(""), std::nullopt);
  EXPECT_EQ(*group_of("root"), std::optional<gid_t>(0));
  const auto none = group_of("no such group");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("admin.group"), std::string::npos);
}

TEST(Operators, AnAccountIsNamedWithItsNumber) {
  EXPECT_EQ(account_name(0), "root(0)");
  EXPECT_EQ(account_name(4'000'000'000u), "uid(4000000000)");
}

}  // namespace
}  // namespace gnomon::daemon
