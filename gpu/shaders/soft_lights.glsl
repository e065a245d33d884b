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
  SoftLight lights[kMaxLights];
  vec3 points[];  // in the world
};

#include "sample_pattern.glsl"
