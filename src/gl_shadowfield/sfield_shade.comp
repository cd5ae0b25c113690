// Does the work of sfield_shade.frag as a compute shader: a work group finds the entities near its 8 x 8
// pixels together.
// uses: sfield_list sfield_point
// sets: SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_SELF=1
// sets: SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0
// sets: SFIELD_BANDS=4 SFIELD_GLOSS=2 SFIELD_GRAZING=1 SFIELD_SELF=1
// sets: SFIELD_BANDS=4 SFIELD_EXP=1 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_EXP=1 SFIELD_GLOSS=2
layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(glbk_gbuffer_place, 0);
    bool inside = all(lessThan(at, size));
    glbk_point p;
    sfield_sums sums = sfield_no_light();
    bool seen = glbk_read_point(min(at, size - 1), p) && inside;
    sfield_list(p.position, p.normal, seen);
    if (seen) sums = sfield_shade_point(at, p);
    if (!inside) return;
    imageStore(glbk_sfield_light_image, at, vec4(sums.light, sums.open));
#if SFIELD_GLOSS
    imageStore(glbk_sfield_gloss_image, at, vec4(sums.gloss, 1.0));
#endif
#if SFIELD_GRAZING
    imageStore(glbk_sfield_grazing_image, at, vec4(sums.grazing, 1.0));
#endif
}
