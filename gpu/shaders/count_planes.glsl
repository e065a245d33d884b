// Packs numbers that a workgroup has counted for the pixels of its tile into planes of the mask (common/light_planes.h).
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer TileWords { uvec2 at[]; };

const uint kMostPlanes = 5u;  // of one number

// The two halves of the words of every plane, then those of the word of pixels that have a number.
shared uint tile_words[2u * (kMostPlanes + 1u)];

// Both before the first gather_count and after store_count: barrier().
void clear_count(uint invocation) {
  if (invocation < 2u * (kMostPlanes + 1u)) tile_words[invocation] = 0u;
}

void gather(uint slot, bool set, uvec2 my_bit) {
  uvec2 bits = subgroupOr(set ? my_bit : uvec2(0u));
  if (subgroupElect()) {
    atomicOr(tile_words[2u * slot], bits.x);
    atomicOr(tile_words[2u * slot + 1u], bits.y);
  }
}

uvec2 gathered(uint slot) { return uvec2(tile_words[2u * slot], tile_words[2u * slot + 1u]); }

// The pixel's number, of 0 to `most`, if it has one. Every invocation calls this.
void gather_count(bool has, uint number, uint most, uint planes, uvec2 my_bit) {
  gather(kMostPlanes, has, my_bit);
  gather(0u, has && number == most, my_bit);
  for (uint plane = 1u; plane < planes; ++plane)
    gather(plane, has && number < most && ((number >> (planes - 1u - plane)) & 1u) != 0u, my_bit);
}

// One plane's word. The planes below the first matter only where the first is 0.
void store_plane(TileWords masks, TileWords valid_bits, uint word, uint plane) {
  uvec2 care = gathered(kMostPlanes);
  masks.at[word] = gathered(plane);
  valid_bits.at[word] = plane == 0u ? care : care & ~gathered(0u);
}
