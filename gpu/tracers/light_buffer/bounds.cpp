#include "gpu/tracers/light_buffer/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double middle(const Linear& f, const Rect& rect) {
  return at(f, 0.5 * (rect.u0 + rect.u1), 0.5 * (rect.v0 + rect.v1));
}

// `plane` moved towards the light until it is in front of every footprint; nullopt if it is then no farther away than
// `best`, in the rectangle's middle.
std::optional<Linear> raised(const Linear& plane, std::span<const Footprint* const> met,
                             std::span<const double> nearness, const Rect& rect, double best) {
  const double least =
      plane.z + std::min(plane.x * rect.u0, plane.x * rect.u1) + std::min(plane.y * rect.v0, plane.y * rect.v1);
  Linear moved = plane;
  double most = -kInfinity;
  for (size_t k = 0; k < met.size(); ++k) {
    if (nearness[k] - least <= most) break;  // no footprint from here on is in front of the plane by more
    const double more = excess(*met[k], rect, plane);
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
  const double nearness = f.bounded ? excess(f, rect, Linear(0.0)) : kInfinity;
  return std::isnan(nearness) ? kInfinity : nearness;
}

bool fit_near_plane(std::span<const Footprint* const> met, std::span<const double> nearness, const Rect& rect,
                    Linear& plane) {
  if (nearness.front() == kInfinity) return false;
  // The candidates are the planes of the footprints that reach nearest to the light, and a plane of constant nearness.
  constexpr size_t kCandidates = 3;
  plane = Linear(0, 0, nearness.front());
  for (const Footprint* candidate : met.first(std::min(met.size(), kCandidates))) {
    if (const auto moved = raised(candidate->nearest, met, nearness, rect, middle(plane, rect))) plane = *moved;
  }
  return true;
}

}  // namespace gnomon::gpu::light_buffer
