#include "tests/bench/steady_times.h"

#include <vector>

#include "common/clock.h"
#include "tests/bench/report.h"

namespace gnomon::bench {
namespace {

// A device that waits between frames lowers its clocks, and then takes several times as long for one.
constexpr Nanoseconds kKeptBusy = std::chrono::milliseconds(150);

std::map<std::string, double> stage_times(const gpu::FrameTiming& timing) {
  std::map<std::string, double> ms;
  for (const gpu::StageTime& stage : timing.stages)
    ms[std::string(stage.pass)] += static_cast<double>(stage.gpu_ns) / 1e6;
  return ms;
}

}  // namespace

Result<SteadyTimes> steady_times(gpu::BlockingFrame& frame, const gpu::CameraView& camera, const TileGrid& grid) {
  std::map<std::string, std::vector<double>> stages;
  std::vector<double> whole;
  const TimePoint end = Clock::now() + kKeptBusy;
  do {
    const auto timing = frame.render(camera, grid);
    if (!timing) return timing.error();
    for (const auto& [pass, ms] : stage_times(*timing)) stages[pass].push_back(ms);
    whole.push_back(static_cast<double>(timing->total_ns) / 1e6);
  } while (Clock::now() < end);
  const auto steady = [](std::vector<double>& ms) {
    ms.erase(ms.begin(), ms.begin() + static_cast<ptrdiff_t>(ms.size() / 2));
    return median(ms);
  };
  SteadyTimes out{steady(whole), {}};
  for (auto& [pass, ms] : stages) out.stage_ms[pass] = steady(ms);
  return out;
}

}  // namespace gnomon::bench
