// Light buffers on disk, so that a scene that was built before is ready at once.
//
// A file's name derives from what it was built from: the scene's content hash, the settings and the version of this
// code. Its content is checksummed; a damaged, truncated or foreign file is treated as missing and is replaced. A file's
// modification time is when it was last used, so that the folder can be kept within a size by least use.
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
  uint64_t build = 0;  // hash of the mesh, its bounds, the lights, the budget and the version of the code
};

// Covers everything that a build reads, so that a scene cannot pass for another one by its content hash, which comes
// from whoever read the file. `mesh`: in the order of the buffer's triangle numbers, which may depend on more than the
// content.
CacheKey cache_key(const scenes::ContentHash& content, const BuildSettings& settings, const scenes::WorldMesh& mesh,
                   const scenes::Bounds& bounds, std::span<const exact::TracedLight> lights);

std::filesystem::path cache_file(const std::filesystem::path& folder, const CacheKey& key);

// Returns nullopt if there is no such file or if it is not valid; else the file counts as used now. `why` is set to the fault; empty if there is no file.
std::optional<LightBuffer> load(const std::filesystem::path& folder, const CacheKey& key, std::string& why);

inline constexpr uint64_t kNoLimit = UINT64_MAX;

// Writes the file, and creates the folder if need be. Concurrent readers see the old file or the new one, never a part.
// Before, room is made as by trim(), so that the folder never holds more than `most_bytes`.
// Error: the system's reason, or that the file alone would be larger.
Result<void> save(const std::filesystem::path& folder, const CacheKey& key, const LightBuffer& buffer,
                  uint64_t most_bytes = kNoLimit);

struct Trimmed {
  size_t files = 0;
  uint64_t bytes = 0;
};

// Removes cached files, the least recently used first, until the rest has at most `most_bytes`. Parts that a process
// left when it was killed count and leave like others; files of another kind do not.
Trimmed trim(const std::filesystem::path& folder, uint64_t most_bytes);

}  // namespace gnomon::gpu::light_buffer
