#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "surface.glsl"

// Averages a picture that was shaded at 2x2 samples a pixel, in linear light. Each invocation makes one pixel of the
// result, which is half as wide and half as high as the frame.
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Pixels { uint at[]; };
layout(push_constant, scalar) uniform Push {
  Uints samples;  // as shade.glsl writes them
  Pixels pixels;
} push;

vec3 to_linear(vec3 c) {
  return mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, lessThanEqual(c, vec3(0.04045)));
}
vec3 to_srgb(vec3 c) {
  return mix(1.055 * pow(max(c, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

vec3 sample_at(uvec2 place) { return to_linear(unpackUnorm4x8(push.samples.at[place.y * frame.width + place.x]).rgb); }

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  uvec2 size = uvec2(frame.width, frame.height) / 2u;
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uvec2 first = 2u * pixel;
  vec3 sum = sample_at(first) + sample_at(first + uvec2(1u, 0u)) + sample_at(first + uvec2(0u, 1u)) +
             sample_at(first + uvec2(1u, 1u));
  push.pixels.at[pixel.y * size.x + pixel.x] = packUnorm4x8(vec4(to_srgb(0.25 * sum), 1.0));
}
