// What moves in a scene pack: a reader that poses it as web/PACK.md says has what the daemon draws at that time.
#include <gtest/gtest.h>

#include <cstring>

#include "scenes/geometry/geometry.h"
#include "scenes/motion.h"
#include "scenes/web_pack.h"
#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/pack_file.h"

namespace gnomon::scenes::testing {
namespace {

// A mesh with normals and one without below a node that turns; the second one mirrors and is scaled itself, and a lamp
// hangs below it. A third mesh rests. A camera flies.
GltfFile moving_file() {
  GltfFile file = triangle_file();
  const std::vector<glm::vec3> places = {{0, 0, 0}, {1, 0, 0.5f}, {0, 1, 0.25f}, {1, 1, -0.3f}};
  const int positions = file.add_positions(places);
  const int normals =
      file.add_accessor(std::vector<glm::vec3>(4, glm::normalize(glm::vec3(1, 2, 3))), kFloat, "VEC3");
  const int indices = file.add_accessor(std::vector<uint32_t>{0, 1, 2, 2, 1, 3}, kUnsignedInt, "SCALAR");
  const json smooth = {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}, {"indices", indices}};
  const json flat = {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}};
  file.root["materials"] = json::array({{{"doubleSided", true}}});
  const int turning = file.add_node({{"mesh", file.add_mesh(smooth)}, {"translation", {0, 2, 0}}});
  const int below = file.add_node({{"mesh", file.add_mesh(flat)}});
  file.root["nodes"][static_cast<size_t>(turning)]["children"] = {below};
  const int lamp = file.add_lamp({{"type", "point"}, {"name", "lamp"}}, {{"translation", {0, 1, 0}}});
  file.root["nodes"][static_cast<size_t>(below)]["children"] = {lamp};
  animate<glm::vec4>(file, turning, "rotation", "LINEAR", {0, 1, 2},
                     {{0, 0, 0, 1}, {0, 0.6f, 0, 0.8f}, {0.48f, 0.6f, 0, 0.64f}});
  animate<glm::vec3>(file, below, "scale", "LINEAR", {0, 2}, {{-1, 2, 0.5f}, {1.5f, 1, 1}});
  const int camera = GltfFile::add(file.root["cameras"],
                                   {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}});
  const int eye = file.add_node({{"camera", camera}});
  animate<glm::vec3>(file, eye, "translation", "CUBICSPLINE", {0, 1.5f},
                     {{0, 0, 0}, {0, 0, 5}, {1, 0, 0}, {0, 1, 0}, {1, 0, 5}, {0, 0, 0}});
  file.root["scenes"] = json::array({json::object({{"nodes", {0, turning, eye}}})});
  return file;
}

struct Loaded {
  ScenePtr scene;
  PackFile pack;
};

Loaded moving_scene() {
  const ScratchFolder folder;
  const auto scene = load_with_geometry(folder.write("a.glb", moving_file().glb()), {}, {}, Colours::encoded);
  EXPECT_TRUE(scene) << scene.error().message;
  return {*scene, PackFile(*web_pack(**scene))};
}

template <class T>
T vector_of(const json& numbers) {
  T out{};
  for (glm::length_t i = 0; i < T::length(); ++i)
    out[i] = numbers[static_cast<size_t>(i)].get<typename T::value_type>();
  return out;
}

glm::quat quat_of(const json& n) {
  return {n[3].get<float>(), n[0].get<float>(), n[1].get<float>(), n[2].get<float>()};
}

NodeTransform transform_of(const json& node) {
  NodeTransform out;
  out.has_matrix = node.contains("matrix");
  if (out.has_matrix) {
    for (int i = 0; i < 16; ++i) out.matrix[i / 4][i % 4] = node["matrix"][static_cast<size_t>(i)].get<float>();
    return out;
  }
  out.translation = vector_of<glm::vec3>(node["translation"]);
  out.rotation = quat_of(node["rotation"]);
  out.scale = vector_of<glm::vec3>(node["scale"]);
  return out;
}

Channel channel_of(const PackFile& pack, const json& said) {
  Channel out;
  out.node = said.value("node", 0u);
  out.path = said["path"] == "translation" ? Channel::Path::translation
             : said["path"] == "rotation"  ? Channel::Path::rotation
                                           : Channel::Path::scale;
  out.interpolation = said["interpolation"] == "step"     ? Interpolation::step
                      : said["interpolation"] == "linear" ? Interpolation::linear
                                                          : Interpolation::cubic_spline;
  out.times = pack.values<float>(said["times"]);
  out.values = pack.values<glm::vec4>(said["values"]);
  return out;
}

// A scene of nothing but what the pack says of motion; its instances have no mesh.
Scene motion_of(const PackFile& pack) {
  Scene scene;
  for (const json& said : pack.head()["moving"]["nodes"]) {
    MovingNode& node = scene.moving_nodes.emplace_back();
    node.parent = said["parent"] == -1 ? kNone : said["parent"].get<uint32_t>();
    for (int i = 0; i < 16; ++i)
      node.parent_to_world[i / 4][i % 4] = said["parent_to_world"][static_cast<size_t>(i)];
    node.local = transform_of(said);
    for (const json& c : said["channels"]) node.channels.push_back(channel_of(pack, c));
  }
  for (const json& said : pack.head()["moving"]["instances"])
    scene.instances.push_back({0, glm::mat4(1.0f), said["node"].get<uint32_t>()});
  scene.period = SceneTime(pack.head()["period_us"].get<int64_t>());
  return scene;
}

glm::vec3 unit(const glm::vec3& v) { return v / glm::length(v); }

// The moving geometry as the document says that it is posed.
WorldMesh posed(const PackFile& pack, const std::vector<Instance>& places) {
  const auto positions = pack.section<glm::vec3>("positions");
  const auto normals = pack.section<glm::vec3>("normals");
  const auto triangles = pack.section<glm::uvec3>("triangles");
  const auto materials = pack.section<uint32_t>("triangle_materials");
  const auto resting = pack.head()["resting"]["vertices"].get<uint32_t>();
  WorldMesh mesh;
  size_t place = 0;
  for (const json& instance : pack.head()["moving"]["instances"]) {
    const glm::mat4& m = places[place++].object_to_world;
    const glm::vec3 m0(m[0]), m1(m[1]), m2(m[2]), m3(m[3]);
    const bool mirrored = glm::determinant(glm::mat3(m)) < 0;
    const uint32_t first = instance["first_vertex"], end = first + instance["vertices"].get<uint32_t>();
    EXPECT_EQ(first, resting + mesh.positions.size());
    for (uint32_t v = first; v < end; ++v) {
      const glm::vec3 p = positions[v], n = normals[v];
      mesh.positions.push_back((m0 * p.x + m1 * p.y) + (m2 * p.z + m3));
      const glm::mat3 c(glm::cross(m1, m2), glm::cross(m2, m0), glm::cross(m0, m1));
      mesh.normals.push_back(unit((mirrored ? -c : c) * n));
    }
    const uint32_t from = instance["first_triangle"], to = from + instance["triangles"].get<uint32_t>();
    for (uint32_t t = from; t < to; ++t) {
      glm::uvec3 corners = triangles[t] - resting;
      if (mirrored) std::swap(corners.y, corners.z);
      mesh.triangles.push_back(corners);
      mesh.materials.push_back(materials[t]);
      if (!instance["flat"].get<bool>()) continue;
      const auto at = [&](uint32_t corner) { return mesh.positions[corner]; };
      const glm::vec3 normal = unit(glm::cross(at(corners.y) - at(corners.x), at(corners.z) - at(corners.x)));
      for (int i = 0; i < 3; ++i) mesh.normals[corners[i]] = normal;
    }
  }
  return mesh;
}

// Vertices of flat triangles that are mirrored stand in another order: what is compared is what a triangle shows.
struct Corner {
  glm::vec3 position, normal;
};

std::vector<Corner> corners_of(const WorldMesh& mesh) {
  std::vector<Corner> out;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) out.push_back({mesh.positions[t[i]], mesh.normals[t[i]]});
  }
  return out;
}

TEST(WebPackMotion, PosedAsTheDocumentSaysIsWhatTheDaemonDraws) {
  const auto [scene, pack] = moving_scene();
  ASSERT_EQ(pack.broken(), "");
  const Scene motion = motion_of(pack);
  ASSERT_EQ(motion.period, scene->period);
  for (const int64_t us : {0, 333'333, 999'999, 1'000'001, 1'900'000}) {
    const WorldMesh expected = build_moving_mesh(*scene, SceneTime(us));
    const WorldMesh got = posed(pack, moved_instances(motion, SceneTime(us)));
    ASSERT_EQ(got.materials, expected.materials);
    const auto a = corners_of(got), b = corners_of(expected);
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].position, b[i].position) << us << ", " << i;
      EXPECT_LT(glm::distance(a[i].normal, b[i].normal), 1e-6f) << us << ", " << i;
    }
  }
}

TEST(WebPackMotion, RestingTrianglesComeFirstAndMovingGroupsLast) {
  const auto [scene, pack] = moving_scene();
  const Geometry resident = make_geometry(*scene);
  const auto positions = pack.section<glm::vec3>("positions");
  const auto triangles = pack.section<glm::uvec3>("triangles");
  ASSERT_EQ(pack.head()["resting"]["triangles"], resident.mesh.triangles.size());
  ASSERT_EQ(pack.head()["resting"]["vertices"], resident.mesh.positions.size());
  EXPECT_TRUE(std::equal(resident.mesh.positions.begin(), resident.mesh.positions.end(), positions.begin()));
  EXPECT_TRUE(std::equal(resident.mesh.triangles.begin(), resident.mesh.triangles.end(), triangles.begin()));
  EXPECT_EQ(triangles.size(), resident.mesh.triangles.size() + 4);
  const json& groups = pack.head()["groups"];
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[1]["first_triangle"], resident.mesh.triangles.size());
  EXPECT_EQ(groups[1]["double_sided"], false);
  EXPECT_EQ(groups[2]["first_triangle"], resident.mesh.triangles.size() + 2);
  EXPECT_EQ(groups[2]["double_sided"], true);
  EXPECT_EQ(groups[2]["triangles"], 2);
}

TEST(WebPackMotion, LightsNameTheirNodes) {
  const auto [scene, pack] = moving_scene();
  const json& lights = pack.head()["moving"]["lights"];
  ASSERT_EQ(lights.size(), 1u);
  EXPECT_EQ(lights[0]["light"], 0);
  EXPECT_EQ(lights[0]["node"], scene->lights[0].moved_by);
  EXPECT_EQ(pack.head()["lights"], json::array({"lamp"}));
}

TEST(WebPackMotion, CameraPathsGiveTheSamePoses) {
  const auto [scene, pack] = moving_scene();
  const json& said = pack.head()["camera_paths"];
  ASSERT_EQ(said.size(), 1u);
  CameraPath path;
  path.camera = said[0]["camera"];
  path.duration_seconds = said[0]["duration_s"];
  for (const json& node : said[0]["chain"]) path.chain.push_back(transform_of(node));
  for (const json& channel : said[0]["channels"]) path.channels.push_back(channel_of(pack, channel));
  for (const float seconds : {0.0f, 0.3f, 1.0f, 1.5f}) {
    const CameraPose expected = pose_at(scene->paths[0], 0.8f, seconds), got = pose_at(path, 0.8f, seconds);
    EXPECT_EQ(got.position, expected.position);
    EXPECT_EQ(got.orientation, expected.orientation);
  }
}

}  // namespace
}  // namespace gnomon::scenes::testing
