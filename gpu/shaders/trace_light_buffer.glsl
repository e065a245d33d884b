// The trace pass with light buffers: one subgroup of LANES answers for one 8x8 tile and stores for each light a word of
// bits and a word that says which of them were asked for.
//
// Written for vector units too (lavapipe): a branch that lanes agree on is jumped over, any other is masked.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_EXT_control_flow_attributes : require
#include "frame.glsl"
#define TILE_INVOCATIONS LANES
#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer TileWords { uvec2 at[]; };

layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords cares;
  uvec2 grid;
  uvec2 leaves;
  uvec2 entries;
  uvec2 corners;  // of every triangle, three positions
  uvec2 views;
  uint first_masked;
  uint reserved;
} push;

const uint kNone = 0xffffffffu;
const uint kRounds = 64u / LANES;  // pixels of a lane

#include "tracers/light_buffer.glsl"

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

uvec2 tile_word(uint bits) {
  uvec2 word = uvec2(0u);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uint lanes = subgroupBallot((bits & (1u << r)) != 0u).x;
    uint shift = r * LANES;
    if (shift < 32u) word.x |= lanes << (shift & 31u);
    else word.y |= lanes << (shift & 31u);
  }
  return uvec2(by_rows(word.x), by_rows(word.y));
}

void load_pixels(out Pixels pixels) {
  pixels.shown = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(r * LANES + gl_SubgroupInvocationID);
    uint id = triangle_at(pixel);
    pixels.surface[r] = surface_of(max(id, 1u) - 1u, pixel);
    pixels.origin[r] = segment_origin(frame.camera, pixels.surface[r]);
    pixels.shown |= id != 0u ? 1u << r : 0u;
  }
}

// One light's leaves, and what their planes say in bits of rounds.
struct Asked {
  LightView view;
  uint leaf[kRounds];
  uint place[kRounds];  // on the face, x in the low half
  float depth[kRounds];
  uint lit, undecided;
};

// Where a segment is traced at all.
uint care_bits(uint light, Pixels pixels) {
  TracedLight traced = frame.lights[light];
  uint care = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r)
    care |= shadow_segment(frame.camera, pixels.surface[r], traced).traced ? 1u << r : 0u;
  return care & pixels.shown;
}

// In steps over all rounds, so that one step's loads, which mostly miss the cache, are under way together.
Asked ask_planes(uint light, Pixels pixels, uint care) {
  Asked asked;
  asked.view = LightViews(push.views).at[light];
  asked.lit = asked.undecided = 0u;
  Place place[kRounds];
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    place[r] = place_of(asked.view, pixels.origin[r] - asked.view.reference);
    asked.depth[r] = place[r].depth;
    asked.place[r] = place[r].at.x | place[r].at.y << 16;
  }
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) asked.leaf[r] = cell_at(asked.view, place[r]);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) asked.leaf[r] = leaf_at(asked.leaf[r], place[r]);
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    vec3 rel = pixels.origin[r] - asked.view.reference;
    bool before = dot(Leaves(push.leaves).at[asked.leaf[r]].near_plane, rel) < 1.0;
    bool behind = dot(Leaves(push.leaves).at[asked.leaf[r]].cover_plane, rel) > 1.0;
    asked.lit |= before ? 1u << r : 0u;
    asked.undecided |= !before && !behind ? 1u << r : 0u;
  }
  asked.lit &= care;
  asked.undecided &= care;
  // A look at every list's first entry, here where loads overlap: the walks find it in the cache.
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    bool walks = (asked.undecided & (1u << r)) != 0u;
    uint first = walks ? Leaves(push.leaves).at[asked.leaf[r]].first : 0u;
    bool before = walks && asked.depth[r] * Entries(push.entries).at[first].reciprocal_depth < 1.0;
    asked.lit |= before ? 1u << r : 0u;
  }
  asked.undecided &= ~asked.lit;
  return asked;
}

// The very direction of shadow_segment.
vec3 direction_of(LightView view, vec3 origin) {
  precise vec3 to_light = view.reference - origin;
  return view.directional != 0u ? view.direction : to_light;
}

// One pixel's way through its leaf's list.
struct Walk {
  uint round;
  vec3 origin;
  vec3 direction;
  float depth;
  uint place;      // in the leaf
  uint next, end;  // entries
};

Walk start_walk(Asked asked, Pixels pixels, uint round) {
  Walk walk;
  uint leaf = asked.leaf[0];
  uint at = asked.place[0];
  walk.depth = asked.depth[0];
  walk.origin = pixels.origin[0];
  // By selection: an array that is indexed by a variable would live in memory, element by element.
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) {
    leaf = round == r ? asked.leaf[r] : leaf;
    at = round == r ? asked.place[r] : at;
    walk.depth = round == r ? asked.depth[r] : walk.depth;
    walk.origin = round == r ? pixels.origin[r] : walk.origin;
  }
  walk.round = round;
  walk.direction = direction_of(asked.view, walk.origin);
  uint count = Leaves(push.leaves).at[leaf].count;
  walk.place = place_in_leaf(uvec2(at & 0xffffu, at >> 16), count);
  walk.next = Leaves(push.leaves).at[leaf].first;
  walk.end = walk.next + (count & ((1u << kCountBits) - 1u));
  return walk;
}

// The next triangle that may block; kNone: no more.
uint next_candidate(inout Walk walk) {
  uint candidate = kNone;
  while (candidate == kNone && walk.next < walk.end) {
    ListEntry entry = Entries(push.entries).at[walk.next];
    bool behind = walk.depth * entry.reciprocal_depth >= 1.0;
    candidate = behind && in_box(entry.box, walk.place) ? entry.triangle : kNone;
    walk.next = behind ? walk.next + 1u : walk.end;
  }
  return candidate;
}

bool meets(uint triangle, Walk walk) {
  return segment_meets_triangle(walk.origin, walk.direction, Vec3s(push.corners).at[3u * triangle],
                                Vec3s(push.corners).at[3u * triangle + 1u], Vec3s(push.corners).at[3u * triangle + 2u]);
}

bool passes_alpha(uint triangle, Walk walk) {
  return blocks_by_alpha(triangle, walk.origin, walk.direction, Vec3s(push.corners).at[3u * triangle],
                         Vec3s(push.corners).at[3u * triangle + 1u], Vec3s(push.corners).at[3u * triangle + 2u]);
}

// Of the pixels `asking`, in bits of rounds, those that an opaque triangle blocks; `masked`: those of the others that
// meet a triangle with an alpha test. A lane that is done with one pixel takes its next.
uint blocked_pixels(Asked asked, Pixels pixels, uint asking, out uint masked) {
  uint blocked = 0u;
  masked = 0u;
  Walk walk;
  walk.next = walk.end = 0u;
  while (asking != 0u || walk.next < walk.end) {
    if (walk.next >= walk.end) {
      walk = start_walk(asked, pixels, uint(findLSB(asking)));
      asking &= asking - 1u;
    }
    uint candidate = next_candidate(walk);
    if (candidate != kNone && meets(candidate, walk)) {
      bool opaque = candidate < push.first_masked;
      blocked |= opaque ? 1u << walk.round : 0u;
      masked |= opaque ? 0u : 1u << walk.round;
      walk.next = opaque ? walk.end : walk.next;
    }
  }
  masked &= ~blocked;
  return blocked;
}

// Of the pixels `asking`, those that an alpha-tested triangle blocks.
uint blocked_by_masked(Asked asked, Pixels pixels, uint asking) {
  uint blocked = 0u;
  for (; asking != 0u; asking &= asking - 1u) {
    Walk walk = start_walk(asked, pixels, uint(findLSB(asking)));
    while (walk.next < walk.end) {
      uint candidate = next_candidate(walk);
      if (candidate != kNone && candidate >= push.first_masked && meets(candidate, walk) &&
          passes_alpha(candidate, walk)) {
        blocked |= 1u << walk.round;
        walk.next = walk.end;
      }
    }
  }
  return blocked;
}

// The undecided pixels that nothing blocks.
uint walk_lists(Asked asked, Pixels pixels) {
  uint masked;
  uint blocked = blocked_pixels(asked, pixels, asked.undecided, masked);
  if (subgroupAny(masked != 0u)) blocked |= blocked_by_masked(asked, pixels, masked);
  return asked.undecided & ~blocked;
}

void main() {
  Pixels pixels;
  load_pixels(pixels);
  uint tile = gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
  for (uint light = 0u; light < frame.light_count; ++light) {
    uint care = care_bits(light, pixels);
    uint lit = 0u;
    if (subgroupAny(care != 0u)) {
      Asked asked = ask_planes(light, pixels, care);
      lit = asked.lit;
      if (subgroupAny(asked.undecided != 0u)) lit |= walk_lists(asked, pixels);
    }
    uvec2 mask_word = tile_word(lit), care_word = tile_word(care);
    if (subgroupElect()) {
      uint word = light * frame.tile_count + tile;
      push.masks.at[word] = mask_word;
      push.cares.at[word] = care_word;
    }
  }
}
