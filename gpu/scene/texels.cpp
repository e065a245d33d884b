#include "gpu/scene/texels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon::gpu {
namespace {

float to_linear(float srgb) { return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f); }

const std::array<float, 256>& linear_of_srgb() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> made{};
    for (size_t i = 0; i < made.size(); ++i) made[i] = to_linear(static_cast<float>(i) / 255.0f);
    return made;
  }();
  return table;
}

// One level; colours linear, alpha from 0 to 1.
struct Level {
  uint32_t width = 0, height = 0;
  std::vector<glm::vec4> texels;
};

Level first_level(const scenes::Texture& texture) {
  const auto& linear = linear_of_srgb();
  Level level{texture.width, texture.height, {}};
  level.texels.reserve(texture.rgba.size() / 4);
  for (size_t i = 0; i + 3 < texture.rgba.size(); i += 4) {
    const uint8_t* t = &texture.rgba[i];
    level.texels.emplace_back(linear[t[0]], linear[t[1]], linear[t[2]], static_cast<float>(t[3]) / 255.0f);
  }
  return level;
}

Level halved(const Level& from) {
  Level to{std::max(from.width / 2, 1u), std::max(from.height / 2, 1u), {}};
  to.texels.reserve(size_t{to.width} * to.height);
  for (uint32_t y = 0; y < to.height; ++y) {
    for (uint32_t x = 0; x < to.width; ++x) {
      const auto at = [&](uint32_t dx, uint32_t dy) {
        return from.texels[size_t{std::min(2 * y + dy, from.height - 1)} * from.width +
                           std::min(2 * x + dx, from.width - 1)];
      };
      to.texels.push_back(0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)));
    }
  }
  return to;
}

uint32_t as_byte(float unit) { return static_cast<uint32_t>(std::lround(255.0f * std::clamp(unit, 0.0f, 1.0f))); }

void append(const Level& level, std::vector<uint32_t>& to) {
  for (const glm::vec4& t : level.texels) {
    to.push_back(as_byte(std::sqrt(t.r)) | as_byte(std::sqrt(t.g)) << 8 | as_byte(std::sqrt(t.b)) << 16 |
                 as_byte(t.a) << 24);
  }
}

}  // namespace

// By a table, as level 0 has three quarters of all texels.
Texels flat_texels(const scenes::Texture& texture) {
  static const std::array<uint32_t, 256> roots = [] {
    std::array<uint32_t, 256> made{};
    for (size_t i = 0; i < made.size(); ++i) made[i] = as_byte(std::sqrt(linear_of_srgb()[i]));
    return made;
  }();
  Texels out;
  out.rgba.reserve(texture.rgba.size() / 4);
  for (size_t i = 0; i + 3 < texture.rgba.size(); i += 4) {
    const uint8_t* t = &texture.rgba[i];
    out.rgba.push_back(roots[t[0]] | roots[t[1]] << 8 | roots[t[2]] << 16 | uint32_t{t[3]} << 24);
  }
  return out;
}

Texels mipmapped_texels(const scenes::Texture& texture) {
  Level level = first_level(texture);
  Texels out = flat_texels(texture);
  while (level.width > 1 || level.height > 1) {
    level = halved(level);
    append(level, out.rgba);
    ++out.levels;
  }
  return out;
}

}  // namespace gnomon::gpu
