// What pieces would take at each of several details, found by one look at their squares. A square that is divided at one
// detail is divided at every finer one, so that the finest detail visits all squares of the others.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "gpu/tracers/light_buffer/squares.h"
#include "gpu/tracers/light_buffer/subdivide.h"

namespace gnomon::gpu::light_buffer {

// What pieces take.
struct PiecesSize {
  uint64_t bytes = 0;  // without the cells
  uint64_t work = 0;   // as Piece::work

  bool within(const PiecesSize& limit) const { return bytes <= limit.bytes && work <= limit.work; }
  // What `used` leaves of this: nothing where it takes more.
  PiecesSize less(const PiecesSize& used) const {
    return {bytes - std::min(bytes, used.bytes), work - std::min(work, used.work)};
  }
  PiecesSize times(double factor) const {
    return {static_cast<uint64_t>(factor * static_cast<double>(bytes)),
            static_cast<uint64_t>(factor * static_cast<double>(work))};
  }
};

// The details that are looked at: Detail::cost_per_byte falls from step to step. Their number only falls, too: where the
// pieces so far exceed a step's limit, that step and all finer ones are given up, but never the first.
class SurveySteps {
 public:
  // `limits`: of all pieces that will be added, for each step; at least one. The thresholds outlive this.
  SurveySteps(std::span<const double> thresholds, std::vector<PiecesSize> limits);

  std::span<const double> thresholds() const { return thresholds_; }
  const PiecesSize& limit(size_t step) const { return limits_[step]; }

  // Any thread.
  size_t count() const;
  // Adds a piece. It may have fewer steps than there still are: those that it has not are given up.
  void add(std::span<const PiecesSize> piece);

  // Of all pieces that were added, for each step that is left. The same whatever the order and the threads.
  std::vector<PiecesSize> sums() const;

 private:
  const std::span<const double> thresholds_;
  const std::vector<PiecesSize> limits_;
  mutable std::mutex mutex_;
  std::vector<PiecesSize> sums_;
};

// Root square (i, j) of a face, which stands for others.
struct PieceSample {
  uint32_t i = 0, j = 0;
  double weight = 1;  // of how many pieces, with itself
  std::optional<uint32_t>
      quarter;  // the one of its four parts that stands for all of them; none: all are looked at
};

// Adds a root square of the face to the steps. `met`, `surface`: as of build_piece. An estimate: it takes all footprints
// of a leaf for entries, of which a few need none.
void survey_piece(const Face& face, double surface, uint32_t finest_level, const PieceSample& sample, Met met,
                  SurveySteps& steps);

}  // namespace gnomon::gpu::light_buffer
