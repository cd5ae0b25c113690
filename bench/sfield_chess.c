/* sfield_chess.c - the paper's chess match: 32 pieces of six meshes and the board, four lamps, 30,000 vertices.
   Frames a second with pieces and lamps moving, and with a lazy cache while only lamps move, or one piece alone;
   errors at some of the vertices, of those that can be seen, against rays: under the same band-limited lamps, and
   under the lamps as they are; and how much of the first is that of the products, of functions that rays project, as
   fields without any error would be. Fields have 8 x 8 positions a face, so that a run takes seconds, but the board's
   16 x 16: it is a slab, whose positions above and below it must not lie far apart for what stands on it. --full
   builds the paper's 16 x 16, and checks more vertices by more rays. Occluders count to the outermost shell, 8 r, or
   to 2.5 r: faster, with a larger error. At 2.5 r the same once more with Phong's lobe, of exponent 30, and with
   glTF's metal-rough BRDF, of roughness 0.5, for an eye at rest. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { OBJECTS = 33, MESHES = 7, LAMPS = 4, COLORS = 3, BOARD = 6000, PIECE = 750 };

static const float lamp_radius = 0.03f, lift = 2e-4f;
static const float colors[COLORS][3] = { { 60, 50, 40 }, { 50, 20, 20 }, { 20, 30, 60 } };

typedef struct chess {
    ex_scene       scene;
    sfield_scene  *field_scene;
    sfield_field  *occlusion[MESHES], *self[MESHES], *source[COLORS];
    sfield_entity  entities[OBJECTS + LAMPS];
    bn_points      points[MESHES];
    sfield_points  sets[OBJECTS];
    sfield_cache  *cache[OBJECTS];
    float         *rgb, *gloss, *to_eye, reach;     /* 0: to the outermost shell */
    size_t         bytes, vertices;
    double         build_seconds;
    int            frames, checked, rays;
} chess;

static int build_mesh(chess *c, const sfield_desc *d, uint32_t m)
{
    const ex_mesh *mesh = &c->scene.meshes[m];
    const sfield_mesh input = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                                3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
    bn_points *p = &c->points[m];
    sfield_points receivers;
    if (bn_points_spread(p, mesh, m ? PIECE : BOARD) != 0)
        return -1;
    memset(&receivers, 0, sizeof receivers);
    receivers.count = p->count;
    receivers.positions = p->positions;
    receivers.normals = p->normals;
    if (sfield_build(d, &input, &c->occlusion[m], NULL) != SFIELD_OK ||
        sfield_build_self(d, &input, &receivers, lift, &c->self[m], NULL) != SFIELD_OK)
        return -1;
    c->bytes += sfield_bytes(c->occlusion[m]) + sfield_bytes(c->self[m]);
    return 0;
}

static int build(chess *c, const bn_options *options)
{
    sfield_desc d = bn_sfield_desc(options);
    double start = ex_seconds();
    d.position_side = options->full ? 16 : 8;
    for (uint32_t m = 0; m < MESHES; m++) {
        sfield_desc own = d;
        own.position_side = m || options->full ? d.position_side : 16;
        if (build_mesh(c, &own, m) != 0)
            return -1;
    }
    for (int i = 0; i < COLORS; i++) {
        sfield_emitter e;
        memset(&e, 0, sizeof e);
        e.radius = lamp_radius;
        memcpy(e.radiance, colors[i], sizeof e.radiance);
        if (sfield_build_emitter(&d, &e, &c->source[i], NULL) != SFIELD_OK)
            return -1;
        c->bytes += sfield_bytes(c->source[i]);
    }
    c->build_seconds = ex_seconds() - start;
    return 0;
}

static int place(chess *c, float pieces, float lamps)
{
    char error[EX_ERROR_SIZE];
    if (ex_scene_set_time(&c->scene, pieces, error) != 0)
        return -1;
    for (uint32_t i = 0; i < OBJECTS; i++) {
        c->entities[i] = upright;
        c->entities[i].occlusion = c->occlusion[c->scene.objects[i].mesh];
        memcpy(c->entities[i].transform, c->scene.objects[i].transform, sizeof c->entities[i].transform);
    }
    for (int i = 0; i < LAMPS; i++) {
        sfield_entity *e = &c->entities[OBJECTS + i];
        float angle = 0.7f * lamps + 1.5707963f * (float)i;
        *e = upright;
        e->source = c->source[i % COLORS];
        e->transform[12] = 0.26f * cosf(angle);
        e->transform[13] = 0.22f + 0.02f * (float)i;
        e->transform[14] = 0.26f * sinf(angle);
    }
    return sfield_scene_entities(c->field_scene, c->entities, OBJECTS + LAMPS) == SFIELD_OK ? 0 : -1;
}

/* What the surfaces are. */
typedef enum look { DULL, PHONG, METAL_ROUGH, LOOKS } look;

static const char *const look_names[LOOKS] = { "none", "phong", "metal_rough" };

/* Gives all sets BRDFs, of an eye that looks down on the board where the pieces stand in the first frame. */
static void polish(chess *c, look of)
{
    static const float exponent = 30, material[5] = { 0.9f, 0.7f, 0.4f, 0.5f, 0.5f }, eye[3] = { 0.3f, 0.4f, 0.5f };
    size_t at = 0;
    for (uint32_t o = 0; o < OBJECTS; o++) {
        sfield_points *p = &c->sets[o];
        for (size_t i = 0; i < p->count; i++) {
            float x[3], n[3], v[3], length;
            bn_points_world(&c->points[c->scene.objects[o].mesh], i, c->entities[o].transform, x, n);
            for (int k = 0; k < 3; k++)
                v[k] = eye[k] - x[k];
            length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            for (int k = 0; k < 3; k++)
                c->to_eye[3 * (at + i) + (size_t)k] = v[k] / length;
        }
        p->gloss = of == DULL ? NULL : c->gloss + 3 * at;
        p->to_eye = of == DULL ? NULL : c->to_eye + 3 * at;
        p->exponents = of == PHONG ? &exponent : NULL;
        p->materials = of == METAL_ROUGH ? material : NULL;
        at += p->count;
    }
}

/* A scene in which pieces hide up to so many of their radii, with empty caches. */
static int open_scene(chess *c, const bn_options *options, float reach)
{
    sfield_scene_desc d;
    memset(&d, 0, sizeof d);
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    d.reach = c->reach = reach;
    if (sfield_scene_create(&d, &c->field_scene) != SFIELD_OK)
        return -1;
    for (int i = 0; i < OBJECTS; i++)
        if (sfield_cache_create(c->field_scene, c->sets[i].count, LAMPS, &c->cache[i]) != SFIELD_OK)
            return -1;
    return 0;
}

static void close_scene(chess *c)
{
    sfield_scene_free(c->field_scene);
    c->field_scene = NULL;
    for (int i = 0; i < OBJECTS; i++) {
        sfield_cache_free(c->cache[i]);
        c->cache[i] = NULL;
    }
}

static int make_sets(chess *c)
{
    c->rgb = malloc(9 * (BOARD + 32 * PIECE) * sizeof *c->rgb);
    if (c->rgb) {
        c->gloss = c->rgb + 3 * (BOARD + 32 * PIECE);
        c->to_eye = c->gloss + 3 * (BOARD + 32 * PIECE);
    }
    for (uint32_t i = 0; c->rgb && i < OBJECTS; i++) {
        uint32_t m = c->scene.objects[i].mesh;
        sfield_points *p = &c->sets[i];
        p->count = c->points[m].count;
        p->positions = c->points[m].positions;
        p->normals = c->points[m].normals;
        p->entity = i + 1;
        p->self = c->self[m];
        p->rgb = c->rgb + 3 * c->vertices;
        c->vertices += p->count;
    }
    return c->rgb ? 0 : -1;
}

/* ---- by rays ---- */

typedef struct tracer {
    const chess    *c;
    bn_rays        *rays, *object[OBJECTS];     /* of all; of each alone */
    sfield_algebra *algebra;
    float          *from, *to, *lit;
} tracer;

/* Which of the directions in a cap about z are open from p as far as `reach`. */
static void trace(const tracer *t, const bn_rays *rays, const float *p, const float *n, const float *z, float cap,
                  float reach)
{
    for (int i = 0; i < t->c->rays; i++) {
        float w[3];
        bn_cap_direction(z, cap, i, t->c->rays, w);
        for (int k = 0; k < 3; k++) {
            t->from[3 * i + k] = p[k] + lift * n[k];
            t->to[3 * i + k] = t->from[3 * i + k] + reach * w[k];
        }
    }
    bn_rays_segments(rays, t->from, t->to, (size_t)t->c->rays, t->lit);
}

/* Adds a lamp's light by its own band-limited radiance at p, seen in all directions. */
static void add_limited(const tracer *t, int lamp, const float *p, const float *n, const float *z, float d,
                        double rgb[3])
{
    const sfield_entity *e = &t->c->entities[OBJECTS + lamp];
    float coefs[3 * 16], at[3];
    double w[3], y[16];
    for (int k = 0; k < 3; k++)
        at[k] = p[k] - e->transform[12 + k];     /* lamps do not turn: world and field differ by a shift */
    if (sfield_query(e->source, 1, at, 0, coefs) != SFIELD_OK)
        return;
    trace(t, t->rays, p, n, z, 2, d);
    for (int i = 0; i < t->c->rays; i++) {
        double cosine = 0;
        for (int k = 0; k < 3; k++) {
            w[k] = (double)((t->to[3 * i + k] - t->from[3 * i + k]) / d);
            cosine += w[k] * (double)n[k];
        }
        if (!(t->lit[i] > 0) || cosine <= 0)
            continue;
        sfield_sh_basis(4, w, y);
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 16; j++)
                rgb[k] += (double)coefs[16 * k + j] * y[j] * cosine * 4 / t->c->rays;
    }
}

/* The same by the lamp as it is: a uniform sphere. */
static void add_exact(const tracer *t, int lamp, const float *p, const float *n, const float *z, float d, double rgb[3])
{
    float cap = 1 - sqrtf(fmaxf(1 - lamp_radius * lamp_radius / (d * d), 0)), reach = d - lamp_radius;
    trace(t, t->rays, p, n, z, cap, reach);
    for (int i = 0; i < t->c->rays; i++) {
        double cosine = 0;
        for (int k = 0; k < 3; k++)
            cosine += (double)((t->to[3 * i + k] - t->from[3 * i + k]) / reach * n[k]);
        for (int k = 0; k < 3 && t->lit[i] > 0 && cosine > 0; k++)
            rgb[k] += (double)colors[lamp % COLORS][k] * cosine * 2 * (double)cap / t->c->rays;
    }
}

/* What rays see of one object, on its bands: of the own one what is open times the cosine, of another what it hides. */
static void project(const tracer *t, uint32_t object, int own, const float *p, const float *n, float coefs[16])
{
    const float reach = 2;
    double sum[16] = { 0 };
    trace(t, t->object[object], p, n, n, 2, reach);
    for (int i = 0; i < t->c->rays; i++) {
        double w[3], y[16], cosine = 0, value = 1;
        if ((t->lit[i] > 0) != own)
            continue;
        for (int k = 0; k < 3; k++) {
            w[k] = (double)((t->to[3 * i + k] - t->from[3 * i + k]) / reach);
            cosine += w[k] * (double)n[k];
        }
        if (own)
            value = fmax(cosine, 0);
        sfield_sh_basis(4, w, y);
        for (int k = 0; k < 16; k++)
            sum[k] += value * y[k];
    }
    for (int k = 0; k < 16; k++)
        coefs[k] = (float)(sum[k] * 4 * 3.14159265358979 / t->c->rays);
}

/* Occluders of a vertex from near to far, by the rules of the scene, and what each hides of it. */
typedef struct occluders { int count; float distance[OBJECTS], hides[OBJECTS][16]; } occluders;

static void find_occluders(const tracer *t, uint32_t set, const float *p, const float *n, occluders *out)
{
    const chess *c = t->c;
    out->count = 0;
    for (uint32_t o = 0; o < OBJECTS; o++) {
        const float *m = c->entities[o].transform;
        float scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]), d = 0, height = 0, reach, fade;
        sfield_info info;
        int at = out->count;
        sfield_get_info(c->entities[o].occlusion, &info);
        for (int k = 0; k < 3; k++) {
            float v = m[k] * info.center[0] + m[4 + k] * info.center[1] + m[8 + k] * info.center[2] + m[12 + k] - p[k];
            d += v * v;
            height += v * n[k];
        }
        d = sqrtf(d);
        reach = scale * info.radius * (c->reach > 0 ? c->reach : 8);     /* the default's outermost shell */
        if (o == set || d >= reach || height <= -scale * info.radius)
            continue;
        for (; at > 0 && out->distance[at - 1] > d; at--) {
            out->distance[at] = out->distance[at - 1];
            memcpy(out->hides[at], out->hides[at - 1], sizeof out->hides[at]);
        }
        out->count++;
        out->distance[at] = d;
        project(t, o, 0, p, n, out->hides[at]);
        fade = fminf(4 * (1 - d / reach), 1);
        for (int k = 0; k < 16; k++)
            out->hides[at][k] *= fade;
    }
}

/* The scene's sum over lamps by triple products, of functions that rays project. */
static void add_products(const tracer *t, uint32_t set, const float *p, const float *n, double rgb[3])
{
    occluders others;
    float own[16];
    find_occluders(t, set, p, n, &others);
    project(t, set, 1, p, n, own);
    for (int lamp = 0; lamp < LAMPS; lamp++) {
        const sfield_entity *e = &t->c->entities[OBJECTS + lamp];
        float at[3], d = 0, coefs[3 * 16], now[16], hidden[16];
        for (int k = 0; k < 3; k++) {
            at[k] = p[k] - e->transform[12 + k];
            d += at[k] * at[k];
        }
        if (sfield_query(e->source, 1, at, 0, coefs) != SFIELD_OK)
            return;
        memcpy(now, own, sizeof now);
        for (int i = 0; i < others.count && others.distance[i] < sqrtf(d); i++) {
            sfield_sh_product(t->algebra, 1, now, others.hides[i], hidden, 1);
            for (int k = 0; k < 16; k++)
                now[k] -= hidden[k];
        }
        for (int k = 0; k < 16; k++)
            for (int q = 0; q < 3; q++)
                rgb[q] += (double)(now[k] * coefs[16 * q + k]) / 3.14159265358979;
    }
}

/* Can p be seen from anywhere? Not where it lies inside another part of its mesh, or under a foot. */
static int is_seen(const tracer *t, const float *p, const float *n)
{
    float open = 0;
    trace(t, t->rays, p, n, n, 1, 2);
    for (int i = 0; i < t->c->rays; i++)
        open += t->lit[i];
    return open > 0;
}

typedef struct errors { bn_error limited, products, traced; } errors;

static void check_vertex(const tracer *t, size_t i, errors *out)
{
    const chess *c = t->c;
    uint32_t o = 0;
    float p[3], n[3];
    double sum[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
    for (; i >= c->sets[o].count; o++)
        i -= c->sets[o].count;
    bn_points_world(&c->points[c->scene.objects[o].mesh], i, c->entities[o].transform, p, n);
    if (!is_seen(t, p, n))
        return;
    for (int lamp = 0; lamp < LAMPS; lamp++) {
        const float *at = c->entities[OBJECTS + lamp].transform + 12;
        float z[3] = { at[0] - p[0], at[1] - p[1], at[2] - p[2] }, d = sqrtf(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
        for (int k = 0; k < 3; k++)
            z[k] /= d;
        add_limited(t, lamp, p, n, z, d, sum[0]);
        add_exact(t, lamp, p, n, z, d, sum[1]);
    }
    add_products(t, o, p, n, sum[2]);
    for (size_t k = 0; k < 3; k++) {
        bn_error_add(&out->limited, (double)c->sets[o].rgb[3 * i + k], sum[0][k]);
        bn_error_add(&out->products, sum[2][k], sum[0][k]);
        bn_error_add(&out->traced, (double)c->sets[o].rgb[3 * i + k], sum[1][k]);
    }
}

static bn_rays *rays_of(const chess *c, uint32_t first, uint32_t count)
{
    bn_model model = { .positions = NULL };
    ex_scene part = c->scene;
    bn_rays *rays;
    part.objects += first;
    rays = bn_model_flatten(&model, &part, count) == 0 ? bn_rays_create(&model, 1) : NULL;
    bn_model_free(&model);
    return rays;
}

static int check(const chess *c, errors *out)
{
    tracer t = { .c = c, .from = malloc(7 * (size_t)c->rays * sizeof(float)), .rays = rays_of(c, 0, OBJECTS) };
    int good = t.from && sfield_algebra_create(4, NULL, &t.algebra) == SFIELD_OK;
    for (uint32_t i = 0; t.rays && i < OBJECTS; i++) {
        t.object[i] = rays_of(c, i, 1);
        good = good && t.object[i];
    }
    for (int i = 0; good && t.rays && i < c->checked; i++) {
        t.to = t.from + 3 * c->rays;
        t.lit = t.to + 3 * c->rays;
        check_vertex(&t, (size_t)i * c->vertices / (size_t)c->checked, out);
    }
    for (int i = 0; i < OBJECTS; i++)
        bn_rays_free(t.object[i]);
    bn_rays_free(t.rays);
    sfield_algebra_free(t.algebra);
    free(t.from);
    return good ? 0 : -1;
}

/* ---- frames ---- */

static int shade(chess *c, float pieces, float lamps, sfield_scene_stats *stats)
{
    return place(c, pieces, lamps) == 0 && sfield_shade(c->field_scene, c->sets, OBJECTS, stats) == SFIELD_OK ? 0 : -1;
}

static int by_size(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* What moves from frame to frame. Without a cache all T are computed anew, whatever moves. */
typedef enum moving { ALL, LAMPS_ALONE, ONE_PIECE, MOVINGS } moving;

static const char *const moving_names[MOVINGS] = { "all", "lamps", "one_piece" };

static int measure(chess *c, const bn_options *options, moving what, look of)
{
    const int lazy = what != ALL;
    sfield_scene_stats stats;
    errors e;
    double *spent = malloc((size_t)c->frames * sizeof *spent), median;
    size_t bytes = c->bytes;
    for (int i = 0; i < OBJECTS; i++)
        c->sets[i].cache = lazy ? c->cache[i] : NULL;
    if (!spent || place(c, 1, 0) != 0)
        return -1;
    polish(c, of);
    if (shade(c, 1, 0, &stats) != 0)                 /* the first frame fills caches */
        return -1;
    for (int i = 0; i < OBJECTS && lazy; i++)
        bytes += sfield_cache_bytes(c->cache[i]);
    memset(&e, 0, sizeof e);
    if (!lazy && of == DULL && check(c, &e) != 0)
        return -1;
    for (int frame = 0; frame < c->frames; frame++) {
        double start = ex_seconds();
        const float time = (float)(frame + 1) / 30;
        if (shade(c, what == LAMPS_ALONE ? 1 : 1 + time, what == ONE_PIECE ? 0 : time, &stats) != 0)
            return -1;
        spent[frame] = ex_seconds() - start;
    }
    qsort(spent, (size_t)c->frames, sizeof *spent, by_size);
    median = spent[c->frames / 2];
    free(spent);
    bn_begin(options, "sfield_chess", options->threads, bn_sfield_simd());
    bn_integer("vertices", c->vertices);
    bn_integer("entities", OBJECTS);
    bn_integer("lights", LAMPS);
    bn_number("reach", (double)c->reach);
    bn_number("build_seconds", c->build_seconds);
    bn_number("fps", 1 / median);
    bn_integer("products", stats.products);
    bn_integer("reused", stats.reused);
    bn_integer("culled", stats.culled_far + stats.culled_horizon + stats.culled_hidden);
    bn_text("moving", moving_names[what]);
    bn_text("gloss", look_names[of]);
    bn_flag("lazy", lazy);
    bn_integer("memory_bytes", bytes);
    bn_integer("checked", e.limited.count / 3);
    bn_number("rmse_vs_bandlimited", bn_error_relative(&e.limited));
    bn_number("rmse_of_products", bn_error_relative(&e.products));
    bn_number("rmse_vs_traced", bn_error_relative(&e.traced));
    bn_end(options);
    return 0;
}

static void close_chess(chess *c)
{
    close_scene(c);
    for (int m = 0; m < MESHES; m++) {
        sfield_free(c->occlusion[m]);
        sfield_free(c->self[m]);
        bn_points_free(&c->points[m]);
    }
    for (int i = 0; i < COLORS; i++)
        sfield_free(c->source[i]);
    ex_scene_free(&c->scene);
    free(c->rgb);
    free(c);
}

int bn_sfield_chess(const bn_options *options)
{
    static const float reaches[] = { 0, 2.5f };     /* all that fields have; a third of it */
    chess *c = calloc(1, sizeof *c);
    char error[EX_ERROR_SIZE] = "out of memory";
    int result = c ? ex_scene_builtin(&c->scene, "chess", 0, error) : -1;
    if (result == 0) {
        c->frames = options->full ? 61 : 15;
        c->checked = options->full ? 1000 : 250;
        c->rays = options->full ? 8192 : 2048;
        result = build(c, options) != 0 || make_sets(c) != 0 ? -1 : 0;
        for (int i = 0; i < 2 && result == 0; i++) {
            result = open_scene(c, options, reaches[i]);
            for (int of = DULL; of < (reaches[i] > 0 ? LOOKS : PHONG); of++)
                for (int what = ALL; what < MOVINGS && result == 0; what++)
                    result = measure(c, options, (moving)what, (look)of);
            close_scene(c);
        }
    }
    if (c)
        close_chess(c);
    return result == 0 ? 0 : bn_failed("sfield_chess", error[0] ? error : "out of memory");
}
