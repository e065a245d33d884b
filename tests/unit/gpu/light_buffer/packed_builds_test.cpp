// Structures built by another process: what comes out is what went in, and bytes that are wrong give an error instead of
// a traversal that reads elsewhere or never ends.
#include "gpu/builds/packed_builds.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/unit/gpu/light_buffer/soups.h"
#include "tests/unit/scenes/support/written_bytes.h"

namespace gnomon::test {
namespace {

using gpu::Bvh;
using gpu::light_buffer::LightBuffer;
using scenes::testing::written_bytes;
using Bytes = std::vector<std::byte>;

template <class Built>
Bytes bytes_of(const Built& built) {
  return written_bytes([&](std::FILE* file) { return gpu::write_outcome(Result<Built>(built), file); });
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

class PackedBuilds : public testing::Test {
 protected:
  PackedBuilds() : soup_(made()) {
    settings_.threads = 1;
    settings_.detail.finest_level = 6;
    bvh_ = *gpu::builds_here()->bvh(soup_.mesh);
    buffer_ = *gpu::builds_here()->light_buffer(soup_.mesh, soup_.bounds, std::span(&soup_.light, 1), settings_);
  }

  static Soup made() {
    Random random(3);
    return make_soup(Shape::even, Lamp::point, 60, random);
  }

  Result<Bvh> read(const Bvh& bvh) const { return gpu::read_bvh(bytes_of(bvh), soup_.mesh); }
  Result<LightBuffer> read(const LightBuffer& buffer) const {
    return gpu::read_light_buffer(bytes_of(buffer), soup_.mesh, 1);
  }

  Soup soup_;
  gpu::light_buffer::BuildSettings settings_;
  Bvh bvh_;
  LightBuffer buffer_;
};

TEST_F(PackedBuilds, AHierarchyComesBackAsItWas) {
  const auto back = read(bvh_);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(same(back->nodes, bvh_.nodes));
  EXPECT_TRUE(same(back->triangles, bvh_.triangles));
}

TEST_F(PackedBuilds, LightBuffersComeBackAsTheyWere) {
  const auto back = read(buffer_);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(same(back->lights, buffer_.lights));
  EXPECT_TRUE(same(back->grid, buffer_.grid));
  EXPECT_TRUE(same(back->leaves, buffer_.leaves));
  EXPECT_EQ(back->entries, buffer_.entries);
  EXPECT_EQ(back->statistics.bytes, buffer_.statistics.bytes);
  EXPECT_EQ(back->statistics.longest_list, buffer_.statistics.longest_list);
}

TEST_F(PackedBuilds, AReasonComesBackAsItWas) {
  const Bytes bytes =
      written_bytes([](std::FILE* file) { return gpu::write_outcome(Result<Bvh>(Error{"too deep"}), file); });
  const auto back = gpu::read_bvh(bytes, soup_.mesh);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().message, "too deep");
}

TEST_F(PackedBuilds, ATaskBuildsTheSame) {
  gpu::BuildTask task;
  task.kind = gpu::BuildTask::Kind::light_buffer;
  task.mesh = &soup_.mesh;
  task.bounds = soup_.bounds;
  task.lights = {soup_.light};
  task.detail = settings_.detail;
  const Bytes bytes = written_bytes([&](std::FILE* file) -> Result<void> {
    scenes::PackWriter writer(file);
    gpu::write(writer, task);
    return writer.good() ? Result<void>() : Error{"not written"};
  });
  scenes::PackReader reader(bytes);
  gpu::BuildTask back;
  gpu::read(reader, back);
  ASSERT_TRUE(reader.good() && reader.at_end());
  EXPECT_EQ(back.kind, task.kind);
  const auto built = gpu::builds_here()->light_buffer(back.own_mesh, back.bounds, back.lights, settings_);
  ASSERT_TRUE(built);
  EXPECT_EQ(built->entries, buffer_.entries);
  for (size_t size = 0; size < bytes.size(); size += 7) {
    scenes::PackReader cut(std::span<const std::byte>(bytes).first(size));
    gpu::BuildTask broken;
    gpu::read(cut, broken);
    ASSERT_FALSE(cut.good()) << size << " of " << bytes.size();
  }
}

TEST_F(PackedBuilds, WhatIsCutOffIsAnError) {
  const Bytes bvh = bytes_of(bvh_), buffer = bytes_of(buffer_);
  for (size_t size = 0; size < bvh.size(); ++size) {
    ASSERT_FALSE(gpu::read_bvh(std::span(bvh).first(size), soup_.mesh)) << size;
  }
  for (size_t size = 0; size < buffer.size(); size += 9973) {
    ASSERT_FALSE(gpu::read_light_buffer(std::span(buffer).first(size), soup_.mesh, 1)) << size;
  }
}

TEST_F(PackedBuilds, ATraversalWouldStayInsideAndEnd) {
  const auto broken = [&](auto change) {
    Bvh bvh = bvh_;
    change(bvh);
    return !read(bvh);
  };
  EXPECT_TRUE(broken([](Bvh& b) { b.nodes[1].skip = 1; })) << "in circles";
  EXPECT_TRUE(broken([](Bvh& b) { b.nodes[1].skip = 0; })) << "backwards";
  EXPECT_TRUE(broken([](Bvh& b) { b.nodes[0].skip = static_cast<uint32_t>(b.nodes.size()) + 1; }));
  EXPECT_TRUE(broken([](Bvh& b) { b.nodes.back().leaf = (60 << 4) | 1; })) << "behind the last triangle";
  EXPECT_TRUE(broken([](Bvh& b) { b.nodes.back().leaf = ~0u; }));
  EXPECT_TRUE(broken([](Bvh& b) { b.triangles[7].triangle = 60; }));
  EXPECT_TRUE(broken([](Bvh& b) { b.triangles[7].masked ^= 1; }));
  EXPECT_TRUE(broken([](Bvh& b) { b.triangles.pop_back(); }));
  EXPECT_FALSE(broken([](Bvh&) {}));
}

TEST_F(PackedBuilds, AQueryWouldStayInside) {
  const auto broken = [&](auto change) {
    LightBuffer buffer = buffer_;
    change(buffer);
    return !read(buffer);
  };
  ASSERT_FALSE(buffer_.entries.empty());
  const auto words = static_cast<uint32_t>(buffer_.grid.size());
  EXPECT_TRUE(broken([](LightBuffer& b) { b.lights.clear(); }));
  EXPECT_TRUE(broken([&](LightBuffer& b) { b.lights[0].cells = words; }));
  EXPECT_TRUE(broken([&](LightBuffer& b) { b.grid[0] = words << gpu::light_buffer::kDepthBits; }));
  EXPECT_TRUE(broken([](LightBuffer& b) { b.grid[0] |= (1u << gpu::light_buffer::kDepthBits) - 1; })) << "too deep";
  EXPECT_TRUE(broken([](LightBuffer& b) { b.grid.back() = static_cast<uint32_t>(b.leaves.size()); }));
  EXPECT_TRUE(broken([](LightBuffer& b) { b.leaves.back().first = static_cast<uint32_t>(b.entries.size()) + 1; }));
  EXPECT_TRUE(broken([](LightBuffer& b) { b.leaves.back().count = (1u << gpu::light_buffer::kCountBits) - 1; }));
  EXPECT_TRUE(broken([](LightBuffer& b) { b.entries[0].triangle = 60; }));
  EXPECT_FALSE(broken([](LightBuffer&) {}));
}

}  // namespace
}  // namespace gnomon::test
