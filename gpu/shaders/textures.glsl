// Filtered colours of textures (gpu/scene/texels.h). They are sampled here instead of by the device's samplers, so that
// any number of textures needs no descriptors; alpha tests go on reading the nearest texel of level 0 (frame.glsl).

// How the texture coordinates change from one pixel to the next.
struct Footprint {
  vec2 dx;
  vec2 dy;
};

uint wrapped_texel(int at, uint wrap, int size) {
  if (wrap == 2u) return uint(clamp(at, 0, size - 1));
  int period = wrap == 0u ? size : 2 * size;
  int within = at - period * int(floor(float(at) / float(period)));
  within = clamp(within, 0, period - 1);
  return uint(within < size ? within : period - 1 - within);
}

vec3 texel_colour(MaterialRecord m, uint level_start, ivec2 size, ivec2 at) {
  uvec2 texel = uvec2(wrapped_texel(at.x, m.wrap.x, size.x), wrapped_texel(at.y, m.wrap.y, size.y));
  vec3 root = unpackUnorm4x8(Uints(m.texels).at[level_start + texel.y * uint(size.x) + texel.x]).rgb;
  return root * root;
}

vec3 bilinear(MaterialRecord m, vec2 uv, uint level) {
  uint start = 0u;
  uvec2 size = m.texture_size;
  for (uint i = 0u; i < level; ++i) {
    start += size.x * size.y;
    size = max(size / 2u, uvec2(1u));
  }
  // Coordinates far from the origin are brought near first: a float has 24 bits for the whole and the part of a texel.
  vec2 near = uv - 2.0 * floor(0.5 * uv);
  if (m.wrap.x == 2u) near.x = clamp(uv.x, -1.0, 2.0);
  if (m.wrap.y == 2u) near.y = clamp(uv.y, -1.0, 2.0);
  vec2 place = near * vec2(size) - 0.5;
  ivec2 corner = ivec2(floor(place));
  vec2 part = place - vec2(corner);
  ivec2 whole = ivec2(size);
  vec3 upper = mix(texel_colour(m, start, whole, corner), texel_colour(m, start, whole, corner + ivec2(1, 0)), part.x);
  vec3 lower = mix(texel_colour(m, start, whole, corner + ivec2(0, 1)),
                   texel_colour(m, start, whole, corner + ivec2(1, 1)), part.x);
  return mix(upper, lower, part.y);
}

vec3 trilinear(MaterialRecord m, vec2 uv, float level) {
  float sharpest = clamp(level, 0.0, float(m.levels - 1u));
  uint first = uint(sharpest);
  float part = sharpest - float(first);
  vec3 colour = bilinear(m, uv, first);
  if (part < 0.01) return colour;
  return mix(colour, bilinear(m, uv, min(first + 1u, m.levels - 1u)), part);
}

// Up to this many samples along the longer axis of a footprint, so that floors seen at a low angle stay sharp.
const float kMostSamples = 6.0;

vec3 texture_colour(MaterialRecord m, vec2 uv, Footprint footprint) {
  vec2 size = vec2(m.texture_size);
  float across = length(footprint.dx * size), down = length(footprint.dy * size);
  float longer = max(max(across, down), 1e-6), shorter = max(min(across, down), 1e-6);
  if (!(longer < 1e6)) return trilinear(m, uv, float(m.levels));
  float samples = clamp(ceil(longer / shorter), 1.0, kMostSamples);
  if (longer <= 1.0) samples = 1.0;  // magnified
  float level = log2(max(longer / samples, 1.0));
  vec2 axis = across >= down ? footprint.dx : footprint.dy;
  vec3 sum = vec3(0.0);
  for (float i = 0.0; i < samples; i += 1.0) sum += trilinear(m, uv + axis * ((i + 0.5) / samples - 0.5), level);
  return sum / samples;
}
