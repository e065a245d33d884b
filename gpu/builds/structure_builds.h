// The builds that tracers do on the host before a scene can be traced.
//
// Their time and memory depend on what a scene's file says. They are behind an interface so that the daemon can have
// them done by another process.
#pragma once

#include <memory>
#include <span>

#include "common/result.h"
#include "gpu/builds/bvh.h"
#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/builder.h"

namespace gnomon::gpu {

class StructureBuilds {
 public:
  virtual ~StructureBuilds() = default;

  // Both block, and may be called by any thread. Error: out of memory, or why whoever builds gave up.
  virtual Result<Bvh> bvh(const scenes::WorldMesh& mesh) const = 0;
  // As light_buffer::build. Error: also if it was stopped through the settings.
  virtual Result<light_buffer::LightBuffer> light_buffer(const scenes::WorldMesh& mesh,
                                                         const scenes::Bounds& bounds,
                                                         std::span<const exact::TracedLight> lights,
                                                         const light_buffer::BuildSettings& settings) const = 0;
};

using StructureBuildsPtr = std::shared_ptr<const StructureBuilds>;

// On all cores of this process.
StructureBuildsPtr builds_here();

}  // namespace gnomon::gpu
