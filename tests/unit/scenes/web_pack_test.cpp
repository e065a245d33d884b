// Scene packs, read back by a reader that was written from their document: they hold what the daemon has, bit for bit.
#include "scenes/web_pack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "scenes/geometry/geometry.h"
#include "scenes/motion.h"
#include "scenes/packed/packed_scene.h"
#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/pack_file.h"
#include "tests/unit/scenes/support/png.h"
#include "tests/unit/scenes/support/written_bytes.h"

namespace gnomon::scenes::testing {
namespace {

namespace fs = std::filesystem;

ScenePtr loaded_for_browsers(const fs::path& file) {
  auto scene = load_with_geometry(file, {}, {}, Colours::encoded);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? *scene : nullptr;
}

ScenePtr loaded_for_browsers(const GltfFile& file) {
  const ScratchFolder folder;
  return loaded_for_browsers(folder.write("scene.glb", file.glb()));
}

PackFile pack_of(const Scene& scene) {
  auto bytes = web_pack(scene);
  EXPECT_TRUE(bytes) << bytes.error().message;
  PackFile pack(bytes ? std::move(*bytes) : std::vector<std::byte>());
  EXPECT_EQ(pack.broken(), "");
  return pack;
}

// Bit for bit: 0 and -0 differ.
template <class T>
void expect_same_bits(const std::vector<T>& a, const std::vector<T>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0) << what;
}

void expect_mesh(const PackFile& pack, const WorldMesh& mesh) {
  expect_same_bits(pack.section<glm::vec3>("positions"), mesh.positions, "positions");
  expect_same_bits(pack.section<glm::vec3>("normals"), mesh.normals, "normals");
  expect_same_bits(pack.section<glm::vec2>("uvs"), mesh.uvs, "uvs");
  expect_same_bits(pack.section<glm::uvec3>("triangles"), mesh.triangles, "triangles");
  expect_same_bits(pack.section<uint32_t>("triangle_materials"), mesh.materials, "materials");
}

// The groups cover all triangles in their order, and each triangle is of its group's kind.
void expect_groups(const PackFile& pack, const WorldMesh& mesh, const Scene& scene) {
  size_t next = 0;
  for (const json& group : pack.head()["groups"]) {
    ASSERT_EQ(group["first_triangle"], next);
    const size_t end = next + group["triangles"].get<size_t>();
    ASSERT_GT(end, next);
    ASSERT_LE(end, mesh.triangles.size());
    for (; next < end; ++next) {
      ASSERT_EQ(group["masked"], next >= mesh.opaque_count) << next;
      ASSERT_EQ(group["double_sided"], scene.materials[mesh.materials[next]].double_sided) << next;
    }
  }
  EXPECT_EQ(next, mesh.triangles.size());
}

class WebPackOfFile : public ::testing::TestWithParam<const char*> {};

TEST_P(WebPackOfFile, HasTheTrianglesThatTheDaemonTraces) {
  const fs::path beside = fs::path(GNOMON_SOURCE_DIR) / ".." / "shared" / "scenes";
  const fs::path built_in = fs::path(GNOMON_SCENES_DIR) / GetParam();
  const fs::path file = fs::exists(built_in) ? built_in : beside / GetParam();
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const ScenePtr scene = loaded_for_browsers(file);
  ASSERT_TRUE(scene);
  ASSERT_TRUE(scene->moving_nodes.empty());
  const PackFile pack = pack_of(*scene);

  const auto drawn = load_scene(file);  // as the native client has it: every texture decoded
  ASSERT_TRUE(drawn) << drawn.error().message;
  const Geometry resident = make_geometry(**drawn);
  expect_mesh(pack, resident.mesh);
  expect_groups(pack, resident.mesh, **drawn);
  EXPECT_EQ(pack.head()["content_hash"], to_hex((*drawn)->content_hash));
  EXPECT_EQ(pack.head()["triangles"], resident.mesh.triangles.size());
  EXPECT_EQ(pack.head()["vertices"], resident.mesh.positions.size());
  EXPECT_EQ(pack.head()["resting"]["triangles"], resident.mesh.triangles.size());

  ASSERT_EQ(pack.head()["textures"].size(), (*drawn)->textures.size());
  for (size_t i = 0; i < (*drawn)->textures.size(); ++i) {
    EXPECT_EQ(pack.head()["textures"][i]["width"], (*drawn)->textures[i].width);
    EXPECT_EQ(pack.values<uint8_t>(pack.head()["textures"][i]), scene->textures[i].encoded);
  }
  ASSERT_EQ(pack.head()["materials"].size(), (*drawn)->materials.size());
  for (size_t i = 0; i < (*drawn)->materials.size(); ++i) {
    const uint32_t texture = (*drawn)->materials[i].base_color_texture;
    EXPECT_EQ(pack.head()["materials"][i]["texture"], texture == kNone ? -1 : static_cast<int>(texture));
  }
}

INSTANTIATE_TEST_SUITE_P(Files, WebPackOfFile,
                         ::testing::Values("living_room.glb", "temple.glb", "sponza_crytek.glb",
                                           "country_kitchen.glb", "grey_white_room.glb", "oa_minia.glb",
                                           "godot_living_room.glb"),
                         [](const auto& param) {
                           return std::string(param.param).substr(0, std::string(param.param).find('.'));
                         });

const std::vector<uint8_t> kTexels = {10, 20, 30, 0, 10, 20, 30, 255, 10, 20, 30, 100, 10, 20, 30, 200};

// Two triangles of one image: one tests its alpha, the other does not; their textures differ in the way they repeat.
GltfFile textured_file() {
  GltfFile file;
  const int positions = file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const int uvs = file.add_accessor(std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}, kFloat, "VEC2");
  const json attributes = {{"POSITION", positions}, {"TEXCOORD_0", uvs}};
  for (const int material : {0, 1})
    file.add_node({{"mesh", file.add_mesh({{"attributes", attributes}, {"material", material}})}});
  const int view = file.add_view(png(2, 2, kTexels));
  file.root["images"] = json::array({json::object({{"bufferView", view}, {"mimeType", "image/png"}})});
  file.root["samplers"] = json::array({{{"wrapS", 33071}, {"wrapT", 33648}}});
  file.root["textures"] =
      json::array({json::object({{"source", 0}}), json::object({{"source", 0}, {"sampler", 0}})});
  const auto material = [](int texture, const char* mode) {
    return json{{"alphaMode", mode}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}};
  };
  file.root["materials"] = json::array({material(0, "OPAQUE"), material(1, "MASK")});
  return file;
}

TEST(WebPack, HasTheFilesOfTheTextures) {
  const PackFile pack = pack_of(*loaded_for_browsers(textured_file()));
  const json& textures = pack.head()["textures"];
  ASSERT_EQ(textures.size(), 2u);
  for (const json& texture : textures) {
    EXPECT_EQ(pack.values<uint8_t>(texture), png(2, 2, kTexels));
    EXPECT_EQ(texture["type"], "image/png");
    EXPECT_EQ(texture["width"], 2);
    EXPECT_EQ(texture["height"], 2);
    EXPECT_EQ(texture["offset"], textures[0]["offset"]) << "equal files are there once";
  }
  EXPECT_EQ(textures[0]["wrap_u"], "repeat");
  EXPECT_EQ(textures[1]["wrap_u"], "clamp_to_edge");
  EXPECT_EQ(textures[1]["wrap_v"], "mirrored_repeat");
  EXPECT_EQ(textures[1]["has_alpha"], true);
  EXPECT_EQ(pack.head()["materials"][1]["texture"], 1);
  EXPECT_EQ(pack.head()["materials"][1]["alpha_mode"], "mask");
  EXPECT_EQ(pack.head()["materials"][2]["texture"], -1) << "the material of meshes that name none";
}

// A server decodes only what it tests, also where one texture serves both.
TEST(WebPack, TexturesThatNobodyTestsAreNotDecoded) {
  GltfFile file = textured_file();
  const ScenePtr scene = loaded_for_browsers(file);
  EXPECT_TRUE(scene->textures[0].rgba.empty());
  EXPECT_EQ(scene->textures[1].rgba, kTexels);
  file.root["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  const ScenePtr shared = loaded_for_browsers(file);
  ASSERT_EQ(shared->textures.size(), 1u);
  EXPECT_EQ(shared->textures[0].rgba, kTexels);
  EXPECT_EQ(shared->textures[0].encoded, png(2, 2, kTexels));
}

TEST(WebPack, ComesFromASceneOfAnotherProcessToo) {
  GltfFile file = textured_file();
  file.root["scenes"] = json::array(
      {{{"nodes", {0, 1}}, {"extras", {{"gnomon", {{"ambient", {{"above", {1, 2, 3}}, {"below", {3, 2, 1}}}}}}}}}});
  file.root["scene"] = 0;
  const ScenePtr scene = loaded_for_browsers(file);
  ASSERT_EQ(scene->surroundings.ambient_above, glm::vec3(1, 2, 3));
  const auto bytes = written_bytes([&](std::FILE* into) { return write_outcome(scene, into); });
  const auto back = read_outcome(bytes, {});
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(*web_pack(**back), *web_pack(*scene));
}

TEST(WebPack, IsRefusedWhereTheFilesWereNotKept) {
  const auto pack = web_pack(*textured_file().load_or_fail());
  ASSERT_FALSE(pack);
  EXPECT_NE(pack.error().message.find("without its pictures"), std::string::npos);
}

// A number that JSON.parse makes of the text is the scene's, to the last bit.
TEST(WebPack, NumbersAreExact) {
  GltfFile file = triangle_file();
  const int camera = GltfFile::add(file.root["cameras"],
                                   {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}});
  file.add_node({{"camera", camera}, {"name", "\"eye\""}, {"translation", {0.1, 1e-7, 1234567.9}}});
  file.root["scenes"] = json::array({json::object({{"nodes", {0, 1}}})});
  const ScenePtr scene = loaded_for_browsers(file);
  const PackFile pack = pack_of(*scene);
  const json& eye = pack.head()["cameras"][0];
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(eye["position"][static_cast<size_t>(i)].get<double>(),
              static_cast<double>(scene->cameras[0].rest.position[i]));
  EXPECT_EQ(eye["vertical_fov"].get<double>(), static_cast<double>(0.8f));
  EXPECT_EQ(eye["orientation"], json::array({0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(pack.head()["bounds"]["max"], json::array({1.0, 1.0, 0.0}));
}

}  // namespace
}  // namespace gnomon::scenes::testing
