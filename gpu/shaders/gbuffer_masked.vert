#version 460
#extension GL_GOOGLE_include_directive : require
#include "gbuffer.glsl"

layout(location = 1) out vec2 surface_uv;

void main() { surface_uv = frame.uvs.at[fetch_corner()]; }
