// Traces all lights together: a lane walks the lists of its undecided pixels one after the other, whatever their light.
// The lengths of lists differ a hundredfold, so that lanes that waited for each other at every light would mostly wait.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_vote : require
#define LANES 32
#include "trace_light_buffer.glsl"

// A set of kRounds bits for each of LANES lights.
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

bool blocked(uint light, vec3 origin) {
  LightView view = LightViews(push.views).at[light];
  vec3 direction = direction_of(view, origin);
  Place place = place_of(view, origin - view.reference);
  Leaf leaf = Leaves(push.leaves).at[leaf_at(cell_at(view, place), place)];
  uint in_leaf = place_in_leaf(place.at, leaf.count);
  uint end = leaf.first + (leaf.count & ((1u << kCountBits) - 1u));
  for (uint e = leaf.first; e < end; ++e) {
    ListEntry entry = Entries(push.entries).at[e];
    if (in_front(entry, place.depth)) return false;
    if (holds(entry, in_leaf) && meets(entry.triangle, origin, direction) &&
        (entry.triangle < push.first_masked || passes_alpha(entry.triangle, origin, direction)))
      return true;
  }
  return false;
}

void main() {
  Pixels pixels;
  load_pixels(pixels);
  for (uint first = 0u; first < frame.light_count; first += LANES) {
    uint lights = min(frame.light_count - first, LANES);
    LaneBits care = no_bits(), lit = no_bits(), undecided = no_bits();
    for (uint k = 0u; k < lights; ++k) {
      uint light_care = care_bits(first + k, pixels);
      if (!subgroupAny(light_care != 0u)) continue;
      Asked asked = ask_planes(first + k, pixels, light_care);
      put_bits(care, k, light_care);
      put_bits(lit, k, asked.lit);
      put_bits(undecided, k, asked.undecided);
    }
    while ((undecided.at.x | undecided.at.y) != 0u) {
      uint index = take_bit(undecided);
      uint round = index % kRounds, k = index / kRounds;
      vec3 origin = pixels.origin[0];
      [[unroll]] for (uint r = 1u; r < kRounds; ++r) origin = round == r ? pixels.origin[r] : origin;
      put_bits(lit, k, blocked(first + k, origin) ? 0u : 1u << round);
    }
    for (uint k = 0u; k < lights; ++k) store_words(first + k, bits_of(lit, k), bits_of(care, k));
  }
}
