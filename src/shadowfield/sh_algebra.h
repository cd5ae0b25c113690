/* ---- harmonics: products of sixteen pairs of vectors ---- */

typedef struct sfield__entry { uint32_t pair; float c; } sfield__entry;

struct sfield_algebra {
    sfield__allocator allocator;
    sfield__logger log;             /* of the system that the tables were made with */
    uint32_t       bands, coefs;    /* n, n^2 */
    int            simd;            /* 0 none, 1 AVX2, 2 AVX-512 */
    uint32_t       pair_count;      /* of i >= j >= 1 with any tripling coefficient */
    uint32_t       row[SFIELD_MAX_COEFS + 1];     /* first pair with this i */
    uint32_t       first[SFIELD_MAX_COEFS + 1];   /* first entry of output k */
    uint8_t       *pair;            /* j of each pair; i is its row */
    uint8_t       *pair_i;
    sfield__entry *entry;
    uint32_t       node_count;      /* quadrature of degree 2 (n - 1) for rotations */
    double        *node;            /* x, y, z, weight */
    double        *basis;           /* n^2 at each node, times weight */
    void          *memory;
};

static const float sfield__y00 = 0.282094792f;      /* Y_00, and C_0jj for every j */

/* ---- harmonics: tripling coefficients, and products of any number of vectors ---- */

static int sfield__may_triple(uint32_t i, uint32_t j, uint32_t k)
{
    uint32_t a = 0, b = 0, c = 0;
    while ((a + 1) * (a + 1) <= i) a++;
    while ((b + 1) * (b + 1) <= j) b++;
    while ((c + 1) * (c + 1) <= k) c++;
    return (a + b + c) % 2 == 0 && a + b >= c && a + c >= b && b + c >= a;
}

/* Finds the pairs by nodes of degree 3 (n - 1); table: coefs floats a pair. Returns how many are not 0. */
static uint32_t sfield__find_tripling(sfield_algebra *t, const double *basis, const double *node,
                                      size_t nodes, double *product, float *table)
{
    uint32_t i, j, k, entries = 0;
    size_t g;
    t->pair_count = 0;
    for (i = 1; i < t->coefs; i++) {
        t->row[i] = t->pair_count;
        for (j = 1; j <= i; j++) {
            float *c = table + (size_t)t->pair_count * t->coefs;
            uint32_t used = 0;
            for (g = 0; g < nodes; g++)
                product[g] = node[4 * g + 3] * basis[g * t->coefs + i] * basis[g * t->coefs + j];
            for (k = 1; k < t->coefs; k++) {
                double sum = 0;
                for (g = 0; sfield__may_triple(i, j, k) && g < nodes; g++)
                    sum += product[g] * basis[g * t->coefs + k];
                c[k] = fabs(sum) > 1e-9 ? (float)sum : 0.0f;
                used += c[k] != 0.0f;
            }
            if (!used) continue;
            entries += used;
            t->pair[t->pair_count] = (uint8_t)j;
            t->pair_i[t->pair_count++] = (uint8_t)i;
        }
    }
    t->row[t->coefs] = t->pair_count;
    return entries;
}

static void sfield__fill_entries(sfield_algebra *t, const float *table)
{
    uint32_t k, q, n = 0;
    for (k = 1; k < t->coefs; k++) {
        t->first[k] = n;
        for (q = 0; q < t->pair_count; q++)
            if (table[(size_t)q * t->coefs + k] != 0.0f) {
                t->entry[n].pair = q;
                t->entry[n++].c = table[(size_t)q * t->coefs + k];
            }
    }
    t->first[t->coefs] = n;
}

static sfield_result sfield__fill_algebra(sfield_algebra *t, double *work, size_t nodes)
{
    uint32_t pairs = t->coefs * (t->coefs - 1) / 2, entries;
    double *node = work, *basis = node + 4 * nodes, *product = basis + nodes * t->coefs;
    float *table = (float *)(void *)(product + nodes);
    size_t g, k;
    uint8_t *at;
    sfield__fill_grid(3 * (t->bands - 1), node);
    sfield__evaluate_basis(node, nodes, t->bands, basis);
    t->pair = (uint8_t *)(table + (size_t)pairs * t->coefs);
    t->pair_i = t->pair + pairs;
    entries = sfield__find_tripling(t, basis, node, nodes, product, table);
    t->node_count = (uint32_t)sfield__grid_size(2 * (t->bands - 1));
    at = (uint8_t *)sfield__alloc(&t->allocator, t->node_count * (4 + t->coefs) * sizeof(double) +
                                                     entries * sizeof *t->entry + 2 * t->pair_count + 16);
    if (!at) return SFIELD_ERR_ALLOC;
    t->memory = at;
    t->node = (double *)(void *)at;
    t->basis = t->node + 4 * (size_t)t->node_count;
    t->entry = (sfield__entry *)(void *)(t->basis + (size_t)t->node_count * t->coefs);
    at = (uint8_t *)(t->entry + entries);
    memcpy(at, t->pair, t->pair_count);
    memcpy(at + t->pair_count, t->pair_i, t->pair_count);
    t->pair = at;
    t->pair_i = at + t->pair_count;
    sfield__fill_entries(t, table);
    sfield__fill_grid(2 * (t->bands - 1), t->node);
    sfield__evaluate_basis(t->node, t->node_count, t->bands, t->basis);
    for (g = 0; g < t->node_count; g++)
        for (k = 0; k < t->coefs; k++) t->basis[g * t->coefs + k] *= t->node[4 * g + 3];
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_system *system,
                                               sfield_algebra **out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_algebra_create");
    sfield__allocator a = sfield__allocator_of(system);
    sfield_algebra *t;
    sfield_result result;
    double *work;
    size_t nodes, pairs;
    if (!out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "out", "is NULL");
    if (!sfield__check_value(&log, bands >= 1 && bands <= SFIELD_MAX_BANDS, "bands", bands, "1..8"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__system_good(system)) return sfield__fail_allocator(&log);
    t = (sfield_algebra *)sfield__alloc(&a, sizeof *t);
    if (!t) return SFIELD_ERR_ALLOC;
    memset(t, 0, sizeof *t);
    t->allocator = a;
    t->log = log;
    t->bands = bands;
    t->coefs = bands * bands;
    t->simd = sfield__simd_level();
    nodes = sfield__grid_size(3 * (bands - 1));
    pairs = (size_t)t->coefs * (t->coefs - 1) / 2;
    work = (double *)sfield__alloc(&a, nodes * (t->coefs + 5) * sizeof *work +
                                           pairs * (t->coefs * sizeof(float) + 2));
    result = work ? sfield__fill_algebra(t, work, nodes) : SFIELD_ERR_ALLOC;
    sfield__free(&a, work);
    if (result != SFIELD_OK) {
        sfield_algebra_free(t);
        return result;
    }
    *out = t;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_algebra_free(sfield_algebra *algebra)
{
    sfield__allocator a;
    if (!algebra) return;
    a = algebra->allocator;
    sfield__free(&a, algebra->memory);
    sfield__free(&a, algebra);
}

/* Copies planes of `count` vectors, fewer than 16, to a tile. Missing lanes are 0. */
static void sfield__load_tile(uint32_t coefs, size_t count, const float *in, size_t stride, float *tile)
{
    size_t k, i;
    for (k = 0; k < coefs; k++)
        for (i = 0; i < SFIELD__LANES; i++)
            tile[k * SFIELD__LANES + i] = i < count ? in[k * stride + i] : 0.0f;
}

static void sfield__store_tile(uint32_t coefs, size_t count, const float *tile, float *out, size_t stride)
{
    size_t k, i;
    for (k = 0; k < coefs; k++)
        for (i = 0; i < count; i++) out[k * stride + i] = tile[k * SFIELD__LANES + i];
}

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *t, size_t count, const float *a,
                                           const float *b, float *out, size_t stride)
{
    float tile[2][SFIELD_MAX_COEFS * SFIELD__LANES] = { { 0 } };
    sfield__logger log;
    size_t i;
    if (!t) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_for(&t->log, "sfield_sh_product");
    if (!a || !b || !out) return sfield__fail_null(&log, !a ? "a" : !b ? "b" : "out");
    if (!sfield__check_stride(&log, stride, count)) return SFIELD_ERR_ARGUMENT;
    for (i = 0; i + SFIELD__LANES <= count; i += SFIELD__LANES)
        sfield__product16(t, a + i, b + i, out + i, stride, 0);
    if (i == count) return SFIELD_OK;
    sfield__load_tile(t->coefs, count - i, a + i, stride, tile[0]);
    sfield__load_tile(t->coefs, count - i, b + i, stride, tile[1]);
    sfield__product16(t, tile[0], tile[1], tile[0], SFIELD__LANES, 0);
    sfield__store_tile(t->coefs, count - i, tile[0], out + i, stride);
    return SFIELD_OK;
}

SFIELD_DEF size_t sfield_sh_terms(const sfield_algebra *t, uint32_t *terms, float *factors)
{
    uint32_t k, q;
    if (!t) return 0;
    for (k = 1; k < t->coefs && terms && factors; k++)
        for (q = t->first[k]; q < t->first[k + 1]; q++) {
            uint32_t pair = t->entry[q].pair;
            terms[q] = (uint32_t)t->pair_i[pair] | (uint32_t)t->pair[pair] << 8 | k << 16;
            factors[q] = t->entry[q].c;
        }
    return t->first[t->coefs];
}

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b,
                                       float *out, size_t stride)
{
    size_t i, j, n, k;
    if (bands < 1 || bands > SFIELD_MAX_BANDS || !a || !b || !out || stride < count)
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < count; i += n) {
        float sum[SFIELD__LANES] = { 0 };
        n = count - i < SFIELD__LANES ? count - i : (size_t)SFIELD__LANES;
        for (k = 0; k < (size_t)bands * bands; k++) {
            const float *p = a + k * stride + i, *q = b + k * stride + i;
            if (n == SFIELD__LANES)
                for (j = 0; j < SFIELD__LANES; j++) sum[j] += p[j] * q[j];
            else
                for (j = 0; j < n; j++) sum[j] += p[j] * q[j];
        }
        for (j = 0; j < n; j++) out[i + j] = sum[j];
    }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_system *system, double *out)
{
    const sfield__logger log = sfield__logger_of(system, "sfield_sh_product_n");
    sfield__allocator a = sfield__allocator_of(system);
    double y[SFIELD_MAX_COEFS], sum[SFIELD_MAX_COEFS], *node;
    uint32_t n = bands * bands, f, k;
    size_t nodes, g;
    if (!coefs || !out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, coefs ? "out" : "coefs", "is NULL");
    if (!sfield__check_value(&log, bands >= 1 && bands <= SFIELD_MAX_BANDS, "bands", bands, "1..8") ||
        !sfield__check_value(&log, functions >= 1 && functions <= 32, "functions", functions, "1..32"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__system_good(system)) return sfield__fail_allocator(&log);
    nodes = sfield__grid_size((functions + 1) * (bands - 1));
    node = (double *)sfield__alloc_array(&a, nodes, 4 * sizeof *node);
    if (!node) return SFIELD_ERR_ALLOC;
    sfield__fill_grid((functions + 1) * (bands - 1), node);
    memset(sum, 0, sizeof sum);
    for (g = 0; g < nodes; g++) {
        double product = node[4 * g + 3];
        sfield_sh_basis(bands, node + 4 * g, y);
        for (f = 0; f < functions; f++) {
            double value = 0;
            for (k = 0; k < n; k++) value += (double)coefs[f * n + k] * y[k];
            product *= value;
        }
        for (k = 0; k < n; k++) sum[k] += product * y[k];
    }
    sfield__free(&a, node);
    memcpy(out, sum, n * sizeof *out);
    return SFIELD_OK;
}
