// The plot of the suite "growth": frame time over triangles and over lights, in one picture.
#pragma once

#include <filesystem>
#include <vector>

#include "common/result.h"

namespace gnomon::bench {

struct GrowthPoint {
  double count = 0;  // triangles or lights
  double frame_ms = 0, raster_ms = 0, trace_ms = 0;
};

struct GrowthCurves {
  std::vector<GrowthPoint> triangles, lights;
  std::string caption;
};

// Draws with gnuplot to `file`, PNG or SVG by its ending. Error if there is no gnuplot, for another ending, or if the
// file cannot be written.
Result<void> plot_growth(const GrowthCurves& curves, const std::filesystem::path& file);

}  // namespace gnomon::bench
