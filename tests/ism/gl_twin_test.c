/* gl_twin_test - the GLSL of ism_*.glsl against ism.h: whole atlases, empty and filled, of every projection and of
   skies and lobes, and the next bounce by them; light by every rule near by,
   by lists and by interleaved pictures; moving meshes and
   renewed points. */
#define _POSIX_C_SOURCE 200809L
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_ism.h"

#include "gl_test.h"
#include "util.h"
#include "gl_util.h"

enum { VPLS = 40, SURFELS = 600, TILE = 32, WIDTH = 40, HEIGHT = 30, PIXELS = WIDTH * HEIGHT, SHOWN = 4 };

/* A room with an octahedron, a few lamps in it and a picture of its floor and one wall. */
typedef struct stage {
    soup      mesh;
    ism_mesh  ism;
    ism_vpl   vpls[VPLS];
    grid      picture;
    float     albedos[3 * PIXELS];
    ism_points view;
    ism_frame frame;
    ism_maps *maps;
    ism_desc  desc;
} stage;

static stage stage_now;     /* large */

static stage *stage_open(const ism_desc *desc, int kinds)
{
    static const float lo[3] = { -2, 0, -2 }, hi[3] = { 2, 3, 2 }, up[3] = { 0, 1, 0 }, a[3] = { -2, 0, -2 };
    static const float u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 };
    stage *s = &stage_now;
    uint32_t seed = 3, i, k;
    memset(s, 0, sizeof *s);
    soup_box(&s->mesh, lo, hi, -1, 6);
    soup_octahedron(&s->mesh, 0.7f);
    for (i = 0; i < 8 * 3; i++) s->mesh.p[9 * (s->mesh.triangles - 8) + 3 * i + 1] += 1.0f;
    s->ism = soup_mesh(&s->mesh);
    grid_fill(&s->picture, WIDTH, HEIGHT, a, u, v, up, 1);
    for (i = 0; i < PIXELS; i++) {
        if (i % 3 == 0) {               /* a wall */
            s->picture.p[3 * i + 1] = 0.1f + 2.8f * util_unit(&seed);
            s->picture.p[3 * i + 2] = -2;
            s->picture.n[3 * i + 1] = 0;
            s->picture.n[3 * i + 2] = 1;
        }
        if (i % 101 == 0) s->picture.n[3 * i] = s->picture.n[3 * i + 1] = s->picture.n[3 * i + 2] = 0;
        for (k = 0; k < 3; k++) s->albedos[3 * i + k] = 0.2f + 0.6f * util_unit(&seed);
    }
    s->view = grid_view(&s->picture);
    s->view.albedos = s->albedos;
    for (i = 0; i < VPLS; i++) {
        ism_vpl *l = &s->vpls[i];
        int axis = (int)(i % 3), far = (int)(i / 3 % 2);
        float n[3] = { 0, 0, 0 };
        n[axis] = far ? -1.0f : 1.0f;
        *l = util_vpl(0, 0, 0, n[0], n[1], n[2], 0.5f + util_unit(&seed));
        for (k = 0; k < 3; k++) l->position[k] = lo[k] + (hi[k] - lo[k]) * (0.1f + 0.8f * util_unit(&seed));
        l->position[axis] = (far ? hi : lo)[axis];
        l->area = 0.1f;
        if (kinds && i % 4 == 1) {      /* a lobe about another axis */
            l->exponent = 1 + 20 * util_unit(&seed);
            l->axis[(axis + 1) % 3] = 0.5f;
            for (k = 0; k < 3; k++) l->axis[k] *= (float)(1 / sqrt(1.25));
        }
        if (kinds && i % 4 == 2) {      /* a direction of a sky */
            const float w[3] = { util_unit(&seed) - 0.5f, 0.6f, util_unit(&seed) - 0.5f };
            const float length = sqrtf(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
            l->directional = 1;
            for (k = 0; k < 3; k++) {
                l->position[k] = w[k] / length;
                l->normal[k] = l->axis[k] = -l->position[k];
            }
        }
    }
    s->frame.mesh = &s->ism;
    s->frame.points = &s->view;
    s->desc = *desc;
    s->desc.vpl_count = VPLS;
    s->desc.surfel_count = SURFELS;
    if (!s->desc.tile_side) s->desc.tile_side = TILE;
    if (!s->desc.lazy_frames) s->desc.lazy_frames = 8;
    assert_int_equal(ism_create(&s->desc, &s->maps), ISM_OK);
    assert_int_equal(ism_set_vpls(s->maps, s->vpls, VPLS), ISM_OK);
    return s;
}

static void stage_close(stage *s) { ism_free(s->maps); }

/* ---- what a renderer does ---- */

static size_t windows_sent;

static void send_vpls(gl_test *t, const stage *s, glbk_ism_maps *m)
{
    size_t count, i;
    const ism_vpl *from = ism_vpls(s->maps, &count);
    ism_info info;
    for (i = 0; i < count; i++) windows_sent += from[i].window != 0;
    ism_get_info(s->maps, &info);
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, m, from, (uint32_t)count, &info));
}

static void send_phase(gl_test *t, const stage *s, glbk_ism_maps *m, uint32_t phase)
{
    static ism_surfel surfels[VPLS * SURFELS];
    size_t count;
    assert_int_equal(ism_phase_surfels(s->maps, phase, surfels, VPLS * SURFELS, &count), ISM_OK);
    assert_int_equal(count, VPLS * m->phase_surfel_count);
    assert_glbk(t, glbk_ism_surfels_upload(&t->gl, m, phase, surfels, count));
}

static void open_maps(gl_test *t, const stage *s, glbk_ism_maps *m)
{
    uint32_t phase;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &s->desc, m));
    send_vpls(t, s, m);
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, m, &s->ism));
    assert_int_equal(glbk_ism_draw(&t->gl, m, 0), GLBK_ERR_ORDER);      /* no surfels yet */
    for (phase = 0; phase < s->desc.lazy_frames; phase++) send_phase(t, s, m, phase);
}

/* Texels whose depths differ by more than 1e-4: rays through the rim of a disc, where floats decide. */
static double atlas_difference(gl_test *t, const stage *s, glbk_ism_maps *m, const char *what)
{
    uint32_t side, tiles;
    const float *cpu = ism_atlas(s->maps, &side, &tiles);
    float *gl = (float *)malloc((size_t)side * side * sizeof *gl);
    size_t i, full = 0, used = 0, off = 0;
    assert_non_null(gl);
    assert_int_equal(side, m->side);
    assert_glbk(t, glbk_ism_draw(&t->gl, m, 0));
    assert_glbk(t, gl_read_atlas(&t->gl, m, gl));
    for (i = 0; i < (size_t)side * side; i++) {
        size_t tile = i / side / s->desc.tile_side * tiles + i % side / s->desc.tile_side;
        if (tile >= VPLS) continue;
        used++;
        full += cpu[i] < ISM_FAR;
        off += !(fabsf(gl[i] - cpu[i]) <= 1e-4f * cpu[i]);
    }
    free(gl);
    printf("%s: %zu texels, %zu with a surface, %zu differ\n", what, used, full, off);
    assert_true(full > used / 3);               /* or this compares nothing */
    return (double)off / (double)used;
}

/* Browsers draw the first projection and the last, since all take a minute there. Other contexts draw the same GLSL of
   all four, and in browsers gl_backend/backend_test links it. */
static int projection_step(void) { return gl_this_way()->bit == GL_WEBGL2 ? 3 : 1; }

static void atlases_are_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    static const char *const names[] = { "default", "cosine", "paraboloid", "octahedral", "lobe" };
    int projection, fill;
    windows_sent = 0;
    for (projection = 1; projection < 5; projection += projection_step())
        for (fill = 0; fill < 2; fill++) {
            ism_desc d;
            glbk_ism_maps m;
            char what[64];
            stage *s;
            memset(&d, 0, sizeof d);
            d.projection = (ism_projection)projection;
            d.no_fill = !fill;
            s = stage_open(&d, 1);
            assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
            open_maps(t, s, &m);
            snprintf(what, sizeof what, "%s %s", names[projection], fill ? "filled" : "with holes");
            assert_true(atlas_difference(t, s, &m, what) < 1e-3);
            glbk_ism_maps_free(&t->gl, &m);
            stage_close(s);
        }
    assert_true(windows_sent > 2 * VPLS);
}

/* The texels of a bounce: place, normal, flux of texel i, three floats each. */
static void read_bounces(gl_test *t, const glbk_ism_bounces *b, float *out[3])
{
    const size_t count = (size_t)b->texels.width * b->texels.height;
    uint32_t *words = (uint32_t *)malloc(16 * count), k;
    size_t i;
    assert_non_null(words);
    for (k = 0; k < 3; k++) {
        assert_glbk(t, glbk_target_read(&t->gl, &b->target, k, 0, 0, b->texels.width, b->texels.height, words));
        for (i = 0; i < count; i++) memcpy(out[k] + 3 * i, words + 4 * i, 12);
    }
    free(words);
}

static double apart(const float *a, const float *b)
{
    return sqrt(pow((double)a[0] - (double)b[0], 2) + pow((double)a[1] - (double)b[1], 2) +
                pow((double)a[2] - (double)b[2], 2));
}

/* Texels that hit another triangle, or nothing, are those of rims, as in atlases, or lie where discs of two triangles
   of a wall overlap, and are counted. */
static void bounces_are_those_of_ism_bounce(void **state)
{
    GL_TEST(t, state)
    static float cpu[3][3 * VPLS * TILE * TILE], gl[3][3 * VPLS * TILE * TILE], albedos[3 * 4096];
    float *const from[3] = { cpu[0], cpu[1], cpu[2] };
    float *to[3] = { gl[0], gl[1], gl[2] };
    int projection, way;
    size_t i, k;
    for (i = 0; i < 3 * 4096; i++) albedos[i] = 0.1f + 0.0002f * (float)i;
    for (projection = 1; projection < 5; projection += projection_step())
        for (way = 0; way < 3; way++) {
            const uint32_t side = way == 1 ? TILE : 8;
            const size_t count = (size_t)VPLS * side * side;
            double places = 0, normals = 0, fluxes = 0;
            size_t off = 0, beside = 0, lit = 0;
            glbk_ism_bounces b;
            glbk_ism_maps m;
            ism_desc d;
            stage *s;
            memset(&d, 0, sizeof d);
            d.projection = (ism_projection)projection;
            d.no_fill = way == 2;
            d.keep_hits = 1;
            s = stage_open(&d, 1);
            assert_true(s->mesh.triangles <= 4096);
            if (way) s->ism.albedos = albedos;
            assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
            assert_int_equal(ism_bounce(s->maps, &s->ism, side, from[0], from[1], from[2]), ISM_OK);
            open_maps(t, s, &m);
            assert_glbk(t, glbk_ism_bounces_create(&t->gl, &m, side, &b));
            assert_int_equal(glbk_ism_bounce(&t->gl, &b, &m), GLBK_ERR_ORDER);      /* not drawn yet */
            assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
            assert_glbk(t, glbk_ism_bounce(&t->gl, &b, &m));
            read_bounces(t, &b, to);
            for (i = 0; i < 3 * count; i += 3) {
                const double place = apart(gl[0] + i, cpu[0] + i), normal = apart(gl[1] + i, cpu[1] + i);
                double flux;
                lit += cpu[2][i] > 0;
                if ((cpu[2][i] > 0) != (gl[2][i] > 0) || place > 1e-3 || normal > 1e-3) {
                    off++;
                    continue;
                }
                places = fmax(places, place);
                normals = fmax(normals, normal);
                flux = 0;
                for (k = 0; k < 3; k++)
                    flux = fmax(flux, fabs((double)gl[2][i + k] - (double)cpu[2][i + k]) /
                                          fmax((double)cpu[2][i + k], 1e-9));
                if (way && flux > 1e-4) beside++;           /* the albedo of a neighbour, 2e-3 away or less */
                else fluxes = fmax(fluxes, flux);
            }
            printf("projection %d, %u x %u cells%s: of %zu texels %zu are lit, %zu differ, %zu have a neighbour's "
                   "albedo; the others' places differ by %.1e, normals by %.1e, fluxes by %.1e\n", projection, side,
                   side, d.no_fill ? " with holes" : "", count, lit, off, beside, places, normals, fluxes);
            assert_true(lit > count / 3 && lit < count);
            assert_true((double)off < 2e-3 * (double)count);
            assert_true((double)beside < 1e-2 * (double)count);
            assert_true(fluxes < 1e-4);
            glbk_ism_bounces_free(&t->gl, &b);
            glbk_ism_bounces_free(&t->gl, &b);
            glbk_ism_maps_free(&t->gl, &m);
            stage_close(s);
        }
}

static void bounces_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_ism_bounces b, none;
    glbk_ism_maps m, plain;
    ism_mesh one;
    ism_desc d;
    stage *s;
    memset(&d, 0, sizeof d);
    memset(&none, 0, sizeof none);
    s = stage_open(&d, 0);
    assert_int_equal(ism_scatter(s->maps, &s->frame), ISM_OK);
    open_maps(t, s, &plain);
    assert_int_equal(glbk_ism_bounces_create(&t->gl, &plain, 8, &b), GLBK_ERR_MISMATCH);
    stage_close(s);
    d.keep_hits = 1;
    d.tile_side = 256;
    s = stage_open(&d, 0);
    assert_int_equal(ism_scatter(s->maps, &s->frame), ISM_OK);
    open_maps(t, s, &m);
    assert_int_equal(glbk_ism_bounces_create(NULL, &m, 8, &b), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounces_create(&t->gl, NULL, 8, &b), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounces_create(&t->gl, &m, 8, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounces_create(&t->gl, &m, 0, &b), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounces_create(&t->gl, &m, 12, &b), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounces_create(&t->gl, &m, 512, &b), GLBK_ERR_ARGUMENT);
    if (t->gl.max_side < 65536)
        assert_int_equal(glbk_ism_bounces_create(&t->gl, &m, 256, &b), GLBK_ERR_LIMIT);
    glbk_ism_maps_free(&t->gl, &m);     /* what is drawn from here on has fewer texels: a 64th */
    stage_close(s);
    d.tile_side = 0;
    s = stage_open(&d, 0);
    assert_int_equal(ism_scatter(s->maps, &s->frame), ISM_OK);
    open_maps(t, s, &m);
    assert_glbk(t, glbk_ism_bounces_create(&t->gl, &m, 4, &b));
    assert_int_equal(glbk_ism_bounce(NULL, &b, &m), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounce(&t->gl, NULL, &m), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounce(&t->gl, &none, &m), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounce(&t->gl, &b, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_bounce(&t->gl, &b, &plain), GLBK_ERR_MISMATCH);
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    assert_glbk(t, glbk_ism_bounce(&t->gl, &b, &m));
    one = s->ism;
    one.vertex_count = 3;               /* the maps show triangles that are gone, until they are drawn again */
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &m, &one));
    assert_int_equal(glbk_ism_bounce(&t->gl, &b, &m), GLBK_ERR_ORDER);
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &m, &s->ism));
    assert_int_equal(glbk_ism_bounce(&t->gl, &b, &m), GLBK_ERR_ORDER);
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    assert_glbk(t, glbk_ism_bounce(&t->gl, &b, &m));
    glbk_ism_bounces_free(&t->gl, NULL);
    glbk_ism_bounces_free(&t->gl, &b);
    glbk_ism_maps_free(&t->gl, &m);
    glbk_ism_maps_free(&t->gl, &plain);
    stage_close(s);
}

/* ---- light ---- */

/* Pictures with too many such receivers; a test asserts that there were none, when it has said them all. */
static unsigned too_many_flipped;

/* Receivers where a depth comparison fell out the other way are counted: a share of at most `flips` of them. The
   others' largest difference over the mean. */
static double difference(const float *a, const float *b, size_t count, double flips)
{
    double mean = 0, worst = 0;
    size_t i, k, flipped = 0;
    for (i = 0; i < 3 * count; i++) mean += (double)b[i] / (3 * (double)count);
    assert_true(mean > 0);
    for (i = 0; i < count; i++) {
        double off = 0;
        for (k = 0; k < 3; k++) off = fmax(off, fabs((double)a[3 * i + k] - (double)b[3 * i + k]) / mean);
        if (off > 1e-4 && flipped++ < SHOWN)
            printf("    receiver %zu: %g %g %g, by ism.h %g %g %g, mean %g\n", i, (double)a[3 * i],
                   (double)a[3 * i + 1], (double)a[3 * i + 2], (double)b[3 * i], (double)b[3 * i + 1],
                   (double)b[3 * i + 2], mean);
        if (off <= 1e-4) worst = fmax(worst, off);
    }
    printf("    light: %zu of %zu receivers flipped, the others differ by %.1e of the mean\n", flipped, count, worst);
    too_many_flipped += (double)flipped > flips * (double)count;
    return worst;
}

static void send_picture(gl_test *t, const stage *s, glbk_gbuffer *seen, glbk_ism_renderer *r)
{
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ WIDTH, HEIGHT }, r));
    gl_see(&t->gl, WIDTH, HEIGHT, s->picture.p, s->picture.n, s->albedos, seen);
}

static double light_difference(gl_test *t, stage *s, const glbk_ism_maps *m, const glbk_gbuffer *seen,
                               glbk_ism_renderer *r, const ism_shading *shading, double *lost)
{
    static float cpu[3 * PIXELS], gl[3 * PIXELS];
    ism_stats stats;
    size_t i;
    assert_int_equal(ism_shade(s->maps, &s->view, shading, cpu, &stats), ISM_OK);
    assert_glbk(t, glbk_ism_shade(&t->gl, r, seen, m, shading, 0));
    gl_light_of(&t->gl, r, s->view.albedos, gl, lost);
    for (i = 0; i < PIXELS; i += 101) assert_true(gl[3 * i] == 0);      /* background */
    *lost = fabs(*lost - stats.lost_energy);
    return difference(gl, cpu, PIXELS, shading->interleave > 1 ? 0.02 : 0.005);
}

/* What glbk_ism_read says times albedo / pi, in 8 bits of a target. */
static void resolves(gl_test *t, const stage *s, const glbk_gbuffer *seen, glbk_ism_renderer *r)
{
    static float light[3 * PIXELS], picture[4 * PIXELS];
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_RGBA8, WIDTH, HEIGHT, 0);
    glbk_pass pass;
    double sum = 0;
    size_t i;
    memset(&pass, 0, sizeof pass);
    pass.target = &canvas.target;
    assert_glbk(t, glbk_ism_resolve(&t->gl, r, seen, &pass, NULL));
    gl_light_of(&t->gl, r, s->albedos, light, NULL);
    assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, WIDTH, HEIGHT, picture));
    for (i = 0; i < 3 * PIXELS; i++) {
        double wanted = light[i] < 1 ? (double)light[i] : 1;
        sum += wanted;
        assert_true(fabs((double)picture[4 * (i / 3) + i % 3] - wanted) < 1 / 255.0);
    }
    assert_true(sum > 1);
    gl_canvas_free(t, &canvas);
}

static void light_is_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    double worst = 0, worst_lost = 0;
    int projection, near_mode, k;
    for (projection = 1; projection < 5; projection += 3) {
        ism_desc d;
        glbk_ism_maps m;
        glbk_gbuffer seen;
        glbk_ism_renderer r;
        stage *s;
        memset(&d, 0, sizeof d);
        d.projection = (ism_projection)projection;
        s = stage_open(&d, 1);
        assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
        open_maps(t, s, &m);
        assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
        send_picture(t, s, &seen, &r);
        for (near_mode = 1; near_mode < 7; near_mode++)          /* the last without near points: as the first */
            for (k = 0; k < 3; k++) {
                ism_shading shading = { 0 };
                double lost, off;
                if (projection == 4 && near_mode > 1) continue;
                shading.near_mode = (ism_near)near_mode;
                shading.clamp = near_mode == ISM_NEAR_CLAMP_MEAN ? 2.0f : 0.05f;
                shading.interleave = k == 1 ? 2 : 1;
                shading.no_maps = k == 2;
                s->view.albedos = k == 0 ? NULL : s->albedos;
                off = light_difference(t, s, &m, &seen, &r, &shading, &lost);
                if (off > worst) worst = off;
                /* blurred, or weighed by albedos, the loss is another number */
                if (k == 0 && lost > worst_lost) worst_lost = lost;
            }
        resolves(t, s, &seen, &r);
        glbk_ism_renderer_free(&t->gl, &r);
        glbk_gbuffer_free(&t->gl, &seen);
        glbk_ism_maps_free(&t->gl, &m);
        stage_close(s);
    }
    assert_true(worst < 2e-5 && worst_lost < 1e-4);
    assert_int_equal(too_many_flipped, 0);
}

/* With near points, which ism_choose draws: a lit floor and wall of the room, and the same two seen. */
static void near_points_agree(void **state)
{
    GL_TEST(t, state)
    /* Askew, since on a grid of round numbers directions fall on borders of texels, where rounding decides: on an H200
       one VPL's map hid 12 of 1,200 receivers that it lights on llvmpipe. */
    static const float up[3] = { 0, 1, 0 }, right[3] = { 1, 0, 0 }, ground[3] = { -1.971f, 0, -1.953f };
    static const float wall[3] = { -2, 0.017f, -1.953f }, u[3] = { 3.913f, 0, 0 }, v[3] = { 0, 0, 3.887f };
    static const float w[3] = { 0, 2.931f, 0 };
    static grid lit[2];
    double worst = 0, worst_lost = 0, lost, off;
    const ism_near_point *points;
    ism_source sources[2];
    ism_desc d;
    glbk_ism_maps m;
    glbk_gbuffer seen;
    glbk_ism_renderer r;
    stage *s;
    size_t count;
    int k;
    memset(&d, 0, sizeof d);
    s = stage_open(&d, 0);
    grid_fill(&lit[0], 32, 32, ground, u, v, up, 0.01f);
    grid_fill(&lit[1], 32, 32, wall, v, w, right, 0.02f);
    for (k = 0; k < 2; k++) sources[k] = grid_source(&lit[k]);
    s->frame.sources = sources;
    s->frame.source_count = 2;
    assert_int_equal(ism_choose(s->maps, &s->frame), ISM_OK);
    assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
    points = ism_near_points(s->maps, &count);
    assert_int_equal(count, 16 * VPLS);
    open_maps(t, s, &m);
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    assert_true(atlas_difference(t, s, &m, "about lit grids") < 1e-3);
    send_picture(t, s, &seen, &r);
    for (k = 0; k < 4; k++) {
        ism_shading shading = { 0 };
        assert_glbk(t, glbk_ism_near_points_upload(&t->gl, &m, points, (uint32_t)count));
        shading.near_mode = k == 3 ? ISM_NEAR_DEFAULT : ISM_NEAR_GATHER;
        shading.interleave = k == 1 ? 4 : 1;
        shading.no_maps = k == 2;
        s->view.albedos = k == 0 ? NULL : s->albedos;
        off = light_difference(t, s, &m, &seen, &r, &shading, &lost);
        if (off > worst) worst = off;
        if (k == 0 && lost > worst_lost) worst_lost = lost;
    }
    assert_true(worst < 2e-5 && worst_lost < 1e-4);
    assert_int_equal(too_many_flipped, 0);
    glbk_ism_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_ism_maps_free(&t->gl, &m);
    stage_close(s);
}

/* ---- a function of one's own in place of the maps ---- */

static float cut = 0.3331f;

/* Different for every third VPL, on both sides of a plane, for floors and walls. */
static void see(void *user, const float position[3], const float normal[3], const uint32_t *numbers, size_t count,
                float *visible)
{
    size_t i;
    (void)user;
    for (i = 0; i < count; i++) {
        visible[i] = (float)(numbers[i] % 3) * 0.5f;
        if (position[0] > cut) visible[i] *= 0.25f;
        if (normal[1] > 0.5f) visible[i] *= 0.5f;
    }
}

static const char see_text[] =
    "uniform float cut;\n"
    "float glbk_visible(uint vpl, vec3 position, vec3 geometric_normal)\n"
    "{\n"
    "    float seen = float(vpl % 3u) * 0.5;\n"
    "    if (position.x > cut) seen *= 0.25;\n"
    "    if (geometric_normal.y > 0.5) seen *= 0.5;\n"
    "    return seen;\n"
    "}\n";

static void set_cut(void *user, glbk_context *ctx)
{
    ctx->gl.Uniform1f(ctx->gl.GetUniformLocation(ctx->program, "cut"), *(const float *)user);
}

/* ism_shade's visible_fn and the same as GLSL: VPLs and near points, each rule near by, interleaved or not; half of
   everything is half of the light without maps, up to rounding; then the maps again. Nobody has drawn the maps. */
static void a_function_of_ones_own_says_what_is_seen(void **state)
{
    GL_TEST(t, state)
    static const float up[3] = { 0, 1, 0 }, ground[3] = { -1.971f, 0, -1.953f };
    static const float u[3] = { 3.913f, 0, 0 }, v[3] = { 0, 0, 3.887f };
    static const glbk_ism_visible own = { see_text, set_cut, &cut },
        half = { "float glbk_visible(uint vpl, vec3 p, vec3 n) { return 0.5; }\n", NULL, NULL },
        none = { NULL, set_cut, NULL },             /* without a text it would read NULL if it were called */
        wrong = { "float glbk_visible(uint vpl) { return nothing; }\n", NULL, NULL };
    static float open[3 * PIXELS], halved[3 * PIXELS];
    static grid lit;
    double worst = 0, lost, off;
    const ism_near_point *points;
    ism_shading shading = { 0 };
    ism_source source;
    ism_desc d;
    glbk_ism_maps m;
    glbk_gbuffer seen;
    glbk_ism_renderer r;
    stage *s;
    size_t count, i;
    int k;
    memset(&d, 0, sizeof d);
    s = stage_open(&d, 0);
    grid_fill(&lit, 32, 32, ground, u, v, up, 0.01f);
    source = grid_source(&lit);
    s->frame.sources = &source;
    s->frame.source_count = 1;
    assert_int_equal(ism_choose(s->maps, &s->frame), ISM_OK);
    assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
    points = ism_near_points(s->maps, &count);
    open_maps(t, s, &m);
    assert_glbk(t, glbk_ism_near_points_upload(&t->gl, &m, points, (uint32_t)count));
    send_picture(t, s, &seen, &r);
    assert_int_equal(glbk_ism_shade(&t->gl, &r, &seen, &m, NULL, 0), GLBK_ERR_ORDER);
    assert_glbk(t, glbk_ism_renderer_see(&t->gl, &r, &own));
    for (k = 0; k < 5; k++) {
        static const ism_near rules[] = { ISM_NEAR_GATHER, ISM_NEAR_PATCH, ISM_NEAR_NONE, ISM_NEAR_CLAMP_MEAN };
        ism_shading asked = { 0 }, plain = { 0 };
        static float cpu[3 * PIXELS], gl[3 * PIXELS];
        asked.near_mode = plain.near_mode = rules[k % 4];
        asked.interleave = plain.interleave = k == 4 ? 2 : 1;
        plain.no_maps = k == 1;                     /* does not count, on either side */
        asked.no_maps = k == 1;
        asked.visible_fn = see;
        s->view.albedos = NULL;
        assert_int_equal(ism_shade(s->maps, &s->view, &asked, cpu, NULL), ISM_OK);
        assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &m, &plain, 0));
        gl_light_of(&t->gl, &r, NULL, gl, &lost);
        off = difference(gl, cpu, PIXELS, k == 4 ? 0.02 : 0);
        if (off > worst) worst = off;
    }
    assert_true(worst < 2e-5);
    assert_int_equal(too_many_flipped, 0);
    assert_glbk(t, glbk_ism_renderer_see(&t->gl, &r, &half));
    assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &m, NULL, 0));
    gl_light_of(&t->gl, &r, NULL, halved, &lost);
    assert_glbk(t, glbk_ism_renderer_see(&t->gl, &r, &none));
    shading.no_maps = 1;
    assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &m, &shading, 0));
    gl_light_of(&t->gl, &r, NULL, open, &lost);
    for (i = 0; i < 3 * PIXELS; i++) assert_true(fabsf(halved[i] - 0.5f * open[i]) <= 1e-6f * open[i]);
    assert_int_equal(glbk_ism_renderer_see(&t->gl, NULL, &own), GLBK_ERR_ARGUMENT);
    assert_glbk(t, glbk_ism_renderer_see(&t->gl, &r, NULL));
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    shading.no_maps = 0;
    s->view.albedos = s->albedos;
    assert_true(light_difference(t, s, &m, &seen, &r, &shading, &lost) < 2e-5);
    assert_int_equal(too_many_flipped, 0);
    assert_glbk(t, glbk_ism_renderer_see(&t->gl, &r, &wrong));
    t->expected_errors = ~0u;                       /* last, since from here on no error of the driver counts */
    assert_int_equal(glbk_ism_shade(&t->gl, &r, &seen, &m, NULL, 0), GLBK_ERR_COMPILE);
    glbk_ism_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_ism_maps_free(&t->gl, &m);
    stage_close(s);
}

/* Triangles that move keep their points; a frame sends one phase; both splats draw the same. */
static void light_follows_moving_triangles(void **state)
{
    GL_TEST(t, state)
    ism_desc d;
    glbk_ism_maps m, quads;
    stage *s;
    size_t i;
    float range = t->gl.max_point_side, opacity[1024];
    memset(&d, 0, sizeof d);
    d.lazy_frames = 3;
    s = stage_open(&d, 1);
    for (i = 0; i < 1024; i++) opacity[i] = i % 5 == 0 ? 0.5f : 1.0f;
    s->ism.opacities = opacity;
    assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
    open_maps(t, s, &m);
    t->gl.max_point_side = 1;
    open_maps(t, s, &quads);
    t->gl.max_point_side = range;
    for (s->frame.index = 1; s->frame.index < 5; s->frame.index++) {
        for (i = s->mesh.triangles - 8; i < s->mesh.triangles; i++)
            for (int k = 0; k < 3; k++) s->mesh.p[9 * i + 3 * (size_t)k] += 0.2f;
        assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
        assert_glbk(t, glbk_ism_mesh_move(&t->gl, &m, s->mesh.p, 0));
        send_phase(t, s, &m, s->frame.index % 3);
        send_vpls(t, s, &m);
    }
    assert_true(atlas_difference(t, s, &m, "moved, by points") < 1e-3);
    assert_glbk(t, glbk_ism_mesh_move(&t->gl, &quads, s->mesh.p, 0));
    for (i = 0; i < 3; i++) send_phase(t, s, &quads, (uint32_t)i);
    send_vpls(t, s, &quads);
    assert_true(atlas_difference(t, s, &quads, "moved, by rectangles") < 1e-3);
    assert_true(m.compute == t->gl.compute && m.quads == 0 && quads.quads == !t->gl.compute);
    glbk_ism_maps_free(&t->gl, &m);
    glbk_ism_maps_free(&t->gl, &quads);
    stage_close(s);
}

/* ---- your own program ---- */

static void pasted_functions_agree(void **state)
{
    GL_TEST(t, state)
    static const char text[] =
        "layout(location = 0) out glbk_color result;\n"
        "void main()\n"
        "{\n"
        "    vec3 p = vec3(gl_FragCoord.x * 0.2 - 1.6, 0.0, gl_FragCoord.y * 0.2 - 1.6);\n"
        "    vec3 n = vec3(0.0, 1.0, 0.0);\n"
        "    result = glbk_pack(vec4(ism_light(p, n, n, 0u, 1u).xyz, ism_visible(0u, ism_read_vpl(0u), p, n, 0.02)));\n"
        "}\n";
    enum { SIDE = 16 };
    glbk_source source;
    glbk_program program;
    glbk_pass pass;
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 0);
    float p[3 * SIDE * SIDE], n[3 * SIDE * SIDE], light[3 * SIDE * SIDE], visible[SIDE * SIDE], gl[4 * SIDE * SIDE];
    float got[3 * SIDE * SIDE];
    ism_points list;
    ism_desc d;
    glbk_ism_maps m;
    stage *s;
    size_t i, wrong;
    int way;

    memset(&d, 0, sizeof d);
    s = stage_open(&d, 0);
    assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
    open_maps(t, s, &m);
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    memset(&source, 0, sizeof source);
    source.fragment = text;
    source.parts[0] = glbk_ism_part();
    source.uses = "ism_light";
    source.defines = "ISM_NEAR=1 ISM_PROJECTION=1";
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
    memset(&pass, 0, sizeof pass);
    pass.target = &canvas.target;
    for (i = 0; i < SIDE * SIDE; i++) {
        p[3 * i] = ((float)(i % SIDE) + 0.5f) * 0.2f - 1.6f;
        p[3 * i + 1] = 0;
        p[3 * i + 2] = ((float)(i / SIDE) + 0.5f) * 0.2f - 1.6f;
        n[3 * i] = n[3 * i + 2] = 0;
        n[3 * i + 1] = 1;
    }
    memset(&list, 0, sizeof list);
    list.positions = p;
    list.normals = n;
    list.count = SIDE * SIDE;
    assert_int_equal(util_visible(s->maps, 0, p, n, SIDE * SIDE, 0.02f, visible), ISM_OK);
    for (way = 0; way < 3; way++) {         /* as glbk_ism_shade has it; another bias; nothing throws shadows */
        ism_shading shading = { 0 };
        shading.bias = way == 1 ? 0.2f : 0;
        shading.no_maps = way == 2;
        assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
        assert_glbk(t, glbk_ism_bind(&t->gl, &m, way ? &shading : NULL, NULL));
        glbk_draw_screen(&t->gl);
        assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, SIDE, SIDE, gl));
        for (i = wrong = 0; i < SIDE * SIDE; i++) {
            wrong += visible[i] != gl[4 * i + 3];
            memcpy(got + 3 * i, gl + 4 * i, 12);
        }
        assert_true(wrong <= 1);
        assert_int_equal(ism_shade(s->maps, &list, &shading, light, NULL), ISM_OK);
        assert_true(difference(got, light, SIDE * SIDE, 0.005) < 2e-5);
        assert_int_equal(too_many_flipped, 0);
    }
    glbk_program_free(&t->gl, &program);
    glbk_ism_maps_free(&t->gl, &m);
    gl_canvas_free(t, &canvas);
    stage_close(s);
}

/* ---- nothing, and too much ---- */

static void nothing_is_dark_and_too_much_is_refused(void **state)
{
    GL_TEST(t, state)
    static const float triangle[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    static float atlas[64 * 64], nothing[3 * 16], rgba[4 * 16];
    static const ism_surfel surfels[64];
    const ism_mesh mesh = { triangle, 3, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL };
    const ism_vpl vpl = { { 0, 0, 1 }, { 0, 0, -1 }, { 1, 1, 1 }, { 0, 0, -1 }, 1, 0, 0, 0, 0, 0, 0, 0, 0 };
    const ism_info info = { 0 };
    ism_desc d;
    glbk_ism_maps m;
    glbk_gbuffer seen;
    glbk_ism_renderer r;
    size_t i;

    memset(&d, 0, sizeof d);
    d.tile_side = 256;
    d.vpl_count = 16384;
    d.surfel_count = 8;
    if (t->gl.max_side < 32768) assert_int_equal(glbk_ism_maps_create(&t->gl, &d, &m), GLBK_ERR_LIMIT);
    d.vpl_count = 1;
    d.tile_side = 64;
    d.lazy_frames = 1;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ 4, 4 }, &r));
    gl_see(&t->gl, 4, 4, nothing, nothing, NULL, &seen);
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));                               /* no mesh, no VPLs: all far */
    assert_glbk(t, gl_read_atlas(&t->gl, &m, atlas));
    for (i = 0; i < 64 * 64; i++) assert_true(atlas[i] == ISM_FAR);
    assert_glbk(t, glbk_ism_shade(&t->gl, &r, &seen, &m, NULL, 0));
    assert_glbk(t, glbk_ism_read(&t->gl, &r, rgba));
    for (i = 0; i < 64; i++) assert_true(rgba[i] == 0);
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &m, &mesh));
    assert_int_equal(glbk_ism_draw(&t->gl, &m, 0), GLBK_ERR_ORDER);
    assert_glbk(t, glbk_ism_surfels_upload(&t->gl, &m, 0, surfels, 8));            /* all of area 0 */
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &m, &vpl, 1, &info));
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    assert_glbk(t, gl_read_atlas(&t->gl, &m, atlas));
    for (i = 0; i < 64 * 64; i++) assert_true(atlas[i] == ISM_FAR);
    glbk_ism_renderer_free(&t->gl, &r);
    glbk_ism_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_ism_maps_free(&t->gl, &m);
    glbk_ism_maps_free(&t->gl, &m);
    glbk_ism_maps_free(&t->gl, NULL);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(nothing_is_dark_and_too_much_is_refused),
        gl_unit_test(pasted_functions_agree),
        gl_unit_test(light_is_as_on_the_cpu),
        gl_unit_test(near_points_agree),
        gl_unit_test(a_function_of_ones_own_says_what_is_seen),
        gl_unit_test(light_follows_moving_triangles),
        gl_unit_test(atlases_are_as_on_the_cpu), gl_unit_test(bounces_are_those_of_ism_bounce),
        gl_unit_test(bounces_refuse_bad_arguments)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
