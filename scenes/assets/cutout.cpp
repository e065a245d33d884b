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

// An image of `size` x `size` texels, which is transparent except where `solid` holds and has the sRGB colour `paint`
// everywhere, so that filters mix in no other. Their arguments lie in [0, 1] x [0, 1], y up.
std::vector<uint8_t> cut_png(int size, const std::function<bool(glm::vec2)>& solid,
                             const std::function<glm::vec3(glm::vec2)>& paint) {
  std::vector<uint8_t> rgba;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const glm::vec2 p((static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                        1.0f - (static_cast<float>(y) + 0.5f) / static_cast<float>(size));
      const glm::vec3 colour = glm::clamp(paint(p), 0.0f, 1.0f);
      for (int i = 0; i < 3; ++i) rgba.push_back(static_cast<uint8_t>(std::lround(255.0f * colour[i])));
      rgba.push_back(solid(p) ? 255 : 0);
    }
  }
  return png_of(size, 4, rgba);
}

// The polar coordinates in which an ivy leaf is drawn: the angle is 0 towards the tip.
struct OnLeaf {
  explicit OnLeaf(glm::vec2 p) : place((p - glm::vec2(0.5f, 0.32f)) / 0.62f), angle(std::atan2(place.x, place.y)) {}
  glm::vec2 place;
  float angle;
};

// Pale veins that run from the stalk into the five lobes, on a blade that darkens towards them.
glm::vec3 leaf_colour(glm::vec2 p) {
  const OnLeaf leaf(p);
  const float from_vein = std::abs(std::sin(2.5f * leaf.angle)) * glm::length(leaf.place);
  const float vein = 1.0f - glm::smoothstep(0.012f, 0.05f, from_vein);
  const float blade =
      0.80f + 0.14f * glm::smoothstep(0.0f, 0.35f, from_vein) + 0.06f * std::sin(31.0f * p.x + 17.0f * p.y);
  return glm::mix(blade * glm::vec3(0.92f, 1.0f, 0.86f), glm::vec3(1.0f, 1.0f, 0.86f), 0.7f * vein);
}

// Wood that was sawn along the bars.
glm::vec3 lattice_colour(glm::vec2 p) {
  return glm::vec3(0.90f + 0.08f * std::sin(90.0f * p.y + 3.0f * std::sin(11.0f * p.x))) *
         glm::vec3(1.0f, 0.96f, 0.90f);
}

}  // namespace

std::vector<uint8_t> png_of(int size, int channels, const std::vector<uint8_t>& texels) {
  std::vector<uint8_t> png;
  const auto keep = [](void* context, void* data, int bytes) {
    auto& out = *static_cast<std::vector<uint8_t>*>(context);
    out.insert(out.end(), static_cast<uint8_t*>(data), static_cast<uint8_t*>(data) + bytes);
  };
  stbi_write_png_to_func(keep, &png, size, size, channels, texels.data(), size * channels);
  return png;
}

std::vector<uint8_t> ivy_leaf_png() {
  const auto solid = [](glm::vec2 p) {
    const auto [q, angle] = OnLeaf(p);
    const float lobes = 0.62f + 0.30f * std::cos(5.0f * angle) * std::exp(-0.12f * angle * angle);
    const float taper = 1.0f + 0.10f * std::cos(angle);
    const bool stalk = std::abs(q.x) < 0.025f && q.y < 0.0f;
    return glm::length(q) < lobes * taper * 0.98f || stalk;
  };
  return cut_png(128, solid, leaf_colour);
}

std::vector<uint8_t> lattice_png(int cells) {
  const auto solid = [cells](glm::vec2 p) {
    const glm::vec2 q = glm::abs(glm::fract(p * static_cast<float>(cells)) - 0.5f);  // 0 at a cell's middle
    const float r = glm::length(q);
    const bool ring = std::abs(r - 0.34f) < 0.05f;
    const bool bars = std::max(q.x, q.y) > 0.455f;
    const bool spokes = r > 0.34f && std::abs(q.x - q.y) < 0.055f;
    const bool hub = r < 0.075f;
    const bool arms = r < 0.34f && std::min(q.x, q.y) < 0.032f;
    return ring || bars || spokes || hub || arms;
  };
  return cut_png(cells * 64, solid, lattice_colour);
}

}  // namespace gnomon::scenes::assets
