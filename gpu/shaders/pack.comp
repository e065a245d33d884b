#version 460
#extension GL_GOOGLE_include_directive : require
#include "pack.glsl"

// Writes the class of each word, and for the mixed words of each invocation their place within the workgroup; behind all
// invocations' places, how many each workgroup has.
layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  Uints classes;
  Uints mixed_places;
  uint words;
  uint words_of_light;
  uint any_untraced;
  uint untraced[8];
} push;

uint class_of(uvec2 lit, uvec2 care) {
  uvec2 lit_bits = lit & care, dark_bits = ~lit & care;
  bool any_lit = (lit_bits.x | lit_bits.y) != 0u, any_dark = (dark_bits.x | dark_bits.y) != 0u;
  return any_lit ? (any_dark ? kMixed : kLit) : (any_dark ? kDark : kFree);
}

bool traced(uint word) {
  uint light = word / push.words_of_light;
  return light >= 256u || ((push.untraced[light / 32u] >> (light % 32u)) & 1u) == 0u;  // else occlusion
}

shared uint counts[INVOCATIONS];  // of mixed words

// The sum of the counts before invocation `i`.
uint counts_before(uint i) {
  uint sum = 0u;
  for (uint k = 0u; k < i; ++k) sum += counts[k];
  return sum;
}

void main() {
  uint i = gl_LocalInvocationIndex, group = gl_GlobalInvocationID.x, first = group * kClassesInWord;
  uint classes = 0u, mixed = 0u;
  uint count = first < push.words ? min(kClassesInWord, push.words - first) : 0u;
  for (uint w = 0u; w < count; ++w) {
    uint of_word = class_of(push.masks.at[first + w], push.valid_bits.at[first + w]);
    if (push.any_untraced != 0u && !traced(first + w)) of_word = kLit;
    classes |= of_word << (2u * w);
    mixed += of_word == kMixed ? 1u : 0u;
  }
  counts[i] = mixed;
  barrier();
  uint groups = groups_of(push.words), place = counts_before(i);
  if (group < groups) {
    push.classes.at[group] = classes;
    push.mixed_places.at[group] = place;
  }
  if (i == INVOCATIONS - 1u && push.words > 0u) push.mixed_places.at[groups + gl_WorkGroupID.x] = place + mixed;
}
