// Access to the structs of gnomon.h that grow with later versions: the caller's `size` says how much of one its header
// knows.
//
// Any thread. Every size is checked before anything beyond it is read or written.
#pragma once

#include <gnomon/gnomon.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>

namespace gnomon::client::c {

inline constexpr size_t kMostBytes = 4096;  // no struct of any version will be longer: a larger size is wrong

// The size of the struct in the version that introduced it: a caller that states less is wrong. Members that are added
// later do not change these.
template <class Struct>
inline constexpr size_t kFirstBytes = 0;
#define GNOMON_FIRST_VERSION_ENDS_WITH(Struct, last) \
  template <>                                        \
  inline constexpr size_t kFirstBytes<Struct> = offsetof(Struct, last) + sizeof(Struct::last)
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_options, open_timeout_ms);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_mask_view, bytes);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_scene, motions);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_light, outer_cone_cos);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_motion, period_us);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_session, draining_ms);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_refusal, fit_rate_hz);
GNOMON_FIRST_VERSION_ENDS_WITH(gnomon_statistics, server_total_us);
#undef GNOMON_FIRST_VERSION_ENDS_WITH

template <class Struct>
bool has_right_size(const Struct* given) {
  static_assert(kFirstBytes<Struct> > 0 && sizeof(Struct) <= kMostBytes);
  return given && given->size >= kFirstBytes<Struct> && given->size <= kMostBytes;
}

// A copy of what the caller has set, with zeros for members that its header does not know. nullopt if the size is
// wrong, or if a member is set that this library does not know.
template <class Struct>
std::optional<Struct> read_versioned(const Struct* given) {
  if (!has_right_size(given)) return std::nullopt;
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  const size_t known = std::min(given->size, sizeof(Struct));
  if (std::any_of(bytes + known, bytes + given->size, [](unsigned char byte) { return byte != 0; })) {
    return std::nullopt;
  }
  Struct copy{};
  std::memcpy(&copy, given, known);
  return copy;
}

// Fills in what the caller has room for, and keeps its `size`. False, with nothing written, if that is wrong.
template <class Struct>
bool write_versioned(Struct value, Struct* out) {
  if (!has_right_size(out)) return false;
  value.size = out->size;
  const size_t known = std::min(out->size, sizeof(Struct));
  std::memset(reinterpret_cast<unsigned char*>(out) + known, 0, out->size - known);
  std::memcpy(out, &value, known);
  return true;
}

}  // namespace gnomon::client::c
