/* ---- csm: lights as they stand in a table ---- */

/* Writes a texel of four floats. */
static void glbk__csm_put(uint32_t *words, uint32_t texel, glbk_csm__v3 v, float w)
{
    float f[4];
    glbk_csm__v3_store(f, v);
    f[3] = w;
    memcpy(words + 4 * (size_t)texel, f, sizeof f);
}

/* Makes running sums, divided by the total, of `count` weights that stand in w of the texels at `sums`, and
   writes for each fraction i / count of the total where a search for it begins and ends. Returns the sum of
   the weights. */
static double glbk__csm_sums(uint32_t *sums, uint32_t count, double total)
{
    double sum = 0;
    float before, after = 0, weight;
    uint32_t i, lo = 0;

    for (i = 0; i < count; i++) {
        memcpy(&weight, sums + 4 * (size_t)i + 3, 4);
        sum += (double)weight;
        before = after;
        after = total > 0 ? i + 1 < count ? (float)(sum / total) : 1.0f : 0.0f;
        memcpy(sums + 4 * (size_t)i, &before, 4);
        memcpy(sums + 4 * (size_t)i + 1, &after, 4);
    }
    for (i = 0; i < count; i++) {
        memcpy(&after, sums + 4 * (size_t)lo + 1, 4);
        while (lo + 1 < count && (double)after <= (double)i / count) {
            lo++;
            memcpy(&after, sums + 4 * (size_t)lo + 1, 4);
        }
        sums[4 * (size_t)i + 2] = lo;
        sums[4 * (size_t)i + 3] = count;
        if (i) sums[4 * (size_t)i - 1] = lo + 1;
    }
    return sum;
}

/* The two frames of a video between which desc->time lies, as lightsampling.h has them. */
typedef struct glbk__csm_film {
    const float *first;
    const float *second;
    float        blend;             /* share of the second, 0..1 */
} glbk__csm_film;

static glbk__csm_film glbk__csm_film_of(const lsamp_light_desc *d)
{
    const uint32_t frames = d->frame_count ? d->frame_count : 1;
    const size_t count = 3 * (size_t)d->width * d->height;
    double t = (double)d->time * (d->frames_per_second > 0 ? (double)d->frames_per_second : 30.0);
    glbk__csm_film film;
    uint32_t at;

    if (d->loop) t -= floor(t / frames) * frames;
    t = t > 0 ? t : 0;
    if (!d->loop && t > frames - 1.0) t = frames - 1.0;
    at = t < frames ? (uint32_t)t : 0;
    film.blend = t < frames ? (float)(t - at) : 0;
    film.first = d->texels + at * count;
    film.second = d->texels + (at + 1) % frames * count;
    return film;
}

/* Returns number i of the frame that is blended of the two; what is not finite or negative counts as 0. */
static float glbk__csm_film_at(const glbk__csm_film *film, size_t i)
{
    float a = film->first[i], b = film->blend > 0 ? film->second[i] : 0;
    a = glbk_csm__finite(a) && a > 0 ? a : 0;
    b = glbk_csm__finite(b) && b > 0 ? b : 0;
    return a * (1 - film->blend) + b * film->blend;
}

/* Returns the density of samples of texel x, y of those that stand in a table, but for a factor that all have
   in common: tint times the mean of L over the texel. Where L is linear between centres, that mean is
   (a + 6 b + c) / 8 along each coordinate, as in lightsampling.h. */
static float glbk__csm_density(const uint32_t *texels, uint32_t flags, const uint32_t side[2], uint32_t x,
                               uint32_t y, glbk_csm__v3 tint)
{
    static const float weights[2][3] = { { 0, 1, 0 }, { 0.125f, 0.75f, 0.125f } };
    const float *weight = weights[(flags & GLBK__CSM_LINEAR) != 0];
    const uint32_t w = side[0];
    float sum = 0, rgb[3];
    uint32_t i, j, column, row;

    for (j = 0; j < 3; j++)
        for (i = 0; i < 3; i++) {
            column = x + i ? x + i - 1 : flags & GLBK__CSM_ROUND ? w - 1 : 0;
            if (column == w) column = flags & GLBK__CSM_ROUND ? 0 : x;
            row = y + j ? y + j - 1 : 0;
            if (row == side[1]) row = y;
            memcpy(rgb, texels + 4 * ((size_t)row * w + column), sizeof rgb);
            sum += glbk_csm__v3_dot(glbk_csm__v3_load(rgb), tint) * weight[i] * weight[j];
        }
    return sum;
}

/* Writes the texels of L, with their densities in w, and the running sums of each row and of all rows. */
static void glbk__csm_texture(const lsamp_light_desc *d, uint32_t flags, uint32_t *words, uint32_t w,
                              uint32_t h)
{
    const uint32_t side[2] = { w, h };
    const glbk__csm_film none = { NULL, NULL, 0 }, film = d->texels ? glbk__csm_film_of(d) : none;
    uint32_t *texels = words + 4 * GLBK__CSM_LIGHT_HEAD, *rows = texels + 4 * (size_t)w * h;
    uint32_t *row, x, y;
    float top = d->radiance[0] > d->radiance[1] ? d->radiance[0] : d->radiance[1], value;
    glbk_csm__v3 tint = glbk_csm__v3_make(1, 1, 1);
    double total = 0, sum, weight;
    size_t i;

    top = top > d->radiance[2] ? top : d->radiance[2];
    if (top > 0) tint = glbk_csm__v3_make(d->radiance[0] / top, d->radiance[1] / top, d->radiance[2] / top);
    tint = glbk_csm__v3_scale(tint, 1.0f / 3.0f);
    for (i = 0; i < 3 * (size_t)w * h; i++) {
        value = d->texels ? glbk__csm_film_at(&film, i) : 1;
        memcpy(texels + i / 3 * 4 + i % 3, &value, 4);
    }
    for (y = 0; y < h; y++) {
        row = rows + 4 * ((size_t)h + (size_t)y * w);
        sum = 0;
        for (x = 0; x < w; x++) {
            value = glbk__csm_density(texels, flags, side, x, y, tint);
            memcpy(texels + 4 * ((size_t)y * w + x) + 3, &value, 4);
            memcpy(row + 4 * (size_t)x + 3, &value, 4);
            sum += (double)value;
        }
        glbk__csm_sums(row, w, sum);
        /* The weight of a row of the sky is its solid angle, cos a - cos b, here without a loss of digits. */
        weight = glbk__csm_is_sky(d)
                     ? 2 * sin(GLBK__PI * (2.0 * y + 1) / (2.0 * h)) * sin(GLBK__PI / (2.0 * h))
                     : 1;
        value = (float)(sum * weight);
        memcpy(rows + 4 * (size_t)y + 3, &value, 4);
        total += (double)value;
    }
    glbk__csm_sums(rows, h, total);
    if (!(total > 0)) return;                   /* a black light: all densities are 0 already */
    weight = glbk__csm_is_sky(d) ? w / (2 * GLBK__PI * total) : (double)w * h / total;
    for (i = 0; i < (size_t)w * h; i++) {
        memcpy(&value, texels + 4 * i + 3, 4);
        value *= (float)weight;
        memcpy(texels + 4 * i + 3, &value, 4);
    }
}

/* Writes the corners of all triangles, and the share of all area up to the end of each. Returns the area.
   Triangles that are not finite or have no area get no share. */
static float glbk__csm_triangles(const lsamp_mesh *m, uint32_t *texels)
{
    const uint32_t count = (uint32_t)(glbk__csm_corner_count(m) / 3);
    double total = 0, sum = 0;
    uint32_t i, pass;

    for (pass = 0; pass < 2; pass++)
        for (i = 0; i < count; i++) {
            glbk_csm__v3 a = glbk__csm_corner(m, 3 * (size_t)i), b = glbk__csm_corner(m, 3 * (size_t)i + 1);
            glbk_csm__v3 c = glbk__csm_corner(m, 3 * (size_t)i + 2);
            glbk_csm__v3 twice = glbk_csm__v3_cross(glbk_csm__v3_sub(b, a), glbk_csm__v3_sub(c, a));
            double area = 0.5 * (double)glbk_csm__v3_length(twice);
            if (!(area > 0 && area < 1e30)) area = 0;
            if (!pass) {
                total += area;
                continue;
            }
            sum += area;
            glbk__csm_put(texels, 3 * i, a, (float)(sum / total));
            glbk__csm_put(texels, 3 * i + 1, b, 0);
            glbk__csm_put(texels, 3 * i + 2, c, 0);
        }
    return (float)total;
}

/* Writes the points of a surface. */
static void glbk__csm_surface(const lsamp_surface *s, uint32_t *texels)
{
    uint32_t i;
    for (i = 0; i < s->width * s->height; i++)
        glbk__csm_put(texels, i, glbk_csm__v3_load(s->points + 3 * (size_t)i), 0);
}

/* What follows the first two texels of a light, as docs/gpu-layouts.md says. */
typedef struct glbk__csm_light_head {
    float position[3], radius;
    float n[3], lx;
    float ex[3], ly;
    float ey[3], area;
    float radiance[3], cos_cone;
    float none[3], turn;
    float u[3], cosine_power;
    float v[4];
} glbk__csm_light_head;

/* Writes what the shape of a light says to its head, and returns whether it is a rectangle with right
   angles. */
static int glbk__csm_shape_write(const lsamp_light_desc *d, glbk__csm_light_head *out)
{
    const glbk_csm__v3 u = glbk_csm__v3_load(d->u), v = glbk_csm__v3_load(d->v);
    glbk_csm__v3 n = glbk_csm__v3_load(d->direction), x = glbk_csm__v3_make(0, 0, 0), y = x;
    float uv, area = 1;

    if (d->kind == LSAMP_LIGHT_LINE) n = u;
    if (d->kind == LSAMP_LIGHT_RECTANGLE) n = glbk_csm__v3_cross(u, v);
    uv = glbk_csm__v3_length(n);
    n = glbk_csm__v3_normalize(n);
    out->lx = glbk_csm__v3_length(u);
    out->ly = glbk_csm__v3_length(v);
    if (d->kind == LSAMP_LIGHT_DISC) glbk_csm__v3_basis(n, &x, &y);
    if (d->kind == LSAMP_LIGHT_DISC || d->kind == LSAMP_LIGHT_SPHERE)
        area = (d->kind == LSAMP_LIGHT_DISC ? 1 : 4) * (float)GLBK__PI * d->radius * d->radius;
    if (d->kind == LSAMP_LIGHT_RECTANGLE) {
        area = uv;
        x = glbk_csm__v3_scale(glbk_csm__v3_cross(v, n), 1.0f / area);
        y = glbk_csm__v3_scale(glbk_csm__v3_cross(n, u), 1.0f / area);
    }
    glbk_csm__v3_store(out->n, n);
    glbk_csm__v3_store(out->ex, x);
    glbk_csm__v3_store(out->ey, y);
    out->area = area;
    uv = glbk_csm__v3_dot(u, v);
    return d->kind == LSAMP_LIGHT_RECTANGLE && (uv < 0 ? -uv : uv) <= 1e-5f * area;
}

/* Writes a light that is valid. */
static glbk_result glbk__csm_light_write(const glbk__csm_logger *log, const lsamp_light_desc *d,
                                         uint32_t *words)
{
    const int sky = glbk__csm_is_sky(d);
    const uint32_t w = d->texels ? d->width : 1, h = d->texels ? d->height : 1;
    glbk__csm_light_head head;
    uint32_t flags;

    memset(&head, 0, sizeof head);
    flags = glbk__csm_shape_write(d, &head) ? GLBK__CSM_ORTHOGONAL : 0;
    if (d->filter == LSAMP_TEXELS_LINEAR) flags |= GLBK__CSM_LINEAR;
    if (sky || d->kind == LSAMP_LIGHT_SPHERE) flags |= GLBK__CSM_ROUND;
    if (d->emission_fn) flags |= GLBK__CSM_OWN_EMISSION;
    if (d->texels || sky) flags |= GLBK__CSM_TEXTURED;
    words[4] = words[6] = GLBK__CSM_LIGHT_HEAD;
    words[5] = GLBK__CSM_LIGHT_HEAD + w * h;
    words[7] = 0;
    if (d->kind == LSAMP_LIGHT_SURFACE) {
        if (d->surface->round) flags |= GLBK__CSM_ROUND | GLBK__CSM_ROUND_SURFACE;
        if (d->texels) words[6] = words[5] + w * h + h;
        words[7] = d->surface->width | d->surface->height << 16;
        glbk__csm_surface(d->surface, words + 4 * (size_t)words[6]);
    }
    if (flags & GLBK__CSM_TEXTURED) glbk__csm_texture(d, flags, words, w, h);
    if (d->kind == LSAMP_LIGHT_MESH) {
        head.area = glbk__csm_triangles(d->mesh, words + 4 * GLBK__CSM_LIGHT_HEAD);
        words[7] = (uint32_t)(glbk__csm_corner_count(d->mesh) / 3);
    }
    if (!(head.area > 0)) {
        (void)glbk__csm_refuse(log, ".mesh", "has no area");
        return GLBK_ERR_INPUT;
    }
    words[0] = sky ? (uint32_t)LSAMP_LIGHT_ENVIRONMENT : (uint32_t)d->kind;
    words[1] = w;
    words[2] = h;
    words[3] = flags;
    memcpy(head.position, d->position, sizeof head.position);
    memcpy(head.radiance, d->radiance, sizeof head.radiance);
    memcpy(head.u, d->u, sizeof head.u);
    memcpy(head.v, d->v, sizeof d->v);
    head.radius = d->radius;
    head.cos_cone = (float)cos((double)d->cone_half_angle);
    head.turn = (float)((double)d->rotation / (2 * GLBK__PI));
    head.cosine_power = d->cosine_power;
    memcpy(words + 8, &head, sizeof head);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_light_write(const lsamp_light_desc *d, uint32_t *words)
{
    glbk_context none;
    glbk__csm_logger log;
    size_t texels;
    glbk_result result;
    if (!d) return GLBK_ERR_ARGUMENT;
    memset(&none, 0, sizeof none);
    none.system.log = d->system.log;
    none.system.user = d->system.user;
    if (!words) return glbk__require(&none, __func__, "words", words);
    log = glbk__csm_logger_make(&none, __func__, "desc", GLBK__NO_INDEX);
    result = glbk__csm_count_texels(&log, d, 1, &texels);
    return result == GLBK_OK ? glbk__csm_light_write(&log, d, words) : result;
}

/* Writes two texels for each lobe. */
static void glbk__csm_write_lobes(const glbk_csm_lights_desc *d, uint32_t *words)
{
    uint32_t i;
    for (i = 0; i < d->lobe_count; i++) {
        glbk__csm_put(words, 2 * i, glbk_csm__v3_load(d->lobes[i].axis), d->lobes[i].exponent);
        glbk__csm_put(words, 2 * i + 1, glbk_csm__v3_load(d->lobes[i].scale), 0);
    }
}

/* Checks what glbk_csm_lights_create is given, except the lights themselves. */
static glbk_result glbk__csm_check_lights(const glbk_context *ctx, const glbk_csm_lights_desc *d,
                                          const uint32_t *starts)
{
    static const char function[] = "glbk_csm_lights_create";
    glbk_result result = glbk__require(ctx, function, "desc", d);
    if (result == GLBK_OK && d->light_count) result = glbk__require(ctx, function, "starts", starts);
    if (result != GLBK_OK) return result;
    if (d->light_count && !d->lights)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.lights", "is NULL");
    if (d->lobe_count && !d->lobes)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.lobes", "is NULL");
    if (d->lobe_count > (uint32_t)1 << 20)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.lobe_count", d->lobe_count, 0, 1048576);
    if ((d->patterns != NULL) != (d->pattern_length != 0) || d->pattern_length > 65536)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.pattern_length", d->pattern_length,
                                  "1..65536 with patterns, 0 without");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const glbk_csm_lights_desc *d,
                                            uint32_t *starts, glbk_csm_lights *out)
{
    glbk_csm__allocator memory;
    glbk__csm_logger log;
    size_t texels, one, patterns;
    uint32_t i, *words;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__csm_check_lights(ctx, d, starts);
    if (result != GLBK_OK) return result;
    log = glbk__csm_logger_make(ctx, __func__, "desc.lights", 0);
    texels = 2 * (size_t)d->lobe_count;
    patterns = 128 * (size_t)d->pattern_length;
    for (i = 0; i < d->light_count; i++) {
        log.index = i;
        result = glbk__csm_count_texels(&log, &d->lights[i], d->own, &one);
        if (result != GLBK_OK) return result;
        starts[i] = (uint32_t)texels;
        texels += one;
        if (texels > (size_t)1 << 28)
            return glbk__refuse_element_value(ctx, GLBK_ERR_LIMIT, __func__, "desc.lights", i,
                                              " and those before: their texels", (double)texels,
                                              "at most 2^28");
    }
    out->lobe_count = d->lobe_count;
    out->own = d->own;
    out->patterns_at = (uint32_t)texels;
    out->pattern_length = d->pattern_length;
    texels += patterns + 1;
    memory = glbk_csm__memory(ctx);
    words = (uint32_t *)glbk_csm__alloc_array(&memory, texels, 16);
    if (!words) result = GLBK_ERR_ALLOC;
    else {
        memset(words, 0, texels * 16);
        glbk__csm_write_lobes(d, words);
        for (i = 0; i < d->light_count && result == GLBK_OK; i++) {
            log.index = i;
            result = glbk__csm_light_write(&log, &d->lights[i], words + 4 * (size_t)starts[i]);
        }
        if (patterns) memcpy(words + 4 * (size_t)out->patterns_at, d->patterns, patterns * 16);
    }
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, words, texels, &out->texels);
    glbk_csm__free(&memory, words);
    if (result != GLBK_OK) memset(out, 0, sizeof *out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const lsamp_light_desc *desc)
{
    glbk_csm__allocator memory;
    glbk__csm_logger log;
    size_t texels;
    uint32_t *words;
    glbk_result result;

    result = glbk__require_created(ctx, __func__, "lights", lights ? &lights->texels.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", desc);
    if (result != GLBK_OK) return result;
    log = glbk__csm_logger_make(ctx, __func__, "desc", GLBK__NO_INDEX);
    result = glbk__csm_count_texels(&log, desc, lights->own, &texels);
    if (result != GLBK_OK) return result;
    if (start < 2 * lights->lobe_count || start > lights->patterns_at || texels > lights->patterns_at - start)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, __func__, "start", start,
                                  "that of a light with as many texels");
    memory = glbk_csm__memory(ctx);
    words = (uint32_t *)glbk_csm__alloc_array(&memory, texels, 16);
    if (!words) return GLBK_ERR_ALLOC;
    result = glbk__csm_light_write(&log, desc, words);
    if (result == GLBK_OK) result = glbk__table_update(ctx, &lights->texels, start, texels, words);
    glbk_csm__free(&memory, words);
    return result;
}

GLBK_DEF void glbk_csm_lights_free(glbk_context *ctx, glbk_csm_lights *lights)
{
    if (!lights) return;
    glbk_texture_free(ctx, &lights->texels);
    memset(lights, 0, sizeof *lights);
}
