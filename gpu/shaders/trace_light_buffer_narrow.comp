// For subgroups of 4, 8 and 16 lanes. Traces light by light, for vector units (lavapipe): a branch on which all lanes
// agree is jumped over, any other one is masked, and a loop's body runs at least once. Hence rare work is in loops and
// branches of its own.
#version 460
#extension GL_GOOGLE_include_directive : require
#define LIGHT_BUFFER_SET 2
#include "trace_light_buffer.glsl"

// The state of one pixel's walk through its leaf's list.
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
  uint at = chosen(asked.place, round), count = chosen(asked.count, round);
  walk.depth = asked.depth[0];
  walk.origin = pixels.origin[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) {
    walk.depth = round == r ? asked.depth[r] : walk.depth;
    walk.origin = round == r ? pixels.origin[r] : walk.origin;
  }
  walk.round = round;
  walk.direction = direction_of(asked.view, walk.origin);
  walk.place = place_in_leaf(uvec2(at & 0xffffu, at >> 16), count);
  walk.next = chosen(asked.first, round);
  walk.end = walk.next + (count & ((1u << kCountBits) - 1u));
  return walk;
}

// The next triangle of the list that may block; kNone if there is none.
uint next_candidate(inout Walk walk) {
  uint found = kNone;  // the number of its entry
  while (found == kNone && walk.next < walk.end) {
    EntryBounds bounds = bounds_at(walk.next);
    bool behind = !in_front(bounds, walk.depth);
    found = behind && holds(bounds, walk.place) ? walk.next : kNone;
    walk.next = behind ? walk.next + 1u : walk.end;
  }
  return found == kNone ? kNone : triangle_of(found);
}

// Returns those of the pixels `asking`, with a bit for each round, that an opaque triangle blocks. `masked`: those of
// the others that meet a triangle with an alpha test. A lane that has finished a pixel continues with its next.
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
    if (candidate != kNone && meets(candidate, walk.origin, walk.direction)) {
      bool opaque = candidate < push.first_masked;
      blocked |= opaque ? 1u << walk.round : 0u;
      masked |= opaque ? 0u : 1u << walk.round;
      walk.next = opaque ? walk.end : walk.next;
    }
  }
  masked &= ~blocked;
  return blocked;
}

// Returns those of the pixels `asking` that a triangle with an alpha test blocks.
uint blocked_by_masked(Asked asked, Pixels pixels, uint asking) {
  uint blocked = 0u;
  for (; asking != 0u; asking &= asking - 1u) {
    Walk walk = start_walk(asked, pixels, uint(findLSB(asking)));
    while (walk.next < walk.end) {
      uint candidate = next_candidate(walk);
      if (candidate != kNone && candidate >= push.first_masked && meets(candidate, walk.origin, walk.direction) &&
          passes_alpha(candidate, walk.origin, walk.direction)) {
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
  if (any_lane(masked != 0u)) blocked |= blocked_by_masked(asked, pixels, masked);
  return asked.undecided & ~blocked;
}

void main() {
  Pixels pixels;
  load_pixels(pixels);
  for (uint light = 0u; light < frame.light_count; ++light) {
    if (frame.planes[light] == kLeftOut) continue;
    uint care = care_bits(light, pixels);
    uint lit = 0u;
    if (any_lane(care != 0u)) {
      Asked asked = ask_planes(light, pixels, care);
      lit = asked.lit;
      if (any_lane(asked.undecided != 0u)) lit |= walk_lists(asked, pixels);
    }
    store_words(light, lit, care);
  }
}
