// For subgroups of 32, 64 and 128 lanes. Traces all lights together: a lane walks the lists of its undecided pixels one
// after the other, whatever their light. The lengths of lists differ a hundredfold, so that lanes that waited for each
// other at every light would mostly wait.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "trace_light_buffer.glsl"

const uint kLightsAtATime = 64u / kRounds;

// A set of kRounds bits for each of kLightsAtATime lights.
struct LaneBits {
  uvec2 at;
};

LaneBits no_bits() { return LaneBits(uvec2(0u)); }

uint bits_of(LaneBits bits, uint light) {
  uint shift = light * kRounds;
  return (shift < 32u ? bits.at.x : bits.at.y) >> (shift & 31u) & ((1u << kRounds) - 1u);
}

void put_bits(inout LaneBits bits, uint light, uint value) {
  uint shift = light * kRounds;
  uint shifted = value << (shift & 31u);
  bits.at |= shift < 32u ? uvec2(shifted, 0u) : uvec2(0u, shifted);
}

// Removes the lowest bit and returns its index. Precondition: the set is not empty.
uint take_bit(inout LaneBits bits) {
  bool low = bits.at.x != 0u;
  uint lowest = uint(findLSB(low ? bits.at.x : bits.at.y));
  bits.at &= ~(low ? uvec2(1u << lowest, 0u) : uvec2(0u, 1u << lowest));
  return lowest + (low ? 0u : 32u);
}

// Entries that a lane walks alone; what is left of a longer list is walked by the whole subgroup.
#ifndef ENTRIES_ALONE
#define ENTRIES_ALONE 64
#endif
const uint kAlone = ENTRIES_ALONE;

// One pixel's walk through its leaf's list.
struct Walk {
  vec3 origin, direction;
  float depth;
  uint place;      // in the leaf
  uint next, end;  // entries
};

Walk start_walk(uint light, vec3 origin) {
  LightView view = LightViews(push.views).at[light];
  Place place = place_of(view, origin - view.reference);
  uint leaf = leaf_at(cell_at(view, place), place);
  uint first = near_side(leaf).first, count = far_side(leaf).count;
  return Walk(origin, direction_of(view, origin), place.depth, place_in_leaf(place.at, count), first,
              first + (count & ((1u << kCountBits) - 1u)));
}

bool blocks(ListEntry entry, Walk walk) {
  return holds(entry.bounds, walk.place) && meets(entry.triangle, walk.origin, walk.direction) &&
         (entry.triangle < push.first_masked || passes_alpha(entry.triangle, walk.origin, walk.direction));
}

const uint kLit = 0u, kBlocked = 1u, kUnknown = 2u;

// Precondition: the list is not empty, as no undecided pixel's is.
uint walk_alone(Walk walk) {
  uint end = min(walk.end, walk.next + kAlone);
  // A walk mostly waits for its entries: the next one is on its way while this one is looked at.
  ListEntry coming = entry_at(walk.next);
  for (uint e = walk.next; e < end; ++e) {
    ListEntry entry = coming;
    coming = entry_at(min(e + 1u, end - 1u));
    if (in_front(entry.bounds, walk.depth)) return kLit;
    if (blocks(entry, walk)) return kBlocked;
  }
  return end < walk.end ? kUnknown : kLit;
}

// What walk_alone left over. The walk is the same in all lanes, of which each looks at every LANES-th entry.
bool blocked_together(Walk walk) {
  for (uint first = walk.next + kAlone; first < walk.end; first += LANES) {
    uint e = first + lane();
    bool front = false, hit = false;
    if (e < walk.end) {
      ListEntry entry = entry_at(e);
      front = in_front(entry.bounds, walk.depth);
      hit = !front && blocks(entry, walk);
    }
    if (any_lane(hit)) return true;
    if (any_lane(front)) return false;
  }
  return false;
}

vec3 origin_of(Pixels pixels, uint round) {
  vec3 origin = pixels.origin[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) origin = round == r ? pixels.origin[r] : origin;
  return origin;
}

// Adds to `lit` what is lit of the undecided pixels of the lights from `first` on.
void walk_lists(uint first, Pixels pixels, LaneBits undecided, inout LaneBits lit) {
  LaneBits unknown = no_bits();
  while ((undecided.at.x | undecided.at.y) != 0u) {
    uint index = take_bit(undecided);
    uint round = index % kRounds, k = index / kRounds;
    uint found = walk_alone(start_walk(first + k, origin_of(pixels, round)));
    put_bits(lit, k, found == kLit ? 1u << round : 0u);
    put_bits(unknown, k, found == kUnknown ? 1u << round : 0u);
  }
  for (;;) {
    uvec4 waiting = ballot((unknown.at.x | unknown.at.y) != 0u);
    if (waiting == uvec4(0u)) break;
    uint turn = lowest_lane(waiting);
    bool mine = lane() == turn;
    uint index = mine ? take_bit(unknown) : 0u;
    index = broadcast(index, turn);
    uint round = index % kRounds, k = index / kRounds;
    vec3 origin = broadcast(origin_of(pixels, round), turn);
    bool dark = blocked_together(start_walk(first + k, origin));
    put_bits(lit, k, mine && !dark ? 1u << round : 0u);
  }
}

void main() {
  Pixels pixels;
  load_pixels(pixels);
  for (uint first = 0u; first < frame.light_count; first += kLightsAtATime) {
    uint lights = min(frame.light_count - first, kLightsAtATime);
    LaneBits care = no_bits(), lit = no_bits(), undecided = no_bits();
    for (uint k = 0u; k < lights; ++k) {
      if (frame.planes[first + k] == kLeftOut) continue;
      uint light_care = care_bits(first + k, pixels);
      if (!any_lane(light_care != 0u)) continue;
      Asked asked = ask_planes(first + k, pixels, light_care);
      put_bits(care, k, light_care);
      put_bits(lit, k, asked.lit);
      put_bits(undecided, k, asked.undecided);
    }
    walk_lists(first, pixels, undecided, lit);
    for (uint k = 0u; k < lights; ++k) store_words(first + k, bits_of(lit, k), bits_of(care, k));
  }
}
