// gpu/shaders/shade.glsl: the picture's own surfaces, lit by the lights that are visible. LOOKUP says what is asked for
// that: MASKS of the very view, or none at all; masks of another view that was SEEN before; or shadow MAPS. WINDOW: with
// masks, pixels around have a say (window.js). SHARES: with masks, those before them have (accumulate.js).
import { OPEN_SEGMENTS } from '../../wire/planes.js';
import { SHARE_OF_PARTS } from './accumulate.js';
import { EXACT } from './exact.js';
import { ALPHA, SCENE, VIEW } from './frame.js';
import { MAPS } from './maps.js';
import { PREDICT } from './predict.js';
import { SKY } from './sky.js';
import { TEXTURES } from './textures.js';
import { WINDOW } from './window.js';

export const LOOKUPS = { MASKS: 1, SEEN: 2, MAPS: 3 };
export const VIEWS = { shaded: 0, material: 1, normals: 2, luminance: 3 };

const LIGHTS = `
uniform sampler2D lights;  // five texels for each, see lights.js
uniform int light_count;

TracedLight light_at(int i) {
  vec4 place = texelFetch(lights, ivec2(0, i), 0), way = texelFetch(lights, ivec2(1, i), 0);
  return TracedLight(place.xyz, place.w, way.xyz, way.w, uint(texelFetch(lights, ivec2(3, i), 0).z));
}

struct LightColour {
  vec3 colour;
  float cone_scale;
  float cone_offset;
};
LightColour colour_at(int i) {
  vec2 cone = texelFetch(lights, ivec2(3, i), 0).xy;
  return LightColour(texelFetch(lights, ivec2(2, i), 0).xyz, cone.x, cone.y);
}
`;

const UNIFORMS = `
uniform usampler2D ids;
uniform usampler2DArray masks;  // a layer for each plane, a texel for each tile
uniform int occlusion_plane;    // of the masks, the first; -1: they say nothing of it
uniform bool masked;            // false: each light reaches what it faces
uniform ivec2 first_pixel;      // of the shown part of the view
uniform int flipped_height;     // of the target, if its row 0 is the lowest; else 0
uniform vec3 ambient_above;     // radiance that reaches surfaces facing up, and those facing down
uniform vec3 ambient_below;
uniform float exposure;
uniform int view;
uniform bool tonemap_filmic;
uniform int only_light;         // -1: every light
uniform vec3 background;
uniform bool has_sky;
uniform vec3 sky_zenith;
uniform vec3 sky_horizon;
uniform vec3 sky_ground;
uniform float sky_clouds;
out vec4 picture;

const int kShaded = 0, kMaterial = 1, kNormals = 2, kLuminance = 3;
const float kPi = 3.14159265;
`;

const COLOUR = `
vec3 linear_to_srgb(vec3 c) {
  return mix(1.055 * pow(max(c, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// Narkowicz, "ACES Filmic Tone Mapping Curve" (2016).
vec3 filmic(vec3 c) { return clamp((c * (2.51 * c + 0.03)) / (c * (2.43 * c + 0.59) + 0.14), 0.0, 1.0); }
`;

const SURFACE = `
struct Triangle {
  uvec4 corners;
  vec3 p0, edge1, edge2;
};

// The triangle's gradient of barycentric weights: how much the weights of corners 1 and 2 change along a step.
vec2 weights_along(vec3 along, vec3 edge1, vec3 edge2) {
  vec3 n = cross(edge1, edge2);
  return vec2(dot(cross(along, edge2), n), dot(cross(edge1, along), n)) / dot(n, n);
}

// Barycentric weights of the corners at a point of the triangle's plane, clamped to [0, 1].
vec3 barycentric(vec3 p, Triangle t) {
  vec2 w = weights_along(p - t.p0, t.edge1, t.edge2);
  return clamp(vec3(1.0 - w.x - w.y, w), 0.0, 1.0);
}

// How far the point that a ray meets on the plane through \`surface\` moves when the ray turns by \`turn\`, which is one
// pixel's step.
vec3 step_on_plane(SurfacePoint surface, vec3 ray, vec3 turn) {
  float depth = dot(surface.position - camera, forward);
  float across = dot(surface.normal, ray);
  if (abs(across) < 1e-6) return vec3(0.0);
  return depth * (turn - ray * (dot(surface.normal, turn) / across));
}

vec3 base_colour(MaterialRecord m, Triangle t, SurfacePoint surface, vec3 weights, ivec2 pixel) {
  vec3 colour = m.base_color.rgb;
  if (!m.textured) return colour;
  vec2 uv0 = uv_of(t.corners.x), uv1 = uv_of(t.corners.y), uv2 = uv_of(t.corners.z);
  vec2 uv = weights.x * uv0 + weights.y * uv1 + weights.z * uv2;
  uv1 -= uv0, uv2 -= uv0;
  vec3 ray = pixel_ray(pixel);
  vec2 across = weights_along(step_on_plane(surface, ray, ray_dx), t.edge1, t.edge2);
  vec2 down = weights_along(step_on_plane(surface, ray, ray_dy), t.edge1, t.edge2);
  return colour * texture_colour(m, uv, Footprint(across.x * uv1 + across.y * uv2, down.x * uv1 + down.y * uv2));
}
`;

const LIGHT = `
bool mask_bit(int plane, ivec2 pixel) {
  uvec2 word = texelFetch(masks, ivec3(pixel >> 3, plane), 0).xy;
  uint bit = uint((pixel.y & 7) * 8 + (pixel.x & 7));
  return ((bit < 32u ? word.x >> bit : word.y >> (bit - 32u)) & 1u) != 0u;
}

// Where the masks of a pixel are looked up.
struct Place {
  ivec2 pixel;
  ivec2 source;  // the pixel whose bits count; kUnknown where none is known, which is lit
  uint like;     // WINDOW alone
};
const ivec2 kUnknown = ivec2(-1);

// Which share of \`most\` the planes from there on say.
float counted_share(int plane, int most, ivec2 source) {
  int number = 0;
  if (mask_bit(plane, source)) return 1.0;
  for (int left = most; left > 1; left >>= 1) number = 2 * number + (mask_bit(++plane, source) ? 1 : 0);
  return float(number) / float(most);
}

int samples_of(int light) { return int(texelFetch(lights, ivec2(4, light), 0).y); }

// The share of the light's points that is seen there: 0 or 1 of a light without an extent.
float share_at(int light, ivec2 source) {
  if (source.x < 0) return 1.0;
#if SHARES
  int layer = int(texelFetch(lights, ivec2(4, light), 0).z);
  if (layer >= 0) return share_of(layer, source);
#endif
  return counted_share(int(texelFetch(lights, ivec2(4, light), 0).x), samples_of(light), source);
}

// The share of ambient light that nothing near hides there.
float open_share(ivec2 source) {
#if SHARES
  return share_of(occlusion_layer, source);
#else
  return counted_share(occlusion_plane, ${OPEN_SEGMENTS}, source);
#endif
}
`;

// Without a window, each pixel stands for itself.
const ALONE = `
Place place_of(SurfacePoint surface, ivec2 pixel) {
#if LOOKUP == 1
  return Place(pixel, masked ? pixel : kUnknown, 0u);
#elif LOOKUP == 2
  return Place(pixel, source_of(surface), 0u);
#else
  return Place(pixel, kUnknown, 0u);
#endif
}

float visible(int light, Place place) { return share_at(light, place.source); }

float openness(Place place) {
  return place.source.x < 0 || occlusion_plane < 0 ? 1.0 : open_share(place.source);
}
`;

const SHADED = `
// The irradiance by light i: I_i attenuated by distance, range and cone (KHR_lights_punctual), times saturate(N.L).
vec3 irradiance(int i, SurfacePoint surface, vec3 normal) {
  TracedLight light = light_at(i);
  LightColour shade = colour_at(i);
  if (shade.colour == vec3(0.0)) return vec3(0.0);  // switched off
  // If nothing was traced, because the light is behind the face or out of range or cone, the bit may have any value.
  if (!shadow_segment(camera, surface, light).traced) return vec3(0.0);
  vec3 to_light = light.kind == 2u ? -light.direction : light.position - surface.position;
  float attenuation = 1.0;
  vec3 direction = normalize(to_light);
  if (light.kind != 2u) {
    float squared = dot(to_light, to_light);
    attenuation = 1.0 / squared;
    if (light.reach > 0.0) {
      float near = squared / (light.reach * light.reach);
      attenuation *= clamp(1.0 - near * near, 0.0, 1.0);
    }
  }
  if (light.kind == 1u) {
    float cone = clamp(dot(light.direction, -direction) * shade.cone_scale + shade.cone_offset, 0.0, 1.0);
    attenuation *= cone * cone;
  }
#if LOOKUP == 3
  attenuation *= share_by_map(i, light, surface);
#endif
  return shade.colour * attenuation * max(dot(normal, direction), 0.0);
}

// How much of the chosen light reaches the point, 0 to 1; all if none is chosen.
float reached(SurfacePoint surface, Place place) {
  if (only_light < 0) return 1.0;
  return shadow_segment(camera, surface, light_at(only_light)).traced ? visible(only_light, place) : 0.0;
}

vec3 shaded(SurfacePoint surface, vec3 normal, vec3 base, vec3 emissive, Place place) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < light_count; ++i) {
    float share = only_light < 0 || only_light == i ? visible(i, place) : 0.0;
    if (share > 0.0) sum += share * irradiance(i, surface, normal);
  }
  vec3 ambient = mix(ambient_below, ambient_above, 0.5 + 0.5 * normal.y);
  return emissive + base * (sum / kPi + openness(place) * ambient);
}
`;

const MAIN = `
vec3 pixel_colour(uint id, ivec2 pixel) {
  Triangle t;
  t.corners = triangle_of(id - 1u);
  SurfacePoint surface = surface_of(t.corners, pixel);
  t.p0 = position_of(t.corners.x);
  t.edge1 = position_of(t.corners.y) - t.p0, t.edge2 = position_of(t.corners.z) - t.p0;
  vec3 weights = barycentric(surface.position, t);
  vec3 normal = normalize(weights.x * normal_of(t.corners.x) + weights.y * normal_of(t.corners.y) +
                          weights.z * normal_of(t.corners.z));
  if (dot(normal, surface.normal) < 0.0) normal = -normal;  // seen from behind
  if (view == kNormals) return normal * 0.5 + 0.5;
  Place place = place_of(surface, pixel);
  MaterialRecord m = material_of(t.corners.w);
  vec3 base = base_colour(m, t, surface, weights, pixel);
  if (view == kMaterial) return reached(surface, place) * base;
  return shaded(surface, normal, base, m.emissive, place);
}

vec3 colour_without_surface(ivec2 pixel) {
  bool sky = has_sky && view == kShaded && only_light < 0;
  return sky ? sky_radiance(normalize(pixel_ray(pixel))) : background;
}

vec3 encoded(vec3 c) {
  if (view == kShaded) {
    c *= exposure;
    if (tonemap_filmic) c = filmic(c);
  }
  return view == kNormals ? c : linear_to_srgb(clamp(c, 0.0, 1.0));
}

// The bits of a number as a colour of four bytes, the lowest first.
vec4 bytes_of(float number) {
  uint bits = floatBitsToUint(number);
  return vec4(bits & 255u, (bits >> 8) & 255u, (bits >> 16) & 255u, bits >> 24) / 255.0;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  if (flipped_height > 0) pixel.y = flipped_height - 1 - pixel.y;
  pixel += first_pixel;
  uint id = texelFetch(ids, pixel, 0).x;
  vec3 colour = id != 0u ? pixel_colour(id, pixel) : colour_without_surface(pixel);
  picture = view == kLuminance ? bytes_of(dot(colour, vec3(0.2126, 0.7152, 0.0722))) : vec4(encoded(colour), 1.0);
}
`;

/** The fragment shader for a value of LOOKUPS. */
export function shadeFragment(
  /** @type {number} */ lookup,
  /** @type {boolean} */ window,
  /** @type {boolean} */ shares,
) {
  const found = lookup === LOOKUPS.SEEN && !window ? PREDICT : lookup === LOOKUPS.MAPS ? MAPS : '';
  const asked = [found, shares ? SHARE_OF_PARTS : '', LIGHT, window ? WINDOW : ALONE, SHADED];
  return [EXACT, SCENE, VIEW, ALPHA, LIGHTS, UNIFORMS, TEXTURES, SKY, COLOUR, SURFACE, ...asked, MAIN].join('');
}
