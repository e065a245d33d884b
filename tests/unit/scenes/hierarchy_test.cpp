// Nodes: where the hierarchy puts things.
#include <gtest/gtest.h>

#include "scenes/world_mesh.h"
#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

// Triangle (0,0,0) (1,0,0) (0,1,0) as mesh 0, on no node yet.
GltfFile mesh_alone() {
  GltfFile file = triangle_file();
  file.root.erase("nodes");
  return file;
}

std::vector<glm::vec3> world_positions(const GltfFile& file) {
  return build_world_mesh(*file.load_or_fail()).positions;
}

TEST(Hierarchy, TranslationRotationAndScaleApplyFromTheRight) {
  GltfFile file = mesh_alone();
  const float s = std::sqrt(0.5f);  // a quarter turn about Z
  file.add_node({{"mesh", 0}, {"translation", {10, 0, 0}}, {"rotation", {0, 0, s, s}}, {"scale", {2, 3, 1}}});
  const auto p = world_positions(file);
  ASSERT_EQ(p.size(), 3u);
  EXPECT_LT(glm::distance(p[0], glm::vec3(10, 0, 0)), 1e-6f);
  EXPECT_LT(glm::distance(p[1], glm::vec3(10, 2, 0)), 1e-6f);
  EXPECT_LT(glm::distance(p[2], glm::vec3(7, 0, 0)), 1e-6f);
}

TEST(Hierarchy, MatricesAreInColumns) {
  GltfFile file = mesh_alone();
  file.add_node({{"mesh", 0}, {"matrix", {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1}}});
  EXPECT_EQ(world_positions(file), (std::vector<glm::vec3>{{10, 0, 0}, {10, 2, 0}, {7, 0, 0}}));
}

TEST(Hierarchy, ParentsApplyAfterChildren) {
  GltfFile file = mesh_alone();
  file.root["scenes"] = json::array({json::object({{"nodes", {0}}})});
  file.add_node({{"children", {1}}, {"scale", {2, 2, 2}}});
  file.add_node({{"children", {2}}, {"translation", {1, 0, 0}}});
  file.add_node({{"mesh", 0}, {"translation", {0, 5, 0}}});
  EXPECT_EQ(world_positions(file), (std::vector<glm::vec3>{{2, 10, 0}, {4, 10, 0}, {2, 12, 0}}));
}

TEST(Hierarchy, MeshesOfSeveralNodesAreKeptOnce) {
  GltfFile file = mesh_alone();
  file.add_node({{"mesh", 0}});
  file.add_node({{"mesh", 0}, {"translation", {0, 0, 7}}});
  const ScenePtr scene = file.load_or_fail();
  EXPECT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->instances.size(), 2u);
  EXPECT_EQ(scene->triangle_count, 2u);
  EXPECT_EQ(scene->bounds.max, glm::vec3(1, 1, 7));
}

TEST(Hierarchy, TheDefaultSceneIsTaken) {
  GltfFile file = mesh_alone();
  file.add_node({{"mesh", 0}});
  file.add_node({{"mesh", 0}, {"translation", {0, 0, 7}}});
  file.root["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  EXPECT_EQ(world_positions(file).at(0), glm::vec3(0, 0, 0));
  file.root["scene"] = 1;
  EXPECT_EQ(world_positions(file).at(0), glm::vec3(0, 0, 7));
  file.root["scene"] = 2;
  EXPECT_NE(file.load_error().find("scene 2"), std::string::npos);
}

TEST(Hierarchy, OfAFileWithoutScenesTheRootsAreTaken) {
  GltfFile file = mesh_alone();
  file.add_node({{"mesh", 0}});
  file.add_node({{"children", {0}}, {"translation", {0, 0, 1}}});
  EXPECT_EQ(file.load_or_fail()->instances.size(), 1u);
  EXPECT_EQ(world_positions(file).at(0), glm::vec3(0, 0, 1));
}

TEST(Hierarchy, GraphsThatAreNoForestAreRefused) {
  const auto error = [](const json& nodes) {
    GltfFile file;
    file.root["nodes"] = nodes;
    return file.load_error();
  };
  EXPECT_NE(error({{{"children", {0}}}}).find("node 0 lies on a cycle"), std::string::npos);
  EXPECT_NE(error({{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}}).find("node 1 has two parents"),
            std::string::npos);
  EXPECT_NE(error({{{"name", "root"}}, {{"children", {2}}}, {{"children", {1}}}}).find("cycle"), std::string::npos);
  EXPECT_NE(error({{{"children", {9}}}}).find("node 9 does not exist"), std::string::npos);
}

TEST(Hierarchy, DepthIsLimited) {
  const auto chain = [](int length) {
    GltfFile file;
    for (int i = 0; i < length; ++i) {
      file.add_node(i + 1 < length ? json::object({{"children", {i + 1}}}) : json::object());
    }
    return file.load_error();
  };
  EXPECT_EQ(chain(1024), "");
  EXPECT_NE(chain(1025).find("deeper than 1024"), std::string::npos);
}

TEST(Hierarchy, WhatIsTooFarAwayIsRefused) {
  GltfFile file = mesh_alone();
  file.add_node({{"mesh", 0}, {"translation", {0, 0, 2e9}}});
  EXPECT_NE(file.load_error().find("reaches farther"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::scenes::testing
