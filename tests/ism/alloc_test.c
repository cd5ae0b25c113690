/* alloc_test - an allocation that fails, at every site: once, and from then on. No crash, no leak, ISM_ERR_ALLOC,
   output untouched, and the same maps go on working. Peak memory is what the stats say. */

#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

enum { W = 16, H = 8, PIXELS = W * H, NEAR = 16 /* near points a VPL */ };

static soup mesh;
static grid lit, eye;

static void make(ism_mesh *m, ism_source *s, ism_points *view, ism_frame *f)
{
    const float lo[3] = { -1, 0.5f, -1 }, hi[3] = { 0, 1, 1 }, a[3] = { -2, 0, -2 }, u[3] = { 4, 0, 0 },
                v[3] = { 0, 0, 4 };
    const float up[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 }, high[3] = { -2, 2, -2 };
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, 1, 2);
    *m = soup_mesh(&mesh);
    grid_fill(&lit, 8, 8, a, u, v, up, 1);
    grid_fill(&eye, W, H, high, u, v, down, 0);
    *s = grid_source(&lit);
    *view = grid_view(&eye);
    memset(f, 0, sizeof *f);
    f->mesh = m;
    f->sources = s;
    f->source_count = 1;
    f->points = view;
}

static ism_desc small_desc(ledger *l)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = 16;
    d.surfel_count = 64;
    d.tile_side = 16;
    d.keep_hits = 1;
    d.system.allocator = ledger_allocator(l);
    return d;
}

static void every_allocation_fails(void **state)
{
    ism_mesh m;
    ism_source s;
    ism_points view;
    ism_frame f;
    int then_on;
    long at;
    (void)state;
    make(&m, &s, &view, &f);
    for (then_on = 0; then_on < 2; then_on++)
        for (at = 0;; at++) {
            ledger l;
            ism_desc d = small_desc(&l);
            ism_maps *maps = NULL;
            ism_shading shading = { 0 };
            float out[3 * PIXELS], before[3 * PIXELS];
            ism_result r;
            shading.interleave = 2;
            memset(out, 0x31, sizeof out);
            memcpy(before, out, sizeof out);
            l.fail_at = at;
            l.from_then_on = then_on;
            r = ism_create(&d, &maps);
            if (r == ISM_OK) r = ism_render(maps, &f, &shading, out, NULL);
            else assert_null(maps);
            if (r == ISM_OK) {
                assert_true((long)l.calls <= at);       /* none failed: all sites have been tried */
                ism_free(maps);
                assert_int_equal(l.live, 0);
                break;
            }
            assert_int_equal(r, ISM_ERR_ALLOC);
            assert_memory_equal(out, before, sizeof out);
            l.fail_at = -1;
            if (maps) assert_int_equal(ism_render(maps, &f, &shading, out, NULL), ISM_OK);
            ism_free(maps);
            assert_int_equal(l.live, 0);
        }
    assert_true(at > 10);
}

/* A choice that needs more room than the one before, and does not get it: its importances are none. */
static void a_choice_that_failed_has_no_importances(void **state)
{
    static const float a[3] = { -2, 0, -2 }, u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 }, up[3] = { 0, 1, 0 };
    ism_mesh m;
    ism_source s[2];
    ism_points view;
    ism_frame f;
    long at;
    (void)state;
    for (at = 0; at < 4; at++) {
        ledger l;
        ism_desc d = small_desc(&l);
        ism_maps *maps;
        size_t count;
        make(&m, s, &view, &f);
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_choose(maps, &f), ISM_OK);
        grid_fill(&lit, 32, 32, a, u, v, up, 1);
        s[0] = s[1] = grid_source(&lit);
        f.source_count = 2;
        l.fail_at = (long)l.calls + at;
        assert_int_equal(ism_choose(maps, &f), ISM_ERR_ALLOC);
        assert_null(ism_importances(maps, 0, &count));
        l.fail_at = -1;
        assert_int_equal(ism_choose(maps, &f), ISM_OK);
        assert_non_null(ism_importances(maps, 1, &count));
        assert_int_equal(count, 32 * 32);
        ism_free(maps);
        assert_int_equal(l.live, 0);
    }
}

static void emitters_may_fail_too(void **state)
{
    static float radiance[3 * 4096];
    float p[30], n[30], flux[30];
    ism_mesh m;
    ism_source s;
    ism_points view;
    ism_frame f;
    long at;
    size_t i;
    (void)state;
    make(&m, &s, &view, &f);
    for (i = 0; i < 3 * 4096; i++) radiance[i] = 1;
    for (at = 0; at < 2; at++) {
        ledger l;
        ism_system system = { ledger_allocator(&l), NULL, NULL, NULL, NULL };
        l.fail_at = at;
        assert_int_equal(ism_emitter_points(&m, radiance, 10, 0, &system, p, n, flux), ISM_ERR_ALLOC);
        assert_int_equal(l.live, 0);
    }
}

/* The manual's formula of what is kept, but for the 8 KB at most that do not depend on the frame. Of so few triangles,
   each is a cluster. */
static size_t kept_bytes(const ism_desc *d, const ism_source *s)
{
    size_t n = d->vpl_count, side = 1, texels = (size_t)d->tile_side * d->tile_side;
    while (side * side < n) side++;
    return 12 * n * d->surfel_count + (d->keep_hits ? 8 : 4) * side * side * texels + 2444 * texels +
           (16 + 768) * mesh.triangles + 832 * (mesh.triangles / 16 + 1) + 20 * (size_t)s->width * s->height +
           16 * s->height + 40 + 4 * PIXELS + 244 * n + 112 * n * NEAR + n * NEAR / 4;
}

static void peak_is_what_the_stats_say(void **state)
{
    enum { BLOCKS = (W + 15) / 16 * ((H + 15) / 16) };
    size_t besides = 0;
    int way;
    (void)state;
    for (way = 0; way < 3; way++) {
        ledger l;
        ism_desc d = small_desc(&l);
        ism_maps *maps;
        ism_mesh m;
        ism_source s;
        ism_points view;
        ism_frame f;
        ism_stats stats;
        ism_shading shading = { 0 };
        float out[3 * PIXELS];
        size_t kept, shaded;
        make(&m, &s, &view, &f);
        if (way) d.vpl_count = 20, d.surfel_count = 100, d.tile_side = 64, d.keep_hits = 0;
        if (way == 2) d.vpl_count = 4096, d.surfel_count = 8, d.tile_side = 8;    /* what there is of each VPL shows */
        mesh.triangles -= 2 * (size_t)way;      /* of 48, which are three bundles of clusters, and one that is empty */
        m = soup_mesh(&mesh);
        shading.interleave = way ? 2 : 1;
        kept = kept_bytes(&d, &s);
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_choose(maps, &f), ISM_OK);
        assert_int_equal(ism_build(maps, &f), ISM_OK);
        stats = util_stats(maps);
        assert_int_equal(stats.bytes, l.now);
        assert_int_equal(stats.peak_bytes, l.peak);
        assert_in_range(stats.bytes, kept, kept + 8191);
        if (!way) besides = stats.bytes - kept;
        assert_int_equal(stats.bytes - kept, besides);      /* the formula has all that grows with a frame */
        assert_int_equal(ism_shade(maps, &view, &shading, out, &stats), ISM_OK);
        assert_int_equal(stats.bytes, l.now);
        assert_int_equal(stats.peak_bytes, l.peak);
        shaded = stats.bytes + (size_t)((way ? 24 : 12) * PIXELS + 32 * BLOCKS) + 64 * d.vpl_count;
        assert_in_range(stats.peak_bytes, shaded, shaded + 8191 - (stats.bytes - kept));
        ism_free(maps);
        assert_int_equal(l.live, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_fails),
        cmocka_unit_test(a_choice_that_failed_has_no_importances),
        cmocka_unit_test(emitters_may_fail_too),
        cmocka_unit_test(peak_is_what_the_stats_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
