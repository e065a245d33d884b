// Meshes: every way in which glTF can write triangles gives the same ones.
#include <gtest/gtest.h>

#include <numeric>

#include "scenes/loader.h"
#include "scenes/world_mesh.h"
#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

using Corners = std::vector<glm::vec3>;

// Corner positions of all triangles of the first primitive.
Corners corners_of(const Scene& scene) {
  Corners corners;
  if (scene.meshes.empty()) return corners;
  const Primitive& p = scene.meshes[0].primitives[0];
  for (const glm::uvec3& t : p.triangles)
    corners.insert(corners.end(), {p.positions[t.x], p.positions[t.y], p.positions[t.z]});
  return corners;
}

const Corners kStrip = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}};

Corners pick(const std::vector<int>& order) {
  Corners corners;
  for (const int i : order) corners.push_back(kStrip[static_cast<size_t>(i)]);
  return corners;
}

// `indices`: an accessor, or -1 for none.
Corners load_corners(GltfFile file, int positions, int indices, int mode = 4) {
  json primitive = {{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
  if (indices != -1) primitive["indices"] = indices;
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  return corners_of(*file.load_or_fail());
}

template <class T>
Corners with_indices(int component_type) {
  GltfFile file;
  const int positions = file.add_positions(kStrip);
  return load_corners(file, positions,
                      file.add_accessor(std::vector<T>{0, 1, 2, 4, 3, 2}, component_type, "SCALAR"));
}

TEST(Geometry, IndicesOfEveryType) {
  const Corners expected = pick({0, 1, 2, 4, 3, 2});
  EXPECT_EQ(with_indices<uint8_t>(kUnsignedByte), expected);
  EXPECT_EQ(with_indices<uint16_t>(kUnsignedShort), expected);
  EXPECT_EQ(with_indices<uint32_t>(kUnsignedInt), expected);
}

TEST(Geometry, WithoutIndicesAnIncompleteTriangleIsLeftOut) {
  GltfFile file;
  EXPECT_EQ(load_corners(file, file.add_positions(kStrip), -1), pick({0, 1, 2}));
}

TEST(Geometry, StripsTurnEverySecondTriangle) {
  GltfFile file;
  EXPECT_EQ(load_corners(file, file.add_positions(kStrip), -1, 5), pick({0, 1, 2, 1, 3, 2, 2, 3, 4}));
}

TEST(Geometry, FansTurnAroundTheirFirstVertex) {
  GltfFile file;
  EXPECT_EQ(load_corners(file, file.add_positions(kStrip), -1, 6), pick({1, 2, 0, 2, 3, 0, 3, 4, 0}));
}

TEST(Geometry, PointsAndLinesAreLeftOut) {
  for (const int mode : {0, 1, 2, 3}) {
    GltfFile file;
    EXPECT_EQ(load_corners(file, file.add_positions(kStrip), -1, mode), Corners{}) << mode;
  }
}

TEST(Geometry, InterleavedAccessorsStepOverTheirNeighbours) {
  std::vector<float> mixed;  // position, then something else
  for (const glm::vec3& p : kStrip) mixed.insert(mixed.end(), {p.x, p.y, p.z, 77.0f, 78.0f});
  GltfFile file;
  const int view = file.add_view(mixed, 20);
  const int positions = GltfFile::add(
      file.root["accessors"], {{"bufferView", view}, {"componentType", kFloat}, {"type", "VEC3"}, {"count", 5}});
  EXPECT_EQ(load_corners(file, positions, -1), pick({0, 1, 2}));
}

int add_sparse(GltfFile& file, json accessor) {
  const int at = file.add_view(std::vector<uint16_t>{1, 2});
  const int values = file.add_view(Corners{{3, 0, 0}, {0, 4, 0}});
  accessor["sparse"] = {{"count", 2},
                        {"indices", {{"bufferView", at}, {"componentType", kUnsignedShort}}},
                        {"values", {{"bufferView", values}}}};
  return GltfFile::add(file.root["accessors"], accessor);
}

TEST(Geometry, SparseAccessorsReplaceElements) {
  GltfFile file;
  const int view = file.add_view(kStrip);
  const int positions =
      add_sparse(file, {{"bufferView", view}, {"componentType", kFloat}, {"type", "VEC3"}, {"count", 5}});
  EXPECT_EQ(load_corners(file, positions, -1), (Corners{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}));
}

// A byte's index at the end of a file, read as a word, would be read behind it.
TEST(Geometry, SparseIndicesAreUnsigned) {
  for (const int type : {5120, 5122, 5126}) {  // BYTE, SHORT, FLOAT
    GltfFile file;
    const int positions = add_sparse(file, {{"componentType", kFloat}, {"type", "VEC3"}, {"count", 3}});
    file.root["accessors"][static_cast<size_t>(positions)]["sparse"]["indices"]["componentType"] = type;
    file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}}}})}});
    file.add_lamp({{"type", "point"}});
    const ScratchFolder folder;
    const auto scene = load_scene(folder.write("scene.glb", file.glb()));
    ASSERT_FALSE(scene) << type;
    EXPECT_NE(scene.error().message.find("sparse part that is not valid"), std::string::npos)
        << scene.error().message;
  }
}

TEST(Geometry, SparseAccessorsWithoutAViewStartFromZero) {
  GltfFile file;
  const int positions = add_sparse(file, {{"componentType", kFloat}, {"type", "VEC3"}, {"count", 3}});
  EXPECT_EQ(load_corners(file, positions, -1), (Corners{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}));
}

TEST(Geometry, QuantisedPositions) {
  GltfFile normalised;
  const std::vector<int16_t> shorts = {0, 0, 0, 0, 32767, 0, 0, 0, 0, -32767, -32768, 0};  // padded to 8 bytes
  const int view = normalised.add_view(shorts, 8);
  const int accessor = GltfFile::add(
      normalised.root["accessors"],
      {{"bufferView", view}, {"componentType", kShort}, {"normalized", true}, {"type", "VEC3"}, {"count", 3}});
  EXPECT_EQ(load_corners(normalised, accessor, -1), (Corners{{0, 0, 0}, {1, 0, 0}, {0, -1, -1}}));

  GltfFile plain;
  const int bytes = plain.add_view(std::vector<uint8_t>{0, 0, 0, 0, 200, 0, 0, 0, 0, 255, 1, 0}, 4);
  const int plain_accessor =
      GltfFile::add(plain.root["accessors"],
                    {{"bufferView", bytes}, {"componentType", kUnsignedByte}, {"type", "VEC3"}, {"count", 3}});
  EXPECT_EQ(load_corners(plain, plain_accessor, -1), (Corners{{0, 0, 0}, {200, 0, 0}, {0, 255, 1}}));
}

TEST(Geometry, ManyPrimitivesMaySharePartsOfOneAccessor) {
  Corners many(1000, glm::vec3(5.0f));
  many[7] = {1, 0, 0};
  many[500] = {0, 1, 0};
  many[999] = {0, 0, 1};
  GltfFile file;
  const int positions = file.add_positions(many);
  const int indices = file.add_accessor(std::vector<uint16_t>{500, 7, 999}, kUnsignedShort, "SCALAR");
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
  const ScenePtr scene = file.load_or_fail();
  EXPECT_EQ(corners_of(*scene), (Corners{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}));
  EXPECT_EQ(scene->meshes.at(0).primitives.at(0).positions.size(), 3u);
}

TEST(Geometry, SeveralPrimitivesKeepTheirMaterials) {
  GltfFile file;
  const int positions = file.add_positions(kStrip);
  file.root["materials"] = {{{"name", "first"}}, {{"name", "second"}}};
  const json attributes = {{"POSITION", positions}};
  const json primitives = {{{"attributes", attributes}, {"material", 1}}, {{"attributes", attributes}}};
  file.root["meshes"] = json::array({json::object({{"primitives", primitives}})});
  file.add_node({{"mesh", 0}});
  const ScenePtr scene = file.load_or_fail();
  ASSERT_EQ(scene->meshes.at(0).primitives.size(), 2u);
  EXPECT_EQ(scene->materials[scene->meshes[0].primitives[0].material].name, "second");
  EXPECT_EQ(scene->materials[scene->meshes[0].primitives[1].material].name, "");
  EXPECT_EQ(scene->triangle_count, 2u);
}

TEST(Geometry, NormalsAreMadeUnitAndBrokenOnesDropped) {
  for (const bool broken : {false, true}) {
    GltfFile file;
    const int positions = file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const int normals = file.add_positions({{0, 0, 2}, {0, 3, 0}, broken ? glm::vec3(0.0f) : glm::vec3(0, 0, 1)});
    file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}})}});
    const Scene scene = *file.load_or_fail();
    const Corners expected = broken ? Corners{} : Corners{{0, 0, 1}, {0, 1, 0}, {0, 0, 1}};
    EXPECT_EQ(scene.meshes.at(0).primitives.at(0).normals, expected);
  }
}

TEST(WorldMesh, FacesWithoutNormalsGetTheirOwn) {
  const WorldMesh mesh = build_world_mesh(*triangle_file().load_or_fail());
  EXPECT_EQ(mesh.normals, (Corners{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}));
  EXPECT_EQ(mesh.opaque_count, 1u);
}

// The face's normal by its winding, and the vertex normals, must both keep pointing along +Z or its image.
TEST(WorldMesh, MirroringInstancesKeepTheirNormalsOutside) {
  for (const bool with_normals : {false, true}) {
    GltfFile file;
    json attributes = {{"POSITION", file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}};
    if (with_normals) attributes["NORMAL"] = file.add_positions({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
    file.add_node({{"mesh", file.add_mesh({{"attributes", attributes}})}, {"scale", {-2, 3, 4}}});
    const WorldMesh mesh = build_world_mesh(*file.load_or_fail());
    ASSERT_EQ(mesh.triangles.size(), 1u);
    const glm::uvec3 t = mesh.triangles[0];
    const glm::vec3 face =
        glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    EXPECT_EQ(face, glm::vec3(0, 0, 6)) << with_normals;
    for (const glm::vec3& n : mesh.normals) EXPECT_EQ(n, glm::vec3(0, 0, 1)) << with_normals;
  }
}

TEST(WorldMesh, NormalsStayPerpendicularUnderUnevenScale) {
  GltfFile file;
  const glm::vec3 normal = glm::normalize(glm::vec3(1, 1, 0));
  const int positions = file.add_positions({{1, 0, 0}, {0, 1, 0}, {1, 0, -1}});
  const int normals = file.add_positions({normal, normal, normal});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}})},
                 {"scale", {4, 1, 1}}});
  const WorldMesh mesh = build_world_mesh(*file.load_or_fail());
  const glm::vec3 edge = mesh.positions.at(1) - mesh.positions.at(0);
  EXPECT_NEAR(glm::dot(mesh.normals.at(0), edge), 0.0f, 1e-6f);
  EXPECT_GT(mesh.normals.at(0).x, 0.0f);
}

TEST(WorldMesh, TrianglesWithoutAreaAreLeftOut) {
  GltfFile file;
  const int positions = file.add_positions({{0, 0, 0},
                                            {1, 0, 0},
                                            {2, 0, 0},  // a line
                                            {0, 0, 0},
                                            {0, 0, 0},
                                            {0, 1, 0},  // an edge
                                            {0, 0, 0},
                                            {1e-12f, 0, 0},
                                            {0, 1e-12f, 0},  // beyond the arithmetic
                                            {0, 0, 0},
                                            {1e-4f, 0, 0},
                                            {0, 1e-4f, 0}});  // small, but there
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}}}})}});
  const ScenePtr scene = file.load_or_fail();
  EXPECT_EQ(scene->triangle_count, 4u);
  EXPECT_EQ(build_world_mesh(*scene).triangles.size(), 1u);
  EXPECT_EQ(scene->bounds.max, glm::vec3(1e-4f, 1e-4f, 0));
}

}  // namespace
}  // namespace gnomon::scenes::testing
