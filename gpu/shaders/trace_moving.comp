#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require

// Traces moving lights and moving geometry, after the trace pass: moving lights are traced in the hierarchy of the
// resting geometry, and every pair that is still lit in the hierarchy of the moving geometry.
//
// A subgroup has an 8x8 tile, in rounds of one pixel for each lane, or a share of one. What moves is far from most ways to
// a light: the parts of its hierarchy that the subgroup's segments to a light may meet are found once for all of them, each
// lane looking at parts of its own, and lit pixels walk these alone.
#include "frame.glsl"
#define LANES_OF_PIPELINE
#include "surface.glsl"

#include "hierarchy.glsl"
#include "tracers/bvh.glsl"
#include "tracers/tile_shaft.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer TileWords { uvec2 at[]; };

// A subtree of the moving geometry's hierarchy: its nodes from `first` to `end` - 1. The parts hold all of its triangles.
struct Part {
  vec3 lo;
  uint first;
  vec3 hi;
  uint end;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Parts { Part at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  Hierarchy still;
  Hierarchy moving;
  Parts parts;
  uint part_count;  // at most 32
  uint moving_lights[8];
} push;

// Subgroups have 4 lanes or more; of 128, the upper half shows nothing.
const uint kMostRounds = 16u, kMostPartRounds = 8u;
const uint kRounds = kLanes * kSharers < 64u ? 64u / (kLanes * kSharers) : 1u;
const uint kPartRounds = kLanes < 32u ? 32u / kLanes : 1u;

struct Origins {
  vec3 at[kMostRounds];  // of the segments of the lane's pixels
  uint shown;            // a bit for each round
  vec3 lo, hi;           // bounds of the whole subgroup's
};

// The lane's pixel in its tile; 64 and above are none.
uint number_of(uint round) {
  return (round * kSharers + gl_SubgroupID % kSharers) * kLanes + gl_SubgroupInvocationID;
}

// The subgroup's tile. It may lie beyond the last column, where it shows nothing.
uvec2 my_tile() {
  uint tiles = gl_WorkGroupSize.x / (kLanes * kSharers);
  return uvec2(gl_WorkGroupID.x * tiles + gl_SubgroupID / kSharers, gl_WorkGroupID.y);
}

uvec2 pixel_of(uint round) { return my_tile() * 8u + pixel_in_tile(number_of(round) % 64u); }

SurfacePoint surface_in(uint round) {
  uvec2 pixel = pixel_of(round);
  return surface_of(max(triangle_at(pixel), 1u) - 1u, pixel);
}

// The round's bit in the tile's word.
uvec2 bit_of(uint round) {
  uvec2 in_tile = pixel_in_tile(number_of(round) % 64u);
  uint bit = in_tile.y * 8u + in_tile.x;
  return bit < 32u ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << (bit - 32u));
}

Origins load_origins() {
  Origins origins;
  origins.shown = 0u;
  const float nowhere = 3.4e38;
  origins.lo = vec3(nowhere);
  origins.hi = vec3(-nowhere);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uvec2 pixel = pixel_of(r);
    uint id = triangle_at(pixel);
    bool shows = number_of(r) < 64u && id != 0u;
    origins.at[r] = segment_origin(frame.camera, surface_of(max(id, 1u) - 1u, pixel));
    origins.shown |= shows ? 1u << r : 0u;
    origins.lo = min(origins.lo, shows ? origins.at[r] : vec3(nowhere));
    origins.hi = max(origins.hi, shows ? origins.at[r] : vec3(-nowhere));
  }
  origins.lo = subgroupMin(origins.lo);
  origins.hi = subgroupMax(origins.hi);
  return origins;
}

// Selects the element, because an array that is indexed by a variable would be kept in memory.
vec3 origin_of(Origins origins, uint round) {
  vec3 origin = origins.at[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) origin = round == r ? origins.at[r] : origin;
  return origin;
}

bool light_moves(uint light) { return ((push.moving_lights[light / 32u] >> (light % 32u)) & 1u) != 0u; }

// The tile's word of the light's mask.
uint word_of(uint light) {
  return frame.planes[light] * frame.tile_count + my_tile().y * frame.tiles_x + my_tile().x;
}

// The direction that shadow_segment computes.
vec3 direction_to(TracedLight light, vec3 origin) {
  precise vec3 along = light.direction * -light.reach;
  precise vec3 to_light = light.position - origin;
  return light.kind == 2u ? along : to_light;
}

// The lane's rounds whose bits are set in the tile's word.
uint rounds_in(uvec2 word) {
  uint rounds = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) rounds |= (word & bit_of(r)) != uvec2(0u) ? 1u << r : 0u;
  return rounds;
}

// The tile's word of which each lane has the bits of its rounds.
uvec2 word_with(uint rounds) {
  uvec2 word = uvec2(0u);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) word |= (rounds & (1u << r)) != 0u ? bit_of(r) : uvec2(0u);
  return subgroupOr(word);
}

// The rounds whose segments to the light are traced.
uint traced_rounds(TracedLight light, uint shown) {
  uint traced = 0u;
  for (uint r = 0u; r < kRounds; ++r)
    traced |= shadow_segment(frame.camera, surface_in(r), light).traced ? 1u << r : 0u;
  return traced & shown;
}

// The parts that the subgroup's segments to the light may meet, as bits.
uint near_parts(TracedLight light, Origins origins, Part mine[kMostPartRounds]) {
  TileShaft shaft = shaft_to(light, origins.lo, origins.hi);
  uint near = 0u;
  [[unroll]] for (uint r = 0u; r < kPartRounds; ++r) {
    uint part = r * kLanes + gl_SubgroupInvocationID;
    bool may = part < push.part_count && shaft_meets(shaft, mine[r].lo, mine[r].hi);
    near |= may ? 1u << part : 0u;
  }
  return subgroupOr(near);
}

bool meets_parts(uint parts, Way way) {
  Tree moving = Tree(push.moving, true);
  bool met = false;
  for (; parts != 0u && !met; parts &= parts - 1u) {
    Part part = push.parts.at[findLSB(parts)];
    uint n = part.first;
    while (n < part.end) {
      BvhNode node = node_at(moving, n);
      bool enter = enters(way, node);
      met = enter && node.leaf != 0u && leaf_blocks(moving, node.leaf, way.origin, way.direction);
      n = met ? part.end : enter ? n + 1u : node.skip;
    }
  }
  return met;
}

// Of the lane's rounds `asked`, those that nothing hides from the light.
uint lit_rounds(TracedLight light, bool moves, uint parts, Origins origins, uint asked) {
  uint lit = asked;
  for (; asked != 0u; asked &= asked - 1u) {
    uint round = uint(findLSB(asked));
    vec3 origin = origin_of(origins, round), direction = direction_to(light, origin);
    bool hidden = meets_parts(parts, way_of(origin, direction)) || (moves && meets(Tree(push.still, false), origin, direction));
    lit &= ~(hidden ? 1u << round : 0u);
  }
  return lit;
}

// Subgroups that share a tile read and change bits of their own in the same word.
void clear_bits(uint word, uvec2 bits) {
  if (bits.x != 0u) atomicAnd(push.masks.at[word].x, ~bits.x);
  if (bits.y != 0u) atomicAnd(push.masks.at[word].y, ~bits.y);
}

void set_bits(TileWords words, uint word, uvec2 bits) {
  if (bits.x != 0u) atomicOr(words.at[word].x, bits.x);
  if (bits.y != 0u) atomicOr(words.at[word].y, bits.y);
}

void trace_resting(uint i, Origins origins, Part parts[kMostPartRounds]) {
  uint word = word_of(i);
  uint lit = rounds_in(push.masks.at[word]);
  if (subgroupOr(lit) == 0u) return;
  uint near = near_parts(frame.lights[i], origins, parts);
  if (near == 0u) return;
  uvec2 hidden = word_with(lit & ~lit_rounds(frame.lights[i], false, near, origins, lit));
  if (subgroupElect()) clear_bits(word, hidden);
}

// The words are 0: the pass before has left the light out.
void trace_moved(uint i, Origins origins, Part parts[kMostPartRounds]) {
  uint traced = traced_rounds(frame.lights[i], origins.shown);
  uint near = near_parts(frame.lights[i], origins, parts);
  uvec2 lit_bits = word_with(lit_rounds(frame.lights[i], true, near, origins, traced));
  uvec2 traced_bits = word_with(traced);
  if (!subgroupElect()) return;
  set_bits(push.masks, word_of(i), lit_bits);
  set_bits(push.valid_bits, word_of(i), traced_bits);
}

void main() {
  if (my_tile().x >= frame.tiles_x) return;
  Origins origins = load_origins();
  Part parts[kMostPartRounds];
  [[unroll]] for (uint r = 0u; r < kPartRounds; ++r)
    parts[r] = push.parts.at[min(r * kLanes + gl_SubgroupInvocationID, max(push.part_count, 1u) - 1u)];
  for (uint i = 0u; i < frame.light_count; ++i) {
    if (frame.planes[i] != kLeftOut) {
      if (light_moves(i)) {
        trace_moved(i, origins, parts);
      } else {
        trace_resting(i, origins, parts);
      }
    }
  }
}
