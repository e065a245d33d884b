// The shaft of all segments from a tile's surfaces, or some of them, to one light: boxes that it does not reach are left out
// for all of these at once (shaft culling: Haines and Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", 1991). In the common subset of GLSL and C++ with GLM, as exact.glsl, so that a test can ask it.

// At t of their way all segments are between t * end_lo and (1 - t) * extent + t * end_hi, seen from `from`.
struct TileShaft {
  vec3 from, extent, end_lo, end_hi;
};

// `lo`, `hi`: the bounds of the segments' origins.
EXACT_FN TileShaft shaft_to(TracedLight light, vec3 lo, vec3 hi) {
  TileShaft shaft;
  shaft.from = lo;
  shaft.extent = hi - lo;
  vec3 along = light.direction * -light.reach;
  shaft.end_lo = light.kind == 2u ? along : light.position - lo;
  shaft.end_hi = light.kind == 2u ? shaft.extent + along : shaft.end_lo;
  return shaft;
}

// Whether the shaft reaches into the box, widened by more than meets() widens it for any of the origins: the difference is
// a hundred times what rounding may move anything here.
EXACT_FN bool shaft_meets(TileShaft shaft, vec3 box_lo, vec3 box_hi) {
  vec3 lo = box_lo - shaft.from, hi = box_hi - shaft.from;
  vec3 reach = max(abs(lo), abs(hi)) + shaft.extent;
  float margin = max(reach.x, max(reach.y, reach.z)) * (1.0f / 4000.0f);
  // At both ends, by how much the shaft's upper side is above the box's lower one, and its lower side below the box's upper
  // one. If that is less than 0 at one end alone, it is 0 somewhere between.
  vec3 above_0 = shaft.extent - lo + margin, above_1 = shaft.end_hi - lo + margin;
  vec3 below_0 = hi + margin, below_1 = hi - shaft.end_lo + margin;
  vec3 none = vec3(0.0f), all = vec3(1.0f);
  if (any(lessThan(max(above_0, above_1), none)) || any(lessThan(max(below_0, below_1), none))) return false;
  vec3 above = above_0 / (above_0 - above_1), below = below_0 / (below_0 - below_1);
  vec3 enter = max(mix(none, above, lessThan(above_0, none)), mix(none, below, lessThan(below_0, none)));
  vec3 leave = min(mix(all, above, lessThan(above_1, none)), mix(all, below, lessThan(below_1, none)));
  return max(enter.x, max(enter.y, enter.z)) <= min(leave.x, min(leave.y, leave.z));
}
