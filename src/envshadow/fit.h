/* ---- fit: a light's map round the casters ---- */

typedef struct envsh__light { envsh__v3 direction, irradiance, axis_u, axis_v; } envsh__light;

/* Returns light i of the caller's arrays; a light without extent gets axes of length 0. */
static envsh__light envsh__light_at(const envsh_lights *lights, uint32_t i)
{
    envsh__light l;
    l.direction = envsh__load_item(lights->directions, lights->stride, i);
    l.irradiance = envsh__load_item(lights->irradiances, lights->stride, i);
    l.axis_u = l.axis_v = envsh__v3_make(0, 0, 0);
    if (!lights->axes_u) return l;
    l.axis_u = envsh__load_item(lights->axes_u, lights->stride, i);
    l.axis_v = envsh__load_item(lights->axes_v, lights->stride, i);
    return l;
}

/* Returns x rounded up to a sixteenth of an octave: a texel keeps its size while bounds change a little.
   The four upper bits of the mantissa stay. */
static float envsh__round_up_texel(float x)
{
    uint32_t bits = envsh__to_bits(x), low = bits & 0x7ffffu;
    return envsh__from_bits(low ? bits - low + 0x80000u : bits);
}

/* Writes a row of envsh_view.lookup, which gives the texel's x, its y or the depth for a point of the world.
   */
static void envsh__set_row(float *row, envsh__v3 axis, float scale, float offset)
{
    envsh__v3_store(row, envsh__v3_scale(axis, scale));
    row[3] = offset;
}

/* Writes the matrix from the world to clip space: texels 0..map_side become -1..1, depth 0..1 becomes what
   clip_depth says. */
static void envsh__clip_matrix(const envsh_maps *m, envsh_view *v)
{
    float s = 2.0f / (float)m->map_side, flip = m->rows == ENVSH_ROWS_TOP_FIRST ? -1.0f : 1.0f;
    float z = 2.0f, less = 1.0f;
    int c;
    if (m->clip_depth == ENVSH_CLIP_DEPTH_ZERO_TO_ONE) z = 1.0f, less = 0.0f;
    if (m->clip_depth == ENVSH_CLIP_DEPTH_REVERSED) z = -1.0f, less = -1.0f;
    for (c = 0; c < 4; c++) {
        v->world_to_clip[4 * c] = v->lookup[c] * s - (c == 3 ? 1.0f : 0.0f);
        v->world_to_clip[4 * c + 1] = flip * (v->lookup[4 + c] * s - (c == 3 ? 1.0f : 0.0f));
        v->world_to_clip[4 * c + 2] = v->lookup[8 + c] * z - (c == 3 ? less : 0.0f);
        v->world_to_clip[4 * c + 3] = c == 3 ? 1.0f : 0.0f;
    }
}

/* Fits a light's tile to the bounds: two axes across the light and one along it, the size of a texel, and the
   range of depths. */
static void envsh__fit_view(const envsh_maps *m, const envsh__light *l, const envsh_bounds *b, envsh_view *v)
{
    envsh__v3 axis[3];
    float low[3], high[3];
    float inner = (float)(m->map_side - 2 * m->guard) - 1.0f;
    float diagonal = 0.0f;
    float range, margin;
    int i, j;
    axis[2] = envsh__v3_normalize(l->direction);
    envsh__v3_basis(axis[2], &axis[0], &axis[1]);
    axis[2] = envsh__v3_scale(axis[2], -1.0f);      /* since depth grows away from the light */
    for (i = 0; i < 3; i++) {
        float d[3];
        envsh__v3_store(d, axis[i]);
        low[i] = high[i] = 0.0f;
        for (j = 0; j < 3; j++) {
            float a = d[j] * b->low[j], c = d[j] * b->high[j];
            low[i] += a < c ? a : c;
            high[i] += a < c ? c : a;
        }
        diagonal += (b->high[i] - b->low[i]) * (b->high[i] - b->low[i]);
    }
    diagonal = sqrtf(diagonal);
    for (i = 0; i < 2; i++) {
        float size = high[i] - low[i], texel, corner;
        size = size > 1e-4f * diagonal ? size : 1e-4f * diagonal;
        texel = envsh__round_up_texel(size / inner);
        corner = floorf((0.5f * (low[i] + high[i]) - 0.5f * texel * (inner + 1.0f)) / texel + 0.5f);
        v->texel[i] = texel;
        envsh__set_row(v->lookup + 4 * i, axis[i], 1.0f / texel, (float)m->guard - corner);
    }
    margin = 1e-3f * diagonal + 1e-6f * (fabsf(low[2]) + fabsf(high[2]));
    range = high[2] - low[2] + 2.0f * margin;
    v->depth_range = range;
    envsh__set_row(v->lookup + 8, axis[2], 1.0f / range, (margin - low[2]) / range);
    envsh__v3_store(v->right, axis[0]);
    envsh__v3_store(v->up, axis[1]);
    for (i = 0; i < 2; i++) {
        v->spread[i] = envsh__v3_dot(axis[i], l->axis_u) * range / v->texel[i];
        v->spread[2 + i] = envsh__v3_dot(axis[i], l->axis_v) * range / v->texel[i];
    }
}

/* Checks one light of the caller's arrays. */
static envsh_result envsh__check_light(const envsh_lights *lights, uint32_t i, const envsh__logger *log)
{
    envsh__light l = envsh__light_at(lights, i);
    float length = envsh__v3_length(l.direction), most = envsh__v3_length(l.axis_u);
    float other = envsh__v3_length(l.axis_v);
    if (!envsh__is_unit(l.direction)) {
        envsh__log_element(log, "lights.directions", i, "has the length", (double)length, "1 (0.97..1.03)");
        return ENVSH_ERR_INPUT;
    }
    if (!(fabsf(l.irradiance.x) <= 1e32f && fabsf(l.irradiance.y) <= 1e32f &&
          fabsf(l.irradiance.z) <= 1e32f)) {
        envsh__log_element(log, "lights.irradiances", i, "begins with", (double)l.irradiance.x,
                           "-1e32..1e32, all three");
        return ENVSH_ERR_INPUT;
    }
    if (most < 1e3f && other < 1e3f) return ENVSH_OK;
    envsh__log_element(log, most < 1e3f ? "lights.axes_v" : "lights.axes_u", i, "has the length",
                       (double)(most < 1e3f ? other : most), "below 1000");
    return ENVSH_ERR_INPUT;
}

/* Checks the arrays of lights and each light, but not whether the maps hold so many. */
static envsh_result envsh__check_lights(const envsh_lights *lights, const envsh__logger *log)
{
    const envsh_result bad = ENVSH_ERR_ARGUMENT;
    envsh_result result = ENVSH_OK;
    uint32_t i;
    if (!lights->count) return ENVSH_OK;
    if (!lights->directions) return envsh__refuse_text(log, "lights.directions", "is NULL", bad);
    if (!lights->irradiances) return envsh__refuse_text(log, "lights.irradiances", "is NULL", bad);
    if (!lights->axes_u != !lights->axes_v)
        return envsh__refuse_text(log, lights->axes_u ? "lights.axes_v" : "lights.axes_u",
                                  "is NULL, and the other axes are not", bad);
    if (!envsh__stride_fits(lights->stride))
        return envsh__refuse_stride(log, "lights.stride", lights->stride);
    for (i = 0; i < lights->count && result == ENVSH_OK; i++) result = envsh__check_light(lights, i, log);
    return result;
}

/* Checks bounds. If they are empty or a point, they become a box in which nothing is divided by 0. */
static envsh_result envsh__check_bounds(envsh_bounds *b, const envsh__logger *log)
{
    int c, empty = 0;
    float size = 0.0f;
    for (c = 0; c < 3; c++) {
        if (!(fabsf(b->low[c]) <= 1e15f))
            return envsh__refuse(log, "bounds.low", (double)b->low[c], "-1e15..1e15", ENVSH_ERR_INPUT);
        if (!(fabsf(b->high[c]) <= 1e15f))
            return envsh__refuse(log, "bounds.high", (double)b->high[c], "-1e15..1e15", ENVSH_ERR_INPUT);
        empty |= b->low[c] > b->high[c];
        if (b->high[c] - b->low[c] > size) size = b->high[c] - b->low[c];
    }
    for (c = 0; c < 3 && (empty || !(size > 1e-15f)); c++) {      /* any box about the point will do */
        float middle = empty ? 0.0f : b->low[c], half = 0.5f + 1e-3f * fabsf(middle);
        b->low[c] = middle - half;
        b->high[c] = middle + half;
    }
    return ENVSH_OK;
}

/* Clears the tile of light i. */
static void envsh__clear_task(void *context, size_t i)
{
    envsh_maps *m = (envsh_maps *)context;
    size_t row, x, y;
    float *tile = envsh__tile_texels(m, (uint32_t)i, &row);
    for (y = 0; y < m->map_side; y++)
        for (x = 0; x < m->map_side; x++) tile[y * row + x * m->channels] = ENVSH__NOTHING;
}

ENVSH_DEF envsh_result envsh_maps_begin(envsh_maps *m, const envsh_lights *lights, envsh_bounds bounds)
{
    uint32_t i, count = lights ? lights->count : 0;
    envsh__logger logger;
    envsh_result result = ENVSH_OK;
    if (!m) return ENVSH_ERR_ARGUMENT;
    logger = envsh__make_logger(&m->system, "envsh_maps_begin");
    if (count > m->capacity) {
        envsh__log_bound(&logger, "lights.count", count, "at most", m->capacity, "the capacity of the maps");
        return ENVSH_ERR_LIMIT;
    }
    if (lights) result = envsh__check_lights(lights, &logger);
    if (result == ENVSH_OK) result = envsh__check_bounds(&bounds, &logger);
    if (result != ENVSH_OK) return result;
    for (i = 0; i < count; i++) {
        envsh_view *v = &m->views[i];
        envsh__light l = envsh__light_at(lights, i);
        uint32_t slot = i / m->channels;
        memset(v, 0, sizeof *v);
        v->channel = i % m->channels;
        v->x = slot % m->across * m->map_side;
        v->y = slot / m->across % m->down * m->map_side;
        v->page = slot / (m->across * m->down);
        v->guard = m->guard;
        envsh__v3_store(v->direction, l.direction);
        envsh__v3_store(v->irradiance, l.irradiance);
        envsh__fit_view(m, &l, &bounds, v);
        envsh__clip_matrix(m, v);
    }
    m->count = count;
    m->phase = 1;
    if (!m->no_depth) envsh__for_each(&m->system, count, envsh__clear_task, m);
    return ENVSH_OK;
}
