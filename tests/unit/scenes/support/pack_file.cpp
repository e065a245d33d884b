#include "tests/unit/scenes/support/pack_file.h"

#include <utility>

namespace gnomon::scenes::testing {
namespace {

uint32_t u32_at(std::span<const std::byte> bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<uint32_t>(bytes[at + i]);
  return value;
}

}  // namespace

PackFile::PackFile(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) { broken_ = read(); }

std::string PackFile::read() {
  if (bytes_.size() < 16 || std::memcmp(bytes_.data(), "GNPACK01", 8) != 0) return "there is no magic";
  const size_t json_bytes = u32_at(bytes_, 8);
  if (u32_at(bytes_, 12) != 0) return "the head does not end with 0";
  if (json_bytes % 16 != 0 || json_bytes > bytes_.size() - 16) return "the JSON's length is wrong";
  const auto* text = reinterpret_cast<const char*>(&bytes_[16]);
  head_ = nlohmann::json::parse(text, text + json_bytes, nullptr, false);
  if (!head_.is_object()) return "there is no JSON";
  return read_places(head_);
}

// Checks every section, wherever the JSON names one.
std::string PackFile::read_places(const nlohmann::json& value) const {
  if (value.is_object() && value.contains("offset")) {
    const size_t offset = value["offset"], size = value["bytes"];
    if (offset % 16 != 0) return "a section lies at " + std::to_string(offset);
    if (offset > bytes_.size() || size > bytes_.size() - offset) return "a section reaches beyond the end";
    if (offset < 16 + u32_at(bytes_, 8)) return "a section begins within the JSON";
  }
  if (!value.is_structured()) return "";
  for (const auto& member : value) {
    if (std::string found = read_places(member); !found.empty()) return found;
  }
  return "";
}

}  // namespace gnomon::scenes::testing
