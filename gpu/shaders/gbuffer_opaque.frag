#version 460
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint triangle_id;

void main() { triangle_id = triangle + 1u; }
