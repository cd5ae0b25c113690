// sfield_gbuffer - the G-buffer of glbk_sfield: floats as their bits (docs/gpu-layouts.md).
// uses: sfield_shade
struct sfield_point { vec3 position, normal; uint entity; float exponent; bool recorded; };     // exponent 0: no lobe

// false: nothing is seen there.
bool sfield_read_point(ivec2 at, out sfield_point p)
{
    uvec4 place = texelFetch(glbk_sfield_place, at, 0), normal = texelFetch(glbk_sfield_normal, at, 0);
    p.position = uintBitsToFloat(place.xyz);
    p.normal = uintBitsToFloat(normal.xyz);
    p.entity = place.w;
    p.exponent = abs(uintBitsToFloat(normal.w));
    p.recorded = (normal.w >> 31) != 0u;
    return dot(p.normal, p.normal) > 0.5;
}

// Own visibility x cosine, in the world: from the G-buffer, two numbers a word in 1/32767 of 1.5; else the cosine.
void sfield_start(ivec2 at, sfield_point p, out float t[SFIELD_COEFS])
{
    if (!p.recorded) {
        sfield_cosine(p.normal, t);
        return;
    }
    for (int layer = 0; 8 * layer < SFIELD_COEFS; layer++) {
        uvec4 words = texelFetch(glbk_sfield_self, ivec3(at, layer), 0);
        for (int k = 0; k < 8; k++) {
            int bits = int((k & 1) != 0 ? words[k >> 1] : words[k >> 1] << 16) >> 16;
            if (8 * layer + k < SFIELD_COEFS) t[8 * layer + k] = float(bits) * (1.5 / 32767.0);
        }
    }
    if (p.entity != SFIELD_NONE) {
        uint rotation = SFIELD_MOVING(sfield_at(p.entity) + 5u).z;
        if (rotation != SFIELD_NONE) sfield_rotate(rotation, false, t);
    }
}

// Light, gloss and what is open, as the textures of the renderer hold them.
sfield_sums sfield_shade_point(ivec2 at, sfield_point p)
{
    float t[SFIELD_COEFS], g[SFIELD_COEFS];
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
    sfield_sums sums = sfield_shade(p.position, p.normal, p.entity, t, g);
    return sfield_sums(sums.light * (1.0 / SFIELD_PI), sums.gloss, sums.open / (SFIELD_PI * SFIELD_Y00));
}
