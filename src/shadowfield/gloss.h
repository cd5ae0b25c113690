/* ---- gloss: BRDFs as harmonics ---- */

/* Returns what stands in the array of points for point i, where a stride of 0 means one for all. */
static const float *sfield__value_of(const float *base, size_t stride, size_t i)
{
    return (const float *)(const void *)((const char *)(const void *)base + i * stride);
}

/* The BRDF of glTF 2.0, appendix B, is F D V + (1 - F) base (1 - metallic) / pi. Schlick's F is F0 (1 - s) +
   s, where s = (1 - v . h)^5. So three kernels that know no colours make it up:

     SFIELD__DIFFUSE   (1 - s) / pi     times (1 - F0) base (1 - metallic)
     SFIELD__FACING    D V (1 - s)      times F0
     SFIELD__GRAZING   D V s

   They depend on the roughness and on the angle between view and normal alone. Their coefficients are kept
   for a grid of both, in the frame in which the normal is z and the view lies in the plane of x and z.
   Kernels are even in y there, so that only the coefficients of order m >= 0 are not 0. Each kernel is kept
   twice: times the cosine, and without it for points whose self-visibility brings the cosine along. The
   second are continued below the horizon, where their partner is 0, by |cos|: the less they jump there, the
   less of the product is lost in the bands. */
enum {
    SFIELD__DIFFUSE, SFIELD__FACING, SFIELD__GRAZING, SFIELD__KERNELS,
    SFIELD__ROUGHNESSES = 24,       /* from 0 to 1 */
    SFIELD__ANGLES = 48,            /* sqrt(1 - cos) from 0 to 1 */
    SFIELD__DRAWS = 32              /* in each of two dimensions, for a node of the grid */
};

struct sfield__brdf {
    sfield_rotation quarter;        /* a quarter turn about x */
    uint32_t bands, half;           /* n; n (n + 1) / 2 coefficients of a kernel */
    float   *table;                 /* [roughness][angle][times the cosine, without][kernel] half */
};

/* Returns alpha of a roughness: its square, not below 0.002, so that lobes keep some width. */
static float sfield__alpha_of(float roughness)
{
    return roughness * roughness > 0.002f ? roughness * roughness : 0.002f;
}

/* Adds weighted values of the basis at sixteen directions to the coefficients of order m >= 0. */
static SFIELD__COLD void sfield__add_half(uint32_t bands, const float *basis, const float *weight, float *out)
{
    uint32_t l, m, i;
    for (l = 0; l < bands; l++)
        for (m = 0; m <= l; m++, out++) {
            const float *y = basis + (l * l + l + m) * 16;
            float sum = 0;
            for (i = 0; i < 16; i++) sum += weight[i] * y[i];
            *out += sum;
        }
}

/* Finds draw `at` of a node: its first number, 0..1, and of its angle about z, 0..pi, sine and cosine. */
static SFIELD__COLD void sfield__find_draw(uint32_t at, double *u, double turn[2])
{
    const double step = 1.0 / (double)SFIELD__DRAWS;
    *u = (at / SFIELD__DRAWS + 0.5) * step;
    sfield__sincos_d(sfield__pi * (at % SFIELD__DRAWS + 0.5) * step, &turn[0], &turn[1]);
}

/* Draws a direction l by the half vectors that a view sees, by spherical caps (Dupuy and Benyoub, HPG 2023),
   in the frame in which the normal is z and the view lies in the plane of x and z. go: what Smith's shadowing
   has of the view. Writes s = (1 - v . h)^5 and returns D V over the density of l. */
static float sfield__draw_direction(const float *view, float alpha, float go, double u, const double *turn,
                                    float *l, float *s)
{
    const float a2 = alpha * alpha, scale = 1 / sqrtf(a2 * view[0] * view[0] + view[2] * view[2]);
    const float z0 = view[2] * scale, z = (float)(1 - u) * (1 + z0) - z0;
    const float ring = sqrtf(z * z < 1 ? 1 - z * z : 0);
    const float x = alpha * (ring * (float)turn[1] + alpha * view[0] * scale);
    const float y = alpha * ring * (float)turn[0];
    const float unit = 1 / sqrtf(x * x + y * y + (z + z0) * (z + z0));
    const float vh = unit * (x * view[0] + (z + z0) * view[2]), off = 1 - (vh < 1 ? vh : 1);
    l[0] = 2 * vh * unit * x - view[0];
    l[1] = 2 * vh * unit * y;
    l[2] = 2 * vh * unit * (z + z0) - view[2];
    *s = off * off * (off * off) * off;
    return (view[2] + go) / (fabsf(l[2]) * go + view[2] * sqrtf(a2 + (1 - a2) * l[2] * l[2]));
}

/* Adds up the kernels of D V for one roughness and view. Directions are drawn on an even grid: what is added
   up is smooth then, however narrow the lobe is. Of directions mirrored in y one is enough. */
static SFIELD__COLD void sfield__add_specular(const sfield__brdf *b, float alpha, const float *view,
                                              float *node)
{
    const float a2 = alpha * alpha, go = sqrtf(a2 + (1 - a2) * view[2] * view[2]);
    const float share = 1.0f / (float)(SFIELD__DRAWS * SFIELD__DRAWS);
    const uint32_t half = b->half, other = SFIELD__KERNELS * half;
    float d[48], weight[4][16], basis[SFIELD_MAX_COEFS * 16];
    uint32_t i, at, k;
    for (at = 0; at < SFIELD__DRAWS * SFIELD__DRAWS; at++) {
        double u, turn[2];
        float l[3], s, all;
        sfield__find_draw(at, &u, turn);
        all = sfield__draw_direction(view, alpha, go, u, turn, l, &s) * share;
        i = at % 16;
        for (k = 0; k < 3; k++) d[16 * k + i] = l[k];
        weight[2][i] = all * (1 - s);
        weight[3][i] = all * s;
        weight[0][i] = l[2] > 0 ? l[2] * weight[2][i] : 0;
        weight[1][i] = l[2] > 0 ? l[2] * weight[3][i] : 0;
        if (i < 15) continue;
        sfield__evaluate_basis16(b->bands, d, basis);
        sfield__add_half(b->bands, basis, weight[0], node + SFIELD__FACING * half);
        sfield__add_half(b->bands, basis, weight[1], node + SFIELD__GRAZING * half);
        sfield__add_half(b->bands, basis, weight[2], node + other + SFIELD__FACING * half);
        sfield__add_half(b->bands, basis, weight[3], node + other + SFIELD__GRAZING * half);
    }
}

/* Adds up the kernel of the diffuse part, over the hemisphere by its cosine and over the sphere. */
static SFIELD__COLD void sfield__add_diffuse(const sfield__brdf *b, const float *view, float *node)
{
    const float share = 1.0f / (float)(SFIELD__DRAWS * SFIELD__DRAWS);
    float d[48], weight[16], basis[SFIELD_MAX_COEFS * 16];
    uint32_t whole, at, i;
    for (whole = 0; whole < 2; whole++)
        for (at = 0; at < SFIELD__DRAWS * SFIELD__DRAWS; at++) {
            double u, turn[2];
            float s, z, ring;
            sfield__find_draw(at, &u, turn);
            z = whole ? (float)(2 * u - 1) : (float)sqrt(u);
            ring = sqrtf(1 - z * z);
            i = at % 16;
            d[i] = ring * (float)turn[1];
            d[16 + i] = ring * (float)turn[0];
            d[32 + i] = z;
            s = 0.5f + 0.5f * (d[i] * view[0] + z * view[2]);
            s = 1 - sqrtf(s > 0 ? s < 1 ? s : 1 : 0);
            weight[i] = (1 - s * s * (s * s) * s) * (whole ? 4.0f : 1.0f) * share;
            if (i < 15) continue;
            sfield__evaluate_basis16(b->bands, d, basis);
            sfield__add_half(b->bands, basis, weight,
                             node + (whole * SFIELD__KERNELS + SFIELD__DIFFUSE) * b->half);
        }
}

/* Fills in the kernels of one view angle, for all roughnesses. */
static SFIELD__COLD void sfield__fill_angle(void *context, size_t angle)
{
    const sfield__brdf *b = (const sfield__brdf *)context;
    const size_t size = 2 * (size_t)SFIELD__KERNELS * b->half;
    const float x = (float)angle / (SFIELD__ANGLES - 1);
    float *node = b->table + angle * size, *first = node, view[3];
    uint32_t i, k;
    /* an eye on the horizon would see nothing of the surface */
    view[2] = x * x < 0.999f ? 1 - x * x : 1e-3f;
    view[1] = 0;
    view[0] = sqrtf(1 - view[2] * view[2]);
    sfield__add_diffuse(b, view, node);
    for (i = 0; i < SFIELD__ROUGHNESSES; i++, node += SFIELD__ANGLES * size) {
        for (k = 0; k < size && i; k++) node[k] = k % (size / 2) < b->half ? first[k] : 0;
        sfield__add_specular(b, sfield__alpha_of((float)i / (SFIELD__ROUGHNESSES - 1)), view, node);
    }
}

SFIELD_DEF SFIELD__COLD size_t sfield_sh_brdf(uint32_t bands, const sfield_system *system, float *table)
{
    const uint32_t half = bands * (bands + 1) / 2;
    const size_t floats = (size_t)SFIELD__ROUGHNESSES * SFIELD__ANGLES * 2 * SFIELD__KERNELS * half;
    sfield__brdf b;
    size_t i;
    if (bands < 1 || bands > SFIELD_MAX_BANDS) return 0;
    if (!table) return floats;
    memset(&b, 0, sizeof b);
    b.bands = bands;
    b.half = half;
    b.table = table;
    memset(table, 0, floats * sizeof *table);
    if (system && system->parallel_for)
        system->parallel_for(system->user, SFIELD__ANGLES, sfield__fill_angle, &b);
    else
        for (i = 0; i < SFIELD__ANGLES; i++) sfield__fill_angle(&b, i);
    return floats;
}

/* Makes the table of a scene when the first set with materials comes. */
static SFIELD__COLD sfield_result sfield__make_brdf(sfield_scene *s)
{
    static const float turn[16] = { 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1 };
    const size_t floats = sfield_sh_brdf(s->desc.bands, NULL, NULL);
    sfield__brdf *b = (sfield__brdf *)sfield__alloc(&s->allocator, sizeof *b + floats * sizeof(float));
    if (!b) return SFIELD_ERR_ALLOC;
    b->bands = s->desc.bands;
    b->half = b->bands * (b->bands + 1) / 2;
    b->table = (float *)(void *)(b + 1);
    (void)sfield_sh_brdf(b->bands, &s->desc.system, b->table);
    (void)sfield_sh_rotation(s->algebra, turn, &b->quarter);
    s->brdf = b;
    return SFIELD_OK;
}

/* Turns sixteen functions about z, each by an angle of its own. */
static void sfield__turn_lanes(uint32_t bands, const float *cosine, const float *sine, float *planes)
{
    float c[16], s[16];
    uint32_t l, m, i;
    for (i = 0; i < 16; i++) {
        c[i] = 1;
        s[i] = 0;
    }
    for (m = 1; m < bands; m++) {
        for (i = 0; i < 16; i++) {
            const float next = c[i] * cosine[i] - s[i] * sine[i];
            s[i] = s[i] * cosine[i] + c[i] * sine[i];
            c[i] = next;
        }
        for (l = m; l < bands; l++) {
            float *plus = planes + (l * l + l + m) * 16, *minus = planes + (l * l + l - m) * 16;
            for (i = 0; i < 16; i++) {
                const float p = plus[i], q = minus[i];
                plus[i] = c[i] * p - s[i] * q;
                minus[i] = s[i] * p + c[i] * q;
            }
        }
    }
}

typedef struct sfield__frames { float c[3][16], s[3][16]; } sfield__frames;

/* Finds the three angles, as cosines and sines, that turn z to the normal and the plane of x and z to the
   view: about z, about y, and about z again. Writes the cosines between normal and view. */
static void sfield__find_frames(const sfield__tile *t, sfield__frames *f, float *facing)
{
    uint32_t i;
    for (i = 0; i < 16; i++) {
        const float x = t->n[i], y = t->n[16 + i], z = t->n[32 + i], ring = sqrtf(x * x + y * y);
        const float *v = t->view + i;
        const float ca = ring > 1e-6f ? x / ring : 1, sa = ring > 1e-6f ? y / ring : 0;
        const float p = z * ca * v[0] + z * sa * v[16] - ring * v[32], q = ca * v[16] - sa * v[0];
        const float length = sqrtf(p * p + q * q), unit = 1 / sqrtf(ring * ring + z * z);
        f->c[0][i] = length > 1e-6f ? p / length : 1;
        f->s[0][i] = length > 1e-6f ? q / length : 0;
        f->c[1][i] = z * unit;
        f->s[1][i] = ring * unit;
        f->c[2][i] = ca;
        f->s[2][i] = sa;
        facing[i] = x * v[0] + y * v[16] + z * v[32];
    }
}

/* Interpolates the kernels of a lane between four nodes of the table, into planes of order m >= 0. */
static SFIELD__COLD void sfield__mix_kernels(const sfield__brdf *b, float roughness, float facing,
                                             uint32_t whole,
                                float *planes, size_t kernel)
{
    const size_t size = 2 * (size_t)SFIELD__KERNELS * b->half;
    const float x = sqrtf(facing < 1 ? facing > 0 ? 1 - facing : 1 : 0) * (SFIELD__ANGLES - 1);
    const float y = roughness * (SFIELD__ROUGHNESSES - 1);
    const uint32_t i = x < SFIELD__ANGLES - 2 ? (uint32_t)x : (uint32_t)SFIELD__ANGLES - 2;
    const uint32_t j = y < SFIELD__ROUGHNESSES - 2 ? (uint32_t)y : (uint32_t)SFIELD__ROUGHNESSES - 2;
    const float u = x - (float)i, v = y - (float)j;
    const float *p = b->table + ((size_t)j * SFIELD__ANGLES + i) * size + whole * size / 2;
    const float *q = p + SFIELD__ANGLES * size;
    uint32_t k, l, m;
    for (k = 0; k < SFIELD__KERNELS; k++)
        for (l = 0; l < b->bands; l++)
            for (m = 0; m <= l; m++, p++, q++)
                planes[k * kernel + (l * l + l + m) * 16] =
                    (1 - v) * ((1 - u) * p[0] + u * p[size]) + v * ((1 - u) * q[0] + u * q[size]);
}

/* Computes T of the metal-rough BRDF before any other entity: kernels for the lanes' roughness and view,
   turned into the world, and times the self-visibility where there is one. */
static void sfield__start_materials(sfield__tile *t)
{
    const sfield_scene *s = t->s;
    const sfield_points *set = t->set;
    const sfield__brdf *b = s->brdf;
    const uint32_t n = s->coefs * SFIELD__LANES;
    float facing[16], *out = set->self ? t->t : t->start;
    sfield__frames f;
    uint32_t i, k;
    sfield__find_frames(t, &f, facing);
    memset(out, 0, SFIELD__KERNELS * n * sizeof *out);
    for (i = 0; i < SFIELD__LANES; i++) {
        const float *m = sfield__value_of(set->materials, set->material_stride,
                                          t->first + (i < t->lanes ? i : 0));
        sfield__mix_kernels(b, m[4], facing[i], set->self != NULL, out + i, n);
    }
    for (k = 0; k < SFIELD__KERNELS; k++, out += n) {
        sfield__turn_lanes(b->bands, f.c[0], f.s[0], out);
        sfield__rotate16(&b->quarter, out, out, SFIELD__LANES, 0, s->simd);
        sfield__turn_lanes(b->bands, f.c[1], f.s[1], out);
        sfield__rotate16(&b->quarter, out, out, SFIELD__LANES, 1, s->simd);
        sfield__turn_lanes(b->bands, f.c[2], f.s[2], out);
    }
    if (!set->self) return;
    for (k = SFIELD__KERNELS; k-- > 0;)         /* the self-visibility is the first T, so it goes last */
        sfield__product16(s->algebra, t->start, t->t + k * n, t->start + k * n, SFIELD__LANES, 0);
}

/* Returns the exponent of a point's lobe, in its range. */
static float sfield__exponent_of(const sfield_points *set, size_t index)
{
    const float n = *sfield__value_of(set->exponents, set->exponent_stride, index);
    return n > 1 ? (n < 1000 ? n : 1000) : 1;
}

/* Computes the lobe cos^n about the mirrored view, times (n + 2) / 2 pi. Its moments over x = cos are
   1/(n+1), 1/(n+2) and then I_l = I_(l-2) (n - l + 2) / (n + l + 1). */
static void sfield__fill_lobe(const sfield__tile *t, float *out)
{
    const sfield_points *set = t->set;
    uint32_t bands = t->s->desc.bands, i, l, k;
    float d[48], before[16], now[16], n[16];
    for (i = 0; i < 16; i++) {
        size_t at = t->first + (i < t->lanes ? i : 0);
        float dot = 0;
        for (k = 0; k < 3; k++) dot += t->n[16 * k + i] * t->view[16 * k + i];
        for (k = 0; k < 3; k++) d[16 * k + i] = 2 * dot * t->n[16 * k + i] - t->view[16 * k + i];
        n[i] = sfield__exponent_of(set, at);
        before[i] = (n[i] + 2) / (n[i] + 1);
        now[i] = 1;
    }
    sfield__evaluate_basis16(bands, d, out);
    for (l = 0; l < bands; l++) {
        for (k = l * l; k < (l + 1) * (l + 1); k++)
            for (i = 0; i < 16; i++) out[k * 16 + i] *= l == 0 ? before[i] : now[i];
        for (i = 0; i < 16 && l >= 1; i++) {
            float next = before[i] * (n[i] - (float)l + 1) / (n[i] + (float)l + 2);
            before[i] = now[i];
            now[i] = next;
        }
    }
}

/* Adds to a hash what T of some points depends on by their BRDFs: where their eyes are, their exponents or
   materials. */
static SFIELD__COLD uint64_t sfield__hash_brdfs(uint64_t h, const sfield_points *set, size_t first,
                                                uint32_t count)
{
    const size_t words = set->materials ? 5 : 1, stride = set->materials ? set->material_stride
                                                                         : set->exponent_stride;
    const float *of = set->materials ? set->materials : set->exponents;
    uint32_t l;
    h = sfield__hash(h, words);
    for (l = 0; l < count; l++) {
        h = sfield__hash_bytes(h, sfield__row(set->to_eye, set->to_eye_stride, first + l), 3);
        if (l == 0 || stride) h = sfield__hash_bytes(h, sfield__value_of(of, stride, first + l), words);
    }
    return h;
}

/* Computes T with a BRDF: of the lobe beside that of rgb, or of all kernels. */
static void sfield__start_gloss(sfield__tile *t)
{
    float *lobe = t->start + t->s->coefs * SFIELD__LANES;
    if (t->set->materials) {
        sfield__start_materials(t);
        return;
    }
    sfield__fill_lobe(t, lobe);
    sfield__product16(t->s->algebra, t->start, lobe, lobe, SFIELD__LANES, 0);
}

/* Returns F0 of a material, in one channel. */
static float sfield__facing_of(const float *material, uint32_t channel)
{
    return 0.04f + material[3] * (material[channel] - 0.04f);
}

/* Gives sums of the kernels' T with all lights their colours: rgb gets what is diffuse, gloss the rest. */
static SFIELD__COLD void sfield__color_tile(const sfield__tile *t, float *rgb, float *facing,
                                            const float *grazing)
{
    uint32_t l, c;
    for (l = 0; l < t->lanes; l++) {
        const float *m = sfield__value_of(t->set->materials, t->set->material_stride, t->first + l);
        for (c = 0; c < 3; c++) {
            const float f0 = sfield__facing_of(m, c);
            rgb[c * SFIELD__LANES + l] *= 1 - f0;
            facing[c * SFIELD__LANES + l] *= f0;
            facing[c * SFIELD__LANES + l] += grazing[c * SFIELD__LANES + l];
        }
    }
}

static void sfield__write_materials(const sfield__tile *t)
{
    float sum[SFIELD__KERNELS][3 * SFIELD__LANES];
    int k;
    for (k = 0; k < SFIELD__KERNELS; k++) sfield__sum_lights(t, k, sum[k]);
    sfield__color_tile(t, sum[SFIELD__DIFFUSE], sum[SFIELD__FACING], sum[SFIELD__GRAZING]);
    if (t->set->rgb) sfield__store_rgb(t, sum[SFIELD__DIFFUSE], 1, t->set->rgb);
    if (t->set->grazing) sfield__store_rgb(t, sum[SFIELD__GRAZING], 1, t->set->grazing);
    sfield__store_rgb(t, sum[SFIELD__FACING], 1, t->set->gloss);
}

/* Checks what a set with gloss needs, before its directions are read. */
static SFIELD__COLD sfield_result sfield__check_gloss(const sfield__logger *log, const sfield_points *p)
{
    size_t i;
    uint32_t k;
    if (p->exponents && p->materials)
        return sfield__fail(log, SFIELD_ERR_ARGUMENT, "points->exponents", "is there beside materials");
    if (!p->to_eye)
        return sfield__fail(log, SFIELD_ERR_ARGUMENT, "points->to_eye",
                            p->materials ? "is NULL, but gloss and materials are there"
                                         : "is NULL, but gloss and exponents are there");
    if (!p->materials) return SFIELD_OK;
    if (p->ambient)
        return sfield__fail(log, SFIELD_ERR_ARGUMENT, "points->ambient",
                            "is there beside gloss and materials, which have none");
    if (!sfield__check_value(log, !p->material_stride || sfield__stride_valid(p->material_stride, 20),
                             "points->material_stride", (double)p->material_stride,
                             "0, or a multiple of 4 of at least 20"))
        return SFIELD_ERR_ARGUMENT;
    for (i = 0; i < (p->material_stride ? p->count : 1); i++)
        for (k = 0; k < 5; k++) {
            const float x = sfield__value_of(p->materials, p->material_stride, i)[k];
            if (sfield__in(x, 0, 1)) continue;
            sfield__log_element(log, "points->materials", i,
                                k < 3    ? "has the base colour"
                                : k == 3 ? "has the metallic"
                                         : "has the roughness",
                                (double)x, "0..1");
            return SFIELD_ERR_INPUT;
        }
    return SFIELD_OK;
}
