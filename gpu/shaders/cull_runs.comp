#version 460
#extension GL_GOOGLE_include_directive : require

// Writes the clusters of a chunk that may show, for raster_runs.comp. A workgroup processes a chunk, an invocation a
// cluster.
layout(local_size_x = 32) in;

#include "raster.glsl"
#define CULL_PUSH \
  RunList runs;   \
  uint first_chunk;
#include "cull.glsl"

shared uint shown;  // a bit for each cluster
shared uint first_run;

void main() {
  uint i = gl_LocalInvocationIndex;
  Chunk chunk = push.chunks.at[push.first_chunk + gl_WorkGroupID.x];
  Cluster cluster = push.clusters.at[chunk.first_cluster + min(i, chunk.cluster_count - 1u)];
  if (i == 0u) shown = 0u;
  barrier();
  bool shows = i < chunk.cluster_count && cluster_may_show(cluster);
  if (shows) atomicOr(shown, 1u << i);
  barrier();
  uint count = uint(bitCount(shown));
  if (i == 0u && count > 0u) {
    first_run = atomicAdd(push.runs.count, count);
    atomicMax(push.runs.groups, min(first_run + count, kMostGroups));
    push.runs.one = push.runs.also_one = 1u;
  }
  barrier();
  uint marks = (chunk.double_sided != 0u ? kDoubleSided : 0u) | (chunk.masked != 0u ? kMasked : 0u);
  uint before = uint(bitCount(shown & ((1u << i) - 1u)));
  if (shows) push.runs.at[first_run + before] = Run(cluster.first_triangle, cluster.triangle_count | marks);
}
