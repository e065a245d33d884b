// Masks of the frames that a client sees along a scene's camera path, on which codecs are measured.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/packed_mask.h"
#include "common/result.h"
#include "protocol/types.h"
#include "tests/bench/bench_scenes.h"

namespace gnomon::bench {

struct PathFrame {
  std::vector<uint64_t> words;       // laid out as in common/tile_mask.h
  std::vector<uint64_t> valid_bits;  // same layout; bits that are not set here do not matter
  PackedMask packed;                 // the mask as the daemon gets it
  protocol::CameraView camera;       // of the frame
};

// The frame at one place of the path, and the frames that the client saw some time before.
struct PathSpot {
  PathFrame now;
  std::vector<PathFrame> before;  // one for each of PathPlan::ages_ms
};

struct PathPlan {
  uint32_t spots = 8;
  PictureSize size;
  std::vector<uint32_t> ages_ms;
  std::string device;            // as render.device of the configuration
  std::filesystem::path folder;  // cache of masks for the next run; if empty, no cache
};

struct PathMasks {
  std::string scene;
  TileGrid grid;
  std::vector<PathSpot> spots;
  std::string device, driver;  // that rendered the masks
};

Result<PathMasks> masks_along_path(const std::string& scene, const PathPlan& plan);

}  // namespace gnomon::bench
