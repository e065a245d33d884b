// Textures of colour: they repeat without seams, tint no material on the whole, and coordinates change no triangle.
#include "scenes/assets/textures.h"

#include <gtest/gtest.h>

#include "scenes/assets/built_in.h"
#include "scenes/assets/tiled_noise.h"
#include "scenes/assets/unwrap.h"

namespace gnomon::scenes::assets {
namespace {

TEST(TiledNoise, RepeatsWithoutASeam) {
  constexpr float kStep = 1e-3f;
  for (float along = 0.013f; along < 1.0f; along += 0.037f) {
    for (const glm::vec2 across : {glm::vec2(1, 0), glm::vec2(0, 1)}) {
      const glm::vec2 at = along * (glm::vec2(1) - across);
      const auto jump = [&](const auto& noise) {
        return std::abs(noise(at) - noise(at + (1.0f - kStep) * across));
      };
      EXPECT_LT(jump([](glm::vec2 p) { return layered_noise(p, {3, 5}, 3, 7); }), 0.1f) << along;
      EXPECT_LT(jump([](glm::vec2 p) { return cell_noise(p, {6, 4}, 7).nearest; }), 0.02f) << along;
    }
  }
}

TEST(Stage, DressedMaterialsKeepTheirColoursOnTheWhole) {
  Stage stage;
  const uint32_t plain = stage.matte("plain", glm::vec3(0.5f)), white = stage.matte("white", {1.0f, 0.9f, 0.8f});
  const glm::vec3 before = stage.materials[plain].base_color, bright = stage.materials[white].base_color;
  stage.dress({plain, white}, Pattern::stone, 2.0f);
  const ColourTexture texture = make_texture(Pattern::stone);
  const glm::vec3 after = stage.materials[plain].base_color * texture.mean;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(after[i], before[i], 1e-5f);
  // No factor may exceed 1: what is too bright gets darker, but not of another hue.
  const glm::vec3 dimmed = stage.materials[white].base_color * texture.mean / bright;
  EXPECT_LE(stage.materials[white].base_color.r, 1.0f);
  EXPECT_NEAR(dimmed.r, dimmed.g, 1e-4f);
  EXPECT_NEAR(dimmed.r, dimmed.b, 1e-4f);
  EXPECT_EQ(stage.images.size(), 1u) << "one image, however many materials have it";
}

class Unwrapped : public testing::TestWithParam<Stage (*)()> {};

TEST_P(Unwrapped, keeps_every_triangle_and_stretches_none_by_much) {
  const Stage stage = GetParam()();
  size_t textured = 0, stretched = 0, all = 0;
  for (const Model& model : stage.models) {
    for (const Part& part : model.parts) {
      const Material& material = stage.materials[part.material];
      if (material.texture == kNoImage) continue;
      const Mesh mesh = unwrapped(part.mesh, material.texture_metres);
      ++textured;
      ASSERT_EQ(mesh.triangles.size(), part.mesh.triangles.size());
      ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
      for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
          const uint32_t now = mesh.triangles[t][k], was = part.mesh.triangles[t][k];
          ASSERT_EQ(mesh.positions[now], part.mesh.positions[was]) << model.name;
          ASSERT_EQ(mesh.normals[now], part.mesh.normals[was]) << model.name;
        }
        const glm::uvec3 c = mesh.triangles[t];
        const glm::vec3 a = mesh.positions[c.y] - mesh.positions[c.x],
                        b = mesh.positions[c.z] - mesh.positions[c.x];
        const glm::vec2 u = mesh.uvs[c.y] - mesh.uvs[c.x], v = mesh.uvs[c.z] - mesh.uvs[c.x];
        const float area = glm::length(glm::cross(a, b)), covered = std::abs(u.x * v.y - u.y * v.x);
        const float scale = material.texture_metres * material.texture_metres;
        ++all;
        stretched +=
            area > 1e-6f && covered * scale < 0.5f * area;  // at most 1 / sqrt(3) of it, were it not rounded
      }
    }
  }
  EXPECT_GT(textured, 20u);
  EXPECT_LT(stretched, all / 1000);
}

INSTANTIATE_TEST_SUITE_P(Assets, Unwrapped, testing::Values(make_living_room, make_temple));

}  // namespace
}  // namespace gnomon::scenes::assets
