#include "gpu/tracers/light_buffer/builder.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <thread>

#include "common/clock.h"
#include "common/parallel.h"

namespace gnomon::gpu::light_buffer {
namespace {

constexpr size_t kChunk = 4096;  // triangles whose footprints one call of parallel_for's body computes

// One light's footprints, face by face.
using Footprints = std::vector<std::vector<Footprint>>;

// One root square and the footprints that may meet it.
struct Root {
  size_t face = 0;
  uint32_t i = 0, j = 0;
  std::vector<const Footprint*> met;
};

class LightBuild {
 public:
  LightBuild(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds, const exact::TracedLight& light,
             unsigned threads, std::stop_token stop)
      : mesh_(mesh), light_(light), faces_(light_faces(light, bounds)), threads_(threads), stop_(std::move(stop)) {
    for (size_t f = 0; f < faces_.faces.size(); ++f) {
      footprints_.push_back(faces_.used[f] ? footprints(faces_.faces[f]) : std::vector<Footprint>());
      add_roots(f);
    }
    for (const Root& root : roots_) met_by_all_ += root.met.size();
    // Roots with many footprints come first, so that no thread starts one of them at the end.
    order_.resize(roots_.size());
    std::iota(order_.begin(), order_.end(), size_t{0});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](size_t a, size_t b) { return roots_[a].met.size() > roots_[b].met.size(); });
  }

  size_t face_count() const { return faces_.faces.size(); }
  const LightView& view() const { return faces_.view; }

  // Builds one root in `stride`; the pieces are in the order of the faces, and those of the other roots stay empty.
  // `progress`, if any, is called on the calling thread with the share of the footprints that were processed.
  std::vector<Piece> pieces(const Detail& detail, size_t stride,
                            const std::function<void(double)>& progress = {}) const {
    std::vector<Piece> pieces(roots_.size());
    const std::thread::id caller = std::this_thread::get_id();
    std::atomic<size_t> met{0};
    parallel_for(order_.size(), threads_, [&](size_t n) {
      const size_t r = order_[n];
      if ((r + r / 16 * 5) % stride != 0) return;  // spread over rows and columns
      if (stop_.stop_requested()) return;
      const Root& root = roots_[r];
      pieces[r] = build_piece(faces_.faces[root.face], detail, root.i, root.j, root.met);
      const size_t so_far = met += root.met.size();
      if (progress && std::this_thread::get_id() == caller)
        progress(static_cast<double>(so_far) / static_cast<double>(std::max<size_t>(met_by_all_, 1)));
    });
    return pieces;
  }

  bool stopped() const { return stop_.stop_requested(); }

 private:
  // Whether the triangle is within the light's range, so that it may block one of its segments.
  bool reaches(const std::array<glm::dvec3, 3>& corners) const {
    if (light_.kind == 2 || light_.reach == 0.0f) return true;
    const glm::dvec3 low = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::dvec3 high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    const glm::dvec3 nearest = glm::clamp(glm::dvec3(0.0), low, high);
    return glm::length(nearest) <= 1.001 * light_.reach;
  }

  std::vector<Footprint> footprints(const Face& face) const {
    const size_t count = mesh_.triangles.size();
    std::vector<std::vector<Footprint>> chunks((count + kChunk - 1) / kChunk);
    parallel_for(chunks.size(), threads_, [&](size_t c) {
      if (stop_.stop_requested()) return;
      for (size_t t = c * kChunk; t < std::min(count, (c + 1) * kChunk); ++t) {
        std::array<glm::dvec3, 3> corners;
        for (int k = 0; k < 3; ++k) {
          corners[static_cast<size_t>(k)] = glm::dvec3(mesh_.positions[mesh_.triangles[t][k]]) - faces_.reference;
        }
        if (!reaches(corners)) continue;
        std::optional<Footprint> f = footprint(face, faces_.diameter, corners);
        if (!f || !meets(*f, face.square(0, 0, 0))) continue;
        f->triangle = static_cast<uint32_t>(t);
        f->can_cover = f->can_cover && t < mesh_.opaque_count;
        chunks[c].push_back(*f);
      }
    });
    std::vector<Footprint> all;
    for (const std::vector<Footprint>& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
    return all;
  }

  void add_roots(size_t f) {
    const Face& face = faces_.faces[f];
    const size_t first = roots_.size();
    for (uint32_t r = 0; r < kRootCount; ++r) {
      roots_.push_back({f, r % (1u << kRootLevel), r >> kRootLevel, {}});
    }
    for (const Footprint& footprint : footprints_[f]) {
      const auto [i0, i1] = root_span(footprint.box.u0, footprint.box.u1, face.low_u, face.size);
      const auto [j0, j1] = root_span(footprint.box.v0, footprint.box.v1, face.low_v, face.size);
      for (uint32_t j = j0; j <= j1; ++j) {
        for (uint32_t i = i0; i <= i1; ++i) roots_[first + (j << kRootLevel) + i].met.push_back(&footprint);
      }
    }
  }

  // Root indices of one axis whose squares may meet [low, high].
  static std::pair<uint32_t, uint32_t> root_span(double low, double high, double face_low, double face_size) {
    const double side = 1u << kRootLevel;
    const double first = std::floor((low - face_low) / face_size * side - 0.01);
    const double last = std::floor((high - face_low) / face_size * side + 0.01);
    return {static_cast<uint32_t>(std::clamp(first, 0.0, side - 1)),
            static_cast<uint32_t>(std::clamp(last, 0.0, side - 1))};
  }

  const scenes::WorldMesh& mesh_;
  const exact::TracedLight& light_;
  const LightFaces faces_;
  const unsigned threads_;
  const std::stop_token stop_;
  Footprints footprints_;
  std::vector<Root> roots_;
  size_t met_by_all_ = 0;
  std::vector<size_t> order_;
};

uint64_t bytes_of(const std::vector<Piece>& pieces) {
  uint64_t bytes = 0;
  for (const Piece& p : pieces) {
    bytes +=
        p.blocks.size() * sizeof(uint32_t) + p.leaves.size() * sizeof(Leaf) + p.entries.size() * sizeof(ListEntry);
  }
  return bytes;
}

// A coarser detail, which takes about a fifth less memory. Long lists are still divided, because they cost most.
Detail coarser(Detail detail) {
  detail.longest_walk *= 1.4;
  return detail;
}

// The pieces of the finest detail that fits into `bytes`, without the cells. After kMostSteps steps the result may be
// larger.
std::vector<Piece> fitting_pieces(const LightBuild& build, Detail detail, uint64_t bytes,
                                  const std::function<void(double)>& progress) {
  constexpr size_t kStride = 16;
  constexpr int kMostSteps = 12;
  int step = 0;
  while (step < kMostSteps && bytes_of(build.pieces(detail, kStride)) * kStride > bytes) {
    detail = coarser(detail);
    ++step;
  }
  std::vector<Piece> pieces = build.pieces(detail, 1, progress);
  for (; step < kMostSteps && bytes_of(pieces) > bytes && !build.stopped(); ++step) {
    detail = coarser(detail);
    pieces = build.pieces(detail, 1, progress);
  }
  return pieces;
}

class Assembly {
 public:
  explicit Assembly(LightBuffer& out) : out_(out) { out_.leaves.resize(1); }

  void add(LightView view, size_t faces, const std::vector<Piece>& pieces) {
    view.cells = static_cast<uint32_t>(out_.grid.size());
    out_.lights.push_back(view);
    out_.grid.resize(out_.grid.size() + faces * kCellCount);
    for (size_t r = 0; r < pieces.size(); ++r) append(pieces[r], cell_of_root(view.cells, r));
  }

 private:
  static size_t cell_of_root(uint32_t cells, size_t r) {
    const size_t side = size_t{1} << kRootLevel;
    const size_t in_face = r % kRootCount;
    return cells + (r / kRootCount) * kCellCount + (in_face / side * kRootCells << kTopLevel) +
           in_face % side * kRootCells;
  }

  void append(const Piece& piece, size_t first_cell) {
    const uint32_t block_base = static_cast<uint32_t>(out_.grid.size());
    const uint32_t leaf_base = static_cast<uint32_t>(out_.leaves.size()) - 1;  // all pieces share leaf 0
    const uint32_t entry_base = static_cast<uint32_t>(out_.entries.size());
    for (size_t y = 0; y < kRootCells; ++y) {
      for (size_t x = 0; x < kRootCells; ++x) {
        out_.grid[first_cell + (y << kTopLevel) + x] = piece.cells[y * kRootCells + x] + (block_base << kDepthBits);
      }
    }
    for (const uint32_t leaf : piece.blocks) out_.grid.push_back(leaf == 0 ? 0 : leaf + leaf_base);
    for (size_t n = 1; n < piece.leaves.size(); ++n) {
      out_.leaves.push_back(piece.leaves[n]);
      out_.leaves.back().first += entry_base;
    }
    out_.entries.insert(out_.entries.end(), piece.entries.begin(), piece.entries.end());
  }

  LightBuffer& out_;
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

uint64_t default_budget(size_t lights) {
  return std::min<uint64_t>(512, 160 + 32 * static_cast<uint64_t>(lights)) << 20;
}

LightBuffer build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                  std::span<const exact::TracedLight> lights, const BuildSettings& settings) {
  const TimePoint start = Clock::now();
  const uint64_t budget = settings.budget_bytes != 0 ? settings.budget_bytes : default_budget(lights.size());
  const unsigned threads =
      settings.threads != 0 ? settings.threads : std::max(1u, std::thread::hardware_concurrency());
  LightBuffer buffer;
  Assembly assembly(buffer);
  for (size_t l = 0; l < lights.size(); ++l) {
    const auto progress = [&](double share) {
      if (settings.progress) settings.progress(l, share);
    };
    progress(0);
    const LightBuild build(mesh, bounds, lights[l], threads, settings.stop);
    // The remaining lights share the part of the budget that earlier lights did not use.
    const uint64_t cells = build.face_count() * kCellCount * sizeof(uint32_t);
    const uint64_t used = buffer.memory_bytes();
    const uint64_t share = budget > used ? (budget - used) / (lights.size() - l) : 0;
    const std::vector<Piece> pieces =
        fitting_pieces(build, settings.detail, share > cells ? share - cells : 0, progress);
    if (settings.stop.stop_requested()) break;  // some pieces are missing
    assembly.add(build.view(), build.face_count(), pieces);
    progress(1);
  }
  count(buffer);
  buffer.statistics.build_seconds = to_seconds(Clock::now() - start);
  return buffer;
}

}  // namespace gnomon::gpu::light_buffer
