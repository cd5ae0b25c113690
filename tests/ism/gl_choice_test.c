/* gl_choice_test - VPLs that glbk_ism_choose chooses against ism_choose for the same random numbers: prefix sums in
   closed form and against doubles; every VPL equal but where a step of the CDF lies within rounding, and those
   counted; a frame that asks GL for nothing. */
#define _POSIX_C_SOURCE 200809L
#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_ism.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "gl_count.h"
#include "gl_says.h"
#include "util.h"
#include "gl_util.h"

enum { MOST = 1200 * 80 };

/* A source of ism.h and its twin in a texture: faces of width x height texels, one above the other. */
typedef struct lit {
    uint32_t     width, height, faces;
    float        position[3 * MOST], normal[3 * MOST], flux[3 * MOST], area[MOST];
    ism_source   sources[4];
    glbk_texture texels;
} lit;

static lit lit_now;     /* large */

/* Faces are pieces of a wavy floor beside each other, some of whose texels have no flux. */
static lit *lit_make(uint32_t width, uint32_t height, uint32_t faces)
{
    lit *l = &lit_now;
    uint32_t seed = 7, x, y, f, k;
    memset(l, 0, sizeof *l);
    assert_true(width * height * faces <= MOST);
    l->width = width;
    l->height = height;
    l->faces = faces;
    for (f = 0; f < faces; f++)
        for (y = 0; y < height; y++)
            for (x = 0; x < width; x++) {
                const size_t i = ((size_t)f * height + y) * width + x;
                const float u = ((float)x + 0.5f) / (float)width, v = ((float)y + 0.5f) / (float)height;
                const float slope = 0.8f * cosf(8 * u), size = 1 / sqrtf(1 + slope * slope);
                l->position[3 * i] = u + 1.2f * (float)f;
                l->position[3 * i + 1] = 0.1f * sinf(8 * u) + (x > width / 2 ? 0.5f : 0);       /* and a step */
                l->position[3 * i + 2] = v;
                l->normal[3 * i] = -slope * size;
                l->normal[3 * i + 1] = size;
                l->area[i] = 1 / (float)(width * height);
                for (k = 0; k < 3; k++) l->flux[3 * i + k] = util_unit(&seed) * (0.01f + u * v);
                if (util_unit(&seed) < 0.3f || (y > 4 && y < 9)) memset(l->flux + 3 * i, 0, 12);
            }
    for (f = 0; f < faces; f++) {
        const size_t first = (size_t)f * width * height;
        l->sources[f].width = width;
        l->sources[f].height = height;
        l->sources[f].positions = l->position + 3 * first;
        l->sources[f].normals = l->normal + 3 * first;
        l->sources[f].fluxes = l->flux + 3 * first;
        l->sources[f].areas = l->area + first;
    }
    return l;
}

static void lit_upload(gl_test *t, lit *l)
{
    const size_t count = (size_t)l->width * l->height;
    float *texels = (float *)calloc(12 * count * l->faces, sizeof *texels);
    glbk_texture_desc d;
    size_t f, i;
    assert_non_null(texels);
    for (f = 0; f < l->faces; f++)
        for (i = 0; i < count; i++) {
            memcpy(texels + 4 * (3 * f * count + i), l->position + 3 * (f * count + i), 12);
            memcpy(texels + 4 * ((3 * f + 1) * count + i), l->normal + 3 * (f * count + i), 12);
            memcpy(texels + 4 * ((3 * f + 2) * count + i), l->flux + 3 * (f * count + i), 12);
            texels[4 * ((3 * f + 2) * count + i) + 3] = l->area[f * count + i];
        }
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA32UI;
    d.width = l->width;
    d.height = l->height;
    d.layers = 3 * l->faces;
    d.data = texels;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &l->texels));
    free(texels);
}

typedef struct chosen {
    ism_desc        desc;
    glbk_ism_maps   maps;
    glbk_ism_choice choice;
} chosen;

static ism_desc by_flux(uint32_t vpls)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls;
    d.surfel_count = 64;
    d.tile_side = 32;
    d.lazy_frames = 1;
    d.near_point_count = -1;
    d.window_rim = -1;
    d.importance = ISM_IMPORTANCE_FLUX;
    return d;
}

static void chosen_make(gl_test *t, const lit *l, const ism_desc *d, chosen *c)
{
    glbk_ism_choice_desc of;
    memset(&of, 0, sizeof of);
    of.width = l->width;
    of.height = l->height;
    of.face_count = l->faces;
    of.scattered = l->sources[0].scattered;
    c->desc = *d;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, d, &c->maps));
    assert_glbk(t, glbk_ism_choice_create(&t->gl, &c->maps, &of, &c->choice));
}

static void chosen_free(gl_test *t, chosen *c)
{
    glbk_ism_choice_free(&t->gl, &c->choice);
    glbk_ism_choice_free(&t->gl, &c->choice);
    glbk_ism_maps_free(&t->gl, &c->maps);
}

/* The floats of a channel that a picture holds as bits. */
static float *read_bits(gl_test *t, const glbk_target *target, uint32_t width, uint32_t height, size_t channel)
{
    const size_t count = (size_t)width * height;
    uint32_t *words = (uint32_t *)malloc(16 * count);
    float *out = (float *)malloc(4 * count);
    size_t i;
    assert_non_null(words);
    assert_non_null(out);
    assert_glbk(t, glbk_target_read(&t->gl, target, 0, 0, 0, width, height, words));
    for (i = 0; i < count; i++) memcpy(out + i, words + 4 * i + channel, 4);
    free(words);
    return out;
}

/* ---- prefix sums ---- */

/* Compares three levels of a line of `count` values: value(k) is what stands at k, stride apart in each picture. */
static double sums_off(float *const level[3], const uint32_t stride[3], const uint32_t first[3], const double *values,
                       uint32_t count)
{
    double before[3] = { 0, 0, 0 }, worst = 0;
    uint32_t k, n;
    for (k = 0; k < count; k++) {
        for (n = 0; n < 3; n++) {
            const uint32_t block = 1u << 5 * n;
            if (k % (32 * block) == 0) before[n] = 0;
            before[n] += values[k];
            if ((k + 1) % block == 0 || k + 1 == count) {
                const double is = (double)level[n][first[n] + k / block * stride[n]];
                worst = fmax(worst, fabs(is - before[n]) / fmax(before[n], 1e-30));
            }
        }
    }
    return worst;
}

static double all_sums_off(gl_test *t, const lit *l, const glbk_ism_choice *c, double *total)
{
    const uint32_t rows = l->height * l->faces;
    float *along[3], *down[3];
    double *values = (double *)malloc(sizeof(double) * (l->width > rows ? l->width : rows)), worst = 0;
    double *sums = (double *)calloc(rows, sizeof(double));
    uint32_t k, x, y;
    assert_non_null(values);
    assert_non_null(sums);
    for (k = 0; k < 3; k++) {
        along[k] = read_bits(t, &c->row_sums[k].target, c->row_sums[k].texture.width, rows, 1);
        down[k] = read_bits(t, &c->column_sums[k].target, 1, c->column_sums[k].texture.height, 1);
    }
    for (y = 0; y < rows; y++) {
        const uint32_t stride[3] = { 1, 1, 1 };
        uint32_t first[3];
        for (k = 0; k < 3; k++) first[k] = y * c->row_sums[k].texture.width;
        for (x = 0; x < l->width; x++) {
            values[x] = (double)ism__luminance(l->flux + 3 * ((size_t)y * l->width + x));
            sums[y] += values[x];
        }
        worst = fmax(worst, sums_off(along, stride, first, values, l->width));
    }
    {
        const uint32_t stride[3] = { 1, 1, 1 }, first[3] = { 0, 0, 0 };
        worst = fmax(worst, sums_off(down, stride, first, sums, rows));
    }
    *total = (double)down[2][c->column_sums[2].texture.height - 1];
    for (k = 0; k < 3; k++) {
        free(along[k]);
        free(down[k]);
    }
    free(values);
    free(sums);
    return worst;
}

static void sums_are_prefix_sums(void **state)
{
    GL_TEST(t, state)
    static const uint32_t sizes[][3] = { { 1, 1, 1 }, { 32, 32, 1 }, { 33, 31, 2 }, { 1100, 40, 2 } };
    const ism_desc d = by_flux(16);
    size_t k, i;
    for (k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        lit *l = lit_make(sizes[k][0], sizes[k][1], sizes[k][2]);
        const size_t count = (size_t)l->width * l->height * l->faces;
        double total = 0, wanted = 0, worst;
        chosen c;
        for (i = 0; i < 3 * count; i++) l->flux[i] = 0.25f;             /* closed form: every sum is a count / 4 */
        lit_upload(t, l);
        chosen_make(t, l, &d, &c);
        assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
        assert_true(all_sums_off(t, l, &c.choice, &total) == 0);
        assert_true(total == 0.25 * (double)count);
        chosen_free(t, &c);
        glbk_texture_free(&t->gl, &l->texels);
        l = lit_make(sizes[k][0], sizes[k][1], sizes[k][2]);            /* any numbers */
        for (i = 0; i < count; i++) wanted += (double)ism__luminance(l->flux + 3 * i);
        lit_upload(t, l);
        chosen_make(t, l, &d, &c);
        assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
        worst = all_sums_off(t, l, &c.choice, &total);
        printf("%u x %u x %u: sums differ by %.1e of themselves\n", sizes[k][0], sizes[k][1], sizes[k][2], worst);
        assert_true(worst < 1e-6);
        assert_true(fabs(total - wanted) <= 1e-6 * wanted);
        chosen_free(t, &c);
        glbk_texture_free(&t->gl, &l->texels);
    }
}

/* ---- VPLs ---- */

static float *read_table(gl_test *t, const glbk_ism_choice *c, uint32_t count)
{
    const uint32_t rows = (count + 255) / 256;
    float *table = (float *)malloc(16 * 1024 * (size_t)rows);
    assert_non_null(table);
    assert_glbk(t, glbk_target_read(&t->gl, &c->table_target, 0, 0, 0, 1024, rows, table));
    return table;
}

static double distance_of(const float *a, const float *b)
{
    double sum = 0;
    int k;
    for (k = 0; k < 3; k++) sum += ((double)a[k] - (double)b[k]) * ((double)a[k] - (double)b[k]);
    return sqrt(sum);
}

/* How near the numbers by which VPL i is chosen lie to a step of a CDF of exact sums, as a share of the whole. */
static double nearest_step(const lit *l, const float *weights, const ism_desc *d, uint32_t i, uint32_t index)
{
    const uint32_t rows = l->height * l->faces, key = d->unstable ? ism__hash_combine(d->seed, index) : d->seed;
    double total = 0, before = 0, nearest = 1, u = ((double)i + 0.5) / (double)d->vpl_count, sum = 0, v;
    uint32_t x, y, row = 0;
    double row_total = 0;
    const double count = (double)l->width * rows;
    size_t k;
    for (k = 0; k < (size_t)count; k++) total += (double)weights[k];
    if (d->unstable) u += (double)ism__to_unit(ism__hash_combine(key, 11));
    u -= floor(u);
    for (y = 0; y < rows; y++) {
        double own = 0;
        for (x = 0; x < l->width; x++) own += (double)weights[(size_t)y * l->width + x];
        nearest = fmin(nearest, fabs(before / total - u));
        if (before <= u * total) {
            row = y;
            row_total = own;
        }
        before += own;
    }
    v = (double)ism__to_unit(i * 2654435769u + ism__hash_combine(key, 12));
    for (x = 0; x < l->width; x++) {
        nearest = fmin(nearest, fabs(sum / row_total - v));
        sum += (double)weights[(size_t)row * l->width + x];
    }
    return nearest;
}

/* The importances that the passes drew, for whose factor of fluxes a test has to do the sums of both channels. */
static float *read_importances(gl_test *t, const lit *l, const chosen *c)
{
    const uint32_t rows = l->height * l->faces;
    const double share = c->desc.flux_share > 0 ? (double)c->desc.flux_share : 0.1;
    float *effects = read_bits(t, &c->choice.importances.target, l->width, rows, 0);
    float *fluxes = read_bits(t, &c->choice.importances.target, l->width, rows, 1);
    double effect = 0, flux = 0, least = 1;
    size_t i, count = (size_t)l->width * rows;
    for (i = 0; i < count; i++) {
        effect += (double)effects[i];
        flux += (double)fluxes[i];
    }
    if (effect > 0) least = effect / flux * share / (1 - 0.999 * share);
    for (i = 0; i < count; i++) effects[i] += (float)(least * (double)fluxes[i]);
    free(fluxes);
    return effects;
}

/* By how much steps of the CDF of rows, and of those within rows, differ between two sets of importances. */
static double steps_differ(const lit *l, const float *a, const float *b)
{
    const size_t rows = (size_t)l->height * l->faces;
    double total[2] = { 0, 0 }, before[2] = { 0, 0 }, worst = 0;
    size_t x, y, i;
    for (i = 0; i < rows * l->width; i++) {
        total[0] += (double)a[i];
        total[1] += (double)b[i];
    }
    for (y = 0; y < rows; y++) {
        double row[2] = { 0, 0 }, sum[2] = { 0, 0 };
        for (x = 0; x < l->width; x++) {
            row[0] += (double)a[y * l->width + x];
            row[1] += (double)b[y * l->width + x];
        }
        for (x = 0; x < l->width && row[0] > 0; x++) {
            sum[0] += (double)a[y * l->width + x];
            sum[1] += (double)b[y * l->width + x];
            worst = fmax(worst, fabs(sum[0] / row[0] - sum[1] / row[1]));
        }
        before[0] += row[0];
        before[1] += row[1];
        worst = fmax(worst, fabs(before[0] / total[0] - before[1] / total[1]));
    }
    return worst;
}

/* Compares the importances with those of ism_choose: the pixel of a receiver is now and then another one, where its
   place lies within rounding of a border. Returns the share of texels whose importance differs by more than 1e-4. */
static double compare_importances(const lit *l, const ism_maps *maps, const float *is, float *wanted)
{
    const size_t face = (size_t)l->width * l->height;
    size_t f, i, off = 0, used = 0, n;
    double worst = 0;
    for (f = 0; f < l->faces; f++) {
        memcpy(wanted + f * face, ism_importances(maps, f, &n), face * sizeof *wanted);
        assert_int_equal(n, face);
    }
    for (i = 0; i < face * l->faces; i++) {
        const double by = fabs((double)is[i] - (double)wanted[i]) / fmax((double)wanted[i], 1e-30);
        used += wanted[i] > 0;
        assert_true((is[i] > 0) == (wanted[i] > 0));
        if (wanted[i] > 0 && by > 1e-4) off++;
        else if (wanted[i] > 0) worst = fmax(worst, by);
    }
    printf("    %zu of %zu importances differ, the others by %.1e\n", off, used, worst);
    return (double)off / (double)used;
}

/* Compares the table with the VPLs of ism_choose. Returns how many stand elsewhere, each beside a step. */
static size_t compare_vpls(gl_test *t, const lit *l, const chosen *c, const ism_points *view, uint32_t index)
{
    ism_frame frame;
    ism_maps *maps;
    const ism_vpl *v;
    float *table = read_table(t, &c->choice, c->desc.vpl_count);
    double worst[5] = { 0, 0, 0, 0, 0 }, spacing = 1.0 / (double)l->width;
    float *weights = read_importances(t, l, c), *wanted = (float *)malloc(sizeof(float) * MOST);
    double slack;
    size_t n, i, elsewhere = 0;
    int k;
    assert_non_null(wanted);
    memset(&frame, 0, sizeof frame);
    frame.sources = l->sources;
    frame.source_count = l->faces;
    frame.points = view;
    frame.index = index;
    assert_int_equal(ism_create(&c->desc, &maps), ISM_OK);
    assert_int_equal(ism_choose(maps, &frame), ISM_OK);
    v = ism_vpls(maps, &n);
    assert_int_equal(n, c->desc.vpl_count);
    assert_int_equal(c->maps.vpl_count, n);
    assert_true(compare_importances(l, maps, weights, wanted) < 2e-2);
    slack = 2e-6 + steps_differ(l, weights, wanted);
    assert_true(slack < (c->desc.importance == ISM_IMPORTANCE_FLUX ? 3e-6 : 1e-3));
    for (i = 0; i < n; i++) {
        const float *g = table + 16 * i;
        const double off = distance_of(g, v[i].position) / spacing;
        assert_true(g[3] == 1 && g[11] == 0 && g[15] == 0);         /* diffuse, no near points, no window */
        assert_memory_equal(g + 4, g + 12, 12);
        if (off > 2e-2) {
            assert_true(nearest_step(l, wanted, &c->desc, (uint32_t)i, index) < slack);
            elsewhere++;
            continue;
        }
        worst[0] = fmax(worst[0], off);
        worst[1] = fmax(worst[1], distance_of(g + 4, v[i].normal));
        for (k = 0; k < 3; k++)
            worst[2] = fmax(worst[2], fabs((double)g[8 + k] - (double)v[i].flux[k]) / (double)v[i].flux[k]);
        worst[3] = fmax(worst[3], fabs((double)g[7] - (double)v[i].edge) / (double)v[i].edge);
    }
    printf("    %zu VPLs, %zu beside a step, %.1e; the others' places differ by %.1e texels, normals %.1e, "
           "fluxes %.1e, edges %.1e\n", n, elsewhere, slack, worst[0], worst[1], worst[2], worst[3]);
    assert_true(worst[1] < 1e-3);
    if (c->desc.importance == ISM_IMPORTANCE_FLUX) assert_true(worst[2] < 1e-5);
    if (!elsewhere) assert_true(worst[3] < 1e-3);
    ism_free(maps);
    free(table);
    free(weights);
    free(wanted);
    return elsewhere;
}

static void vpls_are_those_of_ism_choose(void **state)
{
    GL_TEST(t, state)
    static const uint32_t sizes[][4] = { { 64, 48, 2, 1024 }, { 45, 37, 1, 300 }, { 100, 24, 4, 1000 },
                                         { 512, 128, 1, 1024 }, { 1100, 40, 2, 256 } };
    static const float place[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
    static const float clip[16] = { 1.5f, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1, -1, 0, 0, 3, 4 };
    size_t k, elsewhere = 0, all = 0;
    int way;
    for (k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        for (way = 0; way < 5; way++) {
            lit *l = lit_make(sizes[k][0], sizes[k][1], sizes[k][2]);
            ism_desc d = by_flux(sizes[k][3]);
            ism_points view;
            glbk_gbuffer seen;
            chosen c;
            uint32_t f;
            memset(&view, 0, sizeof view);
            view.count = view.width = 1;
            view.positions = place;
            view.normals = down;
            d.seed = (uint32_t)(11 * k);
            d.no_inter_texel = way == 1;
            d.unstable = way == 2;
            for (f = 0; f < l->faces && way == 3; f++) l->sources[f].scattered = 1;
            for (f = 0; f < l->faces && way == 4; f++) l->sources[f].areas = NULL;      /* edges from distances */
            if (way == 4) memset(l->area, 0, sizeof l->area);
            gl_see(&t->gl, 1, 1, place, down, NULL, &seen);
            if (way == 0) {
                memcpy(view.world_to_clip, clip, sizeof clip);
                memcpy(seen.world_to_clip, clip, sizeof clip);
                seen.has_clip = 1;
            }
            lit_upload(t, l);
            chosen_make(t, l, &d, &c);
            assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, way ? NULL : &seen, 5));
            elsewhere += compare_vpls(t, l, &c, &view, 5);
            all += d.vpl_count;
            chosen_free(t, &c);
            glbk_gbuffer_free(&t->gl, &seen);
            glbk_texture_free(&t->gl, &l->texels);
        }
    printf("%zu of %zu VPLs were chosen on the other side of a step\n", elsewhere, all);
    assert_true((double)elsewhere < 2e-3 * (double)all);
}

/* By the picture: a wall and a floor of receivers, some pixels without any. */
static void vpls_by_the_picture_are_those_of_ism_choose(void **state)
{
    GL_TEST(t, state)
    enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT };
    static float places[3 * PIXELS], normals[3 * PIXELS];
    static const float clip[16] = { 1.5f, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1, -1, 0, -1, 3, 3 };
    size_t k, elsewhere = 0, all = 0;
    uint32_t seed = 3;
    int way;
    for (k = 0; k < PIXELS; k++) {
        const float u = (float)(k % WIDTH) / WIDTH, v = (float)(k / WIDTH) / HEIGHT;
        places[3 * k] = 2.4f * u + 0.001f * util_unit(&seed);
        places[3 * k + 1] = v > 0.5f ? 2 * v : 1.4f;
        places[3 * k + 2] = v > 0.5f ? -0.3f : 2 * v;
        normals[3 * k + 1] = v > 0.5f ? 0.0f : -1.0f;
        normals[3 * k + 2] = v > 0.5f ? 1.0f : 0.0f;
        if (k % 7 == 0) normals[3 * k + 1] = normals[3 * k + 2] = 0;
    }
    for (way = 0; way < 8; way++) {
        lit *l = lit_make(40, 36, 2);
        ism_desc d = by_flux(512);
        ism_points view;
        glbk_gbuffer seen;
        chosen c;
        memset(&view, 0, sizeof view);
        view.count = PIXELS;
        view.width = WIDTH;
        view.positions = places;
        view.normals = normals;
        d.importance = way < 4 ? (ism_importance)(ISM_IMPORTANCE_BRSM + way) : ISM_IMPORTANCE_DEFAULT;
        if (way == 4) d.view_grid_side = 5;                 /* guided samples of odd grids have numbers of their own */
        if (way == 5) d.blur_radius = -1;
        if (way == 6) d.flux_share = 0.7f;
        if (way == 7) d.unstable = 1;
        gl_see(&t->gl, WIDTH, HEIGHT, places, normals, NULL, &seen);
        memcpy(view.world_to_clip, clip, sizeof clip);
        memcpy(seen.world_to_clip, clip, sizeof clip);
        seen.has_clip = 1;
        lit_upload(t, l);
        chosen_make(t, l, &d, &c);
        assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, &seen, 5));
        elsewhere += compare_vpls(t, l, &c, &view, 5);
        all += d.vpl_count;
        chosen_free(t, &c);
        glbk_gbuffer_free(&t->gl, &seen);
        glbk_texture_free(&t->gl, &l->texels);
    }
    printf("%zu of %zu VPLs by the picture were chosen on the other side of a step\n", elsewhere, all);
    assert_true((double)elsewhere < 1e-2 * (double)all);
}

/* ---- near points ---- */

/* The near point of ism_choose that is nearest to one of the table's, of those that no other has taken. */
static size_t find_near(const ism_near_point *points, size_t count, const float *at, const char *taken)
{
    size_t i, best = count;
    double least = 1e30;
    for (i = 0; i < count; i++) {
        const double off = distance_of(points[i].position, at);
        if (taken[i] || off >= least) continue;
        least = off;
        best = i;
    }
    return best;
}

/* Twice the distance from a place to the eighth of the table's VPLs about it. */
static double reach_at(const float *table, size_t vpls, const float *at)
{
    double near8[8];
    size_t i, k;
    for (k = 0; k < 8; k++) near8[k] = 1e30;
    for (i = 0; i < vpls; i++) {
        const double d = distance_of(table + 16 * i, at);
        for (k = 7; k > 0 && near8[k - 1] > d; k--) near8[k] = near8[k - 1];
        if (near8[k] > d) near8[k] = d;
    }
    return 2 * near8[7];
}

/* The table's near points beside ism_choose's: returns how many have no twin, and adds up the radii of the spheres of
   both. */
static size_t compare_near(const lit *l, const ism_maps *maps, const glbk_ism_maps *m, const float *table,
                           double radii[2])
{
    const size_t first = 4 * (size_t)m->desc.vpl_count, n = m->near_point_count, behind = first + (n + 63) / 64;
    const double texel = 1.0 / (double)l->width;
    double worst[4] = { 0, 0, 0, 0 };
    size_t count, i, k, alone = 0, elsewhere = 0;
    const ism_near_point *points = ism_near_points(maps, &count);
    char *taken = (char *)calloc(count, 1);
    assert_non_null(taken);
    assert_int_equal(count, n);
    for (i = 0; i < n; i++) {
        const float *g = table + 4 * (behind + 3 * i), *sphere = table + 4 * (first + i / 64);
        const size_t twin = find_near(points, count, g, taken);
        const ism_near_point *p = &points[twin];
        assert_true(distance_of(g, sphere) + (double)g[7] <= (double)sphere[3] * (1 + 1e-6));
        assert_true(g[11] >= 0 && g[11] < (float)m->vpl_count);
        assert_true(fabs((double)g[7] / reach_at(table, m->vpl_count, g) - 1) < 1e-5);
        taken[twin] = 1;
        if (distance_of(g, p->position) > 2e-2 * texel) {
            alone++;
            continue;
        }
        worst[0] = fmax(worst[0], distance_of(g + 4, p->normal));
        worst[1] = fmax(worst[1], fabs((double)g[3] / (double)p->edge - 1));
        worst[2] = fmax(worst[2], fabs((double)g[7] / (double)p->reach - 1));
        for (k = 0; k < 3; k++)
            worst[3] = fmax(worst[3], fabs((double)g[8 + k] - (double)p->flux[k]) / fmax((double)p->flux[k], 1e-20));
        elsewhere += (uint32_t)g[11] != (uint32_t)p->vpl;
    }
    for (i = 0; i < n; i += 64) {
        float sphere[4];
        ism__near_sphere(points + i, (uint32_t)(n - i < 64 ? n - i : 64), sphere);
        radii[0] += (double)table[4 * (first + i / 64) + 3];
        radii[1] += (double)sphere[3];
    }
    printf("    %zu near points, %zu without a twin; the others' normals differ by %.1e, edges %.1e, reaches %.1e, "
           "fluxes %.1e; %zu of another VPL\n", n, alone, worst[0], worst[1], worst[2], worst[3], elsewhere);
    assert_true(worst[0] < 1e-3 && worst[1] < 1e-2 && worst[2] < 1e-2 && worst[3] < 1e-5);
    assert_true(elsewhere <= n / 100);          /* two VPLs as near */
    free(taken);
    return alone;
}

/* By flux each near point has the same brightness, a part of all. The points are those of ism_choose, each with the
   same square, reach and VPL; 64 that stand together lie together, nearly as closely as in the order of ism_choose. */
static void near_points_are_those_of_ism_choose(void **state)
{
    GL_TEST(t, state)
    static const uint32_t sizes[][4] = { { 64, 48, 1, 64 }, { 45, 37, 2, 150 }, { 512, 64, 1, 300 } };
    static const float place[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
    size_t k, alone = 0, all = 0, i, n;
    double radii[2] = { 0, 0 };
    int way;
    for (k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        for (way = 0; way < 3; way++) {
            lit *l = lit_make(sizes[k][0], sizes[k][1], sizes[k][2]);
            const size_t texels = (size_t)l->width * l->height * l->faces;
            ism_desc d = by_flux(sizes[k][3]);
            ism_points view;
            ism_frame frame;
            ism_maps *maps;
            double total = 0;
            const ism_vpl *v;
            float *table;
            chosen c;
            d.near_point_count = way == 1 ? 3 : 0;
            d.unstable = way == 2;
            memset(&view, 0, sizeof view);
            view.count = view.width = 1;
            view.positions = place;
            view.normals = down;
            memset(&frame, 0, sizeof frame);
            frame.sources = l->sources;
            frame.source_count = l->faces;
            frame.points = &view;
            frame.index = 5;
            assert_int_equal(ism_create(&d, &maps), ISM_OK);
            assert_int_equal(ism_choose(maps, &frame), ISM_OK);
            lit_upload(t, l);
            chosen_make(t, l, &d, &c);
            assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 5));
            n = c.maps.near_point_count;
            assert_int_equal(n, sizes[k][3] * (way == 1 ? 3 : 16));
            table = read_table(t, &c.choice, (uint32_t)(sizes[k][3] + ((n + 63) / 64 + 3 * n + 3) / 4));
            alone += compare_near(l, maps, &c.maps, table, radii);
            all += n;
            for (i = 0; i < texels; i++) total += (double)ism__luminance(l->flux + 3 * i);
            for (i = 0; i < n; i++) {
                const float *flux = table + 4 * (4 * (size_t)d.vpl_count + (n + 63) / 64 + 3 * i + 2);
                assert_true(fabs((double)ism__luminance(flux) * (double)n / total - 1) < 1e-4);
            }
            v = ism_vpls(maps, &i);
            for (i = 0; i < d.vpl_count; i++)
                assert_true(fabs((double)table[16 * i + 11] / (double)v[i].reach - 1) < 1e-2);
            free(table);
            ism_free(maps);
            chosen_free(t, &c);
            glbk_texture_free(&t->gl, &l->texels);
        }
    printf("%zu of %zu near points have no twin; spheres of 64 are %.3f times as wide\n", alone, all,
           radii[0] / radii[1]);
    assert_true((double)alone < 4e-3 * (double)all);
    assert_true(radii[0] < 1.6 * radii[1]);
}

/* A wall stands on the edge of a lit floor of 4 x 4 m, radiosity 1: from its foot up it has the light of the floor's
   form factor. Near points, chosen on the GPU, keep it where 256 VPLs alone make blotches. They and the figures are
   those of near_test. */
static void light_in_a_corner_is_near_the_truth(void **state)
{
    GL_TEST(t, state)
    enum { SIDE = 64, W = 20, H = 12 };
    static const float back[3] = { 0, 0, 1 };
    static const char *const rules[] = { "patches", "near points" };
    static float places[3 * W * H], normals[3 * W * H], light[4 * W * H];
    const glbk_ism_renderer_desc size = { W, H };
    lit *l = lit_make(SIDE, SIDE, 1);
    ism_desc d = by_flux(256);
    double rmse[2] = { 0, 0 }, mean[2] = { 0, 0 }, truth = 0;
    glbk_ism_renderer r;
    glbk_gbuffer seen;
    ism_shading s;
    chosen c;
    size_t i;
    int rule, k;
    for (i = 0; i < SIDE * SIDE; i++) {
        l->position[3 * i] = 4 * ((float)(i % SIDE) + 0.5f) / SIDE - 2;
        l->position[3 * i + 1] = 0;
        l->position[3 * i + 2] = 4 * ((float)(i / SIDE) + 0.5f) / SIDE;
        l->normal[3 * i] = l->normal[3 * i + 2] = 0;
        l->normal[3 * i + 1] = 1;
        l->area[i] = 16.0f / (SIDE * SIDE);
        l->flux[3 * i] = l->flux[3 * i + 1] = l->flux[3 * i + 2] = l->area[i];
    }
    for (i = 0; i < W * H; i++) {
        places[3 * i] = 4 * ((float)(i % W) + 0.5f) / W - 2;
        places[3 * i + 1] = 1.2f * ((float)(i / W) + 0.5f) / H;
        normals[3 * i + 2] = 1;
    }
    d.near_point_count = 0;
    d.importance = ISM_IMPORTANCE_BRSM;
    memset(&s, 0, sizeof s);
    s.no_maps = 1;
    gl_see(&t->gl, W, H, places, normals, NULL, &seen);
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &size, &r));
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, &seen, 0));
    for (rule = 0; rule < 2; rule++) {
        s.near_mode = rule ? ISM_NEAR_GATHER : ISM_NEAR_PATCH;
        assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &c.maps, &s, 0));
        assert_glbk(t, glbk_ism_read(&t->gl, &r, light));
        for (i = 0; i < W * H; i++) {
            static const float corner[4][2] = { { -2, 0 }, { -2, 4 }, { 2, 4 }, { 2, 0 } };
            float square[12];
            double e;
            for (k = 0; k < 4; k++) {
                square[3 * k] = corner[k][0] - places[3 * i];
                square[3 * k + 1] = -places[3 * i + 1];
                square[3 * k + 2] = corner[k][1] - places[3 * i + 2];
            }
            e = (double)util_form_factor(back, square);
            truth += e / 2;
            mean[rule] += (double)light[4 * i];
            rmse[rule] += ((double)light[4 * i] - e) * ((double)light[4 * i] - e);
        }
    }
    for (rule = 0; rule < 2; rule++) {
        mean[rule] /= truth;
        rmse[rule] = sqrt(rmse[rule] * W * H) / truth;
        printf("%s: relative RMSE %.4f, mean %.4f\n", rules[rule], rmse[rule], mean[rule]);
    }
    CONFORM("T44", "wall beside a lit floor, by near points: mean over the form factor's", 1, mean[1], 0.02);
    CONFORM_MAX("T44", "the same: relative RMSE", 0.03, rmse[1]);
    assert_true(rmse[1] < 0.6 * rmse[0]);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
    glbk_ism_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
}

/* Eight VPLs are too few to measure reaches by, and none is told to be near then. */
static void few_vpls_have_no_near_points(void **state)
{
    GL_TEST(t, state)
    lit *l = lit_make(16, 16, 1);
    ism_desc d = by_flux(8);
    float *table;
    chosen c;
    size_t i;
    d.near_point_count = 16;
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
    assert_int_equal(c.maps.near_point_count, 0);
    table = read_table(t, &c.choice, 8);
    for (i = 0; i < 8; i++) assert_true(table[16 * i + 11] == 0);
    free(table);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
}

/* The mean power of VPLs by the picture is that of the map, whatever the importances are. */
static void power_is_kept(void **state)
{
    GL_TEST(t, state)
    enum { RUNS = 60 };
    static const char *const names[] = { "bidirectional importance", "guided importance" };
    static const float clip[16] = { 1.5f, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1, -1, 0, -1, 3, 3 };
    static float places[3 * 32 * 32], normals[3 * 32 * 32];
    char text[80];
    size_t i;
    int way;
    for (i = 0; i < 32 * 32; i++) {
        places[3 * i] = (float)(i % 32) / 32;
        places[3 * i + 1] = 0.9f;
        places[3 * i + 2] = (float)(i / 32) / 32;
        normals[3 * i + 1] = -1;
    }
    for (way = 0; way < 2; way++) {
        lit *l = lit_make(24, 24, 1);
        ism_desc d = by_flux(64);
        double truth = 0, sum = 0, square = 0;
        glbk_gbuffer seen;
        chosen c;
        uint32_t run;
        for (i = 0; i < 24 * 24; i++) truth += (double)ism__luminance(l->flux + 3 * i);
        d.importance = way ? ISM_IMPORTANCE_GUIDED : ISM_IMPORTANCE_BRSM;
        d.unstable = 1;
        gl_see(&t->gl, 32, 32, places, normals, NULL, &seen);
        memcpy(seen.world_to_clip, clip, sizeof clip);
        seen.has_clip = 1;
        lit_upload(t, l);
        chosen_make(t, l, &d, &c);
        for (run = 0; run < RUNS; run++) {
            double total = 0;
            float *table;
            assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, &seen, run));
            table = read_table(t, &c.choice, 64);
            for (i = 0; i < 64; i++) total += (double)ism__luminance(table + 16 * i + 8);
            sum += total / RUNS;
            square += total * total / RUNS;
            free(table);
        }
        snprintf(text, sizeof text, "%s on the GPU: mean power of VPLs over that of the map", names[way]);
        CONFORM("T41", text, 1, sum / truth, 3 * sqrt(fmax(square - sum * sum, 0) / RUNS) / truth + 1e-5);
        assert_true(square - sum * sum > 0);
        chosen_free(t, &c);
        glbk_gbuffer_free(&t->gl, &seen);
        glbk_texture_free(&t->gl, &l->texels);
    }
}

/* Importance by flux has no variance: every VPL has the same flux, and all together that of the source. */
static void all_vpls_are_equally_bright(void **state)
{
    GL_TEST(t, state)
    lit *l = lit_make(64, 48, 2);
    const ism_desc d = by_flux(512);
    double total = 0, sum = 0, least = 1e30, most = 0;
    float *table;
    size_t i;
    chosen c;
    for (i = 0; i < 2 * 64 * 48; i++) total += (double)ism__luminance(l->flux + 3 * i);
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
    table = read_table(t, &c.choice, 512);
    for (i = 0; i < 512; i++) {
        const double is = (double)ism__luminance(table + 16 * i + 8);
        assert_true(fabs(is - total / 512) < 2e-6 * total / 512);
        least = fmin(least, is);
        most = fmax(most, is);
        sum += is;
    }
    CONFORM("T41", "importance by flux: mean power of VPLs over that of the map", 1, sum / total, 1e-5);
    CONFORM("T41", "importance by flux: brightest over darkest VPL", 1, most / least, 1e-4);
    free(table);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
}

/* Of two texels the first is black; and a texel of 1000 before 65,535 of 1e-5, which one float would swallow. */
static void long_sums_lose_nothing(void **state)
{
    GL_TEST(t, state)
    lit *l = lit_make(2, 1, 1);
    const ism_desc d = by_flux(1024);
    double total = 0, first_texel = 0;
    float *table;
    size_t i;
    chosen c;
    for (i = 0; i < 6; i++) l->flux[i] = i < 3 ? 0 : 1;
    l->sources[0].scattered = 1;
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
    table = read_table(t, &c.choice, 1024);
    for (i = 0; i < 1024; i++) first_texel += distance_of(table + 16 * i, l->position + 3) > 0;
    CONFORM("T15", "VPLs at the empty one of two texels", 0, first_texel, 0);
    free(table);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
    l = lit_make(256, 256, 1);
    for (i = 0; i < 3 * 65536; i++) l->flux[i] = i < 3 ? 1000 : 1e-5f;
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
    all_sums_off(t, l, &c.choice, &total);
    /* 31 additions a block, at three levels of rows and two of columns, each off by half a digit of 1000 */
    CONFORM("T16", "sum of 1000 and 65,535 times 1e-5, in blocks of 32 floats", 1000.65535, total, 2e-3);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
}

/* A number that falls on a step belongs to the cell behind: of 32 equal rows, 16 VPLs lie in every other one. */
static void a_step_belongs_to_the_cell_behind(void **state)
{
    GL_TEST(t, state)
    lit *l = lit_make(32, 32, 1);
    ism_desc d = by_flux(16);
    float *table;
    size_t i;
    chosen c;
    for (i = 0; i < 3 * 32 * 32; i++) l->flux[i] = 0.25f;
    d.no_inter_texel = 1;
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
    table = read_table(t, &c.choice, 16);
    for (i = 0; i < 16; i++) assert_true(table[16 * i + 2] == ((float)(2 * i + 1) + 0.5f) / 32);
    free(table);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
}

/* A bent sheet, a cylinder of radius 1 m whose texels lie `step` radians apart, lit from outside (1) or inside (-1):
   the least and the largest height of VPLs over it, on the lit side, in sagittas of its chords. */
static void heights_over_a_bend(gl_test *t, float side, double *least, double *most)
{
    const float step = 0.15f;
    const double sagitta = 1 - cos(0.5 * (double)step);
    const ism_desc d = by_flux(256);
    lit *l = lit_make(8, 8, 1);
    float *table;
    size_t i;
    chosen c;
    for (i = 0; i < 64; i++) {
        const float angle = step * (float)(i % 8);
        l->position[3 * i] = cosf(angle);
        l->position[3 * i + 1] = sinf(angle);
        l->position[3 * i + 2] = 0.25f * (float)(i / 8);
        l->normal[3 * i] = side * cosf(angle);
        l->normal[3 * i + 1] = side * sinf(angle);
        l->normal[3 * i + 2] = 0;
        l->flux[3 * i] = l->flux[3 * i + 1] = l->flux[3 * i + 2] = 1;
    }
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
    table = read_table(t, &c.choice, 256);
    *least = 1e30;
    *most = -1e30;
    for (i = 0; i < 256; i++) {
        const double x = (double)table[16 * i], y = (double)table[16 * i + 1];
        const double h = (double)side * (sqrt(x * x + y * y) - 1) / sagitta;
        *least = fmin(*least, h);
        *most = fmax(*most, h);
    }
    free(table);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
}

static void vpls_stay_before_a_bent_sheet(void **state)
{
    GL_TEST(t, state)
    double least, most;
    heights_over_a_bend(t, 1, &least, &most);
    CONFORM_MAX("T55", "bent sheet lit from outside: depth of VPLs behind it, sagittas", 0.001, -least);
    CONFORM_MAX("T55", "height over it, sagittas", 1.02, most);
    heights_over_a_bend(t, -1, &least, &most);
    CONFORM_MAX("T55", "bent sheet lit from inside: depth of VPLs behind it, sagittas", 0.001, -least);
    CONFORM_MAX("T55", "height over it, sagittas (inside)", 1.02, most);
}

/* Texels with a flux, a place or a normal that cannot be used are never chosen; if there are no others, VPLs are
   black. */
static void what_cannot_be_used_is_never_chosen(void **state)
{
    GL_TEST(t, state)
    static const uint32_t not_a_number = 0x7fc00000u;
    lit *l = lit_make(40, 8, 1);
    const ism_desc d = by_flux(64);
    float *table;
    size_t i, k, only;
    chosen c;
    for (only = 0; only < 2; only++) {
        for (i = 0; i < 40 * 8; i++) {
            for (k = 0; k < 3; k++) l->flux[3 * i + k] = 1;
            l->position[3 * i] = (float)i;
            l->position[3 * i + 2] = 0;
            l->normal[3 * i] = l->normal[3 * i + 2] = 0;
            l->normal[3 * i + 1] = 1;
            if (only && i == 77) continue;
            if (i % 5 == 0) l->flux[3 * i + 1] = -1;
            if (i % 5 == 1) memcpy(l->flux + 3 * i + 2, &not_a_number, 4);
            if (i % 5 == 2) memcpy(l->position + 3 * i + 2, &not_a_number, 4);
            if (i % 5 == 3) l->normal[3 * i + 1] = 0.9f;
            if (i % 5 == 4) l->flux[3 * i] = 2e30f;
        }
        lit_upload(t, l);
        l->sources[0].scattered = 1;
        chosen_make(t, l, &d, &c);
        assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, NULL, 0));
        table = read_table(t, &c.choice, 64);
        for (i = 0; i < 64; i++)
            for (k = 0; k < 3; k++) {
                assert_true(table[16 * i + 8 + k] == (only ? 1.0f / 64 : 0.0f));
                assert_true(table[16 * i + 0] == (only ? 77.0f : 0.0f));
            }
        free(table);
        chosen_free(t, &c);
        glbk_texture_free(&t->gl, &l->texels);
    }
}

/* ---- windows ---- */

/* One receiver right before the only texel that shines: its direction is the square's middle, which lies in cell 32 of
   64 along both axes, with 32 before it and 31 behind. */
static void a_window_holds_what_is_seen(void **state)
{
    GL_TEST(t, state)
    static const float place[3] = { 0.25f, 2.25f, 0.25f }, down[3] = { 0, -1, 0 }, up[3] = { 0, 1, 0 };
    static const float away[3] = { 0, 1, 0.2f };
    lit *l = lit_make(8, 12, 1);
    ism_projection p;
    size_t i;
    for (i = 0; i < 8 * 12; i++) {
        memset(l->position + 3 * i, 0, 12);
        l->position[3 * i] = l->position[3 * i + 2] = 0.25f;
        memcpy(l->normal + 3 * i, up, 12);
    }
    l->sources[0].scattered = 1;
    lit_upload(t, l);
    for (p = ISM_PROJECTION_COSINE; p < ISM_PROJECTION_COUNT; p = (ism_projection)(p + 1)) {
        ism_desc d = by_flux(40);
        int way;
        d.window_rim = 4;
        d.projection = p;
        for (way = 0; way < 4; way++) {         /* seen; its back; nothing is seen; for bounces */
            const uint32_t wanted = way == 0 ? 32u | 32u << 6 | 31u << 12 | 31u << 18 : 0;
            glbk_gbuffer seen;
            float *table;
            chosen c;
            d.keep_hits = way == 3;
            gl_see(&t->gl, 1, 1, place, way == 1 ? away : down, NULL, &seen);
            chosen_make(t, l, &d, &c);
            assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, way == 2 ? NULL : &seen, 0));
            table = read_table(t, &c.choice, 40);
            for (i = 0; i < 40; i++) assert_int_equal((uint32_t)table[16 * i + 15], wanted);
            free(table);
            chosen_free(t, &c);
            glbk_gbuffer_free(&t->gl, &seen);
        }
    }
    glbk_texture_free(&t->gl, &l->texels);
}

/* Counts of a run over frames: VPLs whose window was compared, differs, stayed where a new one would not lie. */
typedef struct windows_seen { size_t all, differ, stayed, none; } windows_seen;

/* Compares the windows of a frame with those of ism_scatter, and of maps without a frame before. Once a VPL was chosen
   elsewhere, the window that it had does not count any more. */
static void compare_windows(gl_test *t, const chosen *c, ism_maps *maps, const ism_frame *frame, char *elsewhere,
                            windows_seen *n)
{
    float *table = read_table(t, &c->choice, c->desc.vpl_count);
    ism_maps *fresh;
    const ism_vpl *v, *f;
    size_t i, count;
    assert_int_equal(ism_create(&c->desc, &fresh), ISM_OK);
    assert_int_equal(ism_choose(fresh, frame), ISM_OK);
    assert_int_equal(ism_scatter(fresh, frame), ISM_OK);
    assert_int_equal(ism_choose(maps, frame), ISM_OK);
    assert_int_equal(ism_scatter(maps, frame), ISM_OK);
    f = ism_vpls(fresh, NULL);
    v = ism_vpls(maps, &count);
    assert_int_equal(count, c->desc.vpl_count);
    for (i = 0; i < count; i++) {
        const uint32_t window = (uint32_t)table[16 * i + 15];
        elsewhere[i] = elsewhere[i] || distance_of(table + 16 * i, v[i].position) > 1e-3;
        if (elsewhere[i]) continue;
        n->all++;
        n->differ += window != v[i].window;
        n->stayed += window != f[i].window;
        n->none += !window;
    }
    ism_free(fresh);
    free(table);
}

static void windows_are_those_of_ism_scatter(void **state)
{
    GL_TEST(t, state)
    enum { WIDTH = 60, PIXELS = WIDTH * 45, FRAMES = 6, VPLS = 300 };
    static float places[3 * PIXELS], normals[3 * PIXELS];
    static char elsewhere[VPLS];
    windows_seen sum = { 0, 0, 0, 0 };
    size_t i;
    int way;
    for (way = 0; way < 7; way++) {
        const uint32_t height = way == 5 ? 5 : 45;      /* fewer than eight rows: blocks beside each other */
        lit *l = lit_make(40, 36, 2);
        windows_seen n = { 0, 0, 0, 0 };
        ism_desc d = by_flux(VPLS);
        ism_points view;
        ism_frame frame;
        ism_maps *maps;
        chosen c;
        uint32_t f, seed = 4;
        d.window_rim = way == 6 ? 16 : 4;
        d.projection = way < 5 ? (ism_projection)way : ISM_PROJECTION_COSINE;
        d.unstable = way == 4;
        if (way == 4) d.projection = ISM_PROJECTION_OCTAHEDRAL;
        d.importance = way & 1 ? ISM_IMPORTANCE_FLUX : ISM_IMPORTANCE_BRSM;
        memset(&view, 0, sizeof view);
        view.count = (size_t)WIDTH * height;
        view.width = WIDTH;
        view.positions = places;
        view.normals = normals;
        memset(&frame, 0, sizeof frame);
        frame.sources = l->sources;
        frame.source_count = 2;
        frame.points = &view;
        memset(elsewhere, 0, sizeof elsewhere);
        lit_upload(t, l);
        chosen_make(t, l, &d, &c);
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        for (f = 0; f < FRAMES; f++) {
            const float wide = 1 + 0.02f * (float)(f % 3), far = f == 5 ? 0.3f : 0;
            glbk_gbuffer seen;
            for (i = 0; i < PIXELS; i++) {
                const float u = (float)(i % WIDTH) / WIDTH, w = (float)(i / WIDTH) / (float)height;
                places[3 * i] = 2.4f * u * wide + 0.001f * util_unit(&seed) + far;
                places[3 * i + 1] = w > 0.5f ? 2 * w : 1.4f;
                places[3 * i + 2] = w > 0.5f ? -0.3f : 2 * w * wide;
                memset(normals + 3 * i, 0, 12);
                if (i % 7) normals[3 * i + 1 + (w > 0.5f)] = w > 0.5f ? 1.0f : -1.0f;
            }
            if (f == 3) {                               /* one face jumps */
                for (i = 40 * 36; i < 2 * 40 * 36; i++) l->position[3 * i + 2] += 0.4f;
                glbk_texture_free(&t->gl, &l->texels);
                lit_upload(t, l);
            }
            frame.index = f;
            gl_see(&t->gl, WIDTH, height, places, normals, NULL, &seen);
            assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, &seen, f));
            compare_windows(t, &c, maps, &frame, elsewhere, &n);
            glbk_gbuffer_free(&t->gl, &seen);
        }
        printf("way %d: of %zu windows %zu differ, %zu stayed where they were, %zu tiles have none\n", way, n.all,
               n.differ, n.stayed, n.none);
        assert_true(n.all > VPLS * FRAMES * 9 / 10);
        assert_true((n.none < n.all / 2) == (way < 6));        /* with a wide rim most are not worth it */
        assert_true((n.stayed > n.differ) == !d.unstable);
        sum.all += n.all;
        sum.differ += n.differ;
        ism_free(maps);
        chosen_free(t, &c);
        glbk_texture_free(&t->gl, &l->texels);
    }
    printf("%zu of %zu windows differ\n", sum.differ, sum.all);
    assert_true((double)sum.differ < 1e-2 * (double)sum.all);
}

/* ---- a frame ---- */

/* Shading by the table that was drawn is as by the same VPLs and near points uploaded; and from there to the picture
   the frame asks GL for nothing: no glReadPixels, no glGet..., no glFinish. What else could wait, glGetTexImage and
   glMapBuffer, the library never loads. Surfels are uploaded before: an upload asks which parameters of texels it must
   put back. */
static void a_frame_reads_nothing_back(void **state)
{
    GL_TEST(t, state)
    enum { SIDE = 24 };
    static float places[3 * SIDE * SIDE], down[3 * SIDE * SIDE], light[2][4 * SIDE * SIDE];
    static ism_surfel surfels[64 * 64];
    static ism_vpl vpls[64];
    static const float occluder[9] = { 0.2f, 0.6f, 0.2f, 0.6f, 0.6f, 0.2f, 0.2f, 0.6f, 0.7f };
    lit *l = lit_make(32, 32, 1);
    enum { NEAR = 64 * 4 };
    static ism_near_point points[NEAR];
    ism_desc d = by_flux(64);
    const glbk_ism_renderer_desc size = { SIDE, SIDE };
    const ism_mesh mesh = { occluder, 3, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL };
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);
    glbk_ism_renderer r;
    glbk_gbuffer seen;
    glbk_pass pass;
    ism_points view;
    ism_frame frame;
    ism_info info;
    ism_maps *maps;
    float *table;
    double sum = 0, shadow = 0;
    size_t i, n;
    int turn;
    chosen c;
    for (i = 0; i < SIDE * SIDE; i++) {
        places[3 * i] = (float)(i % SIDE) / SIDE;
        places[3 * i + 1] = 1.4f;
        places[3 * i + 2] = (float)(i / SIDE) / SIDE;
        down[3 * i + 1] = -1;
    }
    d.near_point_count = 4;
    gl_see(&t->gl, SIDE, SIDE, places, down, NULL, &seen);
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &size, &r));
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    memset(&view, 0, sizeof view);
    view.count = SIDE * SIDE;
    view.positions = places;
    view.normals = down;
    memset(&frame, 0, sizeof frame);
    frame.mesh = &mesh;
    frame.points = &view;
    assert_int_equal(ism_create(&d, &maps), ISM_OK);
    assert_int_equal(ism_choose(maps, &frame), ISM_OK);         /* no sources: surfels alone are wanted */
    assert_int_equal(ism_scatter(maps, &frame), ISM_OK);
    assert_int_equal(ism_phase_surfels(maps, 0, surfels, 64 * 64, &n), ISM_OK);
    ism_get_info(maps, &info);
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &c.maps, &mesh));
    memset(&pass, 0, sizeof pass);
    pass.target = &canvas.target;
    for (turn = 0; turn < 2; turn++) {                          /* programs are compiled in the first */
        assert_glbk(t, glbk_ism_surfels_upload(&t->gl, &c.maps, 0, surfels, n));
        t->gl.check = !turn;                                    /* which asks for errors after each call */
        gl_count_begin(&t->gl);
        assert_glbk(t, glbk_ism_choose(&t->gl, &c.choice, &c.maps, &l->texels, &seen, (uint32_t)turn));
        assert_glbk(t, glbk_ism_draw(&t->gl, &c.maps, 0));
        assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &c.maps, NULL, 0));
        assert_glbk(t, glbk_ism_resolve(&t->gl, &r, &seen, &pass, NULL));
        if (turn) {
            assert_int_equal(gl_counted.asks, 0);
            assert_int_equal(gl_counted.uploads, 0);
            assert_true(gl_counted.draws > 9);
        }
        gl_count_end(&t->gl);
    }
    t->gl.check = 1;
    assert_glbk(t, glbk_ism_read(&t->gl, &r, light[0]));
    assert_int_equal(c.maps.near_point_count, NEAR);
    table = read_table(t, &c.choice, 64 + (NEAR / 64 + 3 * NEAR) / 4);
    memcpy(points, table + 4 * (4 * 64 + NEAR / 64), sizeof points);
    for (i = 0; i < 64; i++) {
        memcpy(vpls[i].position, table + 16 * i, 12);
        memcpy(vpls[i].normal, table + 16 * i + 4, 12);
        memcpy(vpls[i].axis, table + 16 * i + 12, 12);
        memcpy(vpls[i].flux, table + 16 * i + 8, 12);
        vpls[i].edge = table[16 * i + 7];
        vpls[i].reach = table[16 * i + 11];
        vpls[i].exponent = 1;
    }
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &c.maps, vpls, 64, &info));
    assert_glbk(t, glbk_ism_near_points_upload(&t->gl, &c.maps, points, NEAR));
    assert_glbk(t, glbk_ism_draw(&t->gl, &c.maps, 0));
    assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &c.maps, NULL, 0));
    assert_glbk(t, glbk_ism_read(&t->gl, &r, light[1]));
    assert_memory_equal(light[0], light[1], sizeof light[0]);
    assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &c.maps, &(ism_shading){ .no_maps = 1 }, 0));
    assert_glbk(t, glbk_ism_read(&t->gl, &r, light[1]));
    for (i = 0; i < SIDE * SIDE; i++) {
        sum += (double)light[0][4 * i];
        shadow += (double)light[1][4 * i] - (double)light[0][4 * i];
    }
    printf("light %g, the occluder takes %g of it\n", sum, shadow);
    assert_true(sum > 0 && shadow > 0.01 * sum);
    free(table);
    ism_free(maps);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
    glbk_ism_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    gl_canvas_free(t, &canvas);
}

/* ---- errors ---- */

static void wrong_arguments_are_refused(void **state)
{
    GL_TEST(t, state)
    lit *l = lit_make(8, 8, 1);
    ism_desc d = by_flux(4);
    glbk_ism_choice_desc of;
    glbk_ism_choice out;
    glbk_ism_maps other;
    glbk_texture wrong;
    chosen c;
    memset(&of, 0, sizeof of);
    lit_upload(t, l);
    chosen_make(t, l, &d, &c);
    gl_listen(t);
    assert_int_equal(glbk_ism_choice_create(NULL, &c.maps, &of, &out), GLBK_ERR_ARGUMENT);
    SAYS(glbk_ism_choice_create(&t->gl, &c.maps, &of, NULL), GLBK_ERR_ARGUMENT,
                "glbk_ism_choice_create: out is NULL");
    SAYS(glbk_ism_choice_create(&t->gl, NULL, &of, &out), GLBK_ERR_ARGUMENT,
                "glbk_ism_choice_create: maps is NULL");
    SAYS(glbk_ism_choice_create(&t->gl, &c.maps, NULL, &out), GLBK_ERR_ARGUMENT,
                "glbk_ism_choice_create: desc is NULL");
    SAYS(glbk_ism_choice_create(&t->gl, &c.maps, &of, &out), GLBK_ERR_DESC,
                "glbk_ism_choice_create: desc.width is 0; it must be 1 or more");
    of.width = 8;
    SAYS(glbk_ism_choice_create(&t->gl, &c.maps, &of, &out), GLBK_ERR_DESC,
                "glbk_ism_choice_create: desc.height is 0; it must be 1 or more");
    of.height = 1u << 31;
    of.face_count = 2;
    assert_int_equal(glbk_ism_choice_create(&t->gl, &c.maps, &of, &out), GLBK_ERR_LIMIT);
    of.height = 8;
    of.width = 40000;
    assert_int_equal(glbk_ism_choice_create(&t->gl, &c.maps, &of, &out), GLBK_ERR_LIMIT);
    d.importance = (ism_importance)77;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &other));
    of.width = 8;
    of.face_count = 1;
    SAYS(glbk_ism_choice_create(&t->gl, &other, &of, &out), GLBK_ERR_DESC,
                "glbk_ism_choice_create: maps->desc.importance is 77; it must be a value of ism_importance");
    assert_true(!out.drawn.texture.name);
    assert_int_equal(glbk_ism_choose(NULL, &c.choice, &c.maps, &l->texels, NULL, 0), GLBK_ERR_ARGUMENT);
    SAYS(glbk_ism_choose(&t->gl, NULL, &c.maps, &l->texels, NULL, 0), GLBK_ERR_ARGUMENT,
                "glbk_ism_choose: choice is NULL");
    SAYS(glbk_ism_choose(&t->gl, &out, &c.maps, &l->texels, NULL, 0), GLBK_ERR_ARGUMENT,
                "glbk_ism_choose: choice was not created");
    SAYS(glbk_ism_choose(&t->gl, &c.choice, NULL, &l->texels, NULL, 0), GLBK_ERR_ARGUMENT,
                "glbk_ism_choose: maps is NULL");
    SAYS(glbk_ism_choose(&t->gl, &c.choice, &c.maps, NULL, NULL, 0), GLBK_ERR_ARGUMENT,
                "glbk_ism_choose: texels is NULL");
    SAYS(glbk_ism_choose(&t->gl, &c.choice, &other, &l->texels, NULL, 0), GLBK_ERR_MISMATCH,
                "glbk_ism_choose: maps are not those that the choice was made for");
    wrong = l->texels;
    wrong.format = GLBK_FORMAT_RGBA32F;
    SAYS(glbk_ism_choose(&t->gl, &c.choice, &c.maps, &wrong, NULL, 0), GLBK_ERR_MISMATCH,
                "glbk_ism_choose: texels are not GLBK_FORMAT_RGBA32UI");
    wrong = l->texels;
    wrong.width = 9;
    SAYS(glbk_ism_choose(&t->gl, &c.choice, &c.maps, &wrong, NULL, 0), GLBK_ERR_MISMATCH,
                "glbk_ism_choose: texels->width is 9; it must be that of the choice");
    wrong = l->texels;
    wrong.height = 9;
    SAYS(glbk_ism_choose(&t->gl, &c.choice, &c.maps, &wrong, NULL, 0), GLBK_ERR_MISMATCH,
                "glbk_ism_choose: texels->height is 9; it must be that of the choice");
    wrong = l->texels;
    wrong.layers = 6;
    SAYS(glbk_ism_choose(&t->gl, &c.choice, &c.maps, &wrong, NULL, 0), GLBK_ERR_MISMATCH,
                "glbk_ism_choose: texels->layers is 6; it must be three for each face of the choice");
    glbk_ism_choice_free(&t->gl, NULL);
    glbk_ism_maps_free(&t->gl, &other);
    chosen_free(t, &c);
    glbk_texture_free(&t->gl, &l->texels);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(sums_are_prefix_sums),
        gl_unit_test(vpls_are_those_of_ism_choose),
        gl_unit_test(vpls_by_the_picture_are_those_of_ism_choose),
        gl_unit_test(near_points_are_those_of_ism_choose),
        gl_unit_test(light_in_a_corner_is_near_the_truth),
        gl_unit_test(few_vpls_have_no_near_points),
        gl_unit_test(power_is_kept),
        gl_unit_test(all_vpls_are_equally_bright),
        gl_unit_test(long_sums_lose_nothing),
        gl_unit_test(a_step_belongs_to_the_cell_behind),
        gl_unit_test(vpls_stay_before_a_bent_sheet),
        gl_unit_test(what_cannot_be_used_is_never_chosen),
        gl_unit_test(a_window_holds_what_is_seen),
        gl_unit_test(windows_are_those_of_ism_scatter),
        gl_unit_test(a_frame_reads_nothing_back),
        gl_unit_test(wrong_arguments_are_refused)
    };
    (void)count;
    if (gl_this_way() && gl_this_way()->bit != GL_CORE33) unsetenv("CONFORMANCE");     /* each row once */
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
