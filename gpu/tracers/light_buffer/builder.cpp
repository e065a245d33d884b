#include "gpu/tracers/light_buffer/builder.h"

#include <algorithm>
#include <memory>
#include <thread>

#include "common/clock.h"
#include "common/parallel.h"
#include "gpu/tracers/light_buffer/detail_fit.h"
#include "gpu/tracers/light_buffer/light_build.h"

namespace gnomon::gpu::light_buffer {
namespace {

class Assembly {
 public:
  explicit Assembly(LightBuffer& out) : out_(out) { out_.leaves.resize(1); }

  void add(LightView view, size_t faces, const std::vector<Piece>& pieces, unsigned threads) {
    view.cells = static_cast<uint32_t>(out_.grid.size());
    out_.lights.push_back(view);
    std::vector<Place> places;
    Place next{out_.grid.size() + faces * kCellCount, out_.leaves.size() - 1, out_.entries.size()};
    for (const Piece& piece : pieces) {
      places.push_back(next);
      next.block += piece.blocks.size();
      next.leaf += piece.leaves.size() - 1;  // all pieces share leaf 0
      next.entry += piece.entries.size();
    }
    out_.grid.resize(next.block);
    out_.leaves.resize(next.leaf + 1);
    out_.entries.resize(next.entry);
    parallel_for(pieces.size(), threads,
                 [&](size_t r) { write(pieces[r], cell_of_root(view.cells, r), places[r]); });
  }

 private:
  // Where a piece's parts begin; its leaf 1 comes after `leaf`.
  struct Place {
    size_t block, leaf, entry;
  };

  static size_t cell_of_root(uint32_t cells, size_t r) {
    const size_t side = size_t{1} << kRootLevel;
    const size_t in_face = r % kRootCount;
    return cells + (r / kRootCount) * kCellCount + (in_face / side * kRootCells << kTopLevel) +
           in_face % side * kRootCells;
  }

  void write(const Piece& piece, size_t first_cell, const Place& place) {
    for (size_t y = 0; y < kRootCells; ++y) {
      for (size_t x = 0; x < kRootCells; ++x) {
        out_.grid[first_cell + (y << kTopLevel) + x] =
            piece.cells[y * kRootCells + x] + (static_cast<uint32_t>(place.block) << kDepthBits);
      }
    }
    std::ranges::transform(piece.blocks, out_.grid.begin() + static_cast<ptrdiff_t>(place.block),
                           [&](uint32_t leaf) { return leaf == 0 ? 0 : leaf + static_cast<uint32_t>(place.leaf); });
    for (size_t n = 1; n < piece.leaves.size(); ++n) {
      Leaf& leaf = out_.leaves[place.leaf + n];
      leaf = piece.leaves[n];
      leaf.first += static_cast<uint32_t>(place.entry);
    }
    std::ranges::copy(piece.entries, out_.entries.begin() + static_cast<ptrdiff_t>(place.entry));
  }

  LightBuffer& out_;
};

double surface_of(const scenes::WorldMesh& mesh) {
  double twice = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    twice += glm::length(glm::cross(b - a, c - a));
  }
  return std::max(0.5 * twice, 1e-30);
}

// Zero if more is used than there is.
uint64_t difference(uint64_t whole, uint64_t used) { return whole > used ? whole - used : 0; }

// A build of all lights, one after the other, as their footprints are large: first to survey, then to build. Those of the
// first lights are kept in between, as far as the memory goes that their parts of the buffer will take.
class Building {
 public:
  Building(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds, std::span<const exact::TracedLight> lights,
           const BuildSettings& settings)
      : mesh_(mesh),
        bounds_(bounds),
        lights_(lights),
        settings_(settings),
        surface_(surface_of(mesh)),
        threads_(settings.threads != 0 ? settings.threads : std::max(1u, std::thread::hardware_concurrency())),
        budget_(settings.budget_bytes != 0 ? settings.budget_bytes : default_budget(lights.size())),
        kept_(lights.size()) {}

  LightBuffer run() {
    LightBuffer buffer;
    // Memory that nothing is written to costs nothing: this spares copies, as the arrays grow light by light.
    buffer.grid.reserve((cell_bytes(0) + budget_ / 4) / sizeof(uint32_t));
    buffer.leaves.reserve(budget_ / 2 / sizeof(Leaf));
    buffer.entries.reserve(budget_ / sizeof(ListEntry));
    Assembly assembly(buffer);
    const DetailSurvey survey = surveyed();
    for (size_t l = 0; l < lights_.size() && !settings_.stop.stop_requested(); ++l) {
      if (l > 0) progress(l, 0);
      const std::unique_ptr<LightBuild> build = kept_[l] ? std::move(kept_[l]) : light(l);
      const Detail detail = survey.fitting(l, {difference(budget_, buffer.memory_bytes() + cell_bytes(l)),
                                               difference(settings_.most_work, buffer.statistics.work)});
      const double before = l == 0 ? kSurveyShare : 0;
      std::vector<Piece> pieces =
          build->pieces(detail, [&](double share) { progress(l, before + (1 - before) * share); });
      build->shrink(pieces, detail, bytes_left(survey, detail, l, buffer.memory_bytes()));
      if (settings_.stop.stop_requested()) break;  // some pieces are missing
      buffer.statistics.work += size_of(pieces).work;
      assembly.add(build->view(), build->face_count(), pieces, threads_);
      progress(l, 1);
    }
    return buffer;
  }

 private:
  static constexpr double kSurveyShare = 0.3;  // of the first light's progress: the survey of all lights

  void progress(size_t l, double share) const {
    if (settings_.progress) settings_.progress(l, share);
  }

  std::unique_ptr<LightBuild> light(size_t l) const {
    return std::make_unique<LightBuild>(mesh_, surface_, bounds_, lights_[l], threads_, settings_.stop);
  }

  // Of the lights from the l-th on.
  uint64_t cell_bytes(size_t l) const {
    uint64_t cells = 0;
    for (const exact::TracedLight& light : lights_.subspan(l)) cells += light.kind == 2 ? 1 : 6;
    return cells * kCellCount * sizeof(uint32_t);
  }

  DetailSurvey surveyed() {
    uint64_t room = budget_;
    DetailSurvey survey(settings_.detail, {difference(budget_, cell_bytes(0)), settings_.most_work});
    for (size_t l = 0; l < lights_.size() && !settings_.stop.stop_requested(); ++l) {
      progress(0, kSurveyShare * static_cast<double>(l) / static_cast<double>(lights_.size()));
      std::unique_ptr<LightBuild> build = light(l);
      survey.add(*build);
      if (build->memory_bytes() > room) continue;
      room -= build->memory_bytes();
      kept_[l] = std::move(build);
    }
    return survey;
  }

  // What the l-th light's pieces may take if earlier ones took `used`. What the survey expects of later ones stays
  // free, less a part, as some of them will take less; the last light has to fit.
  uint64_t bytes_left(const DetailSurvey& survey, const Detail& detail, size_t l, uint64_t used) const {
    constexpr double kKept = 0.9;
    double later = 0;
    for (size_t k = l + 1; k < lights_.size(); ++k) later += kKept * static_cast<double>(survey.bytes(k, detail));
    return difference(budget_, used + cell_bytes(l) + static_cast<uint64_t>(later));
  }

  const scenes::WorldMesh& mesh_;
  const scenes::Bounds& bounds_;
  const std::span<const exact::TracedLight> lights_;
  const BuildSettings& settings_;
  const double surface_;
  const unsigned threads_;
  const uint64_t budget_;
  std::vector<std::unique_ptr<LightBuild>> kept_;  // of lights that are surveyed and not yet built
};

void count(LightBuffer& buffer) {
  Statistics& s = buffer.statistics;
  s.bytes = buffer.memory_bytes();
  s.leaves = buffer.leaves.size();
  s.entries = buffer.entries.size();
  for (const Leaf& leaf : buffer.leaves)
    s.longest_list = std::max(s.longest_list, leaf.count & ((1u << kCountBits) - 1));
}

}  // namespace

uint64_t default_budget(size_t lights, uint64_t room) {
  constexpr uint64_t kMebi = 1 << 20;
  return std::max(std::min<uint64_t>(512, 160 + 32 * static_cast<uint64_t>(lights)) * kMebi,
                  std::min(room, 1280 * kMebi));
}

LightBuffer build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                  std::span<const exact::TracedLight> lights, const BuildSettings& settings) {
  const TimePoint start = Clock::now();
  LightBuffer buffer = Building(mesh, bounds, lights, settings).run();
  count(buffer);
  buffer.statistics.build_seconds = to_seconds(Clock::now() - start);
  return buffer;
}

}  // namespace gnomon::gpu::light_buffer
