// What decides about the squares of a face: which of the footprints that meet one matter, what queries there are expected
// to cost, and what dividing it takes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "gpu/tracers/light_buffer/bounds.h"
#include "gpu/tracers/light_buffer/face.h"
#include "gpu/tracers/light_buffer/light_buffer.h"

namespace gnomon::gpu::light_buffer {

// The footprints that may meet a square.
using Met = std::vector<const Footprint*>;

// One thread. Keeps memory from square to square.
class Squares {
 public:
  // The face outlives this. `surface`: the area of all triangles of the scene.
  Squares(const Face& face, double surface) : face_(face), surface_(surface) {}

  const Face& face() const { return face_; }

  // Sets the leaf's cover plane if there is one, and removes what it hides.
  void drop_hidden(Leaf& leaf, const Rect& rect, Met& met) const;

  // A square with a long list is mostly divided, and then needs no near plane, which looks at every footprint.
  static bool is_long(const Met& met) { return met.size() > 256; }

  // Sets the leaf's near plane, and sorts the footprints: those nearest to the light first. Leaves the nearness of each in
  // `nearness()`.
  Linear set_near_plane(Leaf& leaf, const Rect& rect, Met& met);
  std::span<const double> nearness() const { return nearness_; }

  // What a query costs that asks this square, times the share of the scene's surface that asks it. Steps of a list are
  // the unit. `near`: what set_near_plane returned for these footprints; without meaning if the list is long.
  double cost(const Rect& rect, const Met& met, const Linear& near) const;

  // As cost, of a list so long that more takes longer than it is worth.
  double rough_cost(const Rect& rect, const Met& met) const;

  // What the square takes in memory if it is divided: leaves, words of the grid, and the entries that more than one of
  // them needs. `deepest`: the finest level of the open cell's leaves.
  static double bytes_to_divide(uint32_t level, uint32_t deepest, size_t count);
  // The words of a cell whose finest leaves are of this level, in bytes.
  static double block_bytes(uint32_t level);

  // The parts of a square of this level, until the next square of the level is divided; nullptr if they would not
  // shorten the lists.
  std::array<Met, 4>* parts(uint32_t level, uint32_t i, uint32_t j, const Met& met);

 private:
  double close_cost(const Rect& rect, const Met& met, const Linear& near) const;
  void sort_by_nearness(const Rect& rect, Met& met);
  double elsewhere(const Rect& rect, double price) const;

  const Face& face_;
  const double surface_;
  std::vector<double> nearness_;
  std::vector<std::pair<double, const Footprint*>> by_nearness_;
  std::array<std::array<Met, 4>, kFinestLevel> parts_;  // level by level
};

}  // namespace gnomon::gpu::light_buffer
