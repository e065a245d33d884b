// Which of the sample points a pixel of each 4x4 block takes, as scenes::sample_pattern.
uint sample_pattern(uvec2 pixel) {
  uvec2 fine = pixel & 1u, coarse = (pixel >> 1) & 1u;
  uint within = ((fine.x ^ fine.y) << 1 | fine.y) & 3u, block = ((coarse.x ^ coarse.y) << 1 | coarse.y) & 3u;
  return 4u * block + within;
}
