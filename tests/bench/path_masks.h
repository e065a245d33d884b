// Masks of the frames that a client sees on its way along a scene's camera path: what codecs are measured on.
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
  std::vector<uint64_t> words;       // as common/tile_mask.h
  std::vector<uint64_t> valid_bits;  // of the same layout: which bits matter
  PackedMask packed;                 // the same as the daemon gets it
  protocol::CameraView camera;       // that it was seen through
};

// One place of the path, and how it looked so long before.
struct PathSpot {
  PathFrame now;
  std::vector<PathFrame> before;  // one for each of PathPlan::ages_ms
};

struct PathPlan {
  uint32_t spots = 8;
  PictureSize size;
  std::vector<uint32_t> ages_ms;
  std::string device;            // as render.device of the configuration
  std::filesystem::path folder;  // where masks are kept for the next run; empty: nowhere
};

struct PathMasks {
  std::string scene;
  TileGrid grid;
  std::vector<PathSpot> spots;
  std::string device, driver;  // what rendered them
};

Result<PathMasks> masks_along_path(const std::string& scene, const PathPlan& plan);

}  // namespace gnomon::bench
