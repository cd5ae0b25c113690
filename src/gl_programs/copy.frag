// Copies a GLBK_FORMAT_COLOR texture, texel by texel, to the same pixels of a target: of the same kind or,
// with TO_COLOR, of colours.
// uses: base_bindings
// with: screen.vert
// sets: TO_COLOR=0 | TO_COLOR=1
#ifndef TO_COLOR
#define TO_COLOR 0
#endif
#if TO_COLOR
layout(location = 0) out vec4 result;
#else
layout(location = 0) out glbk_color result;
#endif

void main()
{
    vec4 color = glbk_unpack(texelFetch(glbk_source, ivec2(gl_FragCoord.xy), 0));
#if TO_COLOR
    result = color;
#else
    result = glbk_pack(color);
#endif
}
