/* ---- residual: what the lights leave out ---- */

/* Checks the arguments of a residual. `name` is that of the output, for the log. */
static envlt_result envlt__check_residual(const envlt_lights *l, const envlt_map *map, const char *function,
                                          const char *name, const float *out)
{
    envlt__logger logger;
    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, function);
    return out ? envlt__check_same(l, map, &logger)
               : envlt__refuse_text(&logger, name, "is NULL", ENVLT_ERR_ARGUMENT);
}

ENVLT_DEF envlt_result envlt_residual(const envlt_lights *l, const envlt_map *map, float *rgb)
{
    envlt_result result = envlt__check_residual(l, map, "envlt_residual", "rgb", rgb);
    float texel[3];
    size_t t, c;
    if (result != ENVLT_OK) return result;
    for (t = 0; t < l->texels; t++) {
        uint32_t s = l->strata[t];
        envlt__fetch_texel(map, t, texel);
        for (c = 0; c < 3; c++)
            rgb[3 * t + c] = s == ENVLT_NO_LIGHT ? 0.0f
                                                 : (float)((double)texel[c] -
                                                           l->sums[s].rgb[c] / l->sums[s].omega);
    }
    return ENVLT_OK;
}

/* Writes the nine real spherical harmonics of bands 0, 1 and 2 in a unit direction. */
static void envlt__fill_harmonics(const double *d, double *y)
{
    y[0] = 0.28209479177387814;
    y[1] = 0.48860251190291992 * d[1];
    y[2] = 0.48860251190291992 * d[2];
    y[3] = 0.48860251190291992 * d[0];
    y[4] = 1.0925484305920792 * d[0] * d[1];
    y[5] = 1.0925484305920792 * d[1] * d[2];
    y[6] = 0.31539156525252005 * (3.0 * d[2] * d[2] - 1.0);
    y[7] = 1.0925484305920792 * d[0] * d[2];
    y[8] = 0.54627421529603959 * (d[0] * d[0] - d[1] * d[1]);
}

ENVLT_DEF envlt_result envlt_residual_sh(const envlt_lights *l, const envlt_map *map, float sh[27])
{
    envlt_result result = envlt__check_residual(l, map, "envlt_residual_sh", "sh", sh);
    double sum[27], y[9], d[3], omega = 0.0;
    uint32_t w, h, x, row;
    uint32_t face, i, j, c;
    size_t t = 0;
    if (result != ENVLT_OK) return result;
    memset(sum, 0, sizeof sum);
    w = map->width;
    h = map->height;
    for (row = 0; row < l->texels / w; row++) {
        face = row / h;
        for (x = 0; x < w; x++, t++) {
            float rgb[3];
            if (l->strata[t] == ENVLT_NO_LIGHT) continue;
            if (x == 0 || l->map.projection == ENVLT_PROJECTION_CUBE || !(omega > 0.0))
                omega = envlt__solid_angle(map, face, x, row % h, l->desc.hemisphere);
            envlt__fetch_texel(map, t, rgb);
            if (!(rgb[0] + rgb[1] + rgb[2] > 0.0f)) continue;
            envlt__direction(map, face, x + 0.5, row % h + 0.5, d);
            envlt__fill_harmonics(d, y);
            for (j = 0; j < 27; j++) sum[j] += y[j / 3] * omega * (double)rgb[j % 3];
        }
        omega = 0.0;
    }
    for (i = 0; i < l->count; i++) {
        for (c = 0; c < 3; c++) d[c] = (double)l->list[i].direction[c];
        envlt__fill_harmonics(d, y);
        for (j = 0; j < 27; j++) sum[j] -= y[j / 3] * l->sums[i].rgb[j % 3];
    }
    for (j = 0; j < 27; j++) sh[j] = (float)sum[j];
    return ENVLT_OK;
}

ENVLT_DEF void envlt_sh_irradiance(const float sh[27], const float normal[3], float rgb[3])
{
    /* The clamped cosine in the three bands: pi, 2 pi / 3 and pi / 4 (T10). */
    static const double kernel[9] = { 3.1415926535897932,
                                      2.0943951023931953, 2.0943951023931953, 2.0943951023931953,
                                      0.78539816339744831, 0.78539816339744831, 0.78539816339744831,
                                      0.78539816339744831, 0.78539816339744831 };
    double d[3], y[9], sum;
    int c, j;
    for (c = 0; c < 3; c++) d[c] = (double)normal[c];
    envlt__fill_harmonics(d, y);
    for (c = 0; c < 3; c++) {
        sum = 0.0;
        for (j = 0; j < 9; j++) sum += kernel[j] * y[j] * (double)sh[3 * j + c];
        rgb[c] = (float)sum;
    }
}
