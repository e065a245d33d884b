#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "surface.glsl"
#include "seen_source.glsl"
#include "mask_counts.glsl"

// For each pixel of the newest mask's view and each number that the mask counts, its mean over that mask and the earlier
// ones that show the same surface and do not contradict it (gpu/passes/accumulation.h).
struct CountedNumber {
  uint first_plane;
  uint most;
  uint step;
  uint accumulates;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Accumulation {
  uint earlier;
  uint numbers;
  uint resting_triangles;
  uint whole_share;
  CountedNumber counted[kMaxLights + 1u];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Shares { uint at[]; };
const uint kEarlier = 3u;
layout(push_constant, scalar) uniform Push {
  Accumulation accumulation;
  Uints ids;        // triangle_id of the newest mask's view
  MaskWords masks;  // the newest
  Shares shares;
  SeenView views[kEarlier];
  Uints earlier_ids[kEarlier];
  MaskWords earlier_masks[kEarlier];
} push;

bool has_number(CountedNumber number, uvec2 at) { return ((at.x | at.y) & (number.step - 1u)) == 0u; }

uint count_at(MaskWords masks, CountedNumber number, uvec2 at) {
  return counted(masks, number.first_plane, number.most, at, frame.tiles_x, frame.tile_count);
}

// The pixel of each earlier mask that shows the surface, as predict.comp says. What moves has none: its triangles were
// elsewhere then.
uvec3 earlier_sources(SurfacePoint surface, uint id) {
  uvec3 sources = uvec3(0u);
  if (id > push.accumulation.resting_triangles) return sources;
  for (uint e = 0u; e < push.accumulation.earlier; ++e) {
    uint source = source_of(push.views[e], push.earlier_ids[e], surface);
    if (source != 0u && push.earlier_ids[e].at[source - 1u] <= push.accumulation.resting_triangles) sources[e] = source;
  }
  return sources;
}

ivec2 neighbour(uvec2 pixel, uint i, uint step) {
  return ivec2(pixel) + (ivec2(int(i % 3u), int(i / 3u)) - 1) * int(step);
}

// Those of the 3x3 pixels around, `step` apart, that show the same surface, as bits.
uint like_pixels(SurfacePoint surface, uvec2 pixel, uint step) {
  uint like = 0u;
  for (uint i = 0u; i < 9u; ++i) {
    ivec2 at = neighbour(pixel, i, step);
    if (any(lessThan(at, ivec2(0))) || at.x >= int(frame.width) || at.y >= int(frame.height)) continue;
    uint id = push.ids.at[uint(at.y) * frame.width + uint(at.x)];
    if (id != 0u && on_one_surface(surface, surface_of(id - 1u, uvec2(at)))) like |= 1u << i;
  }
  return like;
}

// An earlier count is rejected if it lies farther than one point beyond all counts around it in the newest mask: a shadow
// that has gone, or not come yet, does not linger. Where wholly lit and wholly dark pixels are around, the edge is sharper
// than these pixels and lies elsewhere between those of each mask: the newest stands alone.
uint mean_share(CountedNumber number, uvec2 pixel, uvec3 sources, uint like) {
  uint own = count_at(push.masks, number, pixel);
  uint least = own, most = own;
  for (uint i = 0u; i < 9u; ++i) {
    if (sources == uvec3(0u) || (like >> i & 1u) == 0u) continue;
    uint count = count_at(push.masks, number, uvec2(neighbour(pixel, i, number.step)));
    least = min(least, count);
    most = max(most, count);
  }
  bool sharp = least == 0u && most == number.most;
  uint sum = own, masks = 1u;
  for (uint e = 0u; e < kEarlier; ++e) {
    if (sharp || sources[e] == 0u) continue;
    uvec2 at = uvec2((sources[e] - 1u) % frame.width, (sources[e] - 1u) / frame.width);
    if (!has_number(number, at)) continue;
    uint count = count_at(push.earlier_masks[e], number, at);
    if (count + 1u < least || count > most + 1u) continue;
    sum += count;
    ++masks;
  }
  return sum * (push.accumulation.whole_share / (masks * number.most));
}

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  uint index = pixel.y * frame.width + pixel.x;
  uint id = push.ids.at[index];
  uvec3 sources = uvec3(0u);
  uvec2 like = uvec2(0u);  // one pixel apart, and two
  if (id != 0u) {
    SurfacePoint surface = surface_of(id - 1u, pixel);
    sources = earlier_sources(surface, id);
    if (sources != uvec3(0u)) like = uvec2(like_pixels(surface, pixel, 1u), like_pixels(surface, pixel, 2u));
  }
  uint packed = 0u;
  for (uint i = 0u; i < push.accumulation.numbers; ++i) {
    CountedNumber number = push.accumulation.counted[i];
    bool newest_alone = number.accumulates == 0u || !has_number(number, pixel);
    uint share = mean_share(number, pixel, newest_alone ? uvec3(0u) : sources, number.step == 1u ? like.x : like.y);
    packed |= share << 8u * (i % 4u);
    if (i % 4u != 3u && i + 1u != push.accumulation.numbers) continue;
    push.shares.at[(i / 4u) * frame.width * frame.height + index] = packed;
    packed = 0u;
  }
}
