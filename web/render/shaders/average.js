// gpu/shaders/average.comp: the mean of 2x2 samples a pixel, in linear light.
export const AVERAGE = `
uniform sampler2D samples;
uniform int flipped_height;  // of the target, if its row 0 is the lowest; else 0
out vec4 picture;

vec3 to_linear(vec3 c) {
  return mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, lessThanEqual(c, vec3(0.04045)));
}
vec3 to_srgb(vec3 c) {
  return mix(1.055 * pow(max(c, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
vec3 sample_at(ivec2 place) { return to_linear(texelFetch(samples, place, 0).rgb); }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  if (flipped_height > 0) pixel.y = flipped_height - 1 - pixel.y;
  ivec2 first = 2 * pixel;
  vec3 sum = sample_at(first) + sample_at(first + ivec2(1, 0)) + sample_at(first + ivec2(0, 1)) +
             sample_at(first + ivec2(1, 1));
  picture = vec4(to_srgb(0.25 * sum), 1.0);
}
`;
