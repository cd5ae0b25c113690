/* ---- wavelets: lists of coefficients about a point ---- */

/* The lists of wavelets around a point: which samples they belong to, with which weights. */
typedef struct sfield__lists { size_t sample[16]; float weight[16]; uint32_t count; } sfield__lists;

static void sfield__find_lists(const sfield_field *f, const sfield__place *at, int l, float time,
                               sfield__lists *out)
{
    size_t side = f->h.position_side, shell = 6 * side * side;
    uint32_t frame[2], i, j, k;
    float b[4], t = sfield__frames_at(f, time, &frame[0], &frame[1]);
    sfield__weigh_corners(at, l, b);
    out->count = 0;
    for (k = 0; k < 2; k++)
        for (j = 0; j < 2; j++)
            for (i = 0; i < 4; i++) {
                float w = b[i] * (j ? at->w1[l] : at->w0[l]) * (k ? t : 1 - t);
                if (!(w > 0)) continue;
                out->weight[out->count] = w;
                out->sample[out->count++] = frame[k] * f->h.shells * shell + (size_t)at->base[l] + j * shell +
                                            (i & 1) + (i >> 1) * side;
            }
}

/* Returns the number that the low 16 bits hold, in two's complement. */
static float sfield__signed_short(uint32_t bits)
{
    return (float)(int32_t)((bits & 0xffffu) ^ 0x8000u) - 32768.0f;
}

/* Adds weight x what a sample holds to coefs, all channels, in planes `cells` apart. */
static void sfield__scatter_list(const sfield_field *f, size_t sample, float weight, float *coefs)
{
    const uint32_t *e = f->entry + (size_t)f->offset[sample] * f->h.stride,
                   cells = 6 * f->h.cube_side * f->h.cube_side;
    const uint32_t *end = f->entry + (size_t)f->offset[sample + 1] * f->h.stride;
    weight *= f->sample_scale[sample];
    for (; e < end; e += f->h.stride) {
        coefs[e[0] >> 16] += weight * sfield__signed_short(e[0]);
        if (f->h.stride == 1) continue;
        coefs[cells + (e[0] >> 16)] += weight * sfield__signed_short(e[1] >> 16);
        coefs[2 * cells + (e[0] >> 16)] += weight * sfield__signed_short(e[1]);
    }
}

static void sfield__query_haar(const sfield_field *f, const sfield__place *at, int l, float time, float *out)
{
    uint32_t cells = 6 * f->h.cube_side * f->h.cube_side, face, i, c;
    float coefs[4096];
    sfield__lists lists;
    sfield__find_lists(f, at, l, time, &lists);
    memset(out, 0, (size_t)f->h.channels * cells * sizeof *out);
    for (i = 0; i < lists.count; i++) sfield__scatter_list(f, lists.sample[i], lists.weight[i], out);
    for (c = 0; c < f->h.channels; c++)
        for (face = 0; face < 6; face++) {
            uint32_t n = cells / 6, squares;
            float *t = out + c * cells + face * n;
            memcpy(coefs, t, n * sizeof *t);
            for (squares = 1; squares < n; squares *= 4) sfield__haar_up(coefs + squares, squares, t, t);
            for (i = 0; i < n && f->h.kind != SFIELD__KIND_SOURCE; i++) t[i] = 1 - t[i];
        }
}

/* Returns the share of the sphere of directions that an occlusion field of wavelets hides at lane l. */
static float sfield__hidden_share(const sfield_field *f, const sfield__place *at, int l)
{
    const uint32_t in_face = f->h.cube_side * f->h.cube_side - 1;
    sfield__lists lists;
    uint32_t i, k;
    float sum = 0;
    sfield__find_lists(f, at, l, 0, &lists);
    for (i = 0; i < lists.count; i++) {
        const size_t sample = lists.sample[i];
        float own = 0;
        for (k = f->offset[sample]; k < f->offset[sample + 1]; k++)
            own += sfield__signed_short(f->entry[k]) * f->angle[f->entry[k] >> 16 & in_face];
        sum += lists.weight[i] * f->sample_scale[sample] * own;
    }
    return sum * 0.0795774715f;                 /* of 4 pi */
}

/* Writes the texels that a point's own object hides. */
static void sfield__self_haar(const sfield_field *f, size_t point, float *out)
{
    float coefs[4096];
    uint32_t face, squares, m = f->h.cube_side * f->h.cube_side;
    memset(out, 0, 6 * m * sizeof *out);
    sfield__scatter_list(f, point, 1, out);
    for (face = 0; face < 6; face++, out += m) {
        memcpy(coefs, out, m * sizeof *out);
        for (squares = 1; squares < m; squares *= 4) sfield__haar_up(coefs + squares, squares, out, out);
    }
}
