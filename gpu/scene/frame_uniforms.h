// The uniforms of one frame, as shaders/frame.glsl declares them (scalar block layout).
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "gpu/exact_cpp.h"
#include "gpu/renderer.h"

namespace gnomon::gpu {

// Device addresses of a resident scene's buffers.
struct SceneAddresses {
  uint64_t positions = 0;           // vec3 for each vertex
  uint64_t normals = 0;             // vec3 for each vertex; 0: not resident
  uint64_t uvs = 0;                 // vec2 for each vertex
  uint64_t triangles = 0;           // uvec3 for each triangle
  uint64_t triangle_materials = 0;  // uint for each triangle
  uint64_t materials = 0;           // MaterialRecord for each material
};

struct MaterialRecord {
  glm::vec4 base_color{1.0f};
  glm::vec3 emissive{0.0f};
  float alpha_cutoff = 0.0f;
  uint64_t texels = 0;  // uint RGBA8 for each texel, its colour as the square root of the linear one; 0: no texture
  uint32_t texture_width = 0, texture_height = 0;
  uint32_t wrap_u = 0, wrap_v = 0;  // scenes::Wrap
  uint32_t levels = 1;  // mip levels, one behind the other in `texels`; each half the size, rounded down
  uint32_t reserved = 0;
};
static_assert(sizeof(MaterialRecord) == 64);

inline constexpr uint32_t kLeftOut = UINT32_MAX;

struct FrameUniforms {
  glm::mat4 camera_to_clip{1.0f};  // of points relative to the camera's position, in world axes
  glm::vec3 camera{0.0f};
  uint32_t width = 0;
  glm::vec3 forward{0.0f};
  uint32_t height = 0;
  // The ray through the centre of pixel (x, y): ray_corner + (x + 0.5) * ray_dx + (y + 0.5) * ray_dy. Its component
  // along `forward` is 1.
  glm::vec3 ray_corner{0.0f};
  uint32_t tiles_x = 0;
  glm::vec3 ray_dx{0.0f};
  uint32_t tile_count = 0;
  glm::vec3 ray_dy{0.0f};
  uint32_t light_count = 0;
  SceneAddresses scene;
  exact::TracedLight lights[kMaxLights];
  // Of each light's masks, the first (common/light_planes.h); kLeftOut: a later pass traces the light.
  uint32_t planes[kMaxLights];
  uint32_t resting_triangles = 0;  // the numbers of what moves follow
};
static_assert(sizeof(exact::TracedLight) == 40);
static_assert(offsetof(FrameUniforms, scene) == 144);
static_assert(offsetof(FrameUniforms, lights) == 192);
static_assert(sizeof(FrameUniforms) <= 16384, "the least maxUniformBufferRange");

// Sets the members that depend on the camera and on the size of the picture.
void set_view(FrameUniforms& frame, const CameraView& view, uint32_t width, uint32_t height);

}  // namespace gnomon::gpu
