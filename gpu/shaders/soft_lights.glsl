// The area lights of a soft frame and the points of them that are traced (gpu/passes/trace_soft.cpp writes them).
#include "frame.glsl"

const uint kLitEverywhere = 0u, kByHierarchy = 1u, kByLightBuffer = 2u;
struct SoftLight {
  uint light;
  uint plane, planes;  // of the mask
  uint points;         // the first of its points, pattern by pattern
  uint how;
  uint view;     // of light buffers: its number among their lights
  float radius;  // no point is farther from the light's position
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SoftFrame {
  uint light_count;
  uint samples;
  uint reserved[2];
  SoftLight lights[kMaxLights];
  vec3 points[];  // in the world; as texels they are vec4
};

#ifdef BY_TEXELS
layout(set = 4, binding = 0, rgba32ui) uniform readonly uimageBuffer soft_frame;
const uint kPointsFrom = 1u + kMaxLights * 28u / 16u;  // in texels
#define SAMPLE_POINT(n) uintBitsToFloat(imageLoad(soft_frame, int(kPointsFrom + (n))).xyz)
#else
#define SAMPLE_POINT(n) push.soft.points[n]
#endif

#include "sample_pattern.glsl"
