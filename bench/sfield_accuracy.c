/* sfield_accuracy.c - the shadow of a sphere above a plane, and of a chess piece on it, against rays under the same
   sky, and where the error comes from, each part as RMSE by the mean of what rays say:

   projection   visibility by rays, but in the basis (harmonics: cut to 4 bands, under a sky cut alike; wavelets:
                texels)
   sampling     visibility of an uncompressed field instead: interpolated between its samples (harmonics: and 8 bits)
   compression  wavelets: of the field with few of them instead
   products     sfield_shade instead: with harmonics each product is cut to 4 bands

   The sky has one lobe, cos^4 for harmonics and cos^64 for wavelets. Points under the middle of the occluder are
   left out. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { ACROSS = 20, SIDE = 32, TEXELS = 6 * SIDE * SIDE, COEFS = 16, SKY = 128 };

static const float lobe[3] = { 0.48f, 0.64f, 0.6f };

typedef struct plane {
    const sfield_mesh *mesh;
    int           haar, rays;
    sfield_field *whole, *field;        /* wavelets: all kept, few kept; harmonics: twice the same */
    sfield_scene *scene;
    float         sky[3 * COEFS];
    bn_rays      *embree;
    float        *from, *to, *lit, *texel;
    float         center[3], radius;
} plane;

static double sky_at(const plane *s, const float w[3])
{
    float c = w[0] * lobe[0] + w[1] * lobe[1] + w[2] * lobe[2];
    return 0.2 + (c > 0 ? 3 * pow((double)c, s->haar ? 64 : 4) : 0);
}

static int set_sky(plane *s)
{
    float *map = malloc(3 * SKY * SKY / 2 * sizeof *map);
    sfield_result result = SFIELD_ERR_ALLOC;
    for (int i = 0; map && i < SKY * SKY / 2; i++) {
        float w[3];
        ex_sky_texel_direction(SKY, SKY / 2, (float)(i % SKY) + 0.5f, (float)(i / SKY) + 0.5f, w);
        for (int k = 0; k < 3; k++)
            map[3 * i + k] = (float)sky_at(s, w);
    }
    if (map)
        result = sfield_scene_environment(s->scene, map, SKY, SKY / 2, NULL);
    free(map);
    if (result == SFIELD_OK && !s->haar)
        result = sfield_scene_sky(s->scene, s->sky);
    return result == SFIELD_OK ? 0 : -1;
}

static int open_plane(plane *s, const bn_options *options, double *seconds)
{
    sfield_desc d = bn_sfield_desc(options);
    sfield_scene_desc scene;
    sfield_entity e = upright;
    sfield_info info;
    double start = ex_seconds();
    memset(&scene, 0, sizeof scene);
    d.basis = scene.basis = s->haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    scene.reach = 20;
    d.position_side = options->full ? 16 : 8;
    d.shell_count = options->full ? 0 : 12;
    d.outer = 8;
    d.keep = 1;
    if (sfield_build(&d, s->mesh, &s->whole, NULL) != SFIELD_OK)
        return -1;
    d.keep = 0.02f;
    if (s->haar && sfield_build(&d, s->mesh, &s->field, NULL) != SFIELD_OK)
        return -1;
    *seconds = ex_seconds() - start;
    sfield_get_info(s->whole, &info);
    memcpy(s->center, info.center, sizeof s->center);
    s->radius = info.radius;
    e.occlusion = s->haar ? s->field : s->whole;
    return sfield_scene_create(&scene, &s->scene) == SFIELD_OK && sfield_scene_entities(s->scene, &e, 1) == SFIELD_OK &&
           set_sky(s) == 0 ? 0 : -1;
}

/* Irradiance of an upward point from visibility in the basis: without a truncated product. */
static double integrate(const plane *s, const float *visible)
{
    double sum = 0;
    for (uint32_t i = 0; i < TEXELS; i++) {
        float w[3];
        double area = (double)sfield_cube_texel(SIDE, i, w), l = 0, v = 0,
               d[3] = { (double)w[0], (double)w[1], (double)w[2] }, y[COEFS];
        if (w[1] <= 0)
            continue;
        if (s->haar) {
            l = sky_at(s, w);
            v = (double)visible[i];
        } else {
            sfield_sh_basis(4, d, y);
            for (int k = 0; k < COEFS; k++) {
                l += (double)s->sky[k] * y[k];
                v += (double)visible[k] * y[k];
            }
        }
        sum += l * v * d[1] * area;
    }
    return sum;
}

/* By rays: irradiance under the sky as the method sees it, and visibility on texels or in harmonics. */
static double trace(const plane *s, const float p[3], float *visible)
{
    static const float up[3] = { 0, 1, 0 };
    double sum = 0, w[3], y[COEFS];
    float hit[TEXELS] = { 0 }, all[TEXELS] = { 0 };
    for (int i = 0; i < s->rays; i++) {
        float dir[3];
        bn_cap_direction(up, 2, i, s->rays, dir);
        for (int k = 0; k < 3; k++) {
            s->from[3 * i + k] = p[k];
            s->to[3 * i + k] = p[k] + 100 * s->radius * dir[k];
        }
    }
    bn_rays_segments(s->embree, s->from, s->to, (size_t)s->rays, s->lit);
    memset(visible, 0, (s->haar ? TEXELS : COEFS) * sizeof *visible);
    for (int i = 0; i < s->rays; i++) {
        float dir[3];
        double l = 0;
        bn_cap_direction(up, 2, i, s->rays, dir);
        for (int k = 0; k < 3; k++)
            w[k] = (double)dir[k];
        sfield_sh_basis(4, w, y);
        for (int k = 0; k < COEFS && !s->haar; k++) {
            l += (double)s->sky[k] * y[k];
            visible[k] += (float)((double)s->lit[i] * y[k] * 12.566370614 / s->rays);
        }
        if (s->haar) {
            uint32_t texel = sfield_cube_find(SIDE, dir);
            l = sky_at(s, dir);
            hit[texel] += s->lit[i];
            all[texel]++;
        }
        if (dir[1] > 0)
            sum += l * (double)s->lit[i] * (double)dir[1] * 12.566370614 / s->rays;
    }
    for (int i = 0; i < TEXELS && s->haar; i++)
        visible[i] = all[i] > 0 ? hit[i] / all[i] : 1;
    return sum;
}

typedef struct split { bn_error total, projection, sampling, compression, products; double least, most; } split;

/* Each part is the change from one stage to the next: its truth is the stage before, its scale what rays say. */
static void add_part(bn_error *e, double after, double before, double truth)
{
    bn_error_add(e, truth + after - before, truth);
}

static int check_point(const plane *s, const float p[3], split *out)
{
    static const float up[3] = { 0, 1, 0 };
    sfield_points set;
    float rgb[3];
    double truth, projected, sampled, compressed;
    memset(&set, 0, sizeof set);
    truth = trace(s, p, s->texel);
    projected = integrate(s, s->texel);
    if (sfield_query(s->whole, 1, p, 0, s->texel) != SFIELD_OK)
        return -1;
    sampled = compressed = integrate(s, s->texel);
    if (s->haar) {
        if (sfield_query(s->field, 1, p, 0, s->texel) != SFIELD_OK)
            return -1;
        compressed = integrate(s, s->texel);
    }
    set.count = 1;
    set.positions = p;
    set.normals = up;
    set.entity = 0;
    set.rgb = rgb;
    if (sfield_shade(s->scene, &set, 1, NULL) != SFIELD_OK)
        return -1;
    out->least = out->total.count ? fmin(out->least, truth) : truth;
    out->most = fmax(out->most, truth);
    bn_error_add(&out->total, 3.14159265358979 * (double)rgb[1], truth);
    add_part(&out->projection, projected, truth, truth);
    add_part(&out->sampling, sampled, projected, truth);
    add_part(&out->compression, compressed, sampled, truth);
    add_part(&out->products, 3.14159265358979 * (double)rgb[1], compressed, truth);
    return 0;
}

static void report(const plane *s, const bn_options *options, const char *occluder, double seconds, const split *e)
{
    bn_begin(options, "sfield_accuracy", options->threads, bn_sfield_simd());
    bn_text("occluder", occluder);
    bn_text("basis", s->haar ? "wavelets" : "harmonics");
    bn_integer("points", e->total.count);
    bn_integer("rays", (uint64_t)s->rays);
    bn_integer("memory_bytes", sfield_bytes(s->haar ? s->field : s->whole));
    bn_number("build_seconds", seconds);
    bn_number("deepest", e->least / e->most);
    bn_number("rmse", bn_error_relative(&e->total));
    bn_number("projection", bn_error_relative(&e->projection));
    bn_number("sampling", bn_error_relative(&e->sampling));
    bn_number("compression", s->haar ? bn_error_relative(&e->compression) : (double)NAN);
    bn_number("products", bn_error_relative(&e->products));
    bn_end(options);
}

static int measure(const bn_options *options, const char *occluder, const sfield_mesh *mesh, int haar)
{
    bn_model model = { .positions = NULL };
    plane s;
    split e;
    double seconds = 0;
    int result;
    memset(&s, 0, sizeof s);
    memset(&e, 0, sizeof e);
    s.mesh = mesh;
    s.haar = haar;
    s.rays = options->full ? 65536 : 16384;
    model.positions = (float *)(size_t)mesh->positions;         /* only read */
    model.indices = (uint32_t *)(size_t)mesh->indices;
    model.vertices = mesh->vertex_count;
    model.triangles = mesh->index_count / 3;
    s.from = malloc(7 * (size_t)s.rays * sizeof *s.from);
    s.texel = malloc(3 * TEXELS * sizeof *s.texel);
    s.embree = bn_rays_create(&model, options->threads);
    result = s.from && s.texel ? open_plane(&s, options, &seconds) : -1;
    for (int i = 0; i < ACROSS * ACROSS && result == 0 && s.embree; i++) {
        float x = ((float)(i % ACROSS) + 0.5f) / ACROSS * 2 - 1, z = ((float)(i / ACROSS) + 0.5f) / ACROSS * 2 - 1;
        float p[3] = { s.center[0] + 3 * s.radius * x, 0, s.center[2] + 3 * s.radius * z };
        s.to = s.from + 3 * s.rays;
        s.lit = s.to + 3 * s.rays;
        if (9 * (x * x + z * z) > 0.25f)
            result = check_point(&s, p, &e);
    }
    if (result == 0)
        report(&s, options, occluder, seconds, &e);
    bn_rays_free(s.embree);
    sfield_scene_free(s.scene);
    sfield_free(s.whole);
    sfield_free(s.field);
    free(s.from);
    free(s.texel);
    return result == 0 ? 0 : bn_failed("sfield_accuracy", "out of memory");
}

/* Unit sphere of 64 x 32 quads, its lowest point 0.3 above the plane y = 0. */
static void make_sphere(float *p, uint32_t *indices)
{
    for (int i = 0; i < 65 * 33; i++) {
        double a = 3.14159265358979 * (i / 65) / 32, b = 3.14159265358979 * (i % 65) / 32;
        p[3 * i] = (float)(sin(a) * cos(b));
        p[3 * i + 1] = (float)(1.3 + cos(a));
        p[3 * i + 2] = (float)(-sin(a) * sin(b));
    }
    for (uint32_t i = 0; i < 64 * 32; i++) {
        uint32_t a = i / 64 * 65 + i % 64;
        const uint32_t quad[6] = { a, a + 65, a + 66, a, a + 66, a + 1 };
        memcpy(indices + 6 * i, quad, sizeof quad);
    }
}

int bn_sfield_accuracy(const bn_options *options)
{
    static float positions[3 * 65 * 33];
    static uint32_t indices[6 * 64 * 32];
    const sfield_mesh sphere = { positions, 65 * 33, 0, indices, 6 * 64 * 32, NULL, NULL, NULL };
    char error[EX_ERROR_SIZE];
    ex_scene chess;
    int result = 0;
    if (ex_scene_builtin(&chess, "chess", 0, error) != 0)
        return bn_failed("chess", error);
    make_sphere(positions, indices);
    for (int haar = 0; haar < 2 && result == 0; haar++) {
        const ex_mesh *m = &chess.meshes[3];
        const sfield_mesh knight = { m->positions, m->vertex_count, 0, m->indices,
                                    3 * (size_t)m->triangle_count, NULL, NULL, NULL };
        result =
            measure(options, "sphere", &sphere, haar) != 0 || measure(options, "knight", &knight, haar) != 0 ? -1 : 0;
    }
    ex_scene_free(&chess);
    return result;
}
