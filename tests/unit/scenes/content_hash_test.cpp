// The content hash: changes with what affects masks, and with nothing else.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scenes/support/gltf_file.h"
#include "tests/unit/scenes/support/png.h"

namespace gnomon::scenes::testing {
namespace {

using Positions = std::vector<glm::vec3>;

const Positions kTwoTriangles = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};

GltfFile two_triangles(const Positions& positions = kTwoTriangles) {
  GltfFile file;
  const int accessor = file.add_positions(positions);
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", accessor}}}})}});
  return file;
}

std::string hash(const GltfFile& file) { return to_hex(file.load_or_fail()->content_hash); }

TEST(ContentHash, HasThirtyTwoHexDigits) {
  EXPECT_EQ(to_hex({0x00, 0x01, 0x9f, 0xa0}), "00019fa0000000000000000000000000");
  EXPECT_EQ(hash(two_triangles()).size(), 32u);
}

TEST(ContentHash, DoesNotDependOnHowTheFileIsArranged) {
  const std::string expected = hash(two_triangles());

  GltfFile indexed;
  const int positions = indexed.add_positions(kTwoTriangles);
  const int indices = indexed.add_accessor(std::vector<uint8_t>{0, 1, 2, 3, 4, 5}, kUnsignedByte, "SCALAR");
  indexed.add_node({{"mesh", indexed.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
  EXPECT_EQ(hash(indexed), expected);

  GltfFile instanced = triangle_file();
  instanced.add_node({{"mesh", 0}, {"translation", {0, 0, 1}}});
  EXPECT_EQ(hash(instanced), expected);

  GltfFile painted = two_triangles();
  painted.root["nodes"][0]["name"] = "shed";
  painted.root["materials"] =
      json::array({json::object({{"name", "red"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}}}})});
  painted.root["meshes"][0]["primitives"][0]["material"] = 0;
  painted.root["cameras"] =
      json::array({json::object({{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}})});
  painted.add_node({{"camera", 0}});
  EXPECT_EQ(hash(painted), expected);
}

TEST(ContentHash, ChangesWithTheSmallestMoveOfAVertex) {
  Positions moved = kTwoTriangles;
  moved[4].x = std::nextafter(moved[4].x, 2.0f);
  EXPECT_NE(hash(two_triangles(moved)), hash(two_triangles()));
}

TEST(ContentHash, ChangesWithWhatLightsReach) {
  const auto with_lamp = [](const json& light, const json& node = json::object()) {
    GltfFile file = two_triangles();
    file.add_lamp(light, node);
    return hash(file);
  };
  const std::string plain = with_lamp({{"type", "point"}});
  EXPECT_NE(plain, hash(two_triangles()));
  EXPECT_NE(plain, with_lamp({{"type", "point"}}, {{"translation", {0, 1, 0}}}));
  EXPECT_NE(plain, with_lamp({{"type", "point"}, {"range", 5}}));
  EXPECT_NE(plain, with_lamp({{"type", "directional"}}));
  EXPECT_NE(with_lamp({{"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}}),
            with_lamp({{"type", "spot"}, {"spot", {{"outerConeAngle", 0.6}}}}));

  EXPECT_EQ(plain, with_lamp({{"type", "point"}, {"intensity", 7}, {"color", {1, 0, 0}}, {"name", "x"}}));
  EXPECT_EQ(plain, with_lamp({{"type", "point"}}, {{"rotation", {0, 1, 0, 0}}}));
  EXPECT_EQ(with_lamp({{"type", "directional"}}),
            with_lamp({{"type", "directional"}}, {{"translation", {4, 4, 4}}}));
}

TEST(ContentHash, ChangesWithAlphaTestsButNotWithColours) {
  const auto masked = [](uint8_t red, uint8_t alpha, double cutoff) {
    GltfFile file = two_triangles();
    const std::string uri = "data:image/png;base64," + base64(png(1, 1, {red, 0, 0, alpha}));
    file.root["images"] = json::array({json::object({{"uri", uri}})});
    file.root["textures"] = json::array({json::object({{"source", 0}})});
    const json base = {{"baseColorTexture", {{"index", 0}}}};
    file.root["materials"] = json::array(
        {json::object({{"alphaMode", "MASK"}, {"alphaCutoff", cutoff}, {"pbrMetallicRoughness", base}})});
    file.root["meshes"][0]["primitives"][0]["material"] = 0;
    return hash(file);
  };
  EXPECT_EQ(masked(0, 200, 0.5), masked(255, 200, 0.5));
  EXPECT_NE(masked(0, 200, 0.5), masked(0, 201, 0.5));
  EXPECT_NE(masked(0, 200, 0.5), masked(0, 200, 0.6));
  EXPECT_EQ(masked(0, 255, 0.5), hash(two_triangles()));  // an alpha test that every texel passes has no effect
}

}  // namespace
}  // namespace gnomon::scenes::testing
