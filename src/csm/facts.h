/* ---- facts: what maps say about themselves ---- */

COHSM_DEF const char *cohsm_result_text(cohsm_result result)
{
    switch (result) {
#define COHSM__TEXT(name, text) case name: return text;
    COHSM_RESULTS(COHSM__TEXT)
#undef COHSM__TEXT
    default: return "unknown result";
    }
}

COHSM_DEF void cohsm_get_info(const cohsm_maps *m, cohsm_info *out)
{
    const cohsm__header *h;
    if (!m || !out) return;
    h = &m->head;
    memset(out, 0, sizeof *out);
    out->domain = (cohsm_domain_kind)h->domain;
    out->layers = (cohsm_layers)h->layers;
    out->order = (cohsm_order)h->order;
    out->orientation = (cohsm_orientation)h->orientation;
    memcpy(out->side, h->side, sizeof out->side);
    out->map_count = h->map_count;
    out->view_count = h->view_count;
    out->map_side = h->map_side;
    out->depth_bits = h->depth_bits;
    out->dimensions = h->dimensions;
    out->positional = (int)h->positional;
    out->self_only = (int)h->self_only;
    out->pixel_begin = h->pixel_begin;
    out->pixel_end = h->pixel_end;
    memcpy(out->center, h->center, sizeof out->center);
    out->radius = h->radius;
    out->depth_far = h->depth_far;
    out->segment_count = (uint64_t)h->segments_high << 32 | h->segments_low;
    out->bytes = 4 * (size_t)h->words;
    out->layout = m->trays.lines ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
    out->fast_bytes = m->trays.bytes;
    out->memory_bytes = cohsm__maps_bytes(h) - (m->memory ? 0 : out->bytes + 64) + m->trays.bytes;
    out->ratio = 2.0 * (double)h->view_count * (double)m->range / (double)out->bytes;
}

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *m, uint32_t map, float out[4])
{
    cohsm__logger log = cohsm__logger_of_maps(m, "cohsm_location");

    if (!m) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (map >= m->head.map_count) {
        cohsm__log_bound(&log, "map", map, "below", m->head.map_count, "the number of maps");
        return COHSM_ERR_ARGUMENT;
    }
    cohsm__v3_store(out, cohsm__cell_location(&m->head, m->locations, map));
    out[3] = m->head.positional ? 1.0f : 0.0f;
    return COHSM_OK;
}

/* Returns the place in the sequence of the map of a cell. */
static uint32_t cohsm__place_of_cell(const cohsm_maps *m, uint32_t x, uint32_t y, uint32_t z)
{
    const uint32_t *s = m->head.side;
    uint32_t line, cell;
    switch (m->head.order) {
    case COHSM_ORDER_ZIGZAG:
        line = (z & 1u ? s[1] - 1u - y : y) + s[1] * z;
        return line * s[0] + (line & 1u ? s[0] - 1u - x : x);
    case COHSM_ORDER_ZIGZAG_THETA:
        line = (z & 1u ? s[0] - 1u - x : x) + s[0] * z;
        return line * s[1] + (line & 1u ? s[1] - 1u - y : y);
    case COHSM_ORDER_HILBERT:
        cell = x + s[0] * (y + s[1] * z);
        return m->head.map_count <= 65536 ? cohsm__half_word(m->order, cell) : m->order[cell];
    default: return x + s[0] * (y + s[1] * z);
    }
}

COHSM_DEF cohsm_result cohsm_depths(const cohsm_maps *m, uint32_t view, uint16_t *out)
{
    uint32_t c[3], p, place;
    cohsm__logger log = cohsm__logger_of_maps(m, "cohsm_depths");

    if (!m) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (view >= m->head.view_count) {
        cohsm__log_bound(&log, "view", view, "below", m->head.view_count, "the number of views");
        return COHSM_ERR_ARGUMENT;
    }
    cohsm__cell_split(m->head.side, view % m->head.map_count, c);
    place = view / m->head.map_count * m->head.map_count + cohsm__place_of_cell(m, c[0], c[1], c[2]);
    for (p = 0; p < m->range; p++)
        out[p] = (uint16_t)cohsm__stored_depth(m, p, place);
    return COHSM_OK;
}
