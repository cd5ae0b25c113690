/* rows.h - tests of rows T42 to T50 of docs/conformance.md, of a sealed box and of a folded sheet that both sides are
   put to, in the same words: ism.h by tests/ism/points_rows_test.c, gl_ism.h by tests/ism/gl_rows_test.c, where
   ism.h chooses VPLs and scatters points as it does for a renderer. Include ism.h, cmocka.h, conformance.h and
   ism/util.h before and define ROW_TEST(state), the first line of a test; then define the functions row_... and
   engine_... below. */
#ifndef ISM_ROWS_H
#define ISM_ROWS_H

/* Directions of places in a map, and back; there: 0 below the horizon. */
static void row_directions(ism_projection p, float exponent, const float *uv, size_t count, float *d);
static void row_coordinates(ism_projection p, float exponent, const float *d, size_t count, float *uv, uint8_t *there);
/* Of rectangles, 12 floats each, seen from the origin. */
static void row_form_factors(const float normal[3], const float *corners, size_t count, float *f);

typedef struct engine engine;

static engine    *engine_open(const ism_desc *desc, const ism_points *view);
static void       engine_close(engine *e);
static ism_maps  *engine_maps(engine *e);               /* that choose and have VPLs */
static void       engine_draw(engine *e, const ism_frame *frame);
static float     *engine_atlas(engine *e, uint32_t *side);      /* free it */
/* Irradiance; lost: share that clamping took. */
static void       engine_shade(engine *e, const ism_shading *shading, float *light, double *lost);
static void       engine_bounce(engine *e, const ism_frame *frame, uint32_t side, float *p, float *n, float *flux);

static soup mesh;
static grid eye;

/* ---- T42, T43 ---- */

static void t42_t43_form_factors_equal_their_closed_forms(void **state)
{
    ROW_TEST(state)
    enum { N = 256, ALL = N * N };
    static const float face[12] = { 0, 1, 0,  1, 1, 0,  1, 1, 1,  0, 1, 1 };    /* seen from below */
    static const float wall[12] = { 0, 0, 0,  0, 1, 0,  0, 1, 1,  0, 0, 1 };
    const float up[3] = { 0, 1, 0 };
    float *corners = (float *)malloc(sizeof(float) * 13 * ALL), *f = corners + 12 * ALL;
    double sum[5] = { 0, 0, 0, 0, 0 };
    int i, k, side;
    assert_non_null(corners);
    for (side = 0; side < 5; side++) {              /* the cube's walls, turned round its axis; what is above */
        for (i = 0; i < ALL; i++) {
            const float at[3] = { ((float)(i % N) + 0.5f) / N, 0, ((float)(i / N) + 0.5f) / N };
            for (k = 0; k < 4; k++) {
                const float *from = side == 4 ? face + 3 * k : wall + 3 * (side % 2 ? 3 - k : k);
                float *c = corners + 12 * i + 3 * k, x = side % 2 ? 1.0f : 0.0f;
                c[0] = (side == 4 ? from[0] : side < 2 ? x : 1 - from[2]) - at[0];
                c[1] = from[1];
                c[2] = (side == 4 || side < 2 ? from[2] : x) - at[2];
            }
        }
        row_form_factors(up, corners, ALL, f);
        for (i = 0; i < ALL; i++) sum[side] += (double)f[i] / ALL;
    }
    /* midpoint sums of 256^2: the integrand has a kink at the shared edge only, 1e-4 there */
    CONFORM("T42", "two unit squares 1 apart", 0.1998249, sum[4], 1e-5);
    CONFORM("T42", "two unit squares that share an edge", 0.2000438, sum[0], 2e-4);
    CONFORM("T42", "one face of a cube to the other five", 1, sum[0] + sum[1] + sum[2] + sum[3] + sum[4], 1e-3);
    for (k = 0; k < 12; k++) corners[k] = face[k] - (k % 3 == 1 ? 0.0f : 0.5f);
    memcpy(corners + 12, face, sizeof face);
    row_form_factors(up, corners, 2, f);
    CONFORM("T43", "unit square 1 above, its centre", 0.239456, f[0], 1e-6);
    CONFORM("T43", "unit square 1 above, its corner", 0.138532, f[1], 1e-6);
    free(corners);
}

/* ---- T46, T47 ---- */

/* Solid angle of the facet between four directions, and their mean cosine. */
static double facet(const float *a, const float *b, const float *c, const float *d, double *z)
{
    double p[3], q[3], n[3];
    int k;
    for (k = 0; k < 3; k++) {
        p[k] = (double)c[k] - (double)a[k];
        q[k] = (double)d[k] - (double)b[k];
    }
    for (k = 0; k < 3; k++) n[k] = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
    *z = ((double)a[2] + (double)b[2] + (double)c[2] + (double)d[2]) / 4;
    return 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* Largest difference of directions from what their coordinates lead back to. */
static double round_trip_of(ism_projection p, float exponent, float *uv, const float *d, float *again, uint8_t *there,
                            size_t n)
{
    double worst = 0;
    size_t i;
    int k;
    row_coordinates(p, exponent, d, n, uv, there);
    row_directions(p, exponent, uv, n, again);
    for (i = 0; i < n; i++)
        for (k = 0; k < 3; k++)
            if (d[3 * i + 2] > 1e-3f && there[i])
                worst = fmax(worst, fabs((double)again[3 * i + (size_t)k] - (double)d[3 * i + (size_t)k]));
    return worst;
}

static void maps_of_the_hemisphere_keep_solid_angle_and_come_back(void **state)
{
    ROW_TEST(state)
    enum { T = 32, SUB = 16, SIDE = T * SUB, LINE = SIDE + 1, MOST = LINE * LINE };
    static const char *const names[5] = { "", "cosine", "paraboloid", "octahedral", "lobe" };
    static float uv[2 * MOST], d[3 * MOST], again[3 * MOST];
    static uint8_t there[MOST];
    const float exponent = 3;
    int number, x, y, i, below = 0;
    for (number = 1; number < ISM_PROJECTION_COUNT; number++) {
        const ism_projection p = (ism_projection)number;
        double solid = 0, cosine = 0, least = 1e9, most = 0, weight[T * T] = { 0 };
        char text[80];
        for (i = 0; i < MOST; i++) {
            uv[2 * i] = (float)(i % LINE) / SIDE;
            uv[2 * i + 1] = (float)(i / LINE) / SIDE;
        }
        row_directions(p, exponent, uv, MOST, d);
        for (y = 0; y < SIDE; y++)
            for (x = 0; x < SIDE; x++) {
                const float *c = d + 3 * (y * LINE + x);
                double z, area = facet(c, c + 3, c + 3 * (LINE + 1), c + 3 * LINE, &z);
                if (z <= 0) continue;
                solid += area;
                cosine += area * z;
                weight[y / SUB * T + x / SUB] += area * (p == ISM_PROJECTION_LOBE ? pow(z, 3) : z);
            }
        for (i = 0; i < T * T; i++) {
            least = fmin(least, weight[i]);
            most = fmax(most, weight[i]);
        }
        /* facets of 1/512 of the square; at the rim of a map the disc is cut by whole facets */
        snprintf(text, sizeof text, "%s map, solid angles of the texels", names[p]);
        if (p != ISM_PROJECTION_LOBE) CONFORM("T46", text, 2 * UTIL_PI, solid, 0.02);
        snprintf(text, sizeof text, "%s map, cosine-weighted", names[p]);
        if (p != ISM_PROJECTION_LOBE) CONFORM("T46", text, UTIL_PI, cosine, 0.003);
        for (i = 0; i < SIDE * SIDE; i++) {
            uv[2 * i] = ((float)(i % SIDE) + 0.5f) / SIDE;
            uv[2 * i + 1] = ((float)(i / SIDE) + 0.5f) / SIDE;
        }
        row_directions(p, exponent, uv, SIDE * SIDE, d);
        snprintf(text, sizeof text, "%s map, round trip", names[p]);
        CONFORM_MAX("T46", text, 1e-5, round_trip_of(p, exponent, uv, d, again, there, SIDE * SIDE));
        if (p == ISM_PROJECTION_COSINE) {
            CONFORM("T47", "cosine map, weight of a texel x T / pi, least", 1, least * T * T / UTIL_PI, 0.005);
            CONFORM("T47", "cosine map, weight of a texel x T / pi, most", 1, most * T * T / UTIL_PI, 0.005);
        }
        /* facets at the horizon are chords of where cos^3 is almost 0 */
        if (p == ISM_PROJECTION_LOBE)
            CONFORM_MAX("T47", "lobe map, exponent 3, spread of texel weights", 0.08, most / least - 1);
        for (i = 0; i < 1000; i++) {
            d[3 * i] = cosf((float)i * 0.00628f);
            d[3 * i + 1] = sinf((float)i * 0.00628f);
            d[3 * i + 2] = i % 2 ? 0.0f : -1e-6f;
        }
        row_coordinates(p, exponent, d, 1000, uv, there);
        for (i = 0; i < 1000; i++) below += there[i];
    }
    CONFORM("T46", "directions at and below the horizon that get coordinates", 0, below, 0);
}

/* ---- maps drawn: T48 ---- */

static ism_frame frame_of(const ism_mesh *m, const ism_points *view, uint32_t index)
{
    ism_frame f;
    memset(&f, 0, sizeof f);
    f.mesh = m;
    f.points = view;
    f.index = index;
    return f;
}

/* A room with a box in it, seen by a few receivers on the floor. */
static void make_room(ism_mesh *m, ism_points *view)
{
    const float lo[3] = { -4, 0, -3 }, hi[3] = { 4, 3, 3 }, blo[3] = { 0.5f, 0.1f, -1 }, bhi[3] = { 1.2f, 1.4f, 0.3f };
    const float a[3] = { -3, 0, -2 }, u[3] = { 3, 0, 0 }, v[3] = { 0, 0, 2 }, up[3] = { 0, 1, 0 };
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, -1, 6);
    soup_box(&mesh, blo, bhi, 1, 3);
    grid_fill(&eye, 16, 9, a, u, v, up, 0);
    *m = soup_mesh(&mesh);
    *view = grid_view(&eye);
}

/* A sphere of triangles about the origin, each split by four `times` times. */
static void make_sphere(float radius, int times)
{
    static soup finer;
    size_t t;
    mesh.triangles = 0;
    soup_octahedron(&mesh, 1);
    for (; times > 0; times--) {
        finer.triangles = 0;
        for (t = 0; t < mesh.triangles; t++) {
            static const int to[4][3] = { { 0, 3, 5 }, { 3, 1, 4 }, { 5, 4, 2 }, { 3, 4, 5 } };
            const float *p = mesh.p + 9 * t;
            float q[6][3];
            int k, c, s;
            for (k = 0; k < 3; k++)
                for (c = 0; c < 3; c++) {
                    q[k][c] = p[3 * k + c];
                    q[3 + k][c] = p[3 * k + c] + p[3 * ((k + 1) % 3) + c];
                }
            for (k = 0; k < 6; k++) {
                float l = sqrtf(q[k][0] * q[k][0] + q[k][1] * q[k][1] + q[k][2] * q[k][2]);
                for (c = 0; c < 3; c++) q[k][c] /= l;
            }
            for (s = 0; s < 4; s++, finer.triangles++)
                for (k = 0; k < 3; k++) memcpy(finer.p + 9 * finer.triangles + 3 * (size_t)k, q[to[s][k]], 12);
        }
        mesh = finer;
    }
    for (t = 0; t < 9 * mesh.triangles; t++) mesh.p[t] *= radius;
}

/* Of triangles much smaller than what a point stands for: discs jut out over the surface that they are for. */
static void a_fine_surface_does_not_hide_itself(void **state)
{
    ROW_TEST(state)
    static float open[3 * 1024], light[3 * 1024], again[3 * 1024];
    const ism_vpl vpl = util_vpl(0, 3, 0, 0, -1, 0, 1);
    ism_shading s = { 0 };
    ism_points view;
    ism_desc d;
    ism_frame f;
    ism_mesh m;
    engine *e;
    double lit = 0, differ = 0;
    size_t i;
    make_sphere(1, 4);
    m = soup_mesh(&mesh);
    for (i = 0; i < 1024; i++) {            /* receivers on its cap within 45 degrees of the VPL's direction */
        float y = 1 - 0.29289f * ((float)i + 0.5f) / 1024, r = sqrtf(1 - y * y), phi = 2.39996323f * (float)i;
        eye.n[3 * i] = eye.p[3 * i] = r * cosf(phi);
        eye.n[3 * i + 1] = eye.p[3 * i + 1] = y;
        eye.n[3 * i + 2] = eye.p[3 * i + 2] = r * sinf(phi);
    }
    eye.w = eye.h = 32;
    view = grid_view(&eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    d.surfel_count = 256;
    d.spread = ISM_SPREAD_AREA;
    f = frame_of(&m, &view, 0);
    e = engine_open(&d, &view);
    assert_int_equal(ism_set_vpls(engine_maps(e), &vpl, 1), ISM_OK);
    engine_draw(e, &f);
    s.bias = -1;
    engine_shade(e, &s, light, NULL);
    for (f.index = 1; f.index < 10; f.index++) {
        engine_draw(e, &f);
        engine_shade(e, &s, again, NULL);
        differ += memcmp(light, again, sizeof again) != 0;
    }
    s.no_maps = 1;
    engine_shade(e, &s, open, NULL);
    for (i = 0; i < 1024; i++) {
        assert_true(open[3 * i] > 0);
        lit += (double)(light[3 * i] / open[3 * i]) / 1024;
    }
    CONFORM("T48", "sphere of 2048 triangles, 256 points: share of its lit side that the map lights, no bias", 1, lit,
            0.01);
    CONFORM("T57", "static scene: frames that are not the first one, bit by bit", 0, differ, 0);
    engine_close(e);
}

/* One VPL in the middle of a sphere. */
static engine *engine_in_a_sphere(float radius)
{
    const float a[3] = { 0, 0, 0 }, u[3] = { 0.01f, 0, 0 }, w[3] = { 0, 0, 0.01f }, up[3] = { 0, 1, 0 };
    const ism_vpl v = util_vpl(0, 0, 0, 0, 1, 0, 1);
    ism_mesh m;
    ism_points view;
    ism_desc d;
    ism_frame f;
    engine *e;
    make_sphere(radius, 4);
    m = soup_mesh(&mesh);
    grid_fill(&eye, 1, 1, a, u, w, up, 0);
    view = grid_view(&eye);
    f = frame_of(&m, &view, 0);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    e = engine_open(&d, &view);
    assert_int_equal(ism_set_vpls(engine_maps(e), &v, 1), ISM_OK);
    engine_draw(e, &f);
    return e;
}

static const float sphere_radius[3] = { 0.05f, 1, 400 };

static void splats_cover_a_sphere(void **state)
{
    ROW_TEST(state)
    int r;
    for (r = 0; r < 3; r++) {
        engine *e = engine_in_a_sphere(sphere_radius[r]);
        uint32_t side, x, y, right = 0;
        float *atlas = engine_atlas(e, &side);
        char text[80];
        for (y = 0; y < 64; y++)
            for (x = 0; x < 64; x++) right += fabsf(atlas[y * side + x] / sphere_radius[r] - 1) < 0.01f;
        snprintf(text, sizeof text, "radius %g: share of texels within 1 %%", (double)sphere_radius[r]);
        CONFORM_MIN("T48", text, 0.99, right / 4096.0);
        free(atlas);
        engine_close(e);
    }
}

/* ---- T49 ---- */

/* Rewriting one VPL changes no texel of another's tile. */
static void tiles_are_apart(void **state)
{
    ROW_TEST(state)
    ism_mesh m;
    ism_points view;
    ism_desc d;
    ism_frame f;
    ism_vpl v[9];
    float *atlas[2];
    uint32_t side = 0, i, x, y;
    double changed = 0, rewritten = 0;
    make_room(&m, &view);
    f = frame_of(&m, &view, 0);
    memset(&d, 0, sizeof d);
    d.vpl_count = 9;
    d.surfel_count = 512;
    d.tile_side = 16;
    for (i = 0; i < 9; i++) v[i] = util_vpl(-3 + 0.3f * (float)i, 0, 0.1f, 0, 1, 0, 1);
    for (i = 0; i < 2; i++) {
        engine *e = engine_open(&d, &view);
        if (i) v[4] = util_vpl(2, 3, -2, 0, -1, 0, 1);
        assert_int_equal(ism_set_vpls(engine_maps(e), v, 9), ISM_OK);
        engine_draw(e, &f);
        atlas[i] = engine_atlas(e, &side);
        engine_close(e);
    }
    for (y = 0; y < side; y++)
        for (x = 0; x < side; x++) {
            int middle = x / 16 == 1 && y / 16 == 1;
            int differs = memcmp(atlas[0] + y * side + x, atlas[1] + y * side + x, 4) != 0;
            changed += !middle && differs;
            rewritten += middle && differs;
        }
    assert_true(rewritten > 100);
    CONFORM("T49", "texels of eight tiles that change with the ninth", 0, changed, 0);
    free(atlas[0]);
    free(atlas[1]);
}

/* ---- T50, the sealed box ---- */

/* Mean irradiance of a unit square of receivers from a unit square of VPLs 1 above it, x pi: form factor x area. */
static double transmitted(const ism_mesh *m, uint32_t side, uint32_t points, uint32_t tile_size)
{
    static grid below;
    static float light[3 * 32 * 32];
    const float a[3] = { 0, 0, 0 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 0, 1 }, up[3] = { 0, 1, 0 };
    ism_points view;
    ism_desc d;
    ism_frame f;
    ism_vpl list[144];
    ism_shading s = { 0 };
    engine *e;
    double sum = 0;
    const uint32_t vpls = side * side;
    uint32_t i;
    assert_true(vpls <= 144);
    grid_fill(&below, 32, 32, a, u, v, up, 0);
    view = grid_view(&below);
    for (i = 0; i < vpls; i++) {            /* radiance 1: flux pi A */
        const float x = ((float)(i % side) + 0.5f) / (float)side, z = ((float)(i / side) + 0.5f) / (float)side;
        list[i] = util_vpl(x, 1, z, 0, -1, 0, (float)UTIL_PI / (float)vpls);
        list[i].area = 1 / (float)vpls;
    }
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls;
    d.surfel_count = points;
    d.tile_side = tile_size;
    d.spread = ISM_SPREAD_AREA;
    f = frame_of(m, &view, 0);
    s.no_maps = !m;
    e = engine_open(&d, &view);
    assert_int_equal(ism_set_vpls(engine_maps(e), list, vpls), ISM_OK);
    if (m) engine_draw(e, &f);
    engine_shade(e, &s, light, NULL);
    for (i = 0; i < 32 * 32; i++) sum += (double)light[3 * i] / UTIL_PI / (32 * 32);
    engine_close(e);
    return sum;
}

static void an_occluder_between_two_squares_takes_its_share(void **state)
{
    ROW_TEST(state)
    const float a[3] = { -0.05f, 0.5f, -0.05f }, u[3] = { 1.1f, 0, 0 }, v[3] = { 0, 0, 1.1f };
    const float ha[3] = { -1, 0.5f, -1 }, hu[3] = { 1.5f, 0, 0 }, hv[3] = { 0, 0, 3 };
    double full, half;
    ism_mesh m;
    /* midpoint sums of 12^2 x 32^2 */
    CONFORM("T50", "two unit squares 1 apart, by VPLs", 0.1998249, transmitted(NULL, 12, 8, 8), 5e-4);
    mesh.triangles = 0;
    soup_quad(&mesh, a, u, v, 8);
    m = soup_mesh(&mesh);
    full = transmitted(&m, 6, 4096, 32);
    mesh.triangles = 0;
    soup_quad(&mesh, ha, hu, hv, 8);
    m = soup_mesh(&mesh);
    half = transmitted(&m, 6, 16384, 128);  /* discs of 1 cm: a silhouette grows by about their radius */
    CONFORM("T50", "full occluder: transmitted", 0, full, 1e-4);
    /* the edge grows by a disc and part of a texel, 0.02 of the width of 1 */
    CONFORM("T50", "half-plane occluder: share transmitted", 0.5, half / transmitted(NULL, 6, 8, 8), 0.03);
}

/* An engine whose VPLs of one source are chosen and their maps drawn. */
static engine *engine_of(const ism_mesh *m, const ism_points *view, const ism_source *s, uint32_t vpls, uint32_t points,
                         uint32_t tile_size)
{
    ism_desc d;
    ism_frame f = frame_of(m, view, 0);
    engine *e;
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls;
    d.surfel_count = points;
    d.tile_side = tile_size;
    f.sources = s;
    f.source_count = 1;
    e = engine_open(&d, view);
    assert_int_equal(ism_choose(engine_maps(e), &f), ISM_OK);
    engine_draw(e, &f);
    return e;
}

/* Light inside a box, sun outside, over the light through open walls. */
static double sealed_box_leak(uint32_t vpls, uint32_t points, uint32_t tile_size)
{
    static grid roof;
    static float light[3 * 64 * 64];
    const float lo[3] = { -1, 0, -1 }, hi[3] = { 1, 2, 1 }, ilo[3] = { -0.75f, 0.25f, -0.75f },
                ihi[3] = { 0.75f, 1.75f, 0.75f };
    const float glo[3] = { -4, -0.2f, -4 }, gu[3] = { 8, 0, 0 }, gv[3] = { 0, 0, 8 };
    const float a[3] = { -0.75f, 0.25f, -0.75f }, u[3] = { 1.5f, 0, 0 }, v[3] = { 0, 0, 1.5f }, up[3] = { 0, 1, 0 };
    ism_mesh m;
    ism_points view;
    ism_source s;
    ism_shading shading = { 0 };
    engine *e;
    double sum = 0, all = 0;
    size_t i;
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, 1, 8);
    soup_box(&mesh, ilo, ihi, -1, 8);       /* walls as thick as a house's */
    soup_quad(&mesh, glo, gv, gu, 16);
    m = soup_mesh(&mesh);
    grid_fill(&eye, 64, 64, a, u, v, up, 0);
    for (i = 0; i < 64 * 64; i++)           /* receivers on floor and ceiling */
        if (i & 1) {
            eye.p[3 * i + 1] = 1.75f;
            eye.n[3 * i + 1] = -1;
        }
    grid_fill(&roof, 64, 64, glo, gu, gv, up, 1);
    for (i = 0; i < 64 * 64; i++)           /* sun from above on the roof and the ground about the box */
        if (fabsf(roof.p[3 * i]) < 1 && fabsf(roof.p[3 * i + 2]) < 1) roof.p[3 * i + 1] = 2;
    s = grid_source(&roof);
    view = grid_view(&eye);
    e = engine_of(&m, &view, &s, vpls, points, tile_size);
    engine_shade(e, &shading, light, NULL);
    for (i = 0; i < 3 * 64 * 64; i++) sum += (double)light[i];
    shading.no_maps = 1;
    engine_shade(e, &shading, light, NULL);
    for (i = 0; i < 3 * 64 * 64; i++) all += (double)light[i];
    engine_close(e);
    assert_true(all > 0);
    return sum / all;
}

static void a_sealed_box_stays_dark(void **state)
{
    ROW_TEST(state)
    CONFORM("irradiance", "sealed box, sun outside: light inside over light through open walls", 0,
            sealed_box_leak(128, 8192, 0), 0);
}

/* A sheet with folds 1 m apart and 16 cm deep, lit from above: what lies right below it sees VPLs of the next fold's
   upper side at grazing angles, under their squares of 0.5 m, and no map tells that the sheet is between. */
static float fold(float x) { return 0.08f * sinf(2 * (float)UTIL_PI * x); }

static void fold_normal(float x, float sign, float n[3])
{
    float slope = 0.16f * (float)UTIL_PI * cosf(2 * (float)UTIL_PI * x), length = sqrtf(1 + slope * slope);
    n[0] = -sign * slope / length;
    n[1] = sign / length;
    n[2] = 0;
}

static void a_folded_sheet_is_dark_below(void **state)
{
    ROW_TEST(state)
    enum { SIDE = 48, PIXELS = SIDE * SIDE };
    static grid top;
    static float light[3 * PIXELS], areas[PIXELS];
    const float a[3] = { -2, 0, -2 }, u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 }, up[3] = { 0, 1, 0 };
    const ism_shading shading = { 0 };
    double mean = 0, most = 0;
    engine *e;
    ism_mesh m;
    ism_points view;
    ism_source s;
    size_t i;
    mesh.triangles = 0;
    soup_quad(&mesh, a, v, u, 32);
    for (i = 0; i < 3 * mesh.triangles; i++) mesh.p[3 * i + 1] = fold(mesh.p[3 * i]);
    m = soup_mesh(&mesh);
    grid_fill(&top, SIDE, SIDE, a, u, v, up, 16.0f / PIXELS);       /* 1 W/m^2 leaves it */
    grid_fill(&eye, SIDE, SIDE, a, u, v, up, 0);
    for (i = 0; i < PIXELS; i++) {
        float x = top.p[3 * i];
        top.p[3 * i + 1] = eye.p[3 * i + 1] = fold(x);
        fold_normal(x, 1, top.n + 3 * i);
        fold_normal(x, -1, eye.n + 3 * i);
        areas[i] = 16.0f / PIXELS;
    }
    s = grid_source(&top);
    s.areas = areas;
    view = grid_view(&eye);
    e = engine_of(&m, &view, &s, 64, 2048, 0);
    engine_shade(e, &shading, light, NULL);
    engine_close(e);
    for (i = 0; i < PIXELS; i++) {
        mean += (double)light[3 * i] / PIXELS;
        most = fmax(most, (double)light[3 * i]);
    }
    CONFORM_MAX("irradiance", "folded sheet lit from above: mean below it over what leaves it above", 0.002, mean);
    CONFORM_MAX("irradiance", "the same, largest", 0.1, most);
}

/* ---- T44, T45 ---- */

static void clamping_is_known(void **state)
{
    ROW_TEST(state)
    enum { SIDE = 128 };
    static ism_vpl list[SIDE * SIDE];
    const float a[3] = { 0, 0.1f, 0 }, u[3] = { 1e-3f, 0, 0 }, v[3] = { 0, 0, 1e-3f }, down[3] = { 0, -1, 0 };
    ism_points view;
    ism_desc d;
    ism_shading s = { 0 };
    engine *e;
    float light[3];
    double lost;
    int i;
    for (i = 0; i < SIDE * SIDE; i++) {     /* radiance 1 over 4 x 4 m, which is 99.8 % of the plane seen from 0.1 */
        list[i] = util_vpl(((float)(i % SIDE) + 0.5f) * 4 / SIDE - 2, 0, ((float)(i / SIDE) + 0.5f) * 4 / SIDE - 2, 0,
                           1, 0, (float)UTIL_PI * 16 / (SIDE * SIDE));
        list[i].area = 16.0f / (SIDE * SIDE);
    }
    grid_fill(&eye, 1, 1, a, u, v, down, 0);
    view = grid_view(&eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = SIDE * SIDE;
    d.surfel_count = 8;
    d.tile_side = 8;
    e = engine_open(&d, &view);
    assert_int_equal(ism_set_vpls(engine_maps(e), list, SIDE * SIDE), ISM_OK);
    s.no_maps = 1;
    s.near_mode = ISM_NEAR_CLAMP;
    s.clamp = 25;
    engine_shade(e, &s, light, &lost);
    /* pi L (1 - h sqrt c)^2 of pi L; 128^2 VPLs 3 cm apart and the plane's end: 0.005 */
    CONFORM("T44", "h = 0.1, c = 25: share lost, as reported", 0.25, lost, 0.005);
    CONFORM("T44", "h = 0.1, c = 25: irradiance left", 0.75 * UTIL_PI, light[0], 0.03);
    s.near_mode = ISM_NEAR_PATCH;
    engine_shade(e, &s, light, &lost);
    CONFORM("T44", "the same by patches: irradiance", UTIL_PI, light[0], 0.02);
    CONFORM("T44", "the same by patches: share lost", 0, lost, 0);
    engine_close(e);
}

enum { FURNACE_VPLS = 256, FURNACE_SIDE = 8, FURNACE_EYE = 24, FURNACE_EYES = FURNACE_EYE * FURNACE_EYE,
       FURNACE_MOST = 3 * FURNACE_VPLS * FURNACE_SIDE * FURNACE_SIDE };

/* A closed box whose walls all have the radiance 1, as `lit` points that emit, with room for those of a bounce; eyes
   on its floor, and maps for it. */
typedef struct furnace {
    float    at[FURNACE_MOST], n[FURNACE_MOST], flux[FURNACE_MOST];
    ism_mesh mesh;
    ism_desc desc;
} furnace;

static furnace *furnace_make(uint32_t lit)
{
    static float emission[3 * 4096];
    static furnace made;
    const float lo[3] = { -1, -1, -1 }, hi[3] = { 1, 1, 1 };
    const float a[3] = { -1, -1, -1 }, u[3] = { 2, 0, 0 }, v[3] = { 0, 0, 2 }, up[3] = { 0, 1, 0 };
    size_t i;
    memset(&made, 0, sizeof made);
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, -1, 6);
    made.mesh = soup_mesh(&mesh);
    for (i = 0; i < 3 * mesh.triangles; i++) emission[i] = 1;
    grid_fill(&eye, FURNACE_EYE, FURNACE_EYE, a, u, v, up, 0);
    assert_int_equal(ism_emitter_points(&made.mesh, emission, lit, 1, NULL, made.at, made.n, made.flux), ISM_OK);
    made.desc.vpl_count = FURNACE_VPLS;
    made.desc.surfel_count = 1024;
    made.desc.tile_side = 32;
    made.desc.keep_hits = 1;
    return &made;
}

/* Adds the light of bounce 1 or 2 to *radiance, which is 1 at first, and writes its row: walls of albedo 0.5 have the
   radiance 1, 1.5, 1.75, ... where: "" or on which machine. 256 VPLs at random places beside a floor that meets the
   walls: 3 % a bounce. */
static void furnace_row(const float *light, int bounce, const char *where, double *radiance)
{
    static const double expected[3] = { 1, 1.5, 1.75 };
    double mean = 0;
    char text[80];
    size_t i;
    for (i = 0; i < FURNACE_EYES; i++) mean += (double)light[3 * i] / FURNACE_EYES;
    *radiance += 0.5 * mean / UTIL_PI;
    snprintf(text, sizeof text, "radiance after %d bounce%s%s", bounce, bounce > 1 ? "s" : "", where);
    CONFORM("T45", text, expected[bounce], *radiance, 0.03 * bounce);
}

static void t45_a_closed_furnace_gains_half_of_the_last_bounce(void **state)
{
    ROW_TEST(state)
    static float light[3 * FURNACE_EYES];
    const ism_shading shading = { 0 };
    furnace *k = furnace_make(4096);
    const ism_points view = grid_view(&eye);
    double radiance = 1;
    ism_source s;
    ism_frame f;
    int bounce;
    memset(&s, 0, sizeof s);
    s.width = 4096;
    s.height = 1;
    s.positions = k->at;
    s.normals = k->n;
    s.fluxes = k->flux;
    s.scattered = 1;
    f = frame_of(&k->mesh, &view, 0);
    f.sources = &s;
    f.source_count = 1;
    for (bounce = 1; bounce <= 2; bounce++) {
        engine *e = engine_open(&k->desc, &view);
        assert_int_equal(ism_choose(engine_maps(e), &f), ISM_OK);
        engine_draw(e, &f);
        engine_shade(e, &shading, light, NULL);
        furnace_row(light, bounce, "", &radiance);
        if (bounce == 1) engine_bounce(e, &f, FURNACE_SIDE, k->at, k->n, k->flux);
        s.width = FURNACE_VPLS * FURNACE_SIDE * FURNACE_SIDE;
        engine_close(e);
    }
}

#define ISM_ROWS(test)                                                                                          \
    test(t42_t43_form_factors_equal_their_closed_forms),                                                        \
    test(maps_of_the_hemisphere_keep_solid_angle_and_come_back),                                                \
    test(a_fine_surface_does_not_hide_itself), test(splats_cover_a_sphere), test(tiles_are_apart),              \
    test(an_occluder_between_two_squares_takes_its_share), test(a_sealed_box_stays_dark),                       \
    test(a_folded_sheet_is_dark_below),                                                                         \
    test(clamping_is_known), test(t45_a_closed_furnace_gains_half_of_the_last_bounce)

#endif
