#include "daemon/render/light_importance.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace gnomon::daemon {
namespace {

constexpr glm::vec3 kLuminance{0.2126f, 0.7152f, 0.0722f};  // of linear RGB, ITU-R BT.709
constexpr float kNear = 1;                                  // metres; nearer lights do not count as brighter
constexpr float kStay = 1.5f;                               // advantage of lights that are traced already

// Illuminance at the camera without occlusion and cones, as what the camera sees may be lit where the camera is not.
float importance(const scenes::Light& light, const glm::vec3& camera) {
  const float bright = light.intensity * glm::dot(light.color, kLuminance);
  if (light.type == scenes::LightType::directional) return bright;
  const float distance = std::max(kNear, glm::distance(light.position, camera));
  const bool far_out = light.range > 0 && distance > 2 * light.range;
  return far_out ? 0 : bright / (distance * distance);
}

}  // namespace

gpu::LightSet least_important(std::span<const scenes::Light> lights, const glm::vec3& camera, size_t keep,
                              const gpu::LightSet& left_out) {
  std::vector<float> values(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    values[i] = importance(lights[i], camera) / (left_out[i] ? kStay : 1);
  }
  std::vector<size_t> order(lights.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return values[a] > values[b]; });
  gpu::LightSet least;
  for (size_t i = keep; i < order.size(); ++i) least.set(order[i]);
  return least;
}

}  // namespace gnomon::daemon
