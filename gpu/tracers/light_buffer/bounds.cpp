#include "gpu/tracers/light_buffer/bounds.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr size_t kCandidates = 3;

double middle(const Linear& f, const Rect& rect) {
  return at(f, 0.5 * (rect.u0 + rect.u1), 0.5 * (rect.v0 + rect.v1));
}

// `plane` moved towards the light until it is in front of every footprint; nullopt if it is then no farther away than
// `best`, in the rectangle's middle.
std::optional<Linear> raised(const Linear& plane, std::span<const Footprint* const> met, const Rect& rect,
                             double best) {
  Linear moved = plane;
  double most = -kInfinity;
  for (const Footprint* f : met) {
    const double more = excess(*f, rect, plane);
    if (!(more > most)) continue;
    most = more;
    moved.z = plane.z + most;
    if (!(middle(moved, rect) < best)) return std::nullopt;
  }
  return moved;
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

bool fit_near_plane(std::span<const Footprint* const> met, std::span<const double> nearness, const Rect& rect,
                    Linear& plane) {
  // The candidates are the planes of the footprints that reach nearest to the light, and a plane of constant nearness.
  std::array<const Footprint*, kCandidates> nearest{};
  std::array<double, kCandidates> most;
  most.fill(-kInfinity);
  for (size_t i = 0; i < met.size(); ++i) {
    const Footprint* f = met[i];
    if (!f->bounded) return false;
    double n = nearness[i];
    for (size_t k = 0; k < kCandidates && f != nullptr; ++k) {
      if (n > most[k]) {
        std::swap(n, most[k]);
        std::swap(f, nearest[k]);
      }
    }
  }
  plane = Linear(0, 0, most[0]);
  for (const Footprint* candidate : nearest) {
    if (candidate == nullptr) break;
    if (const auto moved = raised(candidate->nearest, met, rect, middle(plane, rect))) plane = *moved;
  }
  return true;
}

}  // namespace gnomon::gpu::light_buffer
