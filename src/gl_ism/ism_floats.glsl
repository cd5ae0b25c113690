// ism_floats - reads floats that a texture keeps as their bits; and the texel that a fragment is.
// uses: ism_bindings
#define ISM_FLOATS(t, at) uintBitsToFloat(texelFetch(t, at, 0))
#define ISM_HERE ivec2(gl_FragCoord.xy)
