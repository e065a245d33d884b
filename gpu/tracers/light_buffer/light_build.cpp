#include "gpu/tracers/light_buffer/light_build.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <thread>

#include "common/parallel.h"

namespace gnomon::gpu::light_buffer {
namespace {

constexpr size_t kChunk = 4096;  // triangles whose footprints one call of parallel_for's body computes

// Root indices of one axis whose squares may meet [low, high].
std::pair<uint32_t, uint32_t> root_span(double low, double high, double face_low, double face_size) {
  const double side = 1u << kRootLevel;
  const double first = std::floor((low - face_low) / face_size * side - 0.01);
  const double last = std::floor((high - face_low) / face_size * side + 0.01);
  return {static_cast<uint32_t>(std::clamp(first, 0.0, side - 1)),
          static_cast<uint32_t>(std::clamp(last, 0.0, side - 1))};
}

uint64_t bytes_of(const Piece& p) {
  return p.blocks.size() * sizeof(uint32_t) + p.leaves.size() * sizeof(Leaf) + p.entries.size() * sizeof(ListEntry);
}

}  // namespace

PiecesSize size_of(const std::vector<Piece>& pieces) {
  PiecesSize size;
  for (const Piece& p : pieces) {
    size.bytes += bytes_of(p);
    size.work += p.work;
  }
  return size;
}

LightBuild::LightBuild(const scenes::WorldMesh& mesh, double surface, const scenes::Bounds& bounds,
                       const exact::TracedLight& light, unsigned threads, std::stop_token stop)
    : mesh_(mesh),
      surface_(surface),
      light_(light),
      faces_(light_faces(light, bounds)),
      threads_(threads),
      stop_(std::move(stop)) {
  add_footprints();
  for (size_t f = 0; f < faces_.faces.size(); ++f)
    for (uint32_t r = 0; r < kRootCount; ++r) roots_.push_back({f, r % (1u << kRootLevel), r >> kRootLevel, {}});
  parallel_for(faces_.faces.size(), threads_, [&](size_t f) { fill_roots(f); });
  for (const Root& root : roots_) met_by_all_ += root.met.size();
  // Roots with many footprints come first, so that no thread starts one of them at the end.
  order_.resize(roots_.size());
  std::iota(order_.begin(), order_.end(), size_t{0});
  std::stable_sort(order_.begin(), order_.end(),
                   [&](size_t a, size_t b) { return roots_[a].met.size() > roots_[b].met.size(); });
}

uint64_t LightBuild::memory_bytes() const {
  uint64_t bytes = 0;
  const auto add = [&](const auto& list) { bytes += std::as_bytes(std::span(list)).size(); };
  for (const Root& root : roots_) add(root.met);
  for (const std::vector<Chunk>& chunks : footprints_) {
    for (const Chunk& chunk : chunks) {
      add(chunk.points);
      add(chunk.areas);
    }
  }
  return bytes;
}

Piece LightBuild::piece(const Root& root, const Detail& detail) const {
  return build_piece(faces_.faces[root.face], detail, surface_, root.i, root.j, root.met);
}

std::vector<Piece> LightBuild::pieces(const Detail& detail, const std::function<void(double)>& progress) const {
  std::vector<Piece> pieces(roots_.size());
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<size_t> met{0};
  parallel_for(order_.size(), threads_, [&](size_t n) {
    if (stopped()) return;
    const Root& root = roots_[order_[n]];
    pieces[order_[n]] = piece(root, detail);
    const size_t so_far = met += root.met.size();
    if (progress && std::this_thread::get_id() == caller)
      progress(static_cast<double>(so_far) / static_cast<double>(std::max<size_t>(met_by_all_, 1)));
  });
  return pieces;
}

void LightBuild::shrink(std::vector<Piece>& pieces, Detail detail, uint64_t bytes) const {
  constexpr double kCoarser = 2.0, kCoarsest = 1e3;  // at which nothing is divided
  uint64_t size = size_of(pieces).bytes;
  for (bool first = true; size > bytes && detail.cost_per_byte < kCoarsest; first = false) {
    detail.cost_per_byte *= kCoarser;
    size = rebuild(pieces, detail, size, bytes);
    if (stopped()) return;
    if (!first || size <= bytes) continue;
    // Once a step was not enough: where not even the last one will be, there is no need to go step by step.
    Detail last = detail;
    last.cost_per_byte = kCoarsest;
    std::vector<Piece> coarsest = this->pieces(last);
    if (stopped() || size_of(coarsest).bytes <= bytes) continue;
    pieces = std::move(coarsest);
    return;
  }
}

uint64_t LightBuild::rebuild(std::vector<Piece>& pieces, const Detail& detail, uint64_t size,
                             uint64_t bytes) const {
  constexpr size_t kAtOnce = 64;
  for (size_t first = 0; first < order_.size() && size > bytes && !stopped(); first += kAtOnce) {
    const size_t count = std::min(kAtOnce, order_.size() - first);
    for (size_t n = first; n < first + count; ++n) size -= bytes_of(pieces[order_[n]]);
    parallel_for(count, threads_,
                 [&](size_t n) { pieces[order_[first + n]] = piece(roots_[order_[first + n]], detail); });
    for (size_t n = first; n < first + count; ++n) size += bytes_of(pieces[order_[n]]);
  }
  return size;
}

std::vector<size_t> LightBuild::by_cost() const {
  std::vector<double> costs(roots_.size());
  parallel_for(roots_.size(), threads_, [&](size_t r) {
    const Root& root = roots_[r];
    const Face& face = faces_.faces[root.face];
    costs[r] = Squares(face, surface_).rough_cost(face.square(kRootLevel, root.i, root.j), root.met);
  });
  std::vector<size_t> order = order_;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return costs[a] > costs[b]; });
  return order;
}

std::vector<PiecesSize> LightBuild::expected_sizes(std::span<const double> thresholds, uint32_t finest_level,
                                                   std::span<const PiecesSize> limits) const {
  // By what their queries cost undivided, neighbours are alike, and one of a few stands for them, with a quarter of it.
  // Those that cost most stand for themselves: most of the memory often goes to a few.
  constexpr size_t kAlone = 64, kStep = 32, kMost = 8, kFew = 256;  // kFew: roots of a single face
  const std::vector<size_t> order = by_cost();
  struct Stratum {
    size_t first, count;
  };
  std::vector<Stratum> strata;
  for (size_t first = 0; first < order.size(); first += strata.back().count) {
    const size_t count = first < kAlone ? 1 : std::min(first / kStep, kMost);
    strata.push_back({first, std::min(count, order.size() - first)});
  }
  SurveySteps steps(thresholds, {limits.begin(), limits.end()});
  parallel_for(strata.size(), threads_, [&](size_t n) {
    if (stopped()) return;
    const Root& root = roots_[order[strata[n].first + strata[n].count / 2]];
    PieceSample sample{root.i, root.j, static_cast<double>(strata[n].count), std::nullopt};
    if (order.size() > kFew) sample.quarter = static_cast<uint32_t>(n % 4);
    survey_piece(faces_.faces[root.face], surface_, finest_level, sample, root.met, steps);
  });
  return steps.sums();
}

// Whether the triangle is within the light's range, so that it may block one of its segments.
bool LightBuild::reaches(const std::array<glm::dvec3, 3>& corners) const {
  if (light_.kind == 2 || light_.reach == 0.0f) return true;
  const glm::dvec3 low = glm::min(corners[0], glm::min(corners[1], corners[2]));
  const glm::dvec3 high = glm::max(corners[0], glm::max(corners[1], corners[2]));
  const glm::dvec3 nearest = glm::clamp(glm::dvec3(0.0), low, high);
  return glm::length(nearest) <= 1.001 * light_.reach + light_.radius;
}

void LightBuild::add_footprints() {
  const size_t count = mesh_.triangles.size(), chunks = (count + kChunk - 1) / kChunk;
  const bool directional = light_.kind == 2;
  footprints_.assign(faces_.faces.size(), std::vector<Chunk>(chunks));
  parallel_for(chunks, threads_, [&](size_t c) {
    if (stopped()) return;
    thread_local std::vector<Chunk> made;  // what lasts takes no more memory than it needs
    made.resize(faces_.faces.size());
    for (size_t t = c * kChunk; t < std::min(count, (c + 1) * kChunk); ++t) {
      std::array<glm::dvec3, 3> corners;
      for (int k = 0; k < 3; ++k) {
        corners[static_cast<size_t>(k)] = glm::dvec3(mesh_.positions[mesh_.triangles[t][k]]) - faces_.reference;
      }
      if (!reaches(corners)) continue;
      const uint32_t met = directional ? 1 : faces_met(faces_.diameter, light_.radius, corners);
      for (size_t f = 0; f < faces_.faces.size(); ++f)
        if (faces_.used[f] && (met >> f & 1) != 0) add_footprint(faces_.faces[f], corners, t, made[f]);
    }
    for (size_t f = 0; f < faces_.faces.size(); ++f) {
      footprints_[f][c] = made[f];
      made[f].points.clear();
      made[f].areas.clear();
    }
  });
}

void LightBuild::add_footprint(const Face& face, const std::array<glm::dvec3, 3>& corners, size_t triangle,
                               Chunk& chunk) const {
  const auto add = [&](auto made, auto& footprints) {
    if (!made || !meets(*made, face.square(0, 0, 0))) return;
    made->triangle = static_cast<uint32_t>(triangle);
    made->can_cover = made->can_cover && triangle < mesh_.opaque_count;
    footprints.push_back(*made);
  };
  if (light_.radius > 0.0f)
    add(area_footprint(face, faces_.diameter, light_.radius, corners), chunk.areas);
  else
    add(footprint(face, faces_.diameter, corners), chunk.points);
}

void LightBuild::fill_roots(size_t f) {
  const Face& face = faces_.faces[f];
  const size_t first = f * kRootCount;
  const auto list = [&](const Footprint& footprint) {
    const auto [i0, i1] = root_span(footprint.box.u0, footprint.box.u1, face.low_u, face.size);
    const auto [j0, j1] = root_span(footprint.box.v0, footprint.box.v1, face.low_v, face.size);
    for (uint32_t j = j0; j <= j1; ++j)
      for (uint32_t i = i0; i <= i1; ++i) roots_[first + (j << kRootLevel) + i].met.push_back(&footprint);
  };
  for (const Chunk& chunk : footprints_[f]) {
    std::ranges::for_each(chunk.points, list);
    std::ranges::for_each(chunk.areas, list);
  }
}

}  // namespace gnomon::gpu::light_buffer
