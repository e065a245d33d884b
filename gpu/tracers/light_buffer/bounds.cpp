#include "gpu/tracers/light_buffer/bounds.h"

#include <algorithm>
#include <array>
#include <limits>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr size_t kCandidates = 3;

double middle(const Linear& f, const Rect& rect) {
  return at(f, 0.5 * (rect.u0 + rect.u1), 0.5 * (rect.v0 + rect.v1));
}

// `plane` moved towards the light until it is in front of every footprint.
Linear raised(Linear plane, std::span<const Footprint* const> met, const Rect& rect) {
  double most = -kInfinity;
  for (const Footprint* f : met) most = std::max(most, excess(*f, rect, plane));
  plane.z += most;
  return plane;
}

}  // namespace

const Footprint* find_cover(std::span<const Footprint* const> met, const Rect& rect) {
  const Footprint* best = nullptr;
  for (const Footprint* f : met) {
    if (!covers(*f, rect)) continue;
    if (best == nullptr || middle(f->cover, rect) > middle(best->cover, rect)) best = f;
  }
  return best;
}

bool hidden(const Footprint& f, const Footprint& cover, const Rect& rect) {
  return f.bounded && &f != &cover && excess(f, rect, cover.cover) <= 0.0;
}

double nearest_in(const Footprint& f, const Rect& rect) {
  return f.bounded ? excess(f, rect, Linear(0.0)) : kInfinity;
}

bool fit_near_plane(std::span<const Footprint* const> met, const Rect& rect, Linear& plane) {
  // The candidates are the planes of the footprints that reach nearest to the light, and a plane of constant nearness.
  std::array<const Footprint*, kCandidates> nearest{};
  std::array<double, kCandidates> nearness;
  nearness.fill(-kInfinity);
  for (const Footprint* f : met) {
    if (!f->bounded) return false;
    double n = excess(*f, rect, Linear(0.0));
    for (size_t k = 0; k < kCandidates && f != nullptr; ++k) {
      if (n > nearness[k]) {
        std::swap(n, nearness[k]);
        std::swap(f, nearest[k]);
      }
    }
  }
  plane = Linear(0, 0, nearness[0]);
  for (const Footprint* candidate : nearest) {
    if (candidate == nullptr) break;
    const Linear moved = raised(candidate->nearest, met, rect);
    if (middle(moved, rect) < middle(plane, rect)) plane = moved;
  }
  return true;
}

}  // namespace gnomon::gpu::light_buffer
