/* ---- inter-texel: VPLs between the texels of a source (paper 6.5) ---- */

/* Computes sample (x + fx, y + fy) of a grid as a mixture of the four texels about it, those that lie on one
   surface (paper 6.5). If the surface is curved, their chord may run behind it, and a VPL there would light a
   sheet's back: the sample lies on the chord or on the mean of the four tangent planes, whichever is farther
   out. Returns the distance to the farthest of the texels. */
static float ism__inter_texel(const ism__view *view, const ism_source *s, const ism__cdf2_sample *at,
                              ism__v3 *p, ism__v3 *n)
{
    size_t i0 = (size_t)at->y * s->width + at->x;
    ism__v3 p0 = ism__v3_load(ism__at(s->positions, s->position_stride, i0)),
            n0 = ism__v3_load(ism__at(s->normals, s->normal_stride, i0));
    ism__v3 sum = ism__v3_make(0, 0, 0), normal = sum, offsets[4], normals[4];
    float sx = at->fx - 0.5f, sy = at->fy - 0.5f, weights = 0.0f, spacing = 0.0f;
    float x0, y0, xk, yk;
    float share[4], behind = 0.0f;
    int k, used = 0, known = ism__to_pixel(view, p0, &x0, &y0);
    for (k = 0; k < 4; k++) {
        int64_t x = (int64_t)at->x + (k & 1 ? (sx < 0.0f ? -1 : 1) : 0),
                y = (int64_t)at->y + (k & 2 ? (sy < 0.0f ? -1 : 1) : 0);
        float w = (k & 1 ? fabsf(sx) : 1.0f - fabsf(sx)) * (k & 2 ? fabsf(sy) : 1.0f - fabsf(sy)), length;
        size_t i = (size_t)y * s->width + (size_t)x;
        ism__v3 q, nq, d;
        if (x < 0 || y < 0 || x >= (int64_t)s->width || y >= (int64_t)s->height) continue;
        if (!ism__flux_ok(ism__at(s->fluxes, s->flux_stride, i)) ||
            !(ism__luminance(ism__at(s->fluxes, s->flux_stride, i)) > 0.0f))
            continue;
        q = ism__v3_load(ism__at(s->positions, s->position_stride, i));
        nq = ism__v3_load(ism__at(s->normals, s->normal_stride, i));
        d = ism__v3_sub(q, p0);
        length = ism__v3_length(d);
        if (k && (!ism__v3_finite(nq) || !(ism__v3_dot(n0, nq) > 0.9f) ||
                  !(fabsf(ism__v3_dot(n0, d)) <= 0.1f * length))) continue;
        if (k && known && ism__to_pixel(view, q, &xk, &yk)) {   /* a Gaussian with variance 0.01, in clip
                                                                   space */
            float ex = 2.0f * (xk - x0) / (float)view->width, ey = 2.0f * (yk - y0) / (float)view->height;
            w *= ism__exp(-50.0f * (ex * ex + ey * ey));
        }
        sum = ism__v3_madd(sum, d, w);
        normal = ism__v3_madd(normal, nq, w);
        weights += w;
        offsets[used] = d;
        normals[used] = nq;
        share[used++] = w;
        if (length > spacing) spacing = length;
    }
    *p = p0;
    *n = n0;
    if (!(weights > 0.0f)) return spacing;
    *n = ism__v3_normalize(normal);
    sum = ism__v3_scale(sum, 1.0f / weights);
    for (k = 0; k < used; k++)
        behind += share[k] / weights * ism__v3_dot(normals[k], ism__v3_sub(offsets[k], sum)) *
                  ism__v3_dot(normals[k], *n);
    *p = ism__v3_add(p0, behind > 0.0f ? ism__v3_madd(sum, *n, behind) : sum);
    return spacing;
}
