#include "scenes/gltf/budget.h"

#include <limits>
#include <string>

namespace gnomon::scenes::gltf {
namespace {

constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
constexpr uint64_t kTexelBytes = 4;

uint64_t product(uint64_t a, uint64_t b) { return b != 0 && a > kMost / b ? kMost : a * b; }
uint64_t sum(uint64_t a, uint64_t b) { return a > kMost - b ? kMost : a + b; }

// Rounded up; an amount beyond all others has no number.
std::string mib(uint64_t bytes) {
  return bytes == kMost ? "countless" : std::to_string((bytes >> 20) + (bytes % (1 << 20) != 0));
}

}  // namespace

Budget::Budget(const LoadLimits& limits) : limits_(limits) {}

Result<void> Budget::read(uint64_t bytes) {
  if (bytes > limits_.max_file_bytes - read_bytes_) {
    exceeded_ = true;
    return Error{"takes the scene beyond its limit of bytes"};
  }
  read_bytes_ += bytes;
  return {};
}

Result<void> Budget::spend(uint64_t count, uint64_t each) {
  const uint64_t takes = sum(spent_bytes_, product(count, each));
  const uint64_t may_take = sum(limits_.base_memory_bytes, product(read_bytes_, limits_.memory_bytes_per_byte));
  if (takes > may_take) {
    exceeded_ = true;
    return Error{"would take " + mib(takes) + " MiB of memory, where a file of " + std::to_string(read_bytes_) +
                 " bytes may take " + std::to_string(may_take >> 20) +
                 ": it unpacks to too much, or names one thing too often"};
  }
  spent_bytes_ = takes;
  return {};
}

Result<void> Budget::decode(uint32_t width, uint32_t height, uint32_t scans) {
  const uint64_t texels = uint64_t{width} * height;
  if (texels > limits_.max_texels - texels_) {
    exceeded_ = true;
    return Error{"takes the scene beyond its limit of " + std::to_string(limits_.max_texels) + " texels"};
  }
  if (scans > limits_.max_scans) {
    exceeded_ = true;
    return Error{"is a JPEG of " + std::to_string(scans) + " scans, of which at most " +
                 std::to_string(limits_.max_scans) + " are read: save it again with a usual encoder"};
  }
  texels_ += texels;
  return spend(texels, kTexelBytes);
}

}  // namespace gnomon::scenes::gltf
