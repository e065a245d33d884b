#include "daemon/encode/cores.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace gnomon::daemon {
namespace {

TEST(Cores, AreReadFromLinuxsLists) {
  EXPECT_EQ(parse_cores("0-3,8,10-11").value(), (Cores{0, 1, 2, 3, 8, 10, 11}));
  EXPECT_EQ(parse_cores("5").value(), Cores{5});
  EXPECT_TRUE(parse_cores("").value().empty());
  for (const char* nonsense : {"a", "1-", "3-1", "1,", "2,1", "1 2", "-1", "99999999999", "0-99999"}) {
    EXPECT_FALSE(parse_cores(nonsense)) << nonsense;
  }
}

class NearTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(devices_ / "0000:65:00.0");
    std::ofstream(devices_ / "0000:65:00.0" / "local_cpulist") << "4-7,12-15\n";
  }
  void TearDown() override { std::filesystem::remove_all(devices_); }

  const std::filesystem::path devices_ = std::filesystem::path(testing::TempDir()) / "gnomon-pci-devices";
};

TEST_F(NearTest, AreTheUsableOnesOfTheDevicesNode) {
  EXPECT_EQ(cores_near("0000:65:00.0", {0, 1, 4, 5, 12}, devices_), (Cores{4, 5, 12}));
}

TEST_F(NearTest, AreAnyWhereNothingIsGained) {
  EXPECT_TRUE(cores_near("0000:65:00.0", {4, 5}, devices_).empty()) << "all usable ones are near";
  EXPECT_TRUE(cores_near("0000:65:00.0", {0, 1}, devices_).empty()) << "none is";
  EXPECT_TRUE(cores_near("0000:01:00.0", {0, 4}, devices_).empty()) << "no such device";
  EXPECT_TRUE(cores_near("", {0, 4}, devices_).empty()) << "on no bus";
}

TEST(Cores, AThreadStaysWhereItIsTold) {
  const Cores usable = usable_cores();
  ASSERT_FALSE(usable.empty());
  std::thread([&] {
    ASSERT_TRUE(stay_on({usable.back()}));
    EXPECT_EQ(usable_cores(), Cores{usable.back()});
    EXPECT_FALSE(stay_on({16000})) << "this machine has no such core";
    ASSERT_TRUE(stay_on({}));
    EXPECT_EQ(usable_cores(), Cores{usable.back()}) << "no wish, no change";
  }).join();
  EXPECT_EQ(usable_cores(), usable) << "other threads are not moved";
}

TEST(Cores, AQuarterEncodes) {
  EXPECT_EQ(default_encode_threads(Cores(1)), 1u);
  EXPECT_EQ(default_encode_threads(Cores(7)), 1u);
  EXPECT_EQ(default_encode_threads(Cores(64)), 16u);
}

}  // namespace
}  // namespace gnomon::daemon
