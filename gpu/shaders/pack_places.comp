#version 460
#extension GL_GOOGLE_include_directive : require
#define INVOCATIONS 128  // what every device allows: one after the other waits for memory
#include "pack.glsl"

// Where each group's mixed words go: the sum of all counts before it; behind the last, of all. One workgroup, of
// which each invocation adds up a share of neighbouring groups.
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
