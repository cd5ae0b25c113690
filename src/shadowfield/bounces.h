/* ---- one interreflection between bodies ---- */

#ifndef SFIELD_WITHOUT_BUILD
/* The light that a diffuse body sends on is a sum over patches: how bright each is now, times what it would
   radiate into the space around with a radiance of 1. What it would radiate is kept in source fields, three
   patches to a frame and one to a channel. */

enum { SFIELD__PATCH_POINTS = 4, SFIELD__MOST_PATCHES = 192 };

struct sfield_bounce {
    sfield__allocator allocator;
    sfield_field *transport, *source;
    uint32_t patches;
    float   *albedo;                            /* of each patch, 3 floats. What follows lies behind it */
    float   *positions, *normals;               /* of its points */
    float   *light, *values;                    /* radiance of each patch; a shell's coefficients */
};

typedef struct sfield__facet {                  /* a triangle */
    double area, feature[6];                    /* normal; middle, in r. What looks alike is near */
    uint32_t patch;
} sfield__facet;

/* Writes the corners of a triangle. Returns the greatest of their coordinates without its sign; a negative
   number if a build leaves the triangle out since they are not finite, or too far away. */
static float sfield__facet_corners(const sfield_mesh *mesh, size_t t, sfield__v3 *v)
{
    const size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    float most = 0;
    uint32_t k, i;
    for (k = 0; k < 3; k++) {
        const float *p = sfield__vertex(mesh, stride, sfield__mesh_index(mesh, 3 * t + k));
        for (i = 0; i < 3; i++) {
            if (!sfield__finite(p[i]) || !(fabsf(p[i]) < 1e18f)) return -1;
            most = fabsf(p[i]) > most ? fabsf(p[i]) : most;
        }
        v[k] = sfield__v3_load(p);
    }
    return most;
}

/* Reads a triangle. Returns its area, 0 if it cannot be used. */
static double sfield__read_facet(const sfield_mesh *mesh, size_t t, float r, sfield__facet *out)
{
    sfield__v3 v[3], n, middle;
    double size;
    uint32_t k;
    memset(out, 0, sizeof *out);
    if (sfield__facet_corners(mesh, t, v) < 0) return 0;
    for (k = 0; k < 3; k++) v[k] = sfield__v3_scale(v[k], 1 / r);
    n = sfield__v3_cross(sfield__v3_sub(v[1], v[0]), sfield__v3_sub(v[2], v[0]));
    size = sqrt((double)sfield__v3_dot(n, n));
    if (!(size > 0)) return 0;
    middle = sfield__v3_scale(sfield__v3_add(sfield__v3_add(v[0], v[1]), v[2]), 1 / 3.0f);
    out->feature[0] = (double)n.x / size;
    out->feature[1] = (double)n.y / size;
    out->feature[2] = (double)n.z / size;
    out->feature[3] = (double)middle.x;
    out->feature[4] = (double)middle.y;
    out->feature[5] = (double)middle.z;
    out->area = 0.5 * size;
    return out->area;
}

/* Returns the spread of a patch along a feature: the sum of squares off the mean, which is written. */
static double sfield__spread_of(const sfield__facet *facets, size_t count, uint32_t patch, uint32_t feature,
                                double *mean)
{
    double area = 0, sum = 0, squares = 0;
    size_t i;
    for (i = 0; i < count; i++) {
        if (facets[i].patch != patch) continue;
        area += facets[i].area;
        sum += facets[i].area * facets[i].feature[feature];
    }
    *mean = area > 0 ? sum / area : 0;
    for (i = 0; i < count; i++)
        if (facets[i].patch == patch)
            squares += facets[i].area * (facets[i].feature[feature] - *mean) *
                       (facets[i].feature[feature] - *mean);
    return squares;
}

/* Cuts the surface: of all patches the one that is spread most, at its mean, again and again. Returns how
   many there are. */
static uint32_t sfield__cut_patches(sfield__facet *facets, size_t count, uint32_t most)
{
    double spread[SFIELD__MOST_PATCHES], mean[SFIELD__MOST_PATCHES], all = 0;
    uint32_t along[SFIELD__MOST_PATCHES], patches = 1, last = 0;
    uint32_t p, k, worst;
    size_t i;
    for (;;) {
        for (p = 0; p < patches; p++) {         /* of those that were just cut */
            if (p != last && p + 1 != patches) continue;
            spread[p] = -1;
            for (k = 0; k < 6; k++) {
                double at;
                const double s = sfield__spread_of(facets, count, p, k, &at);
                if (!(s > spread[p])) continue;
                spread[p] = s;
                mean[p] = at;
                along[p] = k;
            }
        }
        all = patches == 1 ? spread[0] : all;
        for (p = worst = 0; p < patches; p++) worst = spread[p] > spread[worst] ? p : worst;
        if (patches == most || !(spread[worst] > 1e-9 * all)) return patches;
        for (i = 0; i < count; i++)
            if (facets[i].patch == worst && facets[i].feature[along[worst]] > mean[worst])
                facets[i].patch = patches;
        last = worst;
        patches++;
    }
}

/* Fills in albedos and points, which lie in the middles of triangles, evenly by area. */
static void sfield__place_patches(sfield_bounce *b, const sfield__facet *facets, size_t count,
                                  const float *albedo, float r)
{
    const double points = SFIELD__PATCH_POINTS;
    uint32_t p, k, c;
    size_t i;
    for (p = 0; p < b->patches; p++) {
        double area = 0, before = 0, sum[3] = { 0, 0, 0 };
        for (i = 0; i < count; i++)
            for (c = 0; c < 3 && facets[i].patch == p; c++) {
                area += c ? 0 : facets[i].area;
                sum[c] += facets[i].area * (double)albedo[3 * i + c];
            }
        for (c = 0; c < 3; c++) b->albedo[3 * p + c] = (float)(sum[c] / area);
        for (i = 0, k = 0; i < count; i++) {
            if (facets[i].patch != p || !(facets[i].area > 0)) continue;
            before += facets[i].area;
            /* point k goes where (k + 0.5) / 4 of the area are reached */
            for (; k < SFIELD__PATCH_POINTS && ((double)k + 0.5) * area < points * before; k++)
                for (c = 0; c < 3; c++) {
                    const size_t at = 3 * ((size_t)p * SFIELD__PATCH_POINTS + k) + c;
                    b->positions[at] = (float)(facets[i].feature[3 + c] * (double)r);
                    b->normals[at] = (float)facets[i].feature[c];
                }
        }
    }
}

static sfield_result sfield__fail_memory(const sfield__logger *log)
{
    return sfield__fail(log, SFIELD_ERR_ALLOC, "desc.system.allocator", "returned no memory");
}

/* Builds the source fields of all patches as one whose frames they are. */
static sfield_result sfield__build_transport(sfield_bounce *b, const sfield_desc *desc,
                                             const sfield_mesh *mesh, const sfield__facet *facets,
                                             size_t count, const sfield__logger *log)
{
    const uint32_t frames = (b->patches + 2) / 3;
    sfield_desc d = *desc;
    sfield_result result;
    float *radiance;
    size_t i, cells;
    d.frame_count = frames;
    d.frames_per_second = 1;
    d.loop = 0;
    d.shard_begin = d.shard_end = 0;
    radiance = sfield__mul_size(count, frames, &cells)
                   ? (float *)sfield__alloc_array(&b->allocator, cells, 3 * sizeof *radiance)
                   : NULL;
    if (!radiance) return sfield__fail_memory(log);
    memset(radiance, 0, 3 * cells * sizeof *radiance);
    for (i = 0; i < count; i++)
        radiance[3 * (facets[i].patch / 3 * count + i) + facets[i].patch % 3] = facets[i].area > 0 ? 1.0f : 0;
    result = sfield_build_emissive(&d, mesh, radiance, &b->transport, NULL);
    sfield__free(&b->allocator, radiance);
    return result;
}

/* Allocates the source of the body, which is like one frame of b->transport, and the coefficients of a shell,
   in which sfield__mix_patches adds up the patches. */
static sfield_result sfield__make_room(sfield_bounce *b, const sfield__logger *log)
{
    const size_t samples = 6 * (size_t)b->transport->h.position_side * b->transport->h.position_side;
    sfield__header h = b->transport->h;
    h.samples /= h.frames;
    h.frames = 1;
    b->values = (float *)sfield__alloc_array(&b->allocator, samples * h.stride, sizeof *b->values);
    if (!b->values || sfield__alloc_field(&b->allocator, log, &h, &b->source) != SFIELD_OK)
        return sfield__fail_memory(log);
    memset(b->light, 0, 3 * b->patches * sizeof *b->light);
    memcpy(b->source->words + SFIELD__HEADER, b->transport->radii, h.shells * sizeof *b->transport->radii);
    sfield__bind_shells(b->source);
    return SFIELD_OK;
}

/* Adds up the patches of a shell, each as bright as it is. */
static void sfield__mix_patches(const sfield_bounce *b, uint32_t shell, size_t samples)
{
    const sfield_field *f = b->transport;
    const uint32_t planes = f->planes, stride = f->h.stride, side = f->h.shells;
    uint32_t p, c, k;
    size_t i;
    memset(b->values, 0, samples * stride * sizeof *b->values);
    for (p = 0; p < b->patches; p++) {
        const size_t group = (size_t)(p / 3) * side + shell;
        const float *scale = f->scale + group * stride + p % 3 * planes;
        const float *bias = f->bias + group * stride + p % 3 * planes;
        const uint8_t *q = f->sample + group * samples * stride + p % 3 * planes;
        float *out = b->values, x[SFIELD_MAX_COEFS];
        for (i = 0; i < samples; i++, q += stride, out += stride) {
            for (k = 0; k < planes; k++) x[k] = scale[k] * (float)q[k] + bias[k];
            for (c = 0; c < 3; c++)
                for (k = 0; k < planes; k++) out[c * planes + k] += b->light[3 * p + c] * x[k];
        }
    }
}

/* Writes the source field by the light of the patches. */
static void sfield__fill_source(sfield_bounce *b)
{
    const size_t samples = 6 * (size_t)b->source->h.position_side * b->source->h.position_side;
    const sfield__part silent = { NULL, NULL, 0, 1 };
    sfield__build build;
    uint32_t shell;
    memset(&build, 0, sizeof build);
    build.h = b->source->h;
    build.out = b->source;
    build.value = b->values;
    build.count = samples;
    for (shell = 0; shell < b->source->h.shells; shell++) {
        sfield__mix_patches(b, shell, samples);
        sfield__quantise(&build, shell * samples, shell);
    }
    (void)sfield__seal_block(b->source, &silent);
}

/* Allocates the patches, once it is known how many there are. */
static sfield_result sfield__make_patches(sfield_bounce *b, const sfield__logger *log)
{
    const size_t points = (size_t)b->patches * SFIELD__PATCH_POINTS;
    b->albedo = (float *)sfield__alloc_array(&b->allocator, 6 * points + 6 * (size_t)b->patches,
                                             sizeof *b->albedo);
    if (!b->albedo) return sfield__fail_memory(log);
    b->light = b->albedo + 3 * (size_t)b->patches;
    b->positions = b->light + 3 * (size_t)b->patches;
    b->normals = b->positions + 3 * points;
    return SFIELD_OK;
}

static sfield_result sfield__fill_bounce(sfield_bounce *b, const sfield_desc *desc, const sfield_mesh *mesh,
                                         const float *albedo, uint32_t patch_count,
                                         const sfield__logger *log)
{
    const size_t count = sfield__mesh_corners(mesh) / 3;
    float r = 0;
    double area = 0;
    sfield_result result = SFIELD_OK;
    sfield__facet *facets =
        (sfield__facet *)sfield__alloc_array(&b->allocator, count, sizeof *facets);
    size_t i;
    if (!facets) return sfield__fail_memory(log);
    for (i = 0; i < count; i++) {       /* vertices that no triangle has do not count */
        sfield__v3 v[3];
        const float most = sfield__facet_corners(mesh, i, v);
        r = most > r ? most : r;
    }
    r = r > 1e-18f ? r : 1.0f;
    for (i = 0; i < count; i++) area += sfield__read_facet(mesh, i, r, &facets[i]);
    if (!(area > 0)) result = sfield__fail(log, SFIELD_ERR_INPUT, "mesh", "has no triangle with an area");
    if (result == SFIELD_OK) {
        b->patches = sfield__cut_patches(facets, count, patch_count);
        result = sfield__make_patches(b, log);
    }
    if (result == SFIELD_OK) {
        sfield__place_patches(b, facets, count, albedo, r);
        result = sfield__build_transport(b, desc, mesh, facets, count, log);
    }
    if (result == SFIELD_OK) result = sfield__make_room(b, log);
    if (result == SFIELD_OK) sfield__fill_source(b);
    sfield__free(&b->allocator, facets);
    return result;
}

/* Checks what sfield_build_emissive does not, or too late. */
static sfield_result sfield__check_bounce(const sfield__logger *log, const sfield_desc *d,
                                          const sfield_mesh *mesh, const float *albedo, uint32_t patch_count)
{
    sfield__build b;
    sfield_result result;
    size_t i;
    if (!sfield__check_value(log, patch_count <= SFIELD__MOST_PATCHES, "patch_count", patch_count, "0..192"))
        return SFIELD_ERR_ARGUMENT;
    if (d->basis == SFIELD_BASIS_HAAR)
        return sfield__fail(log, SFIELD_ERR_DESC, "desc.basis", "is of wavelets");
    result = sfield__read_desc(&b, d, SFIELD__KIND_SOURCE, log->function);
    if (result == SFIELD_OK) result = sfield__check_mesh(&b, mesh);
    for (i = 0; result == SFIELD_OK && i < sfield__mesh_corners(mesh); i++)
        if (!sfield__in(albedo[i], 0, 1)) {
            sfield__log_element(log, "albedo", i, "is", (double)albedo[i], "0..1");
            return SFIELD_ERR_INPUT;
        }
    return result;
}

SFIELD_DEF sfield_result sfield_bounce_create(const sfield_desc *desc, const sfield_mesh *mesh,
                                              const float *albedo, uint32_t patch_count, sfield_bounce **out)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_bounce_create");
    sfield__allocator a;
    sfield_desc d;
    sfield_bounce *b;
    sfield_result result;
    if (!mesh || !albedo || !out) return sfield__fail_null(&log, !mesh ? "mesh" : !albedo ? "albedo" : "out");
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    result = sfield__check_bounce(&log, &d, mesh, albedo, patch_count);
    if (result != SFIELD_OK) return result;
    a = sfield__allocator_of(&d.system);
    b = (sfield_bounce *)sfield__alloc(&a, sizeof *b);
    if (!b) return sfield__fail_memory(&log);
    memset(b, 0, sizeof *b);
    b->allocator = a;
    result = sfield__fill_bounce(b, &d, mesh, albedo, patch_count ? patch_count : 24, &log);
    if (result != SFIELD_OK) {
        sfield_bounce_free(b);
        return result;
    }
    *out = b;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_bounce_free(sfield_bounce *bounce)
{
    sfield__allocator a;
    if (!bounce) return;
    a = bounce->allocator;
    sfield_free(bounce->transport);
    sfield_free(bounce->source);
    sfield__free(&a, bounce->albedo);
    sfield__free(&a, bounce->values);
    sfield__free(&a, bounce);
}

SFIELD_DEF void sfield_bounce_points(const sfield_bounce *bounce, sfield_points *out)
{
    if (!bounce || !out) return;
    memset(out, 0, sizeof *out);
    out->count = (size_t)bounce->patches * SFIELD__PATCH_POINTS;
    out->positions = bounce->positions;
    out->normals = bounce->normals;
}

SFIELD_DEF sfield_result sfield_bounce_update(sfield_bounce *bounce, const float *rgb)
{
    uint32_t p, k, c;
    if (!bounce) return SFIELD_ERR_ARGUMENT;
    if (!rgb) {
        const sfield__logger log = sfield__logger_for(&bounce->source->log, "sfield_bounce_update");
        return sfield__fail_null(&log, "rgb");
    }
    for (p = 0; p < bounce->patches; p++)
        for (c = 0; c < 3; c++) {
            float sum = 0;
            for (k = 0; k < SFIELD__PATCH_POINTS; k++) {
                const float x = rgb[3 * ((size_t)p * SFIELD__PATCH_POINTS + k) + c];
                sum += sfield__finite(x) && x > 0 ? (x < 1e18f ? x : 1e18f) : 0;
            }
            bounce->light[3 * p + c] = bounce->albedo[3 * p + c] * sum / (float)SFIELD__PATCH_POINTS;
        }
    sfield__fill_source(bounce);
    return SFIELD_OK;
}

SFIELD_DEF const sfield_field *sfield_bounce_source(const sfield_bounce *bounce)
{
    return bounce ? bounce->source : NULL;
}
#endif
