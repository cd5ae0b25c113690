/* ---- harmonics: logarithms (Ren et al., "Real-time soft shadows in dynamic scenes using spherical harmonic
   exponentiation", SIGGRAPH 2006) ---- */

/* Does one Jacobi rotation of the symmetric matrix m and of the vectors v, n x n each. */
static void sfield__jacobi(double *m, double *v, uint32_t n, uint32_t p, uint32_t q)
{
    double off = m[p * n + q], theta, t;
    double c, s;
    uint32_t i;
    if (fabs(off) < 1e-15) return;
    theta = (m[q * n + q] - m[p * n + p]) / (2 * off);
    t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    c = 1 / sqrt(t * t + 1);
    s = t * c;
    for (i = 0; i < n; i++) {
        double a = m[i * n + p], b = m[i * n + q];
        m[i * n + p] = c * a - s * b;
        m[i * n + q] = s * a + c * b;
    }
    for (i = 0; i < n; i++) {
        double a = m[p * n + i], b = m[q * n + i];
        m[p * n + i] = c * a - s * b;
        m[q * n + i] = s * a + c * b;
        a = v[p * n + i];
        b = v[q * n + i];
        v[p * n + i] = c * a - s * b;
        v[q * n + i] = s * a + c * b;
    }
}

/* Computes the logarithm log f = V^T log(D) V 1, where V^T D V is the matrix that multiplies by f. work has
   room for 2 n^2 doubles, where n is the number of coefficients. */
static void sfield__sh_log(const sfield_algebra *t, const float *f, float *out, double *work)
{
    uint32_t n = t->coefs, i, j;
    uint32_t k, q, sweep;
    double *m = work, *v = work + n * n, sum[SFIELD_MAX_COEFS];
    for (i = 0; i < n; i++)
        for (j = 0; j < n; j++) {
            m[i * n + j] = i == j ? (double)f[0] * (double)sfield__y00 : 0;
            v[i * n + j] = i == j;
        }
    for (j = 1; j < n; j++) m[j] = m[j * n] = (double)f[j] * (double)sfield__y00;
    for (k = 1; k < n; k++)
        for (q = t->first[k]; q < t->first[k + 1]; q++) {
            i = t->pair_i[t->entry[q].pair];
            j = t->pair[t->entry[q].pair];
            m[i * n + j] += (double)t->entry[q].c * (double)f[k];
            if (i != j) m[j * n + i] += (double)t->entry[q].c * (double)f[k];
        }
    for (sweep = 0; sweep < 10; sweep++)
        for (i = 0; i + 1 < n; i++)
            for (j = i + 1; j < n; j++) sfield__jacobi(m, v, n, i, j);
    memset(sum, 0, sizeof sum);
    for (i = 0; i < n; i++) {
        double d = m[i * n + i];
        d = (double)sfield__log((float)(d > 0.02 ? d : 0.02)) * v[i * n] / (double)sfield__y00;
        for (j = 0; j < n; j++) sum[j] += d * v[i * n + j];
    }
    for (j = 0; j < n; j++) out[j] = (float)sum[j];
}

SFIELD_DEF sfield_result sfield_sh_log(const sfield_algebra *t, const float *visibility, float *out)
{
    sfield__logger log;
    double *work;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_log");
    if (!visibility || !out) return sfield__fail_null(&log, visibility ? "out" : "visibility");
    work = (double *)sfield__alloc_array(&t->allocator, 2 * (size_t)t->coefs * t->coefs, sizeof *work);
    if (!work) return SFIELD_ERR_ALLOC;
    sfield__sh_log(t, visibility, out, work);
    sfield__free(&t->allocator, work);
    return SFIELD_OK;
}

/* Computes the exponentials of a tile. The constant is taken apart; of the rest h, exp(h) = (1 + h/s +
   (h/s)^2/2 + (h/s)^3/6)^s, where the power of two s is so large that |h/s| is small. out may be in. */
static void sfield__exponentiate16(const sfield_algebra *t, const float *in, float *out)
{
    float h[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 }, constant[SFIELD__LANES], most = 0, scale = 1;
    uint32_t k, i, squares, n = t->coefs * SFIELD__LANES;
    for (i = 0; i < SFIELD__LANES; i++) {
        float norm = 0;
        for (k = 1; k < t->coefs; k++) norm += in[k * SFIELD__LANES + i] * in[k * SFIELD__LANES + i];
        most = norm > most ? norm : most;
        constant[i] = sfield__exp(in[i] * sfield__y00);
    }
    for (squares = 0; squares < 12 && most * scale * scale > 0.25f; squares++) scale *= 0.5f;
    for (k = 0; k < n; k++) h[k] = k < SFIELD__LANES ? 0.0f : in[k] * scale;
    for (k = 0; k < n; k++) out[k] = h[k] * (1.0f / 3) + (k < SFIELD__LANES ? 1 / sfield__y00 : 0.0f);
    for (i = 2; i > 0; i--) {                   /* Horner: 1 + h (1 + h/2 (1 + h/3)) */
        sfield__product16(t, out, h, out, SFIELD__LANES, 0);
        for (k = 0; k < n; k++) out[k] = out[k] / (float)i + (k < SFIELD__LANES ? 1 / sfield__y00 : 0.0f);
    }
    for (i = 0; i < squares; i++) sfield__product16(t, out, out, out, SFIELD__LANES, 0);
    for (k = 0; k < n; k++) out[k] *= constant[k % SFIELD__LANES];
}

SFIELD_DEF sfield_result sfield_sh_exp(const sfield_algebra *t, size_t count, const float *in, float *out,
                                       size_t stride)
{
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    sfield__logger log;
    size_t i, n;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_exp");
    if (!in || !out) return sfield__fail_null(&log, in ? "out" : "in");
    if (!sfield__check_stride(&log, stride, count)) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < count; i += n) {
        n = count - i < SFIELD__LANES ? count - i : (size_t)SFIELD__LANES;
        sfield__load_tile(t->coefs, n, in + i, stride, tile);
        sfield__exponentiate16(t, tile, tile);
        sfield__store_tile(t->coefs, n, tile, out + i, stride);
    }
    return SFIELD_OK;
}
