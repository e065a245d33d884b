#version 460
#extension GL_GOOGLE_include_directive : require
#define LANES 8
#include "trace_light_buffer.glsl"
