// A view that was rasterised before (gpu/passes/seen_view.h).
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SeenView {
  vec3 eye;
  uint width;
  vec3 forward;
  uint height;
  vec3 ray_corner;
  float pixel;  // its width, at depth 1
  vec3 ray_dx;
  vec3 ray_dy;
  vec3 across;  // ray_dx and ray_dy over their squares
  vec3 down;
};
