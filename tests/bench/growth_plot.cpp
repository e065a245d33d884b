#include "tests/bench/growth_plot.h"

#include <cstdio>
#include <string>

#include "tests/bench/gnuplot.h"

namespace gnomon::bench {
namespace {

// Inline blocks of data: the name, then one line for each point.
std::string block(const std::string& name, const std::vector<GrowthPoint>& points) {
  std::string text = "$" + name + " << END\n";
  for (const GrowthPoint& p : points) {
    char line[128];
    std::snprintf(line, sizeof line, "%.0f %.4f %.4f %.4f\n", p.count, p.frame_ms, p.raster_ms, p.trace_ms);
    text += line;
  }
  return text + "END\n";
}

std::string script(const GrowthCurves& curves) {
  return "set title " + in_quotes(curves.caption) + " noenhanced\n" +
         "set logscale x 10\nset logscale x2 2\nset autoscale xfix\nset autoscale x2fix\nset logscale y 10\nset "
         "grid\nset key left top\n"
         "set xtics nomirror\nset x2tics\nset format x '10^{%L}'\n"
         "set xlabel 'triangles (solid)'\nset x2label 'lights (dashed)'\nset ylabel 'ms'\n" +
         block("triangles", curves.triangles) + block("lights", curves.lights) +
         "plot $triangles using 1:2 title 'frame' with linespoints lt 1 lw 2,"
         " $triangles using 1:3 title 'raster' with linespoints lt 2,"
         " $triangles using 1:4 title 'trace' with linespoints lt 3,"
         " $lights using 1:2 axes x2y1 notitle with linespoints lt 1 lw 2 dt 2,"
         " $lights using 1:3 axes x2y1 notitle with linespoints lt 2 dt 2,"
         " $lights using 1:4 axes x2y1 notitle with linespoints lt 3 dt 2\n";
}

}  // namespace

Result<void> plot_growth(const GrowthCurves& curves, const std::filesystem::path& file) {
  return draw(script(curves), file);
}

}  // namespace gnomon::bench
