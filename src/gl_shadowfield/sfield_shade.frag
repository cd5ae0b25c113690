// Writes the light at each pixel of the G-buffer, without albedo, and the share of the cosine-weighted sky
// that is open.
// uses: sfield_point
// with: screen.vert
// sets: SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_SELF=1
// sets: SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0
// sets: SFIELD_BANDS=4 SFIELD_GLOSS=2 SFIELD_GRAZING=1 SFIELD_SELF=1
// sets: SFIELD_BANDS=4 SFIELD_EXP=1 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_EXP=1 SFIELD_GLOSS=2
layout(location = 0) out glbk_color light;
#if SFIELD_GLOSS
layout(location = 1) out glbk_color gloss;
#endif
#if SFIELD_GRAZING
layout(location = 2) out glbk_color grazing;
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    glbk_point p;
    sfield_sums sums = sfield_no_light();
    if (glbk_read_point(at, p)) sums = sfield_shade_point(at, p);
    light = glbk_pack(vec4(sums.light, sums.open));
#if SFIELD_GLOSS
    gloss = glbk_pack(vec4(sums.gloss, 1.0));
#endif
#if SFIELD_GRAZING
    grazing = glbk_pack(vec4(sums.grazing, 1.0));
#endif
}
