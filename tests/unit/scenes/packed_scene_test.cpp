// A scene as bytes for another process: what comes out is what went in, and bytes that are wrong give an error.
#include "scenes/packed/packed_scene.h"

#include <gtest/gtest.h>

#include <random>

#include "scenes/geometry/geometry.h"
#include "scenes/packed/check.h"
#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/invariants.h"
#include "tests/unit/scenes/support/written_bytes.h"

namespace gnomon::scenes::testing {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(const Result<ScenePtr>& scene) {
  return written_bytes([&](std::FILE* file) { return write_outcome(scene, file); });
}

// A scene with some of everything: an animated mesh, light and camera, a mesh that rests, a name for each.
ScenePtr rich_scene() {
  GltfFile file = triangle_file();
  file.root["nodes"][0]["name"] = "moving";
  animate<glm::vec3>(file, 0, "translation", "LINEAR", {0, 1, 3}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}});
  file.add_node({{"mesh", 0}, {"translation", {2, 0, 0}}});
  file.add_lamp({{"type", "spot"}, {"spot", json::object()}, {"name", "lamp"}}, {{"translation", {0, 3, 0}}});
  const int camera = GltfFile::add(file.root["cameras"],
                                   {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}});
  const int eye = file.add_node({{"camera", camera}});
  animate<glm::vec3>(file, eye, "translation", "STEP", {0, 2}, {{0, 0, 5}, {1, 0, 5}});
  file.root["scenes"] = json::array({json::object({{"nodes", {0, 1, 2, eye}}})});
  const auto scene = std::make_shared<Scene>(*file.load_or_fail());
  scene->geometry = std::make_shared<Geometry>(make_geometry(*scene));
  scene->surroundings.sky_horizon = {1, 2, 3};
  scene->textures.push_back({.width = 2, .height = 2, .rgba = {}, .encoded = {0xff, 0xd8}});
  return scene;
}

// Everything of a scene is in its bytes: two scenes with the same bytes are the same.
TEST(PackedScene, ComesBackAsItWas) {
  const ScenePtr scene = rich_scene();
  ASSERT_FALSE(scene->moving_nodes.empty());
  ASSERT_FALSE(scene->paths.empty());
  ASSERT_EQ(scene->lights.size(), 1u);
  const Bytes bytes = bytes_of(scene);
  const auto back = read_outcome(bytes, {});
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(bytes_of(*back), bytes);
  EXPECT_EQ((*back)->content_hash, scene->content_hash);
  EXPECT_EQ((*back)->memory_bytes(), scene->memory_bytes());
  EXPECT_EQ((*back)->lights[0].name, "lamp");
  EXPECT_EQ((*back)->surroundings.sky_horizon, glm::vec3(1, 2, 3));
  EXPECT_EQ((*back)->textures[0].encoded, scene->textures[0].encoded);
  EXPECT_EQ(broken_promise(**back), "");
}

TEST(PackedScene, AReasonComesBackAsItWas) {
  const auto back = read_outcome(bytes_of(Error{"it has too many triangles"}), {});
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().message, "it has too many triangles");
}

TEST(PackedScene, WhatIsCutOffOrTooLongIsAnError) {
  Bytes bytes = bytes_of(rich_scene());
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_FALSE(read_outcome(std::span(bytes).first(size), {})) << size << " of " << bytes.size();
  }
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(read_outcome(bytes, {}));
}

// A byte that changes gives an error, or a scene that keeps its promises.
TEST(PackedScene, DamagedBytesNeverGiveABrokenScene) {
  const Bytes good = bytes_of(rich_scene());
  std::mt19937 random(7);
  size_t refused = 0;
  for (size_t at = 0; at < good.size(); ++at) {
    Bytes bytes = good;
    bytes[at] ^= static_cast<std::byte>(1 + random() % 255);
    const auto scene = read_outcome(bytes, {});
    if (scene) {
      ASSERT_TRUE(check(**scene, {})) << at;
    } else {
      ++refused;
    }
  }
  EXPECT_GT(refused, good.size() / 20);
}

struct Damage {
  const char* what;
  void (*make)(Scene&);
};

class Check : public ::testing::TestWithParam<Damage> {};

TEST_P(Check, FindsEachBrokenPromise) {
  Scene scene = *rich_scene();
  ASSERT_TRUE(check(scene, {}));
  GetParam().make(scene);
  EXPECT_FALSE(check(scene, {}));
}

template <auto change>
void in_geometry(Scene& scene) {
  Geometry geometry = *scene.geometry;
  change(geometry);
  scene.geometry = std::make_shared<Geometry>(std::move(geometry));
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    Scenes, Check,
    ::testing::Values(
        Damage{"NoMaterial", [](Scene& s) { s.materials.clear(); }},
        Damage{"Texture",
               [](Scene& s) {
                 s.textures.push_back({.width = 2, .height = 2, .rgba = {1, 2, 3}});
               }},
        Damage{"TexturesWhoseSidesHaveNoProduct",  // of 64 bits: four of 2^62 + 1 texels have four bytes each
               [](Scene& s) {
                 for (int i = 0; i < 4; ++i) {
                   s.textures.push_back(
                       {.width = 2147549185, .height = 2147418113, .has_alpha = true, .rgba = {1, 2, 3, 4}});
                 }
               }},
        Damage{"NoFileAndNoTexels", [](Scene& s) { s.textures[0].encoded.clear(); }},
        Damage{"AlphaWithoutTexels", [](Scene& s) { s.textures[0].has_alpha = true; }},
        Damage{"Surroundings", [](Scene& s) { s.surroundings.sky_clouds = kNan; }},
        Damage{"TextureOfAMaterial", [](Scene& s) { s.materials[0].base_color_texture = 9; }},
        Damage{"Colour", [](Scene& s) { s.materials[0].base_color.x = kNan; }},
        Damage{"MaterialOfAPrimitive", [](Scene& s) { s.meshes[0].primitives[0].material = 9; }},
        Damage{"Position", [](Scene& s) { s.meshes[0].primitives[0].positions[1].y = kNan; }},
        Damage{"Normals", [](Scene& s) { s.meshes[0].primitives[0].normals.resize(1); }},
        Damage{"Triangle", [](Scene& s) { s.meshes[0].primitives[0].triangles[0].z = 3; }},
        Damage{"MeshOfAnInstance", [](Scene& s) { s.instances[0].mesh = 9; }},
        Damage{"MovedBy", [](Scene& s) { s.instances[0].moved_by = 9; }},
        Damage{"Light", [](Scene& s) { s.lights[0].intensity = kNan; }},
        Damage{"LightMovedBy", [](Scene& s) { s.lights[0].moved_by = 9; }},
        Damage{"NoCamera", [](Scene& s) { s.cameras.clear(); }},
        Damage{"CameraOfAPath", [](Scene& s) { s.paths[0].camera = 9; }},
        Damage{"NodeOfAChannel", [](Scene& s) { s.paths[0].channels[0].node = 9; }},
        Damage{"Times", [](Scene& s) { s.moving_nodes[0].channels[0].times[1] = -1; }},
        Damage{"Values", [](Scene& s) { s.moving_nodes[0].channels[0].values.pop_back(); }},
        Damage{"Parent", [](Scene& s) { s.moving_nodes[0].parent = 0; }},
        Damage{"Count", [](Scene& s) { ++s.triangle_count; }},
        Damage{"WorldPosition", in_geometry<[](Geometry& g) { g.mesh.positions[0].x = kNan; }>},
        Damage{"WorldNormals", in_geometry<[](Geometry& g) { g.mesh.normals.pop_back(); }>},
        Damage{"WorldTriangle", in_geometry<[](Geometry& g) { g.mesh.triangles[0].y = 1000; }>},
        Damage{"WorldMaterial", in_geometry<[](Geometry& g) { g.mesh.materials[0] = 9; }>},
        Damage{"OpaqueCount", in_geometry<[](Geometry& g) { g.mesh.opaque_count = 1000; }>},
        Damage{"Numbers", in_geometry<[](Geometry& g) { g.clusters.numbers[0] = 1000; }>},
        Damage{"Cluster", in_geometry<[](Geometry& g) { g.clusters.clusters[0].first_triangle = 1; }>},
        Damage{"LongCluster", in_geometry<[](Geometry& g) { g.clusters.clusters[0].triangle_count = ~0u; }>},
        Damage{"Chunk", in_geometry<[](Geometry& g) { g.clusters.chunks[0].first_cluster = 9; }>},
        Damage{"Group", in_geometry<[](Geometry& g) { g.clusters.others[3].chunk_count = 9; }>},
        Damage{"GroupBehindTheEnd", in_geometry<[](Geometry& g) { g.clusters.occluders[0].first_triangle = ~0u; }>},
        Damage{"Bounds", [](Scene& s) { s.bounds.max.x = kNan; }}),
    [](const auto& param) { return param.param.what; });

TEST(Check, KeepsTheLimits) {
  const ScenePtr scene = rich_scene();
  EXPECT_FALSE(check(*scene, {.max_triangles = 1}));
  EXPECT_FALSE(check(*scene, {.max_instances = 1}));
  EXPECT_FALSE(check(*scene, {.max_lights = 0}));
}

}  // namespace
}  // namespace gnomon::scenes::testing
