// Computes a pixel's surface point from its triangle id, and maps invocations to pixels of a tile.
#extension GL_EXT_samplerless_texture_functions : require
#include "texels.glsl"

#ifndef TILE_INVOCATIONS
#define TILE_INVOCATIONS 64
#endif
#ifdef LANES_OF_PIPELINE
layout(local_size_x_id = 0) in;  // as make_compute_pipeline has it
layout(constant_id = 1) const uint kLanes = 8u;       // of a subgroup
layout(constant_id = 2) const uint kSharers = 1u;     // subgroups that share a tile
#else
layout(local_size_x = TILE_INVOCATIONS) in;
#endif
layout(set = 0, binding = 1) uniform utexture2D triangle_ids;

// Eight consecutive invocations, the narrowest subgroup, form a block of 4x2 pixels, which share many texels, triangles
// and tree nodes.
uvec2 pixel_in_tile(uint invocation) {
  uint block = invocation / 8u, lane = invocation % 8u;
  return uvec2((block % 2u) * 4u + lane % 4u, (block / 2u) * 2u + lane / 4u);
}

// 1 + the index of the triangle that the pixel shows; 0 if it shows none or lies outside the picture.
uint triangle_at(uvec2 pixel) {
  if (pixel.x >= frame.width || pixel.y >= frame.height) return 0u;
  return texelFetch(triangle_ids, ivec2(pixel), 0).x;
}

// Whether the two points are of one surface, to blur over: normals within 8 degrees, and the other near the plane of `here`.
bool on_one_surface(SurfacePoint here, SurfacePoint other) {
  float room = 0.004 * distance(here.position, frame.camera);
  return abs(dot(other.position - here.position, here.normal)) <= room && dot(other.normal, here.normal) > 0.99;
}

TriangleCorners triangle_corners(uint triangle) {
#ifdef BY_TEXELS
  if (triangle < frame.resting_triangles) return corners_at_rest(triangle);
#endif
  uvec3 corners = frame.triangles.at[triangle];
  return TriangleCorners(frame.positions.at[corners.x], frame.positions.at[corners.y], frame.positions.at[corners.z]);
}

SurfacePoint surface_of(uint triangle, uvec2 pixel) {
  TriangleCorners corners = triangle_corners(triangle);
  return surface_point(frame.camera, frame.forward, pixel_ray(pixel), corners.p0, corners.p1, corners.p2);
}
