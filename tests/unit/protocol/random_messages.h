// Valid messages and camera updates with random field values, the same for the same generator.
#pragma once

#include <array>
#include <random>

#include "protocol/datagram.h"
#include "protocol/messages.h"

namespace gnomon::tests {

using Random = std::mt19937_64;

inline constexpr size_t kMessageTypes = std::variant_size_v<protocol::Message>;

template <class T, size_t N>
T one_of(Random& random, const std::array<T, N>& all) {
  return all[random() % N];
}

protocol::CameraView random_camera(Random& random);
protocol::LightInfo random_light(Random& random);
protocol::CameraUpdate random_update(Random& random);

// `type` is the index in the variant.
protocol::Message random_message(size_t type, Random& random);

}  // namespace gnomon::tests
