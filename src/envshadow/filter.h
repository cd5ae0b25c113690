/* ---- filter: visibility of one light at one point ---- */

typedef struct envsh__lookup {
    const envsh_view *view;
    const float *tile;              /* the corner texel of the light's tile */
    const float *cells;             /* least and greatest depth of its cells; NULL: every texel is read */
    size_t   row, step;             /* floats from one row to the next, and from one texel to the next */
    int32_t  size, cells_wide;      /* texels and cells a side */
    const envsh_query *query;       /* with its defaults filled in */
    uint32_t first;                 /* the number of the point with index 0 */
    const float *disc;              /* x and y of taps on the unit disc */
} envsh__lookup;

typedef struct envsh__receiver {
    float x, y, z;                  /* texels, and depth */
    float gx, gy;                   /* the slopes of its plane: depth over texels */
    float texel_depth;              /* the size of a texel as a depth */
    float limit;                    /* how much nearer to the light than the receiver a tap may be taken to
                                       lie */
} envsh__receiver;

/* Sets how far the receiver's plane is followed towards the light. The plane goes on through walls that stand
   on the receiver's surface, so that it is not followed farther than three texels and the radius of a fixed
   kernel. The penumbra's kernel needs less: what is taken for an occluder although it is the surface itself
   is near, and a near occluder makes the kernel small. */
static void envsh__set_limit(envsh__receiver *r, float radius)
{
    r->limit = (radius + 3.0f) * r->texel_depth;
}

/* Returns whether the receiver's plane is lit at the texel's centre. Beyond the tile nothing is in the way.
   */
static int envsh__is_lit(const envsh__lookup *l, const envsh__receiver *r, int32_t x, int32_t y)
{
    float stored, z;
    if (x < 0 || y < 0 || x >= l->size || y >= l->size) return 1;
    stored = l->tile[(size_t)y * l->row + (size_t)x * l->step];
    z = r->gx * ((float)x + 0.5f - r->x) + r->gy * ((float)y + 0.5f - r->y);
    z = r->z + (z < -r->limit ? -r->limit : z);
    return stored >= ENVSH__NOTHING || z <= stored;
}

/* Returns the texel that a coordinate lies in, at least -64 and at most 8192, which are beyond every tile. */
static int32_t envsh__texel_index(float x)
{
    return x < -64.0f ? -64 : x > 8192.0f ? 8192 : (int32_t)floorf(x);
}

/* Returns 1 if the cells say that all of a kernel of half widths rx, ry is lit, 0 if they say that all of it
   is in shadow, and -1 if they do not tell. */
static int envsh__decide_by_cells(const envsh__lookup *l, const envsh__receiver *r, float rx, float ry)
{
    float lo = ENVSH__NOTHING, hi = 0.0f, slope = fabsf(r->gx) * (rx + 1.0f) + fabsf(r->gy) * (ry + 1.0f);
    int32_t x0, x1, y0, y1;
    int32_t x, y;
    int32_t last = l->cells_wide - 1;
    int32_t edge = l->size - 1;
    int32_t outside;
    if (!l->cells) return -1;
    x0 = envsh__texel_index(r->x - rx);
    x1 = envsh__texel_index(r->x + rx);
    y0 = envsh__texel_index(r->y - ry);
    y1 = envsh__texel_index(r->y + ry);
    outside = x0 < 0 || y0 < 0 || x1 > edge || y1 > edge;
    if (x1 < 0 || y1 < 0 || x0 > edge || y0 > edge) return 1;
    x0 = x0 < 0 ? 0 : x0 / (int32_t)ENVSH__CELL;
    y0 = y0 < 0 ? 0 : y0 / (int32_t)ENVSH__CELL;
    x1 = x1 / (int32_t)ENVSH__CELL;
    y1 = y1 / (int32_t)ENVSH__CELL;
    x1 = x1 > last ? last : x1;
    y1 = y1 > last ? last : y1;
    for (y = y0; y <= y1; y++)
        for (x = x0; x <= x1; x++) {
            const float *cell = l->cells + 2 * ((size_t)y * (size_t)l->cells_wide + (size_t)x);
            lo = cell[0] < lo ? cell[0] : lo;
            hi = cell[1] > hi ? cell[1] : hi;
        }
    if (lo >= ENVSH__NOTHING || r->z + slope <= lo) return 1;
    slope = slope < r->limit ? slope : r->limit;
    return !outside && hi < ENVSH__NOTHING && r->z - slope > hi ? 0 : -1;
}

/* Returns the lit share of all texels whose centres are within radius + 1 along both axes, by weights that
   fall linearly to 0 there. */
static float envsh__filter_smooth(const envsh__lookup *l, const envsh__receiver *r)
{
    float radius = l->query->radius;
    float sum = 0.0f;
    float weights = 0.0f;
    float wx, wy;
    int32_t reach = (int32_t)radius + 1;
    int32_t cx = envsh__texel_index(r->x);
    int32_t cy = envsh__texel_index(r->y);
    int32_t x, y;
    for (y = cy - reach; y <= cy + reach; y++) {
        wy = radius + 1.0f - fabsf((float)y + 0.5f - r->y);
        if (!(wy > 0.0f)) continue;
        for (x = cx - reach; x <= cx + reach; x++) {
            wx = radius + 1.0f - fabsf((float)x + 0.5f - r->x);
            if (!(wx > 0.0f)) continue;
            weights += wx * wy;
            if (envsh__is_lit(l, r, x, y)) sum += wx * wy;
        }
    }
    return weights > 0.0f ? sum / weights : 1.0f;
}

/* Returns the share of taps that are lit on an ellipse of the half axes a and b, in texels. c and s are
   cosine and sine of the angle by which the taps are turned. */
static float envsh__filter_taps(const envsh__lookup *l, const envsh__receiver *r, const float *a,
                                const float *b, float c, float s)
{
    uint32_t i, n = l->query->tap_count, lit = 0;
    for (i = 0; i < n; i++) {
        float u = l->disc[2 * i] * c - l->disc[2 * i + 1] * s;
        float v = l->disc[2 * i] * s + l->disc[2 * i + 1] * c;
        lit += (uint32_t)envsh__is_lit(l, r, envsh__texel_index(r->x + u * a[0] + v * b[0]),
                                       envsh__texel_index(r->y + u * a[1] + v * b[1]));
    }
    return (float)lit / (float)n;
}

/* Shortens half axes that are longer than `most` texels, and lengthens those below 0.7 texels, with which all
   taps could fall into one texel. */
static void envsh__limit_axes(float *a, float *b, float most)
{
    float la = sqrtf(a[0] * a[0] + a[1] * a[1]), lb = sqrtf(b[0] * b[0] + b[1] * b[1]), least = 0.7f, f;
    f = la > most ? most / la : 1.0f;
    a[0] *= f;
    a[1] *= f;
    la *= f;
    f = lb > most ? most / lb : 1.0f;
    b[0] *= f;
    b[1] *= f;
    lb *= f;
    least = least < most ? least : most;
    if (la < least) {
        a[0] = least;
        a[1] = 0.0f;
        b[0] = 0.0f;
        b[1] = least;
    } else if (lb < least) {
        b[0] = -a[1] * (least / la);
        b[1] = a[0] * (least / la);
    }
}

/* Returns a component of a half axis, at most 1e15, so that its square is a float. envsh__limit_axes shortens
   such an axis in any case. */
static float envsh__hold_number(float x) { return x < -1e15f ? -1e15f : x > 1e15f ? 1e15f : x; }

/* Writes the half axes of a kernel in which a light spreads over a distance, given as a depth. */
static void envsh__make_kernel(const envsh__lookup *l, float distance, float *a, float *b)
{
    const float *spread = l->view->spread;
    int k;
    distance = distance > 0.0f ? distance * l->query->extent_scale : 0.0f;
    distance = distance < 1e9f ? distance : 1e9f;
    for (k = 0; k < 2; k++) {
        a[k] = envsh__hold_number(spread[k] * distance);
        b[k] = envsh__hold_number(spread[2 + k] * distance);
    }
    envsh__limit_axes(a, b, l->query->radius);
}

/* Returns the lit share by percentage-closer soft shadows for a directional light (Fernando 2005; the paper's
   future work): finds the mean depth of what is in the way, then filters by a kernel as wide as the light's
   extent spreads over the distance to that depth. */
static float envsh__filter_penumbra(const envsh__lookup *l, const envsh__receiver *r, float c, float s)
{
    const envsh_query *q = l->query;
    float a[2], b[2], occluders = 0.0f;
    uint32_t i, found = 0;
    int32_t x, y;
    int known;
    envsh__make_kernel(l, r->z, a, b);
    known = envsh__decide_by_cells(l, r, fabsf(a[0]) + fabsf(b[0]), fabsf(a[1]) + fabsf(b[1]));
    if (known >= 0) return (float)known;
    for (i = 0; i < q->tap_count; i++) {
        float u = l->disc[2 * i] * c - l->disc[2 * i + 1] * s;
        float v = l->disc[2 * i] * s + l->disc[2 * i + 1] * c;
        x = envsh__texel_index(r->x + u * a[0] + v * b[0]);
        y = envsh__texel_index(r->y + u * a[1] + v * b[1]);
        if (envsh__is_lit(l, r, x, y)) continue;
        occluders += l->tile[(size_t)y * l->row + (size_t)x * l->step];
        found++;
    }
    if (!found) return 1.0f;
    envsh__make_kernel(l, r->z - occluders / (float)found, a, b);
    return envsh__filter_taps(l, r, a, b, c, s);
}

/* Moves the point along its normal by the bias, and finds its place and its plane in the tile. cosine is that
   of normal and light, above 0. */
static void envsh__place_receiver(const envsh_view *v, const envsh_query *q, envsh__v3 p, envsh__v3 n,
                                  float cosine, envsh__receiver *r)
{
    const float *m = v->lookup;
    float nu = envsh__v3_dot(n, envsh__v3_load(v->right)), nv = envsh__v3_dot(n, envsh__v3_load(v->up));
    float texel = v->texel[0] > v->texel[1] ? v->texel[0] : v->texel[1], sine = sqrtf(nu * nu + nv * nv);
    float steep;
    p = envsh__v3_madd(p, n, q->bias * texel * (0.25f + 0.75f * sine));
    r->x = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    r->y = m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7];
    r->z = m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11];
    steep = 1.0f / ((cosine > 0.1f ? cosine : 0.1f) * v->depth_range);
    r->gx = nu * steep * v->texel[0];
    r->gy = nv * steep * v->texel[1];
    r->texel_depth = texel / v->depth_range;
    envsh__set_limit(r, q->filter == ENVSH_FILTER_PENUMBRA ? 1.0f : 0.0f);
}

/* Returns how much of the light reaches a point, 0..1, by the query's filter. n is the geometric normal,
   cosine that of n and the light, above 0. */
static float envsh__find_visibility(const envsh__lookup *l, envsh__v3 p, envsh__v3 n, float cosine,
                                    uint32_t index)
{
    const envsh_query *q = l->query;
    envsh__receiver r;
    float c, s, a[2], b[2];
    int known;
    envsh__place_receiver(l->view, q, p, n, cosine, &r);
    if (!envsh__finite(r.x) || !envsh__finite(r.y) || !envsh__finite(r.z)) return 1.0f;
    if (q->filter == ENVSH_FILTER_PLAIN)
        return (float)envsh__is_lit(l, &r, envsh__texel_index(r.x), envsh__texel_index(r.y));
    if (q->filter != ENVSH_FILTER_PENUMBRA) {
        float reach = q->filter == ENVSH_FILTER_SMOOTH ? q->radius + 1.0f : q->radius;
        envsh__set_limit(&r, reach);
        known = envsh__decide_by_cells(l, &r, reach, reach);
        if (known >= 0) return (float)known;
        if (q->filter == ENVSH_FILTER_SMOOTH) return envsh__filter_smooth(l, &r);
    }
    envsh__sincos(6.28318531f * envsh__to_unit(envsh__hash_combine(q->seed, l->first + index)), &s, &c);
    if (q->filter == ENVSH_FILTER_PENUMBRA) return envsh__filter_penumbra(l, &r, c, s);
    a[0] = b[1] = q->radius;
    a[1] = b[0] = 0.0f;
    return envsh__filter_taps(l, &r, a, b, c, s);
}

/* Fills in n points that lie evenly over the unit disc, on Vogel's spiral. */
static void envsh__fill_disc(float *disc, uint32_t n)
{
    uint32_t i;
    for (i = 0; i < n; i++) {
        float radius = sqrtf(((float)i + 0.5f) / (float)n), s, c;
        envsh__sincos(2.39996323f * (float)i, &s, &c);
        disc[2 * i] = radius * c;
        disc[2 * i + 1] = radius * s;
    }
}

/* Writes the least and the largest radius that a filter may have, in texels. */
static void envsh__radius_range(envsh_filter filter, float *least, float *most)
{
    *least = filter == ENVSH_FILTER_SMOOTH ? 0.5f : 0.0f;
    *most = filter == ENVSH_FILTER_SMOOTH ? 8.0f : filter == ENVSH_FILTER_PCF ? 32.0f : 64.0f;
}

/* Returns what the value of a setting means: 0 the default, a negative number 0. */
static float envsh__or_default(float value, float standard)
{
    return value < 0.0f ? 0.0f : value > 0.0f ? value : standard;
}

/* Copies the query, which may be NULL, fills in its defaults, and checks its fields. */
static envsh_result envsh__check_query(const envsh_query *query, envsh_query *q, const envsh__logger *log)
{
    static const char *const ranges[] = { "at most 64 texels", "0 (= 2) or 0.5..8 texels",
                                         "at most 32 texels" };
    const envsh_result bad = ENVSH_ERR_DESC;
    float least, most;
    memset(q, 0, sizeof *q);
    if (query) *q = *query;
    if ((unsigned)q->filter >= ENVSH_FILTER_COUNT)
        return envsh__refuse(log, "query.filter", q->filter, "one of envsh_filter", bad);
    if (q->filter == ENVSH_FILTER_DEFAULT) q->filter = ENVSH_FILTER_PENUMBRA;
    if (!(q->bias <= 1e6f))
        return envsh__refuse(log, "query.bias", (double)q->bias, "at most 1e6 texels", bad);
    q->bias = envsh__or_default(q->bias, 1.0f);
    if (!q->tap_count) q->tap_count = 16;
    if (q->filter == ENVSH_FILTER_PLAIN) return ENVSH_OK;
    envsh__radius_range(q->filter, &least, &most);
    if (!(q->radius <= most) || (q->radius < least && q->filter == ENVSH_FILTER_SMOOTH && q->radius != 0.0f))
        return envsh__refuse(log, "query.radius", (double)q->radius,
                             ranges[q->filter == ENVSH_FILTER_SMOOTH ? 1 : q->filter == ENVSH_FILTER_PCF ? 2
                                    : 0], bad);
    q->radius = envsh__or_default(q->radius, q->filter == ENVSH_FILTER_PENUMBRA ? 12.0f : 2.0f);
    if (q->filter == ENVSH_FILTER_SMOOTH) return ENVSH_OK;
    if (q->tap_count > ENVSH_MAX_TAPS)
        return envsh__refuse(log, "query.tap_count", q->tap_count, "0 (= 16) or 1..64", bad);
    if (!(q->extent_scale <= 1e6f))
        return envsh__refuse(log, "query.extent_scale", (double)q->extent_scale, "at most 1e6", bad);
    q->extent_scale = envsh__or_default(q->extent_scale, 1.0f);
    return ENVSH_OK;
}
