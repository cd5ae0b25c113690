/* ---- wavelets: cubes of texels turned ---- */

/* Finds the four texels of a cube that lie around a direction, with their bilinear weights. */
static void sfield__find_taps(const sfield_scene *s, const float *direction, sfield__taps *taps)
{
    const uint32_t face = sfield__face_of(direction);
    float q[3], d[3], x, y;
    int32_t xi, yi;
    uint32_t k;
    sfield__to_face(face, direction, q);
    x = (q[0] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
    y = (q[1] / q[2] + 1) * 0.5f * (float)s->side - 0.5f;
    xi = (int32_t)(x + 1) - 1;
    yi = (int32_t)(y + 1) - 1;
    x -= (float)xi;
    y -= (float)yi;
    /* past an edge: the texel of the next face in that direction */
    for (k = 0; k < 4; k++) {
        double e[3];
        sfield__from_face(face, (2.0 * (xi + (int32_t)(k & 1)) + 1) / s->side - 1,
                          (2.0 * (yi + (int32_t)(k >> 1)) + 1) / s->side - 1, e);
        d[0] = (float)e[0];
        d[1] = (float)e[1];
        d[2] = (float)e[2];
        taps->texel[k] = (uint16_t)sfield_cube_find(s->side, d);
        taps->weight[k] = (k & 1 ? x : 1 - x) * (k >> 1 ? y : 1 - y);
    }
}

/* Finds the texels around texel i of the scene's cube, seen through a rotation: rows of three floats,
   `stride` apart. */
static void sfield__find_turned_taps(const sfield_scene *s, const float *turn, uint32_t stride, uint32_t i,
                                 sfield__taps *taps)
{
    const float x = s->texel[i], y = s->texel[s->cells + i], z = s->texel[2 * s->cells + i];
    float local[3];
    uint32_t k;
    for (k = 0; k < 3; k++, turn += stride) local[k] = turn[0] * x + turn[1] * y + turn[2] * z;
    sfield__find_taps(s, local, taps);
}

/* Finds, for a rotated entity, which texels of its own cube lie around each direction of the world's. */
static void sfield__make_taps(const sfield_scene *s, const float *turn, sfield__taps *taps)
{
    uint32_t i;
    for (i = 0; i < s->cells; i++) sfield__find_turned_taps(s, turn, 3, i, &taps[i]);
}

/* Makes a table for each entity that is rotated and hides or shines. Returns 0 if there is no memory. */
static int sfield__make_all_taps(sfield_scene *s, uint32_t tables)
{
    uint32_t i;
    s->taps = (sfield__taps *)sfield__alloc_array(&s->allocator, (size_t)tables * s->cells, sizeof *s->taps);
    if (!s->taps) return 0;
    for (i = 0; i < s->item_count; i++)
        if (s->item[i].map)
            sfield__make_taps(s, s->item[i].turn, s->taps + (size_t)(s->item[i].map - 1) * s->cells);
    return 1;
}

/* Resamples the sky's cube as it lies in the world now, and finds its wavelets. */
static void sfield__turn_cube(sfield_scene *s)
{
    uint32_t i, c, k;
    for (i = 0; i < s->cells; i++) {
        sfield__taps taps;
        sfield__find_turned_taps(s, s->sky_turn, 4, i, &taps);
        for (c = 0; c < 3; c++) s->sky_now[c * s->cells + i] = s->sun[c * s->cells + i];
        for (k = 0; k < 4; k++)
            for (c = 0; c < 3; c++)
                s->sky_now[c * s->cells + i] += taps.weight[k] * s->sky[c * s->cells + taps.texel[k]];
    }
    for (c = 0; c < 3; c++)
        sfield__haar_cube(s->side, s->sky_now + c * s->cells, s->sky_now + (3 + c) * s->cells, s->simd);
}
