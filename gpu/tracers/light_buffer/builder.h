// Builds a scene's light buffers from its triangles and lights.
#pragma once

#include <functional>
#include <span>
#include <stop_token>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "gpu/tracers/light_buffer/subdivide.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu::light_buffer {

struct BuildSettings {
  Detail detail;  // the finest detail
  // For the complete scene; coarser detail is used to keep it. 0: default_budget. While it runs, a build takes as much again
  // for what it builds from, and more where a single light needs that.
  uint64_t budget_bytes = 0;
  // For the complete scene, as Piece::work counts it: some ten seconds of two cores. Coarser detail is used to keep it,
  // as far as work can be estimated beforehand.
  uint64_t most_work = 400'000'000;
  unsigned threads = 0;  // 0: one for each hardware thread
  // Called repeatedly on the calling thread with a light's number and the share of its work that is done, 0 to 1.
  std::function<void(size_t light, double share)> progress;
  std::stop_token stop;  // once stopped, build returns soon
};

// The memory budget of a scene with so many lights, in bytes, if none is configured: what that many lights should have, or
// `room`, if that is more, up to 1,280 MiB.
uint64_t default_budget(size_t lights, uint64_t room = 0);

// Blocking. The same input gives the same bytes, whatever the number of threads. `bounds`: of the mesh. After a request
// to stop, the result is incomplete and must be discarded.
LightBuffer build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                  std::span<const exact::TracedLight> lights, const BuildSettings& settings);

}  // namespace gnomon::gpu::light_buffer
