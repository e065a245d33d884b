#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require

// Writes the triangles of a chunk of clusters (gpu/scene/clusters.h) that may show, in their order, and the command
// that draws them. A workgroup processes a chunk; an invocation tests first a cluster, then one triangle of each
// cluster.
layout(local_size_x = 64) in;

struct Draw {  // VkDrawIndirectCommand
  uint vertex_count;
  uint instance_count;
  uint first_vertex;
  uint first_instance;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Draws { Draw at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Triangles { uint at[]; };

#define CULL_PUSH  \
  Draws draws;     \
  Triangles drawn; \
  uint first_chunk;
#include "cull.glsl"

// Pixels. Rounding may reverse narrower triangles, or move their depths out of their range by more than its length.
const float kNarrow = 2.0 * kPixelSlack;
// Pixels. Farther out, the rounding of floats is not small against kPixelSlack.
const float kFarthestPixel = 16384.0;

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
    extent.nearest = 2.0;  // nearer than any depth, so that only the test for a pixel's centre can hide it
  else if (!double_sided && doubled_area > 0.0)
    return false;  // a back face, as the y axis of pixels points down
  return !hidden(extent);
}

shared uint shown;       // a bit for each cluster
shared uint kept[3][2];  // a bit for each triangle of a cluster; three in rotation need only one barrier per cluster

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
