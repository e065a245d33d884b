#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_query : require
#define TRACER_PUSH uvec2 acceleration_structure; uint first_masked_triangle;
#include "trace.glsl"
#include "tracers/ray_query.glsl"
