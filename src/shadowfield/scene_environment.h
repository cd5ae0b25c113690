/* ---- scenes: distant light ---- */

/* What a cube's texel receives: the sum of radiance times solid angle, and the least of each channel. */
typedef struct sfield__gathered { double rgb[3], angle; float least[3]; } sfield__gathered;

static void sfield__gather_cell(sfield__gathered *g, const float *rgb, double angle)
{
    uint32_t k;
    for (k = 0; k < 3; k++) {
        const float good = sfield__finite(rgb[k]) && rgb[k] > 0 ? (rgb[k] < 1e18f ? rgb[k] : 1e18f) : 0.0f;
        g->rgb[k] += angle * (double)good;
        if (g->angle == 0 || good < g->least[k]) g->least[k] = good;
    }
    g->angle += angle;
}

/* Adds every texel of the map to the texel of the cube that holds its middle. A texel of the map has one
   radiance and its exact solid angle; where the map is coarser than the cube its texels are added in parts.
   So no sun falls between samples, and none counts twice (T11, T12). */
static void sfield__gather_map(const sfield_scene *s, const float *rgb, uint32_t width, uint32_t height,
                               sfield__gathered *g)
{
    const uint32_t across = (32 * s->side + width - 1) / width, down = (16 * s->side + height - 1) / height;
    const uint32_t wide = width * across, high = height * down;
    const double step = 2 * sfield__pi / wide;
    double first[2], turn[2], half;
    double unused, sine, cosine;
    uint32_t x, y;
    sfield__sincos_d(0.5 * step - sfield__pi, &first[1], &first[0]);
    sfield__sincos_d(step, &turn[1], &turn[0]);
    sfield__sincos_d(0.5 * sfield__pi / high, &half, &unused);
    for (y = 0; y < high; y++) {
        const float *row = rgb + 3 * (size_t)(y / down) * width;
        double c = first[0], n = first[1], old, angle;
        sfield__sincos_d(sfield__pi * (y + 0.5) / high, &sine, &cosine);
        angle = step * 2 * sine * half;         /* cos of the upper edge less cos of the lower */
        for (x = 0; x < wide; x++) {
            float direction[3];
            direction[0] = (float)(sine * c);
            direction[1] = (float)cosine;
            direction[2] = (float)(sine * n);
            sfield__gather_cell(g + sfield_cube_find(s->side, direction), row + 3 * (size_t)(x / across),
                                angle);
            old = c;
            c = c * turn[0] - n * turn[1];
            n = n * turn[0] + old * turn[1];
        }
    }
}

/* Makes the cube of texels from a map. What falls into a texel of the cube covers its solid angle but for its
   edges. So the least radiance among this counts for the whole texel, and what is brighter counts by its
   energy; then the remaining error of the energy is scaled away. Returns 0 if there is no memory. */
static int sfield__take_map(sfield_scene *s, const float *rgb, uint32_t width, uint32_t height)
{
    const float *angle = s->texel + 3 * (size_t)s->cells;
    sfield__gathered *g = (sfield__gathered *)sfield__alloc_array(&s->allocator, s->cells, sizeof *g);
    uint32_t i, k;
    if (!g) return 0;
    memset(g, 0, s->cells * sizeof *g);
    sfield__gather_map(s, rgb, width, height, g);
    for (k = 0; k < 3; k++) {
        float *sky = s->sky + (size_t)k * s->cells;
        double all = 0, sum = 0;
        for (i = 0; i < s->cells; i++) {
            const double least = (double)g[i].least[k], more = g[i].rgb[k] - least * g[i].angle;
            sky[i] = (float)(least + more / (double)angle[i]);
            all += g[i].rgb[k];
            sum += (double)sky[i] * (double)angle[i];
        }
        for (i = 0; i < s->cells && sum > 0; i++) sky[i] = (float)((double)sky[i] * (all / sum));
    }
    sfield__free(&s->allocator, g);
    return 1;
}

static void sfield__turn_harmonics(sfield_scene *s)
{
    sfield_rotation r;
    float tile[SFIELD_MAX_COEFS * SFIELD__LANES] = { 0 };
    uint32_t c, k;
    for (c = 0; c < 3; c++) {
        float *now = s->sky_now + c * s->planes;
        memcpy(now, s->sky_still + c * s->planes, s->coefs * sizeof *now);
        if (sfield_sh_rotation(s->algebra, s->sky_turn, &r) == SFIELD_OK) {
            sfield__load_tile(s->coefs, 1, now, 1, tile);
            sfield__rotate16(&r, tile, tile, SFIELD__LANES, 0, s->simd);
            sfield__store_tile(s->coefs, 1, tile, now, 1);
        }
        for (k = 0; k < s->coefs; k++) now[k] += s->sun[c * s->planes + k];
    }
}

/* Turns the sky into the world. Harmonics turn their coefficients; wavelets resample the cube map, once. */
static void sfield__turn_sky(sfield_scene *s)
{
    if (s->algebra) sfield__turn_harmonics(s);
#ifndef SFIELD_WITHOUT_WAVELETS
    else sfield__turn_cube(s);
#endif
    s->sky_hash = sfield__hash_bytes(1, s->sky_now, 3 * (size_t)s->planes);
    sfield__note_change(s, 0);
}

static int sfield__rotation_good(const float *m)
{
    float scale;
    return !m || sfield__m4_is_rigid_uniform(sfield__m4_or_identity(m), &scale);
}

static void sfield__set_turn(sfield_scene *s, const float *to_world)
{
    static const float zeros[16] = { 0 };
    const float *m = sfield__m4_or_identity(to_world ? to_world : zeros);
    uint32_t i;
    float scale = 1;                /* sfield__rotation_good has said that m is rigid */
    (void)sfield__m4_is_rigid_uniform(m, &scale);
    memset(s->sky_turn, 0, sizeof s->sky_turn);
    for (i = 0; i < 12; i++) s->sky_turn[i] = i % 4 == 3 ? 0 : m[i] / scale;
    s->sky_turn[15] = 1;
    sfield__turn_sky(s);
}

SFIELD_DEF sfield_result sfield_scene_environment(sfield_scene *s, const float *rgb, uint32_t width,
                                                  uint32_t height, const float to_world[16])
{
    uint32_t c;
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_environment");
    if (!sfield__rotation_good(to_world))
        return sfield__fail(&log, SFIELD_ERR_INPUT, "to_world", "is no rotation");
    if (rgb && (!sfield__check_value(&log, width >= 1 && width <= 65536, "width", width, "1..65536") ||
                !sfield__check_value(&log, height >= 1 && height <= 65536, "height", height, "1..65536")))
        return SFIELD_ERR_ARGUMENT;
    if (rgb && !sfield__take_map(s, rgb, width, height)) return SFIELD_ERR_ALLOC;
    if (!rgb) memset(s->sky, 0, 3 * (size_t)s->cells * sizeof *s->sky);
    memset(s->sun, 0, 3 * (size_t)s->planes * sizeof *s->sun);
    s->has_sky = rgb != NULL;
    s->has_sun = 0;
    for (c = 0; c < 3 && s->algebra; c++)
        (void)sfield_sh_project(s->desc.bands, s->side, s->sky + c * s->cells, 1,
                                s->sky_still + c * s->planes);
    sfield__set_turn(s, to_world);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_turn(sfield_scene *s, const float to_world[16])
{
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_turn");
    if (!to_world) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "to_world", "is NULL");
    if (!sfield__rotation_good(to_world))
        return sfield__fail(&log, SFIELD_ERR_INPUT, "to_world", "is no rotation");
    sfield__set_turn(s, to_world);
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_sun(sfield_scene *s, const float direction[3],
                                          const float irradiance[3])
{
    double d[3], y[SFIELD_MAX_COEFS];
    uint32_t c, k;
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_sun");
    if (direction && !irradiance) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "irradiance", "is NULL");
    if (!direction) {
        memset(s->sun, 0, 3 * (size_t)s->planes * sizeof *s->sun);
        s->has_sun = 0;
        sfield__turn_sky(s);
        return SFIELD_OK;
    }
    for (k = 0; k < 3; k++) d[k] = (double)direction[k];
    if (sfield__unit_vector(direction) != 1) {
        sfield__log_value(&log, "the length of direction", sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]),
                          "1 (0.97..1.03)");
        return SFIELD_ERR_INPUT;
    }
    for (k = 0; k < 3; k++)
        if (!sfield__in(irradiance[k], 0, 1e18f)) {
            sfield__log_element(&log, "irradiance", k, "is", (double)irradiance[k], "0..1e18");
            return SFIELD_ERR_INPUT;
        }
    if (s->algebra) {
        sfield_sh_basis(s->desc.bands, d, y);
        for (c = 0; c < 3; c++)
            for (k = 0; k < s->coefs; k++) s->sun[c * s->planes + k] += irradiance[c] * (float)y[k];
    } else {
        uint32_t at = sfield_cube_find(s->side, direction);
        for (c = 0; c < 3; c++) s->sun[c * s->cells + at] += irradiance[c] / s->texel[3 * s->cells + at];
    }
    if (!s->has_sky && !s->has_sun) sfield__set_turn(s, NULL);
    else sfield__turn_sky(s);
    s->has_sun = 1;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_sky(const sfield_scene *s, float *coefs)
{
    sfield__logger log;
    uint32_t c, n;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_sky");
    if (!coefs) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "coefs", "is NULL");
    n = s->algebra ? s->coefs : s->cells;
    for (c = 0; c < 3; c++) memcpy(coefs + c * n, s->sky_now + c * s->planes, n * sizeof *coefs);
    return SFIELD_OK;
}
