/* ---- wavelets: BRDFs on texels ---- */

#ifndef SFIELD_WITHOUT_GLOSS
typedef struct sfield__lobe {       /* how a point looks to its eye */
    float n[3], v[3];               /* the normal, and to the eye */
    float mirror[3], exponent;      /* Phong: n, or 0 for the metal-rough BRDF */
    float a2, nv, go;               /* metal-rough: alpha^2, n . v and what Smith's shadowing has of both */
    float width;                    /* of the lobe's half vectors, or of the lobe: a tangent */
    int   narrow;                   /* not 0: the metal-rough lobe is not much wider than texels */
} sfield__lobe;

/* Returns a unit tangent of a surface that points to the eye, or anywhere if the eye is along the normal. */
static SFIELD__COLD sfield__v3 sfield__find_tangent(sfield__v3 n, sfield__v3 view)
{
    sfield__v3 t = sfield__v3_sub(view, sfield__v3_scale(n, sfield__v3_dot(n, view)));
    if (sfield__v3_dot(t, t) < 1e-12f)
        t = sfield__v3_cross(n, fabsf(n.x) < 0.6f ? sfield__v3_make(1, 0, 0) : sfield__v3_make(0, 1, 0));
    return sfield__v3_normalize(t);
}

/* Prepares a point's BRDF. set->exponents or set->materials are there. */
static SFIELD__COLD void sfield__read_lobe(const sfield_points *set, size_t index, const float *n,
                                           const float *view,
                              sfield__lobe *b)
{
    const sfield__v3 up = sfield__v3_load(n), v = sfield__v3_load(view);
    float alpha;
    b->exponent = 0;
    b->narrow = 0;
    b->nv = sfield__v3_dot(up, v);
    sfield__v3_store(b->n, up);
    sfield__v3_store(b->v, v);
    sfield__v3_store(b->mirror, sfield__v3_sub(sfield__v3_scale(up, 2 * b->nv), v));
    if (!set->materials) {
        b->exponent = sfield__exponent_of(set, index);
        b->width = sqrtf(2 / b->exponent);
        return;
    }
    alpha = sfield__alpha_of(sfield__value_of(set->materials, set->material_stride, index)[4]);
    if (b->nv < 1e-3f) {            /* below the horizon an eye looks along the surface, as in the table */
        b->nv = 1e-3f;
        sfield__v3_store(b->v, sfield__v3_madd(sfield__find_tangent(up, v), up, 1e-3f));
    }
    b->a2 = alpha * alpha;
    b->go = sqrtf(b->a2 + (1 - b->a2) * b->nv * b->nv);
    b->width = alpha;
    b->narrow = alpha < 0.08f;
}

/* Adds the kernels times cosine in a direction: of the lobe to out[1], of the metal-rough BRDF to all
   three. */
static void sfield__add_response(const sfield__lobe *b, const float *l, float *out)
{
    const float nl = b->n[0] * l[0] + b->n[1] * l[1] + b->n[2] * l[2];
    float h[3], hh = 0, along = 0, across = 0;
    float q, s, all;
    if (!(nl > 0)) return;
    if (b->exponent > 0) {
        along = b->mirror[0] * l[0] + b->mirror[1] * l[1] + b->mirror[2] * l[2];
        if (along > 0) out[1] += nl * (b->exponent + 2) * 0.159154943f * sfield__pow(along, b->exponent);
        return;
    }
    for (int k = 0; k < 3; k++) {
        h[k] = l[k] + b->v[k];
        hh += h[k] * h[k];
        along += h[k] * b->n[k];
    }
    /* 1 - (n . h)^2 by what of h lies across n: the difference would have few digits where a shallow light
       meets a shallow eye */
    for (int k = 0; k < 3; k++) {
        const float part = h[k] - along * b->n[k];
        across += part * part;
    }
    hh = hh > 4e-6f ? hh : 4e-6f;
    q = (across + along * along * b->a2) / hh;
    s = hh < 4 ? 0.25f * hh : 1;                /* (v . h)^2 */
    s = 1 - sqrtf(s);
    s = s * s * (s * s) * s;
    all = nl * 0.159154943f * b->a2 / (q * q);
    all /= nl * b->go + b->nv * sqrtf(b->a2 + (1 - b->a2) * nl * nl);
    out[0] += nl * 0.318309886f * (1 - s);
    out[1] += all * (1 - s);
    out[2] += all * s;
}

/* Returns into how many parts a side a texel is divided, so that one part is not wider than half of what the
   lobe changes over there. */
static uint32_t sfield__count_parts(const sfield__lobe *b, const float *l, float texel)
{
    float h[3], off = 0, hh = 0;
    float hv = 0, wide;
    uint32_t k;
    if (b->exponent > 0) {
        for (k = 0; k < 3; k++) off += l[k] * b->mirror[k];
        /* the lobe's tail has nothing fine */
        if (off < 1 - 8 * b->width * b->width - texel) return 1;
        return (uint32_t)(2 * texel / b->width) + 1;
    }
    for (k = 0; k < 3; k++) {
        h[k] = l[k] + b->v[k];
        hh += h[k] * h[k];
        off += h[k] * b->n[k];
        hv += h[k] * b->v[k];
    }
    if (!(off > 0)) return 1;
    /* h turns by 1 / (2 v . h) of what l turns, or half of it */
    texel *= 0.5f * sqrtf(hh) / (hv > 1e-3f ? hv : 1e-3f);
    off = hh / (off * off) - 1;
    wide = 0.5f * ((off > 0 ? sqrtf(off) : 0) - texel);
    wide = wide > b->width ? wide : b->width;
    k = (uint32_t)(2 * texel / wide) + 1;
    return k < 16 ? k : 16;
}

/* Fills planes of texels with the kernels times cosine times solid angle: a lobe's in the second of them, or
   those of the metal-rough BRDF in three. */
static void sfield__fill_texels(const sfield_scene *s, const sfield__lobe *b, float *planes)
{
    const uint32_t cells = s->cells, chains = b->exponent > 0 ? 2 : 3;
    const float texel = 1.57079633f / (float)s->side;
    uint32_t i, k, part, parts;
    uint32_t face, x, y;
    for (i = 0; i < cells; i++) {
        float l[3], out[3] = { 0, 0, 0 }, scale;
        for (k = 0; k < 3; k++) l[k] = s->texel[k * cells + i];
        parts = b->narrow ? 1 : sfield__count_parts(b, l, texel);
        if (parts == 1) sfield__add_response(b, l, out);
        else sfield__texel_place(s->side, i, &face, &x, &y);
        for (part = 0; parts > 1 && part < parts * parts; part++) {
            const double step = 2.0 / ((double)parts * s->side);
            double d[3], unit;
            sfield__from_face(face, (x * parts + part % parts + 0.5) * step - 1,
                              (y * parts + part / parts + 0.5) * step - 1, d);
            unit = 1 / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (k = 0; k < 3; k++) l[k] = (float)(d[k] * unit);
            sfield__add_response(b, l, out);
        }
        scale = s->texel[3 * cells + i] / (float)(parts * parts);
        for (k = 0; k < chains; k++) planes[k * cells + i] = out[k] * scale;
    }
}

/* Fills the planes of D V of a lobe that is not much wider than texels: directions are drawn on an even grid,
   and each adds to the texel that it falls into. */
static SFIELD__COLD void sfield__scatter_lobe(const sfield_scene *s, const sfield__lobe *b, float *planes)
{
    const float c = b->nv < 1 ? b->nv : 1.0f, view[3] = { sqrtf(1 - c * c), 0, c };
    const float share = 1.0f / (float)(4 * SFIELD__DRAWS * SFIELD__DRAWS);
    float *facing = planes + s->cells, *grazing = facing + s->cells;
    const sfield__v3 n = sfield__v3_load(b->n), t = sfield__find_tangent(n, sfield__v3_load(b->v));
    const sfield__v3 u = sfield__v3_cross(n, t);
    uint32_t at, side;
    memset(facing, 0, 2 * (size_t)s->cells * sizeof *facing);
    for (at = 0; at < 2 * SFIELD__DRAWS * SFIELD__DRAWS; at++) {
        double number, turn[2];
        float l[3], w, fifth;
        sfield__find_draw(at / 2, &number, turn);
        number += (at & 1 ? 0.25 : -0.25) / (double)SFIELD__DRAWS;
        w = sfield__draw_direction(view, b->width, b->go, number, turn, l, &fifth) * l[2] * share;
        for (side = 0; side < 2 && l[2] > 0; side++) {
            const float y = side ? -l[1] : l[1];
            float d[3];
            uint32_t texel;
            sfield__v3_store(d, sfield__v3_make(l[0] * t.x + y * u.x + l[2] * n.x,
                                                l[0] * t.y + y * u.y + l[2] * n.y,
                                                l[0] * t.z + y * u.z + l[2] * n.z));
            texel = sfield_cube_find(s->side, d);
            facing[texel] += w * (1 - fifth);
            grazing[texel] += w * fifth;
        }
    }
}

/* Shades a point with gloss: T begins with the BRDF, once for each kernel, and goes through the same
   entities as that of rgb. */
static SFIELD__COLD void sfield__light_gloss(sfield__point *p, const sfield__tile *one, uint64_t *hash,
                                             float *ambient)
{
    const sfield_scene *s = p->s;
    const sfield_points *set = p->set;
    const size_t index = one->first;
    const uint32_t chains = p->chains;
    float x[3], n[3], view[3], sum[3][3] = { { 0 } };
    float *rgb = p->rgb, *gloss = set->gloss + 3 * index;
    sfield_scene_stats stats;
    sfield__lobe b;
    uint32_t count, until;
    uint32_t c;
    for (c = 0; c < 3; c++) {
        x[c] = one->p[16 * c];
        n[c] = one->n[16 * c];
        view[c] = one->view[16 * c];
    }
    count = sfield__find_rays(p, x, n);
    until = sfield__find_stale(p, index, count, hash);
    if (until) {
        sfield__read_lobe(set, index, n, view, &b);
        sfield__fill_texels(s, &b, p->kernels);
        if (b.narrow) sfield__scatter_lobe(s, &b, p->kernels);
    }
    stats = p->stats;
    for (c = 0; c < chains; c++) {
        p->kernel = chains == 2 && c == 0 ? NULL : p->kernels + (size_t)c * s->cells;
        p->chain = c;
        p->rgb = sum[c];
        sfield__light_chain(p, index, x, n, count, until, hash, c == 0 ? ambient : NULL);
        if (c == 0) stats = p->stats;
    }
    p->stats = stats;                           /* entities count once */
    p->kernel = NULL;
    p->chain = 0;
    for (c = 0; c < 3; c++) {
        if (chains == 2) {
            rgb[c] = sum[0][c];
            gloss[c] = sum[1][c];
        } else {
            const float f0 =
                sfield__facing_of(sfield__value_of(set->materials, set->material_stride, index), c);
            rgb[c] = sum[0][c] * (1 - f0) * 3.14159265f;        /* the caller divides by pi */
            gloss[c] = f0 * sum[1][c] + sum[2][c];
            if (set->grazing) set->grazing[3 * index + c] = sum[2][c];
        }
    }
}
#endif
