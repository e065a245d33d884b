// A view that was rasterised before (gpu/passes/seen_view.h).
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SeenView {
  vec3 eye;
  uint width;
  vec3 forward;
  uint height;
  vec3 ray_corner;
  float pixel;  // width of a pixel at depth 1
  vec3 ray_dx;
  vec3 ray_dy;
  vec3 across;  // ray_dx / |ray_dx|^2; `down` likewise of ray_dy
  vec3 down;
  uint same_eye;
};
