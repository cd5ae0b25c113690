// Light at each pixel of the G-buffer: rgb without albedo, and the share of the cosine-weighted sky that is open.
// uses: sfield_gbuffer
// with: screen.vert
// sets: SFIELD_BANDS=4 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0
layout(location = 0) out glbk_color light;
#if SFIELD_GLOSS
layout(location = 1) out glbk_color gloss;
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    sfield_point p;
    sfield_sums sums = sfield_sums(vec3(0.0), vec3(0.0), 0.0);
    float t[SFIELD_COEFS], g[SFIELD_COEFS];
    if (sfield_read_point(at, p)) {
        sfield_start(at, p, t);
        for (int k = 0; k < SFIELD_COEFS; k++) g[k] = 0.0;
#if SFIELD_GLOSS
        vec3 view = glbk_sfield_frame.eye.xyz - p.position;
        float r[SFIELD_COEFS];
        if (p.exponent > 0.0 && dot(view, view) > 0.0) {
            sfield_lobe(reflect(-normalize(view), p.normal), clamp(p.exponent, 1.0, 1000.0), r);
            sfield_product(glbk_sfield_scene.parts.xy, t, r, g);
        }
#endif
        sums = sfield_shade(p.position, p.normal, p.entity, t, g);
    }
    light = glbk_pack(vec4(sums.light * (1.0 / SFIELD_PI), sums.open / (SFIELD_PI * SFIELD_Y00)));
#if SFIELD_GLOSS
    gloss = glbk_pack(vec4(sums.gloss, 1.0));
#endif
}
