// What a tracer built for lights, and the lights that it built for.
#pragma once

#include <memory>
#include <vector>

#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {

struct TracedLights {
  std::shared_ptr<const TracedScene> traced;
  std::vector<exact::TracedLight> built_for;
};

}  // namespace gnomon::gpu
