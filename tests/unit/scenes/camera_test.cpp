// Cameras, their paths, and the orbit of scenes that have none.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

const float kQuarter = std::sqrt(0.5f);

glm::vec3 forward(const CameraPose& pose) { return pose.orientation * glm::vec3(0, 0, -1); }
glm::vec3 up(const CameraPose& pose) { return pose.orientation * glm::vec3(0, 1, 0); }

void expect_near(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::distance(a, b), 1e-5f) << a.x << " " << a.y << " " << a.z;
}

// A camera on node 1, child of node 0.
GltfFile camera_file(json camera_node = json::object(), json parent = json::object()) {
  GltfFile file;
  file.root["cameras"] =
      json::array({json::object({{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.01}}}})});
  parent["children"] = {1};
  camera_node["camera"] = 0;
  file.add_node(parent);
  file.add_node(camera_node);
  return file;
}

CameraPose pose(const Scene& scene, float seconds) {
  return pose_at(scene.paths.at(0), scene.cameras.at(0).rest.vertical_fov, seconds);
}

TEST(Cameras, RestPoseComesThroughTheHierarchy) {
  const GltfFile file =
      camera_file({{"translation", {0, 0, 2}}}, {{"rotation", {0, kQuarter, 0, kQuarter}}, {"scale", {3, 3, 3}}});
  const ScenePtr scene = file.load_or_fail();
  ASSERT_EQ(scene->cameras.size(), 1u);
  EXPECT_TRUE(scene->paths.empty());
  const CameraPose& rest = scene->cameras[0].rest;
  expect_near(rest.position, {6, 0, 0});
  expect_near(forward(rest), {-1, 0, 0});
  expect_near(up(rest), {0, 1, 0});
  EXPECT_FLOAT_EQ(rest.vertical_fov, 0.7f);
}

TEST(Cameras, MirroringDoesNotReachTheOrientation) {
  const ScenePtr scene = camera_file(json::object(), {{"scale", {-1, 1, 1}}}).load_or_fail();
  expect_near(forward(scene->cameras.at(0).rest), {0, 0, -1});
  expect_near(up(scene->cameras.at(0).rest), {0, 1, 0});
}

TEST(Cameras, OrthographicOnesAreLeftOut) {
  GltfFile file = camera_file();
  const json size = {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 1}};
  file.root["cameras"] = json::array({json::object({{"type", "orthographic"}, {"orthographic", size}})});
  EXPECT_EQ(file.load_or_fail()->cameras.at(0).name, "bounds");
}

TEST(CameraPaths, LinearTranslationIsClampedToItsKeys) {
  GltfFile file = camera_file();
  animate<glm::vec3>(file, 1, "translation", "LINEAR", {1, 3, 4}, {{0, 0, 0}, {4, 0, 0}, {4, 8, 0}});
  const ScenePtr scene = file.load_or_fail();
  ASSERT_EQ(scene->paths.size(), 1u);
  EXPECT_EQ(scene->paths[0].duration_seconds, 4.0f);
  expect_near(pose(*scene, -5).position, {0, 0, 0});
  expect_near(pose(*scene, 0.5f).position, {0, 0, 0});
  expect_near(pose(*scene, 1.5f).position, {1, 0, 0});
  expect_near(pose(*scene, 3.25f).position, {4, 2, 0});
  expect_near(pose(*scene, 99).position, {4, 8, 0});
  expect_near(pose(*scene, std::nanf("")).position, {0, 0, 0});
}

TEST(CameraPaths, StepHoldsUntilTheNextKey) {
  GltfFile file = camera_file();
  animate<glm::vec3>(file, 1, "translation", "STEP", {0, 2}, {{1, 0, 0}, {2, 0, 0}});
  const ScenePtr scene = file.load_or_fail();
  expect_near(pose(*scene, 1.999f).position, {1, 0, 0});
  expect_near(pose(*scene, 2.0f).position, {2, 0, 0});
}

// p(t) = 3 t^2 - 2 t^3 between 0 and 1 with flat tangents; an outgoing tangent of 4 per second adds
// 4 * 2 s * (t^3 - 2 t^2 + t), at t = 1/2 one.
TEST(CameraPaths, CubicSplinesFollowTheirTangents) {
  GltfFile file = camera_file();
  const glm::vec3 none(0.0f);
  animate<glm::vec3>(file, 1, "translation", "CUBICSPLINE", {0, 2},
                     {none, {0, 0, 0}, {0, 4, 0}, none, {1, 0, 0}, none});
  const ScenePtr scene = file.load_or_fail();
  expect_near(pose(*scene, 0).position, {0, 0, 0});
  expect_near(pose(*scene, 0.5f).position, {3.0f / 16 - 2.0f / 64, 8.0f * (1.0f / 64 - 2.0f / 16 + 0.25f), 0});
  expect_near(pose(*scene, 1).position, {0.5f, 1, 0});
  expect_near(pose(*scene, 2).position, {1, 0, 0});
}

TEST(CameraPaths, RotationsTakeTheShortWay) {
  GltfFile file = camera_file();
  // A quarter turn about Y, written with the quaternion's other sign.
  animate<glm::vec4>(file, 1, "rotation", "LINEAR", {0, 1}, {{0, 0, 0, 1}, {0, -kQuarter, 0, -kQuarter}});
  const ScenePtr scene = file.load_or_fail();
  expect_near(forward(pose(*scene, 0.5f)), {-kQuarter, 0, -kQuarter});
  expect_near(forward(pose(*scene, 1)), {-1, 0, 0});
}

TEST(CameraPaths, AncestorsCarryTheCameraAlong) {
  GltfFile file = camera_file({{"translation", {0, 0, 5}}});
  animate<glm::vec4>(file, 0, "rotation", "LINEAR", {0, 1}, {{0, 0, 0, 1}, {0, kQuarter, 0, kQuarter}});
  animate<glm::vec3>(file, 1, "translation", "LINEAR", {0, 3}, {{0, 0, 5}, {0, 0, 8}});
  const ScenePtr scene = file.load_or_fail();
  ASSERT_EQ(scene->paths.size(), 1u);
  EXPECT_EQ(scene->paths[0].duration_seconds, 3.0f);
  expect_near(pose(*scene, 0).position, {0, 0, 5});
  expect_near(pose(*scene, 1).position, {6, 0, 0});
  expect_near(pose(*scene, 3).position, {8, 0, 0});
  expect_near(forward(pose(*scene, 3)), {-1, 0, 0});
}

TEST(CameraPaths, OtherNodesDoNotMatter) {
  GltfFile file = camera_file();
  file.add_node(json::object());
  animate<glm::vec3>(file, 2, "translation", "LINEAR", {0, 9}, {{0, 0, 0}, {1, 1, 1}});
  EXPECT_TRUE(file.load_or_fail()->paths.empty());
}

TEST(CameraPaths, TimesMustIncreaseAndHaveTheirValues) {
  GltfFile unordered = camera_file();
  animate<glm::vec3>(unordered, 1, "translation", "LINEAR", {0, 2, 1}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  EXPECT_NE(unordered.load_error().find("do not increase"), std::string::npos);
  GltfFile lacking = camera_file();
  animate<glm::vec3>(lacking, 1, "translation", "CUBICSPLINE", {0, 1}, {{0, 0, 0}, {1, 0, 0}});
  EXPECT_NE(lacking.load_error().find("2 values for 2 times"), std::string::npos);
}

TEST(Orbit, OfInteriorsStaysInsideTheBounds) {
  GltfFile file = triangle_file();
  file.root["nodes"][0]["scale"] = {8, 3, 5};
  file.add_node({{"mesh", 0}, {"translation", {0, 0, 5}}});
  file.add_lamp({{"type", "point"}}, {{"translation", {2, 1, 2}}});
  const ScenePtr scene = file.load_or_fail();
  for (float t = 0; t < kOrbitSeconds; t += 0.5f) {
    const CameraPose at = orbit_pose(*scene, t);
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(at.position, scene->bounds.min)));
    EXPECT_TRUE(glm::all(glm::lessThanEqual(at.position, scene->bounds.max)));
  }
}

TEST(Orbit, FromOutsideSeesTheWholeScene) {
  const ScenePtr scene = triangle_file().load_or_fail();
  ASSERT_EQ(scene->cameras.size(), 1u);  // the view of its bounds
  for (float t = 0; t < kOrbitSeconds; t += 0.5f) {
    const CameraPose at = orbit_pose(*scene, t);
    for (const glm::vec3& corner : {scene->bounds.min, scene->bounds.max}) {
      const float along = glm::dot(glm::normalize(corner - at.position), forward(at));
      EXPECT_GT(along, std::cos(0.5f * at.vertical_fov));
    }
  }
  EXPECT_EQ(orbit_pose(*scene, 0).position, scene->cameras[0].rest.position);
}

}  // namespace
}  // namespace gnomon::scenes::testing
