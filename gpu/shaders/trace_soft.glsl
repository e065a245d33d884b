// The trace pass for area lights: one workgroup traces one 8x8 tile, counts for each light how many of its sample points
// a pixel sees, and packs the counts into planes of the mask (common/light_planes.h). Lights without an extent are left
// to the trace pass, except those that are lit everywhere.
//
// The includer defines struct Hierarchy and TRACER_PUSH before including this file, and afterwards seen_samples.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "soft_lights.glsl"
#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer TileWords { uvec2 at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  SoftFrame soft;
  TRACER_PUSH
} push;

// How many of the light's sample points the surface sees, of a pair whose segment to the light's middle is traced.
// `first_point`: of those that are the pixel's.
uint seen_samples(SoftLight light, SurfacePoint surface, vec3 origin, uint first_point);

// The two halves of the words of every plane, then those of the word of traced bits.
shared uint tile_words[2u * (kMostPlanes + 1u)];

void gather(uint slot, bool set, uvec2 my_bit) {
  uvec2 bits = subgroupOr(set ? my_bit : uvec2(0u));
  if (subgroupElect()) {
    atomicOr(tile_words[2u * slot], bits.x);
    atomicOr(tile_words[2u * slot + 1u], bits.y);
  }
}

uvec2 gathered(uint slot) { return uvec2(tile_words[2u * slot], tile_words[2u * slot + 1u]); }

// The planes below the first matter only where the first is 0.
void store(SoftLight light, uint plane) {
  uint word = (light.plane + plane) * frame.tile_count + gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
  if (light.how == kLitEverywhere) {
    push.masks.at[word] = uvec2(0xffffffffu);
    push.valid_bits.at[word] = uvec2(plane == 0u ? 0xffffffffu : 0u);
    return;
  }
  uvec2 care = gathered(kMostPlanes);
  push.masks.at[word] = gathered(plane);
  push.valid_bits.at[word] = plane == 0u ? care : care & ~gathered(0u);
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
    if (invocation < 2u * (kMostPlanes + 1u)) tile_words[invocation] = 0u;
    barrier();
    if (light.how != kLitEverywhere) {
      bool care = id != 0u && shadow_segment(frame.camera, surface, frame.lights[light.light]).traced;
      uint seen = 0u;
      if (care) seen = seen_samples(light, surface, origin, light.points + pattern * samples);
      gather(kMostPlanes, care, my_bit);
      gather(0u, seen == samples, my_bit);
      for (uint plane = 1u; plane < light.planes; ++plane)
        gather(plane, seen < samples && ((seen >> (light.planes - 1u - plane)) & 1u) != 0u, my_bit);
    }
    barrier();
    if (invocation < light.planes) store(light, invocation);
    barrier();
  }
}
