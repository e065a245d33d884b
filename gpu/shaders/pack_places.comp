#version 460
#extension GL_GOOGLE_include_directive : require
#define INVOCATIONS 128  // the most that every device allows, because the loads of each invocation wait for memory
#include "pack.glsl"

// Replaces the counts of mixed words by their exclusive prefix sums, which are the places of each group's mixed words,
// and appends the total. One workgroup, in which each invocation sums a contiguous share of the groups.
layout(push_constant, scalar) uniform Push {
  Uints counts;  // become places
  uint words;
} push;

shared uint sums[INVOCATIONS];

void main() {
  uint groups = groups_of(push.words), share = (groups + INVOCATIONS - 1u) / INVOCATIONS;
  uint me = gl_LocalInvocationID.x, first = min(me * share, groups), end = min(first + share, groups);
  uint sum = 0u;
  for (uint g = first; g < end; ++g) sum += push.counts.at[g];
  sums[me] = sum;
  barrier();
  uint place = 0u;
  for (uint i = 0u; i < me; ++i) place += sums[i];
  for (uint g = first; g < end; ++g) {
    uint count = push.counts.at[g];
    push.counts.at[g] = place;
    place += count;
  }
  if (me == INVOCATIONS - 1u) push.counts.at[groups] = place;
}
