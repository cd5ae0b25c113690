// prelude - goes before everything else: precision, and targets that hold the bits of floats.
#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler3D;
precision highp samplerCube;
precision highp sampler2DArray;
precision highp sampler2DShadow;
precision highp sampler2DArrayShadow;
precision highp isampler2D;
precision highp isampler2DArray;
precision highp usampler2D;
precision highp usampler2DArray;
#endif

#ifndef GLBK_FLOAT_BITS
#error "GLBK_FLOAT_BITS: 1 where GLBK_FORMAT_COLOR is RGBA32UI, else 0"
#endif

// An output of such a target is "layout(location = 0) out glbk_color name;" and gets glbk_pack(vec4); a
// texture of that format is a glbk_color_sampler, glbk_unpack(texelFetch(...)).
#if GLBK_FLOAT_BITS
#define glbk_color uvec4
#define glbk_color_sampler usampler2D
uvec4 glbk_pack(vec4 color) { return floatBitsToUint(color); }
vec4 glbk_unpack(uvec4 bits) { return uintBitsToFloat(bits); }
#else
#define glbk_color vec4
#define glbk_color_sampler sampler2D
vec4 glbk_pack(vec4 color) { return color; }
vec4 glbk_unpack(vec4 color) { return color; }
#endif
