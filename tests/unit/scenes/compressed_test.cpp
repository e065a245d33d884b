// Valid files that leave something to an extension or to zero: they load, or the reason names what is needed.
#include <gtest/gtest.h>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

const std::vector<glm::vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

// A triangle whose indices have no bytes of their own.
GltfFile zero_indices() {
  GltfFile file;
  const int positions = file.add_positions(kCorners);
  const int indices =
      GltfFile::add(file.root["accessors"], {{"componentType", kUnsignedShort}, {"count", 3}, {"type", "SCALAR"}});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
  return file;
}

TEST(ZeroAccessors, IndicesWithoutABufferViewAreZeros) {
  const ScenePtr scene = zero_indices().load_or_fail();
  EXPECT_EQ(scene->meshes.at(0).primitives.at(0).triangles, (std::vector<glm::uvec3>{{0, 0, 0}}));
}

TEST(ZeroAccessors, ABinaryFileMayHaveNothingElse) {
  GltfFile file;
  file.root["accessors"] =
      json::array({json::object({{"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}}),
                   json::object({{"componentType", kUnsignedByte}, {"count", 3}, {"type", "SCALAR"}})});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}})}});
  const ScratchFolder folder;
  const auto scene = load_scene(folder.write("a.glb", file.glb()));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ((*scene)->triangle_count, 0u) << "where all corners are one point there is nothing to draw";
}

TEST(ZeroAccessors, SparseValuesLieOverZeros) {
  GltfFile file = zero_indices();
  const int at = file.add_view(std::vector<uint8_t>{1, 2});
  const int values = file.add_view(std::vector<uint16_t>{1, 2});
  file.root["accessors"][1]["sparse"] = {{"count", 2},
                                         {"indices", {{"bufferView", at}, {"componentType", kUnsignedByte}}},
                                         {"values", {{"bufferView", values}}}};
  const ScenePtr scene = file.load_or_fail();
  EXPECT_EQ(scene->meshes.at(0).primitives.at(0).triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
}

GltfFile with_draco(GltfFile file) {
  file.root["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  file.root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  return file;
}

TEST(Compressed, DracoThatIsOnlyUsedHasAFallback) {
  EXPECT_EQ(with_draco(triangle_file()).load_or_fail()->triangle_count, 1u);
}

TEST(Compressed, WithoutAFallbackTheExtensionIsNamed) {
  for (const GltfFile& whole : {triangle_file(), zero_indices()}) {
    GltfFile file = with_draco(whole);
    file.root["accessors"][0].erase("bufferView");
    const std::string error = file.load_error();
    EXPECT_NE(error.find("mesh 0, primitive 0 stands only in the extension KHR_draco_mesh_compression"),
              std::string::npos)
        << error;
  }
}

TEST(Compressed, MeshoptLikewise) {
  const json named = {{"EXT_meshopt_compression", {{"fallback", true}}}};
  GltfFile file = triangle_file();
  file.root["bufferViews"][0]["extensions"] = {{"EXT_meshopt_compression", {{"buffer", 0}}}};
  EXPECT_EQ(file.load_or_fail()->triangle_count, 1u);
  file.root["buffers"] = json::array({json::object({{"byteLength", 36}, {"extensions", named}})});
  const ScratchFolder folder;
  const auto refused = load_scene(folder.write("a.gltf", file.root.dump()));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("buffer view 0 stands only in the extension EXT_meshopt_compression"),
            std::string::npos)
      << refused.error().message;
}

}  // namespace
}  // namespace gnomon::scenes::testing
