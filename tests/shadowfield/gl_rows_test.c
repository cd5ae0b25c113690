/* gl_rows_test - rows of docs/conformance.md by the GL back end: those of tests/shadowfield/rows.h, a sphere
   occluder (T72), beyond the last shell (T74), all turned (T76), order round a light (T78). Then objects drawn into the
   G-buffer, against shadowfield.h pixel by pixel. */
#define _POSIX_C_SOURCE 200809L
#include "shadowfield.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_shadowfield.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "gl_ask.h"
#include "util.h"

static gl_test *now;                /* of the test that runs */

#define ROW_TEST(state) GL_TEST(test_, state) now = test_;
#include "rows.h"

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { FIELDS = 3, MOST = 8, SIZE = 16 };

typedef enum { BALL, SOUP, LAMP } which;

static sfield_algebra *algebra;
static sfield_field   *field[FIELDS];

static int make_fields(void **state)
{
    model soup = model_soup(16, 0.6, 77);
    sfield_mesh of_soup = mesh_of(&soup);
    sfield_emitter e;
    sfield_desc d;
    (void)state;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    e.radius = 1;
    e.radiance[0] = 1;
    e.radiance[1] = 0.5f;
    field[BALL] = field_of_sphere(&d);
    d.radius = 1;
    d.position_side = 4;                        /* a sphere looks the same from everywhere */
    if (sfield_algebra_create(4, NULL, &algebra) != SFIELD_OK ||
        sfield_build_emitter(&d, &e, &field[LAMP], NULL) != SFIELD_OK)
        return -1;
    d.radius = 0;
    if (sfield_build(&d, &of_soup, &field[SOUP], NULL) != SFIELD_OK)
        return -1;
    model_free(&soup);
    return 0;
}

static int free_fields(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < FIELDS; i++) sfield_free(field[i]);
    sfield_algebra_free(algebra);
    return 0;
}

/* ---- a world on both sides ---- */

typedef struct world {
    glbk_sfield_scene    gl;
    glbk_gbuffer         gbuffer;
    glbk_sfield_renderer renderer;
    sfield_scene        *scene;
} world;

static void open_world(gl_test *t, world *w, uint32_t width, uint32_t height, float reach)
{
    const glbk_sfield_scene_desc d = { algebra, (const sfield_field *const *)field, FIELDS, MOST, reach, NULL };
    const glbk_sfield_renderer_desc r = { width, height, algebra, 0, 1, 5, 0, 0, 0, 0 };
    glbk_gbuffer_desc g;
    sfield_scene_desc s;
    memset(w, 0, sizeof *w);
    memset(&g, 0, sizeof g);
    g.width = width;
    g.height = height;
    memset(&s, 0, sizeof s);
    s.reach = reach;
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &d, &w->gl));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &g, &w->gbuffer));
    assert_glbk(t, glbk_sfield_renderer_create(&t->gl, &r, &w->renderer));
    assert_int_equal(sfield_scene_create(&s, &w->scene), SFIELD_OK);
}

static void close_world(gl_test *t, world *w)
{
    glbk_sfield_renderer_free(&t->gl, &w->renderer);
    glbk_gbuffer_free(&t->gl, &w->gbuffer);
    glbk_sfield_scene_free(&t->gl, &w->gl);
    sfield_scene_free(w->scene);
}

static sfield_entity at(int what, float x, float y, float z)
{
    sfield_entity e = upright;
    if (what == LAMP) e.source = field[LAMP];
    else e.occlusion = field[what];
    e.transform[12] = x;
    e.transform[13] = y;
    e.transform[14] = z;
    return e;
}

static void place(gl_test *t, world *w, const sfield_entity *e, uint32_t count, uint32_t sky)
{
    static const float white[3] = { 1, 1, 1 };
    float coefs[3 * 16];
    assert_int_equal(sfield_scene_entities(w->scene, e, count), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(w->scene, sky ? white : NULL, sky, sky, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_sky(w->scene, coefs), SFIELD_OK);
    assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &w->gl, e, count));
    assert_glbk(t, glbk_sfield_scene_sky(&t->gl, &w->gl, sky ? coefs : NULL));
}

/* One row of points of an entity; self: of all of them, or NULL. */
static void shade_on(gl_test *t, world *w, uint32_t entity, const float *p, const float *n, const float *self,
                     float *light)
{
    glbk_pixel pixels[SIZE];
    const float *of[SIZE];
    uint32_t i;
    memset(pixels, 0, sizeof pixels);
    for (i = 0; i < w->renderer.width; i++) {
        memcpy(pixels[i].position, p + 3 * i, 12);
        memcpy(pixels[i].normal, n + 3 * i, 12);
        pixels[i].entity = entity;
        of[i] = self;
    }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &w->gbuffer, 0, 1, pixels));
    assert_glbk(t, glbk_sfield_self_upload(&t->gl, &w->renderer, 0, 1, of));
    assert_glbk(t, glbk_sfield_shade(&t->gl, &w->renderer, &w->gbuffer, &w->gl, NULL, 0));
    assert_glbk(t, glbk_sfield_read(&t->gl, &w->renderer, light, NULL));
}

static void shade(gl_test *t, world *w, const float *p, const float *n, const float *self, float *light)
{
    shade_on(t, w, 0, p, n, self, light);
}

/* ---- functions of the library ---- */

/* A scene of that many bands with one field and one entity, or without. */
typedef struct asked {
    glbk_sfield_scene world;
    sfield_algebra   *algebra;
    char              defines[40];
} asked;

static void ask_open(asked *a, uint32_t bands, const sfield_field *f, const float *matrix)
{
    glbk_sfield_scene_desc d;
    sfield_entity e = upright;
    memset(a, 0, sizeof *a);
    memset(&d, 0, sizeof d);
    snprintf(a->defines, sizeof a->defines, "SFIELD_BANDS=%u", bands);
    assert_int_equal(sfield_algebra_create(bands, NULL, &a->algebra), SFIELD_OK);
    d.algebra = a->algebra;
    d.entity_capacity = 1;
    d.fields = &f;
    d.field_count = f != NULL;
    assert_glbk(now, glbk_sfield_scene_create(&now->gl, &d, &a->world));
    if (matrix) {
        memcpy(e.transform, matrix, sizeof e.transform);
        assert_glbk(now, glbk_sfield_scene_entities(&now->gl, &a->world, &e, 1));
    }
}

static void ask_close(asked *a)
{
    glbk_sfield_scene_free(&now->gl, &a->world);
    sfield_algebra_free(a->algebra);
}

static void bind_world(gl_test *t, const void *of)
{
    glbk_sfield_bind(&t->gl, (const glbk_sfield_scene *)of, NULL);
}

/* The text makes v of layers; a vector takes (bands^2 + 3) / 4 of them. */
#define ASK_VECTOR(text) \
    GL_ASK("    const int layers = (SFIELD_COEFS + 3) / 4;\n    float v[SFIELD_COEFS], a[SFIELD_COEFS];\n" text \
           "    for (int k = 0; k < 4; k++) if (4 * group + k < SFIELD_COEFS) r[k] = v[4 * group + k];\n")

static void ask_vector(const asked *a, const char *fragment, const float *in, uint32_t layers, size_t count, float *v)
{
    const size_t n = a->world.bands * a->world.bands;
    const uint32_t groups = (uint32_t)(n + 3) / 4;
    float *fours = (float *)malloc(16 * groups * count);
    size_t i, k;
    assert_non_null(fours);
    gl_ask(now, glbk_sfield_part(), fragment, "sfield_shade", a->defines,
           bind_world, &a->world, in, layers, count, groups, fours);
    for (i = 0; i < count; i++)
        for (k = 0; k < n; k++) v[n * i + k] = fours[4 * (k / 4 * count + i) + k % 4];
    free(fours);
}

/* Vectors of n numbers as layers of fours, `first` layers from the start. */
static void to_layers(const float *v, size_t n, size_t count, size_t first, float *in)
{
    size_t i, k;
    for (i = 0; i < count; i++)
        for (k = 0; k < n; k++) in[4 * ((first + k / 4) * count + i) + k % 4] = v[n * i + k];
}

static void ask_directions(uint32_t bands, const char *fragment, const float *directions, size_t count, float *v)
{
    float *in = (float *)calloc(4 * count, sizeof *in);
    asked a;
    assert_non_null(in);
    to_layers(directions, 3, count, 0, in);
    ask_open(&a, bands, NULL, NULL);
    ask_vector(&a, fragment, in, 1, count, v);
    ask_close(&a);
    free(in);
}

static void row_basis(uint32_t bands, const float *directions, size_t count, float *y)
{
    ask_directions(bands, ASK_VECTOR("    sfield_basis(layer(0).xyz, v);\n"), directions, count, y);
}

static void row_cosine(uint32_t bands, const float *directions, size_t count, float *t)
{
    ask_directions(bands, ASK_VECTOR("    sfield_cosine(layer(0).xyz, v);\n"), directions, count, t);
}

static void row_products(uint32_t bands, const float *a, const float *b, size_t count, float *r)
{
    const size_t n = bands * bands, layers = (n + 3) / 4;
    float *in = (float *)calloc(8 * layers * count, sizeof *in);
    asked w;
    assert_non_null(in);
    to_layers(a, n, count, 0, in);
    to_layers(b, n, count, layers, in);
    ask_open(&w, bands, NULL, NULL);
    ask_vector(&w,
               ASK_VECTOR("    float b[SFIELD_COEFS];\n"
                          "    for (int k = 0; k < SFIELD_COEFS; k++) {\n"
                          "        a[k] = layer(k / 4)[k % 4];\n"
                          "        b[k] = layer(layers + k / 4)[k % 4];\n"
                          "    }\n"
                          "    uvec2 terms = uvec2(glbk_sfield_contents.term_texel, glbk_sfield_contents.term_count);\n"
                          "    sfield_product(terms, a, b, v);\n"),
               in, (uint32_t)(2 * layers), count, r);
    ask_close(&w);
    free(in);
}

static void row_rotate(uint32_t bands, const float matrix[16], const float *a, size_t count, float *r)
{
    const size_t n = bands * bands, layers = (n + 3) / 4;
    float *in = (float *)calloc(4 * layers * count, sizeof *in);
    asked w;
    assert_non_null(in);
    to_layers(a, n, count, 0, in);
    ask_open(&w, bands, NULL, matrix);
    ask_vector(&w,
               ASK_VECTOR("    for (int k = 0; k < SFIELD_COEFS; k++) v[k] = layer(k / 4)[k % 4];\n"
                          "    uint rotation = SFIELD_MOVING(sfield_at(0u) + 5u).z;\n"
                          "    if (rotation != SFIELD_NONE) sfield_rotate(rotation, false, v);\n"),
               in, (uint32_t)layers, count, r);
    ask_close(&w);
    free(in);
}

static void row_query(const sfield_field *f, const float *positions, size_t count, float *v)
{
    float *in = (float *)calloc(4 * count, sizeof *in);
    sfield_info info;
    asked w;
    size_t i, k;
    assert_non_null(in);
    sfield_get_info(f, &info);
    ask_open(&w, info.bands, f, NULL);
    for (i = 0; i < count; i++) {
        for (k = 0; k < 3; k++) in[4 * i + k] = (positions[3 * i + k] - info.center[k]) / info.radius;
        memcpy(in + 4 * i + 3, &w.world.fields[0].start, 4);
    }
    ask_vector(&w,
               ASK_VECTOR("    uint f = floatBitsToUint(layer(0).w);\n"
                          "    sfield_fetch(f, sfield_locate(f, layer(0).xyz), 0u, 0.0, -1.0, v);\n"
                          "    v[0] += 3.54490770;\n"),
               in, 1, count, v);
    ask_close(&w);
    free(in);
}

/* ---- scenes ---- */

/* A kernel that is the same in all directions under a white sky: light is lost as directions are hidden. */
static void t72_a_sphere_hides_its_solid_angle(void **state)
{
    GL_TEST(t, state)
    static const double d[4] = { 1.25, 2, 8, 20 };
    static const char *const names[4] = { "percent blocked 1.25 r away, shadow field", "2 r away, shadow field",
                                          "8 r away, shadow field", "20 r away, shadow field" };
    const float self[16] = { 1.4f };
    const float at_last[2] = { 7.9999f, 8.0001f };
    float p[21], n[21], open[28], light[28];
    sfield_entity e = at(BALL, 0, 0, 0);
    world w;
    int i, k;
    for (i = 0; i < 7; i++)
        for (k = 0; k < 3; k++) {
            float dir = k == 0 ? 0.36f : k == 1 ? 0.48f : 0.8f;
            p[3 * i + k] = dir * (i < 4 ? (float)d[i] : i < 6 ? at_last[i - 4] : 80);
            n[3 * i + k] = -dir;
        }
    open_world(t, &w, 7, 1, 1000);              /* no fading */
    place(t, &w, &e, 0, 1);
    shade(t, &w, p, n, self, open);
    assert_true(fabs((double)open[0] - 1.4 * 3.544908 / PI) < 1e-3);
    place(t, &w, &e, 1, 1);
    shade(t, &w, p, n, self, light);
    for (i = 0; i < 7; i++) light[i] = 1 - light[4 * i] / open[4 * i];
    for (i = 0; i < 4; i++)                     /* between shells within 2 % */
        CONFORM("T72", names[i], i == 1 ? 6.699 : i == 2 ? 0.392 : 100 * blocked(d[i]), 100 * light[i],
                2 * (i == 1 ? 0.06699 : i == 2 ? 0.00392 : blocked(d[i])));
    CONFORM_MAX("T74", "step of the hidden share across the outermost shell", 1e-5,
                fabs((double)light[4] - (double)light[5]));
    assert_true(fabs((double)light[6] - blocked(80)) < 5e-7);       /* the last bits of 1 */
    close_world(t, &w);
}

static void only_what_lies_before_a_light_hides_it(void **state)
{
    GL_TEST(t, state)
    static const float origin[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    sfield_entity e[3];
    float lit[4], far[4], both[4], near[4];
    world w;
    open_world(t, &w, 1, 1, 0);
    e[0] = at(LAMP, 0, 6, 0);
    place(t, &w, e, 1, 0);
    shade(t, &w, origin, up, NULL, lit);
    e[1] = at(BALL, 0, 8, 0);
    place(t, &w, e, 2, 0);
    shade(t, &w, origin, up, NULL, far);
    e[2] = at(BALL, 0, 3, 0);
    place(t, &w, e, 3, 0);
    shade(t, &w, origin, up, NULL, both);
    e[1] = e[2];
    place(t, &w, e, 2, 0);
    shade(t, &w, origin, up, NULL, near);
    CONFORM("T78", "light before a far ball by light alone, harmonics", 1, far[0] / lit[0], 0);
    CONFORM("T78", "light between two balls by behind the near one, harmonics", 1, both[0] / near[0], 0);
    assert_true(lit[0] > 0.01f && near[0] < 0.85f * lit[0]);
    close_world(t, &w);
}

/* Points of a ball that glows under a lamp: those of one that does not, and of the CPU's; others see it glow. */
static void a_glowing_ball_lights_not_itself(void **state)
{
    GL_TEST(t, state)
    sfield_entity e[3];
    sfield_points set;
    float p[3 * SIZE], beside[3 * SIZE], facing[3 * SIZE], rgb[3 * SIZE], glowing[4 * SIZE], dull[4 * SIZE],
        near[4 * SIZE];
    double worst = 0, most = 0;
    uint64_t seed = 8;
    world w;
    int i, k;
    open_world(t, &w, SIZE, 1, 0);
    for (i = 0; i < SIZE; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (k = 0; k < 3; k++) {
            p[3 * i + k] = (float)d[k];
            beside[3 * i + k] = 2.5f * (float)d[k];
            facing[3 * i + k] = -(float)d[k];
        }
    }
    e[0] = at(SOUP, -3, 0, 0);
    e[1] = at(BALL, 0, 0, 0);
    e[2] = at(LAMP, 1, 5, 2);
    place(t, &w, e, 3, 0);
    shade_on(t, &w, 2, p, p, NULL, dull);
    e[1].source = field[LAMP];
    for (k = 0; k < 3; k++) e[1].tint[k] = 420;
    place(t, &w, e, 3, 0);
    shade_on(t, &w, 2, p, p, NULL, glowing);
    shade(t, &w, beside, facing, NULL, near);
    memset(&set, 0, sizeof set);
    set.count = SIZE;
    set.positions = set.normals = p;
    set.entity = 2;
    set.rgb = rgb;
    assert_int_equal(sfield_shade(w.scene, &set, 1, NULL), SFIELD_OK);
    assert_memory_equal(glowing, dull, sizeof dull);
    for (i = 0; i < SIZE; i++) {
        for (k = 0; k < 3; k++) worst = fmax(worst, fabs((double)glowing[4 * i + k] - (double)rgb[3 * i + k]));
        most = fmax(most, (double)rgb[3 * i]);
        assert_true(near[4 * i] > 20);
    }
    print_message("points of a glowing ball: GL off the CPU by %.1e of %.1e\n", worst, most);
    assert_true(most > 0.02 && worst < 1e-5);
    close_world(t, &w);
}

/* out = m a, of points where the last column counts. */
static void turn_by(const float *m, const float *a, float *out)
{
    int k;
    float b[3];
    for (k = 0; k < 3; k++) b[k] = m[k] * a[0] + m[4 + k] * a[1] + m[8 + k] * a[2];
    memcpy(out, b, sizeof b);
}

static void t76_turning_everything_changes_nothing(void **state)
{
    GL_TEST(t, state)
    const float m[16] = { 0.36f, 0.48f, -0.8f, 0, -0.8f, 0.6f, 0, 0, 0.48f, 0.64f, 0.6f, 0, 0, 0, 0, 1 };
    sfield_entity e[3], r[3];
    float p[3 * SIZE], n[3 * SIZE], q[3 * SIZE], o[3 * SIZE], before[4 * SIZE], after[4 * SIZE];
    double worst = 0;
    uint64_t seed = 3;
    world w;
    int i, k;
    e[0] = at(SOUP, 1, 3, 0);
    e[1] = at(SOUP, -2, 1, 1);
    memcpy(e[1].transform, m, 12 * sizeof *m);
    e[2] = at(LAMP, 2, 6, 1);
    for (i = 0; i < 3; i++) {
        r[i] = e[i];
        for (k = 0; k < 4; k++) turn_by(m, e[i].transform + 4 * k, r[i].transform + 4 * k);
    }
    for (i = 0; i < SIZE; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (k = 0; k < 3; k++) {
            n[3 * i + k] = (float)d[k];
            p[3 * i + k] = rnd_in(&seed, -0.5, 0.5);
        }
        turn_by(m, p + 3 * i, q + 3 * i);
        turn_by(m, n + 3 * i, o + 3 * i);
    }
    open_world(t, &w, SIZE, 1, 0);
    place(t, &w, e, 3, 1);
    shade(t, &w, p, n, NULL, before);
    place(t, &w, r, 3, 1);
    shade(t, &w, q, o, NULL, after);
    for (i = 0; i < 4 * SIZE; i++)
        if (i % 4 < 3) worst = fmax(worst, fabs((double)before[i] - (double)after[i]));
    CONFORM_MAX("T76", "all turned, shading differs, harmonics", 1e-4, worst);
    close_world(t, &w);
}

/* ---- drawn ---- */

/* A square in y = 0; its vertices also hold half the cosine's coefficients, as if its self-visibility were recorded. */
static uint32_t make_square(glbk_context *gl, uint32_t *buffer)
{
    static const int32_t sizes[6] = { 3, 3, 4, 4, 4, 4 };
    const double up[3] = { 0, 1, 0 };
    float v[4][22], factor[8];
    double y[16];
    uint32_t name, i, k, l;
    size_t from = 0;
    sfield_sh_basis(4, up, y);
    sfield_sh_cosine(4, factor);
    memset(v, 0, sizeof v);
    for (i = 0; i < 4; i++) {
        v[i][0] = i & 1 ? 2.0f : -2.0f;
        v[i][2] = i & 2 ? 2.0f : -2.0f;
        v[i][4] = 1;
        for (l = 0, k = 0; l < 4; l++)
            for (; k < (l + 1) * (l + 1); k++) v[i][6 + k] = 0.5f * (float)y[k] * factor[l];
    }
    gl->gl.GenVertexArrays(1, &name);
    gl->gl.GenBuffers(1, buffer);
    gl->gl.BindVertexArray(name);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, *buffer);
    gl->gl.BufferData(GLBK_GL_ARRAY_BUFFER, sizeof v, v, GLBK_GL_STATIC_DRAW);
    for (i = 0; i < 6; i++) {
        const uint32_t at = i < 2 ? i : i + 3;                          /* 0, 1; 5 to 8 */
        gl->gl.EnableVertexAttribArray(at);
        gl->gl.VertexAttribPointer(at, sizes[i], GLBK_GL_FLOAT, 0, sizeof v[0], (const void *)from);
        from += 4 * (size_t)sizes[i];
    }
    gl->gl.BindVertexArray(0);
    return name;
}

/* A floor, and a quarter of its size a table above it, seen from above: every pixel as shadowfield.h shades its point,
   half of it where self-visibility was drawn: of one of the two, which is seen there alone. */
static void drawn(gl_test *t, uint32_t recorded)
{
    static float positions[SIZE * SIZE][3], normals[SIZE * SIZE][3], rgb[SIZE * SIZE][3], light[SIZE * SIZE][4];
    static const float eye[3] = { 0, 9, 0 };
    glbk_surface surface[2];
    float clip[16];
    sfield_entity e[3];
    sfield_points set;
    double square = 0, size = 0;
    float low = 1e30f, high = 0;
    uint32_t buffer, vertices, object, i, k;
    world w;
    open_world(t, &w, SIZE, SIZE, 0);
    e[0] = at(BALL, 0.3f, 2, 0.2f);
    e[1] = at(SOUP, -1.2f, 1.4f, -0.8f);
    e[2] = at(LAMP, 1.5f, 5, -1);
    place(t, &w, e, 3, 1);
    memset(surface, 0, sizeof surface);
    memset(clip, 0, sizeof clip);
    clip[0] = clip[9] = 0.5f;                   /* x and z of the world are x and y of the picture, from above */
    clip[6] = -0.1f;
    clip[15] = 1;
    for (object = 0; object < 2; object++) {
        for (k = 0; k < 3; k++) surface[object].transform[5 * k] = object ? 0.5f : 1;
        surface[object].transform[13] = object ? 0.4f : 0;
        surface[object].transform[15] = 1;
    }
    vertices = make_square(&t->gl, &buffer);
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &w.gbuffer, clip, eye));
    t->gl.gl.BindVertexArray(vertices);
    for (object = 2; object-- > 0;) {           /* the table first: depth decides */
        assert_glbk(t, glbk_gbuffer_object(&t->gl, &w.gbuffer, &surface[object]));
        t->gl.gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
    }
    assert_glbk(t, glbk_sfield_self_begin(&t->gl, &w.renderer, &w.gbuffer));
    t->gl.gl.BindVertexArray(vertices);
    assert_glbk(t, glbk_sfield_self_object(&t->gl, &w.renderer, surface[recorded].transform));
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
    assert_glbk(t, glbk_sfield_shade(&t->gl, &w.renderer, &w.gbuffer, &w.gl, NULL, 0));
    assert_glbk(t, glbk_sfield_read(&t->gl, &w.renderer, light[0], NULL));
    memset(&set, 0, sizeof set);
    for (i = 0; i < SIZE * SIZE; i++) {
        positions[i][0] = ((float)(i % SIZE) + 0.5f) * 4 / SIZE - 2;
        positions[i][2] = ((float)(i / SIZE) + 0.5f) * 4 / SIZE - 2;
        positions[i][1] = fabsf(positions[i][0]) < 1 && fabsf(positions[i][2]) < 1 ? 0.4f : 0;
        normals[i][1] = 1;
    }
    set.entity = 0;
    set.count = 1;
    for (i = 0; i < SIZE * SIZE; i++) {         /* one by one, so that C orders occluders for each alone */
        set.positions = positions[i];
        set.normals = normals[i];
        set.rgb = rgb[i];
        assert_int_equal(sfield_shade(w.scene, &set, 1, NULL), SFIELD_OK);
        for (k = 0; k < 3; k++) {
            const double half = (positions[i][1] > 0) == (recorded == 1) ? 0.5 : 1;
            double off = (double)light[i][k] - half * (double)rgb[i][k];
            square += off * off;
            size += (double)rgb[i][k] * (double)rgb[i][k];
        }
        low = rgb[i][2] < low ? rgb[i][2] : low;
        high = rgb[i][2] > high ? rgb[i][2] : high;
    }
    printf("drawn: relative difference %.1e; blue %.3f to %.3f\n", sqrt(square / size), (double)low, (double)high);
    assert_true(high > 1.3f * low);             /* shadows are there to be compared */
    assert_true(sqrt(square / size) < 1e-4);    /* 16 bits of self-visibility */
    t->gl.gl.DeleteVertexArrays(1, &vertices);
    t->gl.gl.DeleteBuffers(1, &buffer);
    close_world(t, &w);
}

static void what_is_drawn_into_the_gbuffer_is_shaded_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    drawn(t, 0);        /* the floor, which the table hides in part */
    drawn(t, 1);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        SFIELD_ROWS(gl_unit_test), gl_unit_test(t72_a_sphere_hides_its_solid_angle),
        gl_unit_test(only_what_lies_before_a_light_hides_it), gl_unit_test(a_glowing_ball_lights_not_itself),
        gl_unit_test(t76_turning_everything_changes_nothing),
        gl_unit_test(what_is_drawn_into_the_gbuffer_is_shaded_as_on_the_cpu)
    };
    int result;
    (void)count;
    if (gl_run_ways(values, GL_CORE33, &result)) return result;
    gl_name_tests(tests, sizeof tests / sizeof tests[0]);
    return cmocka_run_group_tests(tests, make_fields, free_fields);
}
