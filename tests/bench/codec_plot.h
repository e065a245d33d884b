// The plot of the suite "codec": for each scene, the bytes of a frame against the time to code it.
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

// Draws with gnuplot to `file`, PNG or SVG by its ending. Error if there is no gnuplot, for another ending, or if the
// file cannot be written.
Result<void> plot_codecs(const std::vector<CodecPoint>& points, const std::string& caption,
                         const std::filesystem::path& file);

}  // namespace gnomon::bench
