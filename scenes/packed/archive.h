// Values as a flat run of bytes, in the machine's own byte order: for another process of the same build on the same
// machine, never for a file that outlives it.
//
// One function describes both directions: `visit(archive, value)` names the members in their order, and PackWriter and
// PackReader are the archives. What a reader gets is untrusted: every count is checked against the bytes that are left
// before memory is allocated for it, and numbers that C++ does not allow (booleans, enumerators) become errors.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace gnomon::scenes {

// Types whose every bit pattern is a value, and which are copied in bulk.
template <class T>
inline constexpr bool kPlain = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
template <glm::length_t N, class T>
inline constexpr bool kPlain<glm::vec<N, T>> = true;
template <glm::length_t C, glm::length_t R, class T>
inline constexpr bool kPlain<glm::mat<C, R, T>> = true;
template <>
inline constexpr bool kPlain<glm::quat> = true;
template <size_t N>
inline constexpr bool kPlain<std::array<uint8_t, N>> = true;

// Writes to a file. Errors are kept: good() says whether everything was written.
class PackWriter {
 public:
  // Borrowed, and neither flushed nor closed.
  explicit PackWriter(std::FILE* file) : file_(file) {}

  bool good() const { return good_; }

  template <class T>
  void plain(const T& value) {
    bytes(&value, sizeof value);
  }
  template <class E>
  void enumerator(const E& value, E /*last*/) {
    plain(static_cast<uint8_t>(value));
  }
  void boolean(const bool& value) { plain(static_cast<uint8_t>(value)); }
  void text(const std::string& value) {
    count(value.size());
    bytes(value.data(), value.size());
  }
  template <class T>
  void bulk(const std::vector<T>& values) {
    count(values.size());
    bytes(values.data(), values.size() * sizeof(T));
  }
  template <class T, class Visit>
  void each(const std::vector<T>& values, Visit visit) {
    count(values.size());
    for (const T& value : values) visit(*this, const_cast<T&>(value));  // visits of a writer change nothing
  }

 private:
  void count(uint64_t n) { plain(n); }
  void bytes(const void* data, size_t size) {
    good_ = good_ && (size == 0 || std::fwrite(data, size, 1, file_) == 1);
  }

  std::FILE* file_;
  bool good_ = true;
};

// Reads from memory. After the first error everything is read as 0, false, the first enumerator or empty.
class PackReader {
 public:
  explicit PackReader(std::span<const std::byte> bytes) : left_(bytes) {}

  bool good() const { return good_; }
  bool at_end() const { return left_.empty(); }
  void fail() { good_ = false; }  // what was read breaks a promise

  template <class T>
  void plain(T& value) {
    static_assert(kPlain<T>);
    if (!bytes(&value, sizeof value)) value = T{};
  }
  template <class E>
  void enumerator(E& value, E last) {
    uint8_t number = 0;
    plain(number);
    good_ = good_ && number <= static_cast<uint8_t>(last);
    value = good_ ? static_cast<E>(number) : E{};
  }
  void boolean(bool& value) {
    uint8_t number = 0;
    plain(number);
    good_ = good_ && number <= 1;
    value = good_ && number == 1;
  }
  void text(std::string& value) {
    value.resize(count(1));
    bytes(value.data(), value.size());
  }
  template <class T>
  void bulk(std::vector<T>& values) {
    static_assert(kPlain<T>);
    const size_t size = count(sizeof(T)) * sizeof(T);
    const std::byte* const from = left_.data();
    values = std::vector<T>(Unaligned<T>(from), Unaligned<T>(from + size));
    left_ = left_.subspan(size);
  }
  // Elements are made one by one, so that a count without its elements costs nothing.
  template <class T, class Visit>
  void each(std::vector<T>& values, Visit visit) {
    const uint64_t n = count(1);
    for (uint64_t i = 0; i < n && good_; ++i) visit(*this, values.emplace_back());
    if (!good_) values.clear();
  }

 private:
  // Values that lie anywhere. A vector that is made of them touches its memory once; resized and then filled, twice.
  template <class T>
  class Unaligned {
   public:
    using iterator_category = std::random_access_iterator_tag;
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using pointer = const T*;
    using reference = T;

    explicit Unaligned(const std::byte* at) : at_(at) {}
    T operator*() const {
      T value;
      std::memcpy(&value, at_, sizeof value);
      return value;
    }
    Unaligned& operator++() {
      at_ += sizeof(T);
      return *this;
    }
    friend difference_type operator-(const Unaligned& a, const Unaligned& b) {
      return (a.at_ - b.at_) / static_cast<difference_type>(sizeof(T));
    }
    friend bool operator==(const Unaligned& a, const Unaligned& b) { return a.at_ == b.at_; }

   private:
    const std::byte* at_;
  };

  // A number of elements of at least `least` bytes each; 0 after an error.
  size_t count(size_t least) {
    uint64_t n = 0;
    plain(n);
    good_ = good_ && n <= left_.size() / least;
    return good_ ? static_cast<size_t>(n) : 0;
  }
  bool bytes(void* out, size_t size) {
    good_ = good_ && size <= left_.size();
    if (!good_) return false;
    if (size > 0) std::memcpy(out, left_.data(), size);
    left_ = left_.subspan(size);
    return true;
  }

  std::span<const std::byte> left_;
  bool good_ = true;
};

}  // namespace gnomon::scenes
