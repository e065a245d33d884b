// The trace pass for area lights: one workgroup traces one 8x8 tile, counts for each light how many of its sample points
// a pixel sees, and packs the counts into planes of the mask (common/light_planes.h). Lights without an extent are left
// to the trace pass, except those that are lit everywhere.
//
// The includer defines struct Hierarchy and TRACER_PUSH before including this file, and afterwards seen_samples.
#include "count_planes.glsl"
#include "soft_lights.glsl"
#include "surface.glsl"

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  SoftFrame soft;
  TRACER_PUSH
} push;

// How many of the light's sample points the surface sees, of a pair whose segment to the light's middle is traced.
// `first_point`: of those that are the pixel's.
uint seen_samples(SoftLight light, SurfacePoint surface, vec3 origin, uint first_point);

uint word_of(SoftLight light, uint plane) {
  return (light.plane + plane) * frame.tile_count + gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
}

void store_lit(SoftLight light, uint plane) {
  push.masks.at[word_of(light, plane)] = uvec2(0xffffffffu);
  push.valid_bits.at[word_of(light, plane)] = uvec2(plane == 0u ? 0xffffffffu : 0u);
}

void main() {
  uint invocation = gl_LocalInvocationIndex;
  uvec2 in_tile = pixel_in_tile(invocation);
  uvec2 pixel = gl_WorkGroupID.xy * 8u + in_tile;
  uint id = triangle_at(pixel);
  SurfacePoint surface = surface_of(max(id, 1u) - 1u, pixel);
  vec3 origin = segment_origin(frame.camera, surface);
  uint bit = in_tile.y * 8u + in_tile.x;
  uvec2 my_bit = bit < 32u ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << (bit - 32u));
  uint samples = push.soft.samples, pattern = sample_pattern(pixel);
  for (uint i = 0u; i < push.soft.light_count; ++i) {
    SoftLight light = push.soft.lights[i];
    if (light.how == kLitEverywhere) {
      if (invocation < light.planes) store_lit(light, invocation);
      continue;
    }
    clear_count(invocation);
    barrier();
    bool care = id != 0u && shadow_segment(frame.camera, surface, frame.lights[light.light]).traced;
    uint seen = 0u;
    if (care) seen = seen_samples(light, surface, origin, light.points + pattern * samples);
    gather_count(care, seen, samples, light.planes, my_bit);
    barrier();
    if (invocation < light.planes)
      store_plane(push.masks, push.valid_bits, word_of(light, invocation), invocation);
    barrier();
  }
}
