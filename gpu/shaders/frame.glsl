// The uniforms of every shader of a frame: the view, the scene's buffers and the lights (gpu/scene/frame_uniforms.h).
#ifndef FRAME_GLSL
#define FRAME_GLSL
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

#define EXACT precise
#define EXACT_FN
#include "exact.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec3s { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec2s { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uvec3s { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uints { uint at[]; };

struct MaterialRecord {
  vec4 base_color;
  vec3 emissive;
  float alpha_cutoff;
  uvec2 texels;  // address of Uints, RGBA8, the colour as its square root; 0: no texture
  uvec2 texture_size;
  uvec2 wrap;    // scenes::Wrap: 0 repeat, 1 mirrored, 2 clamp
  uint levels;
  uint reserved;
};
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Materials { MaterialRecord at[]; };

const uint kMaxLights = 256;
const uint kLeftOut = 0xffffffffu;

layout(set = 0, binding = 0, scalar) uniform Frame {
  mat4 camera_to_clip;
  vec3 camera;
  uint width;
  vec3 forward;
  uint height;
  vec3 ray_corner;
  uint tiles_x;
  vec3 ray_dx;
  uint tile_count;
  vec3 ray_dy;
  uint light_count;
  Vec3s positions;
  Vec3s normals;
  Vec2s uvs;
  Uvec3s triangles;
  Uints triangle_materials;
  Materials materials;
  TracedLight lights[kMaxLights];
  uint planes[kMaxLights];  // of each light's masks, the first; kLeftOut: a later pass traces the light
  uint resting_triangles;   // the others' numbers follow
} frame;

float near_plane() { return frame.camera_to_clip[3][2]; }

// The ray through the centre of the pixel; its component along frame.forward is 1.
vec3 pixel_ray(uvec2 pixel) {
  precise vec3 ray = frame.ray_corner + (float(pixel.x) + 0.5) * frame.ray_dx + (float(pixel.y) + 0.5) * frame.ray_dy;
  return ray;
}

// Nearest texel of level 0: the same rule as scenes::passes_alpha_test.
uint wrap_texel(float u, uint wrap, uint size) {
  precise float within_two = u - 2.0 * floor(0.5 * u);
  precise float repeated = u - floor(u);
  float mirrored = within_two > 1.0 ? 2.0 - within_two : within_two;
  float at = wrap == 2u ? clamp(u, 0.0, 1.0) : wrap == 0u ? repeated : mirrored;
  precise float scaled = at * float(size);
  return min(uint(scaled), size - 1u);
}

uint fetch_texel(MaterialRecord m, uvec2 texel) { return Uints(m.texels).at[texel.y * m.texture_size.x + texel.x]; }

bool passes_alpha_test(uint triangle, vec2 uv) {
  MaterialRecord m = frame.materials.at[frame.triangle_materials.at[triangle]];
  float alpha = m.base_color.a;
  if (m.texels != uvec2(0)) {
    uvec2 texel = uvec2(wrap_texel(uv.x, m.wrap.x, m.texture_size.x), wrap_texel(uv.y, m.wrap.y, m.texture_size.y));
    alpha *= float(fetch_texel(m, texel) >> 24) / 255.0;
  }
  return alpha >= m.alpha_cutoff;
}

// Texture coordinates at barycentric weights of the three corners.
vec2 uv_at(uint triangle, vec3 weights) {
  uvec3 corners = frame.triangles.at[triangle];
  return weights.x * frame.uvs.at[corners.x] + weights.y * frame.uvs.at[corners.y] +
         weights.z * frame.uvs.at[corners.z];
}
#endif
