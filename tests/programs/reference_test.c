/* reference_test - the path tracer that everything else is compared with, against closed forms. Rows of
   docs/conformance.md: T19, T23, T25, T42, T43, T45, T50. What needs samples is compared within five of their standard
   errors, which must be below 0.2 %; what does not, within the rounding of float. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

/* The parts of the program `render` that the reference is made of: inside one file, since they are no library. */
#include "examples/render/json.c"
#include "examples/render/settings.c"
#include "examples/render/emitters.c"
#include "examples/render/ref_bsdf.c"
#include "examples/render/ref_lights.c"
#include "examples/render/ref_scene.c"
#include "examples/render/reference.c"

#define PI RF_PI
#define COPIES 64              /* a single point is shaded this often, with other random numbers each time */

static void near(double a, double b, double epsilon, int line)
{
    if (!(fabs(a - b) <= epsilon))
        fail_msg("line %d: %.9g is not within %.3g of %.9g", line, a, epsilon, b);
}

#define assert_near(a, b, e) near((double)(a), (double)(b), (double)(e), __LINE__)

/* ---- small worlds ---- */

typedef struct world {
    ex_scene    scene;
    rd_settings settings;
    uint32_t    samples, seed;
    int         threads;
    double      noise;         /* of the last run, as reported */
    double      error;         /* standard error of the last radiance(), from the spread of its copies */
} world;

static void *more(void *array, uint32_t count, size_t size)
{
    char *grown = realloc(array, (count + (size_t)1) * size);
    assert_non_null(grown);
    memset(grown + count * size, 0, size);
    return grown;
}

static int make_world(void **state)
{
    world *w = calloc(1, sizeof *w);
    if (!w)
        return -1;
    w->settings.common = rd_common_keys;
    w->settings.own = rd_reference.keys;
    w->samples = 1024;
    w->threads = 1;
    *state = w;
    return 0;
}

static int free_world(void **state)
{
    world *w = *state;
    ex_scene_free(&w->scene);
    free(w);
    return 0;
}

static void set(world *w, const char *pair)
{
    char error[EX_ERROR_SIZE];
    assert_int_equal(rd_settings_add(&w->settings, pair, error), 0);
}

static uint32_t add_material(world *w, float albedo, float emission)
{
    ex_scene *s = &w->scene;
    ex_material *m;
    s->materials = more(s->materials, s->material_count, sizeof *s->materials);
    m = &s->materials[s->material_count];
    for (int k = 0; k < 3; k++) {
        m->base_color[k] = albedo;
        m->emission[k] = emission;
    }
    m->roughness = 1;
    m->base_texture = -1;
    return s->material_count++;
}

/* A parallelogram corner, corner + u, corner + u + v, corner + v; its front is on the side of u x v. */
static void add_quad(world *w, rf_v3 corner, rf_v3 u, rf_v3 v, uint32_t material)
{
    static const uint32_t order[6] = { 0, 1, 2, 0, 2, 3 };
    ex_scene *s = &w->scene;
    rf_v3 n = rf_unit(rf_cross(u, v));
    ex_mesh *mesh;
    ex_object *object;
    s->meshes = more(s->meshes, s->mesh_count, sizeof *s->meshes);
    s->objects = more(s->objects, s->object_count, sizeof *s->objects);
    mesh = &s->meshes[s->mesh_count];
    object = &s->objects[s->object_count++];
    mesh->positions = calloc(12, sizeof(float));
    mesh->normals = calloc(12, sizeof(float));
    mesh->uvs = calloc(8, sizeof(float));
    mesh->indices = calloc(6, sizeof(uint32_t));
    mesh->materials = calloc(2, sizeof(uint32_t));
    assert_true(mesh->positions && mesh->normals && mesh->uvs && mesh->indices && mesh->materials);
    mesh->vertex_count = 4;
    mesh->triangle_count = 2;
    for (size_t i = 0; i < 4; i++) {
        double a = i == 1 || i == 2, b = i >= 2;
        rf_v3 p = rf_mad(rf_mad(corner, u, a), v, b);
        float *to = mesh->positions + 3 * i;
        to[0] = (float)p.x, to[1] = (float)p.y, to[2] = (float)p.z;
        to = mesh->normals + 3 * i;
        to[0] = (float)n.x, to[1] = (float)n.y, to[2] = (float)n.z;
        mesh->uvs[2 * i] = (float)a;
        mesh->uvs[2 * i + 1] = (float)b;
    }
    memcpy(mesh->indices, order, sizeof order);
    mesh->materials[0] = mesh->materials[1] = material;
    object->mesh = s->mesh_count++;
    object->transform[0] = object->transform[5] = object->transform[10] = object->transform[15] = 1;
}

/* The six faces of a cube, all facing inwards. */
static void add_room(world *w, rf_v3 centre, double half, uint32_t material)
{
    for (int face = 0; face < 6; face++) {
        rf_v3 n = rf_make(0, 0, 0), x, y, corner;
        double sign = face & 1 ? -1 : 1;
        if (face / 2 == 0) n.x = sign;
        if (face / 2 == 1) n.y = sign;
        if (face / 2 == 2) n.z = sign;
        rf_frame(n, &x, &y);
        corner = rf_mad(centre, n, -half);
        corner = rf_mad(rf_mad(corner, x, -half), y, -half);
        add_quad(w, corner, rf_scale(x, 2 * half), rf_scale(y, 2 * half), material);
    }
}

static void add_floor(world *w, double half, uint32_t material)
{
    add_quad(w, rf_make(-half, 0, half), rf_make(2 * half, 0, 0), rf_make(0, 0, -2 * half), material);
}

static ex_light *add_light_kind(world *w, ex_light_kind kind, rf_v3 position, rf_v3 direction, float value)
{
    ex_scene *s = &w->scene;
    ex_light *light;
    s->lights = more(s->lights, s->light_count, sizeof *s->lights);
    light = &s->lights[s->light_count++];
    light->kind = kind;
    light->position[0] = (float)position.x;
    light->position[1] = (float)position.y;
    light->position[2] = (float)position.z;
    direction = rf_unit(direction);
    light->direction[0] = (float)direction.x;
    light->direction[1] = (float)direction.y;
    light->direction[2] = (float)direction.z;
    light->value[0] = light->value[1] = light->value[2] = value;
    return light;
}

static void add_sky(world *w, uint32_t width, uint32_t height, float radiance)
{
    w->scene.sky.width = width;
    w->scene.sky.height = height;
    w->scene.sky.rgb = calloc(3 * (size_t)width * height, sizeof(float));
    assert_non_null(w->scene.sky.rgb);
    for (size_t i = 0; i < 3 * (size_t)width * height; i++)
        w->scene.sky.rgb[i] = radiance;
}

static ex_pixel pixel_at(rf_v3 position, rf_v3 normal, float albedo)
{
    ex_pixel p;
    memset(&p, 0, sizeof p);
    p.position[0] = (float)position.x, p.position[1] = (float)position.y, p.position[2] = (float)position.z;
    p.normal[0] = (float)normal.x, p.normal[1] = (float)normal.y, p.normal[2] = (float)normal.z;
    memcpy(p.geometric, p.normal, sizeof p.normal);
    memcpy(p.view, p.normal, sizeof p.normal);
    p.albedo[0] = p.albedo[1] = p.albedo[2] = albedo;
    p.roughness = 1;
    return p;
}

static void need_embree(void)
{
    if (rf_scene_version())
        return;
    puts("skip: built without Embree");
    skip();
}

/* Shades all pixels; out: 3 floats each. */
static void shade(world *w, ex_pixel *pixels, uint32_t count, float *out)
{
    char error[EX_ERROR_SIZE] = "";
    ex_gbuffer gbuffer = { count, 1, pixels };
    ex_image image = { count, 1, out };
    rd_job job;
    rd_emitter *emitters;
    void *state;
    rd_json json = { NULL, 0, 0, 0 };
    rd_report report = { 0, 0, &json };
    memset(&job, 0, sizeof job);
    assert_int_equal(rd_emitters_build(&w->scene, &emitters, &job.emitter_count), 0);
    assert_int_equal(ex_scene_bounds(&w->scene, job.center, &job.radius), 0);
    job.scene = &w->scene;
    job.gbuffer = &gbuffer;
    job.emitters = emitters;
    job.settings = &w->settings;
    job.samples = w->samples;
    job.aa = job.frames = 1;
    job.seed = w->seed;
    job.threads = w->threads;
    job.pool = ex_pool_create(w->threads);
    memset(out, 0, 3 * sizeof(float) * count);
    if (rd_reference.open(&state, &job, error) != 0)
        fail_msg("open: %s", error);
    assert_int_equal(rd_reference.frame(state, &job, &image, error), 0);
    rd_reference.report(state, &report);
    assert_true(report.memory_bytes > 0 && report.peak_bytes >= report.memory_bytes);
    assert_non_null(strstr(json.text, "\"noise\": "));
    w->noise = strtod(strstr(json.text, "\"noise\": ") + 9, NULL);
    rd_json_free(&json);
    rd_reference.close(state);
    ex_pool_free(job.pool);
    free(emitters);
}

/* Radiance of one point (red), averaged over COPIES. */
static double radiance(world *w, ex_pixel pixel)
{
    ex_pixel pixels[COPIES];
    float out[3 * COPIES];
    double sum = 0, squares = 0;
    for (int i = 0; i < COPIES; i++)
        pixels[i] = pixel;
    shade(w, pixels, COPIES, out);
    for (int i = 0; i < COPIES; i++) {
        sum += (double)out[3 * i];
        squares += (double)out[3 * i] * (double)out[3 * i];
    }
    w->error = sqrt(rf_most(squares / COPIES - sum * sum / COPIES / COPIES, 0) / (COPIES - 1));
    return sum / COPIES;
}

/* value = scale times the last radiance() */
static void sampled(const world *w, double value, double scale, double expected, int line)
{
    double error = scale * w->error;
    if (error > 0.002 * fabs(expected))
        fail_msg("line %d: standard error %.3g of %.6g", line, error, expected);
    near(value, expected, 5 * error + 2e-6 * fabs(expected), line);
}

#define assert_radiance(w, pixel, expected) sampled(w, radiance(w, pixel), 1, expected, __LINE__)
#define assert_irradiance(w, p, n, expected) sampled(w, irradiance(w, p, n), PI, expected, __LINE__)

/* Irradiance at a point that nothing but lights can reach; a far speck of geometry keeps the scene from being empty. */
static double irradiance(world *w, rf_v3 position, rf_v3 normal)
{
    if (w->scene.object_count == 0)
        add_quad(w, rf_make(0, -5, 0), rf_make(0.1, 0, 0), rf_make(0, 0, 0.1), add_material(w, 0.5f, 0));
    return PI * radiance(w, pixel_at(position, normal, 1));
}

static rf_v3 up(void) { return rf_make(0, 1, 0); }
static rf_v3 zero(void) { return rf_make(0, 0, 0); }

/* ---- skies ---- */

static void a_plane_under_a_uniform_sky_reflects_its_albedo(void **state)
{
    world *w = *state;
    need_embree();
    add_sky(w, 64, 32, 1);
    add_floor(w, 1, add_material(w, 0.7f, 0));
    assert_radiance(w, pixel_at(zero(), up(), 0.7f), 0.7);       /* E = pi */
}

/* A narrow texel in the middle of the map is +X; a turn by +90 degrees takes it to -Z. */
static void one_texel_of_a_sky_lights_from_its_side(void **state)
{
    world *w = *state;
    double e;
    float seen[3], to_sky[3] = { 0, 0, -1 };
    need_embree();
    add_sky(w, 64, 33, 0);
    for (size_t k = 0; k < 3; k++)
        w->scene.sky.rgb[3 * (16 * 64 + 32) + k] = 100;        /* phi in [0, pi/32), around the equator */
    /* integral of the cosine to the texel's centre: cos(latitude)^2 over latitudes, cos over longitudes */
    e = 100 * 2 * sin(PI / 64) * (PI / 66 + 0.5 * sin(PI / 33));
    assert_irradiance(w, zero(), rf_make(cos(PI / 64), 0, sin(PI / 64)), e);
    assert_near(irradiance(w, zero(), rf_make(-1, 0, 0)), 0, 0);
    w->scene.sky.rotation = (float)(PI / 2);
    assert_irradiance(w, zero(), rf_make(sin(PI / 64), 0, -cos(PI / 64)), e);
    ex_sky_radiance(&w->scene.sky, to_sky, seen);               /* its picture turns the same way */
    assert_true(seen[0] > 1);
}

static void a_wall_hides_half_of_the_sky_and_a_roof_the_rest(void **state)
{
    world *w = *state;
    need_embree();
    add_sky(w, 64, 32, 1);
    add_quad(w, rf_make(0.001, 0, 1000), rf_make(0, 0, -2000), rf_make(0, 2000, 0), add_material(w, 0, 0));
    assert_irradiance(w, rf_make(0, 0.5, 0), up(), PI / 2);
    add_quad(w, rf_make(-3000, 1500, -3000), rf_make(6000, 0, 0), rf_make(0, 0, 6000), add_material(w, 0, 0));
    assert_near(irradiance(w, rf_make(0, 1490, 0), up()), 0, 1e-3);         /* 1e-5 of the sky is left at the rim */
}

/* ---- lights without size ---- */

static void suns_spots_and_points_light_as_in_closed_form(void **state)
{
    world *w = *state;
    ex_light *light;
    need_embree();
    add_light_kind(w, EX_LIGHT_SUN, zero(), rf_make(1, 2, 0), 3);
    assert_near(irradiance(w, zero(), up()), 3 * 2 / sqrt(5), 1e-6);
    assert_near(irradiance(w, zero(), rf_make(0, -1, 0)), 0, 0);
    w->scene.light_count = 0;
    add_light_kind(w, EX_LIGHT_POINT, rf_make(0, 2, 0), zero(), 8);
    assert_near(irradiance(w, zero(), up()), 8.0 / 4, 1e-6);
    assert_near(irradiance(w, rf_make(2, 0, 0), up()), 8.0 / 8 * sqrt(0.5), 1e-6);
    w->scene.light_count = 0;
    light = add_light_kind(w, EX_LIGHT_SPOT, rf_make(0, 2, 0), rf_make(0, -1, 0), 8);
    light->cos_half_angle = (float)cos(PI / 6);
    assert_near(irradiance(w, zero(), up()), 8.0 / 4, 1e-6);
    assert_near(irradiance(w, rf_make(1.1, 0, 0), up()), 8 / 5.21 * 2 / sqrt(5.21), 1e-6);
    assert_near(irradiance(w, rf_make(1.2, 0, 0), up()), 0, 0);             /* the cone ends at 2 tan 30 = 1.1547 */
}

static void a_sheet_hides_the_sun_below_it(void **state)
{
    world *w = *state;
    need_embree();
    add_light_kind(w, EX_LIGHT_SUN, zero(), up(), 1);
    add_quad(w, rf_make(-1, 1, -1), rf_make(2, 0, 0), rf_make(0, 0, 2), add_material(w, 0.5f, 0));
    assert_near(irradiance(w, zero(), up()), 0, 0);
    assert_near(irradiance(w, rf_make(1.001, 0, 0), up()), 1, 1e-6);
    assert_near(irradiance(w, rf_make(0, 1.1, 0), up()), 1, 1e-6);
}

/* ---- lights with size ---- */

static void a_rectangle_lights_as_in_closed_form(void **state)
{
    world *w = *state;
    ex_light *light;
    need_embree();
    light = add_light_kind(w, EX_LIGHT_RECT, rf_make(-0.5, 1, -0.5), zero(), 2);
    light->u[0] = light->v[2] = 1;             /* u x v = -Y */
    assert_irradiance(w, zero(), up(), 2 * 0.752275);
    assert_irradiance(w, rf_make(0.5, 0, 0.5), up(), 2 * PI * 0.138532);
    assert_near(irradiance(w, rf_make(0, 2, 0), rf_make(0, -1, 0)), 0, 0);  /* one-sided */
}

static void a_disc_lights_as_in_closed_form(void **state)
{
    world *w = *state;
    ex_light *light;
    need_embree();
    light = add_light_kind(w, EX_LIGHT_DISC, rf_make(0, 2, 0), rf_make(0, -1, 0), 3);
    light->radius = 1.5f;
    assert_irradiance(w, zero(), up(), PI * 3 * 2.25 / (2.25 + 4));
    assert_near(irradiance(w, rf_make(0, 4, 0), rf_make(0, -1, 0)), 0, 0);
}

static void a_sphere_lights_as_in_closed_form(void **state)
{
    world *w = *state;
    ex_light *light;
    need_embree();
    light = add_light_kind(w, EX_LIGHT_SPHERE, rf_make(0, 2, 0), zero(), 3);
    light->radius = 0.5f;
    assert_irradiance(w, zero(), up(), PI * 3 / 16);
    assert_irradiance(w, zero(), rf_make(0.6, 0.8, 0), PI * 3 / 16 * 0.8);    /* wholly above the horizon */
    light->radius = 0.002f;                    /* far away: no cancellation */
    assert_irradiance(w, zero(), up(), PI * 3e-6);
    light->radius = 1.99f;
    assert_irradiance(w, zero(), up(), PI * 3 * 0.990025);
}

static void a_line_lights_as_in_closed_form(void **state)
{
    world *w = *state;
    ex_light *light;
    const double a = 1.5, h = 1;
    need_embree();
    light = add_light_kind(w, EX_LIGHT_LINE, rf_make(-a, h, 0), zero(), 100);
    light->u[0] = (float)(2 * a);
    light->radius = 0.004f;
    /* thin cylinder: each element has intensity 2 r L sin; integral of h^2 / (h^2 + l^2)^2 */
    assert_irradiance(w, zero(), up(), 2 * 0.004 * 100 * (a / (h * h + a * a) + atan(a / h) / h));
}

/* Two sources at once: the choice between them must not change the sum. */
static void two_lights_sum_whichever_is_chosen(void **state)
{
    world *w = *state;
    ex_light *light;
    need_embree();
    add_sky(w, 64, 32, 0.25f);
    light = add_light_kind(w, EX_LIGHT_SPHERE, rf_make(0, 2, 0), zero(), 3);
    light->radius = 0.5f;
    light = add_light_kind(w, EX_LIGHT_DISC, rf_make(0, 2, 0), rf_make(0, -1, 0), 3);
    light->radius = 1.5f;
    add_light_kind(w, EX_LIGHT_SUN, zero(), up(), 1);
    assert_irradiance(w, zero(), up(), PI / 4 + PI * 3 / 16 + PI * 3 * 0.36 + 1);
}

/* ---- emissive meshes ---- */

static void an_emissive_square_lights_as_a_rectangle(void **state)
{
    world *w = *state;
    uint32_t lamp;
    need_embree();
    lamp = add_material(w, 0, 2);
    add_quad(w, rf_make(-0.5, 1, -0.5), rf_make(1, 0, 0), rf_make(0, 0, 1), lamp);
    assert_irradiance(w, zero(), up(), 2 * 0.752275);
    assert_near(irradiance(w, rf_make(0, 2, 0), rf_make(0, -1, 0)), 0, 0);
    w->scene.materials[lamp].double_sided = 1;
    assert_irradiance(w, rf_make(0, 2, 0), rf_make(0, -1, 0), 2 * 0.752275);
    w->scene.materials[lamp].double_sided = 0;
    w->scene.objects[0].transform[0] = -1;     /* mirrored: the same square and the same front */
    assert_irradiance(w, zero(), up(), 2 * 0.752275);
    assert_near(irradiance(w, rf_make(0, 2, 0), rf_make(0, -1, 0)), 0, 0);
}

/* Mean over a grid of points on the unit square [-0.5, 0.5]^2 at height 0 of E / (pi L). */
static double form_factor(world *w)
{
    enum { SIDE = 48 };
    static ex_pixel pixels[SIDE * SIDE];
    static float out[3 * SIDE * SIDE];
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        pixels[i] = pixel_at(rf_make((i % SIDE + 0.5) / SIDE - 0.5, 0, (i / SIDE + 0.5) / SIDE - 0.5), up(), 1);
    w->samples = 64;
    shade(w, pixels, SIDE * SIDE, out);
    for (int i = 0; i < SIDE * SIDE; i++)
        sum += (double)out[3 * i];
    return sum / (SIDE * SIDE);
}

static void a_form_factor_halves_behind_half_a_sheet(void **state)
{
    world *w = *state;
    uint32_t lamp, black;
    need_embree();
    lamp = add_material(w, 0, 1);
    black = add_material(w, 0, 0);
    add_quad(w, rf_make(-0.5, 1, -0.5), rf_make(1, 0, 0), rf_make(0, 0, 1), lamp);
    assert_near(form_factor(w), 0.1998249, 5e-4);
    add_quad(w, rf_make(0, 0.5, -2), rf_make(2, 0, 0), rf_make(0, 0, 4), black);    /* half a plane, half-way */
    assert_near(form_factor(w), 0.1998249 / 2, 5e-4);
    add_quad(w, rf_make(-2, 0.5, -2), rf_make(2, 0, 0), rf_make(0, 0, 4), black);
    assert_near(form_factor(w), 0, 0);
}

static void squares_that_share_an_edge_have_the_known_form_factor(void **state)
{
    world *w = *state;
    need_embree();
    add_quad(w, rf_make(-0.5, 0, 0.5), rf_make(0, 0, -1), rf_make(0, 1, 0), add_material(w, 0, 1));
    assert_near(form_factor(w), 0.2000438, 1e-3);      /* the grid misses some of the edge's singularity */
}

/* ---- bounces ---- */

static void bounces_in_a_furnace_halve_what_is_missing(void **state)
{
    static const char *const bounces[] = { "bounces=0", "bounces=1", "bounces=2", "bounces=60" };
    static const double expected[] = { 0.5, 0.75, 0.875, 1 };      /* plus the emission of 1 itself: 1.5, 1.75, ... 2 */
    world *w = *state;
    need_embree();
    add_room(w, rf_make(3, 4, 5), 1, add_material(w, 0.5f, 1));
    for (int i = 0; i < 4; i++) {
        set(w, bounces[i]);
        assert_radiance(w, pixel_at(rf_make(3.3, 3, 5.2), up(), 0.5f), expected[i]);
    }
    set(w, "bounces=1");
    set(w, "only=indirect");
    assert_radiance(w, pixel_at(rf_make(3.3, 3, 5.2), up(), 0.5f), 0.25);
    set(w, "only=direct");
    assert_radiance(w, pixel_at(rf_make(3.3, 3, 5.2), up(), 0.5f), 0.5);
}

static void no_light_enters_a_sealed_box(void **state)
{
    world *w = *state;
    ex_light *light;
    need_embree();
    add_room(w, zero(), 1, add_material(w, 0.8f, 0));
    add_light_kind(w, EX_LIGHT_SUN, zero(), rf_make(1, 2, 3), 100);
    light = add_light_kind(w, EX_LIGHT_SPHERE, rf_make(3, 0, 0), zero(), 100);
    light->radius = 1;
    add_sky(w, 16, 8, 10);
    set(w, "bounces=5");
    for (int i = 0; i < 8; i++)        /* close to edges and corners too */
        assert_near(radiance(w, pixel_at(rf_make(1 - pow(0.5, i), -1, 1 - pow(0.3, i)), up(), 0.8f)), 0, 0);
}

/* T25: a lit disc seen from above reflects E = rho E0 / 2; a black sheet between hides it but for the setting. */
static void bounced_light_is_hidden_unless_the_setting_says_no(void **state)
{
    world *w = *state;
    ex_pixel eye = pixel_at(rf_make(0, 1, 0), rf_make(0, -1, 0), 1);
    double e0, disc;
    uint32_t grey;
    need_embree();
    grey = add_material(w, 0.6f, 0);
    for (int i = 0; i < 96; i++) {             /* a disc of slices */
        double a = 2 * PI * i / 96, b = 2 * PI * (i + 1) / 96;
        add_quad(w, zero(), rf_make(cos(b), 0, sin(b)), rf_make(cos(a), 0, sin(a)), grey);
        w->scene.meshes[w->scene.mesh_count - 1].triangle_count = 1;
        w->scene.meshes[w->scene.mesh_count - 1].indices[2] = 3;
    }
    add_light_kind(w, EX_LIGHT_SUN, zero(), rf_make(20, 1, 0), 400);
    e0 = 400 / sqrt(401);
    disc = 0.5 * 0.6 * e0 / PI * sin(2 * PI / 96) / (2 * PI / 96);     /* of the polygon's area; nearly its share */
    set(w, "bounces=1");
    assert_radiance(w, eye, disc);
    add_quad(w, rf_make(-3, 0.5, -3), rf_make(0, 0, 6), rf_make(6, 0, 0), add_material(w, 0, 0));
    assert_near(radiance(w, eye), 0, 0);
    set(w, "indirect_visibility=0");
    assert_radiance(w, eye, disc);
    set(w, "only=direct");
    assert_near(radiance(w, eye), 0, 0);
}

/* ---- materials=full ---- */

/* glTF's metal-rough model once more, as its appendix B writes it. */
static double brdf(double alpha, double base, double metallic, rf_v3 l, rf_v3 v)
{
    rf_v3 h = rf_unit(rf_add(l, v));
    double a2 = alpha * alpha, nh = h.z, vh = rf_dot(v, h), d, visibility, f0, f;
    d = a2 / (PI * pow(nh * nh * (a2 - 1) + 1, 2));
    visibility = 0.5 / (l.z * sqrt(v.z * v.z * (1 - a2) + a2) + v.z * sqrt(l.z * l.z * (1 - a2) + a2));
    f0 = 0.04 * (1 - metallic) + base * metallic;
    f = f0 + (1 - f0) * pow(1 - vh, 5);
    return (1 - f) * base * (1 - metallic) / PI + f * d * visibility;
}

static double reflectance(double alpha, double base, double metallic, rf_v3 v)
{
    const int rings = 1200, sectors = 1200;
    double sum = 0;
    for (int i = 0; i < rings; i++)
        for (int j = 0; j < sectors; j++) {
            double z = sqrt((i + 0.5) / rings), r = sqrt(1 - z * z), phi = 2 * PI * (j + 0.5) / sectors;
            sum += brdf(alpha, base, metallic, rf_make(r * cos(phi), r * sin(phi), z), v);
        }
    return PI * sum / ((double)rings * sectors);       /* even in z^2: weighted by the cosine */
}

static void metal_rough_reflects_its_share_of_a_white_sky(void **state)
{
    static const struct { float roughness, base, metallic, view; } cases[] = {
        { 1, 1, 1, 0.9f }, { 0.7f, 1, 1, 0.5f }, { 0.5f, 1, 1, 0.15f }, { 0.6f, 0.5f, 0, 0.8f },
        { 0.45f, 0.8f, 0.3f, 0.3f }, { 1, 0.2f, 0, 0.05f }
    };
    world *w = *state;
    need_embree();
    add_sky(w, 64, 32, 1);
    add_floor(w, 1, add_material(w, 0.5f, 0));
    set(w, "materials=full");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double z = (double)cases[i].view, r = (double)cases[i].roughness, expected, found;
        ex_pixel p = pixel_at(zero(), up(), cases[i].base);
        p.roughness = cases[i].roughness;
        p.metallic = cases[i].metallic;
        p.view[0] = (float)sqrt(1 - z * z);
        p.view[1] = cases[i].view;
        expected = reflectance(r * r, (double)cases[i].base, (double)cases[i].metallic, rf_make(sqrt(1 - z * z), 0, z));
        found = radiance(w, p);
        sampled(w, found, 1, expected, __LINE__);
        if (cases[i].metallic >= 1)
            assert_true(found <= 1.0005);      /* white furnace: one scattering loses light, never gains it */
    }
}

/* Samples of the BRDF follow its density: the mean of 1 / pdf over a cap is the cap's solid angle. */
static void samples_of_the_brdf_follow_their_density(void **state)
{
    const int count = 1 << 18;
    (void)state;
    for (int k = 0; k < 3; k++) {
        rf_bsdf b;
        double sum = 0, z = 0.9 - 0.35 * k;
        rf_bsdf_init(&b, up(), rf_make(sqrt(1 - z * z), z, 0), rf_make(0.5, 0.5, 0.5), 0.5, 0.6, 1);
        for (int i = 0; i < count; i++) {
            rf_sampler s = { 77u + (unsigned)k, (uint32_t)i, 0 };
            rf_v3 direction, value;
            double u[2], pdf, again;
            rf_sample_2d(&s, u);
            if (!rf_bsdf_sample(&b, u, &direction, &value, &pdf))
                continue;
            rf_bsdf_eval(&b, direction, &again);
            assert_near(again / pdf, 1, 1e-6);
            sum += direction.y > 0.5 ? 1 / pdf : 0;
        }
        assert_near(sum / count, PI, 0.02);
    }
}

/* ---- the rest ---- */

static void holes_of_an_alpha_mask_let_light_through(void **state)
{
    world *w = *state;
    uint32_t masked;
    ex_texture *texture;
    need_embree();
    masked = add_material(w, 0.5f, 0);
    w->scene.textures = more(NULL, 0, sizeof *w->scene.textures);
    w->scene.texture_count = 1;
    texture = w->scene.textures;
    texture->width = 2;
    texture->height = 1;
    texture->rgba = calloc(8, 1);
    assert_non_null(texture->rgba);
    texture->rgba[7] = 255;                    /* a hole where u < 0.5 */
    w->scene.materials[masked].base_texture = 0;
    w->scene.materials[masked].alpha_cutoff = 0.5f;
    add_quad(w, rf_make(-1, 1, -1), rf_make(2, 0, 0), rf_make(0, 0, 2), masked);
    add_light_kind(w, EX_LIGHT_SUN, zero(), up(), 1);
    assert_near(irradiance(w, rf_make(-0.5, 0, 0), up()), 1, 1e-6);
    assert_near(irradiance(w, rf_make(0.5, 0, 0), up()), 0, 0);
}

static void any_number_of_threads_makes_the_same_picture(void **state)
{
    enum { COUNT = 200 };
    static ex_pixel pixels[COUNT];
    static float one[3 * COUNT], two[3 * COUNT];
    world *w = *state;
    double noise;
    need_embree();
    add_room(w, zero(), 1, add_material(w, 0.5f, 1));
    set(w, "bounces=3");
    w->samples = 7;
    for (int i = 0; i < COUNT; i++)
        pixels[i] = pixel_at(rf_make(0.009 * i - 0.9, -1, 0.1), up(), 0.5f);
    shade(w, pixels, COUNT, one);
    noise = w->noise;
    w->threads = 3;
    shade(w, pixels, COUNT, two);
    assert_memory_equal(one, two, sizeof one);
    assert_true(noise > 0 && w->noise >= noise && w->noise <= noise);
    w->seed = 1;
    shade(w, pixels, COUNT, two);
    assert_memory_not_equal(one, two, sizeof one);
}

/* The noise that it reports is the error that it makes. */
static void noise_is_the_error(void **state)
{
    enum { COUNT = 2000 };
    static ex_pixel pixels[COUNT];
    static float out[3 * COUNT];
    world *w = *state;
    ex_light *light;
    double squares = 0;
    need_embree();
    light = add_light_kind(w, EX_LIGHT_RECT, rf_make(-0.5, 1, -0.5), zero(), 1);
    light->u[0] = light->v[2] = 1;
    add_quad(w, rf_make(0, -5, 0), rf_make(0.1, 0, 0), rf_make(0, 0, 0.1), add_material(w, 0.5f, 0));
    for (int i = 0; i < COUNT; i++)
        pixels[i] = pixel_at(zero(), up(), 1);
    w->samples = 64;
    shade(w, pixels, COUNT, out);
    for (int i = 0; i < COUNT; i++)
        squares += pow(PI * (double)out[3 * i] / 0.752275 - 1, 2);
    print_message("noise %.5f, error %.5f\n", w->noise, sqrt(squares / COUNT));
    assert_near(w->noise / sqrt(squares / COUNT), 1, 0.1);
}

#define TEST(f) cmocka_unit_test_setup_teardown(f, make_world, free_world)

int main(void)
{
    static const struct CMUnitTest tests[] = {
        TEST(a_plane_under_a_uniform_sky_reflects_its_albedo), TEST(one_texel_of_a_sky_lights_from_its_side),
        TEST(a_wall_hides_half_of_the_sky_and_a_roof_the_rest),
        TEST(suns_spots_and_points_light_as_in_closed_form), TEST(a_sheet_hides_the_sun_below_it),
        TEST(a_rectangle_lights_as_in_closed_form), TEST(a_disc_lights_as_in_closed_form),
        TEST(a_sphere_lights_as_in_closed_form), TEST(a_line_lights_as_in_closed_form),
        TEST(two_lights_sum_whichever_is_chosen), TEST(an_emissive_square_lights_as_a_rectangle),
        TEST(a_form_factor_halves_behind_half_a_sheet), TEST(squares_that_share_an_edge_have_the_known_form_factor),
        TEST(bounces_in_a_furnace_halve_what_is_missing), TEST(no_light_enters_a_sealed_box),
        TEST(bounced_light_is_hidden_unless_the_setting_says_no), TEST(metal_rough_reflects_its_share_of_a_white_sky),
        TEST(samples_of_the_brdf_follow_their_density), TEST(holes_of_an_alpha_mask_let_light_through),
        TEST(any_number_of_threads_makes_the_same_picture), TEST(noise_is_the_error)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
