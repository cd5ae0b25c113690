/* ---- match: lights of another build, or of a turned sky ---- */

static void envlt__swap_lights(envlt_light *lights, uint32_t a, uint32_t b)
{
    envlt_light moved = lights[a];
    lights[a] = lights[b];
    lights[b] = moved;
}

/* Returns the light that follows `last` in the order of falling luminance, equal ones in the order of the
   list. *bright is the luminance of `last`; the first call is made with infinity and ENVLT_NO_LIGHT. */
static uint32_t envlt__next_brightest(const envlt_light *list, uint32_t count, float *bright, uint32_t last)
{
    uint32_t i, best = ENVLT_NO_LIGHT;
    float most = 0.0f;
    for (i = 0; i < count; i++) {
        float w = envlt__luminance(list[i].irradiance);
        w = w > 0.0f ? w : 0.0f;                    /* NaN counts as 0 too */
        if (w > *bright || (!(w < *bright) && last != ENVLT_NO_LIGHT && i <= last)) continue;
        if (best != ENVLT_NO_LIGHT && w <= most) continue;
        most = w;
        best = i;
    }
    *bright = most;
    return best;
}

/* Returns whether the directions of all lights are unit, 0 0 0 or not finite, by the rule of all headers. */
static int envlt__directions_fit(const envlt_light *lights, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        envlt__v3 d = envlt__v3_load(lights[i].direction);
        float square = envlt__v3_dot(d, d);
        if (square > 0.0f && !envlt__is_unit2(square) && envlt__v3_finite(d)) return 0;
    }
    return 1;
}

ENVLT_DEF envlt_result envlt_match(const envlt_light *previous, uint32_t previous_count, envlt_light *lights,
                                   uint32_t count)
{
    uint32_t i, j;
    uint32_t next = 0;
    uint32_t kept = previous_count < count ? previous_count : count;
    uint32_t which = ENVLT_NO_LIGHT;
    float bright = envlt__from_bits(0x7f800000u);
    if ((!previous && previous_count) || (!lights && count)) return ENVLT_ERR_ARGUMENT;
    if (!envlt__directions_fit(previous, previous_count) || !envlt__directions_fit(lights, count))
        return ENVLT_ERR_INPUT;
    for (i = 0; i < previous_count; i++)
        if (previous[i].id >= next) next = previous[i].id + 1;
    /* First the lights that found a previous one come to the front, with its place in their ids. */
    for (i = 0; i < kept; i++) {
        uint32_t best = i;
        float most = -2.0f;
        which = envlt__next_brightest(previous, previous_count, &bright, which);
        for (j = i; j < count; j++) {
            float c = envlt__v3_dot(envlt__v3_load(previous[which].direction),
                                    envlt__v3_load(lights[j].direction));
            if (c > most) {
                most = c;
                best = j;
            }
        }
        envlt__swap_lights(lights, i, best);
        lights[i].id = which;
    }
    /* Then each goes to that place. A place below `kept` that nobody has gets the light with the lowest place
       among those whose own place is gone. */
    for (i = 0; i < kept; i++) {
        uint32_t best = ENVLT_NO_LIGHT;
        for (j = i; j < kept && (best == ENVLT_NO_LIGHT || lights[best].id != i); j++)
            if (lights[j].id == i || (lights[j].id >= kept && (best == ENVLT_NO_LIGHT ||
                                                               lights[j].id < lights[best].id))) best = j;
        envlt__swap_lights(lights, i, best);
    }
    for (i = 0; i < kept; i++) lights[i].id = previous[lights[i].id].id;
    for (; i < count; i++) lights[i].id = next++;
    return ENVLT_OK;
}

ENVLT_DEF envlt_result envlt_rotate(envlt_light *lights, uint32_t count, const float matrix[16])
{
    float scale;
    uint32_t i;
    if ((!lights && count) || !matrix) return ENVLT_ERR_ARGUMENT;
    if (!envlt__m4_is_rigid_uniform(matrix, &scale) || !(fabsf(scale - 1.0f) < 1e-3f))
        return ENVLT_ERR_INPUT;
    if (!envlt__directions_fit(lights, count)) return ENVLT_ERR_INPUT;
    scale = 1.0f / scale;
    for (i = 0; i < count; i++) {
        envlt_light *l = &lights[i];
        envlt__v3_store(l->direction,
                        envlt__v3_normalize(envlt__m4_direction(matrix, envlt__v3_load(l->direction))));
        envlt__v3_store(l->axis_u,
                        envlt__v3_scale(envlt__m4_direction(matrix, envlt__v3_load(l->axis_u)), scale));
        envlt__v3_store(l->axis_v,
                        envlt__v3_scale(envlt__m4_direction(matrix, envlt__v3_load(l->axis_v)), scale));
    }
    return ENVLT_OK;
}
