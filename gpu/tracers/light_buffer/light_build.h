// One light's part of a build: its footprints, sorted into the roots of its faces, and the pieces that are made of them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/face.h"
#include "gpu/tracers/light_buffer/footprint.h"
#include "gpu/tracers/light_buffer/subdivide.h"
#include "gpu/tracers/light_buffer/survey.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu::light_buffer {

PiecesSize size_of(const std::vector<Piece>& pieces);

class LightBuild {
 public:
  // The mesh and the light outlive this. `surface`: the area of the mesh's triangles.
  LightBuild(const scenes::WorldMesh& mesh, double surface, const scenes::Bounds& bounds,
             const exact::TracedLight& light, unsigned threads, std::stop_token stop);

  size_t face_count() const { return faces_.faces.size(); }
  const LightView& view() const { return faces_.view; }
  uint64_t memory_bytes() const;
  bool stopped() const { return stop_.stop_requested(); }

  // In the order of the faces. `progress`, if any, is called on the calling thread with the share of the footprints that
  // were processed.
  std::vector<Piece> pieces(const Detail& detail, const std::function<void(double)>& progress = {}) const;

  // Makes pieces that were made with `detail` anew and coarser, no more of them than it takes, until all have at most
  // `bytes`, or until none can be coarser.
  void shrink(std::vector<Piece>& pieces, Detail detail, uint64_t bytes) const;

  // What the pieces would take at each threshold of Detail::cost_per_byte, estimated from some of them. `limits`: of each
  // threshold; the last of those that are returned is the last one within its limit, or the first of all.
  std::vector<PiecesSize> expected_sizes(std::span<const double> thresholds, uint32_t finest_level,
                                         std::span<const PiecesSize> limits) const;

 private:
  // Footprints of neighbouring triangles, all of one kind, so that threads make and memory holds them apart.
  struct Chunk {
    std::vector<Footprint> points;
    std::vector<AreaFootprint> areas;
  };

  // One root square and the footprints that may meet it.
  struct Root {
    size_t face = 0;
    uint32_t i = 0, j = 0;
    std::vector<const Footprint*> met;
  };

  bool reaches(const std::array<glm::dvec3, 3>& corners) const;
  // Pieces with many footprints first, until those of `size` bytes have at most `bytes`; what they have then.
  uint64_t rebuild(std::vector<Piece>& pieces, const Detail& detail, uint64_t size, uint64_t bytes) const;
  void add_footprints();
  void add_footprint(const Face& face, const std::array<glm::dvec3, 3>& corners, size_t triangle,
                     Chunk& chunk) const;
  // Lists the footprints that may meet each of the face's roots.
  void fill_roots(size_t face);
  // The numbers of all roots, those first whose queries cost most if nothing is divided.
  std::vector<size_t> by_cost() const;
  Piece piece(const Root& root, const Detail& detail) const;

  const scenes::WorldMesh& mesh_;
  const double surface_;
  const exact::TracedLight& light_;
  const LightFaces faces_;
  const unsigned threads_;
  const std::stop_token stop_;
  std::vector<std::vector<Chunk>> footprints_;  // face by face
  std::vector<Root> roots_;
  size_t met_by_all_ = 0;
  std::vector<size_t> order_;  // roots with many footprints first
};

}  // namespace gnomon::gpu::light_buffer
