#version 460
#extension GL_GOOGLE_include_directive : require
#include "gbuffer.glsl"

void main() { fetch_corner(); }
