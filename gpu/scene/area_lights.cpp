#include "gpu/scene/area_lights.h"

#include <algorithm>

namespace gnomon::gpu {

AreaLights::AreaLights(const std::vector<scenes::Light>& loaded)
    : lights_(static_cast<uint32_t>(loaded.size())), kept_(loaded.size()) {
  for (size_t i = 0; i < loaded.size(); ++i) set_[i] = loaded[i].area.shape != scenes::LightShape::point;
}

const std::vector<glm::vec3>& AreaLights::offsets(size_t light, const scenes::LightArea& area,
                                                  uint32_t samples) const {
  Kept& kept = kept_[light][samples == kMostSamples ? 1 : 0];
  if (kept.offsets.empty() || kept.area != area) kept = {area, scenes::sample_offsets(area, samples)};
  return kept.offsets;
}

// A point of the light is rounded to the floats about it.
exact::TracedLight with_extent(exact::TracedLight traced, const scenes::LightArea& area) {
  const glm::vec3 far = glm::abs(traced.position);
  traced.radius = 1.0001f * area.reach() + 0x1p-21f * std::max({far.x, far.y, far.z});
  return traced;
}

}  // namespace gnomon::gpu
