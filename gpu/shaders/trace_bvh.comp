#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "hierarchy.glsl"
#define RESTING_ALONE
#define TRACER_PUSH Hierarchy scene;
#include "trace.glsl"
#include "tracers/bvh.glsl"

bool occluded(vec3 origin, vec3 direction) { return meets(Tree(push.scene, false), origin, direction); }
