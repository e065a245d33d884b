#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "surface.glsl"
#include "seen_source.glsl"

// Finds for each pixel the pixel of a view seen before that shows the same surface.
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Sources { uint at[]; };
layout(push_constant, scalar) uniform Push {
  SeenView seen;
  Uints seen_ids;  // triangle_id of that view
  Uints ids;       // triangle_id of this view
  Sources sources;
} push;

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  uint index = pixel.y * frame.width + pixel.x;
  uint id = push.ids.at[index];
  uint source = 0u;
  if (id != 0u) source = source_of(push.seen, push.seen_ids, surface_of(id - 1u, pixel));
  push.sources.at[index] = source;
}
