#version 460
#extension GL_GOOGLE_include_directive : require
#include "pack.glsl"

// The class of each word, and how many of an invocation's words are mixed.
layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords cares;
  Uints classes;
  Uints mixed_counts;
  uint words;
} push;

uint class_of(uvec2 lit, uvec2 care) {
  uvec2 lit_bits = lit & care, dark_bits = ~lit & care;
  bool any_lit = (lit_bits.x | lit_bits.y) != 0u, any_dark = (dark_bits.x | dark_bits.y) != 0u;
  return any_lit ? (any_dark ? kMixed : kLit) : (any_dark ? kDark : kFree);
}

void main() {
  uint group = gl_GlobalInvocationID.x, first = group * kClassesInWord;
  if (first >= push.words) return;
  uint classes = 0u, mixed = 0u;
  uint count = min(kClassesInWord, push.words - first);
  for (uint i = 0u; i < count; ++i) {
    uint of_tile = class_of(push.masks.at[first + i], push.cares.at[first + i]);
    classes |= of_tile << (2u * i);
    mixed += of_tile == kMixed ? 1u : 0u;
  }
  push.classes.at[group] = classes;
  push.mixed_counts.at[group] = mixed;
}
