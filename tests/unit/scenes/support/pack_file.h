// A reader of scene packs, written from web/PACK.md alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace gnomon::scenes::testing {

class PackFile {
 public:
  // Check broken() before anything else.
  explicit PackFile(std::vector<std::byte> bytes);

  // What of the document the file does not keep, or "".
  const std::string& broken() const { return broken_; }
  const nlohmann::json& head() const { return head_; }

  // A section as values. `section`: of the JSON, with an offset and a number of bytes.
  template <class T>
  std::vector<T> values(const nlohmann::json& section) const {
    const std::span<const std::byte> bytes = of(section);
    std::vector<T> out(bytes.size() / sizeof(T));
    if (!out.empty()) std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
    return out;
  }
  template <class T>
  std::vector<T> section(const char* name) const {
    return values<T>(head_["sections"][name]);
  }

 private:
  std::string read();
  std::string read_places(const nlohmann::json& value) const;
  std::span<const std::byte> of(const nlohmann::json& section) const {
    return std::span(bytes_).subspan(section["offset"].get<size_t>(), section["bytes"].get<size_t>());
  }

  std::vector<std::byte> bytes_;
  nlohmann::json head_;
  std::string broken_;
};

}  // namespace gnomon::scenes::testing
