// Fetches the corners of triangles for the G-buffer. The shader does this instead of the fixed pipeline, so that each
// corner has its triangle's number, draws may name any subset of the triangles, and no stage needs primitive numbers,
// for which lavapipe copies every triangle.
#include "frame.glsl"

layout(push_constant, scalar) uniform Push { uvec2 drawn; } push;  // address of triangle numbers; 0: all are drawn
layout(location = 0) flat out uint triangle;

// Sets the outputs that all vertex shaders share, and returns the number of the vertex.
uint fetch_corner() {
  triangle = uint(gl_VertexIndex) / 3u;
  if (push.drawn != uvec2(0)) triangle = Uints(push.drawn).at[triangle];
  uint vertex = frame.triangles.at[triangle][uint(gl_VertexIndex) % 3u];
  // Relative to the camera first: large world coordinates cancel exactly.
  gl_Position = frame.camera_to_clip * vec4(frame.positions.at[vertex] - frame.camera, 1.0);
  return vertex;
}
