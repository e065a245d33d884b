// Means over the newest masks and some before them: for each pixel of the newest masks' view, and for one light or the
// ambient light, how much of it the surface sees. Of the masks before those count that show the same surface, unless what
// they counted is not to be found around the pixel in the newest masks.
import { EXACT } from './exact.js';
import { SCENE, VIEW } from './frame.js';
import { SAME_SURFACE } from './window.js';

/** Shares are stored as so many parts: of 4, 8 and 16 points, and as means over up to four masks, they are whole numbers. */
export const PARTS = 192;

/** How the shading pass reads a share: as the quotient that the points themselves give, where only one mask counts. */
export const SHARE_OF_PARTS = `
uniform usampler2DArray shares;
uniform int occlusion_layer;

float share_of(int layer, ivec2 source) {
  uint parts = texelFetch(shares, ivec3(source, layer), 0).x;
  return parts % 3u == 0u ? float(parts / 3u) / ${PARTS / 3}.0 : float(parts) / ${PARTS}.0;
}
`;

/** Which pixels around show the same surface, as bits; 0 where there is none. */
export const ALIKE =
  EXACT +
  SCENE +
  VIEW +
  `
uniform usampler2D ids;
` +
  SAME_SURFACE +
  `
out uint alike;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint id = texelFetch(ids, pixel, 0).x;
  alike = id == 0u ? 0u : same_surface(surface_of(triangle_of(id - 1u), pixel), pixel, 2, 1);
}
`;

export const ACCUMULATE = `
uniform usampler2D alike;
uniform usampler2DArray masks;
uniform usampler2DArray earlier_masks_0;
uniform usampler2DArray earlier_masks_1;
uniform usampler2DArray earlier_masks_2;
uniform usampler2D sources_0;  // of each earlier view, as sources.js makes them
uniform usampler2D sources_1;
uniform usampler2D sources_2;
uniform int earlier;           // how many there are
uniform int first_plane;
uniform int samples;
uniform bool halved;           // pixels of even column and row alone count
out uint share;                // of ${PARTS} parts

int bit_of(usampler2DArray of, int plane, ivec2 pixel) {
  uvec2 word = texelFetch(of, ivec3(pixel >> 3, plane), 0).xy;
  uint bit = uint((pixel.y & 7) * 8 + (pixel.x & 7));
  return int((bit < 32u ? word.x >> bit : word.y >> (bit - 32u)) & 1u);
}

int parts_in(usampler2DArray of, ivec2 pixel) {
  if (bit_of(of, first_plane, pixel) == 1) return ${PARTS};
  int number = 0;
  for (int left = samples, plane = first_plane + 1; left > 1; left >>= 1, ++plane)
    number = 2 * number + bit_of(of, plane, pixel);
  return number * (${PARTS} / samples);
}

bool counts(ivec2 pixel) { return !halved || ((pixel.x | pixel.y) & 1) == 0; }

int sum, masks_counted;
ivec2 range;  // of what the newest masks count around, and a point more

void add(usampler2DArray of, usampler2D sources, ivec2 pixel, int width) {
  int source = int(texelFetch(sources, pixel, 0).x) - 1;
  if (source < 0) return;
  ivec2 at = ivec2(source % width, source / width);
  if (!counts(at)) return;
  int parts = parts_in(of, at);
  if (parts < range.x || parts > range.y) return;
  sum += parts;
  ++masks_counted;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint same = texelFetch(alike, pixel, 0).x;
  sum = parts_in(masks, pixel);
  masks_counted = 1;
  range = ivec2(sum);
  if (same != 0u && counts(pixel)) {
    int apart = halved ? 2 : 1;  // of those that count
    for (int i = 0; i < 9; ++i) {
      ivec2 off = (ivec2(i % 3, i / 3) - 1) * apart;
      if ((same >> (12 + 5 * off.y + off.x) & 1u) == 0u) continue;
      int parts = parts_in(masks, pixel + off);
      range = ivec2(min(range.x, parts), max(range.y, parts));
    }
    // An edge sharper than these pixels lies elsewhere between the pixels of each mask.
    int used = range == ivec2(0, ${PARTS}) ? 0 : earlier;
    range += ivec2(-1, 1) * (${PARTS} / samples);
    int width = textureSize(sources_0, 0).x;
    if (used > 0) add(earlier_masks_0, sources_0, pixel, width);
    if (used > 1) add(earlier_masks_1, sources_1, pixel, width);
    if (used > 2) add(earlier_masks_2, sources_2, pixel, width);
  }
  share = uint(sum / masks_counted);
}
`;
