// Radiance of glbk_ism_shade, as colours.
// uses: ism_bindings
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_ism_view.size.xy);
    result = glbk_unpack(texelFetch(glbk_ism_light, at, 0));
}
