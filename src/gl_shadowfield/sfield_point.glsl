// sfield_point - returns the light at a pixel of the G-buffer (docs/gpu-layouts.md).
// uses: gbuffer sfield_shade sfield_brdf
#ifndef SFIELD_SELF
#define SFIELD_SELF 0
#endif

// Writes self-visibility x cosine of a pixel, in the world: recorded numbers, two a word in 1/32767 of 1.5,
// or else the cosine. The first coefficient is 0 where nothing was recorded. Returns whether it was.
bool sfield_start(ivec2 at, glbk_point p, out float t[SFIELD_COEFS])
{
    sfield_cosine(p.normal, t);
#if SFIELD_SELF
    if ((texelFetch(glbk_sfield_self, ivec3(at, 0), 0).x & 0xffffu) == 0u) return false;
    for (int layer = 0; 8 * layer < SFIELD_COEFS; layer++) {
        uvec4 words = texelFetch(glbk_sfield_self, ivec3(at, layer), 0);
        for (int k = 0; k < 8; k++) {
            int bits = int((k & 1) != 0 ? words[k >> 1] : words[k >> 1] << 16) >> 16;
            if (8 * layer + k < SFIELD_COEFS) t[8 * layer + k] = float(bits) * (1.5 / 32767.0);
        }
    }
    if (p.entity - 1u < glbk_sfield_contents.entity_count) {        // entity 0, which is none, does not turn
        uint rotation = SFIELD_MOVING(sfield_at(p.entity - 1u) + 5u).z;
        if (rotation != SFIELD_NONE) sfield_rotate(rotation, false, t);
    }
    return true;
#else
    return false;
#endif
}

#if SFIELD_GLOSS > 1
// Returns light, gloss and the open share of a pixel of any material. t: as sfield_start wrote it; recorded:
// what it returned. The open share of a metal-rough pixel is that of its diffuse kernel.
sfield_sums sfield_shade_material(glbk_point p, float t[SFIELD_COEFS], bool recorded)
{
    float g[SFIELD_COEFS], h[SFIELD_COEFS], own[SFIELD_COEFS], r[SFIELD_COEFS], q[SFIELD_COEFS], whole = 1.0;
    vec3 view = glbk_sfield_frame.eye.xyz - p.position;
    bool metal = p.kind == GLBK_METAL_ROUGH, seen = dot(view, view) > 0.0;
    uint kernels = metal ? (recorded ? 4u : 3u) : p.exponent > 0.0 && seen ? 1u : 0u;
    if (metal && !seen) return sfield_no_light();
    view = seen ? normalize(view) : vec3(0.0);
    for (int k = 0; k < SFIELD_COEFS; k++) {
        own[k] = t[k];
        g[k] = h[k] = 0.0;
    }
    for (uint i = 0u; i < kernels; i++) {       // the fourth is the first without what is recorded
        bool last = i == 3u;
        if (metal) sfield_kernel(last ? 0u : recorded ? i + 3u : i, p.roughness, p.normal, view, r);
        else sfield_lobe(reflect(-view, p.normal), clamp(p.exponent, 1.0, 1000.0), r);
        if (metal && (last || (i == 0u && !recorded))) whole = r[0];
        if (!metal || recorded) {
            sfield_product(SFIELD_TERMS, own, r, q);
            r = q;
        }
        for (int k = 0; k < SFIELD_COEFS; k++) {
            t[k] = metal && i == 0u ? r[k] : t[k];
            g[k] = !metal || i == 1u ? r[k] : g[k];
            h[k] = metal && i == 2u ? r[k] : h[k];
        }
    }
    sfield_sums sums = sfield_shade(p.position, p.normal, p.entity, t, g, h);
    if (!metal) return sums;
    vec3 f0 = 0.04 + clamp(p.metallic, 0.0, 1.0) * (clamp(p.diffuse, 0.0, 1.0) - 0.04);
    sums.light *= SFIELD_PI * (1.0 - f0);
    sums.gloss = sums.gloss * f0 + sums.grazing;
    sums.open *= SFIELD_PI * SFIELD_Y00 / whole;
    return sums;
}
#endif

// Returns light, gloss and the open share, as the textures of the renderer hold them.
sfield_sums sfield_shade_point(ivec2 at, glbk_point p)
{
    float t[SFIELD_COEFS], g[SFIELD_COEFS];
    bool recorded = sfield_start(at, p, t);
#if SFIELD_GLOSS > 1
    return sfield_shade_material(p, t, recorded);
#else
    for (int k = 0; k < SFIELD_COEFS; k++) g[k] = 0.0;
#if SFIELD_GLOSS
    vec3 view = glbk_sfield_frame.eye.xyz - p.position;
    float r[SFIELD_COEFS];
    if (p.exponent > 0.0 && dot(view, view) > 0.0) {
        sfield_lobe(reflect(-normalize(view), p.normal), clamp(p.exponent, 1.0, 1000.0), r);
        sfield_product(SFIELD_TERMS, t, r, g);
    }
#endif
    return sfield_shade(p.position, p.normal, p.entity, t, g);
#endif
}
