#include "scenes/assets/cutout.h"

#include <cmath>
#include <functional>
#include <glm/glm.hpp>

// stb_image_write is C code with warnings of its own.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace gnomon::scenes::assets {
namespace {

// An image of `size` x `size` texels, white where `solid` holds and transparent elsewhere. The argument of `solid` lies
// in [0, 1] x [0, 1], y up.
std::vector<uint8_t> cut_png(int size, const std::function<bool(glm::vec2)>& solid) {
  std::vector<uint8_t> rgba;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const glm::vec2 p((static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                        1.0f - (static_cast<float>(y) + 0.5f) / static_cast<float>(size));
      rgba.insert(rgba.end(), {255, 255, 255, static_cast<uint8_t>(solid(p) ? 255 : 0)});
    }
  }
  std::vector<uint8_t> png;
  const auto keep = [](void* context, void* data, int bytes) {
    auto& out = *static_cast<std::vector<uint8_t>*>(context);
    out.insert(out.end(), static_cast<uint8_t*>(data), static_cast<uint8_t*>(data) + bytes);
  };
  stbi_write_png_to_func(keep, &png, size, size, 4, rgba.data(), size * 4);
  return png;
}

}  // namespace

std::vector<uint8_t> ivy_leaf_png() {
  return cut_png(128, [](glm::vec2 p) {
    const glm::vec2 q = (p - glm::vec2(0.5f, 0.32f)) / 0.62f;
    const float angle = std::atan2(q.x, q.y);  // 0 towards the tip
    const float lobes = 0.62f + 0.30f * std::cos(5.0f * angle) * std::exp(-0.12f * angle * angle);
    const float taper = 1.0f + 0.10f * std::cos(angle);
    const bool stalk = std::abs(q.x) < 0.025f && q.y < 0.0f;
    return glm::length(q) < lobes * taper * 0.98f || stalk;
  });
}

std::vector<uint8_t> lattice_png(int cells) {
  return cut_png(cells * 64, [cells](glm::vec2 p) {
    const glm::vec2 q = glm::abs(glm::fract(p * static_cast<float>(cells)) - 0.5f);  // 0 at a cell's middle
    const float r = glm::length(q);
    const bool ring = std::abs(r - 0.34f) < 0.05f;
    const bool bars = std::max(q.x, q.y) > 0.455f;
    const bool spokes = r > 0.34f && std::abs(q.x - q.y) < 0.055f;
    const bool hub = r < 0.075f;
    const bool arms = r < 0.34f && std::min(q.x, q.y) < 0.032f;
    return ring || bars || spokes || hub || arms;
  });
}

}  // namespace gnomon::scenes::assets
