// The files: well-formed binary glTF, the same bytes every time, small thanks to instancing.
#include "scenes/assets/glb_writer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "scenes/assets/built_in.h"

namespace gnomon::scenes::assets {
namespace {

constexpr size_t kMostBytes = 25'000'000;

uint32_t word_at(const std::vector<uint8_t>& bytes, size_t offset) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

class GlbFile : public testing::TestWithParam<Stage (*)()> {};

TEST_P(GlbFile, is_the_same_every_time_and_well_formed) {
  const Stage stage = GetParam()();
  const std::vector<uint8_t> bytes = to_glb(stage);
  ASSERT_LT(bytes.size(), kMostBytes);
  EXPECT_TRUE(bytes == to_glb(GetParam()())) << "two builds differ";

  ASSERT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "glTF");
  EXPECT_EQ(word_at(bytes, 4), 2u);
  ASSERT_EQ(word_at(bytes, 8), bytes.size());
  const size_t json_bytes = word_at(bytes, 12), binary_header = 20 + json_bytes;
  EXPECT_EQ(json_bytes % 4, 0u);
  const size_t binary_bytes = word_at(bytes, binary_header);
  ASSERT_EQ(binary_header + 8 + binary_bytes, bytes.size());

  const auto document =
      nlohmann::json::parse(bytes.begin() + 20, bytes.begin() + 20 + static_cast<long>(json_bytes));
  EXPECT_EQ(document["buffers"][0]["byteLength"], binary_bytes);
  EXPECT_EQ(document["extensions"]["KHR_lights_punctual"]["lights"].size(), stage.lights.size());
  EXPECT_EQ(document["meshes"].size(), stage.models.size());
  EXPECT_EQ(document["animations"][0]["channels"].size(), 2u);

  const std::map<int, size_t> component_bytes{{5123, 2}, {5125, 4}, {5126, 4}};
  const std::map<std::string, size_t> components{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  for (const auto& accessor : document["accessors"]) {
    const auto& view = document["bufferViews"].at(accessor["bufferView"].get<size_t>());
    const size_t size = component_bytes.at(accessor["componentType"]) * components.at(accessor["type"]);
    EXPECT_EQ(view["byteLength"], accessor["count"].get<size_t>() * size);
    EXPECT_LE(view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>(), binary_bytes);
    EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Assets, GlbFile, testing::Values(make_living_room, make_temple));

}  // namespace
}  // namespace gnomon::scenes::assets
