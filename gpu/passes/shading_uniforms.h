// What shaders/shade.comp reads from the host beside the masks (scalar block layout, resource `shading`).
#pragma once

#include <glm/glm.hpp>

#include "gpu/scene/frame_uniforms.h"

namespace gnomon::gpu {

// The part of a light that colours; the part that casts shadows is exact::TracedLight.
struct LightColour {
  glm::vec3 colour{0.0f};                       // times intensity
  float cone_scale = 0.0f, cone_offset = 1.0f;  // KHR_lights_punctual's lightAngleScale and lightAngleOffset
  uint32_t first_plane = 0;                     // of the masks, and
  uint32_t samples = 1;                         // see common/light_planes.h
  uint32_t number = 0;                          // of an area light, among all that masks count
};

inline constexpr uint32_t kEveryLight = 0xffffffff;

struct ShadingUniforms {
  glm::vec3 ambient_above{0.0f};  // scenes::Surroundings, and what options add
  float exposure = 1.0f;
  glm::vec3 ambient_below{0.0f};
  uint32_t view = 0;  // ShadeOptions::View; 3: linear luminance as float bits
  glm::vec3 background{0.0f};
  uint32_t tonemap = 0;  // ShadeOptions::Tonemap
  glm::vec3 sky_zenith{0.0f};
  uint32_t only_light = kEveryLight;
  glm::vec3 sky_horizon{0.0f};
  uint32_t has_sky = 0;
  glm::vec3 sky_ground{0.0f};
  float sky_clouds = 0.0f;
  uint32_t filter_step = 0;      // 0: counts as they are; else the mean over pixels this far apart
  uint32_t window_step = 1;      // how far apart the pixels of a window are
  uint32_t occlusion = 0;        // Occlusion, of the masks, and
  uint32_t occlusion_plane = 0;  // the first of its planes
  uint32_t occlusion_number = 0;
  uint32_t whole_share = 0;  // kWholeShare if shares are given, gpu/passes/accumulation.h
  LightColour lights[kMaxLights];
};
static_assert(sizeof(LightColour) == 32);
static_assert(offsetof(ShadingUniforms, lights) == 120);

}  // namespace gnomon::gpu
