#version 460
layout(location = 0) flat in uint first_triangle;
layout(location = 0) out uint triangle_id;

void main() { triangle_id = first_triangle + uint(gl_PrimitiveID) + 1u; }
