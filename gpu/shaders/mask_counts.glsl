// Reads what masks say of a pixel (common/tile_mask.h, common/light_planes.h).
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MaskWords { uvec2 at[]; };

bool mask_bit(MaskWords masks, uint plane, uvec2 pixel, uint tiles_x, uint tile_count) {
  uint tile = (pixel.y / 8u) * tiles_x + pixel.x / 8u;
  uint bit = (pixel.y % 8u) * 8u + pixel.x % 8u;
  uvec2 word = masks.at[plane * tile_count + tile];
  return ((bit < 32u ? word.x >> bit : word.y >> (bit - 32u)) & 1u) != 0u;
}

// The number, 0 to `most`, that the planes from there on say of that pixel.
uint counted(MaskWords masks, uint plane, uint most, uvec2 pixel, uint tiles_x, uint tile_count) {
  if (mask_bit(masks, plane, pixel, tiles_x, tile_count)) return most;
  uint number = 0u;
  for (int more = findMSB(most); more > 0; --more)
    number = 2u * number + uint(mask_bit(masks, ++plane, pixel, tiles_x, tile_count));
  return number;
}
