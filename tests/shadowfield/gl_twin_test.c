/* gl_twin_test - the GLSL of sfield_*.glsl against its C twins in shadowfield.h: fields at random points with their
   edges, video light, rotations, products, kernels; then whole scenes, point by point. */
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

#include "gl_test.h"
#include "gl_state.h"
#include "util.h"

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { COUNT = 512, FIELDS = 6 };

static void test_desc(sfield_desc *d, uint32_t bands)
{
    memset(d, 0, sizeof *d);
    d->bands = bands;
    d->cube_side = 4;
    d->shell_count = 4;
    d->position_side = 3;
}

static void turned(float *m, uint64_t *seed, float scale)
{
    double a[3], b[3], c[3], l = 0;
    int k;
    rnd_direction(seed, a);
    rnd_direction(seed, b);
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
    for (k = 0; k < 3; k++) l += c[k] * c[k];
    for (k = 0; k < 3; k++) c[k] /= sqrt(l);
    b[0] = c[1] * a[2] - c[2] * a[1];
    b[1] = c[2] * a[0] - c[0] * a[2];
    b[2] = c[0] * a[1] - c[1] * a[0];
    memset(m, 0, 16 * sizeof *m);
    for (k = 0; k < 3; k++) {
        m[k] = scale * (float)a[k];
        m[4 + k] = scale * (float)b[k];
        m[8 + k] = scale * (float)c[k];
    }
    m[15] = 1;
}

/* ---- fields on both sides ---- */

typedef struct both {
    uint32_t               bands, coefs;
    sfield_algebra        *algebra;
    sfield_field          *field[FIELDS];        /* box, soup; lights: ball, soup, box, video ball */
    glbk_sfield_scene      world;
    glbk_sfield_scene_desc desc;
    float                 *brdf;                 /* NULL: no table of BRDFs is uploaded */
} both;

static int logarithms;       /* of all occlusion fields, scenes and renderers from now on */

static void build_fields(both *b, uint32_t bands)
{
    static float radiance[3 * 3 * 200];
    sfield_desc d;
    model box = model_box(1, 0.5, 0.7), soup = model_soup(60, 0.5, 3), ball = model_sphere(10, 5, 0.5);
    sfield_mesh of_box = mesh_of(&box), of_soup = mesh_of(&soup), of_ball = mesh_of(&ball);
    int i;
    memset(b, 0, sizeof *b);
    b->bands = bands;
    b->coefs = bands * bands;
    test_desc(&d, bands);
    for (i = 0; i < 3 * 3 * 200; i++) radiance[i] = (float)(1 + i % 7 + i / 300);
    assert_int_equal(sfield_algebra_create(bands, NULL, &b->algebra), SFIELD_OK);
    d.logarithm = logarithms;
    assert_int_equal(sfield_build(&d, &of_box, &b->field[0], NULL), SFIELD_OK);
    assert_int_equal(sfield_build(&d, &of_soup, &b->field[1], NULL), SFIELD_OK);
    d.logarithm = 0;
    assert_int_equal(sfield_build_emissive(&d, &of_ball, radiance, &b->field[2], NULL), SFIELD_OK);
    assert_int_equal(sfield_build_emissive(&d, &of_soup, radiance, &b->field[3], NULL), SFIELD_OK);
    d.spacing = SFIELD_SPACING_UNIFORM;
    assert_int_equal(sfield_build_emissive(&d, &of_box, radiance, &b->field[4], NULL), SFIELD_OK);
    d.frame_count = 3;
    d.frames_per_second = 10;
    d.loop = 1;
    assert_int_equal(sfield_build_emissive(&d, &of_ball, radiance, &b->field[5], NULL), SFIELD_OK);
    model_free(&box);
    model_free(&soup);
    model_free(&ball);
}

static void make_brdf(both *b)
{
    const size_t floats = sfield_sh_brdf(b->bands, NULL, NULL);
    assert_int_equal(floats, 24 * 48 * 6 * b->bands * (b->bands + 1) / 2);
    b->brdf = (float *)malloc(floats * sizeof(float));
    assert_non_null(b->brdf);
    assert_int_equal(sfield_sh_brdf(b->bands, NULL, b->brdf), floats);
}

static void upload(gl_test *t, both *b)
{
    b->desc.brdf = b->brdf;
    b->desc.algebra = b->algebra;
    b->desc.fields = (const sfield_field *const *)b->field;
    b->desc.field_count = FIELDS;
    b->desc.entity_capacity = 40;
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &b->desc, &b->world));
}

/* How a field is called in the table. */
static const glbk_sfield_field *find(const both *b, int which)
{
    size_t i;
    for (i = 0; i < b->world.field_count; i++)
        if (b->world.fields[i].field == b->field[which]) return &b->world.fields[i];
    fail_msg("field %d was not uploaded", which);
    return NULL;
}

static void free_both(gl_test *t, both *b)
{
    int i;
    glbk_sfield_scene_free(&t->gl, &b->world);
    for (i = 0; i < FIELDS; i++) sfield_free(b->field[i]);
    sfield_algebra_free(b->algebra);
    free(b->brdf);
    b->brdf = NULL;
}

/* ---- one function at a time ---- */

/* Pixel (i, j): four of the coefficients that the function makes of point i, from 4 j on. */
static const char twin_main[] =
    "uniform highp usampler2D mine;\n"
    "layout(location = 0) out glbk_color result;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    uvec4 in0 = texelFetch(mine, ivec2(at.x, 0), 0), in1 = texelFetch(mine, ivec2(at.x, 1), 0);\n"
    "    vec3 p = uintBitsToFloat(in0.xyz), d = uintBitsToFloat(in1.xyz);\n"
    "    float v[SFIELD_COEFS], a[SFIELD_COEFS], b[SFIELD_COEFS];\n"
    "    sfield_fetch(in0.w, sfield_locate(in0.w, p), in1.w, d.x * 0.5, 1.0, v);\n"
    "    sfield_basis(d, a);\n"
    "#if TWIN == 1\n"
    "    sfield_rotate(SFIELD_MOVING(sfield_at(0u) + 5u).z, false, v);\n"
    "#elif TWIN == 2\n"
    "    sfield_rotate(SFIELD_MOVING(sfield_at(0u) + 5u).z, true, v);\n"
    "#elif TWIN == 3\n"
    "    for (int k = 0; k < SFIELD_COEFS; k++) b[k] = v[k];\n"
    "    uvec2 terms = uvec2(glbk_sfield_contents.term_texel, glbk_sfield_contents.term_count);\n"
    "    sfield_product(terms, a, b, v);\n"
    "#elif TWIN == 4\n"
    "    sfield_cosine(d, v);\n"
    "#elif TWIN == 5\n"
    "    sfield_lobe(d, 1.0 + 40.0 * abs(p.x), v);\n"
    "#endif\n"
    "    vec4 four = vec4(0.0);\n"
    "    for (int k = 0; k < 4; k++) if (4 * at.y + k < SFIELD_COEFS) four[k] = v[4 * at.y + k];\n"
    "    result = glbk_pack(four);\n"
    "}\n";

static float asked[COUNT][8], given[COUNT * 64];

static void run_twin(gl_test *t, const both *b, int twin)
{
    static uint32_t words[2][COUNT][4];
    char defines[] = "SFIELD_BANDS=4 TWIN=0";
    uint32_t rows = (b->coefs + 3) / 4;
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, COUNT, rows, 0);
    glbk_texture_desc d;
    glbk_texture points;
    glbk_program program;
    glbk_source source;
    glbk_pass pass;
    int i;
    memset(&source, 0, sizeof source);
    memset(&d, 0, sizeof d);
    memset(&pass, 0, sizeof pass);
    defines[13] = (char)('0' + b->bands);
    defines[20] = (char)('0' + twin);
    source.fragment = twin_main;
    source.parts[0] = glbk_sfield_part();
    source.uses = "sfield_shade";
    source.defines = defines;
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
    for (i = 0; i < COUNT; i++) {
        memcpy(words[0][i], asked[i], 16);
        memcpy(words[1][i], asked[i] + 4, 16);
    }
    d.format = GLBK_FORMAT_RGBA32UI;
    d.width = COUNT;
    d.height = 2;
    d.data = words;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &points));
    pass.target = &canvas.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    glbk_sfield_bind(&t->gl, &b->world, NULL);
    t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(program.name, "mine"), 15);
    glbk_bind_texture(&t->gl, 15, &points);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, COUNT, rows, given));
    glbk_texture_free(&t->gl, &points);
    glbk_program_free(&t->gl, &program);
    gl_canvas_free(t, &canvas);
}

/* The same in C; v: bands^2. */
static void expect(const both *b, int twin, int which, const float *in, const sfield_rotation *r, float *v)
{
    sfield_info info;
    sfield_rotation back;
    double direction[3], y[64];
    float position[3], all[3 * 64], factor[8], basis[64];
    uint32_t k, l, channel;
    sfield_get_info(b->field[which], &info);
    memcpy(&channel, in + 7, 4);
    for (k = 0; k < 3; k++) {
        position[k] = info.center[k] + info.radius * in[k];
        direction[k] = (double)in[4 + k];
    }
    assert_int_equal(sfield_query(b->field[which], 1, position, 0.5f * in[4], all), SFIELD_OK);
    sfield_sh_basis(b->bands, direction, y);
    for (k = 0; k < b->coefs; k++) {
        v[k] = all[channel * b->coefs + k];
        if (info.kind == SFIELD_KIND_OCCLUSION) v[k] = (k ? 0 : (float)sqrt(4 * PI)) - v[k];
        basis[k] = (float)y[k];
    }
    sfield_sh_cosine(b->bands, factor);
    if (twin == 1) sfield_sh_rotate(r, 1, v, v, 1);
    if (twin == 3) sfield_sh_product(b->algebra, 1, basis, v, v, 1);
    if (twin == 2) {
        back = *r;                              /* the transpose of each block */
        for (l = 0, k = 0; l < b->bands; k += (2 * l + 1) * (2 * l + 1), l++) {
            uint32_t n = 2 * l + 1, i, j;
            for (i = 0; i < n; i++)
                for (j = 0; j < n; j++) back.block[k + i * n + j] = r->block[k + j * n + i];
        }
        sfield_sh_rotate(&back, 1, v, v, 1);
    }
    if (twin >= 4) {                            /* kernels: A_l, or moments of the lobe by their sum */
        double n = 1 + 40 * fabs((double)in[0]), p[2];
        p[0] = (n + 2) / (n + 1);
        p[1] = 1;
        for (l = 0; l < b->bands; l++) {
            double moment = l == 0 ? p[0] : p[1];
            for (k = l * l; k < (l + 1) * (l + 1); k++) v[k] = basis[k] * (twin == 4 ? factor[l] : (float)moment);
            if (l) {
                double next = p[0] * (n - l + 1) / (n + l + 2);
                p[0] = p[1];
                p[1] = next;
            }
        }
    }
}

static void ask(const both *b, int which, uint64_t *seed)
{
    const glbk_sfield_field *field = find(b, which);
    int i, k;
    for (i = 0; i < COUNT; i++) {
        double d[3], r = exp(-2 + 5 * rnd(seed));
        uint32_t channel = field->source ? rnd_below(seed, 3) : 0;
        rnd_direction(seed, d);
        for (k = 0; k < 3; k++) asked[i][k] = (float)(r * d[k]);
        if (i % 8 == 0) asked[i][1] = asked[i][0];              /* on edges, corners, axes, at the centre */
        if (i % 16 == 0) asked[i][2] = -asked[i][0];
        if (i % 32 == 8) asked[i][1] = asked[i][0] = 0;
        if (i == 5) asked[i][0] = asked[i][1] = asked[i][2] = 0;
        rnd_direction(seed, d);
        for (k = 0; k < 3; k++) asked[i][4 + k] = (float)d[k];
        memcpy(&asked[i][3], &field->start, 4);
        memcpy(&asked[i][7], &channel, 4);
    }
}

static void functions_in_glsl_equal_their_twins(void **state)
{
    GL_TEST(t, state)
    static const uint32_t bands[] = { 4, 1, 6 };
    static both b;
    uint64_t seed = 4;
    size_t n;
    for (n = 0; n < 3; n++) {
        sfield_entity e;
        sfield_rotation r;
        double worst[6] = { 0, 0, 0, 0, 0, 0 }, most = 0;
        int twin, which, i;
        uint32_t k;
        build_fields(&b, bands[n]);
        upload(t, &b);
        memset(&e, 0, sizeof e);
        turned(e.transform, &seed, 1.5f);
        assert_int_equal(sfield_sh_rotation(b.algebra, e.transform, &r), SFIELD_OK);
        assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &b.world, &e, 1));
        for (twin = 0; twin < 6; twin++)
            for (which = 0; which < (n ? 1 : twin ? 2 : FIELDS); which++) {
                if (bands[n] == 1 && (twin == 1 || twin == 2)) continue;        /* nothing turns */
                ask(&b, which, &seed);
                run_twin(t, &b, twin);
                for (i = 0; i < COUNT; i++) {
                    float v[64];
                    double largest = 0.05;
                    expect(&b, twin, which, asked[i], &r, v);
                    for (k = 0; k < b.coefs; k++) largest = fmax(largest, fabs((double)v[k]));
                    for (k = 0; k < b.coefs; k++) {
                        double off =
                            fabs((double)v[k] - (double)given[(k / 4 * COUNT + (uint32_t)i) * 4 + k % 4]) / largest;
                        worst[twin] = off < worst[twin] ? worst[twin] : off;
                        most = fmax(most, fabs((double)v[k]));
                    }
                }
            }
        printf("%u bands: worst of query %.1e, rotate %.1e, back %.1e, product %.1e, cosine %.1e, lobe %.1e; largest "
               "%.2f\n",
               bands[n], worst[0], worst[1], worst[2], worst[3], worst[4], worst[5], most);
        assert_true(most > 1);
        for (twin = 0; twin < 6; twin++) assert_true(worst[twin] < 2e-5);
        free_both(t, &b);
    }
}

/* ---- the product as it is written into a program ---- */

/* Pixel (i, j): four coefficients of the product of point i, from 4 j on; rows of `mine`: those of a, then those
   of b. */
static const char product_main[] =
    "uniform highp usampler2D mine;\n"
    "layout(location = 0) out glbk_color result;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    float a[SFIELD_COEFS], b[SFIELD_COEFS], v[SFIELD_COEFS];\n"
    "    for (int k = 0; k < SFIELD_COEFS; k++) {\n"
    "        a[k] = uintBitsToFloat(texelFetch(mine, ivec2(at.x, k / 4), 0)[k % 4]);\n"
    "        b[k] = uintBitsToFloat(texelFetch(mine, ivec2(at.x, (SFIELD_COEFS + 3) / 4 + k / 4), 0)[k % 4]);\n"
    "    }\n"
    "    sfield_product(uvec2(0u), a, b, v);\n"
    "    vec4 four = vec4(0.0);\n"
    "    for (int k = 0; k < 4; k++) if (4 * at.y + k < SFIELD_COEFS) four[k] = v[4 * at.y + k];\n"
    "    result = glbk_pack(four);\n"
    "}\n";

/* All of the text at any size; what is cut ends with a 0. Returns text and product_main behind it. */
static char *write_product(const sfield_algebra *algebra)
{
    size_t size = glbk_sfield_write_product(algebra, NULL, 0), i;
    char *text = (char *)malloc(size + sizeof product_main), *cut = (char *)malloc(size + 1);
    assert_true(text && cut && size > 1);
    assert_int_equal(glbk_sfield_write_product(algebra, text, size + sizeof product_main), size);
    assert_int_equal(strlen(text), size - 1);
    for (i = 1; i <= size; i += 1 + size / 9) {
        memset(cut, '#', size + 1);
        assert_int_equal(glbk_sfield_write_product(algebra, cut, i), size);
        assert_int_equal(strlen(cut), i - 1);
        assert_memory_equal(cut, text, i - 1);
        assert_int_equal(cut[i], '#');
    }
    free(cut);
    memcpy(text + size - 1, product_main, sizeof product_main);
    return text;
}

static void written_products_agree(void **state)
{
    GL_TEST(t, state)
    static float in[2][COUNT][16], images[8][COUNT][4], v[COUNT][16];
    uint32_t bands, k;
    uint64_t seed = 8;
    for (bands = 1; bands <= 4; bands++) {
        char defines[] = "SFIELD_BANDS=4 SFIELD_UNROLLED";
        uint32_t coefs = bands * bands, rows = (coefs + 3) / 4;
        sfield_algebra *algebra;
        glbk_texture_desc d;
        glbk_texture mine;
        glbk_program program;
        glbk_source source;
        glbk_pass pass;
        gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, COUNT, rows, 0);
        double worst = 0;
        char *text;
        int i;
        memset(&source, 0, sizeof source);
        memset(&d, 0, sizeof d);
        memset(&pass, 0, sizeof pass);
        assert_int_equal(sfield_algebra_create(bands, NULL, &algebra), SFIELD_OK);
        for (i = 0; i < COUNT; i++)
            for (k = 0; k < coefs; k++) {
                images[k / 4][i][k % 4] = in[0][i][k] = rnd_in(&seed, -1, 1);
                images[rows + k / 4][i][k % 4] = in[1][i][k] = rnd_in(&seed, -1, 1);
            }
        for (i = 0; i < COUNT; i++) sfield_sh_product(algebra, 1, in[0][i], in[1][i], v[i], 1);
        defines[13] = (char)('0' + bands);
        source.fragment = text = write_product(algebra);
        source.parts[0] = glbk_sfield_part();
        source.uses = "sfield_access sfield_field";
        source.defines = defines;
        assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
        free(text);
        d.format = GLBK_FORMAT_RGBA32UI;
        d.width = COUNT;
        d.height = 2 * rows;
        d.data = images;
        assert_glbk(t, glbk_texture_create(&t->gl, &d, &mine));
        pass.target = &canvas.target;
        assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
        t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(program.name, "mine"), 15);
        glbk_bind_texture(&t->gl, 15, &mine);
        glbk_draw_screen(&t->gl);
        assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, COUNT, rows, given));
        for (i = 0; i < COUNT; i++)
            for (k = 0; k < coefs; k++)
                worst = fmax(worst, fabs((double)v[i][k] - (double)given[(k / 4 * COUNT + (uint32_t)i) * 4 + k % 4]));
        printf("product written for %u bands: worst %.1e\n", bands, worst);
        assert_true(worst < 1e-6);              /* measured 2.4e-7: sums in another order */
        glbk_texture_free(&t->gl, &mine);
        glbk_program_free(&t->gl, &program);
        gl_canvas_free(t, &canvas);
        sfield_algebra_free(algebra);
    }
}

/* ---- whole scenes ---- */

enum { POINTS = 96, ENTITIES = 9 };

typedef struct stage {
    sfield_scene      *scene;
    sfield_entity      entity[ENTITIES];
    sfield_field      *self;
    float              positions[POINTS][3], normals[POINTS][3], rgb[POINTS][3], gloss[POINTS][3], open[POINTS];
    float              light[POINTS][4], shine[POINTS][4], graze[POINTS][4];
    float              material[POINTS][5], grazing[POINTS][3];
} stage;

/* Boxes and soups, one with a light of its own; lights of four kinds; sky and sun. */
static void make_stage(stage *s, const both *b, uint64_t *seed, int sky)
{
    sfield_scene_desc d;
    float map[4 * 2 * 3];
    const float sun[3] = { 0.6f, 0.8f, 0 }, white[3] = { 1, 1, 0.5f };
    int i;
    memset(s, 0, sizeof *s);
    memset(&d, 0, sizeof d);
    d.bands = b->bands;
    d.product = logarithms ? SFIELD_PRODUCT_EXP : SFIELD_PRODUCT_TRIPLE;
    assert_int_equal(sfield_scene_create(&d, &s->scene), SFIELD_OK);
    for (i = 0; i < ENTITIES; i++) {
        sfield_entity *e = &s->entity[i];
        *e = upright;
        if (i % 3) turned(e->transform, seed, 0.5f + (float)rnd(seed));
        e->transform[12] = i == 0 ? -1 : rnd_in(seed, 0, 3);      /* in front of the face of box 0 that is shaded */
        e->transform[13] = rnd_in(seed, -1, 1.5);
        e->transform[14] = rnd_in(seed, -1.5, 1.5);
        e->time = 0.17f;
        e->tint[1] = 0.8f;
        if (i < 5) e->occlusion = b->field[i & 1];
        if (i >= 4 && i < 8) e->source = b->field[i - 2];     /* 4 hides and shines */
    }
    assert_int_equal(sfield_scene_entities(s->scene, s->entity, ENTITIES), SFIELD_OK);
    for (i = 0; i < 24; i++) map[i] = (float)rnd(seed);
    if (sky) {
        assert_int_equal(sfield_scene_environment(s->scene, map, 4, 2, s->entity[1].transform), SFIELD_OK);
        assert_int_equal(sfield_scene_sun(s->scene, sun, white), SFIELD_OK);
    }
}

/* Points of box 0, with self-visibility, then in space; each a set of its own, so that C orders occluders for
   it alone. exponent: of a lobe, 0 = none, -1 = materials, which have no ambient. */
static void shade_in_c(stage *s, const both *b, uint64_t *seed, const float *eye, float exponent, int on_entity)
{
    static float views[POINTS][3], local[POINTS][3], facing[POINTS][3];
    static sfield_points sets[POINTS];
    model box = model_box(1, 0.5, 0.7);
    sfield_mesh mesh = mesh_of(&box);
    sfield_desc d;
    int i, k;
    test_desc(&d, b->bands);
    memset(sets, 0, sizeof sets);
    for (i = 0; i < POINTS; i++) {
        double n[3];
        const float *m = s->entity[0].transform;
        float length = 0;
        rnd_direction(seed, n);
        for (k = 0; k < 3; k++) {
            local[i][k] = on_entity ? (k == 0 ? 1.0f : 0.4f * (float)n[k]) : rnd_in(seed, -2, 3);
            facing[i][k] = on_entity ? (k == 0) : (float)n[k];
        }
        for (k = 0; k < 3; k++) {
            s->positions[i][k] = on_entity
                                     ? m[k] * local[i][0] + m[4 + k] * local[i][1] + m[8 + k] * local[i][2] + m[12 + k]
                                     : local[i][k];
            s->normals[i][k] = on_entity ? m[k] : facing[i][k];
            views[i][k] = eye[k] - s->positions[i][k];
            length += views[i][k] * views[i][k];
        }
        for (k = 0; k < 3; k++) views[i][k] /= sqrtf(length);
        sets[i].count = 1;
        sets[i].positions = local[i];
        sets[i].normals = facing[i];
        sets[i].entity = on_entity ? 1 : 0;
        sets[i].to_eye = views[i];
        sets[i].exponents = exponent < 0 ? NULL : &exponent;
        sets[i].materials = exponent < 0 ? s->material[i] : NULL;
        sets[i].rgb = s->rgb[i];
        sets[i].gloss = exponent > 0 || exponent < 0 ? s->gloss[i] : NULL;
        sets[i].grazing = exponent < 0 ? s->grazing[i] : NULL;
        sets[i].ambient = exponent < 0 ? NULL : &s->open[i];
    }
    if (on_entity) {
        assert_int_equal(sfield_build_self(&d, &mesh, AT(local[0], facing[0], POINTS),
                                           0.01f, &s->self, NULL), SFIELD_OK);
        for (i = 0; i < POINTS; i++) {          /* one by one, as every set needs a field of its size */
            sfield_field *one;
            assert_int_equal(sfield_build_self(&d, &mesh, AT(local[i], facing[i], 1),
                                               0.01f, &one, NULL), SFIELD_OK);
            sets[i].self = one;
        }
    }
    assert_int_equal(sfield_shade(s->scene, sets, POINTS, NULL), SFIELD_OK);
    for (i = 0; i < POINTS; i++) sfield_free((sfield_field *)(size_t)sets[i].self);
    model_free(&box);
}

static void shade_in_gl(gl_test *t, stage *s, both *b, const float *eye, float exponent, int on_entity, int sky)
{
    static float self[POINTS][64];
    const float *own[POINTS] = { NULL };
    glbk_pixel pixels[POINTS];
    glbk_sfield_renderer r;
    const int metal = exponent < 0;
    const glbk_sfield_renderer_desc d = { POINTS / 4, 4, b->algebra, exponent > 0, on_entity, 0, on_entity, metal,
                                          metal, logarithms };
    glbk_gbuffer_desc of;
    glbk_gbuffer g;
    float coefs[3 * 64];
    int i;
    memset(pixels, 0, sizeof pixels);
    memset(&of, 0, sizeof of);
    of.width = d.width;
    of.height = d.height;
    assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &b->world, s->entity, ENTITIES));
    assert_int_equal(sfield_scene_sky(s->scene, coefs), SFIELD_OK);
    assert_glbk(t, glbk_sfield_scene_sky(&t->gl, &b->world, sky ? coefs : NULL));
    for (i = 0; i < POINTS; i++) {
        memcpy(pixels[i].position, s->positions[i], 12);
        memcpy(pixels[i].normal, s->normals[i], 12);
        pixels[i].entity = on_entity ? 1 : 0;
        pixels[i].material.kind = exponent > 0 ? LSAMP_MATERIAL_PHONG : LSAMP_MATERIAL_LAMBERT;
        pixels[i].material.exponent = exponent > 0 ? exponent : 0;
        if (metal) {
            pixels[i].material.kind = LSAMP_MATERIAL_METAL_ROUGH;
            memcpy(pixels[i].material.diffuse, s->material[i], 12);
            pixels[i].material.metallic = s->material[i][3];
            pixels[i].material.roughness = s->material[i][4];
        }
        if (on_entity) {
            assert_int_equal(sfield_self(s->self, (size_t)i, 1, self[i]), SFIELD_OK);
            own[i] = self[i];
        }
    }
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &of, &g));
    assert_glbk(t, glbk_sfield_renderer_create(&t->gl, &d, &r));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &g, 0, 4, pixels));
    for (i = 0; i < 4 && on_entity; i++)
        assert_glbk(t, glbk_sfield_self_upload(&t->gl, &r, (uint32_t)i, 1, own + i * (POINTS / 4)));
    assert_glbk(t, glbk_sfield_shade(&t->gl, &r, &g, &b->world, eye, 1));
    assert_glbk(t, glbk_sfield_read(&t->gl, &r, s->light[0], exponent > 0 || metal ? s->shine[0] : NULL));
    if (metal) assert_glbk(t, glbk_target_read(&t->gl, &r.target, 2, 0, 0, POINTS / 4, 4, s->graze[0]));
    glbk_sfield_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &g);
}

static void scenes_are_shaded_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    static both b;
    static stage s;
    const float eye[3] = { 1, 5, 2 };
    uint64_t seed = 12;
    int way;
    for (way = 0; way < 4; way++) {             /* on an object or not, with sky or not, shining or not, bands */
        int on_entity = way & 1, sky = way < 3, i, k;
        float exponent = way == 1 || way == 2 ? 12.0f : 0.0f;
        double sum = 0, size = 0, worst = 0, open = 0, dark = 0;
        build_fields(&b, way == 2 ? 3 : 4);
        upload(t, &b);
        make_stage(&s, &b, &seed, sky);
        shade_in_c(&s, &b, &seed, eye, exponent, on_entity);
        shade_in_gl(t, &s, &b, eye, exponent, on_entity, sky);
        for (i = 0; i < POINTS; i++) {
            for (k = 0; k < 3; k++) {
                double off = (double)s.light[i][k] - (double)s.rgb[i][k];
                sum += off * off;
                size += (double)s.rgb[i][k] * (double)s.rgb[i][k];
                worst = fmax(worst, fabs(off));
                if (exponent > 0) {
                    off = (double)s.shine[i][k] - (double)s.gloss[i][k];
                    sum += off * off;
                    worst = fmax(worst, fabs(off));
                }
            }
            open = fmax(open, fabs((double)s.light[i][3] - (double)s.open[i]));
            dark += s.open[i] < 0.8f;
        }
        printf("scene %d: relative difference %.1e, worst %.1e, open %.1e; %.0f of %d points in some shadow\n", way,
               sqrt(sum / size), worst, open, dark, POINTS);
        assert_true(dark > POINTS / 8 && size > 1);        /* or this compares nothing */
        assert_true(sqrt(sum / size) < 5e-4 && open < 1e-3);
        sfield_scene_free(s.scene);
        sfield_free(s.self);
        free_both(t, &b);
    }
}

/* Adds up how far one result is off another, and its size. */
static void compare_results(const float (*gl)[4], const float (*cpu)[3], double *sum, double *size)
{
    for (int i = 0; i < POINTS; i++)
        for (int k = 0; k < 3; k++) {
            const double off = (double)gl[i][k] - (double)cpu[i][k];
            *sum += off * off;
            *size += (double)cpu[i][k] * (double)cpu[i][k];
        }
}

/* What is diffuse, specular and grazing, each by itself, of a scene of so many bands with materials or without. */
static void compare_scene(gl_test *t, uint32_t bands, int materials, int on_entity, uint64_t seed)
{
    static both b;
    static stage s;
    const float eye[3] = { 1, 5, 2 };
    const int sky = !on_entity, results = materials ? 3 : 1;
    double sum[3] = { 0, 0, 0 }, size[3] = { 0, 0, 0 }, dark = 0;
    build_fields(&b, bands);
    if (materials) make_brdf(&b);
    upload(t, &b);
    make_stage(&s, &b, &seed, sky);
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < 5; k++) s.material[i][k] = (float)rnd(&seed);
        if (i % 3 == 0) s.material[i][3] = 0;
        if (i % 7 == 0) s.material[i][4] = i % 2 ? 1.0f : 0.0f;
    }
    shade_in_c(&s, &b, &seed, eye, materials ? -1 : 0, on_entity);
    shade_in_gl(t, &s, &b, eye, materials ? -1 : 0, on_entity, sky);
    compare_results((const float (*)[4])s.light, (const float (*)[3])s.rgb, &sum[0], &size[0]);
    compare_results((const float (*)[4])s.shine, (const float (*)[3])s.gloss, &sum[1], &size[1]);
    compare_results((const float (*)[4])s.graze, (const float (*)[3])s.grazing, &sum[2], &size[2]);
    for (int i = 0; i < POINTS; i++) dark += s.light[i][3] < 0.8f;
    for (int k = 0; k < results; k++)
        printf("%u bands, materials %d, logarithms %d: off by %.1e of %.2g\n", bands, materials, logarithms,
               sqrt(sum[k] / size[k]), sqrt(size[k]));
    assert_true(dark > POINTS / 8 && size[0] > 0.1);
    for (int k = 0; k < results; k++) assert_true(size[k] > 1e-4 && sqrt(sum[k] / size[k]) < 5e-4);
    sfield_scene_free(s.scene);
    sfield_free(s.self);
    free_both(t, &b);
}

/* In space under a sky, and on an object, of few bands since drivers take long for these programs. */
static void materials_are_shaded_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    compare_scene(t, 4, 1, 0, 31);
    compare_scene(t, 2, 1, 1, 32);
}

static void logarithms_are_added_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    logarithms = 1;
    compare_scene(t, 2, 0, 0, 41);
    compare_scene(t, 2, 1, 1, 32);
    logarithms = 0;
}

/* ---- failures put into GL's mouth, and a state turned over ---- */

static uint32_t (GLBK_CALL *real_error)(void);
static int error_at, error_calls, memory_left;

static uint32_t GLBK_CALL lying_error(void)
{
    uint32_t error = real_error();
    return ++error_calls == error_at ? 0x0505 : error;       /* GL_OUT_OF_MEMORY */
}

static void *little_memory(size_t size, void *user)
{
    (void)user;
    return memory_left-- > 0 ? malloc(size) : NULL;
}

static void release(void *memory, void *user)
{
    (void)user;
    free(memory);
}

static glbk_result make_all(gl_test *t, const both *b, glbk_sfield_scene *w, glbk_gbuffer *g,
                            glbk_sfield_renderer *r)
{
    glbk_sfield_renderer_desc d = { 4, 4, b->algebra, 1, 1, 0, 0, 1, 1, 0 };
    const float *own[16] = { NULL };
    glbk_gbuffer_desc of;
    glbk_pixel pixels[4];
    static const float sky[12] = { 3, 1, 0, 0, 2, 0, 1, 0, 1, 0, 0, 1 };
    sfield_entity e;
    glbk_result result = GLBK_OK;
    uint32_t row;
    memset(g, 0, sizeof *g);
    memset(&of, 0, sizeof of);
    of.width = of.height = 4;
    memset(r, 0, sizeof *r);
    memset(pixels, 0, sizeof pixels);
    memset(&e, 0, sizeof e);
    e.transform[0] = e.transform[5] = e.transform[10] = e.transform[15] = 1;
    pixels[0].normal[1] = 1;
    pixels[0].position[1] = -1.5f;
    GL_THEN_SAME(t, result, glbk_sfield_scene_create(&t->gl, &b->desc, w));
    e.occlusion = b->field[0];
    GL_THEN_SAME(t, result, glbk_sfield_scene_entities(&t->gl, w, &e, 1));
    GL_THEN_SAME(t, result, glbk_sfield_scene_sky(&t->gl, w, sky));
    GL_THEN_SAME(t, result, glbk_gbuffer_create(&t->gl, &of, g));
    GL_THEN_SAME(t, result, glbk_sfield_renderer_create(&t->gl, &d, r));
    for (row = 0; row < 4; row++) GL_THEN_SAME(t, result, glbk_gbuffer_upload(&t->gl, g, row, 1, pixels));
    GL_THEN_SAME(t, result, glbk_sfield_self_upload(&t->gl, r, 0, 4, own));
    return result;
}

static void failures_leave_nothing(void **state)
{
    GL_TEST(t, state)
    static both b;
    glbk_sfield_scene w;
    glbk_gbuffer g;
    glbk_sfield_renderer r;
    glbk_result result;
    int kind, done = 0;
    t->gl.check = 1;
    build_fields(&b, 2);
    make_brdf(&b);
    upload(t, &b);
    real_error = t->gl.gl.GetError;
    for (kind = 0; kind < 2; kind++)
        for (error_at = 1, done = 0; !done; error_at++) {
            error_calls = 0;
            memory_left = error_at - 1;
            if (kind) {
                t->gl.system.allocator.alloc_fn = little_memory;
                t->gl.system.allocator.free_fn = release;
            } else t->gl.gl.GetError = lying_error;
            result = make_all(t, &b, &w, &g, &r);
            t->gl.gl.GetError = real_error;
            memset(&t->gl.system.allocator, 0, sizeof t->gl.system.allocator);
            done = result == GLBK_OK;
            if (!done && kind) assert_int_equal(result, GLBK_ERR_ALLOC);
            if (!done && !kind) assert_true(result == GLBK_ERR_PENDING || result == GLBK_ERR_GL_MEMORY);
            if (!done && !r.light.name) assert_int_equal(r.shade.name + r.self.name + r.frame.name, 0);
            glbk_sfield_renderer_free(&t->gl, &r);
            glbk_gbuffer_free(&t->gl, &g);
            glbk_sfield_scene_free(&t->gl, &w);
            assert_int_equal(w.table.name + r.light.name + r.target.name, 0);
            assert_true(error_at < 300);
        }
    free_both(t, &b);
}

/* A triangle over all of the picture, of positions and normals. */
static uint32_t make_triangle(const glbk_functions *gl, uint32_t *buffer)
{
    static const float corner[3][6] = { { -1, -1, 0, 0, 0, 1 }, { 3, -1, 0, 0, 0, 1 }, { -1, 3, 0, 0, 0, 1 } };
    uint32_t vertices, i;
    gl->GenVertexArrays(1, &vertices);
    gl->GenBuffers(1, buffer);
    gl->BindVertexArray(vertices);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, *buffer);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, sizeof corner, corner, GLBK_GL_STATIC_DRAW);
    for (i = 0; i < 2; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, 3, GLBK_GL_FLOAT, 0, sizeof corner[0], (const void *)(size_t)(12 * i));
    }
    return vertices;
}

static void draw_triangle(gl_test *t, glbk_gbuffer *g, glbk_sfield_renderer *r, uint32_t vertices)
{
    const float clip[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, eye[3] = { 0, 5, 1 };
    glbk_surface surface;
    memset(&surface, 0, sizeof surface);
    surface.material.kind = LSAMP_MATERIAL_PHONG;
    surface.material.exponent = 20;
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, g, clip, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, g, &surface));
    t->gl.gl.BindVertexArray(vertices);
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
    assert_glbk(t, glbk_sfield_self_begin(&t->gl, r, g));       /* nothing is drawn: the cosine everywhere */
}

static void make_and_shade(gl_test *t, const both *b, float out[4][64])
{
    const float eye[3] = { 0, 5, 0 };
    glbk_sfield_scene w;
    glbk_gbuffer g;
    glbk_sfield_renderer r;
    glbk_state before;
    uint32_t vertices, buffer;
    assert_glbk(t, make_all(t, b, &w, &g, &r));
    GL_SAVED(t, glbk_sfield_bind(&t->gl, &w, NULL));
    GL_SAVED(t, assert_glbk(t, glbk_sfield_shade(&t->gl, &r, &g, &w, eye, 0)));
    GL_SAME(t, assert_glbk(t, glbk_sfield_read(&t->gl, &r, out[0], out[1])));
    vertices = make_triangle(&t->gl.gl, &buffer);
    glbk_state_save(&t->gl, &before);
    draw_triangle(t, &g, &r, vertices);         /* programs and target are made at first use, which asks GL */
    glbk_state_restore(&t->gl, &before);
    GL_SAVED(t, draw_triangle(t, &g, &r, vertices));
    t->gl.gl.DeleteVertexArrays(1, &vertices);
    t->gl.gl.DeleteBuffers(1, &buffer);
    GL_SAVED(t, assert_glbk(t, glbk_sfield_shade(&t->gl, &r, &g, &w, eye, 0)));
    GL_SAME(t, assert_glbk(t, glbk_sfield_read(&t->gl, &r, out[2], out[3])));
    GL_SAME(t, glbk_sfield_renderer_free(&t->gl, &r));
    GL_SAME(t, glbk_gbuffer_free(&t->gl, &g));
    GL_SAME(t, glbk_sfield_scene_free(&t->gl, &w));
}

static void a_hostile_state_changes_nothing(void **state)
{
    GL_TEST(t, state)
    static both b;
    float plain[4][64], odd[4][64];
    gl_hostile h;
    build_fields(&b, 2);
    make_brdf(&b);
    upload(t, &b);
    gl_state_watch(t, 1);
    gl_count_begin(&t->gl);
    make_and_shade(t, &b, plain);
    gl_count_end(&t->gl);
    assert_true(plain[0][0] != 0 && plain[0][4] == 0);       /* one point is there, its neighbours are not */
    assert_true(plain[2][0] != 0 && plain[2][4] != 0 && plain[2][60] != 0);        /* drawn: all of them */
    gl_hostile_make(t, &h);
    gl_hostile_set(t, &h);
    make_and_shade(t, &b, odd);
    assert_memory_equal(plain, odd, sizeof plain);
    gl_hostile_free(t, &h);
    free_both(t, &b);
}

static void a_lost_context_is_called_no_more(void **state)
{
    GL_TEST(t, state)
    static both b;
    static glbk_functions none;
    const float eye[3] = { 0, 5, 0 }, zeros[16] = { 0 };
    float out[64];
    glbk_sfield_scene w, w2;
    glbk_gbuffer g;
    glbk_sfield_renderer r, r2;
    glbk_sfield_renderer_desc d = { 4, 4, NULL, 1, 1, 0, 0, 1, 1, 0 };
    const float *own[16] = { NULL };
    sfield_entity e;
    glbk_context ctx;
    build_fields(&b, 2);
    make_brdf(&b);
    upload(t, &b);
    d.algebra = b.algebra;
    memset(&e, 0, sizeof e);
    e.transform[0] = e.transform[5] = e.transform[10] = e.transform[15] = 1;
    assert_glbk(t, make_all(t, &b, &w, &g, &r));
    ctx = t->gl;
    t->gl.gl = none;                    /* from here on a call of GL would crash */
    glbk_abandon(&t->gl);
    assert_int_equal(glbk_sfield_scene_create(&t->gl, &b.desc, &w2), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_renderer_create(&t->gl, &d, &r2), GLBK_ERR_LOST);
    assert_int_equal(w2.table.name + r2.light.name, 0);
    assert_int_equal(glbk_sfield_scene_entities(&t->gl, &w, &e, 1), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_scene_sky(&t->gl, &w, out), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_self_upload(&t->gl, &r, 0, 4, own), GLBK_ERR_LOST);
    g.has_depth = g.has_clip = 1;
    assert_int_equal(glbk_sfield_self_begin(&t->gl, &r, &g), GLBK_ERR_LOST);
    r.self_target.name = 1;                     /* as if it had been begun before */
    assert_int_equal(glbk_sfield_self_object(&t->gl, &r, zeros), GLBK_ERR_LOST);
    r.self_target.name = 0;
    glbk_sfield_bind(&t->gl, &w, NULL);
    assert_int_equal(glbk_sfield_shade(&t->gl, &r, &g, &w, eye, 0), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_read(&t->gl, &r, out, NULL), GLBK_ERR_LOST);
    w2 = w;
    w2.fields = (glbk_sfield_field *)calloc(1, sizeof *w2.fields);     /* memory is freed, GL not called */
    r2 = r;
    glbk_sfield_renderer_free(&t->gl, &r2);
    glbk_sfield_scene_free(&t->gl, &w2);
    t->gl = ctx;
    glbk_sfield_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &g);
    glbk_sfield_scene_free(&t->gl, &w);
    free_both(t, &b);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(functions_in_glsl_equal_their_twins), gl_unit_test(written_products_agree),
        gl_unit_test(scenes_are_shaded_as_on_the_cpu), gl_unit_test(materials_are_shaded_as_on_the_cpu),
        gl_unit_test(logarithms_are_added_as_on_the_cpu),
        gl_unit_test(failures_leave_nothing),
        gl_unit_test(a_lost_context_is_called_no_more), gl_unit_test(a_hostile_state_changes_nothing)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
