// A cached light buffer is the one that was saved, or none.
#include "gpu/tracers/light_buffer/cache.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <vector>

#include "tests/unit/gpu/light_buffer/soups.h"

namespace gnomon::test {
namespace {

namespace light_buffer = gpu::light_buffer;

class Cache : public testing::Test {
 protected:
  Cache() {
    Random random(3);
    soup_ = make_soup(Shape::even, Lamp::point, 60, random);
    settings_.threads = 1;
    settings_.detail.finest_level = 6;
    buffer_ = light_buffer::build(soup_.mesh, soup_.bounds, std::span(&soup_.light, 1), settings_);
    key_ = key_of(1, soup_, settings_);
    folder_ = std::filesystem::path(testing::TempDir()) / "gnomon_light_buffer_cache";
    std::filesystem::remove_all(folder_);
  }
  ~Cache() override { std::filesystem::remove_all(folder_); }

  static light_buffer::CacheKey key_of(uint8_t content, const Soup& soup,
                                       const light_buffer::BuildSettings& settings) {
    return light_buffer::cache_key({content}, settings, soup.mesh, soup.bounds, std::span(&soup.light, 1));
  }

  std::vector<char> file() const {
    std::ifstream in(light_buffer::cache_file(folder_, key_), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::vector<char>& bytes) const {
    std::ofstream out(light_buffer::cache_file(folder_, key_), std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  bool loads(std::string& why) const { return light_buffer::load(folder_, key_, why).has_value(); }

  Soup soup_;
  light_buffer::BuildSettings settings_;
  light_buffer::LightBuffer buffer_;
  light_buffer::CacheKey key_;
  std::filesystem::path folder_;
};

TEST_F(Cache, GivesBackWhatWasSaved) {
  std::string why;
  EXPECT_FALSE(loads(why));
  EXPECT_EQ(why, "");
  ASSERT_TRUE(light_buffer::save(folder_, key_, buffer_));
  const auto loaded = light_buffer::load(folder_, key_, why);
  ASSERT_TRUE(loaded) << why;
  ASSERT_EQ(loaded->leaves.size(), buffer_.leaves.size());
  EXPECT_EQ(
      std::memcmp(loaded->leaves.data(), buffer_.leaves.data(), buffer_.leaves.size() * sizeof(buffer_.leaves[0])),
      0);
  EXPECT_EQ(loaded->entries, buffer_.entries);
  EXPECT_EQ(loaded->statistics.longest_list, buffer_.statistics.longest_list);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()), 1);
}

// Of three files, the one that was used least recently leaves, though it was not written first.
TEST_F(Cache, WhatWasUsedLeastRecentlyLeavesFirst) {
  using namespace std::chrono_literals;
  const std::vector<light_buffer::CacheKey> keys{key_, key_of(2, soup_, settings_), key_of(3, soup_, settings_)};
  const auto now = std::filesystem::file_time_type::clock::now();
  for (size_t i = 0; i < keys.size(); ++i) {
    ASSERT_TRUE(light_buffer::save(folder_, keys[i], buffer_));
    std::filesystem::last_write_time(light_buffer::cache_file(folder_, keys[i]), now - 3h + i * 1h);
  }
  std::ofstream(folder_ / "something_else") << "not ours";
  const uint64_t each = file().size();
  std::string why;
  ASSERT_TRUE(light_buffer::load(folder_, keys[0], why)) << why;

  EXPECT_EQ(light_buffer::trim(folder_, 3 * each).files, 0u) << "there is room for all of them";
  const light_buffer::Trimmed trimmed = light_buffer::trim(folder_, 3 * each - 1);
  EXPECT_EQ(trimmed.files, 1u);
  EXPECT_EQ(trimmed.bytes, each);
  const auto kept = [&](size_t i) { return std::filesystem::exists(light_buffer::cache_file(folder_, keys[i])); };
  EXPECT_TRUE(kept(0)) << "it was read just now";
  EXPECT_FALSE(kept(1));
  EXPECT_TRUE(kept(2));

  ASSERT_TRUE(light_buffer::save(folder_, keys[1], buffer_, 2 * each));
  EXPECT_TRUE(kept(0));
  EXPECT_TRUE(kept(1)) << "what was just built";
  EXPECT_FALSE(kept(2)) << "room was made";
  EXPECT_TRUE(std::filesystem::exists(folder_ / "something_else"));
}

TEST_F(Cache, WhatIsLargerThanTheCacheIsNotWritten) {
  ASSERT_TRUE(light_buffer::save(folder_, key_, buffer_));
  const uint64_t each = file().size();
  const auto larger = light_buffer::save(folder_, key_of(2, soup_, settings_), buffer_, each - 1);
  ASSERT_FALSE(larger);
  EXPECT_NE(larger.error().message.find("more than the cache may hold"), std::string::npos)
      << larger.error().message;
  std::string why;
  EXPECT_TRUE(loads(why)) << "nothing had to leave for it";
}

TEST_F(Cache, AnyChangedByteIsFound) {
  ASSERT_TRUE(light_buffer::save(folder_, key_, buffer_));
  const std::vector<char> good = file();
  for (size_t at = 0; at < good.size(); at += at < 256 ? 1 : good.size() / 97) {
    std::vector<char> bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    write(bad);
    std::string why;
    EXPECT_FALSE(loads(why)) << "byte " << at;
    EXPECT_NE(why, "");
  }
}

TEST_F(Cache, ShortenedAndLengthenedFilesAreFound) {
  ASSERT_TRUE(light_buffer::save(folder_, key_, buffer_));
  const std::vector<char> good = file();
  for (const size_t length : {size_t{0}, size_t{1}, size_t{95}, size_t{96}, good.size() - 1, good.size() + 1}) {
    std::vector<char> bad = good;
    bad.resize(length);
    write(bad);
    std::string why;
    EXPECT_FALSE(loads(why)) << length;
    EXPECT_NE(why, "");
  }
}

TEST_F(Cache, OtherScenesAndSettingsHaveOtherFiles) {
  ASSERT_TRUE(light_buffer::save(folder_, key_, buffer_));
  light_buffer::BuildSettings finer = settings_;
  finer.detail.cost_per_byte /= 2;
  const light_buffer::CacheKey other_scene = key_of(2, soup_, settings_);
  const light_buffer::CacheKey other_settings = key_of(1, soup_, finer);
  std::string why;
  EXPECT_FALSE(light_buffer::load(folder_, other_scene, why));
  EXPECT_FALSE(light_buffer::load(folder_, other_settings, why));
  // A file that was copied to another key's name is refused.
  std::filesystem::copy_file(light_buffer::cache_file(folder_, key_),
                             light_buffer::cache_file(folder_, other_scene));
  EXPECT_FALSE(light_buffer::load(folder_, other_scene, why));
  EXPECT_EQ(why, "belongs to another scene");
}

// Whoever reads a scene says its content hash. One that lies must not give another scene its light buffers.
TEST_F(Cache, WhatIsBuiltFromOtherInputHasAnotherFileWhateverItsHash) {
  Soup moved = soup_, regrouped = soup_, larger = soup_, relit = soup_;
  moved.mesh.positions[5].x += 0.5f;
  std::swap(regrouped.mesh.triangles[0], regrouped.mesh.triangles[1]);
  larger.bounds.max.y += 1;
  relit.light.position.z += 1;
  for (const Soup* other : {&moved, &regrouped, &larger, &relit}) {
    EXPECT_NE(key_of(1, *other, settings_).build, key_.build);
  }
  EXPECT_EQ(key_of(1, soup_, settings_).build, key_.build);
}

TEST_F(Cache, AFileWhereTheFolderShouldBeIsAnError) {
  std::ofstream(folder_) << "in the way";
  const auto saved = light_buffer::save(folder_, key_, buffer_);
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().message.find(folder_.string()), std::string::npos);
}

TEST(Budget, IsKept) {
  Random random(5);
  const Soup soup = make_soup(Shape::even, Lamp::point, 2000, random);
  light_buffer::BuildSettings settings;
  settings.threads = 1;
  settings.detail.finest_level = 10;
  const auto fine = light_buffer::build(soup.mesh, soup.bounds, std::span(&soup.light, 1), settings);
  // The cells of six faces are always there.
  const uint64_t cells = 6 * light_buffer::kCellCount * sizeof(uint32_t);
  settings.budget_bytes = cells + (fine.memory_bytes() - cells) * 2 / 3;
  const auto coarse = light_buffer::build(soup.mesh, soup.bounds, std::span(&soup.light, 1), settings);
  EXPECT_LE(coarse.memory_bytes(), settings.budget_bytes);
}

}  // namespace
}  // namespace gnomon::test
