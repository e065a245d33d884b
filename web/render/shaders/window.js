// gpu/shaders/shade.glsl where pixels around have a say, those that show the same surface: with its filter, which averages
// the shares of area lights and of ambient light; and where not every pixel counts what occludes its ambient light.
export const SAME_SURFACE = `
// 5x5 pixels: the weights 1, 2, 2, 2, 1 in each direction are the mean of the four 4x4 windows that contain the pixel, of
// which each has every sample point.
const int kWindow = 25, kOwn = 12;  // \`kOwn\`: the pixel itself

ivec2 step_in_window(int i) { return ivec2(i % 5, i / 5) - 2; }

// Those pixels of the window that show the same surface, as bits: of a normal within 8 degrees, and near its plane.
// \`reach\`: how many steps are looked at; \`apart\`: pixels between them.
uint same_surface(SurfacePoint surface, ivec2 pixel, int reach, int apart) {
  uint like = 1u << kOwn;
  float room = 0.004 * distance(surface.position, camera);
  for (int i = 0; i < kWindow; ++i) {
    ivec2 at = pixel + step_in_window(i) * apart, off = abs(step_in_window(i));
    if (i == kOwn || max(off.x, off.y) > reach) continue;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, textureSize(ids, 0)))) continue;
    uint id = texelFetch(ids, at, 0).x;
    if (id == 0u) continue;
    SurfacePoint other = surface_of(triangle_of(id - 1u), at);
    bool on_plane = abs(dot(other.position - surface.position, surface.normal)) <= room;
    if (on_plane && dot(other.normal, surface.normal) > 0.99) like |= 1u << i;
  }
  return like;
}
`;

export const WINDOW =
  SAME_SURFACE +
  `
uniform bool filtered;    // false: counts are taken as they are
uniform bool halved;      // pixels of even column and row alone count occlusion
uniform int window_step;  // how far apart a window's pixels are
uniform usampler2D sources;  // as sources.js makes them of the view
uniform ivec2 seen_size;

// The pixel of the masks that shows the surface of a pixel of the view.
ivec2 source_at(ivec2 pixel) {
#if LOOKUP == 1
  return pixel;
#else
  int source = int(texelFetch(sources, pixel, 0).x) - 1;
  return source < 0 ? kUnknown : ivec2(source % seen_size.x, source / seen_size.x);
#endif
}

ivec2 pixel_in_window(ivec2 pixel, int i) { return pixel + step_in_window(i) * window_step; }

float weight_in_window(int i) {
  ivec2 off = abs(step_in_window(i));
  return (off.x == 2 ? 1.0 : 2.0) * (off.y == 2 ? 1.0 : 2.0);
}

Place place_of(SurfacePoint surface, ivec2 pixel) {
  int reach = filtered ? 2 : 1;  // those next to the pixel are enough to find a count of occlusion
  return Place(pixel, source_at(pixel), same_surface(surface, pixel, reach, window_step));
}

// Where wholly lit and wholly dark pixels lie side by side, the edge is sharper than the window, and the pixel keeps its
// own count.
float visible(int light, Place place) {
  float own = share_at(light, place.source);
  if (!filtered || samples_of(light) == 1) return own;
  float sum = 0.0, weights = 0.0;
  bool lit = false, dark = false;
  for (int i = 0; i < kWindow; ++i) {
    if ((place.like >> i & 1u) == 0u) continue;
    float share = share_at(light, source_at(pixel_in_window(place.pixel, i)));
    sum += weight_in_window(i) * share;
    weights += weight_in_window(i);
    lit = lit || share == 1.0;
    dark = dark || share == 0.0;
  }
  return lit && dark ? own : sum / weights;
}

bool counts_occlusion(ivec2 source) { return source.x >= 0 && (!halved || ((source.x | source.y) & 1) == 0); }

// A pixel without a count takes the mean of those next to it that show the same surface; where none of them has one, as at
// a twig thinner than two pixels, it is open.
float openness(Place place) {
  if (place.source.x < 0 || occlusion_plane < 0) return 1.0;
  if (!filtered && counts_occlusion(place.source)) return open_share(place.source);
  float sum = 0.0, weights = 0.0;
  for (int i = 0; i < kWindow; ++i) {
    if ((place.like >> i & 1u) == 0u) continue;
    ivec2 source = source_at(pixel_in_window(place.pixel, i));
    if (!counts_occlusion(source)) continue;
    sum += weight_in_window(i) * open_share(source);
    weights += weight_in_window(i);
  }
  return weights > 0.0 ? sum / weights : 1.0;
}
`;
