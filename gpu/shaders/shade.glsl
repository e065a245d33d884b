// Shades a client's picture: its own surfaces, lit by the lights that are visible according to the masks. With
// PREDICTED, the masks are of another view, and are looked up at the pixel in which predict.comp found the same
// surface; surfaces that it did not find are lit by every light.
#include "frame.glsl"
#include "surface.glsl"
#include "mask_counts.glsl"
#ifdef PREDICTED
#include "seen_view.glsl"
#endif

struct LightColour {
  vec3 colour;
  float cone_scale;
  float cone_offset;
  uint first_plane;  // common/light_planes.h
  uint samples;
  uint number;  // gpu/passes/accumulation.h
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Shading {
  vec3 ambient_above;  // radiance that reaches surfaces facing up, and those facing down
  float exposure;
  vec3 ambient_below;
  uint view;
  vec3 background;
  uint tonemap;
  vec3 sky_zenith;
  uint only_light;
  vec3 sky_horizon;
  uint has_sky;
  vec3 sky_ground;
  float sky_clouds;
  uint filter_step;  // 0: counts are taken as they are
  uint window_step;  // how far apart a window's pixels are
  uint occlusion;    // common/sample_counts.h
  uint occlusion_plane;
  uint occlusion_number;
  uint whole_share;  // 0: counts are those of the masks; else the shares are shown instead, and this is a whole one
  LightColour lights[kMaxLights];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Pixels { uint at[]; };
layout(push_constant, scalar) uniform Push {
  MaskWords masks;
  Shading shading;
  Pixels pixels;
#ifdef PREDICTED
  SeenView seen;  // the view of the masks
  Uints sources;  // for each pixel, as predict.comp writes them
  Uints shares;   // as accumulate.comp writes them, if there are any
#endif
} push;

const uint kShaded = 0u, kMaterial = 1u, kNormals = 2u, kLuminance = 3u;
const uint kFilmic = 1u;
const uint kNoOcclusion = 0u, kHalf = 1u, kOcclusionSegments = 8u;
const float kPi = 3.14159265;

#include "textures.glsl"
#include "sky.glsl"

vec3 linear_to_srgb(vec3 c) {
  return mix(1.055 * pow(max(c, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// Narkowicz, "ACES Filmic Tone Mapping Curve" (2016).
vec3 filmic(vec3 c) { return clamp((c * (2.51 * c + 0.03)) / (c * (2.43 * c + 0.59) + 0.14), 0.0, 1.0); }

// The triangle's gradient of barycentric weights: how much the weights of corners 1 and 2 change along a step, for a
// triangle with these edges from corner 0.
vec2 weights_along(vec3 along, vec3 edge1, vec3 edge2) {
  vec3 n = cross(edge1, edge2);
  return vec2(dot(cross(along, edge2), n), dot(cross(edge1, along), n)) / dot(n, n);
}

// Barycentric weights of the corners at a point of the triangle's plane, clamped to [0, 1].
vec3 barycentric(vec3 p, vec3 p0, vec3 p1, vec3 p2) {
  vec2 w = weights_along(p - p0, p1 - p0, p2 - p0);
  return clamp(vec3(1.0 - w.x - w.y, w), 0.0, 1.0);
}

// How far the point that a ray meets on the plane through `surface` moves when the ray turns by `turn`, which is one
// pixel's step.
vec3 step_on_plane(SurfacePoint surface, vec3 ray, vec3 turn) {
  float depth = dot(surface.position - frame.camera, frame.forward);
  float across = dot(surface.normal, ray);
  if (abs(across) < 1e-6) return vec3(0.0);
  return depth * (turn - ray * (dot(surface.normal, turn) / across));
}

Footprint footprint_of(uint triangle, SurfacePoint surface, uvec2 pixel) {
  uvec3 c = frame.triangles.at[triangle];
  vec3 p0 = frame.positions.at[c.x];
  vec3 edge1 = frame.positions.at[c.y] - p0, edge2 = frame.positions.at[c.z] - p0;
  vec2 uv0 = frame.uvs.at[c.x], uv1 = frame.uvs.at[c.y] - uv0, uv2 = frame.uvs.at[c.z] - uv0;
  vec3 ray = pixel_ray(pixel);
  vec2 across = weights_along(step_on_plane(surface, ray, frame.ray_dx), edge1, edge2);
  vec2 down = weights_along(step_on_plane(surface, ray, frame.ray_dy), edge1, edge2);
  return Footprint(across.x * uv1 + across.y * uv2, down.x * uv1 + down.y * uv2);
}

vec3 base_colour(MaterialRecord m, uint triangle, SurfacePoint surface, vec3 weights, uvec2 pixel) {
  vec3 colour = m.base_color.rgb;
  if (m.texels != uvec2(0))
    colour *= texture_colour(m, uv_at(triangle, weights), footprint_of(triangle, surface, pixel));
  return colour;
}

// The pixel of the masks that shows the surface of this pixel; none: no pixel does.
const uvec2 kNone = uvec2(0xffffffffu);

uvec2 mask_pixel(uvec2 pixel) {
#ifdef PREDICTED
  uint source = push.sources.at[pixel.y * frame.width + pixel.x];
  return source == 0u ? kNone : uvec2((source - 1u) % push.seen.width, (source - 1u) / push.seen.width);
#else
  return pixel;
#endif
}

// `number`: which of those that masks count, if `most` is more than 1.
float share_in(uint plane, uint most, uint number, uvec2 at) {
#ifdef PREDICTED
  if (push.shading.whole_share != 0u && most > 1u) {
    uint place = (number / 4u) * push.seen.width * push.seen.height + at.y * push.seen.width + at.x;
    return float(push.shares.at[place] >> 8u * (number % 4u) & 0xffu) / float(push.shading.whole_share);
  }
  uvec2 tiles = (uvec2(push.seen.width, push.seen.height) + 7u) / 8u;
  return float(counted(push.masks, plane, most, at, tiles.x, tiles.x * tiles.y)) / float(most);
#else
  return float(counted(push.masks, plane, most, at, frame.tiles_x, frame.tile_count)) / float(most);
#endif
}

// The share of the light's sample points that the pixel sees: 0 or 1 of a light without extent.
float share_at(uint light, uvec2 pixel) {
  uvec2 at = mask_pixel(pixel);
  LightColour of_light = push.shading.lights[light];
  return at == kNone ? 1.0 : share_in(of_light.first_plane, of_light.samples, of_light.number, at);
}

// The filter's window, 5x5 pixels: the weights 1, 2, 2, 2, 1 in each direction are the mean of the four 4x4 windows that
// contain the pixel, of which each has every sample point.
const uint kWindow = 25u, kOwn = 12u;  // `kOwn`: the pixel itself

ivec2 window_step(uint i) { return ivec2(int(i % 5u), int(i / 5u)) - 2; }

ivec2 window_pixel(uvec2 pixel, uint i) { return ivec2(pixel) + window_step(i) * int(push.shading.window_step); }

float window_weight(uint i) {
  ivec2 off = abs(window_step(i));
  return (off.x == 2 ? 1.0 : 2.0) * (off.y == 2 ? 1.0 : 2.0);
}

// How far around a pixel it looks: as far as the filter, or to those next to it that count occlusion.
int window_reach() {
  return push.shading.filter_step != 0u ? 2 : push.shading.occlusion == kHalf ? 1 : 0;
}

// Those pixels of the window that show the same surface, as bits.
uint same_surface(SurfacePoint surface, uvec2 pixel) {
  uint like = 1u << kOwn;
  int reach = window_reach();
  if (reach == 0) return like;
  for (uint i = 0u; i < kWindow; ++i) {
    ivec2 at = window_pixel(pixel, i), off = abs(window_step(i));
    if (i == kOwn || max(off.x, off.y) > reach || any(lessThan(at, ivec2(0))) || at.x >= int(frame.width) || at.y >= int(frame.height)) continue;
    uint id = triangle_at(uvec2(at));
    if (id == 0u) continue;
    if (on_one_surface(surface, surface_of(id - 1u, uvec2(at)))) like |= 1u << i;
  }
  return like;
}

// `like`: as same_surface() says. Where wholly lit and wholly dark pixels lie side by side, the edge is sharper than the
// window, and the pixel keeps its own count.
float visible(uint light, uvec2 pixel, uint like) {
  float own = share_at(light, pixel);
  if (push.shading.filter_step == 0u || push.shading.lights[light].samples == 1u) return own;
  float sum = 0.0, weights = 0.0;
  bool lit = false, dark = false;
  for (uint i = 0u; i < kWindow; ++i) {
    if ((like >> i & 1u) == 0u) continue;
    float share = share_at(light, uvec2(window_pixel(pixel, i)));
    sum += window_weight(i) * share;
    weights += window_weight(i);
    lit = lit || share == 1.0;
    dark = dark || share == 0.0;
  }
  return lit && dark ? own : sum / weights;
}

// Whether that pixel of the masks has a count of its own.
bool counts_occlusion(uvec2 at) {
  return at != kNone && (push.shading.occlusion != kHalf || ((at.x | at.y) & 1u) == 0u);
}

float open_share(uvec2 at) {
  return share_in(push.shading.occlusion_plane, kOcclusionSegments, push.shading.occlusion_number, at);
}

// The share of its ambient light that nothing near hides. A pixel without a count takes the mean of those next to it that
// show the same surface; where none of them has one, as at a twig thinner than two pixels, it is open.
float openness(uvec2 pixel, uint like) {
  if (push.shading.occlusion == kNoOcclusion) return 1.0;
  uvec2 own = mask_pixel(pixel);
  if (own == kNone) return 1.0;
  if (push.shading.filter_step == 0u && counts_occlusion(own)) return open_share(own);
  float sum = 0.0, weights = 0.0;
  for (uint i = 0u; i < kWindow; ++i) {
    if ((like >> i & 1u) == 0u) continue;
    uvec2 at = mask_pixel(uvec2(window_pixel(pixel, i)));
    if (!counts_occlusion(at)) continue;
    sum += window_weight(i) * open_share(at);
    weights += window_weight(i);
  }
  return weights > 0.0 ? sum / weights : 1.0;
}

// The irradiance by light i: I_i attenuated by distance, range and cone (KHR_lights_punctual), times saturate(N.L).
vec3 irradiance(uint i, SurfacePoint surface, vec3 normal) {
  TracedLight light = frame.lights[i];
  LightColour shade = push.shading.lights[i];
  // If nothing was traced, because the light is behind the face or out of range or cone, the bit may have any value.
  if (!shadow_segment(frame.camera, surface, light).traced) return vec3(0.0);
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
  return shade.colour * attenuation * max(dot(normal, direction), 0.0);
}

// How much of the chosen light reaches the point; all if none is chosen. Bits of pairs that were not traced may have any
// value.
float reached(SurfacePoint surface, uvec2 pixel) {
  uint light = push.shading.only_light;
  if (light == 0xffffffffu) return 1.0;
  bool traced = shadow_segment(frame.camera, surface, frame.lights[light]).traced;
  return traced ? visible(light, pixel, same_surface(surface, pixel)) : 0.0;
}

vec3 shaded(SurfacePoint surface, vec3 normal, vec3 base, vec3 emissive, uvec2 pixel) {
  vec3 sum = vec3(0.0);
  uint like = same_surface(surface, pixel);
  for (uint i = 0u; i < frame.light_count; ++i) {
    if (push.shading.only_light != 0xffffffffu && push.shading.only_light != i) continue;
    float share = visible(i, pixel, like);
    if (share > 0.0) sum += share * irradiance(i, surface, normal);
  }
  vec3 ambient = mix(push.shading.ambient_below, push.shading.ambient_above, 0.5 + 0.5 * normal.y);
  ambient *= openness(pixel, like);
  return emissive + base * (sum / kPi + ambient);
}

uint encode(vec3 radiance) {
  if (push.shading.view == kLuminance) return floatBitsToUint(dot(radiance, vec3(0.2126, 0.7152, 0.0722)));
  vec3 c = radiance;
  if (push.shading.view == kShaded) {
    c *= push.shading.exposure;
    if (push.shading.tonemap == kFilmic) c = filmic(c);
  }
  if (push.shading.view != kNormals) c = linear_to_srgb(clamp(c, 0.0, 1.0));
  return packUnorm4x8(vec4(c, 1.0));
}

vec3 pixel_colour(uint triangle, uvec2 pixel) {
  SurfacePoint surface = surface_of(triangle, pixel);
  uvec3 corners = frame.triangles.at[triangle];
  vec3 weights = barycentric(surface.position, frame.positions.at[corners.x], frame.positions.at[corners.y],
                             frame.positions.at[corners.z]);
  vec3 normal = normalize(weights.x * frame.normals.at[corners.x] + weights.y * frame.normals.at[corners.y] +
                          weights.z * frame.normals.at[corners.z]);
  if (dot(normal, surface.normal) < 0.0) normal = -normal;  // seen from behind
  if (push.shading.view == kNormals) return normal * 0.5 + 0.5;
  MaterialRecord m = frame.materials.at[frame.triangle_materials.at[triangle]];
  vec3 base = base_colour(m, triangle, surface, weights, pixel);
  if (push.shading.view == kMaterial) return reached(surface, pixel) * base;
  return shaded(surface, normal, base, m.emissive, pixel);
}

vec3 colour_without_surface(uvec2 pixel) {
  bool sky = push.shading.has_sky != 0u && push.shading.view == kShaded && push.shading.only_light == 0xffffffffu;
  return sky ? sky_radiance(normalize(pixel_ray(pixel))) : push.shading.background;
}

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  uint id = triangle_at(pixel);
  vec3 colour = id != 0u ? pixel_colour(id - 1u, pixel) : colour_without_surface(pixel);
  push.pixels.at[pixel.y * frame.width + pixel.x] = encode(colour);
}
