// Ambient light and sky of extras.gnomon, and which textures a server reads.
#include <gtest/gtest.h>

#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/png.h"

namespace gnomon::scenes::testing {
namespace {

GltfFile surrounded(const json& gnomon) {
  GltfFile file = triangle_file();
  file.root["scenes"] = json::array({{{"nodes", {0}}, {"extras", {{"gnomon", gnomon}}}}});
  file.root["scene"] = 0;
  return file;
}

TEST(Surroundings, AreWhatTheScenesExtrasSay) {
  const json said = {
      {"ambient", {{"above", {0.1, 0.2, 0.3}}, {"below", {1, 2, 3}}, {"reach", 0.75}}},
      {"sky",
       {{"zenith", {0.25, 0.5, 1.0}}, {"horizon", {2, 1.5, 1}}, {"ground", {0.5, 0.5, 0.25}}, {"clouds", 0.75}}}};
  const Surroundings around = surrounded(said).load_or_fail()->surroundings;
  EXPECT_EQ(around.ambient_above, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(around.ambient_below, glm::vec3(1, 2, 3));
  EXPECT_EQ(around.ambient_reach, 0.75f);
  EXPECT_TRUE(around.has_sky);
  EXPECT_EQ(around.sky_zenith, glm::vec3(0.25f, 0.5f, 1.0f));
  EXPECT_EQ(around.sky_horizon, glm::vec3(2, 1.5f, 1));
  EXPECT_EQ(around.sky_ground, glm::vec3(0.5f, 0.5f, 0.25f));
  EXPECT_EQ(around.sky_clouds, 0.75f);
}

TEST(Surroundings, AreNoneWithoutThem) {
  const Surroundings around = triangle_file().load_or_fail()->surroundings;
  EXPECT_EQ(around.ambient_above, glm::vec3(0.0f));
  EXPECT_EQ(around.ambient_reach, 0.0f);
  EXPECT_FALSE(around.has_sky);
}

TEST(Surroundings, MembersThatAreNotWhatTheyShouldBeAreLeftOut) {
  for (const json& odd :
       {json("bright"), json{1, 2}, json{1, 2, "3"}, json{1, 2, -3}, json{1, 2, 1e9}, json(nullptr)}) {
    const json said = {{"ambient", {{"above", odd}, {"below", {1, 1, 1}}}}, {"sky", {{"zenith", odd}}}};
    const Surroundings around = surrounded(said).load_or_fail()->surroundings;
    EXPECT_EQ(around.ambient_above, glm::vec3(0.0f)) << odd;
    EXPECT_EQ(around.ambient_below, glm::vec3(1.0f)) << odd;
    EXPECT_EQ(around.sky_zenith, glm::vec3(0.0f)) << odd;
  }
  for (const json& odd : {json(7), json("dark"), json::array({1}), json(nullptr)}) {
    EXPECT_FALSE(surrounded(odd).load_or_fail()->surroundings.has_sky) << odd;
  }
  for (const json& odd : {json(-1), json(1e9), json("far"), json::array({1})}) {
    EXPECT_EQ(surrounded({{"ambient", {{"reach", odd}}}}).load_or_fail()->surroundings.ambient_reach, 0.0f) << odd;
  }
  EXPECT_EQ(surrounded({{"sky", {{"clouds", 1.5}}}}).load_or_fail()->surroundings.sky_clouds, 0.0f);
}

// One triangle with a texture; its alpha tests anything only if `material` says so.
GltfFile textured(const json& material) {
  GltfFile file;
  const int positions = file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const int uvs = file.add_accessor(std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}, kFloat, "VEC2");
  const json attributes = {{"POSITION", positions}, {"TEXCOORD_0", uvs}};
  file.add_node({{"mesh", file.add_mesh({{"attributes", attributes}, {"material", 0}})}});
  const std::string image = base64(png(1, 2, {10, 20, 30, 0, 10, 20, 30, 255}));
  file.root["images"] = json::array({json::object({{"uri", "data:image/png;base64," + image}})});
  file.root["textures"] = json::array({json::object({{"source", 0}})});
  json m = material;
  m["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  file.root["materials"] = json::array({m});
  return file;
}

TEST(ColourTextures, AServerReadsNoneAndFindsTheSameScene) {
  const ScratchFolder folder;
  for (const char* mode : {"OPAQUE", "BLEND", "MASK"}) {
    const auto file = folder.write("a.gltf", textured({{"alphaMode", mode}}).gltf());
    const auto drawn = load_scene(file), served = load_with_geometry(file);
    ASSERT_TRUE(drawn && served);
    EXPECT_EQ((*drawn)->textures.size(), 1u) << mode;
    EXPECT_EQ((*served)->textures.size(), mode == std::string("MASK") ? 1u : 0u) << mode;
    EXPECT_EQ((*drawn)->content_hash, (*served)->content_hash) << mode;
  }
}

}  // namespace
}  // namespace gnomon::scenes::testing
