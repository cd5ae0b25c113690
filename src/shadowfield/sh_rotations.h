/* ---- harmonics: rotations ---- */

/* Returns whether a matrix that rotates and scales does not rotate. Only the zeros are looked at, since a
   diagonal that was divided by its mean length may miss 1. */
static int sfield__is_upright(const float *m)
{
    return m[1] == 0 && m[2] == 0 && m[4] == 0 && m[6] == 0 && m[8] == 0 && m[9] == 0 && m[0] > 0 && m[5] > 0;
}

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *t, const float matrix[16],
                                            sfield_rotation *out)
{
    double sum[680], y[SFIELD_MAX_COEFS], *s;
    const double *basis;
    float scale, *block;
    uint32_t g, l, i, j;
    sfield__logger log;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_rotation");
    if (!matrix || !out) return sfield__fail_null(&log, matrix ? "out" : "matrix");
    if (!sfield__m4_is_rigid_uniform(matrix, &scale))
        return sfield__fail(&log, SFIELD_ERR_INPUT, "matrix", "is no rotation with one scale > 0");
    memset(sum, 0, sizeof sum);
    for (g = 0; g < t->node_count; g++) {
        const double *d = t->node + 4 * (size_t)g;
        double back[3], length;
        for (i = 0; i < 3; i++)
            back[i] = (double)matrix[4 * i] * d[0] + (double)matrix[4 * i + 1] * d[1] +
                      (double)matrix[4 * i + 2] * d[2];
        length = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
        for (i = 0; i < 3; i++) back[i] /= length;
        sfield_sh_basis(t->bands, back, y);
        for (l = 0, s = sum; l < t->bands; l++) {
            basis = t->basis + (size_t)g * t->coefs + l * l;
            for (i = 0; i < 2 * l + 1; i++)
                for (j = 0; j < 2 * l + 1; j++) *s++ += basis[i] * y[l * l + j];
        }
    }
    memset(out, 0, sizeof *out);
    out->bands = t->bands;
    out->identity = sfield__is_upright(matrix);
    for (l = 0, s = sum, block = out->block; l < t->bands; l++)
        for (i = 0; i < 2 * l + 1; i++)
            for (j = 0; j < 2 * l + 1; j++, s++)
                *block++ = out->identity ? (i == j ? 1.0f : 0.0f) : (float)*s;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *r, size_t count, const float *in, float *out,
                                          size_t stride)
{
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    int simd = sfield__simd_level();
    uint32_t coefs;
    size_t i;
    if (!r || !in || !out || stride < count || r->bands < 1 || r->bands > SFIELD_MAX_BANDS)
        return SFIELD_ERR_ARGUMENT;
    coefs = r->bands * r->bands;
    for (i = 0; i + SFIELD__LANES <= count; i += SFIELD__LANES)
        sfield__rotate16(r, in + i, out + i, stride, 0, simd);
    if (i == count) return SFIELD_OK;
    sfield__load_tile(coefs, count - i, in + i, stride, tile);
    sfield__rotate16(r, tile, tile, SFIELD__LANES, 0, simd);
    sfield__store_tile(coefs, count - i, tile, out + i, stride);
    return SFIELD_OK;
}
