// Light buffers on disk, so that a scene that was seen before is ready at once.
//
// A file is found by what it was built from: the scene's content hash, the settings and this code's version. What it
// holds is checksummed; a damaged, shortened or foreign file is as good as none and is written anew.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "common/result.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "scenes/scene.h"

namespace gnomon::gpu::light_buffer {

struct CacheKey {
  scenes::ContentHash content{};
  uint64_t settings = 0;  // of the budget and of everything in the code that changes what is built
};

// `triangles`: in the order by which the buffer speaks of them, which may follow from more than the content.
CacheKey cache_key(const scenes::ContentHash& content, const BuildSettings& settings,
                   std::span<const glm::uvec3> triangles = {});

std::filesystem::path cache_file(const std::filesystem::path& folder, const CacheKey& key);

// Nothing: no such file, or not one to trust; then `why` says what is wrong with it, empty where there is none.
std::optional<LightBuffer> load(const std::filesystem::path& folder, const CacheKey& key, std::string& why);

// Creates the folder. Readers see the old file or the new one, never a part. Error: the system's reason.
Result<void> save(const std::filesystem::path& folder, const CacheKey& key, const LightBuffer& buffer);

}  // namespace gnomon::gpu::light_buffer
