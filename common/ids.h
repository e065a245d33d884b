// Strong ids: a TenantId does not convert to a SessionId, and neither supports arithmetic.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace gnomon {

template <class Tag, class Rep>
struct StrongId {
  Rep value{};

  constexpr StrongId() = default;
  constexpr explicit StrongId(Rep v) : value(v) {}
  friend constexpr auto operator<=>(StrongId, StrongId) = default;
};

using TenantId = StrongId<struct TenantTag, uint32_t>;    // index of a tenant in the configuration
using SessionId = StrongId<struct SessionTag, uint64_t>;  // random; routes datagrams
using FrameId = StrongId<struct FrameTag, uint32_t>;      // chosen by the client, increasing within a session
using JobId = StrongId<struct JobTag, uint64_t>;          // unique within a daemon process
using SceneId = StrongId<struct SceneTag, uint32_t>;      // index in the scene registry

// Frame ids count up and may wrap: of two, the newer is less than half the circle ahead.
constexpr bool is_newer(FrameId a, FrameId b) { return static_cast<int32_t>(a.value - b.value) > 0; }

}  // namespace gnomon

template <class Tag, class Rep>
struct std::hash<gnomon::StrongId<Tag, Rep>> {
  size_t operator()(gnomon::StrongId<Tag, Rep> id) const noexcept { return std::hash<Rep>{}(id.value); }
};
