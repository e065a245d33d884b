// Traces by the device's ray query. Opaque triangles end it; triangles with an alpha test are candidates that the
// shader tests.
#include "tracers/alpha.glsl"

bool candidate_blocks(uint triangle, vec3 origin, vec3 direction) {
  uvec3 corners = frame.triangles.at[triangle];
  return blocks_by_alpha(triangle, origin, direction, frame.positions.at[corners.x], frame.positions.at[corners.y],
                         frame.positions.at[corners.z]);
}

bool occluded(vec3 origin, vec3 direction) {
  if (push.acceleration_structure == uvec2(0)) return false;  // a scene without triangles
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(push.acceleration_structure), gl_RayFlagsTerminateOnFirstHitEXT,
                        0xff, origin, 0.0, direction, 1.0);
  while (rayQueryProceedEXT(query)) {
    uint triangle = push.first_masked_triangle + rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
    if (candidate_blocks(triangle, origin, direction)) rayQueryConfirmIntersectionEXT(query);
  }
  return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}
