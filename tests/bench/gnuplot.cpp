#include "tests/bench/gnuplot.h"

#include <cstdio>

namespace gnomon::bench {

std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

Result<void> draw(const std::string& script, const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  if (ending != ".png" && ending != ".svg")
    return Error{"a plot ends in .png or .svg, not '" + file.string() + "'"};
  const std::string terminal = ending == ".png" ? "pngcairo size 1000,700" : "svg size 1000,700";
  const std::string text = "set terminal " + terminal + "\nset output " + in_quotes(file.string()) + "\n" + script;
  std::FILE* gnuplot = ::popen("gnuplot", "w");
  if (!gnuplot) return Error{"gnuplot cannot be started"};
  const bool written = std::fwrite(text.data(), 1, text.size(), gnuplot) == text.size();
  if (::pclose(gnuplot) == 0 && written) return {};
  return Error{"gnuplot made no plot of " + file.string() + " (deploy/install-packages tests installs it)"};
}

}  // namespace gnomon::bench
