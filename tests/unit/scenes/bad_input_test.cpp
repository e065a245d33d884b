// Any bytes give a scene that keeps its promises, or an error.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <random>

#include "common/log.h"
#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/invariants.h"
#include "tests/unit/scenes/support/png.h"

namespace gnomon::scenes::testing {
namespace {

// A file that contains every kind of data that the loader reads.
GltfFile rich_file() {
  GltfFile file;
  const std::vector<glm::vec3> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
  const int positions = file.add_positions(corners);
  const int normals = file.add_positions({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 1, 0}});
  const int uvs = file.add_accessor(std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}, {1, 1}}, kFloat, "VEC2");
  const int indices = file.add_accessor(std::vector<uint16_t>{0, 1, 2, 1, 3, 2}, kUnsignedShort, "SCALAR");
  const int at = file.add_view(std::vector<uint8_t>{1, 3});
  const int replaced = file.add_view(std::vector<glm::vec3>{{2, 0, 0}, {2, 2, 2}});
  file.root["accessors"][0]["sparse"] = {{"count", 2},
                                         {"indices", {{"bufferView", at}, {"componentType", kUnsignedByte}}},
                                         {"values", {{"bufferView", replaced}}}};
  const int image = file.add_view(png(2, 2, std::vector<uint8_t>(16, 120)));
  file.root["images"] = json::array({json::object({{"bufferView", image}, {"mimeType", "image/png"}})});
  file.root["samplers"] = json::array({json::object({{"wrapS", 33648}})});
  file.root["textures"] = json::array({json::object({{"source", 0}, {"sampler", 0}})});
  const json transform = {{"extensions", {{"KHR_texture_transform", {{"scale", {2, 2}}}}}}, {"index", 0}};
  file.root["materials"] = json::array(
      {json::object({{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorTexture", transform}}}})});
  file.root["cameras"] =
      json::array({json::object({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}})});
  const json attributes = {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}};
  const int mesh = file.add_mesh({{"attributes", attributes}, {"indices", indices}, {"material", 0}});
  const int strip = file.add_mesh({{"attributes", {{"POSITION", positions}}}, {"mode", 5}});
  file.root["scene"] = 0;
  file.root["scenes"] = json::array({json::object({{"nodes", {0, 1, 2}}})});
  file.add_node({{"mesh", mesh}, {"scale", {-1, 1, 2}}, {"rotation", {0, 0.6, 0, 0.8}}});
  file.add_node({{"mesh", strip}, {"camera", 0}, {"translation", {1, 2, 3}}});
  file.add_lamp({{"type", "spot"}, {"range", 9.5}, {"spot", {{"outerConeAngle", 0.5}}}});
  const int times = file.add_accessor(std::vector<float>{0, 1}, kFloat, "SCALAR");
  const int values = file.add_positions({{0, 0, 0}, {1, 1, 1}});
  const json channel = {{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}};
  const json sampler = {{"input", times}, {"output", values}};
  file.root["animations"] =
      json::array({json::object({{"samplers", json::array({sampler})}, {"channels", json::array({channel})}})});
  return file;
}

// Thousands of damaged files would log thousands of warnings about textures.
class ManyBadInputs : public ::testing::Test {
 protected:
  void SetUp() override { log::set_level(log::Level::error); }
  void TearDown() override { log::set_level(log::Level::warning); }
};

TEST(BadInput, TheIntactFileIsFine) {
  const ScratchFolder folder;
  const Result<ScenePtr> scene = load_scene(folder.write("rich.glb", rich_file().glb()));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(broken_promise(**scene), "");
  EXPECT_EQ((*scene)->triangle_count, 4u);
  EXPECT_EQ((*scene)->textures.size(), 1u);
  EXPECT_EQ((*scene)->lights.size(), 1u);
  EXPECT_EQ((*scene)->paths.size(), 1u);
}

TEST_F(ManyBadInputs, TruncatedAtEveryByteItIsRefused) {
  const ScratchFolder folder;
  const std::vector<uint8_t> whole = rich_file().glb();
  for (size_t size = 0; size < whole.size(); ++size) {
    const auto file =
        folder.write("cut.glb", std::vector<uint8_t>(whole.begin(), whole.begin() + static_cast<long>(size)));
    ASSERT_FALSE(load_scene(file)) << size;
  }
}

TEST_F(ManyBadInputs, FlippedBytesGiveAWholeSceneOrAnError) {
  const ScratchFolder folder;
  const std::vector<uint8_t> whole = rich_file().glb();
  std::mt19937 random(20240229);
  int loaded = 0;
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<uint8_t> flipped = whole;
    const size_t flips = 1 + random() % 3;
    for (size_t k = 0; k < flips; ++k)
      flipped[random() % flipped.size()] ^= static_cast<uint8_t>(1 + random() % 255);
    const Result<ScenePtr> scene = load_scene(folder.write("flipped.glb", flipped));
    const std::string broken = scene ? broken_promise(**scene) : "";
    ASSERT_EQ(broken, "") << i;
    (scene ? loaded : refused)++;
  }
  EXPECT_GT(loaded, 0);
  EXPECT_GT(refused, 0);
}

// Replaces numbers in the JSON text by others and by values of other types, which random byte flips rarely produce.
TEST_F(ManyBadInputs, ExchangedNumbersGiveAWholeSceneOrAnError) {
  const std::string text = rich_file().gltf();
  const size_t end = text.find("\"buffers\"");
  const char* values[] = {"-1",    "0",          "1",          "7",          "255",
                          "65535", "2147483647", "4294967295", "4294967296", "18446744073709551615",
                          "1e308", "-0.5",       "null",       "\"x\"",      "[]",
                          "{}"};
  const ScratchFolder folder;
  int tried = 0;
  for (size_t at = 1; at < text.size(); ++at) {
    const bool starts = std::isdigit(static_cast<unsigned char>(text[at])) &&
                        std::string(":,[").find(text[at - 1]) != std::string::npos;
    if (!starts) continue;
    if (at > end && at < text.find("\"cameras\"")) continue;  // not within the data
    const size_t length = text.find_first_not_of("0123456789.", at) - at;
    for (const char* value : values) {
      std::string changed = text;
      changed.replace(at, length, value);
      const Result<ScenePtr> scene = load_scene(folder.write("changed.gltf", changed));
      const std::string broken = scene ? broken_promise(**scene) : "";
      ASSERT_EQ(broken, "") << text.substr(at > 30 ? at - 30 : 0, 40) << " <- " << value;
      ++tried;
    }
  }
  EXPECT_GT(tried, 500);
}

TEST(BadInput, FilesOutsideTheFolderAreNotRead) {
  const ScratchFolder folder;
  const std::vector<uint8_t> content(36, 0);
  const auto outside = folder.write("outside.bin", content);
  const auto inner = folder.path() / "inner";
  std::filesystem::create_directories(inner / "sub");
  std::filesystem::create_symlink(outside, inner / "link.bin");
  std::filesystem::create_directory_symlink(folder.path(), inner / "up");
  ASSERT_EQ(mkfifo((inner / "pipe.bin").c_str(), 0600), 0);
  folder.write("inner/own.bin", content);
  folder.write("inner/sub/deep one.bin", content);

  const auto error_for = [&](const std::string& uri) {
    GltfFile file = triangle_file();
    file.root["buffers"] = json::array({json::object({{"byteLength", 36}, {"uri", uri}})});
    const Result<ScenePtr> scene = load_scene(folder.write("inner/scene.gltf", file.root.dump()));
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_EQ(error_for("own.bin"), "");
  EXPECT_EQ(error_for("./sub/../own.bin"), "");
  EXPECT_EQ(error_for("sub/deep%20one.bin"), "");
  EXPECT_NE(error_for("../outside.bin").find("outside the scene's folder"), std::string::npos);
  EXPECT_NE(error_for("%2e%2e/outside.bin").find("outside the scene's folder"), std::string::npos);
  EXPECT_NE(error_for("link.bin").find("outside the scene's folder"), std::string::npos);
  EXPECT_NE(error_for("up/outside.bin").find("outside the scene's folder"), std::string::npos);
  EXPECT_NE(error_for(outside.string()).find("not the name of a file"), std::string::npos);
  EXPECT_NE(error_for("/dev/zero").find("not the name of a file"), std::string::npos);
  EXPECT_NE(error_for("pipe.bin").find("not a regular file"), std::string::npos);
  EXPECT_NE(error_for("sub").find("not a regular file"), std::string::npos);
  EXPECT_NE(error_for("absent.bin").find("absent.bin"), std::string::npos);
  EXPECT_NE(error_for("http://example.org/a.bin").find("cannot open"), std::string::npos);
}

TEST(BadInput, FilesBeyondTheLimitAreNotRead) {
  const ScratchFolder folder;
  LoadLimits limits;
  limits.max_file_bytes = 1000;
  const Result<ScenePtr> scene = load_scene(folder.write("a.gltf", std::string(1001, ' ')), limits);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("limit"), std::string::npos);
  EXPECT_FALSE(load_scene("/dev/zero"));
  EXPECT_FALSE(load_scene(folder.path()));
  EXPECT_FALSE(load_scene(folder.path() / "none.glb"));
}

TEST(BadInput, TrianglesAndInstancesAreLimited) {
  GltfFile file = triangle_file();
  file.add_node({{"mesh", 0}});
  const ScratchFolder folder;
  const auto path = folder.write("a.gltf", file.gltf());
  LoadLimits limits;
  limits.max_triangles = 1;
  EXPECT_FALSE(load_scene(path, limits));
  limits.max_triangles = 2;
  EXPECT_TRUE(load_scene(path, limits));
  limits.max_instances = 1;
  EXPECT_FALSE(load_scene(path, limits));
}

TEST(BadInput, RequiredExtensionsAreNamed) {
  GltfFile file = triangle_file();
  file.root["extensionsRequired"] = {"KHR_lights_punctual", "KHR_draco_mesh_compression"};
  EXPECT_NE(file.load_error().find("KHR_draco_mesh_compression"), std::string::npos);
  file.root["extensionsRequired"] = {"KHR_lights_punctual", "KHR_mesh_quantization", "KHR_texture_transform"};
  EXPECT_EQ(file.load_error(), "");
}

TEST(BadInput, ErrorsNameTheirPlaceInOneLine) {
  GltfFile file = triangle_file();
  file.root["meshes"][0]["name"] = "bad\nmesh";
  file.root["meshes"][0]["primitives"][0]["indices"] =
      file.add_accessor(std::vector<uint8_t>{0, 1, 3}, kUnsignedByte, "SCALAR");
  const std::string error = file.load_error();
  EXPECT_NE(error.find("scene.gltf: "), std::string::npos);
  EXPECT_NE(error.find("bad?mesh"), std::string::npos);
  EXPECT_NE(error.find("index 3"), std::string::npos);
}

TEST(BadInput, AGlbWithoutItsBinaryChunkIsRefused) {
  GltfFile file = triangle_file();
  GltfFile structure;
  structure.root = file.root;
  structure.root["buffers"] = json::array({json::object({{"byteLength", 36}})});
  const ScratchFolder folder;
  const Result<ScenePtr> scene = load_scene(folder.write("a.glb", structure.glb()));
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("BIN"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::scenes::testing
