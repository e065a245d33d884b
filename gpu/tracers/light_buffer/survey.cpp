#include "gpu/tracers/light_buffer/survey.h"

#include <algorithm>

namespace gnomon::gpu::light_buffer {
namespace {

class PieceSurvey {
 public:
  PieceSurvey(const Face& face, double surface, uint32_t finest_level, const PieceSample& sample,
              const SurveySteps& steps)
      : squares_(face, surface),
        finest_level_(finest_level),
        sample_(sample),
        steps_(steps),
        sizes_(steps.count(), PiecesSize{sizeof(Leaf), 0}),
        deepest_(sizes_.size(), kTopLevel) {}

  // Steps before `first` have a leaf that this square is a part of.
  void visit(uint32_t level, uint32_t i, uint32_t j, Met& met, size_t first) {
    if (first >= sizes_.size()) return;
    if (level == kTopLevel) std::fill(deepest_.begin(), deepest_.end(), kTopLevel);
    for (size_t s = first; s < sizes_.size(); ++s) deepest_[s] = std::max(deepest_[s], level);
    const Rect rect = squares_.face().square(level, i, j);
    Leaf leaf;
    squares_.drop_hidden(leaf, rect, met);
    for (size_t s = first; s < sizes_.size(); ++s) sizes_[s].work += scale_ * (met.size() + 1);
    give_up();
    size_t divided = first_divided(level, rect, leaf, met, first);
    std::array<Met, 4>* parts = divided < sizes_.size() ? squares_.parts(level, i, j, met) : nullptr;
    if (parts == nullptr) divided = sizes_.size();
    const bool empty = met.empty() && leaf.cover_plane == glm::vec3(0.0f);
    const uint64_t bytes =
        (empty ? 0 : sizeof(Leaf) + met.size() * sizeof(ListEntry)) + (level < kTopLevel ? sizeof(uint32_t) : 0);
    for (size_t s = first; s < std::min(divided, sizes_.size()); ++s) sizes_[s].bytes += scale_ * bytes;
    for (uint32_t c = 0; parts != nullptr && c < 4; ++c) {
      if (level == kRootLevel && sample_.quarter) {
        if (c != *sample_.quarter) continue;
        scale_ = 4;
      }
      visit(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1), (*parts)[c], divided);
    }
    if (level != kTopLevel) return;
    for (size_t s = first; s < sizes_.size(); ++s)
      sizes_[s].bytes += scale_ * static_cast<uint64_t>(Squares::block_bytes(deepest_[s]));
  }

  std::vector<PiecesSize> weighted_sizes() const {
    std::vector<PiecesSize> sizes = sizes_;
    for (PiecesSize& size : sizes) size = size.times(sample_.weight);
    return sizes;
  }

 private:
  // The first step, from `first` on, at which the square is divided, if it can be.
  size_t first_divided(uint32_t level, const Rect& rect, Leaf& leaf, Met& met, size_t first) {
    if (met.size() <= 1 || level >= finest_level_) return sizes_.size();
    const Linear near = Squares::is_long(met) ? Linear(0.0) : squares_.set_near_plane(leaf, rect, met);
    const double cost = squares_.cost(rect, met, near);
    const auto divides = [&](size_t s) {
      return cost > steps_.thresholds()[s] * Squares::bytes_to_divide(level, deepest_[s], met.size());
    };
    while (first < sizes_.size() && !divides(first)) ++first;
    return first;
  }

  // The steps that this piece alone takes beyond their limit. What it takes grows from step to step.
  void give_up() {
    while (sizes_.size() > 1 && !sizes_.back().times(sample_.weight).within(steps_.limit(sizes_.size() - 1)))
      sizes_.pop_back();
  }

  Squares squares_;
  const uint32_t finest_level_;
  const PieceSample sample_;
  uint64_t scale_ = 1;  // how many squares the one that is visited stands for, within the piece
  const SurveySteps& steps_;
  std::vector<PiecesSize> sizes_;
  std::vector<uint32_t> deepest_;  // of each step, the finest level of the open cell's leaves
};

}  // namespace

SurveySteps::SurveySteps(std::span<const double> thresholds, std::vector<PiecesSize> limits)
    : thresholds_(thresholds), limits_(std::move(limits)), sums_(limits_.size()) {}

size_t SurveySteps::count() const {
  const std::lock_guard lock(mutex_);
  return sums_.size();
}

void SurveySteps::add(std::span<const PiecesSize> piece) {
  const std::lock_guard lock(mutex_);
  sums_.resize(std::min(sums_.size(), piece.size()));
  for (size_t s = 0; s < sums_.size(); ++s) {
    sums_[s].bytes += piece[s].bytes;
    sums_[s].work += piece[s].work;
  }
  while (sums_.size() > 1 && !sums_.back().within(limits_[sums_.size() - 1])) sums_.pop_back();
}

std::vector<PiecesSize> SurveySteps::sums() const {
  const std::lock_guard lock(mutex_);
  return sums_;
}

void survey_piece(const Face& face, double surface, uint32_t finest_level, const PieceSample& sample, Met met,
                  SurveySteps& steps) {
  const Rect rect = face.square(kRootLevel, sample.i, sample.j);
  std::erase_if(met, [&](const Footprint* f) { return !meets(*f, rect); });
  PieceSurvey survey(face, surface, finest_level, sample, steps);
  survey.visit(kRootLevel, sample.i, sample.j, met, 0);
  steps.add(survey.weighted_sizes());
}

}  // namespace gnomon::gpu::light_buffer
