#include "gpu/tracers/light_buffer/squares.h"

#include <algorithm>
#include <cmath>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kStart = 3.0, kStep = 1.0, kTest = 3.0;  // of what a query costs

double area(const Rect& r) { return std::max(0.0, r.u1 - r.u0) * std::max(0.0, r.v1 - r.v0); }

// Lanes wait for the one with the longest walk, and a frame for its last tile: a long walk costs more than its steps.
double waited_for(double price) {
  constexpr double kUsual = 16.0;
  return price * (1.0 + price / kUsual);
}

// The share of a footprint's part that lies behind the near plane, from a few places of it.
double walking(const Footprint& f, const Rect& part, const Linear& near) {
  if (!f.bounded) return 1.0;
  constexpr std::array<glm::dvec2, 4> kPlaces = {{{0.25, 0.15}, {0.85, 0.25}, {0.15, 0.75}, {0.75, 0.85}}};
  int behind = 0;
  for (const glm::dvec2& p : kPlaces) {
    const double u = part.u0 + p.x * (part.u1 - part.u0), v = part.v0 + p.y * (part.v1 - part.v0);
    const double bound = at(near, u, v);
    behind += at(f.nearest, u, v) < bound - 1e-4 * std::abs(bound) ? 1 : 0;
  }
  return 0.25 * behind;
}

}  // namespace

void Squares::drop_hidden(Leaf& leaf, const Rect& rect, Met& met) const {
  const Footprint* cover = find_cover(met, rect);
  if (cover != nullptr && face_.plane(cover->cover, -1.0, leaf.cover_plane)) {
    std::erase_if(met, [&](const Footprint* f) { return hidden(*f, *cover, rect); });
  }
}

Linear Squares::set_near_plane(Leaf& leaf, const Rect& rect, Met& met) {
  Linear plane(0, 0, 1e30);
  nearness_.clear();
  if (met.empty()) return plane;
  sort_by_nearness(rect, met);
  if (!fit_near_plane(met, nearness_, rect, plane) ||
      (!face_.plane(plane, 1.0, leaf.near_plane) &&
       !face_.plane(Linear(0, 0, nearness_.front()), 1.0, leaf.near_plane))) {
    // There is no near plane: this one has no point in front of it at any depth that a float can hold.
    leaf.near_plane = glm::vec3(face_.depth_axis * 1e30);
  }
  return plane;
}

void Squares::sort_by_nearness(const Rect& rect, Met& met) {
  by_nearness_.clear();
  for (const Footprint* f : met) by_nearness_.emplace_back(nearest_in(*f, rect), f);
  // Parts have the order of their square, so that neighbours are mostly in order.
  std::sort(by_nearness_.begin(), by_nearness_.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  for (size_t k = 0; k < met.size(); ++k) {
    met[k] = by_nearness_[k].second;
    nearness_.push_back(by_nearness_[k].first);
  }
}

double Squares::cost(const Rect& rect, const Met& met, const Linear& near) const {
  return is_long(met) ? rough_cost(rect, met) : close_cost(rect, met, near);
}

// It assumes that the surfaces that are seen are mostly those that cast the shadows: each footprint asks for as much of
// its triangle as lies here. It costs nothing where that lies on the near plane, else a start, a step for each footprint
// before it, and a test for each of these whose box holds it.
double Squares::close_cost(const Rect& rect, const Met& met, const Linear& near) const {
  const double tests = kTest / area(rect);
  double price = kStart, sum = 0;
  for (const Footprint* f : met) {
    const Rect part = common(rect, f->box);
    const double place = area(part);
    price += kStep + tests * place;
    sum += f->asking * place * walking(*f, part, near) * waited_for(price);
  }
  return sum / surface_ + elsewhere(rect, price);
}

double Squares::rough_cost(const Rect& rect, const Met& met) const {
  const double price = kStart + kStep * static_cast<double>(met.size());
  double sum = 0;
  for (const Footprint* f : met) sum += f->asking * area(common(rect, f->box));
  return sum * waited_for(price) / surface_ + elsewhere(rect, price);
}

// What surfaces ask that are no occluders of this face: a part of all, evenly over the directions. Without it nothing
// would divide a long list of triangles too small to matter as surfaces.
double Squares::elsewhere(const Rect& rect, double price) const {
  constexpr double kPart = 0.3, kFaces = 6.0;
  return kPart * area(rect) / (kFaces * face_.size * face_.size) * waited_for(price);
}

double Squares::bytes_to_divide(uint32_t level, uint32_t deepest, size_t count) {
  const double lists = 128.0 + 6.0 * static_cast<double>(count);
  return level < deepest || level < kTopLevel ? lists : lists + block_bytes(level + 1) - block_bytes(deepest);
}

double Squares::block_bytes(uint32_t level) {
  return sizeof(uint32_t) * power_of_two(2 * static_cast<int>(level - kTopLevel));
}

std::array<Met, 4>* Squares::parts(uint32_t level, uint32_t i, uint32_t j, const Met& met) {
  std::array<Met, 4>& parts = parts_[level];
  for (Met& part : parts) part.clear();
  const Quarters quarters(face_.square(level + 1, 2 * i, 2 * j), face_.square(level + 1, 2 * i + 1, 2 * j + 1));
  for (const Footprint* f : met) {
    const uint32_t those = quarters_met(*f, quarters);
    for (uint32_t c = 0; c < 4; ++c)
      if ((those >> c & 1) != 0) parts[c].push_back(f);
  }
  const size_t total = parts[0].size() + parts[1].size() + parts[2].size() + parts[3].size();
  if (level >= kTopLevel && 10 * total > 36 * met.size() && met.size() < 64) return nullptr;
  return &parts;
}

}  // namespace gnomon::gpu::light_buffer
