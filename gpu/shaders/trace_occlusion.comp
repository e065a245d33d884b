#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Counts for each pixel the segments of its surface's ambient light that nothing near blocks, and packs the counts into
// planes of the mask. One workgroup has one 8x8 tile. At half size four invocations share each pixel that counts.
//
// Each segment walks the hierarchies by itself: a list of what is near, gathered once for the tile, was slower on
// lavapipe and no faster on an NVIDIA H100 (docs/soft-light.md).
#include "count_planes.glsl"
#include "frame.glsl"
#include "sample_pattern.glsl"
#include "surface.glsl"

#include "hierarchy.glsl"
#include "tracers/bvh.glsl"

// gpu/passes/trace_occlusion.cpp writes it.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer OcclusionPoints {
  float radius;
  vec3 on_sphere[];
};

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  OcclusionPoints points;
  uint first_plane;
  uint half_size;  // 1: pixels of even column and row alone
  Hierarchy still;
  Hierarchy moving;
} push;

const uint kSegments = 8u, kPlanes = 4u, kSharers = 4u;

shared uint open_segments[64];  // of each pixel of the tile

bool is_open(vec3 origin, vec3 normal, uint point) {
  ShadowSegment segment = occlusion_segment(origin, normal, push.points.on_sphere[point], push.points.radius);
  return !segment.traced || (!meets(Tree(push.moving, true), origin, segment.direction) &&
                             !meets(Tree(push.still, false), origin, segment.direction));
}

// Of the pixel's segments `first` to `end` - 1.
void count_open(uvec2 in_tile, uint first, uint end) {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + in_tile;
  uint id = triangle_at(pixel);
  if (id == 0u) return;
  SurfacePoint surface = surface_of(id - 1u, pixel);
  vec3 origin = segment_origin(frame.camera, surface);
  uint points = sample_pattern(pixel) * kSegments, open = 0u;
  for (uint i = first; i < end; ++i) open += is_open(origin, surface.normal, points + i) ? 1u : 0u;
  atomicAdd(open_segments[in_tile.y * 8u + in_tile.x], open);
}

void main() {
  uint invocation = gl_LocalInvocationIndex;
  bool half_size = push.half_size != 0u;
  open_segments[invocation] = 0u;
  clear_count(invocation);
  barrier();
  if (half_size) {
    uint sharer = invocation % kSharers, counting = invocation / kSharers, each = kSegments / kSharers;
    count_open(2u * uvec2(counting % 4u, counting / 4u), sharer * each, (sharer + 1u) * each);
  } else {
    count_open(pixel_in_tile(invocation), 0u, kSegments);
  }
  barrier();
  uvec2 in_tile = uvec2(invocation % 8u, invocation / 8u);
  bool counts = triangle_at(gl_WorkGroupID.xy * 8u + in_tile) != 0u &&
                (!half_size || ((in_tile.x | in_tile.y) & 1u) == 0u);
  uvec2 my_bit = invocation < 32u ? uvec2(1u << invocation, 0u) : uvec2(0u, 1u << (invocation - 32u));
  gather_count(counts, open_segments[invocation], kSegments, kPlanes, my_bit);
  barrier();
  if (invocation < kPlanes) {
    uint word = (push.first_plane + invocation) * frame.tile_count + gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
    store_plane(push.masks, push.valid_bits, word, invocation);
  }
}
