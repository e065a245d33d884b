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
  Detail detail;              // as fine as it may become
  uint64_t budget_bytes = 0;  // of the whole scene; coarser detail is taken until it is kept. 0: default_budget
  unsigned threads = 0;       // 0: as many as the machine has
  // Called now and then with a light's number and the share of its work that is done, 0 to 1; from the calling thread.
  std::function<void(size_t light, double share)> progress;
  std::stop_token stop;  // once stopped, build returns soon
};

// What a scene of so many lights may take where nothing else is said.
uint64_t default_budget(size_t lights);

// The same input gives the same bytes, whatever the number of threads. `bounds`: of the mesh. What it returns after
// settings.stop was asked to stop is incomplete and of no use.
LightBuffer build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                  std::span<const exact::TracedLight> lights, const BuildSettings& settings);

}  // namespace gnomon::gpu::light_buffer
