// Motion: the places of moving instances and lights at a time, which are those of the scene frozen at that time.
#include "scenes/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scenes/world_mesh.h"
#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

using namespace std::chrono_literals;

const float kQuarter = std::sqrt(0.5f);

void expect_near(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::distance(a, b), 1e-5f) << a.x << " " << a.y << " " << a.z;
}

// Node 0 with a triangle rests; node 1 carries the same mesh in node 2, and a spot light in node 3, both 2 along x.
GltfFile carousel() {
  GltfFile file = triangle_file();
  file.add_node({{"children", {2, 3}}});
  file.add_node({{"mesh", 0}, {"translation", {2, 0, 0}}});
  file.add_lamp({{"type", "spot"}, {"spot", json::object()}}, {{"translation", {2, 0, 0}}});
  file.root["scenes"] = json::array({json::object({{"nodes", {0, 1}}})});
  return file;
}

void turn(GltfFile& file, int node) {
  animate<glm::vec4>(file, node, "rotation", "LINEAR", {0, 1, 2},
                     {{0, 0, 0, 1}, {0, kQuarter, 0, kQuarter}, {0, 1, 0, 0}});
}

using Triangle = std::array<float, 9>;

std::vector<Triangle> sorted_triangles(const WorldMesh& mesh) {
  std::vector<Triangle> all;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    all.push_back({a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z});
  }
  std::sort(all.begin(), all.end());
  return all;
}

void expect_frozen_alike(const Scene& scene, SceneTime time) {
  std::vector<Triangle> apart = sorted_triangles(build_world_mesh(scene));
  const std::vector<Triangle> moving = sorted_triangles(build_moving_mesh(scene, time));
  apart.insert(apart.end(), moving.begin(), moving.end());
  std::sort(apart.begin(), apart.end());
  const auto frozen = frozen_at(scene, time);
  EXPECT_FALSE(moves(*frozen));
  EXPECT_EQ(apart, sorted_triangles(build_world_mesh(*frozen))) << time.count();
}

TEST(Motion, MovesWhatIsBelowAnAnimatedNodeAndNothingElse) {
  GltfFile file = carousel();
  turn(file, 1);
  const ScenePtr scene = file.load_or_fail();
  ASSERT_TRUE(moves(*scene));
  EXPECT_EQ(scene->period, SceneTime(2s));
  EXPECT_EQ(build_world_mesh(*scene).triangles.size(), 1u);
  expect_near(build_moving_mesh(*scene, 0s).positions.at(0), {2, 0, 0});
  expect_near(build_moving_mesh(*scene, 1s).positions.at(0), {0, 0, -2});
  expect_near(build_moving_mesh(*scene, 500ms).positions.at(0), {2 * kQuarter, 0, -2 * kQuarter});
  expect_near(build_moving_mesh(*scene, 1s).positions.at(1), {0, 0, -3});
  const std::vector<Light> lights = lights_at(*scene, scene->lights, 1s);
  expect_near(lights.at(0).position, {0, 0, -2});
  expect_near(lights.at(0).direction, {-1, 0, 0});
}

TEST(Motion, ScenesAtRestHaveNone) {
  const ScenePtr scene = carousel().load_or_fail();
  EXPECT_FALSE(moves(*scene));
  EXPECT_EQ(within_period(*scene, 5s), SceneTime(0));
  EXPECT_TRUE(build_moving_mesh(*scene, 1s).triangles.empty());
  EXPECT_EQ(build_world_mesh(*scene).triangles.size(), 2u);
  EXPECT_EQ(lights_at(*scene, scene->lights, 1s).at(0).position, scene->lights.at(0).position);
}

TEST(Motion, AllBeginsAnewAfterTheLongestAnimation) {
  GltfFile file = carousel();
  turn(file, 1);
  animate<glm::vec3>(file, 2, "translation", "LINEAR", {0, 0.5f}, {{2, 0, 0}, {4, 0, 0}});
  const ScenePtr scene = file.load_or_fail();
  EXPECT_EQ(within_period(*scene, 5s), SceneTime(1s));
  EXPECT_EQ(within_period(*scene, -500ms), SceneTime(1500ms));
  expect_near(build_moving_mesh(*scene, 1s).positions.at(0), {0, 0, -4});  // held after its last key
}

TEST(Motion, ThePlaceOfAnInstanceIsThatAtTimeZero) {
  GltfFile file = triangle_file();
  animate<glm::vec3>(file, 0, "translation", "STEP", {0, 1}, {{0, 7, 0}, {0, 8, 0}});
  const ScenePtr scene = file.load_or_fail();
  expect_near(glm::vec3(scene->instances.at(0).object_to_world[3]), {0, 7, 0});
  expect_near(build_moving_mesh(*scene, 1s).positions.at(0), {0, 8, 0});
}

TEST(Motion, IsThatOfTheWholeSceneStopped) {
  GltfFile file = carousel();
  turn(file, 1);
  // The scale passes through 0 to a mirrored triangle.
  animate<glm::vec3>(file, 2, "scale", "LINEAR", {0, 1, 2}, {{1, 1, 1}, {0, 0, 0}, {-1, 1, 1}});
  const ScenePtr scene = file.load_or_fail();
  for (int ms = 0; ms <= 2000; ms += 125) expect_frozen_alike(*scene, std::chrono::milliseconds(ms));
  EXPECT_TRUE(build_moving_mesh(*scene, 1s).triangles.empty());
  EXPECT_EQ(moving_mesh_size(*scene).triangles, 1u);
  const WorldMesh mirrored = build_moving_mesh(*scene, 2s);
  EXPECT_EQ(mirrored.triangles.at(0), glm::uvec3(0, 1, 2));  // flat: corners stand in their order
  expect_near(mirrored.normals.at(0), {0, 0, -1});           // half a turn, its winding turned back
}

TEST(Motion, BoundsHoldWhatMovesAtAnyTime) {
  GltfFile file = carousel();
  animate<glm::vec4>(file, 1, "rotation", "CUBICSPLINE", {0, 3},
                     {glm::vec4(0), {0, 0, 0, 1}, {0, 2, 1, 0}, {1, 0, 2, 0}, {0, 1, 0, 0}, glm::vec4(0)});
  const ScenePtr scene = file.load_or_fail();
  for (int ms = 0; ms <= 3000; ++ms) {
    for (const glm::vec3& p : build_moving_mesh(*scene, std::chrono::milliseconds(ms)).positions) {
      ASSERT_TRUE(glm::all(glm::lessThanEqual(scene->bounds.min, p))) << ms;
      ASSERT_TRUE(glm::all(glm::lessThanEqual(p, scene->bounds.max))) << ms;
    }
  }
  EXPECT_LT(glm::length(scene->bounds.max - scene->bounds.min), 20.0f);
}

TEST(Motion, CountsInTheContentHash) {
  const auto hash_of = [](const std::vector<glm::vec3>& values, const char* interpolation = "LINEAR") {
    GltfFile file = carousel();
    if (!values.empty()) animate<glm::vec3>(file, 1, "translation", interpolation, {0, 1}, values);
    return to_hex(file.load_or_fail()->content_hash);
  };
  const std::string there = hash_of({{0, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(there, hash_of({{0, 0, 0}, {1, 0, 0}}));
  EXPECT_NE(there, hash_of({{0, 0, 0}, {1, 0, std::nextafter(0.0f, 1.0f)}}));
  EXPECT_NE(there, hash_of({{0, 0, 0}, {1, 0, 0}}, "STEP"));
  EXPECT_NE(there, hash_of({}));
}

ScenePtr load_with(const GltfFile& file, const std::vector<NodeMotion>& motions) {
  const ScratchFolder folder;
  auto scene = load_scene(folder.write("scene.gltf", file.gltf()), {}, motions);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? *scene : std::make_shared<Scene>();
}

TEST(GivenMotion, SpinsAndShiftsAndRepeatsUntilTheLongestEnds) {
  GltfFile file = carousel();
  file.root["nodes"][1]["name"] = "wheel";
  file.root["nodes"][3]["name"] = "lamp";
  using Kind = NodeMotion::Kind;
  const ScenePtr scene =
      load_with(file, {{"wheel", Kind::spin, {0, 2, 0}, 4s}, {"lamp", Kind::shift, {0, 1, 0}, 1s}});
  EXPECT_EQ(scene->period, SceneTime(4s));
  expect_near(build_moving_mesh(*scene, 0s).positions.at(0), {2, 0, 0});
  expect_near(build_moving_mesh(*scene, 1s).positions.at(0), {0, 0, -2});
  expect_near(build_moving_mesh(*scene, 500ms).positions.at(0), {2 * kQuarter, 0, -2 * kQuarter});
  expect_near(build_moving_mesh(*scene, 3s).positions.at(0), {0, 0, 2});
  for (const SceneTime turn : {SceneTime(0), SceneTime(1s), SceneTime(3s)}) {
    EXPECT_NEAR(lights_at(*scene, scene->lights, turn).at(0).position.y, 0, 1e-5);
    EXPECT_NEAR(lights_at(*scene, scene->lights, turn + 250ms).at(0).position.y, 0.5, 1e-5);
    EXPECT_NEAR(lights_at(*scene, scene->lights, turn + 500ms).at(0).position.y, 1, 1e-5);
  }
  EXPECT_NE(scene->content_hash, load_with(file, {{"wheel", Kind::spin, {0, 2, 0}, 4s}})->content_hash);
}

TEST(GivenMotion, MovesANodeThatIsPlacedByAMatrix) {
  using Kind = NodeMotion::Kind;
  const auto with = [](const json& matrix) {
    GltfFile file = carousel();
    file.root["nodes"][2].erase("translation");
    file.root["nodes"][2]["matrix"] = matrix;
    file.root["nodes"][2]["name"] = "chair";
    return file;
  };
  // A quarter turn about Y, twice as large, two metres along X.
  const json turned = {0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 2, 0, 0, 1};
  const ScenePtr rests = with(turned).load_or_fail();
  const ScenePtr scene = load_with(with(turned), {{"chair", Kind::spin, {0, 1, 0}, 4s}});
  const WorldMesh at_rest = build_world_mesh(*rests), moving = build_moving_mesh(*scene, 0s);
  for (size_t i = 0; i < moving.positions.size(); ++i) {
    const auto same = [&](const glm::vec3& p) { return glm::length(p - moving.positions[i]) < 1e-5f; };
    EXPECT_TRUE(std::any_of(at_rest.positions.begin(), at_rest.positions.end(), same)) << i;
  }
  const WorldMesh half = build_moving_mesh(*scene, 2s);
  for (size_t i = 0; i < half.positions.size(); ++i) {
    expect_near(half.positions[i] - glm::vec3(2, 0, 0),
                (moving.positions[i] - glm::vec3(2, 0, 0)) * glm::vec3(-1, 1, -1));
  }
  const ScratchFolder folder;
  const json skewed = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1};
  const auto refused =
      load_scene(folder.write("scene.gltf", with(skewed).gltf()), {}, {{"chair", Kind::spin, {0, 1, 0}, 4s}});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("its matrix is skewed or flat"), std::string::npos)
      << refused.error().message;
}

TEST(Motion, NothingGoesFartherThanNumbersReach) {
  for (const glm::vec3 far : {glm::vec3(3e9f, 0, 0), glm::vec3(0, -2e9f, 0)}) {
    GltfFile file = carousel();
    animate<glm::vec3>(file, 3, "translation", "LINEAR", {0, 1, 2}, {{2, 0, 0}, far, {2, 0, 0}});
    const ScratchFolder folder;
    const auto scene = load_scene(folder.write("scene.gltf", file.gltf()));
    ASSERT_FALSE(scene) << "the lamp at " << far.x;
    EXPECT_NE(scene.error().message.find("a million kilometres"), std::string::npos) << scene.error().message;
  }
}

// One motion may be that of thousands of nodes, each of which has its keys.
TEST(GivenMotion, HasNoMoreKeysThanTheFileMayAskFor) {
  GltfFile file = carousel();
  turn(file, 1);
  for (int i = 0; i < 20'000; ++i) {
    file.add_node({{"mesh", 0}, {"name", "leaf"}});
    file.root["scenes"][0]["nodes"].push_back(4 + i);
  }
  const ScratchFolder folder;
  const auto scene =
      load_scene(folder.write("scene.gltf", file.gltf()), {}, {{"leaf", NodeMotion::Kind::spin, {0, 1, 0}, 3ms}});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("names one thing too often"), std::string::npos) << scene.error().message;
}

TEST(GivenMotion, MustMoveSomething) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.gltf", carousel().gltf());
  const auto scene = load_scene(file, {}, {{"fan", NodeMotion::Kind::spin, {0, 1, 0}, 4s}});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("no node is named 'fan'"), std::string::npos);
}

TEST(Motion, BrokenAnimationsAreNamed) {
  GltfFile file = carousel();
  animate<glm::vec3>(file, 1, "translation", "LINEAR", {0, 2, 1}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  EXPECT_NE(file.load_error().find("do not increase"), std::string::npos);
  GltfFile far = carousel();
  animate<glm::vec3>(far, 1, "translation", "LINEAR", {0, 1}, {{0, 0, 0}, {3e9f, 0, 0}});
  EXPECT_NE(far.load_error().find("farther than a million kilometres"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::scenes::testing
