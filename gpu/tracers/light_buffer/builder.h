// Builds a scene's light buffers from its triangles and lights.
#pragma once

#include <functional>
#include <span>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "gpu/tracers/light_buffer/subdivide.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu::light_buffer {

struct BuildSettings {
  Detail detail;              // as fine as it may become
  uint64_t budget_bytes = 0;  // of the whole scene; coarser detail is taken until it is kept. 0: default_budget
  unsigned threads = 0;       // 0: as many as the machine has
  // Called now and then with the share that is done, 0 to 1; from the calling thread.
  std::function<void(double)> progress;
};

// What a scene of so many lights may take where nothing else is said.
uint64_t default_budget(size_t lights);

// The same input gives the same bytes, whatever the number of threads. `bounds`: of the mesh.
LightBuffer build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                  std::span<const exact::TracedLight> lights, const BuildSettings& settings);

}  // namespace gnomon::gpu::light_buffer
