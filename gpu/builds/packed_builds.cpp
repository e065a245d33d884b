#include "gpu/builds/packed_builds.h"

#include <algorithm>

namespace gnomon::scenes {

template <>
inline constexpr bool kPlain<gpu::BvhNode> = true;
template <>
inline constexpr bool kPlain<gpu::BvhTriangle> = true;
template <>
inline constexpr bool kPlain<gpu::exact::TracedLight> = true;
template <>
inline constexpr bool kPlain<gpu::light_buffer::LightView> = true;
template <>
inline constexpr bool kPlain<gpu::light_buffer::Leaf> = true;
template <>
inline constexpr bool kPlain<gpu::light_buffer::ListEntry> = true;

}  // namespace gnomon::scenes

namespace gnomon::gpu {
namespace {

using light_buffer::LightBuffer;
using scenes::PackReader;
using scenes::PackWriter;

template <class Archive>
void visit(Archive& a, scenes::WorldMesh& mesh) {
  a.bulk(mesh.positions);
  a.bulk(mesh.triangles);
  a.plain(mesh.opaque_count);
}

template <class Archive>
void visit_settings(Archive& a, BuildTask& task) {
  a.enumerator(task.kind, BuildTask::Kind::light_buffer);
  a.plain(task.bounds.min);
  a.plain(task.bounds.max);
  a.bulk(task.lights);
  a.plain(task.detail.cost_per_byte);
  a.plain(task.detail.finest_level);
  a.plain(task.budget_bytes);
}

template <class Archive>
void visit(Archive& a, Bvh& bvh) {
  a.bulk(bvh.nodes);
  a.bulk(bvh.triangles);
}

template <class Archive>
void visit(Archive& a, LightBuffer& buffer) {
  a.bulk(buffer.lights);
  a.bulk(buffer.grid);
  a.bulk(buffer.leaves);
  a.bulk(buffer.entries);
  a.plain(buffer.statistics.build_seconds);
  a.plain(buffer.statistics.longest_list);
}

template <class Built>
Result<void> write_result(const Result<Built>& built, std::FILE* file) {
  PackWriter writer(file);
  writer.boolean(built.has_value());
  if (built) {
    visit(writer, const_cast<Built&>(*built));  // visits of a writer change nothing
  } else {
    writer.text(built.error().message);
  }
  if (writer.good() && std::fflush(file) == 0) return {};
  return Error{"the result cannot be written"};
}

template <class Built>
Result<Built> read_result(std::span<const std::byte> bytes) {
  PackReader reader(bytes);
  bool done = false;
  reader.boolean(done);
  if (!done) {
    std::string why;
    reader.text(why);
    return Error{reader.good() && !why.empty() ? why : "its builder gave no answer"};
  }
  Built built;
  visit(reader, built);
  if (!reader.good() || !reader.at_end()) return Error{"its builder gave a broken answer: it is cut off"};
  return built;
}

// A ray goes on at the next node or at `skip`: as both lie behind the node it is at, it comes to an end.
bool sound(const Bvh& bvh, const scenes::WorldMesh& mesh) {
  const size_t nodes = bvh.nodes.size(), triangles = bvh.triangles.size();
  for (size_t i = 0; i < nodes; ++i) {
    const BvhNode& node = bvh.nodes[i];
    if (node.skip <= i || node.skip > nodes) return false;
    if ((node.leaf >> 4) + (node.leaf & 15) > triangles) return false;
  }
  return triangles == mesh.triangles.size() &&
         std::all_of(bvh.triangles.begin(), bvh.triangles.end(), [&](const BvhTriangle& t) {
           return t.triangle < triangles && t.masked == (t.triangle >= mesh.opaque_count ? 1u : 0u);
         });
}

// Finds the blocks of a grid whose every word names a leaf, each in constant time however blocks overlap.
class Blocks {
 public:
  explicit Blocks(const LightBuffer& buffer) : others_before_(buffer.grid.size() + 1) {
    for (size_t i = 0; i < buffer.grid.size(); ++i) {
      others_before_[i + 1] = others_before_[i] + (buffer.grid[i] < buffer.leaves.size() ? 0 : 1);
    }
  }
  bool sound(uint32_t cell) const {
    using namespace light_buffer;
    const uint32_t bits = cell & ((1u << kDepthBits) - 1);
    const size_t first = cell >> kDepthBits, end = first + (size_t{1} << (2 * bits));
    return bits <= kBlockBits && end < others_before_.size() && others_before_[first] == others_before_[end];
  }

 private:
  std::vector<uint32_t> others_before_;  // words before each word that name no leaf
};

bool sound(const LightBuffer& buffer, const scenes::WorldMesh& mesh, size_t lights) {
  using namespace light_buffer;
  if (buffer.lights.size() != lights) return false;
  const Blocks blocks(buffer);
  for (const LightView& light : buffer.lights) {
    const size_t first = light.cells, cells = (light.directional != 0 ? size_t{1} : size_t{6}) * kCellCount;
    if (first > buffer.grid.size() || cells > buffer.grid.size() - first) return false;
    const auto begin = buffer.grid.begin() + static_cast<ptrdiff_t>(first);
    if (!std::all_of(begin, begin + static_cast<ptrdiff_t>(cells), [&](uint32_t c) { return blocks.sound(c); })) {
      return false;
    }
  }
  const size_t entries = buffer.entries.size();
  return std::all_of(buffer.leaves.begin(), buffer.leaves.end(),
                     [&](const Leaf& leaf) {
                       const size_t count = leaf.count & ((1u << kCountBits) - 1);
                       return leaf.first <= entries && count <= entries - leaf.first;
                     }) &&
         std::all_of(buffer.entries.begin(), buffer.entries.end(),
                     [&](const ListEntry& entry) { return entry.triangle < mesh.triangles.size(); });
}

bool sound(const scenes::WorldMesh& mesh) {
  const size_t vertices = mesh.positions.size();
  return mesh.opaque_count <= mesh.triangles.size() &&
         std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const glm::uvec3& t) { return t.x < vertices && t.y < vertices && t.z < vertices; });
}

const Error kBroken{"its builder gave a broken answer"};

}  // namespace

void write(PackWriter& writer, const BuildTask& task) {
  visit_settings(writer, const_cast<BuildTask&>(task));  // visits of a writer change nothing
  visit(writer, const_cast<scenes::WorldMesh&>(*task.mesh));
}

void read(PackReader& reader, BuildTask& task) {
  visit_settings(reader, task);
  visit(reader, task.own_mesh);
  if (!sound(task.own_mesh)) reader.fail();
}

Result<void> write_outcome(const Result<Bvh>& built, std::FILE* file) { return write_result(built, file); }
Result<void> write_outcome(const Result<LightBuffer>& built, std::FILE* file) { return write_result(built, file); }

Result<Bvh> read_bvh(std::span<const std::byte> bytes, const scenes::WorldMesh& mesh) {
  auto bvh = read_result<Bvh>(bytes);
  if (bvh && !sound(*bvh, mesh)) return kBroken;
  return bvh;
}

Result<LightBuffer> read_light_buffer(std::span<const std::byte> bytes, const scenes::WorldMesh& mesh,
                                      size_t lights) {
  auto buffer = read_result<LightBuffer>(bytes);
  if (!buffer) return buffer;
  if (!sound(*buffer, mesh, lights)) return kBroken;
  buffer->statistics.bytes = buffer->memory_bytes();
  buffer->statistics.leaves = buffer->leaves.size();
  buffer->statistics.entries = buffer->entries.size();
  return buffer;
}

}  // namespace gnomon::gpu
