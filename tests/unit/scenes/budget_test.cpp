// What may be made of a file is bounded by its own size; what is cheap to say and dear to make is refused with a reason.
#include <gtest/gtest.h>

#include "common/log.h"
#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/jpeg.h"
#include "tests/unit/scenes/support/png.h"

namespace gnomon::scenes::testing {
namespace {

constexpr uint64_t kBase = LoadLimits{}.base_memory_bytes;

bool says(const std::string& error, const std::string& what) { return error.find(what) != std::string::npos; }

// A triangle with an image as its base colour. An opaque surface could do without.
GltfFile pictured(const std::vector<uint8_t>& image, const char* alpha_mode = "OPAQUE") {
  GltfFile file = triangle_file();
  const int uvs = file.add_accessor(std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}, kFloat, "VEC2");
  const int view = file.add_view(image);
  file.root["images"] = json::array({json::object({{"bufferView", view}})});
  file.root["textures"] = json::array({json::object({{"source", 0}})});
  file.root["materials"] = json::array({json::object(
      {{"alphaMode", alpha_mode}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}})});
  json& primitive = file.root["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["attributes"]["TEXCOORD_0"] = uvs;
  return file;
}

TEST(Budget, AKilobyteDoesNotBuyAGigabyteOfTexels) {
  for (const char* mode : {"OPAQUE", "MASK"}) {
    const GltfFile file = pictured(jpeg(16384, 16384, 1), mode);
    ASSERT_LT(file.gltf().size(), 3000u);
    const std::string error = file.load_error();
    EXPECT_TRUE(says(error, "image 0 of 16384 x 16384 would take ")) << error;
    EXPECT_TRUE(says(error, "unpacks to too much")) << error;
  }
}

TEST(Budget, SmallImagesDoNotAddUpToAGigabyte) {
  GltfFile file = pictured(jpeg(1024, 1024, 1));
  for (int i = 1; i < 256; ++i) {
    GltfFile::add(file.root["textures"], {{"source", 0}});
    json material = file.root["materials"][0];
    material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = i;
    GltfFile::add(file.root["materials"], material);
  }
  EXPECT_TRUE(says(file.load_error(), "image 0 of 1024 x 1024 would take")) << file.load_error();
}

// The sharpest real textures are of one colour: 800 texels and more for each byte.
TEST(Budget, TexturesOfOneColourAreRead) {
  const std::vector<uint8_t> flat = png(2048, 2048, std::vector<uint8_t>(size_t{4} << 22, 200));
  const ScenePtr scene = pictured(flat).load_or_fail();
  EXPECT_EQ(scene->textures.at(0).rgba.size(), size_t{4} << 22);
}

TEST(Budget, EachByteOfAFileAddsToWhatItMayTake) {
  const ScratchFolder folder;
  LoadLimits limits;
  limits.base_memory_bytes = 0;
  const GltfFile file = triangle_file();
  const uint64_t bytes = file.gltf().size();
  limits.memory_bytes_per_byte = 0;
  EXPECT_FALSE(load_scene(folder.write("a.gltf", file.gltf()), limits));
  limits.memory_bytes_per_byte = 256;
  const auto loaded = load_scene(folder.write("a.gltf", file.gltf()), limits);
  EXPECT_TRUE(loaded) << bytes << ": " << loaded.error().message;
}

TEST(Budget, ScansOfAJpegAreLimited) {
  const uint32_t most = LoadLimits{}.max_scans;
  EXPECT_EQ(pictured(jpeg(64, 64, most)).load_error(), "");
  EXPECT_EQ(pictured(jpeg(64, 64, most)).load_or_fail()->textures.size(), 1u);
  const std::string error = pictured(jpeg(64, 64, most + 1)).load_error();
  EXPECT_TRUE(says(error, std::to_string(most + 1) + " scans")) << error;
}

TEST(Budget, SparseZerosAreCountedEachTime) {
  GltfFile file;
  const int at = file.add_view(std::vector<uint32_t>{1});
  const int values = file.add_view(std::vector<glm::vec3>{{1, 2, 3}});
  const json sparse = {{"count", 1},
                       {"indices", {{"bufferView", at}, {"componentType", kUnsignedInt}}},
                       {"values", {{"bufferView", values}}}};
  GltfFile::add(file.root["accessors"],
                {{"componentType", kFloat}, {"count", 1 << 20}, {"type", "VEC3"}, {"sparse", sparse}});
  json primitives = json::array();
  for (int i = 0; i < 95; ++i) primitives.push_back({{"attributes", {{"POSITION", 0}}}});
  file.root["meshes"] = json::array({json::object({{"primitives", primitives}})});
  file.add_node({{"mesh", 0}});
  const std::string error = file.load_error();
  EXPECT_TRUE(says(error, "mesh 0")) << error;
  EXPECT_TRUE(says(error, "names one thing too often")) << error;
}

TEST(Budget, OneFileIsNotReadAgainAndAgain) {
  const ScratchFolder folder;
  folder.write("one.bin", std::vector<uint8_t>(size_t{1} << 20, 0));
  std::filesystem::create_hard_link(folder.path() / "one.bin", folder.path() / "two.bin");
  const auto with_buffers = [&](int count) {
    GltfFile file = triangle_file();
    file.root["buffers"] = json::array();
    for (int i = 0; i < count; ++i) {
      file.root["buffers"].push_back({{"byteLength", 1 << 20}, {"uri", i % 2 ? "one.bin" : "././two.bin"}});
    }
    return load_scene(folder.write("a.gltf", file.root.dump()));
  };
  const auto refused = with_buffers(2000);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(says(refused.error().message, "named again and again")) << refused.error().message;
  const auto loaded = with_buffers(3);
  EXPECT_TRUE(loaded) << loaded.error().message;
}

TEST(Budget, EmptyEntriesAreCounted) {
  GltfFile file = triangle_file();
  file.root["materials"] = json(std::vector<json>(100'000, json::object()));
  EXPECT_TRUE(says(file.load_error(), "its structure would take")) << file.load_error();
}

TEST(Budget, ZerosCountByWhatTheyWouldHold) {
  const auto error_with = [](uint64_t count) {
    GltfFile file = triangle_file();
    const int zeros = GltfFile::add(file.root["accessors"],
                                    {{"componentType", kUnsignedInt}, {"count", count}, {"type", "SCALAR"}});
    file.root["meshes"][0]["primitives"][0]["indices"] = zeros;
    return file.load_error();
  };
  EXPECT_EQ(error_with(3000), "");
  for (const uint64_t count : {kBase, uint64_t{1} << 40, uint64_t{1} << 63}) {
    EXPECT_TRUE(says(error_with(count), "has no bytes of its own")) << count << ": " << error_with(count);
  }
}

TEST(Budget, AnimationsThatShareTheirKeysAreCounted) {
  constexpr int kKeys = 100'000;
  GltfFile file;
  std::vector<float> times(kKeys);
  for (size_t i = 0; i < times.size(); ++i) times[i] = static_cast<float>(i);
  const int mesh =
      file.add_mesh({{"attributes", {{"POSITION", file.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}}}});
  const json sampler = {{"input", file.add_accessor(times, kFloat, "SCALAR")},
                        {"output", GltfFile::add(file.root["accessors"],
                                                 {{"componentType", kFloat}, {"count", kKeys}, {"type", "VEC3"}})}};
  json channels = json::array();
  for (int i = 0; i < 2000; ++i) {
    const int node = file.add_node({{"mesh", mesh}});
    channels.push_back({{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}});
  }
  file.root["animations"] =
      json::array({json::object({{"samplers", json::array({sampler})}, {"channels", channels}})});
  EXPECT_TRUE(says(file.load_error(), "would take")) << file.load_error();
}

}  // namespace
}  // namespace gnomon::scenes::testing
