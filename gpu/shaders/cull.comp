#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

// Writes down which triangles of a chunk of clusters (gpu/clusters.h) may show, in their order, and the draw of them.
// A chunk is a workgroup, an invocation is a cluster first and then a triangle of each cluster.
//
// A triangle is left out only where it can own no pixel, so the picture is that of drawing everything. Margins:
// `slack`, in metres, is more than what the vertex shader's floats can be off; kPixelSlack is more than how far a
// rasteriser may move a vertex.
layout(local_size_x = 64) in;

const float kPixelSlack = 1.0 / 16.0;
// Faces this close to edge-on may turn over where a rasteriser moves their vertices.
const float kEdgeOnSine = 0.02;
// Pixels. Narrower triangles may turn over, or leave their range of depths by more than its own length.
const float kNarrow = 2.0 * kPixelSlack;
// Pixels. Farther out, floats no longer tell what kPixelSlack is.
const float kFarthestPixel = 16384.0;
// What would ask more tiles than this is near and large: it shows.
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
};
struct Draw {  // VkDrawIndirectCommand
  uint vertex_count;
  uint instance_count;
  uint first_vertex;
  uint first_instance;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Clusters { Cluster at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Chunks { Chunk at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DepthTiles { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Draws { Draw at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Triangles { uint at[]; };

layout(push_constant, scalar) uniform Push {
  Clusters clusters;
  Chunks chunks;
  uvec2 depth_tiles;  // address of DepthTiles; 0: nothing hides anything yet
  Draws draws;
  Triangles drawn;
  uint first_chunk;
} push;

float near_plane() { return frame.camera_to_clip[3][2]; }
float largest(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }
vec2 pixel_of(vec4 clip) { return (clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.width, frame.height); }

// Relative to the camera, in world axes.
struct Box {
  vec3 middle;
  vec3 half_size;
};

// The box's extent along an axis.
float reach_along(vec3 axis, Box box) { return dot(abs(axis), box.half_size); }

bool outside(vec3 edge, vec3 next_edge, vec3 centre, Box box, float slack) {
  vec3 inwards = cross(edge, next_edge);
  if (dot(inwards, centre) < 0.0) inwards = -inwards;
  return dot(inwards, box.middle) + reach_along(inwards, box) < -slack * length(inwards);
}

// Four sides, whose edges are the rays through the picture's corners, and the near plane.
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

// Does it hold no pixel's centre, or is it behind what all its tiles show? Rasterised depth may leave the range where
// a triangle is steep, hence a margin as large as the range.
bool hidden(Extent extent) {
  ivec2 size = ivec2(frame.width, frame.height);
  ivec2 first = ivec2(clamp(ceil(extent.low - kPixelSlack - 0.5), vec2(0.0), vec2(size)));
  ivec2 last = ivec2(clamp(floor(extent.high + kPixelSlack - 0.5), vec2(-1.0), vec2(size - 1)));
  if (any(greaterThan(first, last))) return true;
  if (push.depth_tiles == uvec2(0)) return false;
  uvec2 tile = uvec2(first) / 8u, end = uvec2(last) / 8u + 1u, tiles = end - tile;
  if (tiles.x * tiles.y > kMostTiles) return false;
  float limit = extent.nearest + (extent.nearest - extent.farthest);
  for (uint y = tile.y; y < end.y; ++y)
    for (uint x = tile.x; x < end.x; ++x)
      if (DepthTiles(push.depth_tiles).at[y * frame.tiles_x + x] <= limit) return false;
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

bool triangle_may_show(uvec3 corners, bool double_sided) {
  vec4 a = frame.camera_to_clip * vec4(frame.positions.at[corners.x] - frame.camera, 1.0);
  vec4 b = frame.camera_to_clip * vec4(frame.positions.at[corners.y] - frame.camera, 1.0);
  vec4 c = frame.camera_to_clip * vec4(frame.positions.at[corners.z] - frame.camera, 1.0);
  float shallow = min(a.w, min(b.w, c.w)), deep = max(a.w, max(b.w, c.w));
  if (shallow <= near_plane() * 1.001) return true;
  vec2 pa = pixel_of(a), pb = pixel_of(b), pc = pixel_of(c);
  Extent extent = Extent(min(pa, min(pb, pc)), max(pa, max(pb, pc)), near_plane() / shallow, near_plane() / deep);
  if (max(max(-extent.low.x, -extent.low.y), max(extent.high.x, extent.high.y)) > kFarthestPixel) return true;
  vec2 ab = pb - pa, ac = pc - pa, bc = pc - pb;
  float doubled_area = ab.x * ac.y - ab.y * ac.x;
  float longest = sqrt(max(dot(ab, ab), max(dot(ac, ac), dot(bc, bc))));
  if (abs(doubled_area) <= kNarrow * longest)
    extent.nearest = 2.0;  // may be nearer than all; still it may hold no pixel
  else if (!double_sided && doubled_area > 0.0)
    return false;  // its back: pixels' y goes down
  return !hidden(extent);
}

shared uint shown;       // a bit for each cluster
shared uint kept[3][2];  // a bit for each triangle of a cluster; in turns, so that one barrier a cluster is enough

void main() {
  uint i = gl_LocalInvocationIndex;
  uint chunk_index = push.first_chunk + gl_WorkGroupID.x;
  Chunk chunk = push.chunks.at[chunk_index];
  uint first = push.clusters.at[chunk.first_cluster].first_triangle;
  if (i == 0u) shown = 0u;
  if (i < 2u) kept[0][i] = 0u;
  barrier();
  if (i < chunk.cluster_count && cluster_may_show(push.clusters.at[chunk.first_cluster + i])) atomicOr(shown, 1u << i);
  barrier();

  uint drawn = 0u, turn = 0u;
  for (uint left = shown; left != 0u; left &= left - 1u) {
    Cluster cluster = push.clusters.at[chunk.first_cluster + uint(findLSB(left))];
    uint triangle = cluster.first_triangle + i, next_turn = (turn + 1u) % 3u;
    bool shows = i < cluster.triangle_count &&
                 triangle_may_show(frame.triangles.at[triangle], chunk.double_sided != 0u);
    if (shows) atomicOr(kept[turn][i / 32u], 1u << (i % 32u));
    if (i < 2u) kept[next_turn][i] = 0u;
    barrier();
    uint before = bitCount(kept[turn][i / 32u] & ((1u << (i % 32u)) - 1u));
    if (i >= 32u) before += bitCount(kept[turn][0]);
    if (shows) push.drawn.at[first + drawn + before] = triangle;
    drawn += bitCount(kept[turn][0]) + bitCount(kept[turn][1]);
    turn = next_turn;
  }
  if (i == 0u) push.draws.at[chunk_index] = Draw(3u * drawn, 1u, 3u * first, 0u);
}
