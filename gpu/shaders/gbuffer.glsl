// Corners of triangles for the G-buffer. Vertices are fetched here and not by the fixed pipeline: so each corner knows
// its triangle, draws may name triangles in any subset, and no stage needs primitive numbers, for which lavapipe
// copies every triangle.
#include "frame.glsl"

layout(push_constant, scalar) uniform Push { uvec2 drawn; } push;  // address of triangle numbers; 0: all are drawn
layout(location = 0) flat out uint triangle;

// The number of this vertex.
uint fetch_corner() {
  triangle = uint(gl_VertexIndex) / 3u;
  if (push.drawn != uvec2(0)) triangle = Uints(push.drawn).at[triangle];
  uint vertex = frame.triangles.at[triangle][uint(gl_VertexIndex) % 3u];
  // Relative to the camera first: large world coordinates cancel exactly.
  gl_Position = frame.camera_to_clip * vec4(frame.positions.at[vertex] - frame.camera, 1.0);
  return vertex;
}
