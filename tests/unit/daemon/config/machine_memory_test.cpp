#include "daemon/config/machine_memory.h"

#include <gtest/gtest.h>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::daemon {
namespace {

using scenes::testing::ScratchFolder;

// A file system with what the kernel says of memory.
struct Kernel {
  explicit Kernel(const std::string& cgroup) {
    std::filesystem::create_directories(folder.path() / "proc/self");
    std::filesystem::create_directories(folder.path() / "sys/fs/cgroup/system.slice/gnomond.service");
    folder.write("proc/meminfo", std::string("MemTotal:       1000 kB\nMemFree:        500 kB\n"));
    folder.write("proc/self/cgroup", cgroup);
  }
  void limit(const std::string& group, const std::string& bytes) {
    folder.write("sys/fs/cgroup/" + group + "memory.max", bytes);
  }
  uint64_t usable() const { return usable_memory_bytes(folder.path()); }

  ScratchFolder folder;
};

const char* const kUnit = "0::/system.slice/gnomond.service\n";

TEST(MachineMemory, IsTheMachinesWithoutAGroup) {
  EXPECT_EQ(Kernel(kUnit).usable(), 1000u << 10);
  EXPECT_EQ(Kernel("").usable(), 1000u << 10);
}

TEST(MachineMemory, IsWhatTheTightestGroupAllows) {
  Kernel kernel(kUnit);
  kernel.limit("system.slice/gnomond.service/", "300000\n");
  EXPECT_EQ(kernel.usable(), 300'000u);
  kernel.limit("system.slice/", "200000\n");
  EXPECT_EQ(kernel.usable(), 200'000u);
  kernel.limit("", "max\n");
  EXPECT_EQ(kernel.usable(), 200'000u);
}

TEST(MachineMemory, AGroupWithoutALimitAllowsAll) {
  Kernel kernel(kUnit);
  kernel.limit("system.slice/gnomond.service/", "max\n");
  EXPECT_EQ(kernel.usable(), 1000u << 10);
}

TEST(MachineMemory, OfThisMachineIsKnown) {
  EXPECT_GT(usable_memory_bytes(), uint64_t{64} << 20);
  EXPECT_LT(usable_memory_bytes(), uint64_t{1} << 50);
}

}  // namespace
}  // namespace gnomon::daemon
