// A level of a texture: gpu/scene/texels.cpp.
export const LEVEL = `
uniform sampler2D from;
uniform sampler2D linear_of_srgb;
uniform ivec2 from_size;
uniform ivec2 place;  // of the level in its target
uniform int coded;    // what \`from\` has: 0 the file's bytes, 1 linear values, 2 their square roots
uniform bool halved;
uniform bool to_roots;
out vec4 made;

float linear(float srgb) { return texelFetch(linear_of_srgb, ivec2(int(srgb * 255.0 + 0.5), 0), 0).x; }

vec4 texel(ivec2 at) {
  vec4 t = texelFetch(from, min(at, from_size - 1), 0);
  if (coded == 0) return vec4(linear(t.r), linear(t.g), linear(t.b), t.a);
  return coded == 1 ? t : vec4(t.rgb * t.rgb, t.a);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - place;
  int samples = halved ? 4 : 1;
  vec4 t = vec4(0.0);
  for (int i = 0; i < samples; ++i) t += texel(halved ? 2 * at + ivec2(i & 1, i >> 1) : at);
  t /= float(samples);
  made = to_roots ? vec4(floor(255.0 * sqrt(t.rgb) + 0.5) / 255.0, t.a) : t;
}
`;
