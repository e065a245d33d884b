// Embree over a scene's world mesh: the independent oracle of the tests and the peer of the benchmarks. It answers for
// the same shadow segments as our tracers, made from the same surface points, and packs the same tile words.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "scenes/scene.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::test {

enum class EmbreeQuery {
  single,     // rtcOccluded1, robust: the oracle
  packets16,  // rtcOccluded16 with coherent 4x4-pixel packets: the fastest that Embree offers
};

class EmbreeOracle {
 public:
  // `robust`: watertight, as an oracle must be; a peer is faster without.
  EmbreeOracle(scenes::ScenePtr scene, bool robust);
  ~EmbreeOracle();
  EmbreeOracle(const EmbreeOracle&) = delete;
  EmbreeOracle& operator=(const EmbreeOracle&) = delete;

  // Tile words of a frame whose surface points are `samples`, row by row; on `threads` threads.
  std::vector<uint64_t> trace(const gpu::CameraView& camera, const TileGrid& grid,
                              std::span<const gpu::SurfaceSample> samples, EmbreeQuery query,
                              unsigned threads) const;

  // How many of `samples` points of each light the surfaces of a soft frame see, light by light and row by row; nothing of
  // pairs that are not asked. On `threads` threads.
  std::vector<std::optional<uint32_t>> count(const gpu::CameraView& camera, const TileGrid& grid,
                                             std::span<const gpu::SurfaceSample> surfaces, uint32_t samples,
                                             unsigned threads) const;

  // Is anything between the two points?
  bool occluded(glm::vec3 from, glm::vec3 to) const;

  double build_seconds() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace gnomon::test
