#version 460
#extension GL_GOOGLE_include_directive : require

// Divides large triangles into the 8x8 blocks that they may show in: an invocation tests one block of a triangle's
// bounding rectangle. A triangle that fills a block hides what lies behind it there from all that is drawn later.
layout(local_size_x = 256) in;

#include "raster.glsl"
#include "occluded.glsl"

layout(push_constant, scalar) uniform Push {
  LargeList large;
  BlockList blocks;
  DepthTiles depth_tiles;
} push;

shared uint found, first_kept;
const uint kStarts = 0, kKept = 1;
shared uint marks[2][8];  // a bit for each invocation: whether a triangle begins at its block; whether its block is kept

// The last triangle whose first block is not after this one. Each step looks at 256 places at once, as each step waits
// for memory.
uint triangle_with(uint block, uint count) {
  uint low = 0u;
  for (uint left = count; left > 1u;) {
    uint apart = (left + 255u) / 256u, place = low + apart * gl_LocalInvocationIndex;
    barrier();  // all invocations have taken what the step before found
    if (gl_LocalInvocationIndex == 0u) found = low;
    barrier();
    if (place > low && place < low + left && push.large.first_block[place] <= block) atomicMax(found, place);
    barrier();
    left = min(apart, low + left - found);
    low = found;
  }
  return low;
}

void mark(uint what, uint i) { atomicOr(marks[what][i / 32u], 1u << (i % 32u)); }

uint marks_until(uint what, uint i) {
  uint count = uint(bitCount(marks[what][i / 32u] & (0xffffffffu >> (31u - i % 32u))));
  for (uint word = 0u; word < i / 32u; ++word) count += uint(bitCount(marks[what][word]));
  return count;
}

// The greatest value of an edge in a rectangle, and the least.
int most_in(BlockEdge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0 ? p.last.x : p.first.x, e.dy > 0 ? p.last.y : p.first.y));
}
int least_in(BlockEdge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0 ? p.first.x : p.last.x, e.dy > 0 ? p.first.y : p.last.y));
}

// Whether the triangle may show in its bounding rectangle's block of this number, which is the picture's tile `tile`.
bool shows_in(Prepared t, uint number, out uint tile) {
  int across = blocks_of(t.bounds).x;
  ivec2 at = t.bounds.first / 8 + ivec2(int(number) % across, int(number) / across), corner = at * 8;
  tile = uint(at.y) * frame.tiles_x + uint(at.x);
  Pixels block = Pixels(max(corner, t.bounds.first), min(corner + 7, t.bounds.last));
  Pixels offsets = Pixels(block.first - corner, block.last - corner);
  int reaches = 0, fills = 0;  // negative if some edge has the block outside; if some edge has a part of it outside
  for (uint k = 0u; k < 4u; ++k) {
    BlockEdge e = in_block(t.edges[k], corner);
    reaches |= most_in(e, offsets);
    fills |= least_in(e, offsets);
  }
  if (reaches < 0 || hidden(push.depth_tiles, tile, t.plane, block)) return false;
  bool whole = block.first == corner && block.last == min(corner + 7, ivec2(frame.width, frame.height) - 1);
  if (fills >= 0 && whole && (t.triangle & kMasked) == 0u) hide_behind(push.depth_tiles, tile, t.plane, block);
  return true;
}

void divide(uint first, uint blocks, uint triangles) {
  uint i = gl_LocalInvocationIndex, first_triangle = triangle_with(first, triangles);
  barrier();
  if (i < 16u) marks[i / 8u][i % 8u] = 0u;
  barrier();
  // A triangle has at least one block: those that begin among these blocks are the next 255 at most.
  uint next = first_triangle + 1u + i;
  if (next < triangles) {
    uint start = push.large.first_block[next] - first;
    if (start < 256u) mark(kStarts, start);
  }
  barrier();
  uint triangle = first_triangle + marks_until(kStarts, i), tile = 0u;
  bool shows = first + i < blocks &&
               shows_in(push.large.prepared[triangle], first + i - push.large.first_block[triangle], tile);
  if (shows) mark(kKept, i);
  barrier();
  if (i == 255u) {
    uint count = marks_until(kKept, 255u);
    first_kept = count == 0u ? 0u : atomicAdd(push.blocks.count, count);
    if (count != 0u) {
      atomicMax(push.blocks.groups, min((first_kept + count + kBlocksOfGroup - 1u) / kBlocksOfGroup, kMostGroups));
      push.blocks.one = push.blocks.also_one = 1u;
    }
  }
  barrier();
  if (shows) push.blocks.at[first_kept + marks_until(kKept, i) - 1u] = triangle << kPlaceBits | tile;
}

void main() {
  uint64_t counts = push.large.refused != 0ul ? ~push.large.refused : push.large.divided;
  uint blocks = uint(counts & ((uint64_t(1) << kBlocksOfCount) - 1ul)), triangles = uint(counts >> kBlocksOfCount);
  for (uint first = gl_WorkGroupID.x * 256u; first < blocks; first += gl_NumWorkGroups.x * 256u)
    divide(first, blocks, triangles);
}
