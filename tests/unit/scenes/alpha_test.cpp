// Alpha modes, base colour textures, and the alpha test that every tracer repeats.
#include <gtest/gtest.h>

#include "scenes/world_mesh.h"
#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/png.h"

namespace gnomon::scenes::testing {
namespace {

// 2 x 2 texels: alpha 0, 255 in the upper row, 100, 200 in the lower.
const std::vector<uint8_t> kTexels = {10, 20, 30, 0, 10, 20, 30, 255, 10, 20, 30, 100, 10, 20, 30, 200};

// One triangle with uvs (0,0) (1,0) (0,1) and a textured material with this alpha mode.
GltfFile textured_file(const json& material, const json& sampler = json::object(),
                       const json& texture_info = json::object()) {
  GltfFile file;
  const int positions = file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const int uvs = file.add_accessor(std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}, kFloat, "VEC2");
  const int other = file.add_accessor(std::vector<glm::vec2>{{5, 5}, {6, 5}, {5, 6}}, kFloat, "VEC2");
  const json attributes = {{"POSITION", positions}, {"TEXCOORD_0", uvs}, {"TEXCOORD_1", other}};
  file.add_node({{"mesh", file.add_mesh({{"attributes", attributes}, {"material", 0}})}});
  file.root["samplers"] = json::array({sampler});
  file.root["images"] =
      json::array({json::object({{"uri", "data:image/png;base64," + base64(png(2, 2, kTexels))}})});
  file.root["textures"] = json::array({json::object({{"source", 0}, {"sampler", 0}})});
  json m = material;
  m["pbrMetallicRoughness"]["baseColorTexture"] = texture_info;
  m["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  file.root["materials"] = json::array({m});
  return file;
}

TEST(Textures, AreDecodedFromTheTopRow) {
  const ScenePtr scene = textured_file({{"alphaMode", "MASK"}}).load_or_fail();
  ASSERT_EQ(scene->textures.size(), 1u);
  EXPECT_EQ(scene->textures[0].width, 2u);
  EXPECT_EQ(scene->textures[0].height, 2u);
  EXPECT_TRUE(scene->textures[0].has_alpha);
  EXPECT_EQ(scene->textures[0].rgba, kTexels);
}

TEST(Textures, MayLieInABufferOrAFileBesideTheScene) {
  GltfFile in_buffer = textured_file({{"alphaMode", "MASK"}});
  const int view = in_buffer.add_view(png(2, 2, kTexels));
  in_buffer.root["images"] = json::array({json::object({{"bufferView", view}, {"mimeType", "image/png"}})});
  EXPECT_EQ(in_buffer.load_or_fail()->textures.at(0).rgba, kTexels);

  GltfFile beside = textured_file({{"alphaMode", "MASK"}});
  beside.root["images"] = json::array({json::object({{"uri", "leaf%20one.png"}})});
  const ScratchFolder folder;
  folder.write("leaf one.png", png(2, 2, kTexels));
  const Result<ScenePtr> scene = load_scene(folder.write("a.gltf", beside.gltf()));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ((*scene)->textures.at(0).rgba, kTexels);
}

TEST(Textures, BrokenOnesAreLeftOutUnlessAnAlphaTestNeedsThem) {
  for (const char* uri : {"missing.png", "data:image/png;base64,AAAA", "../a.png"}) {
    GltfFile opaque = textured_file(json::object());
    opaque.root["images"] = json::array({json::object({{"uri", uri}})});
    const ScenePtr scene = opaque.load_or_fail();
    EXPECT_TRUE(scene->textures.empty()) << uri;
    EXPECT_EQ(scene->materials.at(0).base_color_texture, kNone) << uri;
    GltfFile mask = textured_file({{"alphaMode", "MASK"}});
    mask.root["images"] = opaque.root["images"];
    EXPECT_NE(mask.load_error().find("alpha test"), std::string::npos) << uri;
  }
}

TEST(Textures, WhatUnpacksToFarMoreThanItsSizeIsRefused) {
  GltfFile file = textured_file({{"alphaMode", "MASK"}});
  const std::string uri = "data:image/png;base64," + base64(png_bomb(size_t{8} << 20));
  file.root["images"] = json::array({json::object({{"uri", uri}})});
  EXPECT_NE(file.load_error().find("outofmem"), std::string::npos);
}

TEST(Textures, TheirTexelsAreLimited) {
  const ScratchFolder folder;
  LoadLimits limits;
  limits.max_texels = 3;
  const Result<ScenePtr> scene =
      load_scene(folder.write("a.gltf", textured_file({{"alphaMode", "MASK"}}).gltf()), limits);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("2 x 2"), std::string::npos);
}

TEST(Textures, CoordinatesComeFromTheNamedSet) {
  const ScenePtr scene = textured_file({{"alphaMode", "MASK"}}, json::object(), {{"texCoord", 1}}).load_or_fail();
  EXPECT_EQ(scene->meshes.at(0).primitives.at(0).uvs, (std::vector<glm::vec2>{{5, 5}, {6, 5}, {5, 6}}));
}

TEST(Textures, TransformsOfCoordinatesAreApplied) {
  const json transform = {{"offset", {0.5, 0.25}}, {"scale", {2, 4}}, {"rotation", 1.57079632679}};
  const json info = {{"extensions", {{"KHR_texture_transform", transform}}}};
  const ScenePtr scene = textured_file({{"alphaMode", "MASK"}}, json::object(), info).load_or_fail();
  // Scaled, then turned (u, v) -> (v, -u), then moved.
  const std::vector<glm::vec2> expected = {{0.5f, 0.25f}, {0.5f, 0.25f - 2.0f}, {0.5f + 4.0f, 0.25f}};
  const auto& uvs = scene->meshes.at(0).primitives.at(0).uvs;
  ASSERT_EQ(uvs.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_LT(glm::distance(uvs[i], expected[i]), 1e-5f) << i;
}

TEST(AlphaTest, TakesTheNearestTexel) {
  const ScenePtr scene = textured_file({{"alphaMode", "MASK"}}).load_or_fail();
  EXPECT_FALSE(passes_alpha_test(*scene, 0, {0.25f, 0.25f}));
  EXPECT_TRUE(passes_alpha_test(*scene, 0, {0.75f, 0.25f}));
  EXPECT_FALSE(passes_alpha_test(*scene, 0, {0.25f, 0.75f}));
  EXPECT_TRUE(passes_alpha_test(*scene, 0, {0.75f, 0.75f}));
  EXPECT_FALSE(passes_alpha_test(*scene, 0, {0.49f, 0.49f}));
  EXPECT_TRUE(passes_alpha_test(*scene, 0, {0.5f, 0.49f}));
}

TEST(AlphaTest, CutoffAndFactorCount) {
  const json base = {{"baseColorFactor", {1, 1, 1, 0.5}}};
  const ScenePtr scene =
      textured_file({{"alphaMode", "MASK"}, {"alphaCutoff", 0.39}, {"pbrMetallicRoughness", base}}).load_or_fail();
  EXPECT_TRUE(passes_alpha_test(*scene, 0, {0.75f, 0.75f}));   // 200 / 255 / 2 = 0.392
  EXPECT_FALSE(passes_alpha_test(*scene, 0, {0.25f, 0.75f}));  // 100 / 255 / 2
}

TEST(AlphaTest, WrapsAsTheSamplerSays) {
  const auto load = [](int wrap) {
    return textured_file({{"alphaMode", "MASK"}}, {{"wrapS", wrap}}).load_or_fail();
  };
  const ScenePtr repeat = load(10497);
  const ScenePtr clamp = load(33071);
  const ScenePtr mirror = load(33648);
  // Upper row: 0, 255. Only u is special here.
  EXPECT_TRUE(passes_alpha_test(*repeat, 0, {-0.25f, 0.25f}));
  EXPECT_FALSE(passes_alpha_test(*repeat, 0, {1.25f, 0.25f}));
  EXPECT_FALSE(passes_alpha_test(*clamp, 0, {-0.25f, 0.25f}));
  EXPECT_TRUE(passes_alpha_test(*clamp, 0, {1.25f, 0.25f}));
  EXPECT_FALSE(passes_alpha_test(*mirror, 0, {-0.25f, 0.25f}));
  EXPECT_TRUE(passes_alpha_test(*mirror, 0, {1.25f, 0.25f}));
  EXPECT_TRUE(passes_alpha_test(*mirror, 0, {-0.75f, 0.25f}));
  EXPECT_FALSE(passes_alpha_test(*mirror, 0, {1.75f, 0.25f}));
}

TEST(AlphaModes, OpaqueFirstThenTestedAndBlendedNotAtAll) {
  GltfFile file = textured_file({{"alphaMode", "MASK"}});
  file.root["materials"].push_back({{"alphaMode", "BLEND"}});
  file.root["materials"].push_back({{"alphaMode", "OPAQUE"}});
  for (const int material : {1, 2}) {
    file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", 0}}}, {"material", material}})}});
  }
  const ScenePtr scene = file.load_or_fail();
  const WorldMesh mesh = build_world_mesh(*scene);
  EXPECT_EQ(scene->triangle_count, 3u);
  EXPECT_EQ(mesh.opaque_count, 1u);
  EXPECT_EQ(mesh.materials, (std::vector<uint32_t>{2, 0}));
}

// Without a texture that has alpha the test comes out the same everywhere: no tracer need make it.
TEST(AlphaModes, ATestWithOneOutcomeIsNoTest) {
  for (const double alpha : {0.6, 0.4}) {
    GltfFile file = triangle_file();
    const json base = {{"baseColorFactor", {1, 1, 1, alpha}}};
    file.root["materials"] = json::array({json::object({{"alphaMode", "MASK"}, {"pbrMetallicRoughness", base}})});
    file.root["meshes"][0]["primitives"][0]["material"] = 0;
    const WorldMesh mesh = build_world_mesh(*file.load_or_fail());
    EXPECT_EQ(mesh.opaque_count, alpha > 0.5 ? 1u : 0u);
    EXPECT_EQ(mesh.triangles.size(), mesh.opaque_count);
  }
}

}  // namespace
}  // namespace gnomon::scenes::testing
