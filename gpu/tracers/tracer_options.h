// Options of tracers.
#pragma once

#include <cstdint>
#include <filesystem>

#include "gpu/builds/structure_builds.h"

namespace gnomon::gpu {

struct TracerOptions {
  std::filesystem::path cache_folder;  // for the results of builds; empty: no cache
  uint64_t cache_bytes = UINT64_MAX;   // most that the folder may hold; what was used least recently leaves first
  uint64_t light_buffer_bytes = 0;     // memory budget of a scene's light buffers; 0: by the number of lights
  StructureBuildsPtr builds = builds_here();
};

}  // namespace gnomon::gpu
