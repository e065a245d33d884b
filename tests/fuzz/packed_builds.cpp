// What a process that builds for tracers is told and answers: a structure whose every traversal stays inside and ends, or
// an error. Light buffers without lights, as the cells of one light alone are 256 KiB.
#include "gpu/builds/packed_builds.h"

#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {

// Walks every node as a ray does that misses all boxes, and as one that hits all.
void traverse(const gpu::Bvh& bvh, const scenes::WorldMesh& mesh) {
  for (const bool hits : {false, true}) {
    size_t steps = 0;
    for (size_t node = 0; node < bvh.nodes.size(); ++steps) {
      require(steps <= bvh.nodes.size(), "a traversal ends");
      const gpu::BvhNode& at = bvh.nodes[node];
      for (uint32_t i = 0; i < (at.leaf & 15); ++i) {
        require(bvh.triangles[(at.leaf >> 4) + i].triangle < mesh.triangles.size(), "a leaf's triangles exist");
      }
      node = hits ? node + 1 : at.skip;
    }
  }
}

}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon;
  const auto bytes = std::as_bytes(std::span(data, size));
  const scenes::WorldMesh mesh = fuzz::small_mesh();
  if (const auto bvh = gpu::read_bvh(bytes, mesh)) fuzz::traverse(*bvh, mesh);
  if (const auto buffer = gpu::read_light_buffer(bytes, mesh, 0)) {
    for (const auto& entry : buffer->entries)
      fuzz::require(entry.triangle < mesh.triangles.size(), "an entry's triangle exists");
  }
  scenes::PackReader reader(bytes);
  gpu::BuildTask task;
  gpu::read(reader, task);
  if (!reader.good()) return 0;
  for (const glm::uvec3& t : task.own_mesh.triangles) {
    for (int k = 0; k < 3; ++k) fuzz::require(t[k] < task.own_mesh.positions.size(), "a triangle's corners exist");
  }
  return 0;
}
