#include "daemon/config/machine_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace gnomon::daemon {
namespace {

constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();

uint64_t machine_bytes(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/meminfo");
  std::string key;
  uint64_t kib = 0;
  while (file >> key >> kib) {
    if (key == "MemTotal:") return kib << 10;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return kUnlimited;
}

// Every group above ours limits us too.
uint64_t group_bytes(const std::filesystem::path& root) {
  std::ifstream membership(root / "proc/self/cgroup");
  std::string line, ours;
  while (std::getline(membership, line)) {
    if (line.starts_with("0::/")) ours = line.substr(4);
  }
  uint64_t least = kUnlimited;
  const std::filesystem::path top = root / "sys/fs/cgroup";
  for (std::filesystem::path group = top / ours;; group = group.parent_path()) {
    uint64_t bytes = 0;
    if (std::ifstream limit(group / "memory.max"); limit >> bytes) least = std::min(least, bytes);  // or "max"
    if (group == top || !group.has_relative_path()) return least;
  }
}

}  // namespace

uint64_t usable_memory_bytes(const std::filesystem::path& root) {
  return std::min(machine_bytes(root), group_bytes(root));
}

}  // namespace gnomon::daemon
