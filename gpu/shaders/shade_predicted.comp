#version 460
#extension GL_GOOGLE_include_directive : require
#define PREDICTED
#include "shade.glsl"
