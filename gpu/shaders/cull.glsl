// The culling tests of both ways of rasterising, for clusters (gpu/scene/clusters.h): by the frustum, by the cone of
// normals, and by the farthest depths of 8x8 tiles, one level of the pyramid of Greene, Kass and Miller, "Hierarchical
// Z-Buffer Visibility" (1993).
//
// Only what covers no pixel is culled, so that the picture equals that of drawing everything. Margins: `slack`, in
// metres, exceeds the rounding of a vertex's transformation; kPixelSlack exceeds the distance by which a rasteriser may
// move a vertex.
//
// The includer has defined CULL_PUSH, the further members of the push constants.
#include "frame.glsl"

const float kPixelSlack = 1.0 / 16.0;
// The rasteriser's rounding of vertices may reverse faces that are this close to edge-on.
const float kEdgeOnSine = 0.02;
// Anything that covers more tiles than this counts as visible, because it is near and large.
const uint kMostTiles = 256;

struct Cluster {
  vec3 box_min;
  uint first_triangle;
  vec3 box_max;
  uint triangle_count;  // at most one for each invocation
  vec3 cone_axis;
  float cone_cutoff;
};
struct Chunk {
  uint first_cluster;
  uint cluster_count;  // at most 32
  uint double_sided;
  uint masked;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Clusters { Cluster at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chunks { Chunk at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DepthTiles { float at[]; };

layout(push_constant, scalar) uniform Push {
  Clusters clusters;
  Chunks chunks;
  uvec2 depth_tiles;  // address of DepthTiles; 0: nothing hides anything yet
  CULL_PUSH
} push;

float largest(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }
vec2 pixel_of(vec4 clip) { return (clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.width, frame.height); }

// A box relative to the camera, in world axes.
struct Box {
  vec3 middle;
  vec3 half_size;
};

// Half of the box's extent along an axis, times the axis' length.
float reach_along(vec3 axis, Box box) { return dot(abs(axis), box.half_size); }

bool outside(vec3 edge, vec3 next_edge, vec3 centre, Box box, float slack) {
  vec3 inwards = cross(edge, next_edge);
  if (dot(inwards, centre) < 0.0) inwards = -inwards;
  return dot(inwards, box.middle) + reach_along(inwards, box) < -slack * length(inwards);
}

// Tests the near plane and the four sides, whose edges are the rays through the picture's corners.
bool outside_frustum(Box box, float slack) {
  vec3 across = frame.ray_dx * float(frame.width), down = frame.ray_dy * float(frame.height);
  vec3 corner = frame.ray_corner, centre = corner + 0.5 * (across + down);
  return dot(frame.forward, box.middle) + reach_along(frame.forward, box) < near_plane() - slack ||
         outside(corner, corner + across, centre, box, slack) ||
         outside(corner + across, corner + across + down, centre, box, slack) ||
         outside(corner + across + down, corner + down, centre, box, slack) ||
         outside(corner + down, corner, centre, box, slack);
}

bool turns_its_back(Cluster cluster, Box box, float slack) {
  float distance = length(box.middle);
  return dot(box.middle, cluster.cone_axis) >
         (cluster.cone_cutoff + kEdgeOnSine) * distance + length(box.half_size) + slack;
}

// A rectangle of pixels and the depths there. Depth is reversed: greater is nearer.
struct Extent {
  vec2 low, high;
  float nearest, farthest;
};

float depth_of_tile(uint x, uint y) { return DepthTiles(push.depth_tiles).at[y * frame.tiles_x + x]; }

// Whether the extent contains no pixel's centre, or is behind the farthest depths of all of its tiles. The rasterised
// depth of a steep triangle may leave the range, hence a margin as large as the range.
bool hidden(Extent extent) {
  ivec2 size = ivec2(frame.width, frame.height);
  ivec2 first = ivec2(clamp(ceil(extent.low - kPixelSlack - 0.5), vec2(0.0), vec2(size)));
  ivec2 last = ivec2(clamp(floor(extent.high + kPixelSlack - 0.5), vec2(-1.0), vec2(size - 1)));
  if (any(greaterThan(first, last))) return true;
  if (push.depth_tiles == uvec2(0)) return false;
  uvec2 tile = uvec2(first) / 8u, end = uvec2(last) / 8u + 1u, tiles = end - tile;
  if (tiles.x * tiles.y > kMostTiles) return false;
  float limit = extent.nearest + (extent.nearest - extent.farthest);
  // Eight tiles at a time, because the loop waits for memory more than for anything else.
  for (uint y = tile.y; y < end.y; y += 2u) {
    uint next_y = min(y + 1u, end.y - 1u);
    for (uint x = tile.x; x < end.x; x += 4u) {
      float farthest = 1.0;
      for (uint k = 0u; k < 4u; ++k)
        farthest = min(farthest, min(depth_of_tile(min(x + k, end.x - 1u), y),
                                     depth_of_tile(min(x + k, end.x - 1u), next_y)));
      if (farthest <= limit) return false;
    }
  }
  return true;
}

bool hidden(Box box, float slack) {
  float middle = dot(frame.forward, box.middle), reach = reach_along(frame.forward, box) + slack;
  if (middle - reach <= near_plane()) return false;
  Extent extent = Extent(vec2(1e9), vec2(-1e9), near_plane() / (middle - reach), near_plane() / (middle + reach));
  for (int i = 0; i < 8; ++i) {
    vec3 side = vec3(i & 1, i >> 1 & 1, i >> 2) * 2.0 - 1.0;
    vec2 pixel = pixel_of(frame.camera_to_clip * vec4(box.middle + side * box.half_size, 1.0));
    extent.low = min(extent.low, pixel);
    extent.high = max(extent.high, pixel);
  }
  return hidden(extent);
}

bool cluster_may_show(Cluster cluster) {
  Box box = Box(0.5 * (cluster.box_min + cluster.box_max) - frame.camera, 0.5 * (cluster.box_max - cluster.box_min));
  float slack = 4e-6 * (largest(cluster.box_min) + largest(cluster.box_max) + largest(frame.camera));
  return !outside_frustum(box, slack) && !turns_its_back(cluster, box, slack) && !hidden(box, slack);
}
