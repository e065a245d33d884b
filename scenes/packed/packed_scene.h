// A scene, and the task of loading one, as bytes that another process of this build reads. See archive.h.
#pragma once

#include <cstdio>
#include <filesystem>
#include <span>
#include <vector>

#include "common/result.h"
#include "scenes/loader.h"
#include "scenes/packed/archive.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

// A scene to be loaded by another process.
struct LoadTask {
  std::filesystem::path file;
  std::vector<NodeMotion> motions;
  LoadLimits limits;
  Colours colours = Colours::none;
};

void write(PackWriter& writer, const LoadTask& task);
void read(PackReader& reader, LoadTask& task);  // the reader's good() says whether the task was complete

// A scene or the reason why there is none. Error: the file cannot be written.
Result<void> write_outcome(const Result<ScenePtr>& scene, std::FILE* file);

// The scene, or the reason that was written. The bytes are untrusted: a scene that breaks what scenes/scene.h promises
// or that exceeds the limits is an error. Its content hash is taken as it is written.
Result<ScenePtr> read_outcome(std::span<const std::byte> bytes, const LoadLimits& limits);

}  // namespace gnomon::scenes
