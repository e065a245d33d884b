// Buffers as texels (gpu/vulkan/texels.h). Vector units load lane by lane: through an address each word by itself, each
// behind a branch, but a texel of four words at once. With BY_TEXELS what tracing reads most is loaded so, from these sets:
//   1  the scene: the corners of resting triangles
//   2  the hierarchy of the resting geometry, or in the trace pass with light buffers these
//   3  the hierarchy of the moving geometry
//   4  in the pass for area lights their points
//   5  and there the light buffers
#ifndef TEXELS_GLSL
#define TEXELS_GLSL

struct TriangleCorners {
  vec3 p0, p1, p2;
};

#ifdef BY_TEXELS

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimageBuffer resting_corners;

vec3 resting_corner(uint n) { return uintBitsToFloat(imageLoad(resting_corners, int(n)).xyz); }

TriangleCorners corners_at_rest(uint triangle) {
  return TriangleCorners(resting_corner(3u * triangle), resting_corner(3u * triangle + 1u),
                         resting_corner(3u * triangle + 2u));
}

#endif
#endif
