#version 460
#extension GL_GOOGLE_include_directive : require
#include "pack.glsl"

// Writes the class of each word, and for each invocation the number of its mixed words.
layout(push_constant, scalar) uniform Push {
  TileWords masks;
  TileWords valid_bits;
  Uints classes;
  Uints mixed_counts;
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

void main() {
  uint group = gl_GlobalInvocationID.x, first = group * kClassesInWord;
  if (first >= push.words) return;
  uint classes = 0u, mixed = 0u;
  uint count = min(kClassesInWord, push.words - first);
  for (uint i = 0u; i < count; ++i) {
    uint of_tile = class_of(push.masks.at[first + i], push.valid_bits.at[first + i]);
    if (push.any_untraced != 0u && !traced(first + i)) of_tile = kLit;
    classes |= of_tile << (2u * i);
    mixed += of_tile == kMixed ? 1u : 0u;
  }
  push.classes.at[group] = classes;
  push.mixed_counts.at[group] = mixed;
}
