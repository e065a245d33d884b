// One description of a structure's fields that both writes and reads them, so that the two cannot disagree:
//
//   template <class A> void fields(A& a, Of<A, Stats>& m) { a(m.frames, m.coalesced); a.check(..., "why"); }
//
// With A = Writer the fields are appended to a byte vector; with A = Reader they are taken from bytes, and the first
// check that fails is kept as the reason. All numbers are little-endian.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "common/ids.h"
#include "protocol/text.h"
#include "protocol/types.h"

namespace gnomon::protocol {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian, and so is every host so far");

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class Writer {
 public:
  static constexpr bool kReading = false;

  explicit Writer(std::vector<uint8_t>& out) : out_(out) {}

  template <class... Fields>
  void operator()(const Fields&... values) {
    (field(values), ...);
  }

  void text(const std::string& value, size_t max_bytes) {
    const std::string clean = wire_text(value, max_bytes);
    field(static_cast<uint16_t>(clean.size()));
    out_.insert(out_.end(), clean.begin(), clean.end());
  }

  void bytes(const std::vector<uint8_t>& value, size_t max_bytes) {
    const size_t size = std::min(value.size(), max_bytes);
    field(static_cast<uint16_t>(size));
    out_.insert(out_.end(), value.begin(), value.begin() + static_cast<std::ptrdiff_t>(size));
  }

  // Items beyond `max_count` are not sent, because a peer would refuse the message.
  template <class T, class WriteItem>
  void list(const std::vector<T>& items, size_t max_count, WriteItem write_item) {
    const size_t count = std::min(items.size(), max_count);
    field(static_cast<uint16_t>(count));
    for (size_t i = 0; i < count; ++i) write_item(items[i]);
  }

  void check(bool, const char*) {}

 private:
  template <Number T>
  void field(T value) {
    const size_t at = out_.size();
    out_.resize(at + sizeof value);
    std::memcpy(out_.data() + at, &value, sizeof value);
  }
  template <class Tag, class Rep>
  void field(StrongId<Tag, Rep> id) {
    field(id.value);
  }
  template <class T, size_t N>
  void field(const std::array<T, N>& values) {
    for (const T& value : values) field(value);
  }

  std::vector<uint8_t>& out_;
};

// Allocates only for texts, byte strings and lists, in proportion to the bytes that are present.
class Reader {
 public:
  static constexpr bool kReading = true;

  explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  bool ok() const { return why_ == nullptr; }
  const char* why() const { return why_; }
  std::span<const uint8_t> rest() const { return bytes_; }

  template <class... Fields>
  void operator()(Fields&... values) {
    (field(values), ...);
  }

  void text(std::string& value, size_t max_bytes) {
    uint16_t size = 0;
    field(size);
    check(size <= max_bytes, "a text is too long");
    const auto chars = take(size);
    value.assign(chars.begin(), chars.end());
    check(is_wire_text(value), "a text is not UTF-8 or has control characters");
  }

  void bytes(std::vector<uint8_t>& value, size_t max_bytes) {
    uint16_t size = 0;
    field(size);
    check(size <= max_bytes, "too many bytes");
    const auto taken = take(size);
    value.assign(taken.begin(), taken.end());
  }

  template <class T, class ReadItem>
  void list(std::vector<T>& items, size_t max_count, ReadItem read_item) {
    uint16_t count = 0;
    field(count);
    check(count <= max_count, "a list is too long");
    items.clear();
    for (size_t i = 0; i < count && ok(); ++i) read_item(items.emplace_back());
  }

  void check(bool holds, const char* why) {
    if (!holds && ok()) why_ = why;
  }

 private:
  // Takes the next `size` bytes. Empty, with a reason set, if there are fewer or an earlier check failed.
  std::span<const uint8_t> take(size_t size) {
    check(size <= bytes_.size(), "cut short");
    if (!ok()) return {};
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }

  template <Number T>
  void field(T& value) {
    const auto taken = take(sizeof value);
    if (!taken.empty()) std::memcpy(&value, taken.data(), sizeof value);
  }
  template <class Tag, class Rep>
  void field(StrongId<Tag, Rep>& id) {
    field(id.value);
  }
  template <class T, size_t N>
  void field(std::array<T, N>& values) {
    for (T& value : values) field(value);
  }

  std::span<const uint8_t> bytes_;
  const char* why_ = nullptr;
};

// T when reading, const T when writing.
template <class Archive, class T>
using Of = std::conditional_t<Archive::kReading, T, const T>;

template <class A>
void fields(A& a, Of<A, CameraView>& m) {
  a(m.position, m.orientation, m.tan_left, m.tan_right, m.tan_up, m.tan_down, m.near_plane);
  a.check(is_valid(m), "a camera is not finite, not of unit length or sees nothing");
}

}  // namespace gnomon::protocol
