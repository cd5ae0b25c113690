/* points_rows_test - surfels and maps: the rows of ism/rows.h, area of an adaptive cloud (T53), lazy renewal (T54, E9),
   solid angles of splats (T48), pull and push (T49). */

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "conformance.h"
#include "util.h"

#define ROW_TEST(state) (void)(state);
#include "rows.h"

/* ---- the rows by ism.h ---- */

static void row_directions(ism_projection p, float exponent, const float *uv, size_t count, float *d)
{
    size_t i;
    for (i = 0; i < count; i++) ism_map_direction(p, exponent, uv + 2 * i, d + 3 * i);
}

static void row_coordinates(ism_projection p, float exponent, const float *d, size_t count, float *uv, uint8_t *there)
{
    size_t i;
    for (i = 0; i < count; i++) {
        uv[2 * i] = -1;
        there[i] = ism_map_coordinates(p, exponent, d + 3 * i, uv + 2 * i) != 0;
        assert_true(there[i] || uv[2 * i] < 0);
    }
}

static void row_form_factors(const float normal[3], const float *corners, size_t count, float *f)
{
    size_t i;
    for (i = 0; i < count; i++) f[i] = util_form_factor(normal, corners + 12 * i);
}

struct engine { ism_maps *maps; ism_points view; };

static engine *engine_open(const ism_desc *desc, const ism_points *view)
{
    engine *e = (engine *)calloc(1, sizeof *e);
    assert_non_null(e);
    assert_int_equal(ism_create(desc, &e->maps), ISM_OK);
    e->view = *view;
    return e;
}

static void engine_close(engine *e)
{
    ism_free(e->maps);
    free(e);
}

static ism_maps *engine_maps(engine *e) { return e->maps; }

static void engine_draw(engine *e, const ism_frame *frame)
{
    assert_int_equal(ism_build(e->maps, frame), ISM_OK);
}

static float *engine_atlas(engine *e, uint32_t *side)
{
    const float *from = ism_atlas(e->maps, side, NULL);
    const size_t size = (size_t)*side * *side * sizeof *from;
    float *atlas = (float *)malloc(size);
    assert_non_null(atlas);
    return (float *)memcpy(atlas, from, size);
}

static void engine_shade(engine *e, const ism_shading *shading, float *light, double *lost)
{
    ism_stats stats;
    assert_int_equal(ism_shade(e->maps, &e->view, shading, light, &stats), ISM_OK);
    if (lost) *lost = stats.lost_energy;
}

static void engine_bounce(engine *e, const ism_frame *frame, uint32_t side, float *p, float *n, float *flux)
{
    assert_int_equal(ism_bounce(e->maps, frame->mesh, side, p, n, flux), ISM_OK);
}

/* ---- what only the CPU computes ---- */

static double triangle_area(size_t t)
{
    const float *p = mesh.p + 9 * t;
    double a[3], b[3], n[3];
    int k;
    for (k = 0; k < 3; k++) {
        a[k] = (double)p[3 + k] - (double)p[k];
        b[k] = (double)p[6 + k] - (double)p[k];
    }
    for (k = 0; k < 3; k++) n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    return 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

static double cloud_area(const ism_maps *m)
{
    static ism_surfel points[4096];
    size_t n, j, count;
    uint32_t v;
    double sum = 0;
    ism_vpls(m, &count);
    for (v = 0; v < count; v++) {
        assert_int_equal(ism_surfels(m, v, points, 4096, &n), ISM_OK);
        for (j = 0; j < n; j++) sum += (double)points[j].area * triangle_area(points[j].triangle) / (double)count;
    }
    return sum;
}

static void an_adaptive_cloud_keeps_the_area(void **state)
{
    static const char *const names[5] = { "", "points by area", "by 1 view sample", "by 8 view samples",
                                          "by view and VPL" };
    ism_mesh m;
    ism_points view;
    int spread;
    (void)state;
    make_room(&m, &view);
    for (spread = 1; spread < ISM_SPREAD_COUNT; spread++) {
        ism_frame f = frame_of(&m, &view, 0);
        ism_vpl v[32];
        ism_desc d;
        ism_maps *maps;
        ism_stats s;
        char text[80];
        int i;
        for (i = 0; i < 32; i++) v[i] = util_vpl(-3 + 0.1f * (float)i, 0, 0, 0, 1, 0, 1);
        memset(&d, 0, sizeof d);
        d.vpl_count = 32;
        d.surfel_count = 4096;
        d.tile_side = 16;
        d.spread = (ism_spread)spread;
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_set_vpls(maps, v, 32), ISM_OK);
        assert_int_equal(ism_build(maps, &f), ISM_OK);
        s = util_stats(maps);
        snprintf(text, sizeof text, "%s: sum of their areas over the surface", names[spread]);
        /* stratified: a triangle's share is off by one point at most; 3 sigma of the rest */
        CONFORM("T53", text, 1, cloud_area(maps) / s.surface_area, 0.002);
        ism_free(maps);
    }
}

static void lazy_renewal_reaches_all_points(void **state)
{
    static ism_surfel before[1024], after[1024];
    ism_mesh m;
    ism_points view;
    ism_vpl v = util_vpl(0, 0, 0, 0, 1, 0, 1);
    ism_desc d;
    ism_maps *maps, *fresh;
    ism_frame f;
    size_t n, j, left = 0, moved = 0, off = 0;
    uint64_t touched = 0;
    uint32_t i;
    (void)state;
    make_room(&m, &view);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    d.surfel_count = 1024;
    assert_int_equal(ism_create(&d, &maps), ISM_OK);
    assert_int_equal(ism_set_vpls(maps, &v, 1), ISM_OK);
    f = frame_of(&m, &view, 0);
    assert_int_equal(ism_build(maps, &f), ISM_OK);
    assert_int_equal(ism_surfels(maps, 0, before, 1024, &n), ISM_OK);
    /* the view jumps to the other end; after eight frames the points are those of a new set of maps */
    for (i = 0; i < 3 * 16 * 9; i += 3) eye.p[i] += 5;
    for (i = 1; i <= 8; i++) {
        ism_stats s;
        f = frame_of(&m, &view, i);
        assert_int_equal(ism_build(maps, &f), ISM_OK);
        s = util_stats(maps);
        touched += s.renewed;
        assert_int_equal(ism_surfels(maps, 0, after, 1024, &n), ISM_OK);
        for (j = 0; j < n; j++)
            if (memcmp(&before[j], &after[j], sizeof before[j])) moved += j % 8 != i % 8;
        memcpy(before, after, sizeof before);
    }
    assert_int_equal(ism_create(&d, &fresh), ISM_OK);
    assert_int_equal(ism_set_vpls(fresh, &v, 1), ISM_OK);
    assert_int_equal(ism_build(fresh, &f), ISM_OK);
    assert_int_equal(ism_surfels(fresh, 0, before, 1024, &n), ISM_OK);
    for (j = 0; j < n; j++) left += memcmp(&before[j], &after[j], sizeof before[j]) != 0;
    CONFORM("T54", "points renewed in eight frames", 1024, (double)touched, 0);
    CONFORM("T54", "of 1024 points, not those of a new view after eight frames", 0, (double)left, 0);
    CONFORM("T54", "points that changed out of their turn", 0, (double)moved, 0);
    /* the mesh bends: points of an old frame stay on their triangles by construction; they are drawn where it is now */
    for (i = 0; i < 9 * mesh.triangles; i += 3) mesh.p[i] += 0.2f * mesh.p[i + 1];
    f = frame_of(&m, &view, 9);
    assert_int_equal(ism_build(maps, &f), ISM_OK);
    assert_int_equal(ism_surfels(maps, 0, before, 1024, &n), ISM_OK);
    for (j = 0; j < n; j++)
        off += before[j].triangle >= mesh.triangles || before[j].barycentric[0] + before[j].barycentric[1] > 1.00002f;
    for (j = 0; j < n; j++) off += j % 8 != 1 && memcmp(&before[j], &after[j], sizeof before[j]) != 0;
    CONFORM("T54", "points off their triangles after it bent", 0, (double)off, 0);
    ism_free(maps);
    ism_free(fresh);
}

/* ---- E9: triangles that come and go ---- */

enum { STRIPS = 300, CROWD = 16, EACH = 1200 };

typedef struct crowd {
    ism_maps  *maps;
    ism_mesh   mesh;
    ism_points view;
    ism_frame  frame;
    uint32_t   lazy;
    ism_surfel is[CROWD][EACH], was[CROWD][EACH];
} crowd;

/* STRIPS triangles of area 1 to 4, and points on them by area, for CROWD VPLs. */
static crowd *crowd_open(uint32_t lazy_frames)
{
    static const float place[3] = { 0, 5, 0 }, up[3] = { 0, 1, 0 };
    static float strips[9 * STRIPS];
    crowd *c = (crowd *)calloc(1, sizeof *c);
    ism_vpl v[CROWD];
    ism_desc d;
    uint32_t i;
    assert_non_null(c);
    for (i = 0; i < STRIPS; i++) {
        const float z = (float)i, size = 2 * (float)(1 + i % 4), corners[9] = { 0, 0, z, size, 0, z, 0, 1, z };
        memcpy(strips + 9 * i, corners, sizeof corners);
    }
    for (i = 0; i < CROWD; i++) v[i] = util_vpl(-1, 0, (float)i, 1, 0, 0, 1);
    memset(&d, 0, sizeof d);
    d.vpl_count = CROWD;
    d.surfel_count = EACH;
    d.tile_side = 8;
    d.lazy_frames = lazy_frames;
    d.spread = ISM_SPREAD_AREA;
    assert_int_equal(ism_create(&d, &c->maps), ISM_OK);
    assert_int_equal(ism_set_vpls(c->maps, v, CROWD), ISM_OK);
    c->lazy = lazy_frames;
    c->mesh.positions = strips;
    c->view.count = 1;
    c->view.positions = place;
    c->view.normals = up;
    c->frame.mesh = &c->mesh;
    c->frame.points = &c->view;
    return c;
}

/* Scatters a frame of that many triangles. Returns how many points are others than in the frame before, though their
   triangle is there and it is another phase's turn; *renewed counts those of the other phases that had to move. */
static size_t crowd_frame(crowd *c, uint32_t triangles, size_t *renewed)
{
    const uint32_t index = ++c->frame.index, lazy = c->lazy;
    size_t wrong = 0, gone = 0, due = 0, n, i;
    uint32_t v;
    c->mesh.vertex_count = 3 * (size_t)triangles;
    memcpy(c->was, c->is, sizeof c->is);
    assert_int_equal(ism_scatter(c->maps, &c->frame), ISM_OK);
    for (v = 0; v < CROWD; v++) {
        assert_int_equal(ism_surfels(c->maps, v, c->is[v], EACH, &n), ISM_OK);
        assert_int_equal(n, EACH);
        for (i = 0; i < n; i++) {
            assert_true(c->is[v][i].triangle < triangles);
            if (i % lazy == index % lazy) due++;
            else if (c->was[v][i].triangle >= triangles) gone++;
            else wrong += memcmp(&c->is[v][i], &c->was[v][i], sizeof c->is[v][i]) != 0;
        }
    }
    *renewed = gone;
    if (index > 1) assert_int_equal(util_stats(c->maps).renewed, due + gone);
    return index > 1 ? wrong : 0;
}

/* The share of the points on triangles from first on, over the share of the area that these have of `all`. */
static double crowd_share(const crowd *c, uint32_t first, uint32_t end, uint32_t all)
{
    double area = 0, whole = 0, has = 0;
    uint32_t i, v;
    for (i = 0; i < all; i++) whole += 1 + i % 4;
    for (i = first; i < end; i++) area += 1 + i % 4;
    for (v = 0; v < CROWD; v++)
        for (i = 0; i < EACH; i++) has += c->is[v][i].triangle >= first && c->is[v][i].triangle < end;
    return has / (CROWD * EACH) / (area / whole);
}

static void triangles_that_come_and_go_leave_the_points_of_the_others(void **state)
{
    crowd *c = crowd_open(8);
    size_t gone, moved, k;
    double worst = 0;
    uint32_t i;
    (void)state;
    (void)crowd_frame(c, 300, &gone);
    assert_true(fabs(crowd_share(c, 200, 300, 300) - 1) < 1e-3);
    moved = crowd_frame(c, 200, &gone);
    CONFORM("T54", "100 of 300 triangles go: points of the others that move out of their turn", 0, (double)moved, 0);
    /* a third of the points, but for those of the phase: stratified, so that one at each end of a VPL's may be off */
    CONFORM("T54", "the same: share of the points that are drawn anew at once, of the third that lay there", 1,
            (double)gone / (CROWD * EACH * 7 / 8 / 3.0), 0.004);
    /* 5,600 of 19,200 points are drawn without strata: 4 sigma of their share in a tenth of the triangles */
    for (i = 0; i < 10; i++) worst = fmax(worst, fabs(crowd_share(c, 20 * i, 20 * i + 20, 200) - 1));
    CONFORM("T54", "the same: points in each tenth of the area left, greatest deviation from a tenth", 0, worst, 0.05);
    for (i = 0; i < 8; i++) {
        (void)crowd_frame(c, 200, &gone);
        assert_int_equal(gone, 0);
    }
    for (worst = 0, i = 0; i < 10; i++) worst = fmax(worst, fabs(crowd_share(c, 20 * i, 20 * i + 20, 200) - 1));
    CONFORM("T54", "the same, eight frames later: the strata are whole again", 0, worst, 0.01);
    for (k = 0, moved = 0; k < 8; k++) {            /* 100 come: a phase of their points a frame */
        moved += crowd_frame(c, 300, &gone);
        assert_int_equal(gone, 0);
        assert_true(fabs(crowd_share(c, 200, 300, 300) - (double)(k + 1) / 8) < 2e-3);
    }
    CONFORM("T54", "100 triangles come back: points that move out of their turn", 0, (double)moved, 0);
    CONFORM("T54", "the same: after eight frames, points on them over their share of the area", 1,
            crowd_share(c, 200, 300, 300), 1e-3);
    ism_free(c->maps);
    free(c);
}

/* Twenty triangles fewer each frame: points that are drawn anew several times do not gather on the last ones. */
static void triangles_that_go_one_after_the_other_leave_an_even_crowd(void **state)
{
    crowd *c = crowd_open(64);
    double worst = 0;
    uint32_t i, left;
    size_t gone, moved;
    (void)state;
    (void)crowd_frame(c, 300, &gone);
    for (left = 280, moved = 0; left >= 100; left -= 20) moved += crowd_frame(c, left, &gone);
    for (i = 0; i < 10; i++) worst = fmax(worst, fabs(crowd_share(c, 10 * i, 10 * i + 10, 100) - 1));
    printf("after ten times: a tenth of the area has a tenth of the points but for %.4f\n", worst);
    assert_int_equal(moved, 0);
    assert_true(worst < 0.12);      /* 1,766 to 2,074 points a tenth, whose areas are 23 to 27: 5 sigma of binomials */
    ism_free(c->maps);
    free(c);
}

/* A mesh with other numbers: once without a mesh, and all points are made anew, as for new maps. */
static void without_a_mesh_all_points_begin_anew(void **state)
{
    crowd *c = crowd_open(8), *fresh = crowd_open(8);
    size_t gone;
    (void)state;
    (void)crowd_frame(c, 300, &gone);
    c->frame.mesh = NULL;
    assert_int_equal(ism_scatter(c->maps, &c->frame), ISM_OK);
    c->frame.mesh = &c->mesh;
    c->frame.index = 0;
    (void)crowd_frame(c, 120, &gone);
    (void)crowd_frame(fresh, 120, &gone);
    assert_memory_equal(c->is, fresh->is, sizeof c->is);
    assert_int_equal(util_stats(c->maps).renewed, CROWD * EACH);
    ism_free(c->maps);
    ism_free(fresh->maps);
    free(c);
    free(fresh);
}

/* What leaks is of the size of texels and of the gaps between points, nothing else: with walls of 0.25 m wider than
   both, no pair of receiver and VPL is lit. */
static void a_sealed_box_is_dark_where_texels_are_finer(void **state)
{
    (void)state;
    CONFORM("irradiance", "the same, 256 x 256 texels and 32,768 points a VPL", 0, sealed_box_leak(32, 32768, 256), 0);
}

/* ---- T48 ---- */

static void splats_have_the_sphere_s_solid_angle(void **state)
{
    static ism_surfel points[8192];
    int r;
    (void)state;
    for (r = 0; r < 3; r++) {
        engine *e = engine_in_a_sphere(sphere_radius[r]);
        double solid = 0;
        size_t n, j;
        char text[80];
        assert_int_equal(ism_surfels(e->maps, 0, points, 8192, &n), ISM_OK);
        for (j = 0; j < n; j++) {           /* area cos / d^2: the triangles face the middle to within 0.1 % */
            const float *p = mesh.p + 9 * (size_t)points[j].triangle;
            double q[3], d2 = 0;
            int k;
            for (k = 0; k < 3; k++) {
                double b1 = (double)points[j].barycentric[0], b2 = (double)points[j].barycentric[1];
                q[k] = (double)p[k] * (1 - b1 - b2) + (double)p[3 + k] * b1 + (double)p[6 + k] * b2;
                d2 += q[k] * q[k];
            }
            solid += (double)points[j].area * triangle_area(points[j].triangle) / d2;
        }
        snprintf(text, sizeof text, "radius %g: sum of solid angles over 4 pi", (double)sphere_radius[r]);
        CONFORM("T48", text, 1, solid / (4 * UTIL_PI), 0.02);
        engine_close(e);
    }
}

/* ---- T49: the filling itself, on tiles made by hand ---- */

typedef struct hand {
    ism_vpl vpl;
    ism_maps *maps;
    ism__texel texels[4096];
    float depth[4096];
    uint32_t pyramid[2048];
    ism__tile tile;
} hand;

static hand *make_hand(void)
{
    hand *h = (hand *)calloc(1, sizeof *h);
    ism_desc d;
    size_t i;
    assert_non_null(h);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    assert_int_equal(ism_create(&d, &h->maps), ISM_OK);
    h->vpl = util_vpl(0, 0, 0, 0, 0, 1, 1);
    h->tile.m = h->maps;
    h->tile.vpl = &h->vpl;
    h->tile.size = 64;
    h->tile.projection = ISM_PROJECTION_COSINE;
    h->tile.x = (const float *)h->maps->directions.data;
    h->tile.y = h->tile.x + 4096;
    h->tile.z = h->tile.y + 4096;
    h->tile.depth = h->depth;
    h->tile.texels = h->texels;
    for (i = 0; i < 4096; i++) h->depth[i] = ISM_FAR;
    return h;
}

static void free_hand(hand *h)
{
    ism_free(h->maps);
    free(h);
}

/* A surfel of the plane g . p = 1 at a texel. */
static void set_texel(hand *h, size_t i, const float g[3])
{
    memcpy(h->texels[i].g, g, sizeof h->texels[i].g);
    h->depth[i] = 1 / (g[0] * h->tile.x[i] + g[1] * h->tile.y[i] + g[2] * h->tile.z[i]);
}

static float depth_of(const hand *h, size_t i)
{
    const ism__texel *t = &h->texels[i];
    return h->depth[i] < ISM_FAR ? h->depth[i] : t->filled ? t->g[0] : ISM_FAR;
}

/* docs/ism.md: what is filled of a slit of so many texels between two walls of depth 1, at eight places of the tile. */
static void slits_are_closed_up_to_eight_texels(void **state)
{
    static const struct { int width; double least, most; } slits[] = {
        { 4, 1, 1 }, { 8, 1, 1 }, { 12, 0.7, 0.9 }, { 16, 0.3, 0.5 }, { 24, 0, 0 },
    };
    size_t k;
    (void)state;
    for (k = 0; k < sizeof slits / sizeof *slits; k++) {
        double filled = 0, all = 0;
        int at, i;
        for (at = 24; at < 32; at++) {
            hand *h = make_hand();
            for (i = 0; i < 4096; i++) {
                const float g[3] = { h->tile.x[i], h->tile.y[i], h->tile.z[i] };
                if (i % 64 < at || i % 64 >= at + slits[k].width) set_texel(h, (size_t)i, g);
            }
            ism__fill(&h->tile, h->pyramid);
            for (i = 64 * 16; i < 64 * 48; i++) {       /* not at its ends */
                if (i % 64 < at || i % 64 >= at + slits[k].width) continue;
                filled += h->texels[i].filled;
                all++;
            }
            free_hand(h);
        }
        assert_true(filled >= slits[k].least * all && filled <= slits[k].most * all);
    }
}

static void pull_and_push_fill_holes(void **state)
{
    uint32_t seed = 3, trial;
    size_t i;
    double constant = 0, plane = 0, between = 0, filled = 0, empty = 0, holes = 0, inner = 0;
    hand *h = make_hand();
    (void)state;
    h->tile.m = h->maps;
    ism__fill(&h->tile, h->pyramid);
    for (i = 0; i < 4096; i++) empty += depth_of(h, i) < ISM_FAR;
    free_hand(h);
    for (trial = 0; trial < 3; trial++) {
        h = make_hand();
        for (i = 0; i < 4096; i++) {
            const float w[3] = { h->tile.x[i], h->tile.y[i], h->tile.z[i] };
            float g[3] = { 0.3f, -0.2f, 0.5f };
            int k;
            if (util_unit(&seed) >= 0.1f) continue;
            if (trial == 0)                 /* constant depth: surfels face the VPL */
                for (k = 0; k < 3; k++) g[k] = 0.5f * w[k];
            if (trial == 1 && g[0] * w[0] + g[1] * w[1] + g[2] * w[2] < 0.1f) continue;
            if (trial == 2)                 /* two depths, left and right */
                for (k = 0; k < 3; k++) g[k] = w[k] * (i % 64 < 32 ? 1.0f : 0.25f);
            set_texel(h, i, g);
        }
        ism__fill(&h->tile, h->pyramid);
        for (i = 0; i < 4096; i++) {
            const float w[3] = { h->tile.x[i], h->tile.y[i], h->tile.z[i] };
            float t = depth_of(h, i), truth;
            const int x = (int)(i % 64), y = (int)(i / 64), inside = x >= 4 && y >= 4 && x < 60 && y < 60;
            inner += trial == 0 && inside;
            if (t >= ISM_FAR) {
                holes += trial == 0 && inside;
                continue;
            }
            if (trial == 0) constant = fmax(constant, fabs((double)t / 2 - 1));
            truth = 1 / (0.3f * w[0] - 0.2f * w[1] + 0.5f * w[2]);
            if (trial == 1 && truth > 0 && truth < 5) {
                plane = fmax(plane, fabs((double)(t / truth - 1)));
                filled++;
            }
            if (trial == 2) between += t > 1.1f && t < 3.6f;    /* facets go out to 1.06 and 4.24 */
        }
        free_hand(h);
    }
    /* exact but for rounding: eight of a float's last places */
    CONFORM_MAX("T49", "constant depth from 10 % points, largest relative error", 1e-6, constant);
    CONFORM_MAX("T49", "constant depth from 10 % points, share of texels left open, four from the border", 0.01,
                holes / inner);
    CONFORM_MAX("T49", "plane from 10 % points, largest relative error", 0.01, plane);
    assert_true(filled > 2900);
    CONFORM("T49", "two depths: texels with a depth between", 0, between, 0);
    CONFORM("T49", "empty tile: texels with a depth", 0, empty, 0);
}

/* Up to the border, as dense as tiles are. */
static void pull_and_push_fill_the_border_too(void **state)
{
    uint32_t seed = 5;
    double open = 0, count = 0;
    int trial;
    (void)state;
    for (trial = 0; trial < 20; trial++) {
        hand *h = make_hand();
        size_t i;
        for (i = 0; i < 4096; i++) {
            float g[3] = { 0.5f * h->tile.x[i], 0.5f * h->tile.y[i], 0.5f * h->tile.z[i] };
            if (util_unit(&seed) < 0.4f) set_texel(h, i, g);
        }
        ism__fill(&h->tile, h->pyramid);
        for (i = 0; i < 4096; i++) {
            if (i % 64 > 0 && i % 64 < 63 && i / 64 > 0 && i / 64 < 63) continue;
            count++;
            open += !(depth_of(h, i) < ISM_FAR);
        }
        free_hand(h);
    }
    CONFORM_MAX("T49", "constant depth from 40 % points, share of the border's texels left open", 0.01, open / count);
}

/* What is full on one side of a line, of any direction and place, or within a circle, stays as it is. */
static void silhouettes_do_not_grow(void **state)
{
    double lines = 0, circles = 0;
    int trial;
    (void)state;
    for (trial = 0; trial < 128; trial++) {
        const double a = 6.283185307179586 * (trial / 2) / 64, c = cos(a), s = sin(a), shift = trial % 7 * 4 - 12;
        const double radius = 6 + trial % 5 * 4;
        hand *h = make_hand();
        size_t i;
        int k;
        for (i = 0; i < 4096; i++) {
            const double x = (double)(i % 64) - 31.5, y = (double)(i / 64) - 31.5;
            float g[3] = { 0.5f * h->tile.x[i], 0.5f * h->tile.y[i], 0.5f * h->tile.z[i] };
            if (trial % 2 ? x * c + y * s < shift : hypot(x - 4 * c, y - 4 * s) < radius) set_texel(h, i, g);
        }
        ism__fill(&h->tile, h->pyramid);
        for (i = 0, k = 0; i < 4096; i++)
            if (i % 64 > 7 && i % 64 < 56 && i / 64 > 7 && i / 64 < 56)
                k += !(h->depth[i] < ISM_FAR) && depth_of(h, i) < ISM_FAR;
        *(trial % 2 ? &lines : &circles) += k;
        free_hand(h);
    }
    CONFORM("T49", "half a tile full, 64 directions: texels filled beyond, eight from the border", 0, lines, 0);
    CONFORM("T49", "circles in an empty tile: texels filled beyond, eight from the border", 0, circles, 0);
}

/* What a texel of a map stands for when its VPL bounces on: the cells of any projection share the light of the
   hemisphere. A cell's weight is half of its solid angle's quarter's two diagonals' product, so that twice the sum is
   the integral of cos^n: 2 pi / (n + 1). */
static void cells_share_the_hemisphere(void **state)
{
    static const ism_projection projections[2] = { ISM_PROJECTION_PARABOLOID, ISM_PROJECTION_OCTAHEDRAL };
    static const float exponents[2] = { 1, 8 };
    int i, k;
    (void)state;
    for (i = 0; i < 2; i++)
        for (k = 0; k < 2; k++) {
            ism_desc d;
            ism_vpl v;
            ism_maps *m;
            double sum = 0;
            uint32_t x, y;
            memset(&d, 0, sizeof d);
            memset(&v, 0, sizeof v);
            d.vpl_count = 16;
            d.surfel_count = 64;
            d.tile_side = 64;
            d.projection = projections[i];
            v.normal[1] = v.axis[1] = 1;
            v.exponent = exponents[k];
            assert_int_equal(ism_create(&d, &m), ISM_OK);
            for (y = 0; y < d.tile_side; y++)
                for (x = 0; x < d.tile_side; x++) sum += 2 * (double)ism__cell_weight(m, &v, x, y);
            ism_free(m);
            /* 64 x 64 cells: the disc's rim is a row wide at most, where the cosine is 0.03 */
            if (!(fabs(sum / (6.283185307179586 / (1 + (double)exponents[k])) - 1) < 0.005))
                fail_msg("projection %d, exponent %g: %g", i, (double)exponents[k], sum);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ISM_ROWS(cmocka_unit_test),
        cmocka_unit_test(an_adaptive_cloud_keeps_the_area),
        cmocka_unit_test(lazy_renewal_reaches_all_points),
        cmocka_unit_test(triangles_that_come_and_go_leave_the_points_of_the_others),
        cmocka_unit_test(triangles_that_go_one_after_the_other_leave_an_even_crowd),
        cmocka_unit_test(without_a_mesh_all_points_begin_anew),
        cmocka_unit_test(a_sealed_box_is_dark_where_texels_are_finer),
        cmocka_unit_test(splats_have_the_sphere_s_solid_angle),
        cmocka_unit_test(slits_are_closed_up_to_eight_texels), cmocka_unit_test(pull_and_push_fill_holes),
        cmocka_unit_test(pull_and_push_fill_the_border_too),
        cmocka_unit_test(silhouettes_do_not_grow),
        cmocka_unit_test(cells_share_the_hemisphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
