// The builds of structure_builds.h as bytes, for a process of the same build on the same machine: what is to be built,
// and what came of it. See scenes/packed/archive.h.
#pragma once

#include <cstdio>
#include <span>
#include <vector>

#include "gpu/builds/structure_builds.h"
#include "scenes/packed/archive.h"

namespace gnomon::gpu {

struct BuildTask {
  enum class Kind : uint8_t { bvh, light_buffer };
  Kind kind = Kind::bvh;
  // Borrowed by who writes a task. Normals, texture coordinates and materials do not matter to a build and are not
  // written.
  const scenes::WorldMesh* mesh = nullptr;
  scenes::WorldMesh own_mesh;  // of a task that was read; `mesh` is nullptr then
  // Of light buffers alone.
  scenes::Bounds bounds;
  std::vector<exact::TracedLight> lights;
  light_buffer::Detail detail;
  uint64_t budget_bytes = 0;
};

void write(scenes::PackWriter& writer, const BuildTask& task);
// The reader's good() says whether the task was complete. A triangle without its corners makes it incomplete.
void read(scenes::PackReader& reader, BuildTask& task);

// Error: the file cannot be written.
Result<void> write_outcome(const Result<Bvh>& built, std::FILE* file);
Result<void> write_outcome(const Result<light_buffer::LightBuffer>& built, std::FILE* file);

// The structure, or the reason that was written. The bytes are untrusted: a structure that would lead a traversal
// outside itself, in circles or outside the mesh is an error.
Result<Bvh> read_bvh(std::span<const std::byte> bytes, const scenes::WorldMesh& mesh);
Result<light_buffer::LightBuffer> read_light_buffer(std::span<const std::byte> bytes, const scenes::WorldMesh& mesh,
                                                    size_t lights);

}  // namespace gnomon::gpu
