// What tracers may be told beside the scene.
#pragma once

#include <cstdint>
#include <filesystem>

namespace gnomon::gpu {

struct TracerOptions {
  std::filesystem::path cache_folder;  // where what was built is kept for the next start; empty: nowhere
  uint64_t light_buffer_bytes = 0;     // memory of a scene's light buffers; 0: by the number of lights
};

}  // namespace gnomon::gpu
