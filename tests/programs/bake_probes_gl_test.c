/* bake_probes_gl_test - the function that reads probes on GL, examples/bake/probes.glsl, run on each driver: against
   docs/probes.md written down once more in doubles; an even field, which is the same everywhere; a wall between a light
   probe and a dark one. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_backend.h"
#include "gl_backend/gl_programs.h"

#include "gl_test.h"

enum { SIDE = 8, FLOATS = 27 + 2 * SIDE * SIDE, ACROSS = 32, POINTS = ACROSS * ACROSS };

typedef struct field {
    int    grid[3];
    double origin[3], step[3];
    float *floats;
} field;

typedef struct questions { float points[4 * POINTS], normals[4 * POINTS], answers[4 * POINTS]; } questions;

static uint32_t state_of_random = 1;

static double random_in(double low, double high)
{
    state_of_random = state_of_random * 1664525u + 1013904223u;
    return low + (high - low) * (state_of_random >> 8) / 16777216.0;
}

static field make_field(int x, int y, int z)
{
    field f = { { x, y, z }, { -1, 0.5, 2 }, { 1, 0.75, 1.5 }, NULL };
    f.floats = (float *)calloc((size_t)(x * y * z) * FLOATS, sizeof(float));
    assert_non_null(f.floats);
    return f;
}

/* ---- docs/probes.md in doubles ---- */

static double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double irradiance_of(const float *probe, const double *n, int channel)
{
    const double x = n[0], y = n[1], z = n[2];
    const double basis[9] = { 0.28209479, 0.48860251 * y, 0.48860251 * z, 0.48860251 * x, 1.09254843 * x * y,
                              1.09254843 * y * z, 0.31539157 * (3 * z * z - 1), 1.09254843 * x * z,
                              0.54627422 * (x * x - y * y) };
    double sum = 0;
    for (int j = 0; j < 9; j++) sum += basis[j] * (double)probe[3 * j + channel];
    return sum > 0 ? sum : 0;
}

static double texel(const float *probe, int x, int y, int moment)
{
    x = x < 0 ? 0 : x >= SIDE ? SIDE - 1 : x;
    y = y < 0 ? 0 : y >= SIDE ? SIDE - 1 : y;
    return (double)probe[27 + 2 * (y * SIDE + x) + moment];
}

/* Between the middles of texels, linearly; beyond the outermost middles as there. */
static double distance_along(const float *probe, const double *d, int moment)
{
    const double length = fabs(d[0]) + fabs(d[1]) + fabs(d[2]), x = d[0] / length, y = d[1] / length;
    double u = x, v = y, a, b;
    if (d[2] < 0) {
        u = (1 - fabs(y)) * (x < 0 ? -1 : 1);
        v = (1 - fabs(x)) * (y < 0 ? -1 : 1);
    }
    u = fmin(fmax((0.5 * u + 0.5) * SIDE - 0.5, 0), SIDE - 1);
    v = fmin(fmax((0.5 * v + 0.5) * SIDE - 0.5, 0), SIDE - 1);
    a = u - floor(u), b = v - floor(v);
    return (1 - b) * ((1 - a) * texel(probe, (int)u, (int)v, moment) + a * texel(probe, (int)u + 1, (int)v, moment)) +
           b * ((1 - a) * texel(probe, (int)u, (int)v + 1, moment) + a * texel(probe, (int)u + 1, (int)v + 1, moment));
}

static double weight_of(const field *f, const float *probe, const double *place, const double *p, const double *n,
                        double near)
{
    const double to[3] = { p[0] - place[0], p[1] - place[1], p[2] - place[2] }, away = sqrt(dot3(to, to));
    const double facing = 0.5 - 0.5 * dot3(n, to) / fmax(away, 1e-6);
    double weight = fmax(near, 1e-4) * (facing * facing + 0.1), mean, square, variance, over, chance;
    (void)f;
    if (away <= 1e-4) return weight;
    mean = distance_along(probe, to, 0), square = distance_along(probe, to, 1);
    variance = fmax(square - mean * mean, 1e-6 + 1e-3 * mean * mean);
    over = fmax(away - mean, 0);
    chance = variance / (variance + over * over);
    return weight * fmax(chance * chance * chance, 0.01);
}

static double expected_of(const field *f, const double *p, const double *n, int channel)
{
    double sum = 0, weights = 0;
    for (int i = 0; i < 8; i++) {
        double place[3], near = 1, weight;
        int cell[3], number;
        for (int k = 0; k < 3; k++) {
            const double at = fmin(fmax((p[k] - f->origin[k]) / f->step[k], 0), f->grid[k] - 1);
            const int most = f->grid[k] > 2 ? f->grid[k] - 2 : 0, low = (int)at < most ? (int)at : most;
            const int high = i >> k & 1;
            cell[k] = low + high < f->grid[k] ? low + high : f->grid[k] - 1;
            place[k] = f->origin[k] + cell[k] * f->step[k];
            near *= high ? at - low : 1 - (at - low);
        }
        number = (cell[2] * f->grid[1] + cell[1]) * f->grid[0] + cell[0];
        weight = weight_of(f, f->floats + number * FLOATS, place, p, n, near);
        sum += weight * irradiance_of(f->floats + number * FLOATS, n, channel);
        weights += weight;
    }
    return sum / weights;
}

/* ---- on GL ---- */

static char *read_glsl(void)
{
    char *text = (char *)calloc(1, 1 << 16);
    FILE *file = fopen("examples/bake/probes.glsl", "r");
    assert_true(text && file);
    assert_true(fread(text, 1, (1 << 16) - 1, file) > 1000);
    fclose(file);
    return text;
}

/* Fills the answers: each pixel asks for one point. */
static void ask(gl_test *t, const field *f, questions *q)
{
    static const char *const names[3] = { "probes", "points", "normals" };
    static char text[1 << 16];
    char *glsl = read_glsl();
    glbk_texture textures[3];
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, ACROSS, ACROSS, 0);
    glbk_source s = { 0 };
    glbk_program program;
    glbk_pass pass = { 0 };
    textures[0] = gl_texture(t, GLBK_FORMAT_R32F, FLOATS, (uint32_t)(f->grid[0] * f->grid[1] * f->grid[2]), f->floats);
    textures[1] = gl_texture(t, GLBK_FORMAT_RGBA32F, ACROSS, ACROSS, q->points);
    textures[2] = gl_texture(t, GLBK_FORMAT_RGBA32F, ACROSS, ACROSS, q->normals);
    snprintf(text, sizeof text,
             "%s\nuniform highp sampler2D probes;\nuniform highp sampler2D points;\nuniform highp sampler2D normals;\n"
             "layout(location = 0) out glbk_color result;\nvoid main()\n{\n"
             "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
             "    vec3 e = dapple_probe_irradiance(probes, ivec3(%d, %d, %d), vec3(%.9g, %.9g, %.9g),\n"
             "        vec3(%.9g, %.9g, %.9g), %d, texelFetch(points, at, 0).xyz, texelFetch(normals, at, 0).xyz);\n"
             "    result = glbk_pack(vec4(e, 1.0));\n}\n", glsl, f->grid[0], f->grid[1], f->grid[2], f->origin[0],
             f->origin[1], f->origin[2], f->step[0], f->step[1], f->step[2], SIDE);
    s.fragment = text;
    pass.target = &c.target;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    for (uint32_t i = 0; i < 3; i++) {
        t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(program.name, names[i]), (int32_t)i);
        glbk_bind_texture(&t->gl, i, &textures[i]);
    }
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, ACROSS, ACROSS, q->answers));
    for (int i = 0; i < 3; i++) glbk_texture_free(&t->gl, &textures[i]);
    glbk_program_free(&t->gl, &program);
    gl_canvas_free(t, &c);
    free(glsl);
}

/* Points in and about the grid, unit normals. */
static void scatter(questions *q, const field *f)
{
    for (int i = 0; i < POINTS; i++) {
        double n[3] = { 0, 0, 0 }, length = 0;
        for (int k = 0; k < 3; k++)
            q->points[4 * i + k] = (float)(f->origin[k] + f->step[k] * random_in(-0.5, f->grid[k] - 0.5));
        while (length < 0.1 || length > 1) {
            for (int k = 0; k < 3; k++) n[k] = random_in(-1, 1);
            length = sqrt(dot3(n, n));
        }
        for (int k = 0; k < 3; k++) q->normals[4 * i + k] = (float)(n[k] / length);
    }
}

static void irradiance_is_what_the_page_says(void **state)
{
    static const int grids[4][3] = { { 3, 2, 4 }, { 1, 1, 1 }, { 2, 1, 3 }, { 5, 4, 1 } };
    GL_TEST(t, state)
    questions *q = (questions *)calloc(1, sizeof *q);
    double worst = 0;
    assert_non_null(q);
    for (int g = 0; g < 4; g++) {
        field f = make_field(grids[g][0], grids[g][1], grids[g][2]);
        const int count = f.grid[0] * f.grid[1] * f.grid[2];
        for (int i = 0; i < count; i++) {
            float *probe = f.floats + i * FLOATS;
            for (int j = 0; j < 27; j++) probe[j] = (float)(j < 3 ? random_in(2, 6) : random_in(-1, 1));
            for (int j = 0; j < SIDE * SIDE; j++) {
                const double mean = random_in(0.2, 2), spread = random_in(0, 0.4);
                probe[27 + 2 * j] = (float)mean;
                probe[28 + 2 * j] = (float)(mean * mean + spread * spread);
            }
        }
        scatter(q, &f);
        ask(t, &f, q);
        for (int i = 0; i < POINTS; i++) {
            double p[3], n[3];
            for (int k = 0; k < 3; k++) p[k] = (double)q->points[4 * i + k], n[k] = (double)q->normals[4 * i + k];
            for (int k = 0; k < 3; k++) {
                const double e = expected_of(&f, p, n, k), found = (double)q->answers[4 * i + k];
                worst = fmax(worst, fabs(found - e));
                if (!(fabs(found - e) <= 2e-4 * (1 + e)))
                    fail_msg("grid %d, point %d, channel %d: %g, not %g", g, i, k, found, e);
            }
        }
        free(f.floats);
    }
    printf("apart from doubles by %.1e at most\n", worst);
    free(q);
}

/* All probes hold pi for every normal: so does every point, whatever the distances are. */
static void an_even_field_is_even(void **state)
{
    GL_TEST(t, state)
    questions *q = (questions *)calloc(1, sizeof *q);
    field f = make_field(3, 3, 3);
    assert_non_null(q);
    for (int i = 0; i < 27; i++)
        for (int j = 0; j < FLOATS; j++)
            f.floats[i * FLOATS + j] = j < 3 ? (float)(3.14159265358979 / 0.28209479) : j < 27 ? 0
                                                 : (float)random_in(0.1, 1);
    scatter(q, &f);
    ask(t, &f, q);
    for (int i = 0; i < POINTS; i++)
        for (int k = 0; k < 3; k++) assert_true(fabsf(q->answers[4 * i + k] - 3.14159265f) < 1e-4f);
    free(f.floats);
    free(q);
}

/* The direction of a texel's middle. */
static void direction_of(int x, int y, double *d)
{
    const double u = 2 * (x + 0.5) / SIDE - 1, v = 2 * (y + 0.5) / SIDE - 1;
    double length;
    d[2] = 1 - fabs(u) - fabs(v);
    d[0] = d[2] < 0 ? (1 - fabs(v)) * (u < 0 ? -1 : 1) : u;
    d[1] = d[2] < 0 ? (1 - fabs(u)) * (v < 0 ? -1 : 1) : v;
    length = sqrt(dot3(d, d));
    for (int k = 0; k < 3; k++) d[k] /= length;
}

/* A wall half way between two probes, one of which is light and one dark: on either side it is as its probe says, right
   up to the wall; with the distances taken away the middle is grey. */
static void light_does_not_come_through_a_wall(void **state)
{
    GL_TEST(t, state)
    questions *q = (questions *)calloc(1, sizeof *q);
    field f = make_field(2, 1, 1);
    assert_non_null(q);
    for (int open = 0; open < 2; open++) {
        for (int i = 0; i < 2; i++)
            for (int j = 0; j < SIDE * SIDE; j++) {
                double d[3], distance;
                float *probe = f.floats + i * FLOATS;
                direction_of(j % SIDE, j / SIDE, d);
                distance = !open && (i ? d[0] < 0 : d[0] > 0) ? fmin(0.5 * f.step[0] / fabs(d[0]), 3) : 3;
                probe[0] = probe[1] = probe[2] = i ? 0 : (float)(1 / 0.28209479);
                probe[27 + 2 * j] = (float)distance;
                probe[28 + 2 * j] = (float)(distance * distance);
            }
        for (int i = 0; i < POINTS; i++) {
            const float along = ((float)i + 0.5f) / POINTS;
            for (int k = 0; k < 3; k++) {
                q->points[4 * i + k] = (float)(f.origin[k] + (k ? 0 : f.step[0] * (double)along));
                q->normals[4 * i + k] = k == 1;
            }
        }
        ask(t, &f, q);
        for (int i = 0; i < POINTS; i++) {
            const float along = ((float)i + 0.5f) / POINTS, found = q->answers[4 * i];
            if (open ? fabsf(along - 0.5f) < 0.01f && fabsf(found - 0.5f) > 0.03f
                     : (along < 0.4f && found < 0.95f) || (along > 0.6f && found > 0.05f))
                fail_msg("%s, %g along: %g", open ? "no wall" : "a wall", (double)along, (double)found);
        }
    }
    free(f.floats);
    free(q);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(irradiance_is_what_the_page_says),
        gl_unit_test(an_even_field_is_even),
        gl_unit_test(light_does_not_come_through_a_wall),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30);
}
