// sfield_point - returns the light at a pixel of the G-buffer (docs/gpu-layouts.md).
// uses: gbuffer sfield_shade
#ifndef SFIELD_SELF
#define SFIELD_SELF 0
#endif

// Writes self-visibility x cosine of a pixel, in the world: recorded numbers, two a word in 1/32767 of 1.5,
// or else the cosine. The first coefficient is 0 where nothing was recorded.
void sfield_start(ivec2 at, glbk_point p, out float t[SFIELD_COEFS])
{
    sfield_cosine(p.normal, t);
#if SFIELD_SELF
    if ((texelFetch(glbk_sfield_self, ivec3(at, 0), 0).x & 0xffffu) == 0u) return;
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
#endif
}

// Returns light, gloss and the open share, as the textures of the renderer hold them.
sfield_sums sfield_shade_point(ivec2 at, glbk_point p)
{
    float t[SFIELD_COEFS], g[SFIELD_COEFS];
    sfield_start(at, p, t);
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
}
