/* ---- building: shells and points where a measured error asks for them ---- */

enum { SFIELD__GRID = 129, SFIELD__AROUND = 26, SFIELD__ACROSS = 24 };

/* What is seen from places all round at many radii, as values whose squares add up to the integral over all
   directions. Shells are chosen among these radii. */
typedef struct sfield__profile {
    float    radius[SFIELD__GRID], measure[SFIELD__GRID];
    float    whole[SFIELD__GRID];   /* what errors at a radius are divided by */
    uint32_t shell[64], count;      /* chosen: their places in the grid */
} sfield__profile;

/* Returns how many values a view has: coefficients, or of wavelets squares of a face, 8 a side at most. */
static size_t sfield__count_values(const sfield__build *b)
{
    const uint32_t side = b->h.cube_side < 8 ? b->h.cube_side : 8;
    return b->h.basis == SFIELD_BASIS_HAAR ? (size_t)b->h.channels * 6 * side * side : b->h.stride;
}

/* Makes the values of what the view's texels hold. Squares are runs of texels, which are in Morton order. */
static void sfield__value_view(const sfield__build *b, sfield__view *v, float *out)
{
    const size_t squares = b->seen_size / b->h.channels, run = b->cells / squares;
    size_t c, i, k;
    if (b->h.basis != SFIELD_BASIS_HAAR) {
        sfield__encode_sh(b, v, NULL, out);
        return;
    }
    for (c = 0; c < b->h.channels; c++)
        for (i = 0; i < squares; i++) {
            float sum = 0, angle = 0;
            for (k = i * run; k < (i + 1) * run; k++) {
                sum += v->texel[c * b->cells + k] * b->texels.angle[k];
                angle += b->texels.angle[k];
            }
            out[c * squares + i] = sum / sqrtf(angle);
        }
}

/* Looks from each of b->eyes, as a build does. */
static void sfield__measure_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    for (i = piece; i < b->to; i += b->pieces) {
        float eye[3];
        memcpy(eye, b->eyes + 3 * i, sizeof eye);
        sfield__view_from(b, v, eye);
        if (b->what == SFIELD__MESH && !b->desc.keep_inside &&
            sfield__move_out(b, sfield__share_hidden(b, v->texel), eye))
            sfield__view_from(b, v, eye);
        sfield__value_view(b, v, b->seen + i * b->seen_size);
    }
}

/* Returns the integral, over all directions, of the square of a (1 - t) + c t - what is seen. */
static double sfield__square_error(const sfield__build *b, const float *a, const float *c, float t,
                                   const float *seen)
{
    double sum = 0;
    size_t k;
    for (k = 0; k < b->seen_size; k++) {
        const float off = a[k] + t * (c[k] - a[k]) - seen[k];
        sum += (double)off * (double)off;
    }
    return sum;
}

/* Looks from all places of the profile. Errors of visibility are divided by 4 pi, those of sources by the
   light at their radius. */
static void sfield__measure_profile(sfield__build *b, sfield__profile *q)
{
    const float inner = b->radii[0], outer = b->radii[b->h.shells - 1];
    uint32_t i, j, k;
    for (i = 0; i < SFIELD__GRID; i++) {
        q->radius[i] = i + 1 < SFIELD__GRID
                           ? inner * sfield__pow(outer / inner, (float)i / (float)(SFIELD__GRID - 1))
                           : outer;
        q->measure[i] = sfield__measure_of(q->radius[i] * q->radius[i], b->h.kind, b->h.spacing);
        for (j = 0, k = 0; j < SFIELD__AROUND; j++, k++) {
            sfield__v3 d;
            k += k == 13;                       /* corners, edges and sides of a cube, turned a little */
            d = sfield__v3_make((float)(k % 3) - 1, (float)(k / 3 % 3) - 1, (float)(k / 9) - 1);
            d = sfield__v3_add(sfield__v3_normalize(d), sfield__v3_make(0.0131f, -0.0079f, 0.0107f));
            d = sfield__v3_scale(sfield__v3_normalize(d), q->radius[i]);
            sfield__v3_store(b->eyes + 3 * (i * SFIELD__AROUND + j), d);
        }
    }
    b->to = (size_t)SFIELD__GRID * SFIELD__AROUND;
    sfield__run_tasks(b, sfield__measure_task);
    for (i = 0; i < SFIELD__GRID; i++) {
        double sum = 4 * 3.14159265358979 * (double)SFIELD__AROUND;
        if (b->h.kind == SFIELD__KIND_SOURCE) {
            const float *seen = b->seen + (size_t)i * SFIELD__AROUND * b->seen_size;
            for (sum = 0, k = 0; k < SFIELD__AROUND * b->seen_size; k++)
                sum += (double)seen[k] * (double)seen[k];
        }
        q->whole[i] = (float)sqrt(sum);
    }
}

/* Returns the greatest error at the radii between two, interpolated as queries do. */
static float sfield__error_between(const sfield__build *b, const sfield__profile *q, uint32_t from,
                                   uint32_t to)
{
    const size_t row = SFIELD__AROUND * b->seen_size;
    float worst = 0;
    uint32_t i, j;
    for (i = from + 1; i < to; i++) {
        const float t = (q->measure[i] - q->measure[from]) / (q->measure[to] - q->measure[from]);
        double sum = 0;
        float error;
        for (j = 0; j < SFIELD__AROUND; j++) {
            const float *seen = b->seen + j * b->seen_size;
            sum += sfield__square_error(b, seen + from * row, seen + to * row, t, seen + i * row);
        }
        error = q->whole[i] > 0 ? (float)sqrt(sum) / q->whole[i] : 0;
        worst = error > worst ? error : worst;
    }
    return worst;
}

/* Goes outwards by the longest steps whose error is within a bound. Returns how many shells that takes, or
   one more than `most`. */
static uint32_t sfield__step_outwards(const sfield__build *b, sfield__profile *q, float bound,
                                      uint32_t most)
{
    uint32_t at = 0;
    for (q->count = 0; q->count < most;) {
        uint32_t next = at + 1;
        q->shell[q->count++] = at;
        if (at == SFIELD__GRID - 1) return q->count;
        while (next + 1 < SFIELD__GRID && sfield__error_between(b, q, at, next + 1) <= bound) next++;
        at = next;
    }
    return most + 1;
}

/* Returns the greatest error between neighbours among the chosen shells, and the first of the two; of equal
   ones those that are widest apart, so that there is always a radius between them. */
static float sfield__find_worst(const sfield__build *b, const sfield__profile *q, uint32_t *where)
{
    float worst = -1;
    uint32_t i;
    *where = 0;
    for (i = 0; i + 1 < q->count; i++) {
        const float error = sfield__error_between(b, q, q->shell[i], q->shell[i + 1]);
        const int wider = q->shell[i + 1] - q->shell[i] > q->shell[*where + 1] - q->shell[*where];
        if (!(error > worst) && !(error >= worst && wider)) continue;
        worst = error;
        *where = i;
    }
    return worst;
}

/* Chooses radii: as few as the bound allows, or those by which `most` shells err least. Returns the error, or
   a negative number if the bound cannot be kept. */
static float sfield__choose_radii(const sfield__build *b, sfield__profile *q, float bound, uint32_t most)
{
    float low = 1e-7f, high = 4, worst;
    uint32_t i, where;
    if (bound > 0) {
        if (sfield__step_outwards(b, q, bound, most) > most) return -1;
        return sfield__find_worst(b, q, &where);
    }
    /* few uniform shells of a source may err by many times its light */
    for (; sfield__step_outwards(b, q, high, most) > most && high < 1e30f; low = high, high *= 1024) { }
    for (i = 0; i < 22; i++) {
        const float middle = sqrtf(low * high);
        if (sfield__step_outwards(b, q, middle, most) > most) low = middle;
        else high = middle;
    }
    (void)sfield__step_outwards(b, q, high, most);
    worst = sfield__find_worst(b, q, &where);
    while (q->count < most) {                   /* those that are left halve what errs most */
        uint32_t *next = q->shell + where + 1;
        memmove(next + 1, next, (q->count++ - where - 1) * sizeof *next);
        *next = (next[-1] + next[1]) / 2;
        worst = sfield__find_worst(b, q, &where);
    }
    return worst;
}

/* Writes the four corners of a square of sample points, and its middle, on a sphere. */
static void sfield__aim_square(uint32_t side, uint32_t square, float radius, float *eyes)
{
    const float step = 1.57079633f / (float)(side - 1);
    const uint32_t x = (square & 1 ? 2 : 1) * (side - 2) / 3, y = (square & 2 ? 2 : 1) * (side - 2) / 3;
    uint32_t k, l;
    for (k = 0; k < 5; k++, eyes += 3) {
        const float a = (float)x + (k < 4 ? (float)(k & 1) : 0.5f);
        const float c = (float)y + (k < 4 ? (float)(k >> 1) : 0.5f);
        double d[3], length;
        float sine[2], cosine[2];
        sfield__sincos(step * a - 0.785398163f, &sine[0], &cosine[0]);
        sfield__sincos(step * c - 0.785398163f, &sine[1], &cosine[1]);
        sfield__from_face(square / 4, (double)(sine[0] / cosine[0]), (double)(sine[1] / cosine[1]), d);
        length = (double)radius / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (l = 0; l < 3; l++) eyes[l] = (float)(d[l] * length);
    }
}

/* Returns the error in the middles of squares of sample points, on the worst of the chosen shells, of fields
   with `side` points a side of a face. */
static float sfield__error_across(sfield__build *b, const sfield__profile *q, uint32_t side)
{
    float worst = 0;
    uint32_t i, j;
    b->h.position_side = side;
    for (i = 0; i < q->count; i++) {
        double sum = 0, whole = 0;
        for (j = 0; j < SFIELD__ACROSS; j++)
            sfield__aim_square(side, j, q->radius[q->shell[i]], b->eyes + 15 * j);
        b->to = 5 * SFIELD__ACROSS;
        sfield__run_tasks(b, sfield__measure_task);
        for (j = 0; j < SFIELD__ACROSS; j++) {
            float *seen = b->seen + 5 * j * b->seen_size, *middle = seen + 4 * b->seen_size;
            size_t v, n = b->seen_size;
            for (v = 0; v < n; v++) {
                seen[v] = 0.25f * (seen[v] + seen[v + n] + seen[v + 2 * n] + seen[v + 3 * n]);
                whole += (double)middle[v] * (double)middle[v];
            }
            sum += sfield__square_error(b, seen, seen, 0, middle);
        }
        if (b->h.kind != SFIELD__KIND_SOURCE) whole = 4 * 3.14159265358979 * (double)SFIELD__ACROSS;
        if (whole > 0 && sqrt(sum / whole) > (double)worst) worst = (float)sqrt(sum / whole);
    }
    return worst;
}

/* Chooses shells, then points. Half of the bound is for what lies between shells, half for what lies between
   the points of a shell. */
static sfield_result sfield__choose_places(sfield__build *b, float bound, sfield_placement *out)
{
    static const uint8_t sides[9] = { 4, 6, 8, 12, 16, 24, 32, 48, 64 };
    const uint32_t most = bound > 0 && !b->desc.shell_count ? 64 : b->h.shells, side = b->h.position_side;
    sfield__profile q;
    uint32_t i;
    memset(out, 0, sizeof *out);
    sfield__measure_profile(b, &q);
    if (!sfield__tell_progress(b, 0.5f)) return SFIELD_ERR_CANCELLED;
    out->between = sfield__choose_radii(b, &q, 0.5f * bound, most);
    if (!sfield__check_value(&b->log, out->between >= 0, "bound", (double)bound,
                             "more, or desc.shell_count more"))
        return SFIELD_ERR_LIMIT;
    out->shell_count = q.count;
    for (i = 0; i < q.count; i++) out->radii[i] = q.radius[q.shell[i]];
    for (i = 0; i < 9; i++) {
        out->position_side = bound > 0 && !b->desc.position_side ? sides[i] : side;
        out->across = sfield__error_across(b, &q, out->position_side);
        if (!sfield__tell_progress(b, 0.5f + 0.05f * (float)(i + 1))) return SFIELD_ERR_CANCELLED;
        if (!(bound > 0) || out->across <= 0.5f * bound) return SFIELD_OK;
        if (out->position_side != sides[i]) break;
    }
    (void)sfield__check_value(&b->log, 0, "bound", (double)bound, "more, or desc.position_side more");
    return SFIELD_ERR_LIMIT;
}

SFIELD_DEF sfield_result sfield_place(const sfield_desc *desc, const sfield_mesh *mesh,
                                      const sfield_emitter *emitter, float bound, sfield_placement *out)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_place");
    const size_t places = (size_t)SFIELD__GRID * SFIELD__AROUND;
    sfield_placement placement;
    sfield__build b;
    sfield_result result;
    if (!out) return sfield__fail_null(&log, "out");
    if (!mesh == !emitter)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "mesh", "and emitter: one of both is to be given");
    if (!sfield__check_value(&log, sfield__in(bound, 0, 1), "bound", (double)bound, "0..1"))
        return SFIELD_ERR_ARGUMENT;
    result = sfield__read_desc(&b, desc, mesh ? SFIELD__KIND_OCCLUSION : SFIELD__KIND_SOURCE, log.function);
    if (result != SFIELD_OK) return result;
    b.what = mesh ? SFIELD__MESH : SFIELD__ANALYTIC;
    if (emitter) b.emitter = *emitter;
    result = mesh ? sfield__take_mesh(&b, mesh) : sfield__take_emitter(&b);
    if (result == SFIELD_OK) result = sfield__prepare_build(&b);
    if (result == SFIELD_OK) {
        b.seen_size = sfield__count_values(&b);
        b.eyes = (float *)sfield__hold_memory(&b, 3 * places, sizeof *b.eyes);
        b.seen = (float *)sfield__hold_memory(&b, places, b.seen_size * sizeof *b.seen);
        result = !b.eyes || !b.seen ? SFIELD_ERR_ALLOC
                 : sfield__tell_progress(&b, 0) ? sfield__choose_places(&b, bound, &placement)
                                                : SFIELD_ERR_CANCELLED;
    }
    if (result == SFIELD_OK) *out = placement;
    return sfield__end_build(&b, result);
}
