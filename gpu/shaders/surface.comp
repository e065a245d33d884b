#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "surface.glsl"

struct SurfaceSample {
  vec3 position;
  uint triangle;
  vec3 normal;
  uint reserved;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer Samples { SurfaceSample at[]; };
layout(push_constant, scalar) uniform Push { Samples samples; } push;

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  SurfaceSample s = SurfaceSample(vec3(0.0), triangle_at(pixel), vec3(0.0), 0u);
  if (s.triangle != 0u) {
    SurfacePoint point = surface_of(s.triangle - 1u, pixel);
    s.position = point.position;
    s.normal = point.normal;
  }
  push.samples.at[pixel.y * frame.width + pixel.x] = s;
}
