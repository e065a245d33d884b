// The trace pass with light buffers: one subgroup of LANES traces one 8x8 tile, in rounds of one pixel for each lane, and
// stores for each light a word of visibility bits and a word with a 1 for each bit that was traced. A subgroup of 128
// traces two tiles side by side: no lane idles, except in a last column that stands alone.
//
// This file has the part that narrow and wide subgroups share: loading the pixels, and testing the planes of their
// leaves. They differ in how they walk the lists of the undecided pixels: trace_light_buffer_narrow.comp,
// trace_light_buffer_wide.comp. LANES is defined on the compiler's command line, and
// TRACER_PUSH_MORE by an includer that has further push constants.
#extension GL_EXT_control_flow_attributes : require
#include "subgroup.glsl"
#include "frame.glsl"
#define TILE_INVOCATIONS LANES
#include "surface.glsl"

#ifndef TRACER_PUSH_MORE
#define TRACER_PUSH_MORE
#endif

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer TileWords { uvec2 at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  uvec2 grid;
  uvec2 leaves;
  uvec2 entries;
  uvec2 corners;  // of every triangle
  uvec2 views;
  uint first_masked;
  uint reserved;
  TRACER_PUSH_MORE
} push;

const uint kNone = 0xffffffffu;
const uint kTiles = LANES > 64 ? LANES / 64 : 1;   // of each subgroup
const uint kRounds = LANES < 64 ? 64 / LANES : 1;  // number of pixels of each lane

#include "tracers/light_buffer.glsl"

struct Pixels {
  vec3 normal[kRounds];
  vec3 origin[kRounds];
  uint shown;  // a bit for each round
};

// Converts bits from the order of rounds, 4x2 blocks, to that of tile words, rows: neighbouring groups of four bits are
// swapped.
uint by_rows(uint by_blocks) {
  uint swap = ((by_blocks >> 4) ^ by_blocks) & 0x00f000f0u;
  return by_blocks ^ swap ^ (swap << 4);
}

// The word of the lane's tile. `bits`: the lane's own, one for each round.
uvec2 tile_word(uint bits) {
  uvec2 word = uvec2(0u);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uvec4 lanes = ballot((bits & (1u << r)) != 0u);
    uint shift = r * LANES;
    if (LANES >= 64) word = kTiles == 1u || lane() < 64u ? lanes.xy : lanes.zw;
    else if (shift < 32u) word.x |= lanes.x << (shift & 31u);
    else word.y |= lanes.x << (shift & 31u);
  }
  return uvec2(by_rows(word.x), by_rows(word.y));
}

// The tile that the lane traces a part of. It may lie beyond the last column, where it shows nothing.
uvec2 tile_of_lane() {
  return kTiles == 1u ? gl_WorkGroupID.xy : uvec2(gl_WorkGroupID.x * kTiles + lane() / 64u, gl_WorkGroupID.y);
}

void load_pixels(out Pixels pixels) {
  pixels.shown = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uvec2 pixel = tile_of_lane() * 8u + pixel_in_tile((r * LANES + lane()) % 64u);
    uint id = triangle_at(pixel);
    SurfacePoint surface = surface_of(max(id, 1u) - 1u, pixel);
    pixels.normal[r] = surface.normal;
    pixels.origin[r] = segment_origin(frame.camera, surface);
    pixels.shown |= id != 0u ? 1u << r : 0u;
  }
}

// The leaves of one light for a lane's pixels, and the results of their planes, with a bit for each round.
struct Asked {
  LightView view;
  uint leaf[kRounds];
  uint first[kRounds], count[kRounds];  // as the leaf has them
  uint place[kRounds];  // on the face, x in the low half
  float depth[kRounds];
  uint lit, undecided;
};

// Selects the element, because an array that is indexed by a variable would be kept in memory.
uint chosen(uint list[kRounds], uint round) {
  uint value = list[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) value = round == r ? list[r] : value;
  return value;
}

// The rounds whose segments to the light are traced.
uint care_bits(uint light, Pixels pixels) {
  TracedLight traced = frame.lights[light];
  uint care = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r)
    care |= segment_to_light(pixels.origin[r], pixels.normal[r], traced).traced ? 1u << r : 0u;
  return care & pixels.shown;
}

// Those of the pixels `asking` that lie behind the cover plane of their leaves.
uint covered(inout Asked asked, Pixels pixels, uint asking) {
  uint dark = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    FarSide far = far_side(asked.leaf[r]);
    asked.count[r] = far.count;
    dark |= dot(far.cover_plane, pixels.origin[r] - asked.view.reference) > 1.0 ? 1u << r : 0u;
  }
  return dark & asking;
}

// Those of the pixels `asking` that lie in front of the first entry of their lists. The walks of the others find it in the
// cache.
uint before_lists(Asked asked, uint asking) {
  uint before = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    bool asks = (asking & (1u << r)) != 0u;
    before |= asks && in_front(bounds_at(asks ? asked.first[r] : 0u), asked.depth[r]) ? 1u << r : 0u;
  }
  return before;
}

// Proceeds in steps over all rounds, so that the loads of a step, which mostly miss the cache, overlap. The near planes
// alone decide most tiles.
Asked ask_planes(uint light, Pixels pixels, uint care) {
  Asked asked;
  asked.view = LightViews(push.views).at[light];
  Place place[kRounds];
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    place[r] = place_of(asked.view, pixels.origin[r] - asked.view.reference);
    asked.depth[r] = place[r].depth;
    asked.place[r] = place[r].at.x | place[r].at.y << 16;
  }
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) asked.leaf[r] = cell_at(asked.view, place[r]);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) asked.leaf[r] = leaf_at(asked.leaf[r], place[r]);
  uint before = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    NearSide near = near_side(asked.leaf[r]);
    asked.first[r] = near.first;
    before |= dot(near.near_plane, pixels.origin[r] - asked.view.reference) < 1.0 ? 1u << r : 0u;
  }
  asked.lit = before & care;
  asked.undecided = care & ~before;
  if (any_lane(asked.undecided != 0u)) asked.undecided &= ~covered(asked, pixels, asked.undecided);
  if (any_lane(asked.undecided != 0u)) {
    uint before_all = before_lists(asked, asked.undecided);
    asked.lit |= before_all;
    asked.undecided &= ~before_all;
  }
  return asked;
}

// The direction that shadow_segment computes.
vec3 direction_of(LightView view, vec3 origin) {
  precise vec3 to_light = view.reference - origin;
  return view.directional != 0u ? view.direction : to_light;
}

void store_words(uint light, uint lit, uint care) {
  if (frame.planes[light] == kLeftOut) return;
  uvec2 mask_word = tile_word(lit), care_word = tile_word(care);
  uvec2 tile = tile_of_lane();
  bool is_first_of_tile = lane() % 64u == 0u;
  if (is_first_of_tile && (kTiles == 1u || tile.x < frame.tiles_x)) {
    uint word = frame.planes[light] * frame.tile_count + tile.y * frame.tiles_x + tile.x;
    push.masks.at[word] = mask_word;
    push.valid_bits.at[word] = care_word;
  }
}

bool meets(uint triangle, vec3 origin, vec3 direction) {
  TriangleCorners corners = corners_of(triangle);
  return segment_meets_triangle(origin, direction, corners.p0, corners.p1, corners.p2);
}

bool passes_alpha(uint triangle, vec3 origin, vec3 direction) {
  TriangleCorners corners = corners_of(triangle);
  return blocks_by_alpha(triangle, origin, direction, corners.p0, corners.p1, corners.p2);
}
