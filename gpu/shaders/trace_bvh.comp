#version 460
#extension GL_GOOGLE_include_directive : require
#define TRACER_PUSH uvec2 nodes; uvec2 triangles; uint node_count;
#include "trace.glsl"
#include "tracers/bvh.glsl"
