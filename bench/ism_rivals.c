/* ism_rivals.c - what the paper compares its method with (Ritschel et al. 2011, figures 1, 5 and 7), each with as many
   VPLs as take the processor time of ism.h's defaults: imperfect shadow maps of 2008, bidirectional choice alone,
   adaptive surfels alone, both, and maps without imperfection, which a rasteriser draws. */
#define _POSIX_C_SOURCE 200809L
#include "ism_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { W = 80, H = 45, FACE = 32, FACES = 5, SURFELS = 8192, FIRST = 1024, FIRST_DRAWN = 32, MOST = 16384,
       RUNS = 4 };

typedef struct rival {
    const char    *name;
    ism_importance importance;
    ism_spread     spread;
    int            drawn;              /* maps by the rasteriser */
    int            ours;               /* with windows, and near points by near_mode's default */
} rival;

static const rival rivals[] = {
    { "ism.h", ISM_IMPORTANCE_DEFAULT, ISM_SPREAD_DEFAULT, 0, 1 },
    { "flux, surfels by area (2008)", ISM_IMPORTANCE_FLUX, ISM_SPREAD_AREA, 0, 0 },
    { "bidirectional choice alone", ISM_IMPORTANCE_GUIDED_MEAN, ISM_SPREAD_AREA, 0, 0 },
    { "adaptive surfels alone", ISM_IMPORTANCE_FLUX, ISM_SPREAD_VIEW_8, 0, 0 },
    { "both (2011)", ISM_IMPORTANCE_GUIDED_MEAN, ISM_SPREAD_VIEW_8, 0, 0 },
    { "bidirectional choice, drawn maps", ISM_IMPORTANCE_GUIDED_MEAN, ISM_SPREAD_AREA, 1, 0 },
};

/* ---- maps that a rasteriser draws: the half of a cube over each VPL ---- */

typedef struct drawn_map { float axes[3][3]; float *depths; } drawn_map;     /* axes[2]: the normal */

typedef struct drawn_maps {
    drawn_map *maps;
    size_t     count;
    float     *depths;
    const ism_vpl *vpls;
} drawn_maps;

static float dot3(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void face_axes(const drawn_map *m, int face, float right[3], float up[3], float forward[3])
{
    const int side = (face - 1) / 2;                /* of faces 1 to 4: along axis 0 or 1 */
    const float sign = face % 2 ? 1.0f : -1.0f;
    for (int k = 0; k < 3; k++) {
        forward[k] = face ? sign * m->axes[side][k] : m->axes[2][k];
        up[k] = face ? m->axes[2][k] : m->axes[1][k];
    }
    for (int k = 0; k < 3; k++)
        right[k] = forward[(k + 1) % 3] * up[(k + 2) % 3] - forward[(k + 2) % 3] * up[(k + 1) % 3];
}

static void make_axes(drawn_map *m, const float *normal)
{
    const float other[3] = { fabsf(normal[0]) < 0.5f, fabsf(normal[0]) >= 0.5f, 0 };
    float length;
    memcpy(m->axes[2], normal, sizeof m->axes[2]);
    for (int k = 0; k < 3; k++)
        m->axes[0][k] = other[(k + 1) % 3] * normal[(k + 2) % 3] - other[(k + 2) % 3] * normal[(k + 1) % 3];
    length = sqrtf(dot3(m->axes[0], m->axes[0]));
    for (int k = 0; k < 3; k++)
        m->axes[0][k] /= length;
    for (int k = 0; k < 3; k++)
        m->axes[1][k] = normal[(k + 1) % 3] * m->axes[0][(k + 2) % 3] - normal[(k + 2) % 3] * m->axes[0][(k + 1) % 3];
}

/* Distances from the VPL, a little above its surface, to what each texel's middle shows. */
static int draw_face(const bn_scene *s, const bn_options *options, const ex_clusters *clusters, const ism_vpl *v,
                     const drawn_map *m, int face)
{
    float right[3], up[3], forward[3], *depths = m->depths + (size_t)face * FACE * FACE;
    ex_scene scene = s->scene;
    char error[EX_ERROR_SIZE];
    ex_gbuffer g;
    face_axes(m, face, right, up, forward);
    for (int k = 0; k < 3; k++) {
        scene.camera.eye[k] = v->position[k] + 1e-4f * s->job.radius * v->normal[k];
        scene.camera.target[k] = scene.camera.eye[k] + s->job.radius * forward[k];
        scene.camera.up[k] = up[k];
    }
    scene.camera.fovy = 1.57079633f;
    if (ex_gbuffer_render_clusters(&g, &scene, clusters, FACE, FACE, options->threads, error) != 0)
        return bn_failed(s->name, error);
    for (size_t i = 0; i < (size_t)FACE * FACE; i++) {
        float d[3];
        for (int k = 0; k < 3; k++)
            d[k] = g.pixels[i].position[k] - v->position[k];
        depths[i] = g.pixels[i].object == UINT32_MAX ? HUGE_VALF : sqrtf(dot3(d, d));
    }
    ex_gbuffer_free(&g);
    return 0;
}

static void free_maps(drawn_maps *d)
{
    free(d->maps);
    free(d->depths);
    memset(d, 0, sizeof *d);
}

static int draw_maps(drawn_maps *d, const bn_scene *s, const bn_options *options, const ism_maps *from)
{
    ex_clusters *clusters = ex_clusters_build(&s->scene);
    int result = 0;
    d->vpls = ism_vpls(from, &d->count);
    d->maps = calloc(d->count + 1, sizeof *d->maps);
    d->depths = malloc((d->count * FACES * FACE * FACE + 1) * sizeof *d->depths);
    if (!clusters || !d->maps || !d->depths)
        result = bn_failed(s->name, "out of memory");
    for (size_t i = 0; i < d->count && result == 0; i++) {
        d->maps[i].depths = d->depths + i * FACES * FACE * FACE;
        make_axes(&d->maps[i], d->vpls[i].normal);
        for (int face = 0; face < FACES && result == 0; face++)
            result = draw_face(s, options, clusters, &d->vpls[i], &d->maps[i], face);
    }
    ex_clusters_free(clusters);
    return result;
}

/* Depths are compared on the receiver's tangent plane at the middle of its texel, as ism.h does. */
static float map_sees(const drawn_map *m, const float *from, const float *position, const float *normal)
{
    float right[3], up[3], forward[3], l[3], ray[3], distance, along, most = 0, x, y, to_plane;
    int face = 0, column, row;
    for (int k = 0; k < 3; k++)
        l[k] = position[k] - from[k];
    distance = sqrtf(dot3(l, l));
    for (int f = 0; f < FACES; f++) {
        face_axes(m, f, right, up, forward);
        if (dot3(forward, l) > most) {
            most = dot3(forward, l);
            face = f;
        }
    }
    if (!(dot3(m->axes[2], l) > 0))
        return 0;
    face_axes(m, face, right, up, forward);
    x = 0.5f + 0.5f * dot3(right, l) / most;
    y = 0.5f - 0.5f * dot3(up, l) / most;
    column = (int)fminf(x * FACE, FACE - 1);
    row = (int)fminf(y * FACE, FACE - 1);
    for (int k = 0; k < 3; k++)
        ray[k] = forward[k] + (2 * ((float)column + 0.5f) / FACE - 1) * right[k] +
                 (1 - 2 * ((float)row + 0.5f) / FACE) * up[k];
    along = dot3(normal, ray) / sqrtf(dot3(ray, ray));
    to_plane = fabsf(along) > 0 ? dot3(normal, l) / along : distance;
    if (to_plane > 0.5f * distance && to_plane < 2 * distance)
        distance = to_plane;
    return (float)(0.98f * distance <= m->depths[((size_t)face * FACE + (size_t)row) * FACE + (size_t)column]);
}

static void drawn_visibility(void *user, const float *position, const float *normal, const uint32_t *numbers,
                             size_t count, float *visible)
{
    const drawn_maps *d = user;
    for (size_t i = 0; i < count; i++)
        visible[i] = map_sees(&d->maps[numbers[i]], d->vpls[numbers[i]].position, position, normal);
}

/* ---- equal time ---- */

static double processor_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A picture by so many VPLs, and the processor's seconds from the choice to the light. */
static int picture_by(const bn_scene *s, const bn_options *options, const rival *r, uint32_t vpls, float *out,
                      double *seconds)
{
    const double start = processor_seconds();
    ism_desc d = bn_ism_desc(options, vpls, SURFELS);
    ism_frame frame = bn_ism_frame(s);
    ism_shading shading = { 0 };
    drawn_maps drawn;
    ism_maps *maps;
    ism_result result;
    int status = 0;
    memset(&drawn, 0, sizeof drawn);
    d.importance = r->importance;
    d.spread = r->spread;
    d.window_rim = r->ours ? 0 : -1;
    d.near_point_count = r->ours ? 0 : -1;
    result = ism_create(&d, &maps);
    if (result != ISM_OK)
        return bn_failed(s->name, ism_result_text(result));
    result = ism_choose(maps, &frame);
    if (result == ISM_OK && r->drawn) {
        status = draw_maps(&drawn, s, options, maps);
        shading.visible_fn = drawn_visibility;
        shading.visible_user = &drawn;
    } else if (result == ISM_OK) {
        result = ism_build(maps, &frame);
    }
    if (result == ISM_OK && status == 0)
        result = ism_shade(maps, &s->view, &shading, out, NULL);
    free_maps(&drawn);
    ism_free(maps);
    *seconds = processor_seconds() - start;
    return result != ISM_OK ? bn_failed(s->name, ism_result_text(result)) : status;
}

static void report(const bn_options *options, const char *scene, const rival *r, uint32_t vpls, double seconds,
                   const bn_picture_error *e, double noise)
{
    bn_begin(options, "ism_rivals", options->threads, bn_ism_simd());
    bn_text("scene", scene);
    bn_text("way", r->name);
    bn_integer("vpl_count", vpls);
    bn_number("cpu_seconds", seconds);
    bn_picture_error_print(e);
    bn_number("reference_noise", noise);
    bn_end(options);
}

/* Each run tells what a VPL costs; the last has as many as cost what those of ism.h's defaults do, within a tenth. */
static int rivals_of(const bn_scene *s, const bn_options *options, const char *name, const float *truth, double noise)
{
    static float out[3 * W * H];
    double budget = 0;
    int result = 0;
    for (size_t i = 0; i < sizeof rivals / sizeof rivals[0] && result == 0; i++) {
        const rival *r = &rivals[i];
        uint32_t vpls = r->drawn ? FIRST_DRAWN : FIRST;
        bn_picture_error e;
        double seconds = 0;
        result = picture_by(s, options, r, vpls, out, &seconds);
        if (i == 0)
            budget = seconds;
        for (int run = 0; run < RUNS && result == 0 && fabs(seconds / budget - 1) > 0.1; run++) {
            double wanted = vpls * budget / seconds;
            vpls = wanted < 16 ? 16 : wanted > MOST ? MOST : (uint32_t)wanted;
            result = picture_by(s, options, r, vpls, out, &seconds);
        }
        if (result == 0)
            result = bn_picture_error_of(out, truth, (size_t)W * H, &e);
        if (result == 0)
            report(options, name, r, vpls, seconds, &e, noise);
    }
    return result;
}

static int reference_of(const bn_options *options, const char *folder, const char *path, ex_image *out, double *noise)
{
    char program[1024], picture[128], json[128], error[EX_ERROR_SIZE];
    const char *arguments[] = { program, "--technique", "reference", "--scene", path, "--size", "80x45",
                                "--samples", options->full ? "16384" : "4096", "--set", "only=indirect",
                                "--set", "bounces=1", "--out", picture, "--json", json, NULL };
    int result;
    bn_program(options, "render", program);
    snprintf(picture, sizeof picture, "%s/reference.pfm", folder);
    snprintf(json, sizeof json, "%s/reference.json", folder);
    result = bn_start(program, arguments, NULL);
    *noise = bn_read_number(json, "noise");
    if (result != 0 || ex_image_read_pfm(out, picture, error) != 0)
        result = bn_failed(path, "render --technique reference failed");
    remove(picture);
    remove(json);
    return result;
}

int bn_ism_rivals(const bn_options *options)
{
    static const char *const scenes[] = { "builtin:corridor", "builtin:atrium" };
    char folder[64] = "/tmp/dapple-bench-XXXXXX";
    int result = 0;
    if (!bn_rays_version())
        return bn_failed("ism_rivals", "the reference needs Embree: apt-get install libembree-dev");
    if (!mkdtemp(folder))
        return bn_failed("/tmp", "no room for temporary files");
    for (int i = 0; i < (options->model ? 1 : 2) && result == 0; i++) {
        const char *path = options->model ? options->model : scenes[i];
        ex_image truth = { 0, 0, NULL };
        double noise = 0;
        bn_scene s;
        if (bn_ism_open(&s, options, path, W, H, 512, 64) != 0) {
            result = -1;
            break;
        }
        result = reference_of(options, folder, path, &truth, &noise);
        if (result == 0)
            result = rivals_of(&s, options, path, truth.rgb, noise);
        ex_image_free(&truth);
        bn_ism_close(&s);
    }
    remove(folder);
    return result;
}
