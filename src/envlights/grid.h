/* ---- grid: the map as weights, its columns turned so that the least energy comes first ---- */

typedef struct envlt__grid {
    envlt_map map;
    uint32_t  width, height, faces;
    uint32_t  roll;                         /* the column of the map that is column 0 of the grid */
    size_t    count;                        /* texels */
    float    *lum;                          /* luminance; 0 where a texel does not count or belongs to the
                                               sun */
    float    *omega;                        /* the solid angle that counts */
    float    *dx, *dy, *dz;                 /* unit directions, with azimuths counted from column 0 of the
                                               grid, so that a turned map has the same */
    double    total;                        /* the sum of luminance x solid angle */
    uint64_t  bad;                          /* texels with a channel that was replaced by 0 */
    float    *memory;                       /* of the five arrays */
} envlt__grid;

/* Returns the texel of the map for the grid's column x, in the row that begins at texel `row`. */
static size_t envlt__map_texel(const envlt__grid *g, size_t row, uint32_t x)
{
    return row + (x < g->width - g->roll ? x + g->roll : x + g->roll - g->width);
}

/* Fills in the directions of the texels' centres. */
static void envlt__fill_directions(envlt__grid *g)
{
    uint32_t f, x, y;
    double d[3];
    double st, ct, sp, cp;
    size_t t = 0;
    if (g->faces == 6) {
        for (f = 0; f < 6; f++)
            for (y = 0; y < g->height; y++)
                for (x = 0; x < g->width; x++, t++) {
                    envlt__direction(&g->map, f, x + 0.5, y + 0.5, d);
                    g->dx[t] = (float)d[0];
                    g->dy[t] = (float)d[1];
                    g->dz[t] = (float)d[2];
                }
        return;
    }
    /* The first row holds the azimuths until it is made itself, last. */
    for (x = 0; x < g->width; x++) {
        envlt__sincos64(2.0 * ENVLT__PI * (x + 0.5) / g->width, &sp, &cp);
        g->dx[x] = (float)cp;
        g->dz[x] = (float)sp;
    }
    for (y = g->height; y-- > 0;) {
        envlt__sincos64(ENVLT__PI * (y + 0.5) / g->height, &st, &ct);
        t = (size_t)y * g->width;
        for (x = 0; x < g->width; x++) {
            g->dx[t + x] = (float)st * g->dx[x];
            g->dy[t + x] = (float)ct;
            g->dz[t + x] = (float)st * g->dz[x];
        }
    }
}

/* Chooses the column with the least energy for column 0 of the grid, so that turning a latitude-longitude map
   turns its lights (T21). sums is an array of width zeros. */
static void envlt__choose_roll(envlt__grid *g, double *sums, int hemisphere)
{
    uint32_t x, y;
    float rgb[3];
    for (y = 0; y < g->height; y++) {
        double omega = envlt__solid_angle(&g->map, 0, 0, y, hemisphere);
        for (x = 0; omega > 0.0 && x < g->width; x++) {
            envlt__fetch_texel(&g->map, (size_t)y * g->width + x, rgb);
            sums[x] += (double)envlt__luminance(rgb) * omega;
        }
    }
    for (x = 0; x < g->width; x++)
        if (sums[x] < sums[g->roll]) g->roll = x;
}

/* Fills in luminance and solid angle of each texel, and their sums. */
static void envlt__fill_weights(envlt__grid *g, int hemisphere)
{
    uint32_t f, x, y;
    size_t t = 0;
    float rgb[3];
    for (f = 0; f < g->faces; f++)
        for (y = 0; y < g->height; y++) {
            double row = 0.0, omega = g->faces == 1 ? envlt__solid_angle(&g->map, 0, 0, y, hemisphere) : 0.0;
            for (x = 0; x < g->width; x++, t++) {
                if (g->faces == 6) omega = envlt__solid_angle(&g->map, f, x, y, hemisphere);
                g->omega[t] = (float)omega;
                g->lum[t] = 0.0f;
                if (!(omega > 0.0)) continue;
                g->bad += (uint64_t)envlt__fetch_texel(&g->map, envlt__map_texel(g, t - x, x), rgb);
                g->lum[t] = envlt__luminance(rgb);
                row += (double)g->lum[t] * omega;
            }
            g->total += row;
        }
}

/* Fills the grid from a map that envlt__check_map has passed. roll is the map's column for column 0 of the
   grid, or ENVLT_NO_LIGHT for the column with the least energy. */
static envlt_result envlt__make_grid(envlt__grid *g, const envlt_map *map, int hemisphere, uint32_t roll,
                                     const envlt__allocator *a)
{
    double *sums;
    size_t t, count = (size_t)map->width * map->height * (map->projection == ENVLT_PROJECTION_CUBE ? 6 : 1);
    memset(g, 0, sizeof *g);
    g->map = *map;
    g->width = map->width;
    g->height = map->height;
    g->faces = map->projection == ENVLT_PROJECTION_CUBE ? 6 : 1;
    g->count = count;
    g->roll = roll == ENVLT_NO_LIGHT ? 0 : roll;
    if (g->faces == 1 && roll == ENVLT_NO_LIGHT) {
        sums = (double *)envlt__alloc_array(a, g->width, sizeof *sums);
        if (!sums) return ENVLT_ERR_ALLOC;
        for (t = 0; t < g->width; t++) sums[t] = 0.0;
        envlt__choose_roll(g, sums, hemisphere);
        envlt__free(a, sums);
    }
    g->memory = (float *)envlt__alloc_array(a, g->count, 5 * sizeof(float));
    if (!g->memory) return ENVLT_ERR_ALLOC;
    g->lum = g->memory;
    g->omega = g->lum + count;
    g->dx = g->omega + count;
    g->dy = g->dx + count;
    g->dz = g->dy + count;
    envlt__fill_directions(g);
    envlt__fill_weights(g, hemisphere);
    return ENVLT_OK;
}

/* Returns the energy of a texel, luminance x solid angle. */
static double envlt__texel_weight(const envlt__grid *g, size_t t)
{
    return (double)g->lum[t] * (double)g->omega[t];
}

static double envlt__sum_weights(const envlt__grid *g)
{
    double total = 0.0;
    size_t t;
    for (t = 0; t < g->count; t++) total += envlt__texel_weight(g, t);
    return total;
}

/* Writes the four neighbours of a texel. They go round the seam and over the poles of a latitude-longitude
   map, and across the edges of a cube. */
static void envlt__neighbours(const envlt__grid *g, uint32_t t, uint32_t *out)
{
    uint32_t w = g->width;
    uint32_t h = g->height;
    uint32_t x = t % w;
    uint32_t row = t / w;
    uint32_t y = row % h;
    uint32_t face = row / h;
    if (g->faces == 6) {
        out[0] = x > 0 ? t - 1 : envlt__cube_texel(w, face, -1, (int64_t)y);
        out[1] = x + 1 < w ? t + 1 : envlt__cube_texel(w, face, (int64_t)w, (int64_t)y);
        out[2] = y > 0 ? t - w : envlt__cube_texel(w, face, (int64_t)x, -1);
        out[3] = y + 1 < h ? t + w : envlt__cube_texel(w, face, (int64_t)x, (int64_t)h);
        return;
    }
    out[0] = x > 0 ? t - 1 : t + w - 1;
    out[1] = x + 1 < w ? t + 1 : t + 1 - w;
    out[2] = y > 0 ? t - w : row * w + (x + w / 2) % w;
    out[3] = y + 1 < h ? t + w : row * w + (x + w / 2) % w;
}
