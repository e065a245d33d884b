// Lights of glTF files (KHR_lights_punctual).
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

Light load_light(const json& light, const json& node = json::object()) {
  GltfFile file = triangle_file();
  file.add_lamp(light, node);
  const ScenePtr scene = file.load_or_fail();
  return scene->lights.empty() ? Light{} : scene->lights[0];
}

TEST(Lights, PointAtItsNode) {
  const Light light =
      load_light({{"type", "point"}, {"name", "lamp"}, {"color", {1, 0.5, 0.25}}, {"intensity", 40}, {"range", 6}},
                 {{"translation", {1, 2, 3}}, {"scale", {5, 5, 5}}});
  EXPECT_EQ(light.type, LightType::point);
  EXPECT_EQ(light.name, "lamp");
  EXPECT_EQ(light.position, glm::vec3(1, 2, 3));
  EXPECT_EQ(light.color, glm::vec3(1, 0.5f, 0.25f));
  EXPECT_EQ(light.intensity, 40.0f);
  EXPECT_EQ(light.range, 6.0f);  // not scaled
}

TEST(Lights, DefaultsAreThoseOfTheExtension) {
  const Light light = load_light({{"type", "point"}}, {{"name", "by node"}});
  EXPECT_EQ(light.name, "by node");
  EXPECT_EQ(light.color, glm::vec3(1.0f));
  EXPECT_EQ(light.intensity, 1.0f);
  EXPECT_EQ(light.range, 0.0f);
}

TEST(Lights, DirectionalShinesAlongMinusZ) {
  const float s = std::sqrt(0.5f);  // a quarter turn about X takes -Z to +Y
  const Light light = load_light({{"type", "directional"}}, {{"rotation", {s, 0, 0, s}}, {"scale", {9, 9, 9}}});
  EXPECT_EQ(light.type, LightType::directional);
  EXPECT_LT(glm::distance(light.direction, glm::vec3(0, 1, 0)), 1e-6f);
}

TEST(Lights, SpotHasItsCone) {
  const Light light = load_light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}});
  EXPECT_EQ(light.type, LightType::spot);
  EXPECT_EQ(light.direction, glm::vec3(0, 0, -1));
  EXPECT_FLOAT_EQ(light.inner_cone_cos, std::cos(0.25f));
  EXPECT_FLOAT_EQ(light.outer_cone_cos, std::cos(0.5f));
  const Light by_default = load_light({{"type", "spot"}, {"spot", json::object()}});
  EXPECT_EQ(by_default.inner_cone_cos, 1.0f);
  EXPECT_FLOAT_EQ(by_default.outer_cone_cos, std::sqrt(0.5f));
}

TEST(Lights, NodesCarryThemThroughTheHierarchyInOrder) {
  GltfFile file = triangle_file();
  for (int i = 0; i < 40; ++i) file.add_lamp({{"type", "point"}}, {{"translation", {i, 0, 0}}});
  file.add_light({{"type", "point"}});  // on no node
  const ScenePtr scene = file.load_or_fail();
  ASSERT_EQ(scene->lights.size(), 40u);
  EXPECT_EQ(scene->mask_words(), 2u);
  for (size_t i = 0; i < 40; ++i) EXPECT_EQ(scene->lights[i].position.x, static_cast<float>(i));
}

TEST(Lights, WhatIsNotValidIsRefused) {
  const auto error = [](const json& light) {
    GltfFile file = triangle_file();
    file.add_lamp(light);
    return file.load_error();
  };
  EXPECT_NE(error({{"type", "area"}}).find("'area'"), std::string::npos);
  EXPECT_NE(error({{"type", "point"}, {"intensity", -1}}).find("intensity"), std::string::npos);
  EXPECT_NE(error({{"type", "point"}, {"range", -1}}).find("range"), std::string::npos);
  EXPECT_NE(error({{"type", "point"}, {"color", {1, 1}}}).find("colour"), std::string::npos);
  EXPECT_NE(error({{"type", "spot"}, {"spot", {{"outerConeAngle", 3.0}}}}).find("outer cone"), std::string::npos);
  GltfFile far_away = triangle_file();
  far_away.add_lamp({{"type", "point"}}, {{"translation", {0, 2e9, 0}}});
  EXPECT_NE(far_away.load_error().find("farther"), std::string::npos);
  GltfFile dangling = triangle_file();
  dangling.add_lamp({{"type", "point"}});
  dangling.add_node({{"extensions", {{"KHR_lights_punctual", {{"light", 5}}}}}});
  EXPECT_NE(dangling.load_error().find("light 5 does not exist"), std::string::npos);
}

TEST(Lights, TheirNumberIsLimited) {
  GltfFile file = triangle_file();
  for (int i = 0; i < 9; ++i) file.add_lamp({{"type", "point"}});
  const ScratchFolder folder;
  LoadLimits limits;
  limits.max_lights = 8;
  const Result<ScenePtr> scene = load_scene(folder.write("a.gltf", file.gltf()), limits);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("more than 8 lights"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::scenes::testing
