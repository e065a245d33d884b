#include "scenes/assets/textures.h"

#include <algorithm>
#include <cmath>

#include "scenes/assets/cutout.h"
#include "scenes/assets/tiled_noise.h"

namespace gnomon::scenes::assets {
namespace {

using glm::ivec2;
using glm::mix;
using glm::smoothstep;
using glm::vec2;
using glm::vec3;

// Each gives the linear colour at a place of the unit square.

vec3 stone(vec2 p) {
  const float stains = layered_noise(p, {3, 3}, 4, 11), bedding = layered_noise(p, {3, 17}, 4, 21);
  const float grit = layered_noise(p, {48, 48}, 3, 31);
  // Pits differ in size and come in patches, with ragged edges.
  const Cells pits = cell_noise(p + 0.006f * vec2(grit, stains), {46, 46}, 41);
  const float patch = smoothstep(-0.05f, 0.35f, layered_noise(p, {4, 4}, 3, 45));
  const float size = 0.05f + 0.26f * std::max(pits.id - 0.55f, 0.0f);
  const float hole = pits.id > 0.55f ? patch * (1.0f - smoothstep(0.5f * size, 1.6f * size, pits.nearest)) : 0.0f;
  const float light = (0.82f + 0.20f * stains + 0.16f * bedding + 0.15f * grit) * (1.0f - 0.30f * hole);
  const vec3 warm = mix(vec3(1.0f), vec3(1.0f, 0.88f, 0.72f), smoothstep(-0.15f, 0.45f, stains - 0.5f * bedding));
  return light * warm;
}

vec3 marble(vec2 p) {
  const vec2 bent = p + 0.09f * vec2(layered_noise(p, {3, 3}, 4, 5), layered_noise(p, {3, 3}, 4, 55));
  const float coarse = std::abs(layered_noise(bent, {2, 3}, 5, 61)),
              fine = std::abs(layered_noise(bent, {5, 4}, 5, 71));
  const float vein = std::max(std::exp(-26.0f * coarse), 0.55f * std::exp(-34.0f * fine));
  const float clouds = 0.93f + 0.09f * layered_noise(p, {4, 4}, 4, 81);
  return clouds * mix(vec3(1.0f), vec3(0.50f, 0.49f, 0.50f), 0.8f * vein);
}

vec3 plaster(vec2 p) {
  const float swell = layered_noise(p, {5, 5}, 4, 91), grain = layered_noise(p, {64, 64}, 3, 95);
  return vec3(0.93f + 0.055f * swell + 0.05f * grain);
}

vec3 wood(vec2 p) {
  const float bend = layered_noise(p, {2, 3}, 3, 101);
  const float rings = 0.5f + 0.5f * std::sin(6.2831853f * (9.0f * p.y + 1.5f * bend));
  const float streaks = layered_noise(p, {3, 70}, 3, 111), tone = layered_noise(p, {2, 8}, 3, 121);
  const float pores = smoothstep(0.32f, 0.62f, gradient_noise(p, {20, 150}, 131));
  float light = 0.86f - 0.20f * std::pow(rings, 3.0f) + 0.22f * streaks + 0.20f * tone;
  light *= 1.0f - 0.32f * pores;
  return std::max(light, 0.12f) * mix(vec3(1.0f), vec3(1.0f, 0.80f, 0.62f), 0.8f * (1.0f - light));
}

vec3 weave(vec2 p) {
  constexpr float kThreads = 40.0f;
  const vec2 q = p * kThreads, f = glm::fract(q) - 0.5f;
  const bool warp_above = (static_cast<int>(q.x) + static_cast<int>(q.y)) % 2 == 0;
  // The thread on top bulges along its length and is round across.
  const float along = warp_above ? f.y : f.x, across = warp_above ? f.x : f.y;
  const float height = std::cos(3.14159f * 0.7f * across) * (0.80f + 0.20f * std::cos(3.14159f * along));
  const float slub = layered_noise(p, warp_above ? ivec2(40, 5) : ivec2(5, 40), 3, 141);
  return vec3(std::max(0.25f, 0.30f + 0.66f * height + 0.26f * slub));
}

vec3 wool(vec2 p) {
  const Cells tufts =
      cell_noise(p + 0.01f * vec2(gradient_noise(p, {30, 30}, 3), gradient_noise(p, {30, 30}, 4)), {44, 44}, 151);
  const float light = 1.0f - 0.55f * smoothstep(0.15f, 0.75f, tufts.nearest) + 0.16f * (tufts.id - 0.5f);
  return vec3(light + 0.10f * layered_noise(p, {6, 6}, 3, 161));
}

vec3 leather(vec2 p) {
  const Cells grain = cell_noise(p, {30, 30}, 171);
  const float crease = 1.0f - smoothstep(0.02f, 0.22f, grain.second - grain.nearest);
  const float worn = layered_noise(p, {3, 3}, 4, 181);
  return (0.84f + 0.24f * worn) * (1.0f - 0.42f * crease) * vec3(1.0f, 0.96f, 0.92f);
}

vec3 clay(vec2 p) {
  const float rings = layered_noise(p, {24, 2}, 3, 191), burnt = layered_noise(p, {3, 3}, 4, 195);
  const float grit = layered_noise(p, {56, 56}, 2, 199);
  const vec3 tint = mix(vec3(1.0f), vec3(0.74f, 0.66f, 0.62f), smoothstep(0.05f, 0.5f, burnt));
  return (0.86f + 0.16f * rings + 0.14f * grit) * tint;
}

vec3 ground(vec2 p) {
  const float patches = layered_noise(p, {4, 4}, 6, 201), blades = layered_noise(p, {70, 70}, 2, 211);
  const vec3 grass(0.50f, 0.64f, 0.28f), dry(0.96f, 0.86f, 0.58f);
  const vec3 colour = mix(grass, dry, smoothstep(-0.45f, 0.40f, patches + 0.6f * blades));
  return colour * (0.84f + 0.40f * blades);
}

vec3 foliage(vec2 p) {
  const Cells leaves = cell_noise(p, {26, 26}, 221), sprays = cell_noise(p, {7, 7}, 231);
  const float depth = 1.0f - smoothstep(0.1f, 0.85f, leaves.nearest);
  const float spray = 1.0f - 0.55f * smoothstep(0.2f, 0.9f, sprays.nearest);
  const vec3 tint = mix(vec3(0.62f, 0.85f, 0.40f), vec3(1.0f, 1.0f, 0.58f), leaves.id);
  return (0.18f + 0.82f * depth) * spray * tint;
}

vec3 patina(vec2 p) {
  const float rust = layered_noise(p, {5, 5}, 5, 241), scratches = layered_noise(p, {4, 60}, 2, 251);
  const float dull = 0.82f + 0.20f * layered_noise(p, {11, 11}, 3, 261) + 0.08f * scratches;
  return dull * mix(vec3(1.0f, 0.92f, 0.80f), vec3(0.30f, 0.78f, 0.66f), 0.75f * smoothstep(0.10f, 0.36f, rust));
}

vec3 hammered(vec2 p) {
  const Cells dents = cell_noise(p, {20, 20}, 271);
  const float rub = layered_noise(p, {4, 4}, 4, 281);
  return vec3(1.0f, 0.97f, 0.90f) * (0.72f + 0.26f * smoothstep(0.0f, 0.7f, dents.nearest) + 0.18f * rub);
}

vec3 ember(vec2 p) {
  const Cells coals = cell_noise(p, {9, 9}, 291);
  const float ash = smoothstep(-0.1f, 0.35f, layered_noise(p, {8, 8}, 4, 301));
  return mix(vec3(0.95f, 0.55f, 0.30f), vec3(0.25f), ash) * (0.35f + 0.65f * (coals.second - coals.nearest));
}

struct Recipe {
  vec3 (*colour)(vec2);
  int size;  // texels each way
};

Recipe recipe_of(Pattern pattern) {
  switch (pattern) {
    case Pattern::stone: return {stone, 512};
    case Pattern::marble: return {marble, 512};
    case Pattern::plaster: return {plaster, 256};
    case Pattern::wood: return {wood, 512};
    case Pattern::weave: return {weave, 320};
    case Pattern::wool: return {wool, 256};
    case Pattern::leather: return {leather, 256};
    case Pattern::clay: return {clay, 256};
    case Pattern::ground: return {ground, 512};
    case Pattern::foliage: return {foliage, 256};
    case Pattern::patina: return {patina, 256};
    case Pattern::hammered: return {hammered, 256};
    case Pattern::ember: return {ember, 128};
  }
  return {plaster, 256};
}

float to_srgb(float c) { return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f; }

}  // namespace

ColourTexture make_texture(Pattern pattern) {
  const Recipe recipe = recipe_of(pattern);
  const auto size = static_cast<float>(recipe.size);
  std::vector<vec3> colours;
  for (int y = 0; y < recipe.size; ++y) {
    for (int x = 0; x < recipe.size; ++x) {
      const vec2 p((static_cast<float>(x) + 0.5f) / size, (static_cast<float>(y) + 0.5f) / size);
      colours.push_back(glm::clamp(recipe.colour(p), vec3(0.0f), vec3(1.0f)));
    }
  }
  glm::dvec3 sum(0.0);
  std::vector<uint8_t> rgb;
  for (const vec3& c : colours) {
    sum += glm::dvec3(c);
    for (int i = 0; i < 3; ++i) rgb.push_back(static_cast<uint8_t>(std::lround(255.0f * to_srgb(c[i]))));
  }
  return {png_of(recipe.size, 3, rgb), vec3(sum / static_cast<double>(colours.size()))};
}

}  // namespace gnomon::scenes::assets
