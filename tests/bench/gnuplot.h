// Pictures by gnuplot.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace gnomon::bench {

// A text within a gnuplot script.
std::string in_quotes(const std::string& text);

// Runs `script` with its output going to `file`, PNG or SVG by its ending. Error if there is no gnuplot, for another
// ending, or if the file cannot be written.
Result<void> draw(const std::string& script, const std::filesystem::path& file);

}  // namespace gnomon::bench
