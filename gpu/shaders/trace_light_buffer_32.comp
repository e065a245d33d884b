#version 460
#extension GL_GOOGLE_include_directive : require
#define LANES 32
#include "trace_light_buffer.glsl"
