// The trace pass around a tracer: one workgroup traces one 8x8 tile, and packs for each light a word of visibility bits
// and a word with a 1 for each bit that was traced.
//
// The includer defines TRACER_PUSH, the members of the tracer's push constants, before including this file, and
// afterwards bool occluded(vec3 origin, vec3 direction).
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "frame.glsl"
#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer TileWords { uvec2 at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  TRACER_PUSH
} push;

bool occluded(vec3 origin, vec3 direction);

const uint kLightsAtATime = 32;
// For each light the two halves of its visibility word, then those of its word of traced bits.
shared uint tile_words[4 * kLightsAtATime];

// The pixel's bit in the two halves of the tile's visibility word (xy) and of its word of traced bits (zw).
uvec4 answer(SurfacePoint surface, uint light, uvec2 my_bit) {
  ShadowSegment segment = shadow_segment(frame.camera, surface, frame.lights[light]);
  if (!segment.traced) return uvec4(0u);
  return uvec4(occluded(segment.origin, segment.direction) ? uvec2(0u) : my_bit, my_bit);
}

// The tile's word of the light's mask.
uint word_of(uint light) {
  return frame.planes[light] * frame.tile_count + gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
}

void main() {
  uint invocation = gl_LocalInvocationIndex;
  uvec2 in_tile = pixel_in_tile(invocation);
  uvec2 pixel = gl_WorkGroupID.xy * 8u + in_tile;
  uint id = triangle_at(pixel);
  SurfacePoint surface;
  if (id != 0u) surface = surface_of(id - 1u, pixel);

  uint bit = in_tile.y * 8u + in_tile.x;
  uvec2 my_bit = bit < 32u ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << (bit - 32u));
  for (uint first = 0u; first < frame.light_count; first += kLightsAtATime) {
    uint lights = min(frame.light_count - first, kLightsAtATime);
    tile_words[invocation] = 0u;
    tile_words[invocation + 64u] = 0u;
    barrier();
    for (uint light = 0u; light < lights; ++light) {
      if (frame.planes[first + light] == kLeftOut) continue;
      uvec4 bits = uvec4(0u);
      if (id != 0u) bits = answer(surface, first + light, my_bit);
      bits = subgroupOr(bits);
      if (subgroupElect())
        for (uint i = 0u; i < 4u; ++i) atomicOr(tile_words[4u * light + i], bits[i]);
    }
    barrier();
    if (invocation < lights && frame.planes[first + invocation] != kLeftOut) {
      uint i = 4u * invocation, light = first + invocation;
      push.masks.at[word_of(light)] = uvec2(tile_words[i], tile_words[i + 1u]);
      push.valid_bits.at[word_of(light)] = uvec2(tile_words[i + 2u], tile_words[i + 3u]);
    }
    barrier();
  }
}
