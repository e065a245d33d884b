// Packs masks. common/packed_mask.h defines the format and packs in C++.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

#ifndef INVOCATIONS
#define INVOCATIONS 64
#endif
layout(local_size_x = INVOCATIONS) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer TileWords { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Uints { uint at[]; };

// The number of words that an invocation packs: their classes fill one uint.
const uint kClassesInWord = 16u;
const uint kDark = 0u, kLit = 1u, kMixed = 2u, kFree = 3u;

uint groups_of(uint words) { return (words + kClassesInWord - 1u) / kClassesInWord; }
