// Synthetic shadow masks with the features of real ones, from smooth to noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "common/tile_mask.h"

namespace gnomon::tests {

struct Mask {
  TileGrid grid;
  std::vector<uint64_t> words;

  TileMaskView view() const { return {grid, words}; }
};

// The mask whose pixels `lit(x, y, light)` says are lit.
template <class Lit>
Mask make_mask(TileGrid grid, Lit lit) {
  Mask mask{grid, std::vector<uint64_t>(grid.word_count())};
  for (uint32_t light = 0; light < grid.planes; ++light) {
    for (uint32_t y = 0; y < grid.height; ++y) {
      for (uint32_t x = 0; x < grid.width; ++x) {
        if (!lit(x, y, light)) continue;
        const size_t tile = size_t{y / kTileSize} * grid.tiles_x() + x / kTileSize;
        mask.words[size_t{light} * grid.tile_count() + tile] |= uint64_t{1}
                                                                << (y % kTileSize * kTileSize + x % kTileSize);
      }
    }
  }
  return mask;
}

inline Mask all_dark(TileGrid grid) { return {grid, std::vector<uint64_t>(grid.word_count())}; }
inline Mask all_lit(TileGrid grid) {
  return make_mask(grid, [](uint32_t, uint32_t, uint32_t) { return true; });
}
inline Mask checkerboard(TileGrid grid, uint32_t period) {
  return make_mask(
      grid, [=](uint32_t x, uint32_t y, uint32_t light) { return (x / period + y / period + light) % 2 == 0; });
}
inline Mask noise(TileGrid grid, uint32_t seed) {
  std::mt19937_64 random(seed);
  return make_mask(grid, [&](uint32_t, uint32_t, uint32_t) { return (random() >> 40 & 1) != 0; });
}

// A room: each light is cut by a few straight edges and round objects, one of them by blinds.
inline Mask room(TileGrid grid, uint32_t seed) {
  struct Shape {
    float nx, ny, offset, cx, cy, radius_x, radius_y;
  };
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<std::vector<Shape>> lights(grid.planes);
  for (auto& shapes : lights) {
    for (int i = 0; i < 12; ++i) {
      const float angle = unit(random) * 6.2831853f;
      shapes.push_back({std::cos(angle), std::sin(angle), 0.25f + 0.4f * unit(random), unit(random), unit(random),
                        0.01f + 0.1f * unit(random), 0.01f + 0.1f * unit(random)});
    }
  }
  return make_mask(grid, [&](uint32_t px, uint32_t py, uint32_t light) {
    const float x = (static_cast<float>(px) + 0.5f) / static_cast<float>(grid.width);
    const float y = (static_cast<float>(py) + 0.5f) / static_cast<float>(grid.height);
    const auto& shapes = lights[light];
    for (size_t i = 0; i < shapes.size(); ++i) {
      const Shape& s = shapes[i];
      if (i < 2 && (x - 0.5f) * s.nx + (y - 0.5f) * s.ny > s.offset) return false;
      const float dx = (x - s.cx) / s.radius_x;
      const float dy = (y - s.cy) / s.radius_y;
      if (i < 9 ? dx * dx + dy * dy < 1 : std::abs(dx) < 1 && std::abs(dy) < 1) return false;
    }
    const bool behind_window = x > 0.1f && x < 0.35f && y > 0.55f && y < 0.85f;
    return !(light == 0 && behind_window && std::fmod(y + 0.2f * x, 0.02f) < 0.009f);
  });
}

// Leaves: the room, with many small ellipses in one part of the picture, some dark and some lit.
inline Mask foliage(TileGrid grid, uint32_t seed) {
  Mask mask = room(grid, seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  for (uint32_t light = 0; light < grid.planes; ++light) {
    for (int leaf = 0; leaf < 400; ++leaf) {
      const float cx = (0.3f + 0.4f * unit(random)) * static_cast<float>(grid.width);
      const float cy = (0.1f + 0.5f * unit(random)) * static_cast<float>(grid.height);
      const float rx = 2 + 10 * unit(random), ry = 2 + 6 * unit(random), slant = unit(random) - 0.5f;
      const bool lit = unit(random) < 0.4f;
      for (int y = static_cast<int>(cy - ry); y <= static_cast<int>(cy + ry); ++y) {
        for (int x = static_cast<int>(cx - 2 * rx); x <= static_cast<int>(cx + 2 * rx); ++x) {
          if (x < 0 || y < 0 || x >= static_cast<int>(grid.width) || y >= static_cast<int>(grid.height)) continue;
          const float v = (static_cast<float>(y) - cy) / ry;
          const float u = (static_cast<float>(x) - cx) / rx - slant * v;
          if (u * u + v * v > 1) continue;
          const auto px = static_cast<uint32_t>(x), py = static_cast<uint32_t>(y);
          uint64_t& word =
              mask.words[size_t{light} * grid.tile_count() + py / kTileSize * grid.tiles_x() + px / kTileSize];
          const uint64_t bit = uint64_t{1} << (py % kTileSize * kTileSize + px % kTileSize);
          word = lit ? word | bit : word & ~bit;
        }
      }
    }
  }
  return mask;
}

}  // namespace gnomon::tests
