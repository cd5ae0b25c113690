/* ---- lights: from strata to lights ---- */

typedef struct envlt__sums {        /* sums over the texels of a stratum; d is a texel's direction */
    double rgb[3];                  /* radiance x solid angle */
    double omega;                   /* solid angle */
    double w;                       /* energy: luminance x solid angle */
    double m[3];                    /* w d */
    double s[6];                    /* w d d^T: xx xy xz yy yz zz */
    double o[3];                    /* omega d of dark texels, which say where a stratum without energy lies
                                       */
    double texels;                  /* how many there are */
} envlt__sums;

/* Counts the bytes that an allocator has given out, for envlt_stats.peak_bytes. The size of a block stands in
   front of the block. */
typedef struct envlt__meter { envlt__allocator inner; size_t now, peak; } envlt__meter;

struct envlt_lights {
    envlt__allocator allocator;     /* the caller's, called through the meter */
    envlt__meter     meter;
    envlt_desc   desc;
    envlt_map    map;               /* the projection and sizes of the map; rgb is NULL */
    uint32_t     roll;              /* the column of the map at which the grid begins */
    uint32_t     count;             /* lights */
    uint32_t     next_id;           /* the id of the next new light */
    int          has_sun;           /* not 0: light 0 is the sun */
    size_t       lit;               /* how many texels were lit, the sun counted as one, if they were too few
                                       for all lights; else 0 */
    double       slack;             /* how uneven the strata were when built, which envlt_follow tolerates
                                       twice; 0 = not measured yet */
    envlt_light *list;
    envlt__sums *sums;              /* of each light's stratum */
    size_t       texels;
    uint32_t    *strata;            /* the light of each texel of the map */
    uint32_t    *order;             /* the texels of stratum i are order[start[i] .. start[i + 1]) */
    uint32_t    *start;
    double      *cdf;               /* running sums of w; those of stratum i begin at start[i] + i */
};

/* Sums up all texels of the grid by label. While the label stays the same, sums are kept in a local copy,
   which is faster than memory that each texel reads and writes. */
static void envlt__accumulate_sums(const envlt__grid *g, const uint32_t *label, envlt__sums *sums,
                                   uint32_t count)
{
    size_t t;
    float rgb[3];
    envlt__sums s;
    uint32_t column = 0, held = ENVLT_NO_LIGHT;
    memset(sums, 0, count * sizeof *sums);
    memset(&s, 0, sizeof s);
    for (t = 0; t < g->count; t++, column = column + 1 < g->width ? column + 1 : 0) {
        double omega = (double)g->omega[t];
        double w = envlt__texel_weight(g, t);
        double x, y, z;
        if (!(omega > 0.0) || label[t] >= count) continue;
        if (label[t] != held) {
            if (held != ENVLT_NO_LIGHT) sums[held] = s;
            held = label[t];
            s = sums[held];
        }
        x = (double)g->dx[t];
        y = (double)g->dy[t];
        z = (double)g->dz[t];
        s.omega += omega;
        s.texels += 1.0;
        if (!(w > 0.0)) {
            s.o[0] += omega * x;
            s.o[1] += omega * y;
            s.o[2] += omega * z;
            continue;
        }
        envlt__fetch_texel(&g->map, envlt__map_texel(g, t - column, column), rgb);
        s.rgb[0] += omega * (double)rgb[0];
        s.rgb[1] += omega * (double)rgb[1];
        s.rgb[2] += omega * (double)rgb[2];
        s.w += w;
        s.m[0] += w * x;
        s.m[1] += w * y;
        s.m[2] += w * z;
        s.s[0] += w * x * x;
        s.s[1] += w * x * y;
        s.s[2] += w * x * z;
        s.s[3] += w * y * y;
        s.s[4] += w * y * z;
        s.s[5] += w * z * z;
    }
    if (held != ENVLT_NO_LIGHT) sums[held] = s;
}

/* Returns a direction of the grid, whose azimuths begin at the roll, as a direction of the map. */
static envlt__v3 envlt__unroll_direction(const envlt__grid *g, double x, double y, double z)
{
    double s, c;
    if (g->faces == 6) return envlt__v3_make((float)x, (float)y, (float)z);
    envlt__sincos64(2.0 * ENVLT__PI * ((double)g->roll / g->width - 0.5), &s, &c);
    return envlt__v3_make((float)(x * c - z * s), (float)y, (float)(x * s + z * c));
}

/* Finds the half axes of the ellipse over which the stratum's radiance spreads about its light's direction d:
   the eigenvectors of the 2 x 2 covariance in the tangent plane, as long as twice the standard deviation,
   which is the radius of a uniform disc. The size of a texel itself is added to the covariance. */
static void envlt__find_extent(const envlt__sums *s, envlt__v3 d, envlt__v3 *major, envlt__v3 *minor)
{
    envlt__v3 u, v;
    double a = 0.0, b = 0.0, c = 0.0, texel = s->texels > 0.0 ? s->omega / s->texels / 12.0 : 0.0;
    double half, root, along;
    double x = 1.0;
    double y = 0.0;
    double length;
    float p[3], q[3];
    int i, j;
    envlt__v3_basis(d, &u, &v);
    envlt__v3_store(p, u);
    envlt__v3_store(q, v);
    if (s->w > 0.0) {
        static const int at[3][3] = { { 0, 1, 2 }, { 1, 3, 4 }, { 2, 4, 5 } };
        for (i = 0; i < 3; i++)
            for (j = 0; j < 3; j++) {
                double e = s->s[at[i][j]] / s->w;
                a += (double)p[i] * e * (double)p[j];
                b += (double)p[i] * e * (double)q[j];
                c += (double)q[i] * e * (double)q[j];
            }
    }
    a += texel;
    c += texel;
    half = 0.5 * (a - c);
    root = sqrt(half * half + b * b);
    along = 0.5 * (a + c);
    if (root > 0.0) {
        x = half >= 0.0 ? half + root : b;
        y = half >= 0.0 ? b : root - half;
        length = sqrt(x * x + y * y);
        x /= length;
        y /= length;
    }
    *major = envlt__v3_add(envlt__v3_scale(u, (float)x), envlt__v3_scale(v, (float)y));
    *minor = envlt__v3_cross(d, *major);
    *major = envlt__v3_scale(*major, (float)(2.0 * sqrt(along + root)));
    *minor = envlt__v3_scale(*minor, (float)(2.0 * sqrt(along > root ? along - root : 0.0)));
}

/* Makes a light of a stratum's sums. Its direction is that of the texel `chosen`, or the stratum's mean
   direction if chosen is ENVLT_NO_LIGHT. */
static void envlt__make_light(const envlt__grid *g, const envlt__sums *s, uint32_t chosen, envlt_light *light)
{
    double x = s->m[0];
    double y = s->m[1];
    double z = s->m[2];
    double least = 1e-9 * s->w;
    double length;
    envlt__v3 d, major, minor;
    int c;
    if (chosen != ENVLT_NO_LIGHT) {
        x = (double)g->dx[chosen];
        y = (double)g->dy[chosen];
        z = (double)g->dz[chosen];
        least = 0.0;                                    /* a texel's direction is unit, whatever its energy */
    }
    length = sqrt(x * x + y * y + z * z);
    if (!(length > least)) {                            /* light comes evenly from all round: any direction
                                                           will do */
        x = z = 0.0;
        y = length = 1.0;
    }
    d = envlt__v3_make((float)(x / length), (float)(y / length), (float)(z / length));
    envlt__find_extent(s, d, &major, &minor);
    envlt__v3_store(light->direction,
                    envlt__v3_normalize(envlt__unroll_direction(g, (double)d.x, (double)d.y, (double)d.z)));
    envlt__v3_store(light->axis_u,
                    envlt__unroll_direction(g, (double)major.x, (double)major.y, (double)major.z));
    envlt__v3_store(light->axis_v,
                    envlt__unroll_direction(g, (double)minor.x, (double)minor.y, (double)minor.z));
    for (c = 0; c < 3; c++) light->irradiance[c] = (float)s->rgb[c];
    light->solid_angle = (float)s->omega;
}

/* Gives the texels of strata without energy to the light whose mean direction is nearest, numbers the other
   strata without gaps, and returns how many are left. remap is scratch of count entries. */
static uint32_t envlt__drop_dark(const envlt__grid *g, uint32_t *label, envlt__sums *sums, uint32_t *chosen,
                                 uint32_t *remap, uint32_t count)
{
    uint32_t i, j, n = 0;
    size_t t;
    for (i = 0; i < count; i++)
        if (sums[i].w > 0.0) remap[i] = n++;
    if (n == count || n == 0) return n;
    for (i = 0; i < count; i++) {
        double best = 0.0;
        uint32_t nearest = ENVLT_NO_LIGHT;
        for (j = 0; j < count && !(sums[i].w > 0.0); j++) {
            const double *m = sums[j].m, *o = sums[i].o;
            double c = m[0] * o[0] + m[1] * o[1] + m[2] * o[2];
            if (!(sums[j].w > 0.0)) continue;
            c /= sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) + 1e-300;
            if (nearest != ENVLT_NO_LIGHT && c <= best) continue;
            best = c;
            nearest = remap[j];
        }
        if (!(sums[i].w > 0.0)) remap[i] = nearest;
    }
    for (t = 0; t < g->count; t++)
        if (label[t] < count) label[t] = remap[label[t]];
    for (i = n = 0; i < count; i++)
        if (sums[i].w > 0.0) chosen[n++] = chosen[i];
    envlt__accumulate_sums(g, label, sums, n);
    return n;
}
