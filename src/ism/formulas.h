/* ---- formulas: solid angle, form factor, dithering ---- */

/* Returns the solid angle of a triangle seen from the origin, in sr, exact for any size (Van Oosterom and
   Strackee 1983), and 0 for a triangle without area:
   tan(omega / 2) = a . (b x c) / (abc + (a . b) c + (a . c) b + (b . c) a). */
static float ism__solid_angle(const float pa[3], const float pb[3], const float pc[3])
{
    ism__v3 a = ism__v3_load(pa), b = ism__v3_load(pb), c = ism__v3_load(pc);
    float la = ism__v3_length(a), lb = ism__v3_length(b), lc = ism__v3_length(c);
    float top = fabsf(ism__v3_dot(a, ism__v3_cross(b, c))), omega;
    float below = la * lb * lc + ism__v3_dot(a, b) * lc + ism__v3_dot(a, c) * lb + ism__v3_dot(b, c) * la;
    if (!(top > 0.0f) || !ism__finite(top) || !ism__finite(below)) return 0.0f;
    omega = 2.0f * ism__atan2(top, below);
    return omega > 0.0f ? omega : 0.0f;
}

/* Returns the form factor from a point at the origin with the normal n to a flat polygon, whose corners go
   counter-clockwise as seen from the point, by Lambert's sum over the edges of the part above the horizon:
   F = 1 / 2 pi sum angle(a, b) n . (b x a) / |b x a|. *share is the part of the area that is left; share may
   be NULL. */
static float ism__form_factor(ism__v3 n, const ism__v3 *corner, uint32_t count, float *share)
{
    ism__v3 p[8];
    float sum = 0.0f, cut = 0.0f, whole = 0.0f;
    uint32_t i, k = 0;
    for (i = 0; i < count; i++) {
        ism__v3 a = corner[i], b = corner[(i + 1u) % count];
        float ha = ism__v3_dot(n, a), hb = ism__v3_dot(n, b);
        if (ha > 0.0f) p[k++] = a;
        if ((ha > 0.0f) != (hb > 0.0f)) p[k++] = ism__v3_madd(a, ism__v3_sub(b, a), ha / (ha - hb));
    }
    if (share) {
        ism__v3 s = ism__v3_make(0, 0, 0), t = s;
        for (i = 1; i + 1u < k; i++)
            s = ism__v3_add(s, ism__v3_cross(ism__v3_sub(p[i], p[0]), ism__v3_sub(p[i + 1u], p[0])));
        for (i = 1; i + 1u < count; i++)
            t = ism__v3_add(
                t, ism__v3_cross(ism__v3_sub(corner[i], corner[0]), ism__v3_sub(corner[i + 1u], corner[0])));
        cut = ism__v3_length(s);
        whole = ism__v3_length(t);
        *share = whole > 0.0f ? cut / whole : 1.0f;
    }
    for (i = 0; i < k; i++) {
        ism__v3 a = p[i], b = p[(i + 1u) % k], c = ism__v3_cross(b, a);
        float length = ism__v3_length(c);
        if (length > 0.0f) sum += ism__atan2(length, ism__v3_dot(a, b)) * (ism__v3_dot(n, c) / length);
    }
    return sum * 0.159154943f;
}

/* Returns whether a pixel of a surface with this opacity is drawn. Of each 2 x 2 pixels the opacities 0, .25,
   .5, .75 and 1 draw exactly 0 to 4 (paper 6.4). */
static int ism__dither(uint32_t x, uint32_t y, float opacity)
{
    static const float threshold[4] = { 0.125f, 0.625f, 0.875f, 0.375f };   /* Bayer's 2 x 2 */
    return opacity > threshold[(y & 1u) * 2u + (x & 1u)];
}
