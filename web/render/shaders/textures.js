// gpu/shaders/textures.glsl: filtered colours of textures. Each level of each texture is a rectangle of an atlas.
export const TEXTURES = `
// How the texture coordinates change from one pixel to the next.
struct Footprint {
  vec2 dx;
  vec2 dy;
};

int wrapped_texel(int at, int wrap, int size) {
  if (wrap == 2) return clamp(at, 0, size - 1);
  int period = wrap == 0 ? size : 2 * size;
  int within = at - period * int(floor(float(at) / float(period)));
  within = clamp(within, 0, period - 1);
  return within < size ? within : period - 1 - within;
}

vec3 texel_colour(ivec3 corner, ivec2 at) {
  vec3 root = texelFetch(texels, ivec3(corner.xy + at, corner.z), 0).rgb;
  return root * root;
}

vec3 bilinear(MaterialRecord m, vec2 uv, int level) {
  ivec3 start = ivec3(texelFetch(records, place_in_list(m.first_level + uint(level)), 0).xyz);
  ivec2 size = max(m.texture_size >> level, ivec2(1));
  // Coordinates far from the origin are brought near first: a float has 24 bits for the whole and the part of a texel.
  vec2 near = uv - 2.0 * floor(0.5 * uv);
  if (m.wrap.x == 2) near.x = clamp(uv.x, -1.0, 2.0);
  if (m.wrap.y == 2) near.y = clamp(uv.y, -1.0, 2.0);
  vec2 place = near * vec2(size) - 0.5;
  ivec2 corner = ivec2(floor(place));
  vec2 part = place - vec2(corner);
  ivec2 low = ivec2(wrapped_texel(corner.x, m.wrap.x, size.x), wrapped_texel(corner.y, m.wrap.y, size.y));
  ivec2 high = ivec2(wrapped_texel(corner.x + 1, m.wrap.x, size.x), wrapped_texel(corner.y + 1, m.wrap.y, size.y));
  vec3 upper = mix(texel_colour(start, low), texel_colour(start, ivec2(high.x, low.y)), part.x);
  vec3 lower = mix(texel_colour(start, ivec2(low.x, high.y)), texel_colour(start, high), part.x);
  return mix(upper, lower, part.y);
}

// Up to this many samples along the longer axis of a footprint, so that floors seen at a low angle stay sharp.
const float kMostSamples = 6.0;

// textures.glsl has functions for one sample and for one level. Here they are loops, because compilers of browsers write
// out each call.
vec3 texture_colour(MaterialRecord m, vec2 uv, Footprint footprint) {
  vec2 size = vec2(m.texture_size);
  float across = length(footprint.dx * size), down = length(footprint.dy * size);
  float longer = max(max(across, down), 1e-6), shorter = max(min(across, down), 1e-6);
  bool far = !(longer < 1e6);
  float samples = clamp(ceil(longer / shorter), 1.0, kMostSamples);
  if (longer <= 1.0 || far) samples = 1.0;  // magnified, or beyond measure
  float level = far ? float(m.levels) : log2(max(longer / samples, 1.0));
  vec2 axis = far ? vec2(0.0) : across >= down ? footprint.dx : footprint.dy;
  float sharpest = clamp(level, 0.0, float(m.levels - 1));
  int first = int(sharpest);
  float part = sharpest - float(first);
  int levels = part < 0.01 ? 1 : 2;
  vec3 sum = vec3(0.0);
  for (float i = 0.0; i < samples; i += 1.0) {
    vec2 place = uv + axis * ((i + 0.5) / samples - 0.5);
    for (int j = 0; j < levels; ++j) {
      float weight = levels == 1 ? 1.0 : j == 0 ? 1.0 - part : part;
      sum += weight * bilinear(m, place, min(first + j, m.levels - 1));
    }
  }
  return sum / samples;
}
`;
