/* build_rows_test - what csm.h stores: lossless (T59), minimal (T60), one segment for a sphere (T63), orientations
   (T64), orders (T65); bytes that depend on neither threads nor shards nor intrinsics. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "conformance.h"
#include "util.h"
#include "scene.h"

static const cohsm_domain_kind all_kinds[7] = { COHSM_DOMAIN_LATLONG, COHSM_DOMAIN_OCTAHEDRAL, COHSM_DOMAIN_LINE,
    COHSM_DOMAIN_RECTANGLE, COHSM_DOMAIN_DISC, COHSM_DOMAIN_SPHERE, COHSM_DOMAIN_VOLUME };

/* ---- views by cell, since maps are asked by cell and builders count along the sequence ---- */

/* cell[i] = the cell whose location is that of view i < N. */
static uint32_t *cells_of(const cohsm_builder *b, const cohsm_maps *maps)
{
    cohsm_info info;
    uint32_t i, c, *cell;
    float *at;

    cohsm_get_info(maps, &info);
    cell = (uint32_t *)malloc(4 * (size_t)info.map_count);
    at = (float *)malloc(16 * (size_t)info.map_count);
    assert_true(cell && at);
    for (c = 0; c < info.map_count; c++) assert_int_equal(cohsm_location(maps, c, at + 4 * c), COHSM_OK);
    for (i = 0; i < info.map_count; i++) {
        cohsm_view v;
        assert_int_equal(cohsm_builder_view(b, i, &v), COHSM_OK);
        for (c = 0; c < info.map_count && memcmp(at + 4 * c, v.location, 16); c++) {}
        assert_true(c < info.map_count);
        cell[i] = c;
    }
    free(at);
    return cell;
}

/* ---- layers of our own: rays in double through the pixel centres of the view's matrix ---- */

static void affine_solve(const float *m, const double *target, double *x)   /* rows 0..2 of m times (x, 1) = target */
{
    double a[3][4];
    int r, c, k;
    for (r = 0; r < 3; r++) {
        for (c = 0; c < 3; c++) a[r][c] = (double)m[4 * c + r];
        a[r][3] = target[r] - (double)m[12 + r];
    }
    for (k = 0; k < 3; k++) {
        int pivot = k;
        for (r = k + 1; r < 3; r++)
            if (fabs(a[r][k]) > fabs(a[pivot][k])) pivot = r;
        for (c = 0; c < 4; c++) {
            double t = a[k][c];
            a[k][c] = a[pivot][c];
            a[pivot][c] = t;
        }
        for (r = 0; r < 3; r++) {
            double f = r == k ? 0 : a[r][k] / a[k][k];
            for (c = k; c < 4; c++) a[r][c] -= f * a[k][c];
        }
    }
    for (r = 0; r < 3; r++) x[r] = a[r][3] / a[r][r];
}

static void unproject(const cohsm_view *v, double px, double py, double depth, double *out)
{
    double target[3];
    if (v->depth_scale > 0.0f) {
        double w = depth / (double)v->depth_scale;
        float m[16];
        int c;
        target[0] = px * w;
        target[1] = py * w;
        target[2] = w;
        memcpy(m, v->matrix, sizeof m);
        for (c = 0; c < 4; c++) m[4 * c + 2] = m[4 * c + 3];     /* the row of w in the place of the depth's */
        affine_solve(m, target, out);
        return;
    }
    target[0] = px;
    target[1] = py;
    target[2] = depth;
    affine_solve(v->matrix, target, out);
}

/* z[0..2] = M * M depths; 2 where nothing is hit. */
static void cast_view(const model *m, const cohsm_view *v, uint32_t size, float *z[3])
{
    uint32_t p;
    int k;
    for (p = 0; p < size * size; p++) {
        double px = p % size + 0.5, py = p / size + 0.5, o[3], e[3], d[3], hits[3];
        int n;
        unproject(v, px, py, 0.0, o);
        unproject(v, px, py, 1.0, e);
        for (k = 0; k < 3; k++) d[k] = e[k] - o[k];
        n = ray_hits(m, o, d, v->depth_scale > 0.0f ? 1e-6 : -1.0, hits, 3);
        for (k = 0; k < 3; k++) z[k][p] = k < n ? (float)hits[k] : 2.0f;
    }
}

static uint32_t quantised(float z) { return z <= 1.0f ? (uint32_t)(z * 65533.0f) : 65535u; }

/* Does any value of the grid lie in [lo, hi]? */
static int grid_meets(uint32_t lo, uint32_t hi, uint32_t bits)
{
    uint32_t grid = (1u << bits) - 1u, i;
    for (i = 0; i <= grid; i++) {
        uint32_t v = i < grid ? i * 65535u / grid : 65535u;
        if (v >= lo && v <= hi) return 1;
    }
    return 0;
}

/* ---- T59 ---- */

typedef struct tally { uint64_t entries, wrong, empty, open, exact; } tally;

/* Builds from own layers, decodes every view, compares with own intervals. Layers Z1Z2 and Z1Z3_FAR need no sphere. */
static tally lossless_by_hand(const cohsm_desc *desc, const model *m)
{
    cohsm_builder *b;
    cohsm_maps *maps;
    cohsm_stats stats;
    cohsm_view v;
    tally t = { 0, 0, 0, 0, 0 };
    uint32_t n, i, p, size = desc->map_side, pixels = size * size, *cell, map_count;
    uint16_t *out = (uint16_t *)malloc(2 * (size_t)pixels);
    float *all, *z[3];
    int k;

    assert_int_equal(cohsm_builder_create(desc, &b), COHSM_OK);
    n = cohsm_builder_view_count(b);
    all = (float *)malloc(12 * (size_t)pixels * n);
    assert_true(all && out);
    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) z[k] = all + ((size_t)3 * i + (size_t)k) * pixels;
        assert_int_equal(cohsm_builder_view(b, i, &v), COHSM_OK);
        assert_int_equal(v.index, i);
        cast_view(m, &v, size, z);
        assert_int_equal(cohsm_builder_add(b, i, z[0], z[1], z[2]), COHSM_OK);
    }
    assert_int_equal(cohsm_builder_finish(b, &maps, &stats), COHSM_OK);
    cell = cells_of(b, maps);
    map_count = desc->domain.kind == COHSM_DOMAIN_LATLONG || desc->domain.kind == COHSM_DOMAIN_OCTAHEDRAL ? n : n / 6;
    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) z[k] = all + ((size_t)3 * i + (size_t)k) * pixels;
        assert_int_equal(cohsm_depths(maps, i / map_count * map_count + cell[i % map_count], out), COHSM_OK);
        for (p = 0; p < pixels; p++) {
            uint32_t lo = quantised(z[0][p]), z2 = quantised(z[1][p]), z3 = quantised(z[2][p]), upper, hi;
            /* a sheet is open_thickness pixels thick; a pixel is 2 / M of the distance in a cube's face */
            float pixel = v.depth_scale > 0.0f ? 2.0f * (float)lo : 65536.0f;
            float sheet = (desc->open_thickness > 0.0f ? desc->open_thickness : 8.0f) / (float)size * pixel;
            upper = desc->layers == COHSM_LAYERS_Z1Z3_FAR ? (z3 == 65535 ? 65536 : z3)
                    : z2 != 65535                         ? z2
                                                          : lo + 1 + (uint32_t)sheet;
            if (desc->layers != COHSM_LAYERS_Z1Z3_FAR && upper > 65535) upper = 65535;
            hi = lo == 65535 ? 65535 : upper > lo ? upper - 1 : lo;
            if (lo == 65535 && desc->self_only) lo = 0;
            t.entries++;
            t.wrong += out[p] < lo || out[p] > hi;
            t.empty += lo != 65535 && upper <= lo;
            t.open += quantised(z[0][p]) != 65535 && z2 == 65535;
            t.exact += !grid_meets(lo, hi, desc->depth_bits ? desc->depth_bits : 8);
        }
    }
    assert_int_equal(stats.empty_intervals, t.empty);
    assert_int_equal(stats.open_entries, t.open);
    assert_int_equal(stats.exact_depths, t.exact);
    cohsm_free(maps);
    cohsm_builder_free(b);
    free(cell);
    free(all);
    free(out);
    return t;
}

static void t59_every_stored_value_separates_the_layers_of_rays(void **state)
{
    model shape[3];
    int s, k;
    uint64_t entries = 0;
    (void)state;
    shape[0] = model_sphere(14, 9, 0.15);
    shape[1] = model_soup(24, 0.4, 5);
    shape[2] = model_torus(14, 8, 0.7, 0.25);
    for (s = 0; s < 3; s++)
        for (k = 0; k < 7; k++) {
            cohsm_desc d = desc_of(all_kinds[k], k == 6 ? 3 : k < 2 ? 8 : 4, 10);
            tally t;
            d.radius = 1.3f;
            d.depth_bits = 4 + (uint32_t)(k + s) % 5;
            d.layers = k % 3 == 1 ? COHSM_LAYERS_Z1Z3_FAR : COHSM_LAYERS_Z1Z2;
            d.order = (cohsm_order)(1 + (k + s) % 4);
            d.self_only = k == 3;
            d.open_thickness = s == 1 ? 0.5f * (float)k : 0.0f;
            place_domain(&d, -0.8f, 2.0f, -0.9f, 1.5f);
            t = lossless_by_hand(&d, &shape[s]);
            assert_int_equal(t.wrong, 0);
            entries += t.entries;
            print_message(
                "T59 rays: shape %d, domain %d, depth_bits %u: %lu entries, %lu wrong, %lu with z1 = z2, %lu open, "
                "%lu exact\n",
                s, (int)all_kinds[k], d.depth_bits, (unsigned long)t.entries, (unsigned long)t.wrong,
                (unsigned long)t.empty, (unsigned long)t.open, (unsigned long)t.exact);
        }
    CONFORM_NOTE("T59", "depths compared with the layers of own rays, three shapes, seven domains: none outside",
                 entries);
    for (s = 0; s < 3; s++) model_free(&shape[s]);
}

static void build_and_verify(const cohsm_desc *d, const cohsm_mesh *mesh, cohsm_report *report, cohsm_stats *stats)
{
    cohsm_maps *maps;
    assert_int_equal(cohsm_build(d, mesh, &maps, stats), COHSM_OK);
    assert_int_equal(cohsm_verify(maps, d ? &d->system : NULL, mesh, report), COHSM_OK);
    assert_int_equal(report->wrong, 0);
    assert_int_equal(report->empty, stats->empty_intervals);
    cohsm_free(maps);
}

static void t59_verify_finds_no_wrong_value(void **state)
{
    model m = model_sphere(24, 14, 0.2);
    cohsm_mesh mesh = mesh_of(&m);
    uint64_t entries = 0, empty = 0, exact = 0, wrong = 0;
    int k, l, bits;
    (void)state;
    for (k = 0; k < 7; k++)
        for (l = 1; l <= 3; l++)
            for (bits = 4; bits <= 8; bits += 2) {
                cohsm_desc d = desc_of(all_kinds[k], k == 6 ? 3 : 6, 24);
                cohsm_report r;
                cohsm_stats s;
                d.layers = (cohsm_layers)l;
                d.depth_bits = (uint32_t)bits;
                d.order = (cohsm_order)(1 + (k + l) % 4);
                place_domain(&d, -1.0f, 2.5f, -1.0f, 2.0f);
                build_and_verify(&d, &mesh, &r, &s);
                entries += r.entries;
                wrong += r.wrong;
                empty += r.empty;
                exact += s.exact_depths;
            }
    CONFORM("T59", "stored depths outside of their interval, by cohsm_verify over 63 descs", 0, wrong, 0);
    print_message("T59 verify: %lu entries, 0 wrong, %lu with z1 = upper, %lu exact\n", (unsigned long)entries,
                  (unsigned long)empty, (unsigned long)exact);
    model_free(&m);
}

/* The verifier must see damage: the same block against another mesh. */
static void t59_verify_sees_a_wrong_block(void **state)
{
    model a = model_sphere(20, 12, 0.0), b = model_sphere(20, 12, 0.0);
    cohsm_mesh mesh = mesh_of(&a), other = mesh_of(&b);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 8, 24);
    cohsm_maps *maps;
    cohsm_report r;
    size_t i;
    (void)state;
    for (i = 0; i < 3 * b.vertices; i++) b.p[i] *= 0.5f;
    assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
    assert_int_equal(cohsm_verify(maps, NULL, &other, &r), COHSM_OK);
    assert_int_equal(r.entries, 64 * 24 * 24);
    assert_true(r.wrong > 1000);
    assert_true(r.first_view < 64 && r.first_pixel < 24 * 24);
    print_message("T59 verify: %lu of %lu entries wrong against a smaller sphere\n", (unsigned long)r.wrong,
                  (unsigned long)r.entries);
    cohsm_free(maps);
    model_free(&a);
    model_free(&b);
}

/* Shards tell of the same damage: as many wrong entries in all, each names one of its own pixels, and the first of
   these is the whole block's. */
static void t59_verify_sees_wrong_shards(void **state)
{
    static const uint32_t cut[4] = { 0, 150, 151, 24 * 24 };
    model a = model_sphere(20, 12, 0.0), b = model_sphere(20, 12, 0.0);
    cohsm_mesh mesh = mesh_of(&a), other = mesh_of(&b);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 8, 24);
    cohsm_maps *maps;
    cohsm_report whole, r, first;
    uint64_t wrong = 0;
    size_t i;
    (void)state;
    for (i = 0; i < 3 * b.vertices; i++) b.p[i] *= 0.5f;
    assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
    assert_int_equal(cohsm_verify(maps, NULL, &other, &whole), COHSM_OK);
    cohsm_free(maps);
    memset(&first, 0xff, sizeof first);
    for (i = 0; i < 3; i++) {
        d.pixel_begin = cut[i];
        d.pixel_end = cut[i + 1];
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        assert_int_equal(cohsm_verify(maps, NULL, &other, &r), COHSM_OK);
        cohsm_free(maps);
        assert_int_equal(r.entries, 64 * (cut[i + 1] - cut[i]));
        wrong += r.wrong;
        if (!r.wrong) continue;
        assert_true(r.first_pixel >= cut[i] && r.first_pixel < cut[i + 1]);
        if (r.first_view < first.first_view) first = r;
    }
    assert_int_equal(wrong, whole.wrong);
    assert_int_equal(first.first_view, whole.first_view);
    assert_int_equal(first.first_pixel, whole.first_pixel);
    model_free(&a);
    model_free(&b);
}

/* z1 = z2 in every entry: a double wall. Each entry is stored at z1 and counted. */
static void t59_equal_layers_are_counted(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 6, 8);
    cohsm_builder *b;
    cohsm_maps *maps;
    cohsm_stats s;
    float z[36][64];
    uint16_t out[64];
    uint64_t seed = 3;
    uint32_t i, p, *cell;
    (void)state;
    d.radius = 1;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    for (i = 0; i < 36; i++) {
        for (p = 0; p < 64; p++) z[i][p] = (float)rnd(&seed);
        assert_int_equal(cohsm_builder_add(b, i, z[i], z[i], z[i]), COHSM_OK);
    }
    assert_int_equal(cohsm_builder_finish(b, &maps, &s), COHSM_OK);
    cell = cells_of(b, maps);
    for (i = 0; i < 36; i++) {
        assert_int_equal(cohsm_depths(maps, cell[i], out), COHSM_OK);
        for (p = 0; p < 64; p++) assert_int_equal(out[p], quantised(z[i][p]));
    }
    CONFORM("T59", "entries with z1 = z2 counted, 36 views of 64", 36 * 64, s.empty_intervals, 0);
    print_message("T59: %lu entries with z1 = z2, %lu segments, %lu exact\n", (unsigned long)s.empty_intervals,
                  (unsigned long)s.segments, (unsigned long)s.exact_depths);
    free(cell);
    cohsm_free(maps);
    cohsm_builder_free(b);
}

/* ---- T60 ---- */

/* Fewest segments for intervals lo[i]..hi[i], by dynamic programming over all starts. A segment may hold views that one
   grid value separates, or one view alone. */
static uint32_t fewest(const uint32_t *lo, const uint32_t *hi, uint32_t n, uint32_t bits, uint32_t *best)
{
    uint32_t grid = (1u << bits) - 1u, i, j;
    best[0] = 0;
    for (i = 1; i <= n; i++) {
        uint32_t l = 0, h = 65535;
        best[i] = best[i - 1] + 1;
        for (j = i; j > 0; j--) {
            uint32_t v;
            l = lo[j - 1] > l ? lo[j - 1] : l;
            h = hi[j - 1] < h ? hi[j - 1] : h;
            if (l > h) break;
            v = l == 65535 ? grid : (l * grid + 65534u) / 65535u;     /* the least grid value that may do */
            if ((v < grid ? v * 65535u / grid : 65535u) > h) break;
            if (best[j - 1] + 1 < best[i]) best[i] = best[j - 1] + 1;
        }
    }
    return best[n];
}

static void random_interval(uint64_t *seed, uint32_t style, float *z1, float *z2)
{
    double a = rnd(seed), b = rnd(seed);
    switch (style) {
    case 0: *z1 = (float)(a < b ? a : b); *z2 = (float)(a < b ? b : a); break;                   /* any */
    case 1: *z1 = (float)(0.5 + 0.02 * a); *z2 = *z1 + (float)(0.05 * b); break;                 /* alike */
    case 2: *z1 = (float)a; *z2 = *z1 + 1e-3f * (float)b; break;                                 /* thin */
    default: *z1 = a < 0.3 ? 2.0f : (float)(0.4 * b); *z2 = a < 0.6 ? 2.0f : *z1 + 0.5f;         /* holes, open */
    }
    if (*z2 < *z1) *z2 = *z1;
}

static void t60_case(uint32_t n, uint32_t bits, uint64_t seed, uint64_t *total, uint64_t *least)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, 4);
    cohsm_builder *b;
    cohsm_maps *maps;
    cohsm_stats s;
    float *at = (float *)calloc(4 * (size_t)n, 4), z1[16], z2[16];
    uint32_t *lo = (uint32_t *)malloc(64 * (size_t)n), *hi = (uint32_t *)malloc(64 * (size_t)n), i, p, sum = 0;
    uint32_t *best = (uint32_t *)malloc(4 * ((size_t)n + 1));
    uint16_t out[16];

    assert_true(at && lo && hi && best);
    for (i = 0; i < n; i++) rnd_direction(&seed, at + 4 * i);
    d.domain.locations = at;
    d.domain.location_count = n;
    d.depth_bits = bits;
    d.radius = 1;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    for (i = 0; i < n; i++) {
        for (p = 0; p < 16; p++) {
            random_interval(&seed, p % 4, &z1[p], &z2[p]);
            lo[p * n + i] = quantised(z1[p]);
            hi[p * n + i] = lo[p * n + i] == 65535 ? 65535 : quantised(z2[p]) - 1;
            if (hi[p * n + i] < lo[p * n + i] || quantised(z2[p]) == 0) hi[p * n + i] = lo[p * n + i];
        }
        assert_int_equal(cohsm_builder_add(b, i, z1, z2, NULL), COHSM_OK);
    }
    assert_int_equal(cohsm_builder_finish(b, &maps, &s), COHSM_OK);
    for (p = 0; p < 16; p++) sum += fewest(lo + p * n, hi + p * n, n, bits, best);
    assert_int_equal(s.segments, sum);
    for (i = 0; i < n; i++) {
        assert_int_equal(cohsm_depths(maps, i, out), COHSM_OK);
        for (p = 0; p < 16; p++)
            if (out[p] < lo[p * n + i] || out[p] > hi[p * n + i])
                fail_msg("n %u, bits %u, view %u, pixel %u: %u is not in %u..%u", n, bits, i, p, out[p], lo[p * n + i],
                         hi[p * n + i]);
    }
    *total += s.segments;
    *least += sum;
    cohsm_free(maps);
    cohsm_builder_free(b);
    free(at);
    free(lo);
    free(hi);
    free(best);
}

static void t60_greedy_is_the_dynamic_programming_minimum(void **state)
{
    static const uint32_t counts[9] = { 1, 2, 3, 17, 64, 65, 200, 700, 1500 };
    uint64_t total = 0, least = 0;
    uint32_t bits, i;
    (void)state;
    for (bits = 4; bits <= 8; bits++)
        for (i = 0; i < 9; i++) t60_case(counts[i], bits, 1000 * bits + i, &total, &least);
    CONFORM("T60", "segments of random intervals, 1 to 1500 views, against dynamic programming", least, total, 0);
    print_message("T60: %lu segments, dynamic programming %lu\n", (unsigned long)total, (unsigned long)least);
}

/* More views than a chunk of 65,536: the segments of each chunk are minimal, and every view decodes. */
static void t60_lists_of_more_than_65536_views_decode(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 0, 4);
    cohsm_builder *b;
    cohsm_maps *maps;
    cohsm_stats s;
    uint64_t seed = 77, sum = 0;
    uint32_t n, i, p, *lo, *hi, *best, split;
    float z1[16], z2[16];
    (void)state;
    d.domain.side[0] = 300;
    d.domain.side[1] = 300;
    d.radius = 1;
    d.order = COHSM_ORDER_SCANLINE;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    n = cohsm_builder_view_count(b);
    assert_int_equal(n, 90000);
    lo = (uint32_t *)malloc(64 * (size_t)n);
    hi = (uint32_t *)malloc(64 * (size_t)n);
    best = (uint32_t *)malloc(4 * ((size_t)n + 1));
    assert_true(lo && hi && best);
    for (i = 0; i < n; i++) {
        for (p = 0; p < 16; p++) {
            random_interval(&seed, p % 4, &z1[p], &z2[p]);
            if (p == 5) { z1[p] = 0.25f; z2[p] = 0.75f; }       /* the same in all maps: one segment a chunk */
            lo[p * n + i] = quantised(z1[p]);
            hi[p * n + i] = lo[p * n + i] == 65535 ? 65535 : quantised(z2[p]) - 1;
            if (hi[p * n + i] < lo[p * n + i] || quantised(z2[p]) == 0) hi[p * n + i] = lo[p * n + i];
        }
        assert_int_equal(cohsm_builder_add(b, i, z1, z2, NULL), COHSM_OK);
    }
    assert_int_equal(cohsm_builder_finish(b, &maps, &s), COHSM_OK);
    for (p = 0; p < 16; p++) {
        if (p == 5) {               /* one a chunk; the programme would look back over all of it for every view */
            sum += 2;
            continue;
        }
        for (split = 0; split < n; split += 65536)
            sum += fewest(lo + p * n + split, hi + p * n + split, n - split < 65536 ? n - split : 65536, 8, best);
    }
    CONFORM("T60", "segments of 90,000 views in two chunks, against dynamic programming", sum, s.segments, 0);
    for (i = 0; i < n; i++) {
        uint16_t out[16];
        assert_int_equal(cohsm_depths(maps, i, out), COHSM_OK);
        for (p = 0; p < 16; p++) assert_true(out[p] >= lo[p * n + i] && out[p] <= hi[p * n + i]);
    }
    print_message("T60: 90,000 views: %lu segments, dynamic programming in two chunks %lu\n", (unsigned long)s.segments,
                  (unsigned long)sum);
    cohsm_free(maps);
    cohsm_builder_free(b);
    free(lo);
    free(hi);
    free(best);
}

/* ---- T63 ---- */

static void t63_a_sphere_takes_one_segment_a_pixel(void **state)
{
    uint32_t side, p, i;
    (void)state;
    for (side = 2; side <= 64; side *= 4) {
        cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, side, 32);
        cohsm_builder *b;
        cohsm_maps *maps;
        cohsm_stats s;
        cohsm_info info;
        float z1[1024], z2[1024];
        d.radius = 1;
        for (p = 0; p < 1024; p++) {
            double x = (p % 32 + 0.5) / 16 - 1, y = (p / 32 + 0.5) / 16 - 1, r2 = x * x + y * y;
            z1[p] = r2 < 1 ? (float)(0.5 - 0.5 * sqrt(1 - r2)) : 2.0f;
            z2[p] = r2 < 1 ? (float)(0.5 + 0.5 * sqrt(1 - r2)) : 2.0f;
        }
        assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
        for (i = 0; i < side * side; i++) assert_int_equal(cohsm_builder_add(b, i, z1, z2, NULL), COHSM_OK);
        assert_int_equal(cohsm_builder_finish(b, &maps, &s), COHSM_OK);
        cohsm_get_info(maps, &info);
        assert_int_equal(s.segments, 1024);
        assert_int_equal(info.segment_count, 1024);
        /* 4 bytes a segment + 4 bytes of lookup, as the paper counts */
        print_message(
            "T63: N %u: %lu segments (M^2 = 1024), ratio in the paper's format %.2f (N/4 = %.2f), ours %.2f\n",
            side * side, (unsigned long)s.segments, (double)side * side * 1024 * 2 / (8.0 * (double)s.segments),
            side * side / 4.0, info.ratio);
        assert_true((double)side * side * 1024 * 2 / (8.0 * (double)s.segments) == side * side / 4.0);
        if (side == 32) {
            CONFORM("T63", "segments, N 1024, M 32", 32 * 32, s.segments, 0);
            CONFORM("T63", "ratio in the paper's format, N 1024", 256,
                    side * side * 1024 * 2 / (8.0 * (double)s.segments), 0);
        }
        cohsm_free(maps);
        cohsm_builder_free(b);
    }
}

/* ---- T64 ---- */

/* A real model where ASSETS has it, else a built-in one. */
static void load_model(const char *name, const char *other, model *out)
{
    const char *folder = getenv("ASSETS");
    char path[512], error[EX_ERROR_SIZE];
    ex_scene scene;
    size_t k;

    snprintf(path, sizeof path, "%s/%s.glb", folder ? folder : "", name);
    if (!folder || !*folder || ex_scene_load(&scene, path, error) != 0)
        assert_int_equal(ex_scene_builtin(&scene, other, 0, error), 0);
    print_message("T64: %s, %lu triangles\n", scene.name, (unsigned long)scene.meshes[0].triangle_count);
    *out = model_alloc(scene.meshes[0].vertex_count, scene.meshes[0].triangle_count);
    memcpy(out->p, scene.meshes[0].positions, 12 * out->vertices);
    for (k = 0; k < out->indices; k++) out->i[k] = scene.meshes[0].indices[k];
    ex_scene_free(&scene);
}

static double segments_with(const cohsm_mesh *mesh, cohsm_domain_kind kind, uint32_t side, cohsm_orientation frame)
{
    cohsm_desc d = desc_of(kind, side, 64);
    cohsm_maps *maps;
    cohsm_stats s;
    d.order = COHSM_ORDER_HILBERT;
    d.orientation = frame;
    assert_int_equal(cohsm_build(&d, mesh, &maps, &s), COHSM_OK);
    cohsm_free(maps);
    return (double)s.segments;
}

/* The product is over the objects: a default is the best for a kind of domain, not for one object. */
static void t64_the_default_frame_is_within_2_percent_of_the_best(void **state)
{
    static const char *const names[2] = { "bunny", "dragon" }, *const others[2] = { "knot", "figure" };
    static const cohsm_domain_kind kinds[2] = { COHSM_DOMAIN_LATLONG, COHSM_DOMAIN_OCTAHEDRAL };
    double product[2][4] = { { 1, 1, 1, 1 }, { 1, 1, 1, 1 } };
    uint32_t side = 16;
    int i, k, f;
    (void)state;
    for (i = 0; i < 2; i++) {
        model m;
        cohsm_mesh mesh;
        load_model(names[i], others[i], &m);
        mesh = mesh_of(&m);
        for (k = 0; k < 2; k++) {
            double s[4];
            for (f = 0; f < 4; f++) {
                s[f] = segments_with(&mesh, kinds[k], side, (cohsm_orientation)f);
                product[k][f] *= s[f];
            }
            print_message("T64, %s, side %u, M 64: default %.0f, polar %.0f, minimal %.0f, two poles %.0f segments\n",
                          k ? "octahedral" : "latlong", side, s[0], s[1], s[2], s[3]);
        }
        model_free(&m);
    }
    for (k = 0; k < 2; k++) {
        double best = product[k][1];
        for (f = 2; f < 4; f++) best = product[k][f] < best ? product[k][f] : best;
        print_message("T64 %s: the default takes %.4f of the best frame's segments\n", k ? "octahedral" : "latlong",
                      sqrt(product[k][0] / best));
        CONFORM_MAX("T64", k ? "segments with the default frame over the best frame's, octahedral" :
                    "segments with the default frame over the best frame's, latlong", 1.02, sqrt(product[k][0] / best));
    }
}

/* ---- T65 ---- */

static void cell_of_view(const cohsm_builder *b, uint32_t index, const uint32_t *side, uint32_t *c)
{
    cohsm_view v;
    assert_int_equal(cohsm_builder_view(b, index, &v), COHSM_OK);
    assert_int_equal(v.index, index);
    c[0] = (uint32_t)(v.location[0] * (float)side[0]);
    c[1] = (uint32_t)(v.location[1] * (float)side[1]);
    c[2] = (uint32_t)(v.location[2] * (float)side[2]);
}

/* Unit line, square or cube as local domain: locations are cell coordinates. Counts steps that are not to
   a neighbour. */
static void walk(uint32_t dims, const uint32_t *side, cohsm_order order, uint32_t *diagonal, uint32_t *far)
{
    cohsm_desc d;
    cohsm_builder *b;
    uint32_t n = side[0] * side[1] * side[2], i, k, face, c[3], before[3] = { 0, 0, 0 };
    uint8_t *seen = (uint8_t *)calloc(n, 1);

    memset(&d, 0, sizeof d);
    d.domain.kind = dims == 1 ? COHSM_DOMAIN_LINE : dims == 2 ? COHSM_DOMAIN_RECTANGLE : COHSM_DOMAIN_VOLUME;
    memcpy(d.domain.side, side, sizeof d.domain.side);
    d.domain.u[0] = d.domain.v[1] = d.domain.w[2] = 1;
    d.map_side = 4;
    d.radius = 1;
    d.order = order;
    *diagonal = *far = 0;
    assert_non_null(seen);
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    assert_int_equal(cohsm_builder_view_count(b), 6 * n);
    for (face = 0; face < 6; face += 5) {
        memset(seen, 0, n);
        for (i = 0; i < n; i++) {
            uint32_t steps = 0, longest = 0;
            cohsm_view v;
            cell_of_view(b, face * n + i, side, c);
            assert_int_equal(cohsm_builder_view(b, face * n + i, &v), COHSM_OK);
            assert_int_equal(v.face, face);
            assert_true(c[0] < side[0] && c[1] < side[1] && c[2] < side[2]);
            assert_int_equal(seen[c[0] + side[0] * (c[1] + side[1] * c[2])]++, 0);
            for (k = 0; k < 3; k++) {
                uint32_t step = c[k] > before[k] ? c[k] - before[k] : before[k] - c[k];
                steps += step;
                longest = step > longest ? step : longest;
                before[k] = c[k];
            }
            if (i == 0 || face) continue;
            *diagonal += steps == 2 && longest == 1;
            *far += steps > 2 || longest > 1;
        }
    }
    cohsm_builder_free(b);
    free(seen);
}

static int power_of_two(uint32_t x) { return (x & (x - 1)) == 0; }

static void t65_orders_visit_every_cell_once_and_step_to_neighbours(void **state)
{
    static const uint32_t sides[][3] = { { 1, 1, 1 },    { 7, 1, 1 },    { 64, 1, 1 },  { 2, 2, 1 },   { 4, 4, 1 },
                                         { 16, 16, 1 },  { 64, 64, 1 },  { 8, 2, 1 },   { 2, 8, 1 },   { 16, 4, 1 },
                                         { 3, 5, 1 },    { 5, 3, 1 },    { 7, 7, 1 },   { 13, 8, 1 },  { 1, 9, 1 },
                                         { 9, 1, 1 },    { 33, 20, 1 },  { 20, 33, 1 }, { 15, 12, 1 }, { 6, 100, 1 },
                                         { 37, 61, 1 },  { 128, 96, 1 }, { 2, 2, 2 },   { 4, 4, 4 },   { 8, 8, 8 },
                                         { 16, 16, 16 }, { 3, 4, 5 },    { 5, 5, 5 },   { 1, 6, 7 },   { 4, 2, 8 },
                                         { 6, 6, 3 },    { 10, 12, 14 }, { 3, 1, 4 } };
    uint32_t i, order, worst2 = 0, worst3 = 0, tried = 0;
    (void)state;
    for (i = 0; i < sizeof sides / sizeof sides[0]; i++) {
        const uint32_t *s = sides[i];
        uint32_t dims = s[2] > 1 ? 3 : s[1] > 1 ? 2 : 1;
        for (order = 1; order < COHSM_ORDER_COUNT; order++) {
            uint32_t diagonal, far, exact = order == COHSM_ORDER_ZIGZAG || order == COHSM_ORDER_ZIGZAG_THETA;
            walk(dims, s, (cohsm_order)order, &diagonal, &far);
            tried++;
            if (order == COHSM_ORDER_SCANLINE) continue;
            if (order == COHSM_ORDER_HILBERT) exact = power_of_two(s[0]) && power_of_two(s[1]) && power_of_two(s[2]);
            if (far || (exact && diagonal) || (dims < 3 && diagonal > 1))
                fail_msg("%u x %u x %u, order %u: %u diagonal, %u longer steps", s[0], s[1], s[2], order, diagonal,
                         far);
            if (dims == 3) worst3 = diagonal > worst3 ? diagonal : worst3;
            else worst2 = diagonal > worst2 ? diagonal : worst2;
        }
    }
    print_message("T65: %u walks; most diagonal steps %u in 1-D and 2-D, %u in 3-D\n", tried, worst2, worst3);
    CONFORM_MAX("T65", "diagonal steps of any walk in 1-D and 2-D (sizes that are no powers of two)", 1, worst2);
    CONFORM_MAX("T65", "diagonal steps of any walk in 3-D", 1, worst3);
}

/* Every order finds its maps again: each view gets a depth of its own, and is asked for by its cell. */
static void t65_every_cell_is_found_again(void **state)
{
    static const uint32_t sides[][3] = { { 5, 7, 1 }, { 8, 8, 1 }, { 11, 1, 1 },
                                         { 3, 4, 5 }, { 4, 4, 4 }, { 257, 256, 1 } };
    uint32_t i, order, v, p;
    (void)state;
    for (i = 0; i < 6; i++)
        for (order = 1; order < COHSM_ORDER_COUNT; order++) {
            const uint32_t *s = sides[i];
            uint32_t n = s[0] * s[1] * s[2], c[3], views;
            cohsm_desc d;
            cohsm_builder *b;
            cohsm_maps *maps;
            float z[16];
            memset(&d, 0, sizeof d);
            d.domain.kind = s[2] > 1 ? COHSM_DOMAIN_VOLUME : s[1] > 1 ? COHSM_DOMAIN_RECTANGLE : COHSM_DOMAIN_LINE;
            memcpy(d.domain.side, s, sizeof d.domain.side);
            d.domain.u[0] = d.domain.v[1] = d.domain.w[2] = 1;
            d.map_side = 4;
            d.radius = 1;
            d.order = (cohsm_order)order;
            assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
            views = cohsm_builder_view_count(b);
            for (v = 0; v < views; v++) {
                uint32_t cell, key;
                cell_of_view(b, v, s, c);
                cell = c[0] + s[0] * (c[1] + s[1] * c[2]);
                key = (cell + v / n * 7919u) * 40503u % 65521u;
                for (p = 0; p < 16; p++) z[p] = ((float)key + 0.5f) / 65533.0f;
                assert_int_equal(cohsm_builder_add(b, v, z, z, NULL), COHSM_OK);
            }
            assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_OK);
            for (v = 0; v < views; v += n > 1000 ? 97 : 1) {
                uint16_t out[16];
                uint32_t key = (v % n + v / n * 7919u) * 40503u % 65521u;
                float at[4];
                assert_int_equal(cohsm_depths(maps, v, out), COHSM_OK);
                if (out[0] != key || out[15] != key)
                    fail_msg("sides %u, order %u, map %u: %u, not %u", i, order, v, out[0], key);
                assert_int_equal(cohsm_location(maps, v % n, at), COHSM_OK);
                assert_int_equal((uint32_t)(at[0] * (float)s[0]), v % n % s[0]);
            }
            cohsm_free(maps);
            cohsm_builder_free(b);
        }
}

/* ---- bytes: threads, shards, intrinsics ---- */

static int same_bytes(const cohsm_maps *a, const cohsm_maps *b)
{
    size_t n, k;
    const void *p = cohsm_data(a, &n), *q = cohsm_data(b, &k);
    return n == k && memcmp(p, q, n) == 0;
}

static cohsm_maps *build(const cohsm_desc *d, const model *m, cohsm_stats *s)
{
    cohsm_mesh mesh = mesh_of(m);
    cohsm_maps *maps = NULL;
    assert_int_equal(cohsm_build(d, &mesh, &maps, s), COHSM_OK);
    return maps;
}

static void bytes_do_not_depend_on_threads(void **state)
{
    model m = model_soup(300, 0.3, 9);
    int k, l, threads;
    (void)state;
    for (k = 0; k < 7; k++)
        for (l = 1; l <= 3; l++) {
            cohsm_desc d = desc_of(all_kinds[k], k == 6 ? 3 : k < 2 ? 12 : 4, 20);
            cohsm_maps *one;
            cohsm_stats s1;
            d.layers = (cohsm_layers)l;
            d.order = k % 2 ? COHSM_ORDER_DEFAULT : COHSM_ORDER_ZIGZAG;
            place_domain(&d, -1, 1.8f, -1, 2);
            one = build(&d, &m, &s1);
            for (threads = 2; threads <= 9; threads += 7) {
                team t;
                cohsm_maps *many;
                cohsm_stats s;
                cohsm_mesh mesh = mesh_of(&m);
                cohsm_report r;
                memset(&t, 0, sizeof t);
                pthread_mutex_init(&t.lock, NULL);
                t.threads = threads;
                d.system.parallel_for = team_for;
                d.system.user = &t;
                many = build(&d, &m, &s);
                assert_true(same_bytes(one, many));
                assert_true(s.peak_bytes >= s1.peak_bytes);     /* with threads there are more views in a batch */
                s.peak_bytes = s1.peak_bytes;
                assert_memory_equal(&s, &s1, sizeof s);
                assert_int_equal(cohsm_verify(many, &d.system, &mesh, &r), COHSM_OK);
                assert_int_equal(r.wrong, 0);
                cohsm_free(many);
                pthread_mutex_destroy(&t.lock);
            }
            cohsm_free(one);
        }
    model_free(&m);
}

static void shards_join(const cohsm_desc *desc, const model *m, const uint32_t *cuts, size_t count)
{
    cohsm_desc d = *desc;
    cohsm_maps *whole = build(&d, m, NULL), *joined = NULL, *shard[16] = { NULL };
    size_t i;
    for (i = 0; i < count; i++) {
        cohsm_info info;
        cohsm_report r;
        cohsm_mesh mesh = mesh_of(m);
        d.pixel_begin = cuts[i];
        d.pixel_end = cuts[i + 1];
        shard[i] = build(&d, m, NULL);
        cohsm_get_info(shard[i], &info);
        assert_int_equal(info.pixel_begin, cuts[i]);
        assert_int_equal(info.pixel_end, cuts[i + 1]);
        assert_int_equal(cohsm_verify(shard[i], NULL, &mesh, &r), COHSM_OK);
        assert_int_equal(r.wrong, 0);
        assert_int_equal(r.entries, (uint64_t)info.view_count * (cuts[i + 1] - cuts[i]));
    }
    assert_int_equal(cohsm_merge((const cohsm_maps *const *)shard, count, NULL, &joined), COHSM_OK);
    assert_true(same_bytes(whole, joined));
    for (i = 0; i < count; i++) cohsm_free(shard[i]);
    cohsm_free(joined);
    cohsm_free(whole);
}

static void merged_shards_are_the_unsharded_bytes(void **state)
{
    static const uint32_t cuts[5][6] = {
        { 0, 576 }, { 0, 288, 576 }, { 0, 1, 2, 575, 576 }, { 0, 100, 317, 333, 500, 576 }, { 0, 24, 552, 576 }
    };
    static const size_t parts[5] = { 1, 2, 4, 5, 3 };
    model m = model_soup(120, 0.35, 4);
    int k, i;
    (void)state;
    for (k = 0; k < 7; k++)
        for (i = 0; i < 5; i++) {
            cohsm_desc d = desc_of(all_kinds[k], k == 6 ? 3 : 5, 24);
            d.order = (cohsm_order)(1 + (k + i) % 4);
            d.layers = (cohsm_layers)(1 + i % 3);
            place_domain(&d, -1, 1.8f, -1, 2);
            shards_join(&d, &m, cuts[i], parts[i]);
        }
    model_free(&m);
}

static void shards_of_more_than_65536_views_merge(void **state)
{
    static const uint32_t cuts[4] = { 0, 5, 6, 36 };
    model m = model_soup(5, 0.5, 2);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 260, 6);
    (void)state;
    d.order = COHSM_ORDER_HILBERT;
    shards_join(&d, &m, cuts, 3);
    model_free(&m);
}

/* Views of a column go through the clusters that one of them may see, a slab of 16 after the other in stretches of 512:
   this mesh has more than one stretch, and a shard's rows see parts of it. */
static void shards_of_many_clusters_merge(void **state)
{
    static const uint32_t cuts[4] = { 0, 200, 331, 576 };
    model m = model_sphere(96, 48, 0.3);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 9, 24);
    (void)state;
    assert_true(mesh_of(&m).index_count / 3 > 512 * 16);
    d.order = COHSM_ORDER_HILBERT;
    shards_join(&d, &m, cuts, 3);
    model_free(&m);
}

static int no_hole(void *user, uint32_t triangle, const float weights[3])
{
    (void)user, (void)triangle, (void)weights;
    return 1;
}

/* Draws a view of a mesh without a mask by the kernels of a level. */
static void draw_by_kernels(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup, int level)
{
    cohsm__column *column = (cohsm__column *)calloc(1, sizeof *column);
    assert_non_null(column);
    cohsm__raster_column(t, cam, 1, soup, level, column);
    free(column);
}

/* Moves corners to multiples of a quarter of a pixel, so that samples lie on corners and edges of an image along the
   axes. */
static void model_snap(model *m, float quarter)
{
    size_t i;
    for (i = 0; i < 3 * m->vertices; i++) m->p[i] = (float)(int)(m->p[i] / quarter) * quarter;
}

/* A mesh with a mask is drawn triangle by triangle; one without is drawn by kernels, many triangles at once, and those
   of one sample by their own rules. Every third round has samples on edges and corners, half of the others many
   triangles of one sample. */
static void all_kernels_draw_what_single_triangles_draw(void **state)
{
    uint64_t seed = 8, drawn = 0;
    int round;
    (void)state;
    for (round = 0; round < 90; round++) {
        static const int sizes[6] = { 4, 7, 31, 64, 200, 1024 };
        int size = sizes[round % 6];
        model m = model_soup(1 + (uint32_t)round * 2, round % 2 ? 0.02 * round : 4.0 / size, seed++);
        cohsm_mesh mesh = mesh_of(&m);
        uint32_t triangles = (uint32_t)(m.indices / 3), i;
        uint8_t used[256];
        float center[3] = { 0, 0, 0 }, d[3] = { 0, 1, 0 };
        int level;
        cohsm__counted_heap heap;
        cohsm__soup alone, soup;
        cohsm__camera cam;
        cohsm__target a, b;
        size_t n = (size_t)(size * size) * 4;

        memset(used, 1, sizeof used);
        memset(&heap, 0, sizeof heap);
        heap.allocator = cohsm__allocator_make(NULL, NULL, NULL);
        if (round % 3 == 0) model_snap(&m, 2.5f / (float)(2 * size));
        else rnd_direction(&seed, d);
        assert_true(cohsm__soup_make(&soup, &mesh, used, triangles, center, 2.5f, &heap));
        mesh.mask_fn = no_hole;
        assert_true(cohsm__soup_make(&alone, &mesh, used, triangles, center, 2.5f, &heap));
        memset(&cam, 0, sizeof cam);
        cam.axes = cohsm__axes_of(COHSM_ORIENTATION_TWO_POLES, cohsm__v3_load(d));
        a.size = size;
        a.keep = round & 1 ? 4 : 2;
        a.row_begin = round % 4 == 3 ? size / 3 : 0;
        a.row_end = round % 4 == 3 ? size / 3 + 1 : size;
        a.z = (uint16_t *)calloc(n, 2);
        b = a;
        b.z = (uint16_t *)calloc(n, 2);
        assert_true(a.z && b.z);
        cohsm__raster_view(&a, &cam, &alone, 0);
        for (level = 0; level <= cohsm__simd(); level++) {
            draw_by_kernels(&b, &cam, &soup, level);
            for (i = 0; i < n; i++)
                if (a.z[i] != b.z[i])
                    fail_msg("round %d, value %u: %u alone, %u by level %d", round, i, a.z[i], b.z[i], level);
        }
        for (i = 0; i < n; i++) drawn += a.z[i] && a.z[i] != COHSM__INFINITE;
        free(a.z);
        free(b.z);
        cohsm__soup_free(&alone, &heap);
        cohsm__soup_free(&soup, &heap);
        model_free(&m);
    }
    assert_true(drawn > 100000);
}

/* The rasteriser against rays: away from edges, where corners rounded to 1/256 pixel decide, all three layers agree. */
static void the_rasteriser_agrees_with_rays(void **state)
{
    model m = model_sphere(16, 10, 0.15);
    int k;
    (void)state;
    for (k = 0; k < 4; k++) {
        cohsm_desc d = desc_of(k < 2 ? all_kinds[k] : COHSM_DOMAIN_RECTANGLE, 3, 32);
        cohsm_builder *b;
        cohsm_mesh mesh = mesh_of(&m);
        cohsm__counted_heap heap;
        cohsm__soup soup;
        cohsm_view v;
        uint8_t used[512];
        uint64_t compared = 0, differ = 0;
        uint32_t i, p, n;
        float z[3][1024], *zp[3];
        uint16_t r[4 * 1024];
        cohsm__target t;
        d.radius = 1.3f;
        d.order = COHSM_ORDER_HILBERT;
        place_domain(&d, k == 3 ? -0.2f : -1.0f, k == 3 ? 0.0f : 2.0f, k == 3 ? -0.2f : -1.0f, k == 3 ? 0.4f : 2.0f);
        assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
        memset(used, 1, sizeof used);
        memset(&heap, 0, sizeof heap);
        heap.allocator = cohsm__allocator_make(NULL, NULL, NULL);
        assert_true(cohsm__soup_make(&soup, &mesh, used, (uint32_t)(m.indices / 3), d.center, d.radius, &heap));
        t.z = r;
        t.keep = 4;
        t.size = 32;
        t.row_begin = 0;
        t.row_end = 32;
        n = cohsm_builder_view_count(b);
        for (i = 0; i < n; i++) {
            cohsm__camera cam = cohsm__camera_of(&b->head, b->locations, b->angles, b->cells[i % b->head.map_count],
                                                 i / b->head.map_count);
            assert_int_equal(cohsm_builder_view(b, i, &v), COHSM_OK);
            for (p = 0; p < 3; p++) zp[p] = z[p];
            cast_view(&m, &v, 32, zp);
            if (cam.perspective) cohsm__raster_view(&t, &cam, &soup, 0);
            else draw_by_kernels(&t, &cam, &soup, 0);
            for (p = 0; p < 1024; p++) {
                int layer;
                for (layer = 0; layer < 3; layer++) {
                    int a = (int)quantised(z[layer][p]), c = r[4 * p + (uint32_t)layer];
                    compared++;
                    differ += abs(a - c) > 40;          /* 40: 1/512 pixel of 2.6 on a slope of 10 */
                }
            }
        }
        print_message("raster: domain %d: %lu of %lu depths differ by more than 40/65533\n", (int)d.domain.kind,
                      (unsigned long)differ, (unsigned long)compared);
        assert_true((double)differ <= 0.01 * (double)compared);
        cohsm__soup_free(&soup, &heap);
        cohsm_builder_free(b);
    }
    model_free(&m);
}

/* ---- memory and progress ---- */

/* Counts the tasks of the first call, by which a build draws its first batch. */
static void count_tasks(void *user, size_t count, cohsm_task task, void *context)
{
    size_t *first = (size_t *)user, i;
    if (!*first) *first = count;
    for (i = 0; i < count; i++) task(context, i);
}

/* As documented at cohsm_build; all segments, where it says those of the last 65,536 maps. */
static double documented_bytes(const cohsm_desc *d, size_t triangles, uint32_t maps, uint64_t segments, size_t block)
{
    const double m = (double)d->map_side * d->map_side, n = d->pixel_end ? d->pixel_end - d->pixel_begin : m;
    const int views = d->map_side > 128 ? 32 : d->system.parallel_for ? 128 : 64;
    double t = 40.0 * (double)triangles, whole;
    whole = t + (d->system.parallel_for ? 15e5 : 8e5) + views * (d->layers == COHSM_LAYERS_Z1Z2 ? 4.0 : 8.0) * m +
            80 * n + 4.0 * maps + 16.0 * (double)segments + 2.0 * (double)block;
    /* From 32 maps a side on a trial has a quarter of these, of M / 2 pixels a side, and keeps all views: 4 bytes. */
    if (d->order == COHSM_ORDER_DEFAULT) whole += 20 * m + (maps * m / 16 < 34e6 ? maps * m / 16 : 34e6);
    return whole > 100.0 * (double)triangles ? whole : 100.0 * (double)triangles;
}

static void peak_memory_is_as_documented(void **state)
{
    model m = model_soup(2000, 0.05, 3);
    static const uint32_t sides[6] = { 4, 16, 40, 300, 40, 96 };
    size_t tasks = 0;
    int i, wrong = 0;
    (void)state;
    for (i = 0; i < 6; i++) {
        cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, sides[i], i == 3 ? 8 : i == 5 ? 128 : 64);
        cohsm_stats s;
        cohsm_info info;
        cohsm_maps *maps;
        ledger l;
        double bound;
        d.layers = i == 1 ? COHSM_LAYERS_Z1Z3_SPHERE : COHSM_LAYERS_Z1Z2;
        d.order = i == 5 ? COHSM_ORDER_DEFAULT : COHSM_ORDER_HILBERT;
        if (i == 4) d.system.parallel_for = count_tasks;
        if (i == 4) d.system.user = &tasks;
        if (i == 5) d.pixel_end = 256;          /* of a small shard, what the trials take is most of all */
        d.system.allocator = ledger_allocator(&l);
        maps = build(&d, &m, &s);
        cohsm_get_info(maps, &info);
        bound = documented_bytes(&d, 2000, info.map_count, s.segments, info.bytes);
        print_message("memory: side %u, M %u: peak %lu counted, %lu reported, %.0f documented, block %lu\n", sides[i],
                      d.map_side, (unsigned long)l.peak, (unsigned long)s.peak_bytes, bound, (unsigned long)info.bytes);
        wrong += l.peak != s.peak_bytes || (double)l.peak > bound;
        assert_true(l.live > 0 && l.used >= info.bytes);
        cohsm_free(maps);
        assert_int_equal(l.live, 0);
        assert_int_equal(l.wrong, 0);
    }
    assert_int_equal(wrong, 0);
    model_free(&m);
}

/* Whatever axes the views of a batch have, sixteen threads have a task each; of maps beyond 128 pixels, whose batches
   have 32 views, if these have several axes to the right. */
static void a_batch_is_drawn_by_sixteen_tasks(void **state)
{
    static const cohsm_order orders[3] = { COHSM_ORDER_HILBERT, COHSM_ORDER_SCANLINE, COHSM_ORDER_ZIGZAG_THETA };
    model m = model_sphere(12, 8, 0.1);
    int i;
    (void)state;
    for (i = 0; i < 12; i++) {
        cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 32, i < 6 ? 16 : 132);
        size_t tasks = 0;
        d.order = orders[i % 3];
        d.orientation = i % 2 ? COHSM_ORIENTATION_TWO_POLES : COHSM_ORIENTATION_POLAR;
        if (i >= 6) d.pixel_end = 132;
        d.system.parallel_for = count_tasks;
        d.system.user = &tasks;
        cohsm_free(build(&d, &m, NULL));
        if (tasks != (i < 6 || i % 2 || i % 3 == 1 ? 16 : 4))
            fail_msg("M %u, order %d, orientation %d: %lu tasks", d.map_side, (int)d.order, (int)d.orientation,
                     (unsigned long)tasks);
    }
    model_free(&m);
}

typedef struct meter { float last; int calls, stop_at, bad; } meter;

static int watch(void *user, float fraction)
{
    meter *w = (meter *)user;
    if (!(fraction >= w->last && fraction >= 0.0f && fraction <= 1.0f)) w->bad++;
    w->last = fraction;
    return ++w->calls == w->stop_at ? -7 : 0;
}

static void progress_rises_and_cancels_without_a_trace(void **state)
{
    model m = model_sphere(20, 12, 0.1);
    cohsm_mesh mesh = mesh_of(&m);
    int order, calls, k, verify;
    (void)state;
    for (verify = 0; verify < 2; verify++)
        for (order = 0; order <= 1; order++) {
            cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 20, 16);
            cohsm_maps *good = build(&d, &m, NULL);
            meter w = { 0, 0, 0, 0 };
            ledger l;
            d.order = order ? COHSM_ORDER_DEFAULT : COHSM_ORDER_ZIGZAG;
            d.system.allocator = ledger_allocator(&l);
            d.system.progress = watch;
            d.system.user = &w;
            if (verify) {
                cohsm_report r;
                assert_int_equal(cohsm_verify(good, &d.system, &mesh, &r), COHSM_OK);
            } else cohsm_free(build(&d, &m, NULL));
            assert_true(w.calls >= 400 / 64 + (verify ? 0 : 6));         /* and 3 batches for each frame tried */
            assert_int_equal(w.bad, 0);
            calls = w.calls;
            for (k = 1; k <= calls; k++) {
                cohsm_maps *maps = (cohsm_maps *)(void *)&w;
                cohsm_stats s, s0;
                cohsm_report r, r0;
                memset(&s, 0x77, sizeof s);
                memset(&r, 0x77, sizeof r);
                s0 = s;
                r0 = r;
                w.last = 0;
                w.calls = 0;
                w.stop_at = k;
                if (verify) assert_int_equal(cohsm_verify(good, &d.system, &mesh, &r), COHSM_ERR_CANCELLED);
                else assert_int_equal(cohsm_build(&d, &mesh, &maps, &s), COHSM_ERR_CANCELLED);
                assert_ptr_equal(maps, &w);
                assert_memory_equal(&s, &s0, sizeof s);
                assert_memory_equal(&r, &r0, sizeof r);
                assert_int_equal(l.live, 0);
                assert_int_equal(w.calls, k);
            }
            cohsm_free(good);
        }
    model_free(&m);
}

/* Calls that build nothing, on lists enough for each to ask several times. */

enum { OPEN_PLAIN, OPEN_PACKED, PACK, MERGE, SERVICED };

typedef struct bundle {
    cohsm_maps *whole, *shard[2];
    void       *plain, *packed;         /* files */
    size_t      plain_size, packed_size;
} bundle;

static void bundle_make(bundle *b, const model *m)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 3, 104);
    d.order = COHSM_ORDER_ZIGZAG;
    b->whole = build(&d, m, NULL);
    cohsm_data(b->whole, &b->plain_size);
    b->plain = malloc(b->plain_size);
    assert_non_null(b->plain);
    assert_int_equal(cohsm_write(b->whole, b->plain, b->plain_size), COHSM_OK);
    assert_int_equal(cohsm_pack(b->whole, NULL, &b->packed, &b->packed_size), COHSM_OK);
    d.pixel_end = 5000;
    b->shard[0] = build(&d, m, NULL);
    d.pixel_begin = 5000;
    d.pixel_end = 104 * 104;
    b->shard[1] = build(&d, m, NULL);
}

static void bundle_free(bundle *b)
{
    cohsm_free(b->whole);
    cohsm_free(b->shard[0]);
    cohsm_free(b->shard[1]);
    free(b->plain);
    free(b->packed);
}

/* One call. What it makes must be what is known; *made and *size are 1 before. */
static cohsm_result serviced(int call, const bundle *b, const cohsm_desc *d, void **made, size_t *size)
{
    cohsm_maps *maps = (cohsm_maps *)*made;
    cohsm_result r;
    if (call == PACK) {
        r = cohsm_pack(b->whole, &d->system, made, size);
        if (r != COHSM_OK) return r;
        assert_int_equal(*size, b->packed_size);
        assert_memory_equal(*made, b->packed, *size);
        d->system.allocator.free_fn(*made, d->system.allocator.user);
        return r;
    }
    if (call == MERGE) r = cohsm_merge((const cohsm_maps *const *)b->shard, 2, &d->system, &maps);
    else if (call == OPEN_PACKED) r = cohsm_open(b->packed, b->packed_size, &d->system, &maps);
    else r = cohsm_open(b->plain, b->plain_size, &d->system, &maps);
    if (r == COHSM_OK) {
        assert_memory_equal(cohsm_data(maps, size), cohsm_data(b->whole, NULL), b->plain_size);
        assert_int_equal(*size, b->plain_size);
        cohsm_free(maps);
    } else *made = maps;
    return r;
}

static void calls_that_build_nothing_tell_progress_and_cancel_without_a_trace(void **state)
{
    static const int asked[SERVICED] = { 3, 169 + 3, 2 * 169 + 3, 2 * 3 };
    static char untouched;
    model m = model_sphere(20, 12, 0.1);
    bundle b;
    int call, calls, k;
    (void)state;
    bundle_make(&b, &m);
    for (call = 0; call < SERVICED; call++) {
        cohsm_desc d;
        meter w = { 0, 0, 0, 0 };
        ledger l;
        void *made = &untouched;
        size_t size = 1;
        memset(&d, 0, sizeof d);
        d.system.allocator = ledger_allocator(&l);
        d.system.progress = watch;
        d.system.user = &w;
        assert_int_equal(serviced(call, &b, &d, &made, &size), COHSM_OK);
        assert_int_equal(w.bad, 0);
        assert_int_equal(w.calls, asked[call]);
        assert_true(w.last > 0.75f);
        assert_int_equal(l.live, 0);
        for (k = 1, calls = w.calls; k <= calls; k++) {
            made = &untouched;
            size = 1;
            w.last = 0;
            w.calls = 0;
            w.stop_at = k;
            assert_int_equal(serviced(call, &b, &d, &made, &size), COHSM_ERR_CANCELLED);
            assert_int_equal(w.calls, k);
            assert_true(k > 1 || w.last == 0.0f);
            assert_ptr_equal(made, &untouched);
            assert_int_equal(size, 1);
            assert_int_equal(l.live, 0);
            assert_int_equal(l.wrong, 0);
        }
    }
    bundle_free(&b);
    model_free(&m);
}

static void a_budget_is_one_progress(void **state)
{
    model m = model_sphere(20, 12, 0.1);
    cohsm_mesh mesh = mesh_of(&m);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 0, 0);
    meter w = { 0, 0, 0, 0 };
    ledger l;
    uint32_t side, size;
    int calls, i;
    (void)state;
    d.system.allocator = ledger_allocator(&l);
    d.system.progress = watch;
    d.system.user = &w;
    assert_int_equal(cohsm_budget(&d, &mesh, 1000000, &side, &size), COHSM_OK);
    assert_int_equal(w.bad, 0);
    calls = w.calls;
    assert_true(calls >= (256 + 1024) / 64 && w.last > 0.9f);
    for (i = 0; i < 3; i++) {
        meter stopped = { 0, 0, 0, 0 };
        stopped.stop_at = i == 0 ? 1 : i == 1 ? calls / 2 : calls;
        d.system.user = &stopped;
        side = size = 7;
        assert_int_equal(cohsm_budget(&d, &mesh, 1000000, &side, &size), COHSM_ERR_CANCELLED);
        assert_true(stopped.calls == stopped.stop_at && side == 7 && size == 7 && l.live == 0);
    }
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t59_every_stored_value_separates_the_layers_of_rays),
        cmocka_unit_test(t59_verify_finds_no_wrong_value),
        cmocka_unit_test(t59_verify_sees_a_wrong_block),
        cmocka_unit_test(t59_verify_sees_wrong_shards),
        cmocka_unit_test(t59_equal_layers_are_counted),
        cmocka_unit_test(t60_greedy_is_the_dynamic_programming_minimum),
        cmocka_unit_test(t60_lists_of_more_than_65536_views_decode),
        cmocka_unit_test(t63_a_sphere_takes_one_segment_a_pixel),
        cmocka_unit_test(t64_the_default_frame_is_within_2_percent_of_the_best),
        cmocka_unit_test(t65_orders_visit_every_cell_once_and_step_to_neighbours),
        cmocka_unit_test(t65_every_cell_is_found_again),
        cmocka_unit_test(bytes_do_not_depend_on_threads),
        cmocka_unit_test(merged_shards_are_the_unsharded_bytes),
        cmocka_unit_test(shards_of_more_than_65536_views_merge),
        cmocka_unit_test(shards_of_many_clusters_merge),
        cmocka_unit_test(all_kernels_draw_what_single_triangles_draw),
        cmocka_unit_test(the_rasteriser_agrees_with_rays),
        cmocka_unit_test(peak_memory_is_as_documented),
        cmocka_unit_test(a_batch_is_drawn_by_sixteen_tasks),
        cmocka_unit_test(progress_rises_and_cancels_without_a_trace),
        cmocka_unit_test(a_budget_is_one_progress),
        cmocka_unit_test(calls_that_build_nothing_tell_progress_and_cancel_without_a_trace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
