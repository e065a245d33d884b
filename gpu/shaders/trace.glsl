// The trace pass around a tracer: one workgroup answers for one 8x8 tile and packs a word for each light.
//
// The includer has defined, before: TRACER_PUSH, the members of the tracer's push constants; after this file's
// declarations: bool occluded(vec3 origin, vec3 direction).
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "frame.glsl"
#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer TileWords { uvec2 at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TRACER_PUSH
} push;

bool occluded(vec3 origin, vec3 direction);

const uint kLightsAtATime = 32;
shared uint tile_words[2 * kLightsAtATime];

bool lit(SurfacePoint surface, uint light) {
  ShadowSegment segment = shadow_segment(frame.camera, surface, frame.lights[light]);
  return segment.traced && !occluded(segment.origin, segment.direction);
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
  uint tile = gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
  for (uint first = 0u; first < frame.light_count; first += kLightsAtATime) {
    uint lights = min(frame.light_count - first, kLightsAtATime);
    tile_words[invocation] = 0u;
    barrier();
    for (uint light = 0u; light < lights; ++light) {
      uvec2 bits = id != 0u && lit(surface, first + light) ? my_bit : uvec2(0u);
      bits = subgroupOr(bits);
      if (subgroupElect()) {
        atomicOr(tile_words[2u * light], bits.x);
        atomicOr(tile_words[2u * light + 1u], bits.y);
      }
    }
    barrier();
    if (invocation < lights)
      push.masks.at[(first + invocation) * frame.tile_count + tile] =
          uvec2(tile_words[2u * invocation], tile_words[2u * invocation + 1u]);
    barrier();
  }
}
