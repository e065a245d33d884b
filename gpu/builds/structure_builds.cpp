#include "gpu/builds/structure_builds.h"

#include <algorithm>
#include <new>
#include <thread>

namespace gnomon::gpu {
namespace {

const char* const kNoMemory = "there is not enough memory to build what traces it";

class BuildsHere : public StructureBuilds {
 public:
  Result<Bvh> bvh(const scenes::WorldMesh& mesh) const override {
    try {
      return build_bvh(mesh, std::max(1u, std::thread::hardware_concurrency()));
    } catch (const std::bad_alloc&) {
      return Error{kNoMemory};
    }
  }

  Result<light_buffer::LightBuffer> light_buffer(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                                                 std::span<const exact::TracedLight> lights,
                                                 const light_buffer::BuildSettings& settings) const override {
    try {
      auto built = light_buffer::build(mesh, bounds, lights, settings);
      if (settings.stop.stop_requested()) return Error{"the build was stopped"};
      return built;
    } catch (const std::bad_alloc&) {
      return Error{kNoMemory};
    }
  }
};

}  // namespace

StructureBuildsPtr builds_here() { return std::make_shared<const BuildsHere>(); }

}  // namespace gnomon::gpu
