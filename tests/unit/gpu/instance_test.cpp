// Drivers stay loaded from one instance to the next.
#include "gpu/vulkan/instance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string>

namespace gnomon::test {
namespace {

using namespace gpu;

// The shared libraries of this process.
std::set<std::string> loaded() {
  std::set<std::string> libraries;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const size_t path = line.find('/');
    if (path != std::string::npos && line.find(".so", path) != std::string::npos)
      libraries.insert(line.substr(path));
  }
  return libraries;
}

TEST(Instances, LeaveDriversLoaded) {
  const std::set<std::string> before = loaded();
  std::set<std::string> during;
  {
    const auto instance = Instance::create({});
    ASSERT_TRUE(instance) << instance.error().message;
    ASSERT_FALSE(list_devices(**instance).empty());
    during = loaded();
  }
  EXPECT_TRUE(std::ranges::includes(during, before));
  EXPECT_EQ(loaded(), during);
}

}  // namespace
}  // namespace gnomon::test
