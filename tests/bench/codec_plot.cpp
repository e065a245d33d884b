#include "tests/bench/codec_plot.h"

#include <algorithm>
#include <cstdio>

#include "tests/bench/gnuplot.h"

namespace gnomon::bench {
namespace {

// One block of data for each scene: bytes, milliseconds to encode, to decode, the codec's name.
std::string block(size_t number, const std::string& scene, const std::vector<CodecPoint>& points) {
  std::string text = "$scene" + std::to_string(number) + " << END\n";
  for (const CodecPoint& point : points) {
    if (point.scene != scene) continue;
    char line[160];
    std::snprintf(line, sizeof line, "%.1f %.4f %.4f \"%s\"\n", point.bytes, point.encode_ms, point.decode_ms,
                  point.codec.c_str());
    text += line;
  }
  return text + "END\n";
}

}  // namespace

Result<void> plot_codecs(const std::vector<CodecPoint>& points, const std::string& caption,
                         const std::filesystem::path& file) {
  std::vector<std::string> scenes;
  for (const CodecPoint& point : points)
    if (std::find(scenes.begin(), scenes.end(), point.scene) == scenes.end()) scenes.push_back(point.scene);
  std::string data, curves;
  for (size_t i = 0; i < scenes.size(); ++i) {
    data += block(i, scenes[i], points);
    const std::string source = "$scene" + std::to_string(i), colour = " lc " + std::to_string(i + 1);
    curves += std::string(i == 0 ? "plot " : ", ") + source + " using 2:1 title " + in_quotes(scenes[i]) +
              " with points pt 7" + colour + ", " + source + " using 3:1 notitle with points pt 6" + colour + ", " +
              source + " using 2:1:4 notitle with labels font ',9' offset 0,0.8 tc lt " + std::to_string(i + 1);
  }
  return draw("set termoption noenhanced\nset title " + in_quotes(caption + " (full: encode, hollow: decode)") +
                  "\nset logscale xy\nset grid\nset key right top\nset offsets graph 0.1, graph 0.1, "
                  "graph 0.1, graph 0.1\nset xlabel 'ms'\nset ylabel 'bytes'\n" +
                  data + curves + "\n",
              file);
}

}  // namespace gnomon::bench
