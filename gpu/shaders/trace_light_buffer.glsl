// The trace pass with light buffers: one subgroup of LANES answers for one 8x8 tile and stores for each light a word of
// bits and a word that says which of them were asked for.
//
// A tile's pixels lie close together, so for each light one node that holds them all mostly answers all. Nodes are
// looked up for LANES lights at once, one in each lane. What they leave undecided every lane asks by itself, pixel by
// pixel and light by light, so that lanes are busy with different lights at the same time.
//
// Written for vector units without jumps (lavapipe masks branches instead of taking them, and runs a loop's body at
// least once): what can be skipped is a loop's second turn, and everything rare shares one loop.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_EXT_control_flow_attributes : require
#include "frame.glsl"
#define TILE_INVOCATIONS LANES
#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer TileWords { uvec2 at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords cares;
  uvec2 nodes;
  uvec2 lists;
  uvec2 views;
  uint first_masked;
  uint reserved;
} push;

const uint kRounds = 64u / LANES;  // pixels of a lane

#include "tracers/light_buffer.glsl"
#include "tracers/light_buffer_group.glsl"

struct Pixels {
  SurfacePoint surface[kRounds];
  vec3 origin[kRounds];
  uint shown;  // a bit for each round
};

// Tile words list pixels by rows, rounds by 4x2 blocks: the two differ by a swap of neighbouring quarters.
uint by_rows(uint by_blocks) {
  uint swap = ((by_blocks >> 4) ^ by_blocks) & 0x00f000f0u;
  return by_blocks ^ swap ^ (swap << 4);
}

uvec2 tile_word(uint lit) {
  uvec2 word = uvec2(0u);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uint bits = subgroupBallot((lit & (1u << r)) != 0u).x;
    uint shift = r * LANES;
    if (shift < 32u) word.x |= bits << (shift & 31u);
    else word.y |= bits << (shift & 31u);
  }
  return uvec2(by_rows(word.x), by_rows(word.y));
}

void load_pixels(out Pixels pixels, out Group group) {
  pixels.shown = 0u;
  group = empty_group();
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(r * LANES + gl_SubgroupInvocationID);
    uint id = triangle_at(pixel);
    pixels.surface[r] = surface_of(max(id, 1u) - 1u, pixel);
    pixels.origin[r] = segment_origin(frame.camera, pixels.surface[r]);
    pixels.shown |= id != 0u ? 1u << r : 0u;
    add_to_group(group, pixels.origin[r], pixels.surface[r].normal, id != 0u);
  }
  close_group(group);
}

// What the node says of every pixel of the lane: bits of rounds.
void ask_node(GroupNode node, uint light, Pixels pixels, out uint lit, out uint care, out uint undecided) {
  lit = 0u;
  care = 0u;
  undecided = 0u;
  TracedLight traced = frame.lights[light];
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    ShadowSegment segment = shadow_segment(frame.camera, pixels.surface[r], traced);
    vec3 rel = pixels.origin[r] - node.reference;
    bool before = node.known && dot(node.near_plane, rel) < 1.0;
    bool behind = node.known && dot(node.cover_plane, rel) > 1.0;
    care |= segment.traced ? 1u << r : 0u;
    lit |= segment.traced && before ? 1u << r : 0u;
    undecided |= segment.traced && !before && !behind ? 1u << r : 0u;
  }
  lit &= pixels.shown;
  care &= pixels.shown;
  undecided &= pixels.shown;
}

// pixels.origin[round], by selection: an array that is indexed by a variable would live in memory, element by element.
vec3 origin_of(Pixels pixels, uint round) {
  vec3 origin = pixels.origin[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) origin = round == r ? pixels.origin[r] : origin;
  return origin;
}

bool lit_alone(uint light, vec3 origin) {
  LightView view = LightViews(push.views).at[light];
  vec3 rel = origin - view.reference;
  // The very direction of shadow_segment.
  precise vec3 to_light = view.reference - origin;
  vec3 direction = view.directional != 0u ? view.direction : to_light;
  return !blocked_alone(view, view.directional != 0u ? rel : -to_light, origin, direction);
}

void main() {
  uint lane = gl_SubgroupInvocationID;
  Pixels pixels;
  Group group;
  load_pixels(pixels, group);
  uint tile = gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
  for (uint first = 0u; first < frame.light_count; first += LANES) {
    uint lights = min(frame.light_count - first, LANES);
    GroupNode mine = group_node(group, first + min(lane, lights - 1u));
    // Bits of rounds, kRounds for each light of the batch.
    uvec2 lit = uvec2(0u);
    uvec2 care = uvec2(0u);
    uvec2 undecided = uvec2(0u);
    uint todo = subgroupBallot(mine.wanted && lane < lights).x;
    for (; todo != 0u; todo &= todo - 1u) {
      uint k = uint(findLSB(todo));
      uint node_lit, node_care, node_undecided;
      ask_node(shuffled(mine, k), first + k, pixels, node_lit, node_care, node_undecided);
      uint shift = k * kRounds;
      bool low = shift < 32u;
      lit |= uvec2(low ? node_lit << (shift & 31u) : 0u, low ? 0u : node_lit << (shift & 31u));
      care |= uvec2(low ? node_care << (shift & 31u) : 0u, low ? 0u : node_care << (shift & 31u));
      undecided |= uvec2(low ? node_undecided << (shift & 31u) : 0u, low ? 0u : node_undecided << (shift & 31u));
    }
    while ((undecided.x | undecided.y) != 0u) {
      bool low = undecided.x != 0u;
      uint half_bit = uint(findLSB(low ? undecided.x : undecided.y));
      uvec2 bit = low ? uvec2(1u << half_bit, 0u) : uvec2(0u, 1u << half_bit);
      undecided &= ~bit;
      uint index = half_bit + (low ? 0u : 32u);
      vec3 origin = origin_of(pixels, index % kRounds);
      if (lit_alone(first + index / kRounds, origin)) lit |= bit;
    }
    uvec2 mine_word = uvec2(0u);
    uvec2 mine_care = uvec2(0u);
    for (uint k = 0u; k < lights; ++k) {
      uint shift = k * kRounds;
      uvec2 word = tile_word((shift < 32u ? lit.x : lit.y) >> (shift & 31u));
      mine_word = lane == k ? word : mine_word;
      uvec2 cares = tile_word((shift < 32u ? care.x : care.y) >> (shift & 31u));
      mine_care = lane == k ? cares : mine_care;
    }
    if (lane < lights) {
      push.masks.at[(first + lane) * frame.tile_count + tile] = mine_word;
      push.cares.at[(first + lane) * frame.tile_count + tile] = mine_care;
    }
  }
}
