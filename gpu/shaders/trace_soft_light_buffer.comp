#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Traces area lights with light buffers that were built for their extents: one subgroup of LANES traces one 8x8 tile, as
// trace_light_buffer.glsl says. The planes of a pixel's leaf decide for all sample points at once; what they leave
// undecided walks its list once with a set of the points that nothing has hidden so far. Lights that are not where the
// buffers were built for them are traced by the hierarchy of the resting geometry, and for every light the points left
// by that of the moving geometry.
#include "hierarchy.glsl"
#include "soft_lights.glsl"
#define TRACER_PUSH_MORE SoftFrame soft; Hierarchy still; Hierarchy moving;
#define LIGHT_BUFFER_SET 5
#include "trace_light_buffer.glsl"

// A list that is longer is not walked: the hierarchy of the resting geometry answers for its pixels sooner.
#ifndef LONG_LIST
#define LONG_LIST (LANES >= 32 ? 192u : 384u)
#endif
const uint kLongList = LONG_LIST;

// From this length of a list and this many points on it pays to look first where the points are: on vector units, whose
// steps are those of the lane that tests most points. GPUs took 5 to 40% longer for that.
const bool kLooksAtPoints = LANES <= 16;
const uint kWorthLookingLength = 48u, kWorthLookingSamples = 16u;

#include "tracers/bvh_bundle.glsl"

// For each pixel of a lane, the sample points that are in front of its surface and that nothing has hidden so far.
struct Open {
  uint points[kRounds];
  uint first[kRounds];  // of the pixel's points
};

vec3 origin_of(Pixels pixels, uint round) {
  vec3 origin = pixels.origin[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) origin = round == r ? pixels.origin[r] : origin;
  return origin;
}

// The points in front of the surface. Where the whole light is, with room for all rounding, no point is looked at.
Open facing_points(SoftLight light, Pixels pixels, uint care) {
  uint samples = push.soft.samples, all = all_points(samples);
  vec3 middle = frame.lights[light.light].position;
  Open open;
  uint partly = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uvec2 pixel = tile_of_lane() * 8u + pixel_in_tile((r * LANES + lane()) % 64u);
    open.first[r] = light.points + sample_pattern(pixel) * samples;
    vec3 to_middle = middle - pixels.origin[r];
    float rounding = 1e-5 * (abs(to_middle.x) + abs(to_middle.y) + abs(to_middle.z));
    bool cares = (care & (1u << r)) != 0u;
    bool whole = dot(pixels.normal[r], to_middle) > 1.001 * light.radius + rounding;
    open.points[r] = cares ? all : 0u;
    partly |= cares && !whole ? 1u << r : 0u;
  }
  if (any_lane(partly != 0u)) {
    [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
      uint facing = 0u;
      for (uint i = 0u; i < samples; ++i)
        facing |= sample_segment(pixels.origin[r], pixels.normal[r], SAMPLE_POINT(open.first[r] + i)).traced
                      ? point_bit(i) : 0u;
      open.points[r] &= (partly & (1u << r)) != 0u ? facing : all;
    }
  }
  return open;
}

// The state of one pixel's walk through its leaf's list.
struct Walk {
  uint round;
  Bundle bundle;
  SeenPoints points;
  uint open;
  float depth;
  uint place;      // in the leaf
  uint next, end;  // entries
};

Bundle bundle_of(SoftLight light, Pixels pixels, Open open, uint round) {
  vec3 origin = origin_of(pixels, round);
  return Bundle(origin, frame.lights[light.light].position - origin, light.radius, chosen(open.first, round));
}

Walk start_walk(SoftLight light, Asked asked, Pixels pixels, Open open, uint round) {
  Walk walk;
  walk.round = round;
  walk.depth = asked.depth[0];
  [[unroll]] for (uint r = 1u; r < kRounds; ++r) walk.depth = round == r ? asked.depth[r] : walk.depth;
  uint at = chosen(asked.place, round), count = chosen(asked.count, round);
  uint length = count & ((1u << kCountBits) - 1u);
  walk.place = place_in_leaf(uvec2(at & 0xffffu, at >> 16), count);
  walk.next = chosen(asked.first, round);
  walk.end = walk.next + length;
  walk.open = chosen(open.points, round);
  walk.bundle = bundle_of(light, pixels, open, round);
  bool looks = kLooksAtPoints && push.soft.samples >= kWorthLookingSamples && length >= kWorthLookingLength;
  if (looks) walk.points = points_as_seen(walk.bundle.origin, walk.bundle.to_middle, light.radius, walk.bundle.first);
  else walk.points = points_anywhere();
  return walk;
}

// The next triangle of the list that may block; kNone if there is none.
uint next_candidate(inout Walk walk) {
  uint found = kNone;  // the number of its entry
  while (found == kNone && walk.next < walk.end) {
    EntryBounds bounds = bounds_at(walk.next);
    bool behind = !in_front(bounds, walk.depth);
    found = behind && holds(bounds, walk.place) ? walk.next : kNone;
    walk.next = behind ? walk.next + 1u : walk.end;
  }
  return found == kNone ? kNone : triangle_of(found);
}

// A lane that has finished a pixel continues with its next.
void walk_lists(SoftLight light, Asked asked, Pixels pixels, inout Open open) {
  uint asking = asked.undecided;
  Walk walk;
  walk.next = walk.end = 0u;
  while (asking != 0u || walk.next < walk.end) {
    if (walk.next >= walk.end) {
      walk = start_walk(light, asked, pixels, open, uint(findLSB(asking)));
      asking &= asking - 1u;
    }
    uint candidate = next_candidate(walk);
    if (candidate != kNone) {
      TriangleCorners corners = corners_of(candidate);
      Occluder occluder =
          Occluder(candidate, candidate >= push.first_masked, corners.p0, corners.p1, corners.p2);
      walk.open = left_open(walk.bundle, walk.points, walk.open, occluder);
      walk.next = walk.open == 0u ? walk.end : walk.next;
    }
    [[unroll]] for (uint r = 0u; r < kRounds; ++r) open.points[r] = walk.round == r ? walk.open : open.points[r];
  }
}

// Those of the undecided pixels whose lists are too long.
uint with_long_lists(Asked asked) {
  uint with = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uint bit = asked.undecided & (1u << r);
    if (bit != 0u && (asked.count[r] & ((1u << kCountBits) - 1u)) > kLongList) with |= bit;
  }
  return with;
}

#if LANES >= 32
// Pixels whose points are traced, those of the subgroup's one after the other.
shared vec3 traced_origin[LANES];
shared uint traced_first[LANES], traced_open[LANES];

// Takes away the points of the pixels `asking` that a hierarchy's geometry hides. The segments of one pixel are side by
// side in the lanes: they pass the same nodes, and no lane idles because its pixel does not ask.
void hide_behind(SoftLight light, Tree tree, Pixels pixels, uint asking, inout Open open) {
  uint samples = push.soft.samples;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    bool asks = (asking & (1u << r)) != 0u && open.points[r] != 0u;
    uvec4 votes = ballot(asks);
    uint count = lanes_in(votes), own = lanes_before(votes);
    if (asks) {
      traced_origin[own] = pixels.origin[r];
      traced_first[own] = open.first[r];
      traced_open[own] = open.points[r];
    }
    barrier();
    for (uint from = 0u; from < count; from += LANES / samples) {
      uint pixel = from + lane() / samples, i = lane() % samples;
      if (pixel >= count || (traced_open[pixel] & point_bit(i)) == 0u) continue;
      Bundle bundle = Bundle(traced_origin[pixel], vec3(0.0), 0.0, traced_first[pixel]);
      if (meets(tree, bundle.origin, direction_to(bundle, i))) atomicAnd(traced_open[pixel], ~point_bit(i));
    }
    barrier();
    if (asks) open.points[r] = traced_open[own];
    barrier();
  }
}
#else
// Takes away the points of the pixels `asking` that a hierarchy's geometry hides.
void hide_behind(SoftLight light, Tree tree, Pixels pixels, uint asking, inout Open open) {
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    bool asks = (asking & (1u << r)) != 0u;
    uint left = open_behind(tree, bundle_of(light, pixels, open, r), asks ? open.points[r] : 0u);
    open.points[r] = asks ? left : open.points[r];
  }
}
#endif

void store_word(SoftLight light, uint plane, uvec2 lit, uvec2 valid) {
  uvec2 tile = tile_of_lane();
  if (lane() % 64u == 0u && (kTiles == 1u || tile.x < frame.tiles_x)) {
    uint word = (light.plane + plane) * frame.tile_count + tile.y * frame.tiles_x + tile.x;
    push.masks.at[word] = lit;
    push.valid_bits.at[word] = valid;
  }
}

void store_planes(SoftLight light, Open open, uint care) {
  uint samples = push.soft.samples;
  uint fully = 0u, partly = 0u;
  [[unroll]] for (uint r = 0u; r < kRounds; ++r) {
    uint seen = uint(bitCount(open.points[r]));
    fully |= seen == samples ? 1u << r : 0u;
    partly |= seen > 0u && seen < samples ? 1u << r : 0u;
  }
  uvec2 care_word = tile_word(care), full_word = tile_word(fully);
  store_word(light, 0u, full_word, care_word);
  bool mixed = any_lane(partly != 0u);
  for (uint plane = 1u; plane < light.planes; ++plane) {
    uvec2 word = uvec2(0u);
    if (mixed) {
      uint bits = 0u;
      [[unroll]] for (uint r = 0u; r < kRounds; ++r)
        bits |= ((uint(bitCount(open.points[r])) >> (light.planes - 1u - plane)) & 1u) << r;
      word = tile_word(bits & ~fully);
    }
    store_word(light, plane, word, care_word & ~full_word);
  }
}

void main() {
  Pixels pixels;
  load_pixels(pixels);
  for (uint i = 0u; i < push.soft.light_count; ++i) {
    SoftLight light = push.soft.lights[i];
    if (light.how == kLitEverywhere) {
      for (uint plane = 0u; plane < light.planes; ++plane)
        store_word(light, plane, uvec2(0xffffffffu), uvec2(plane == 0u ? 0xffffffffu : 0u));
      continue;
    }
    uint care = care_bits(light.light, pixels);
    Open open;
    [[unroll]] for (uint r = 0u; r < kRounds; ++r) open.points[r] = open.first[r] = 0u;
    if (any_lane(care != 0u)) {
      if (light.how == kByLightBuffer) {
        Asked asked = ask_planes(light.view, pixels, care);
        uint dark = ~(asked.lit | asked.undecided);
        open = facing_points(light, pixels, care & ~dark);
        uint by_hierarchy = with_long_lists(asked);
        asked.undecided &= ~by_hierarchy;
        if (any_lane(asked.undecided != 0u)) walk_lists(light, asked, pixels, open);
        if (any_lane(by_hierarchy != 0u)) hide_behind(light, Tree(push.still, false), pixels, by_hierarchy, open);
      } else {
        open = facing_points(light, pixels, care);
        hide_behind(light, Tree(push.still, false), pixels, care, open);
      }
      if (push.moving.node_count != 0u) hide_behind(light, Tree(push.moving, true), pixels, care, open);
    }
    store_planes(light, open, care);
  }
}
