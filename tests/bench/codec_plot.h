// The plot of the suite "codec": for each scene, what a frame takes in bytes against what it takes in time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::bench {

struct CodecPoint {
  std::string scene, codec;
  double bytes = 0, encode_ms = 0, decode_ms = 0;
};

// `file`: PNG or SVG by its ending. Drawn by gnuplot. Error: no gnuplot, another ending, or the file cannot be written.
Result<void> plot_codecs(const std::vector<CodecPoint>& points, const std::string& caption,
                         const std::filesystem::path& file);

}  // namespace gnomon::bench
