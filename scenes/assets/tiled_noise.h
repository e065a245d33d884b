// Noise over the unit square that repeats without seams: gradient noise (after Perlin, "Improving Noise", 2002) and
// cells (after Worley, "A Cellular Texture Basis Function", 1996), both on lattices whose corners wrap round.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace gnomon::scenes::assets {

// A number from 0 to 1 for each corner of a lattice of `cells`, which wraps.
inline float corner_value(glm::ivec2 corner, glm::ivec2 cells, uint32_t seed) {
  const auto x = static_cast<uint32_t>((corner.x % cells.x + cells.x) % cells.x);
  const auto y = static_cast<uint32_t>((corner.y % cells.y + cells.y) % cells.y);
  uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca6bu ^ seed * 0xc2b2ae35u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1p-24f;
}

// From about -1 to 1.
inline float gradient_noise(glm::vec2 p, glm::ivec2 cells, uint32_t seed) {
  const glm::vec2 q = p * glm::vec2(cells), low = glm::floor(q), f = q - low;
  const glm::ivec2 corner(low);
  const auto slope = [&](int dx, int dy) {
    const float angle = 6.2831853f * corner_value(corner + glm::ivec2(dx, dy), cells, seed);
    return std::cos(angle) * (f.x - static_cast<float>(dx)) + std::sin(angle) * (f.y - static_cast<float>(dy));
  };
  const glm::vec2 s = f * f * f * (f * (f * 6.0f - 15.0f) + 10.0f);
  return 1.5f * glm::mix(glm::mix(slope(0, 0), slope(1, 0), s.x), glm::mix(slope(0, 1), slope(1, 1), s.x), s.y);
}

// Octaves of that, each twice as fine and half as strong.
inline float layered_noise(glm::vec2 p, glm::ivec2 cells, int octaves, uint32_t seed) {
  float sum = 0, weight = 0.5f;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += weight * gradient_noise(p, cells, seed + static_cast<uint32_t>(octave));
    cells *= 2;
    weight *= 0.5f;
  }
  return sum;
}

struct Cells {
  float nearest = 0, second = 0;  // distances to the two nearest points, in cells
  float id = 0;                   // a number from 0 to 1 of the nearest
};

inline Cells cell_noise(glm::vec2 p, glm::ivec2 cells, uint32_t seed) {
  const glm::vec2 q = p * glm::vec2(cells), low = glm::floor(q);
  Cells out{9.0f, 9.0f, 0.0f};
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const glm::ivec2 corner = glm::ivec2(low) + glm::ivec2(dx, dy);
      const glm::vec2 point =
          glm::vec2(corner) + glm::vec2(corner_value(corner, cells, seed), corner_value(corner, cells, seed + 101));
      const float away = glm::distance(q, point);
      if (away < out.nearest) {
        out.second = out.nearest;
        out.nearest = away;
        out.id = corner_value(corner, cells, seed + 202);
      } else {
        out.second = std::min(out.second, away);
      }
    }
  }
  return out;
}

}  // namespace gnomon::scenes::assets
