// Whether a triangle is hidden in an 8x8 block by what is drawn already, and how it hides what will be drawn.

// For each 8x8 block the bits of a depth, not negative, that is at most that of each of its pixels.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer DepthTiles { uint at[]; };

// Exceeds the relative rounding of a plane's depths within a block.
const float kDepthSlack = 1e-5;

// `block`: pixels of the block that `tile` is, at least one.
bool hidden(DepthTiles depth_tiles, uint tile, Plane plane, Pixels block) {
  vec2 nearest = vec2(plane.dx > 0.0 ? block.last.x : block.first.x, plane.dy > 0.0 ? block.last.y : block.first.y);
  return uintBitsToFloat(depth_tiles.at[tile]) > depth_at(plane, nearest) * (1.0 + kDepthSlack);
}

// Precondition: the triangle fills the block, of which these are all pixels.
void hide_behind(DepthTiles depth_tiles, uint tile, Plane plane, Pixels block) {
  vec2 farthest = vec2(plane.dx > 0.0 ? block.first.x : block.last.x, plane.dy > 0.0 ? block.first.y : block.last.y);
  atomicMax(depth_tiles.at[tile], floatBitsToUint(depth_at(plane, farthest) * (1.0 - kDepthSlack)));
}
