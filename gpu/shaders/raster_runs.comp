#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require

// Draws runs of triangles, one triangle for each invocation: small ones are drawn pixel by pixel, the others are listed
// for divide_large.comp and raster_large.comp.
layout(local_size_x = 64) in;

#include "raster.glsl"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DepthTiles { float at[]; };

layout(push_constant, scalar) uniform Push {
  Visibility visibility;
  LargeList large;
  uvec2 runs;         // address of RunList; 0: the triangles from `first` on
  uvec2 depth_tiles;  // address of DepthTiles; 0: nothing hides anything yet
  uint first;
  uint count;
  uint marks;
  uint most_blocks;  // of divided triangles; 0: divide none, as a list's counts may not hold them
} push;

const int kSmallSide = 64;    // pixels: edges then fit into 32 bits
const int kSmallPixels = 32;  // of the rectangle around the outline
const int kFewTiles = 4;

bool hidden(Pixels p, float nearest) {
  if (push.depth_tiles == uvec2(0)) return false;
  ivec2 first = p.first / 8, end = p.last / 8 + 1;
  if ((end.x - first.x) * (end.y - first.y) > kFewTiles) return false;
  for (int y = first.y; y < end.y; ++y)
    for (int x = first.x; x < end.x; ++x)
      if (DepthTiles(push.depth_tiles).at[y * int(frame.tiles_x) + x] <= nearest) return false;
  return true;
}

// An edge's value at a pixel's centre, and its steps to the next pixel to the right and down. Values are not negative
// inside.
ivec3 edge(ivec2 from, ivec2 to, ivec2 middle) {
  ivec2 along = to - from, off = middle - from;
  int above_or_left = along.y < 0 || (along.y == 0 && along.x >= 0) ? 0 : -1;
  return ivec3(along.x * off.y - along.y * off.x + above_or_left, -along.y * kSubpixels, along.x * kSubpixels);
}

void draw_small(uint marked, Corners corners, Outline o, Pixels p) {
  ivec2 middle = p.first * kSubpixels + kSubpixels / 2;
  ivec3 e0 = edge(o.at[0], o.at[1], middle), e1 = edge(o.at[1], o.at[2], middle), e2 = edge(o.at[2], o.at[3], middle),
        e3 = edge(o.at[3], o.at[0], middle);
  Plane plane = plane_of(corners, o);
  for (int y = 0; y <= p.last.y - p.first.y; ++y)
    for (int x = 0; x <= p.last.x - p.first.x; ++x) {
      int inside = (e0.x + e0.y * x + e0.z * y) | (e1.x + e1.y * x + e1.z * y) | (e2.x + e2.y * x + e2.z * y) |
                   (e3.x + e3.y * x + e3.z * y);
      if (inside >= 0) plot(push.visibility, marked, corners, plane, uvec2(p.first + ivec2(x, y)));
    }
}

// Numbers in the upper bits and blocks in the lower ones, as LargeList::divided counts them, are given out to all
// invocations of a subgroup that come here by one atomic: those of one address wait for each other. False if the list has
// no room.
bool divide(uint marked, Corners corners, Outline o, Pixels p) {
  if (push.most_blocks == 0u) return false;
  ivec2 blocks = blocks_of(p);
  uint more = uint(blocks.x * blocks.y), more_before = subgroupExclusiveAdd(more), one_before = subgroupExclusiveAdd(1u);
  uint64_t all = (uint64_t(subgroupAdd(1u)) << kBlocksOfCount) + uint64_t(subgroupAdd(more));
  uvec2 given = uvec2(0u);
  if (subgroupElect()) {
    given = unpackUint2x32(atomicAdd(push.large.divided, all));
    uint64_t end = (packUint2x32(given) + all) & ((uint64_t(1) << kBlocksOfCount) - 1ul);
    atomicMax(push.large.dividing_groups, uint(min((end + 255ul) / 256ul, uint64_t(kMostGroups))));
    push.large.dividing_one = push.large.dividing_also_one = 1u;
  }
  uint64_t before = packUint2x32(subgroupBroadcastFirst(given)) + (uint64_t(one_before) << kBlocksOfCount) +
                    uint64_t(more_before);
  uint64_t first_block = before & ((uint64_t(1) << kBlocksOfCount) - 1ul), number = before >> kBlocksOfCount;
  if (first_block + uint64_t(more) > uint64_t(push.most_blocks) || number >= uint64_t(kMostDivided)) {
    atomicMax(push.large.refused, ~before);
    return false;
  }
  push.large.first_block[uint(number)] = uint(first_block);
  push.large.prepared[uint(number)] = prepared_of(marked, corners, o, p);
  return true;
}

void list_whole(uint marked) {
  uint place = atomicAdd(push.large.count, 1u);
  push.large.at[place] = marked;
  atomicMax(push.large.groups, min((place + 1u) * kStripes, kMostGroups));
  push.large.one = push.large.also_one = 1u;
}

void draw(uint marked) {
  Corners corners = corners_of(marked & kNumber);
  Outline o = outline_of(corners, (marked & kDoubleSided) != 0u);
  if (!o.shows) return;
  Pixels p = pixels_of(o);
  if (none(p) || hidden(p, o.nearest)) return;
  ivec2 pixels = p.last - p.first + 1;
  ivec2 low = min(min(o.at[0], o.at[1]), min(o.at[2], o.at[3]));
  ivec2 high = max(max(o.at[0], o.at[1]), max(o.at[2], o.at[3]));
  if (pixels.x * pixels.y <= kSmallPixels && all(lessThan(high - low, ivec2(kSmallSide * kSubpixels))))
    draw_small(marked, corners, o, p);
  else if (any(greaterThan(high - low, ivec2(kLongest))) || !divide(marked, corners, o, p))
    list_whole(marked);
}

void main() {
  uint i = gl_LocalInvocationIndex;
  if (push.runs == uvec2(0)) {
    uint triangle = gl_WorkGroupID.x * 64u + i;
    if (triangle < push.count) draw((push.first + triangle) | push.marks);
    return;
  }
  uint runs = RunList(push.runs).count;
  for (uint r = gl_WorkGroupID.x; r < runs; r += gl_NumWorkGroups.x) {
    Run run = RunList(push.runs).at[r];
    if (i < (run.count & kNumber)) draw((run.first + i) | (run.count & ~kNumber));
  }
}
