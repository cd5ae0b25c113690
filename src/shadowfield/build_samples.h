/* ---- building: samples seen, projected, packed ---- */

/* Applies the window to a channel, and takes its logarithm if the desc asks for it. */
static void sfield__finish_channel(const sfield__build *b, sfield__view *v, float *out)
{
    uint32_t k, l;
    for (l = 0, k = 0; l < b->h.bands; l++)
        for (; k < (l + 1) * (l + 1); k++) out[k] *= b->window[l];
    if (!b->h.logarithm) return;
    for (k = 0; k < b->h.bands * b->h.bands; k++) out[k] = (k ? 0 : 1 / sfield__y00) - out[k];
    sfield__sh_log(b->algebra, out, out, v->work);
}

/* Projects texel[] on the basis, into n^2 values for each channel, `planes` apart. Self-visibility is the
   visible share times the cosine. */
static void sfield__encode_sh(const sfield__build *b, sfield__view *v, const float *normal, float *out)
{
    uint32_t i, k, c, l;
    memset(out, 0, b->h.stride * sizeof *out);
    for (c = 0; c < b->h.channels; c++, out += b->planes) {
        const float *texel = v->texel + c * b->cells;
        for (i = 0; i < b->cells; i++) {
            const float *y = b->texels.basis + (size_t)i * b->planes, *d = b->texels.direction + 3 * i;
            float a = texel[i];
            if (normal) {
                float cosine = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
                a = cosine > 0 ? (1 - a) * cosine : 0;
            }
            if (a == 0) continue;
            for (k = 0; k < b->planes; k += 8)
                for (l = 0; l < 8; l++) out[k + l] += a * y[k + l];
        }
        sfield__finish_channel(b, v, out);
    }
}

/* Takes what the caller's renderer saw from sample i of the batch: coefficients, or texels to encode. */
static void sfield__encode_seen(const sfield__build *b, sfield__view *v, size_t i)
{
    const float most = b->h.kind == SFIELD__KIND_SOURCE ? 1e18f : 100;
    float *seen = b->seen + (i - b->from) * b->seen_size, *out;
    uint32_t c, n = b->h.bands * b->h.bands;
    size_t k;
    for (k = 0; k < b->seen_size; k++) seen[k] = sfield__in(seen[k], -most, most) ? seen[k] : 0;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) {
        memcpy(v->texel, seen, b->seen_size * sizeof *seen);
        sfield__encode_haar(b, v, &b->kept[i], &b->kept_scale[i], b->entry + i * b->most * b->h.stride);
        return;
    }
#endif
    out = b->value + i * b->h.stride;
    memset(out, 0, b->h.stride * sizeof *out);
    for (c = 0; c < b->h.channels; c++, out += b->planes) {
        memcpy(out, seen + c * n, n * sizeof *out);
        sfield__finish_channel(b, v, out);
    }
}

/* Writes where sample i of the current shell lies, in r. */
static void sfield__sample_point(const sfield__build *b, size_t i, float *eye)
{
    uint32_t side = b->h.position_side, k;
    double d[3], l;
    sfield__from_face((uint32_t)(i / ((size_t)side * side)), (double)b->texels.node[i % side],
                      (double)b->texels.node[i / side % side], d);
    l = (double)b->radius / sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (k = 0; k < 3; k++) eye[k] = (float)(d[k] * l);
}

static void sfield__build_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    uint32_t k;
    for (i = b->from + piece; i < b->to; i += b->pieces) {
        const float *normal = NULL;
        float eye[3];
        if (b->what == SFIELD__VIEWS) {
            sfield__encode_seen(b, v, i);
            continue;
        }
        if (b->what == SFIELD__SELF) {
            const float *p = sfield__row(b->points->positions, b->points->position_stride, b->first + i);
            normal = sfield__row(b->points->normals, b->points->normal_stride, b->first + i);
            for (k = 0; k < 3; k++) eye[k] = (p[k] + b->offset * normal[k] - b->h.center[k]) / b->h.radius;
        } else sfield__sample_point(b, i, eye);
        sfield__view_from(b, v, eye);
        if ((b->what == SFIELD__MESH || b->what == SFIELD__SELF) && !b->desc.keep_inside &&
            sfield__move_out(b, sfield__share_hidden(b, v->texel), eye)) {
            sfield__view_from(b, v, eye);
            v->moved++;
        }
#ifndef SFIELD_WITHOUT_WAVELETS
        if (b->h.basis == SFIELD_BASIS_HAAR) {
            sfield__encode_haar(b, v, &b->kept[i], &b->kept_scale[i], b->entry + i * b->most * b->h.stride);
            continue;
        }
#endif
        sfield__encode_sh(b, v, normal, b->value + i * b->h.stride);
    }
}

/* Packs each coefficient into 8 bits, scaled to its range in this shell. The error is at most range / 510
   (T77). */
static void sfield__quantise(sfield__build *b, size_t first, uint32_t group)
{
    sfield_field *f = b->out;
    float *scale = (float *)(void *)(f->words + SFIELD__HEADER + b->h.shells) + (size_t)group * b->h.stride;
    float *bias = scale + (size_t)sfield__groups(&b->h) * b->h.stride;
    uint8_t *sample = (uint8_t *)(f->words + f->word_count) + first * b->h.stride;
    size_t i, k;
    for (k = 0; k < b->h.stride; k++) {
        float low = b->value[k], high = b->value[k], inverse;
        for (i = 1; i < b->count; i++) {
            float x = b->value[i * b->h.stride + k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        scale[k] = (high - low) / 255;
        bias[k] = low;
        inverse = scale[k] > 0 ? 1 / scale[k] : 0;
        for (i = 0; i < b->count; i++) {
            float q = (b->value[i * b->h.stride + k] - low) * inverse + 0.5f;
            sample[i * b->h.stride + k] = (uint8_t)(q < 255 ? q : 255);
        }
    }
}

/* Asks the caller's renderer what some eyes see. Returns what it returns: not 0 if the build ends. */
static int sfield__ask_views(sfield__build *b, size_t begin, size_t end)
{
    sfield_views views;
    memset(b->seen + begin * b->seen_size, 0, b->seen_size * (end - begin) * sizeof *b->seen);
    memcpy(views.center, b->h.center, sizeof views.center);
    views.radius = b->h.radius;
    views.time = b->time;
    views.count = end - begin;
    views.eyes = b->eyes + 3 * begin;
    views.values = b->seen + begin * b->seen_size;
    return b->see(b->see_user, &views);
}

/* Asks for all samples of the batch, then once more for those that are inside the mesh, a run of neighbours
   at a time. Returns not 0 if the build ends. */
static int sfield__ask_batch(sfield__build *b)
{
    size_t i, end, count = b->to - b->from;
    for (i = 0; i < count; i++) sfield__sample_point(b, b->from + i, b->eyes + 3 * i);
    if (sfield__ask_views(b, 0, count) != 0) return 1;
    if (b->triangles == 0 || b->h.kind != SFIELD__KIND_OCCLUSION || b->desc.keep_inside) return 0;
    sfield__run_tasks(b, sfield__find_inside_task);
    for (i = 0; i < count; i = end + 1) {
        while (i < count && !b->moved[i]) i++;
        for (end = i; end < count && b->moved[end];) end++;
        if (end > i && sfield__ask_views(b, i, end) != 0) return 1;
    }
    return 0;
}

static sfield_result sfield__build_batch(sfield__build *b, uint32_t group)
{
    size_t step = b->what == SFIELD__VIEWS ? (size_t)SFIELD__MOST_VIEWS : b->count;
    for (b->from = 0; b->from < b->count; b->from = b->to) {
        b->to = b->count - b->from < step ? b->count : b->from + step;
        if (b->what == SFIELD__VIEWS && sfield__ask_batch(b) != 0) return SFIELD_ERR_CANCELLED;
        sfield__run_tasks(b, sfield__build_task);
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (b->h.basis == SFIELD_BASIS_HAAR) return sfield__append_wavelets(b, b->first);
#endif
    if (b->what != SFIELD__SELF) sfield__quantise(b, b->first, group);
    return SFIELD_OK;
}
