/* ---- windows: most texels of a tile show that part of the square which the picture shows ---- */

/* Sets the map of one axis; below and above are the 64ths of the square on either side of the window. The
   window begins and ends between texels, so that the map is linear within each. */
static void ism__set_axis(uint32_t below, uint32_t above, uint32_t size, uint32_t rim, ism__axis *out)
{
    uint32_t rest = below + above, a;
    memset(out, 0, sizeof *out);
    if (!(rest * size > rim * ISM__STEPS) || rest >= ISM__STEPS) return;
    a = (2u * rim * below + rest) / (2u * rest);
    if (below && !a) a = 1u;
    if (above && a == rim) a = rim - 1u;
    out->on = 1;
    out->lo = (float)below / (float)ISM__STEPS;
    out->hi = (float)(ISM__STEPS - above) / (float)ISM__STEPS;
    out->a = (float)a / (float)size;
    out->b = (float)(size - rim + a) / (float)size;
    out->below = below ? out->a / out->lo : 1.0f;
    out->inside = (out->b - out->a) / (out->hi - out->lo);
    out->above = above ? (1.0f - out->b) / (1.0f - out->hi) : 1.0f;
}

static void ism__set_window(uint32_t window, uint32_t size, uint32_t rim, ism__window *out)
{
    ism__set_axis(window & 63u, window >> 12 & 63u, size, rim, &out->u);
    ism__set_axis(window >> 6 & 63u, window >> 18 & 63u, size, rim, &out->v);
}

static float ism__to_tile(const ism__axis *w, float u)
{
    float x;
    if (!w->on) return u;
    x = u < w->lo ? u * w->below : u < w->hi ? w->a + (u - w->lo) * w->inside : w->b + (u - w->hi) * w->above;
    return x < 0.0f ? 0.0f : x < 1.0f ? x : 1.0f;
}

static float ism__from_tile(const ism__axis *w, float x)
{
    float u;
    if (!w->on) return x;
    u = x < w->a ? x / w->below : x < w->b ? w->lo + (x - w->a) / w->inside : w->hi + (x - w->b) / w->above;
    return u < 0.0f ? 0.0f : u < 1.0f ? u : 1.0f;
}

ISM_DEF void ism_zoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float uv[2], float tile[2])
{
    ism__window w;
    ism__set_window(window, tile_side, rim, &w);
    tile[0] = ism__to_tile(&w.u, uv[0] > 0.0f ? uv[0] < 1.0f ? uv[0] : 1.0f : 0.0f);
    tile[1] = ism__to_tile(&w.v, uv[1] > 0.0f ? uv[1] < 1.0f ? uv[1] : 1.0f : 0.0f);
}

ISM_DEF void ism_unzoom(uint32_t window, uint32_t tile_side, uint32_t rim, const float tile[2], float uv[2])
{
    ism__window w;
    ism__set_window(window, tile_side, rim, &w);
    uv[0] = ism__from_tile(&w.u, tile[0] > 0.0f ? tile[0] < 1.0f ? tile[0] : 1.0f : 0.0f);
    uv[1] = ism__from_tile(&w.v, tile[1] > 0.0f ? tile[1] < 1.0f ? tile[1] : 1.0f : 0.0f);
}
