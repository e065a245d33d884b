#include "tests/eval/remote/screen.h"

#include <algorithm>

namespace gnomon::remote {
namespace {

// The newest picture at the end of the step; none yet: the number of pictures.
size_t on_screen(const Screen& screen, uint32_t step) {
  const TimePoint end = screen.started + Nanoseconds(static_cast<int64_t>((step + 1) * 1e9 / screen.rate_hz));
  const auto after =
      std::upper_bound(screen.pictures.begin(), screen.pictures.end(), end,
                       [](TimePoint when, const ScreenPicture& picture) { return when < picture.at; });
  if (after == screen.pictures.begin()) return screen.pictures.size();
  return static_cast<size_t>(after - screen.pictures.begin()) - 1;
}

uint32_t age_of(const Screen& screen, size_t picture, uint32_t step) {
  return step - std::min(step, screen.pictures[picture].step);
}

}  // namespace

std::vector<Seen> seen_at_steps(const Screen& screen, uint32_t first) {
  std::vector<Seen> seen;
  std::vector<uint32_t> steps, ages;
  for (uint32_t step = first; step < screen.steps; ++step) {
    const size_t picture = on_screen(screen, step);
    if (picture == screen.pictures.size()) continue;
    seen.push_back({picture, screen.pictures[picture].step, false});
    steps.push_back(step);
    ages.push_back(age_of(screen, picture, step));
  }
  if (seen.empty()) return seen;
  std::vector<uint32_t> sorted = ages;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<ptrdiff_t>(sorted.size() / 2), sorted.end());
  const uint32_t usual = sorted[sorted.size() / 2];
  for (size_t i = 0; i < seen.size(); ++i) {
    seen[i].late = ages[i] > usual + 1;
    if (seen[i].late) seen[i].meant = steps[i] - usual;
  }
  return seen;
}

}  // namespace gnomon::remote
