// Words of a buffer two by two. Vector units load lane by lane, so that a load costs them by its components and not by its
// bytes: with BY_PAIRS the structures of tracers are loaded in half as many, of 64 bits.
#ifndef PAIRS_GLSL
#define PAIRS_GLSL
#ifdef BY_PAIRS
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

vec2 floats_of(uint64_t pair) { return uintBitsToFloat(unpack32(pair)); }

#endif
#endif
