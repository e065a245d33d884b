#include "gpu/builds/structure_builds.h"

#include <algorithm>
#include <thread>

#include "common/within_memory.h"

namespace gnomon::gpu {
namespace {

class BuildsHere : public StructureBuilds {
 public:
  Result<Bvh> bvh(const scenes::WorldMesh& mesh) const override {
    return within_memory(
        [&]() -> Result<Bvh> { return build_bvh(mesh, std::max(1u, std::thread::hardware_concurrency())); });
  }

  Result<light_buffer::LightBuffer> light_buffer(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                                                 std::span<const exact::TracedLight> lights,
                                                 const light_buffer::BuildSettings& settings) const override {
    return within_memory([&]() -> Result<light_buffer::LightBuffer> {
      auto built = light_buffer::build(mesh, bounds, lights, settings);
      if (settings.stop.stop_requested()) return Error{"the build was stopped"};
      return built;
    });
  }
};

}  // namespace

StructureBuildsPtr builds_here() { return std::make_shared<const BuildsHere>(); }

}  // namespace gnomon::gpu
