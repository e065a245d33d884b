// gpu/shaders/sky.glsl: a gradient, clouds, and a glow around each directional light.
export const SKY = `
float corner_noise(ivec2 p) {
  uint state = (uint(p.x) * 1664525u + uint(p.y) * 22695477u) * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return float(((word >> 22u) ^ word) & 0xffffu) / 65535.0;
}
float smooth_noise(vec2 p) {
  ivec2 corner = ivec2(floor(p));
  vec2 f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(corner_noise(corner), corner_noise(corner + ivec2(1, 0)), f.x),
             mix(corner_noise(corner + ivec2(0, 1)), corner_noise(corner + ivec2(1, 1)), f.x), f.y);
}

// How much of the light from behind a cloud stays away in this direction of the upper half, 0 to 1.
float cloud_cover(vec3 direction, float share) {
  vec2 p = direction.xz / (direction.y + 0.12) * 1.6;
  // Five octaves, in a loop that compilers cannot write out: that alone would be a fifth of the time they take.
  float sum = 0.0, weight = share > 0.0 ? 0.5 : 0.0;
  while (weight > 0.02) {
    sum += weight * smooth_noise(p);
    p = mat2(1.6, 1.2, -1.2, 1.6) * p + vec2(17.3, 5.1);
    weight *= 0.5;
  }
  float edge = 0.78 - 0.5 * share;
  return smoothstep(edge, edge + 0.28, sum) * smoothstep(0.02, 0.22, direction.y);
}

// \`direction\`: unit.
vec3 sky_radiance(vec3 direction) {
  vec3 horizon = sky_horizon;
  if (direction.y < 0.0) return mix(horizon, sky_ground, smoothstep(0.0, 0.12, -direction.y));
  vec3 sky = mix(horizon, sky_zenith, pow(direction.y, 0.5));
  vec3 glow = vec3(0.0);
  for (int i = 0; i < light_count; ++i) {
    TracedLight light = light_at(i);
    if (light.kind != 2u) continue;
    float near = max(dot(direction, -light.direction), 0.0);
    glow += colour_at(i).colour * (0.10 * pow(near, 8.0) + 0.35 * pow(near, 64.0) + 6.0 * pow(near, 2500.0));
  }
  float cover = sky_clouds > 0.0 ? cloud_cover(direction, sky_clouds) : 0.0;
  vec3 cloud = 1.15 * horizon + 0.5 * glow;
  return mix(sky + glow, cloud, 0.85 * cover);
}
`;
