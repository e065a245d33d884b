#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "pack.glsl"

// Writes the classes, and the mixed words without gaps, directly to host memory, so that only as many bytes as needed
// cross the bus. A workgroup writes the words of as many groups as it has invocations: each of these looks up the places
// of one group, and then writes every INVOCATIONS-th word, so that neighbours in memory are neighbours in a subgroup.
layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  Uints classes;
  Uints mixed_places;
  Uints host_classes;
  TileWords host_mixed;
  Uints host_mixed_count;
  uint words;
} push;

// Shifts a word towards higher bits if `by` is positive. A row has 8 bits.
uvec2 shifted(uvec2 v, int by) {
  if (by == 32) return uvec2(0u, v.x);
  if (by == -32) return uvec2(v.y, 0u);
  if (by > 0) return uvec2(v.x << by, (v.y << by) | (v.x >> (32 - by)));
  return uvec2((v.x >> -by) | (v.y << (32 + by)), v.y >> -by);
}

// Keeps the columns that a shift along the row may reach.
uvec2 kept(uvec2 v, uint columns) { return v & uvec2(columns); }

// Gives unknown bits the value of the known bits at distance `by`, as Fill in common/packed_mask.cpp.
void take(inout uvec2 value, inout uvec2 known, int by, uint columns) {
  uvec2 from = kept(shifted(known, by), columns) & ~known;
  value |= shifted(value, by) & from;
  known |= from;
}

uvec2 filled(uvec2 lit, uvec2 care) {
  uvec2 value = lit & care, known = care;
  take(value, known, 8, 0xffffffffu);
  take(value, known, 16, 0xffffffffu);
  take(value, known, 32, 0xffffffffu);
  take(value, known, -8, 0xffffffffu);
  take(value, known, -16, 0xffffffffu);
  take(value, known, -32, 0xffffffffu);
  take(value, known, 1, 0xfefefefeu);
  take(value, known, 2, 0xfcfcfcfcu);
  take(value, known, 4, 0xf0f0f0f0u);
  take(value, known, -1, 0x7f7f7f7fu);
  take(value, known, -2, 0x3f3f3f3fu);
  take(value, known, -4, 0x0f0f0f0fu);
  return value;
}

shared uint mixed_before;  // mixed words of all workgroups before
// Of the workgroup's groups: the classes of their words, and the mixed words of groups before.
shared uint classes_of_group[INVOCATIONS], place_of_group[INVOCATIONS];

// Bit 2i is set if the group's word i is mixed.
uint mixed_words(uint classes) { return (classes >> 1) & ~classes & 0x55555555u; }

void main() {
  uint i = gl_LocalInvocationIndex, group = gl_GlobalInvocationID.x, groups = groups_of(push.words);
  if (i == 0u) mixed_before = 0u;
  classes_of_group[i] = 0u;
  if (group < groups) {
    classes_of_group[i] = push.classes.at[group];
    place_of_group[i] = push.mixed_places.at[group];
    push.host_classes.at[group] = classes_of_group[i];
  }
  barrier();
  uint sum = 0u;
  for (uint w = i; w < gl_WorkGroupID.x; w += INVOCATIONS) sum += push.mixed_places.at[groups + w];
  if (sum != 0u) atomicAdd(mixed_before, sum);
  barrier();
  bool is_last_workgroup = gl_WorkGroupID.x == gl_NumWorkGroups.x - 1u;
  if (is_last_workgroup && i == 0u)
    push.host_mixed_count.at[0] =
        push.words > 0u ? mixed_before + push.mixed_places.at[groups + gl_WorkGroupID.x] : 0u;
  uint first = gl_WorkGroupID.x * INVOCATIONS * kClassesInWord;
  uint bit = 1u << (2u * (i % kClassesInWord));
  [[unroll]] for (uint k = 0u; k < kClassesInWord; ++k) {
    uint w = k * INVOCATIONS + i;
    uint mixed = mixed_words(classes_of_group[w / kClassesInWord]);
    if ((mixed & bit) == 0u) continue;
    uint place = mixed_before + place_of_group[w / kClassesInWord] + uint(bitCount(mixed & (bit - 1u)));
    push.host_mixed.at[place] = filled(push.masks.at[first + w], push.valid_bits.at[first + w]);
  }
}
