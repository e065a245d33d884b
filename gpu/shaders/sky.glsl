// The sky behind a scene that states one (scenes::Surroundings): a gradient, clouds, and a glow around each directional
// light.

// A number from 0 to 1 for each corner of a lattice (PCG, as Jarzynski and Olano, "Hash Functions for GPU Rendering",
// 2020), and the smooth noise between corners.
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

// How much of the light from behind a cloud stays away in this direction of the upper half, 0 to 1. Clouds lie on a
// plane overhead; towards the horizon they thin out into haze.
float cloud_cover(vec3 direction, float share) {
  vec2 p = direction.xz / (direction.y + 0.12) * 1.6;
  float sum = 0.0, weight = 0.5;
  for (int octave = 0; octave < 5; ++octave) {
    sum += weight * smooth_noise(p);
    p = mat2(1.6, 1.2, -1.2, 1.6) * p + vec2(17.3, 5.1);
    weight *= 0.5;
  }
  float edge = 0.78 - 0.5 * share;
  return smoothstep(edge, edge + 0.28, sum) * smoothstep(0.02, 0.22, direction.y);
}

// `direction`: unit.
vec3 sky_radiance(vec3 direction) {
  vec3 horizon = push.shading.sky_horizon;
  if (direction.y < 0.0)
    return mix(horizon, push.shading.sky_ground, smoothstep(0.0, 0.12, -direction.y));
  vec3 sky = mix(horizon, push.shading.sky_zenith, pow(direction.y, 0.5));
  vec3 glow = vec3(0.0);
  for (uint i = 0u; i < frame.light_count; ++i) {
    if (frame.lights[i].kind != 2u) continue;
    float near = max(dot(direction, -frame.lights[i].direction), 0.0);
    glow += push.shading.lights[i].colour * (0.10 * pow(near, 8.0) + 0.35 * pow(near, 64.0) + 6.0 * pow(near, 2500.0));
  }
  float cover = push.shading.sky_clouds > 0.0 ? cloud_cover(direction, push.shading.sky_clouds) : 0.0;
  vec3 cloud = 1.15 * horizon + 0.5 * glow;
  return mix(sky + glow, cloud, 0.85 * cover);
}
