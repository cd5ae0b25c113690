/* shadowfield.c - the technique "shadowfield": precomputed shadow fields, evaluated at points of each object and
   interpolated in its triangles; flat receivers (the ground) are evaluated pixel by pixel.

   One occlusion field for each distinct mesh, its self-visibility at each point, a source field for each area light and
   emissive object, which is one entity with what it hides: its light does not fall on its own points; built again
   where their shape changes with time. Suns and skies are the environment. Spots and points become spheres of the
   size `lamp_radius`. */
#include "shadowfield_parts.h"
#include "sfield_gpu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

typedef struct sf_state {
    sfield_scene   *scene;
    sfield_basis    basis;
    int             full, gltf;         /* materials=full; by glTF's BRDF, not by Phong's lobe */
    float         (*material)[5];       /* by object: the one that all of it has */
    sfield_field  **occlusion;          /* by mesh; equal meshes share */
    sf_surface     *surface;            /* by mesh */
    sf_bones       *bones;              /* by mesh; without bones: rigid */
    uint32_t       *first_bone;         /* by object: the entity that its first bone is */
    size_t          bone_count;         /* of all objects */
    size_t          object_count;
    const uint32_t *same;               /* by mesh: the first one with the same geometry */
    uint32_t       *same_of;
    uint32_t        mesh_count;
    sfield_field  **light;              /* of scene->lights, then of emissive objects */
    uint32_t       *light_object;       /* UINT32_MAX: light_of of scene->lights */
    uint32_t       *light_of;
    ex_light       *built;              /* that one when its field was built, of radiance 1 */
    ex_light       *seen;               /* scene->lights when the sky was set, with its rotation: suns belong to it */
    float           seen_rotation, lamp;        /* radius of spots and points */
    sf_glow        *glow;               /* of objects: what it was built from */
    sfield_field  **old_light;          /* replaced; the scene still has it */
    size_t          light_count, lamp_count;      /* lamps: those of scene->lights */
    sfield_entity  *entities;           /* objects, with what they emit; then lamps; then bones */
    const sf_surface **surface_of;      /* by object; NULL: pixel by pixel */
    sf_tap         *taps;
    float         **rgb, **gloss, **grazing;    /* by object: of its chosen points */
    size_t          points;
    sfield_cache  **cache;              /* lazy=1: of each object's points, then of the flat ones */
    float          *flat_positions;     /* that the last one is of */
    size_t          flat_count;
    sfield_scene_stats stats;
    size_t          peak;
    sf_gl          *gl;                 /* --backend gl */
    sf_baked        baked;
    sf_bounces     *bounces;            /* bounce=1 */
} sf_state;

static int failed(const char *what, sfield_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield: %s: %s", what, sfield_result_text(result));
    return -1;
}

static int out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield: out of memory");
    return -1;
}

static sfield_desc desc_of(const rd_job *job, sfield_basis basis)
{
    sfield_desc d;
    int side = rd_setting_integer(job->settings, "position_side");
    int shells = rd_setting_integer(job->settings, "shell_count");
    memset(&d, 0, sizeof d);
    d.basis = basis;
    d.bands = basis == SFIELD_BASIS_HAAR ? 0 : (uint32_t)rd_setting_integer(job->settings, "bands");
    d.position_side = (uint32_t)side;
    d.shell_count = (uint32_t)shells;
    d.cube_side = (uint32_t)rd_setting_integer(job->settings, "cube_side");
    d.keep = (float)rd_setting_number(job->settings, "keep");
    ex_pool_label(job->pool, "shadowfield");
    d.system.parallel_for = ex_pool_run;
    d.system.progress = ex_pool_progress;
    d.system.log = ex_pool_log;
    d.system.user = job->pool;
    return d;
}

/* On the processor, or with build=gpu on OpenGL. */
static int build_field(const rd_job *job, const sfield_desc *d, const sfield_mesh *mesh, const float *radiance,
                       sfield_field **out, sfield_stats *stats, char *error)
{
    const char *what = radiance ? "source field of an emissive mesh" : "occlusion field";
    ex_sfield_gpu gpu = { job->gl, GLBK_OK };
    sfield_result r;
    if (rd_setting_is(job->settings, "build", "gpu"))
        r = ex_sfield_build(&gpu, d, mesh, radiance, out, stats);
    else
        r = radiance ? sfield_build_emissive(d, mesh, radiance, out, stats) : sfield_build(d, mesh, out, stats);
    if (gpu.result != GLBK_OK) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield on GL: %s: %s", what, glbk_result_text(gpu.result));
        return -1;
    }
    return r == SFIELD_OK ? 0 : failed(what, r, error);
}

static sfield_mesh mesh_of(const ex_mesh *m)
{
    sfield_mesh mesh = { m->positions, m->vertex_count, 0, m->indices, 3 * (size_t)m->triangle_count,
                         NULL, NULL, NULL };
    return mesh;
}

static int same_geometry(const ex_mesh *a, const ex_mesh *b)
{
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           memcmp(a->positions, b->positions, 12 * (size_t)a->vertex_count) == 0 &&
           memcmp(a->indices, b->indices, 12 * (size_t)a->triangle_count) == 0;
}

static float scale_of(const ex_object *o)
{
    const float *m = o->transform;
    return sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
}

/* The field of a mesh: baked, or built now. */
static int field_of(sf_state *s, const rd_job *job, const ex_mesh *mesh, sfield_field **out, char *error)
{
    sfield_desc d = desc_of(job, s->basis);
    sfield_mesh input = mesh_of(mesh);
    sfield_stats stats;
    *out = sf_baked_occlusion(&s->baked, mesh);
    if (*out)
        return 0;
    d.logarithm = rd_setting_is(job->settings, "product", "exp");
    if (build_field(job, &d, &input, NULL, out, &stats, error) != 0)
        return -1;
    s->peak = stats.peak_bytes > s->peak ? stats.peak_bytes : s->peak;
    return 0;
}

static size_t entity_count(const sf_state *s) { return s->object_count + s->lamp_count + s->bone_count; }

static void fill_set(sfield_points *set, size_t count, const float *positions, const float *normals)
{
    memset(set, 0, sizeof *set);
    set->count = count;
    set->positions = positions;
    set->normals = normals;
}

/* What hides a mesh from its own points: baked, or built now. */
static int self_of(sf_state *s, const rd_job *job, const ex_mesh *mesh, sf_surface *surface, float offset, char *error)
{
    sfield_desc d = desc_of(job, s->basis);
    sfield_mesh input = mesh_of(mesh);
    sfield_stats stats;
    sfield_points points;
    sfield_result r;
    d.keep = 0.06f;                              /* of wavelets: one cube a point, not thousands an object */
    surface->self = sf_baked_self(&s->baked, &d, mesh, surface, offset);
    if (surface->self)
        return 0;
    fill_set(&points, surface->chosen_count, surface->chosen_positions, surface->chosen_normals);
    r = sfield_build_self(&d, &input, &points, offset, &surface->self, &stats);
    if (r != SFIELD_OK)
        return failed("visibility of an object's points", r, error);
    s->peak = stats.peak_bytes > s->peak ? stats.peak_bytes : s->peak;
    return 0;
}

/* Does an object deform and, with bones=1, move as its bones? What shines does not. */
static int has_bones(const rd_job *job, uint32_t object)
{
    for (size_t i = 0; i < job->emitter_count; i++)
        if (job->emitters[i].object == object)
            return 0;
    return rd_setting_is(job->settings, "bones", "1") && job->scene->meshes[job->scene->objects[object].mesh].deforms;
}

/* What a bone hides, and what of it is hidden from its own points by its own triangles as they are now. */
static int make_bone(sf_state *s, const rd_job *job, const ex_mesh *mesh, sf_bones *b, size_t i, float offset,
                     char *error)
{
    sf_bone *bone = &b->bone[i];
    sfield_desc d = desc_of(job, s->basis);
    sfield_mesh input = mesh_of(&bone->hull);
    sfield_points points;
    size_t count = 0;
    sfield_result r = SFIELD_OK;
    uint32_t *indices = sf_bone_triangles(b, mesh, i, &count);
    d.inner = fminf(fmaxf(bone->inner, 0.02f), 0.2f);
    d.logarithm = rd_setting_is(job->settings, "product", "exp");
    if (!indices)
        return out_of_memory(error);
    if (build_field(job, &d, &input, NULL, &bone->occlusion, NULL, error) != 0) {
        free(indices);
        return -1;
    }
    d = desc_of(job, s->basis);
    d.keep = 0.06f;
    input = mesh_of(mesh);
    input.indices = indices;
    input.index_count = count;
    fill_set(&points, b->first[i + 1] - b->first[i], b->positions + 3 * b->first[i], b->normals + 3 * b->first[i]);
    if (points.count)
        r = sfield_build_self(&d, &input, &points, offset, &bone->self, NULL);
    free(indices);
    return r == SFIELD_OK ? 0 : failed("visibility of a bone's points", r, error);
}

static int make_bones(sf_state *s, const rd_job *job, uint32_t m, float spacing, float offset, char *error)
{
    const ex_mesh *mesh = &job->scene->meshes[m];
    sf_bones *b = &s->bones[m];
    if (sf_bones_build(b, mesh) != 0 || sf_surface_build(&s->surface[m], job->scene, mesh, spacing, b->piece) != 0 ||
        sf_bones_points(b, &s->surface[m]) != 0)
        return out_of_memory(error);
    sf_bones_follow(b, mesh, &s->surface[m]);
    for (size_t i = 0; i < b->count; i++)
        if (make_bone(s, job, mesh, b, i, offset, error) != 0)
            return -1;
    return 0;
}

/* Room for the entities of all, now that the bones are known. */
static int make_entities(sf_state *s, const ex_scene *scene, char *error)
{
    s->first_bone = calloc(scene->object_count + (size_t)1, sizeof *s->first_bone);
    for (uint32_t i = 0; s->first_bone && i < scene->object_count; i++) {
        s->first_bone[i] = (uint32_t)s->bone_count;
        s->bone_count += s->bones[scene->objects[i].mesh].count;
    }
    s->entities = calloc(scene->object_count + scene->light_count + s->bone_count + 1, sizeof *s->entities);
    return s->first_bone && s->entities ? 0 : out_of_memory(error);
}

/* Fields and points of every mesh that a casting object uses. */
static int make_meshes(sf_state *s, const rd_job *job, char *error)
{
    const ex_scene *scene = job->scene;
    s->mesh_count = scene->mesh_count;
    s->occlusion = calloc(scene->mesh_count + (size_t)1, sizeof *s->occlusion);
    s->surface = calloc(scene->mesh_count + (size_t)1, sizeof *s->surface);
    s->bones = calloc(scene->mesh_count + (size_t)1, sizeof *s->bones);
    s->same_of = calloc(scene->mesh_count + (size_t)1, sizeof *s->same_of);
    if (!s->occlusion || !s->surface || !s->bones || !s->same_of)
        return out_of_memory(error);
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *o = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[o->mesh];
        float share = (float)rd_setting_number(job->settings, "point_spacing");
        float spacing = share * job->radius / fmaxf(scale_of(o), 1e-12f);
        sf_surface *surface = &s->surface[o->mesh];
        float offset = 1e-3f * job->radius / fmaxf(scale_of(o), 1e-12f);
        uint32_t first = 0;
        if (o->receiver_only || surface->point_count || !mesh->triangle_count)
            continue;
        if (has_bones(job, i)) {
            if (make_bones(s, job, o->mesh, spacing, offset, error) != 0)
                return -1;
            continue;
        }
        while (first < o->mesh && !(s->occlusion[first] && same_geometry(mesh, &scene->meshes[first])))
            first++;
        s->same_of[o->mesh] = first;
        if (first == o->mesh && field_of(s, job, mesh, &s->occlusion[first], error) != 0)
            return -1;
        if (sf_surface_build(surface, scene, mesh, spacing, NULL) != 0)
            return out_of_memory(error);
        if (self_of(s, job, mesh, surface, offset, error) != 0)
            return -1;
    }
    s->same = s->same_of;
    return make_entities(s, scene, error);
}

/* ---- lights ---- */

/* Lamps: spot, point, sphere, disc, rectangle, line. Their fields are of radiance 1: what they shine with is their
   entity's tint. */
static int build_lamp(sf_state *s, const rd_job *job, size_t j, char *error)
{
    const ex_light *l = &job->scene->lights[s->light_of[j]];
    sfield_desc d = desc_of(job, s->basis);
    sfield_emitter e;
    sfield_field *field;
    sfield_result r = SFIELD_OK;
    if (sf_emitter_of(l, s->lamp, &e) != 0) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: this kind of light is not treated");
        return -1;
    }
    field = sf_baked_lamp(&s->baked, &e);
    if (!field)
        r = sfield_build_emitter(&d, &e, &field, NULL);
    if (r != SFIELD_OK)
        return failed("source field", r, error);
    s->old_light[j] = s->light[j];
    s->light[j] = field;
    s->built[j] = *l;
    return 0;
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Can one be turned, moved and evenly scaled into the other? */
static int same_shape(const ex_light *a, const ex_light *b)
{
    float u = dot(a->u, a->u) * dot(b->v, b->v), v = dot(b->u, b->u) * dot(a->v, a->v);
    if (a->kind == EX_LIGHT_SPOT)
        return a->cos_half_angle == b->cos_half_angle;
    if (a->kind == EX_LIGHT_LINE)
        return fabsf(a->radius * sqrtf(dot(b->u, b->u)) - b->radius * sqrtf(dot(a->u, a->u))) <=
               1e-5f * a->radius * sqrtf(dot(b->u, b->u));
    if (a->kind != EX_LIGHT_RECT)
        return 1;
    return fabsf(u - v) <= 1e-5f * u && fabsf(dot(a->u, a->v) * dot(b->u, b->u) - dot(b->u, b->v) * dot(a->u, a->u)) <=
                                            1e-5f * dot(a->u, a->u) * sqrtf(dot(b->u, b->u) * dot(b->v, b->v));
}

/* Fields of lamps that have another shape than before. Returns how many, or -1. */
static int follow_lamps(sf_state *s, const rd_job *job, char *error)
{
    int built = 0;
    for (size_t j = 0; j < s->lamp_count; j++) {
        if (s->light[j] && same_shape(&job->scene->lights[s->light_of[j]], &s->built[j]))
            continue;
        if (build_lamp(s, job, j, error) != 0)
            return -1;
        built++;
    }
    return built;
}

/* The source field of light j, an object, as it shines now. */
static int build_glow(sf_state *s, const rd_job *job, size_t j, sf_glow *glow, char *error)
{
    const ex_mesh *m = &job->scene->meshes[job->scene->objects[s->light_object[j]].mesh];
    const int side = rd_setting_integer(job->settings, "source_position_side");
    const int shells = rd_setting_integer(job->settings, "source_shell_count");
    sfield_desc d = desc_of(job, s->basis);
    sfield_mesh mesh = { m->positions, m->vertex_count, 0, glow->indices, 3 * (size_t)glow->count, NULL, NULL, NULL };
    sfield_field *field;
    d.position_side = side ? (uint32_t)side : d.position_side;
    d.shell_count = shells ? (uint32_t)shells : d.shell_count;
    field = sf_baked_source(&s->baked, m, glow, job->time);
    if (!field && build_field(job, &d, &mesh, glow->radiance, &field, NULL, error) != 0) {
        sf_glow_free(glow);
        return -1;
    }
    s->old_light[j] = s->light[j];
    s->light[j] = field;
    sf_glow_free(&s->glow[j]);
    s->glow[j] = *glow;
    return 0;
}

/* Source fields of objects that shine, where they shine otherwise than before, as the picture of a video does. One that
   went out stays a light, of radiance 0. Returns how many were built, or -1. */
static int follow_glows(sf_state *s, const rd_job *job, char *error)
{
    int built = 0;
    for (size_t i = 0; i < job->emitter_count; i++) {
        size_t j = s->lamp_count;
        while (j < s->light_count && s->light_object[j] != job->emitters[i].object)
            j++;
        s->light_object[j] = job->emitters[i].object;
        s->light_count += j == s->light_count;
    }
    for (size_t j = s->lamp_count; j < s->light_count; j++) {
        sf_glow glow;
        if (sf_glow_build(&glow, job->scene, &job->scene->objects[s->light_object[j]]) != 0)
            return out_of_memory(error);
        if (s->light[j] && sf_glow_same(&glow, &s->glow[j])) {
            sf_glow_free(&glow);
            continue;
        }
        if (build_glow(s, job, j, &glow, error) != 0)
            return -1;
        built++;
    }
    return built;
}

/* Sky and suns, where they are others than before. */
static int follow_sky(sf_state *s, const rd_job *job, char *error)
{
    const ex_scene *scene = job->scene;
    const ex_sky *sky = &scene->sky;
    float c = cosf(sky->rotation), sn = sinf(sky->rotation);
    const float turn[16] = { c, 0, -sn, 0, 0, 1, 0, 0, sn, 0, c, 0, 0, 0, 0, 1 };
    const size_t bytes = scene->light_count * sizeof *s->seen;
    sfield_result r = SFIELD_OK;
    const int first = !s->seen, turned = first || s->seen_rotation != sky->rotation;
    int moved = first;
    for (uint32_t i = 0; i < scene->light_count && !moved; i++)
        moved = scene->lights[i].kind == EX_LIGHT_SUN && memcmp(&scene->lights[i], &s->seen[i], sizeof *s->seen) != 0;
    if (!turned && !moved)
        return 0;
    if (first && !(s->seen = malloc(bytes + 1)))
        return out_of_memory(error);
    if (bytes)
        memcpy(s->seen, scene->lights, bytes);
    s->seen_rotation = sky->rotation;
    if (first)
        r = sfield_scene_environment(s->scene, sky->width ? sky->rgb : NULL, sky->width, sky->height, turn);
    else if (turned)
        r = sfield_scene_turn(s->scene, turn);
    if (moved && r == SFIELD_OK)
        r = sfield_scene_sun(s->scene, NULL, NULL);
    for (uint32_t i = 0; i < scene->light_count && moved && r == SFIELD_OK; i++)
        if (scene->lights[i].kind == EX_LIGHT_SUN)
            r = sfield_scene_sun(s->scene, scene->lights[i].direction, scene->lights[i].value);
    return r == SFIELD_OK ? 0 : failed("sky", r, error);
}

/* All that shines, as it is now. Returns how many fields were built, or -1. */
static int follow_lights(sf_state *s, const rd_job *job, char *error)
{
    int lamps = follow_sky(s, job, error) == 0 ? follow_lamps(s, job, error) : -1;
    int glows = lamps < 0 ? -1 : follow_glows(s, job, error);
    return glows < 0 ? -1 : lamps + glows;
}

static int build_lights(sf_state *s, const rd_job *job, char *error)
{
    s->lamp = (float)rd_setting_number(job->settings, "lamp_radius") * job->radius;
    for (uint32_t i = 0; i < job->scene->light_count; i++) {
        if (job->scene->lights[i].kind == EX_LIGHT_SUN)
            continue;
        s->light_object[s->light_count] = UINT32_MAX;
        s->light_of[s->light_count++] = i;
    }
    s->lamp_count = s->light_count;
    return follow_lights(s, job, error) < 0 ? -1 : 0;
}

/* The entity that light j is of. */
static sfield_entity *entity_of(const sf_state *s, const ex_scene *scene, size_t j)
{
    return &s->entities[s->light_object[j] == UINT32_MAX ? scene->object_count + j : s->light_object[j]];
}

/* Is what an object hides a room about a place, for the library? See docs/shadowfield.md, Rooms. */
static int is_room(const sfield_field *field, const float *m, float scale, const float *at)
{
    float local[3] = { 0, 0, 0 }, open = 1;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            local[k] += m[4 * k + i] * (at[i] - m[12 + i]) / (scale * scale);
    return sfield_ambient(field, 1, local, &open) == SFIELD_OK && open < 0.5f;
}

/* A light in an object of which the library makes no room: points on the walls have no notion of what lies behind the
   light, and would be hidden from it. On OpenGL there are no rooms. An object that is most of the scene counts; lamps
   carried by smaller ones are counted as overlaps. */
static int check_enclosed(const sf_state *s, const rd_job *job, char *error)
{
    for (size_t j = 0; j < s->light_count; j++)
        for (uint32_t i = 0; i < job->scene->object_count; i++) {
            const ex_object *o = &job->scene->objects[i];
            const float *m = entity_of(s, job->scene, j)->transform;
            sfield_info info, lamp;
            float d2 = 0, scale = scale_of(o), at[3];
            if (!s->entities[i].occlusion || s->light_object[j] == i)
                continue;
            sfield_get_info(s->entities[i].occlusion, &info);
            sfield_get_info(s->light[j], &lamp);
            for (int k = 0; k < 3; k++) {
                const float *t = o->transform, *p = info.center;
                float c = t[k] * p[0] + t[4 + k] * p[1] + t[8 + k] * p[2] + t[12 + k];
                float l = m[k] * lamp.center[0] + m[4 + k] * lamp.center[1] + m[8 + k] * lamp.center[2] + m[12 + k];
                d2 += (l - c) * (l - c);
                at[k] = l;
            }
            if (scale * info.radius > 0.75f * job->radius && d2 < scale * scale * info.radius * info.radius &&
                (job->gl || !is_room(s->entities[i].occlusion, o->transform, scale, at))) {
                snprintf(error, EX_ERROR_SIZE,
                         "shadowfield: a light lies inside the bounding sphere of %.40s, which would "
                         "hide it from itself",
                         o->name);
                return -1;
            }
        }
    return 0;
}

/* ---- frames ---- */

/* Columns: along u, across it in the plane, the normal. */
static void rect_frame(const ex_light *l, float f[9])
{
    const float *u = l->u, *v = l->v;
    float n[3] = { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
    float length = sqrtf(dot(u, u)), area = sqrtf(dot(n, n));
    for (int k = 0; k < 3; k++) {
        f[k] = u[k] / length;
        f[6 + k] = n[k] / area;
    }
    for (int k = 0; k < 3; k++)
        f[3 + k] = f[6 + (k + 1) % 3] * f[(k + 2) % 3] - f[6 + (k + 2) % 3] * f[(k + 1) % 3];
}

/* Spots, discs and lines, which are round, turn from where they pointed by the shortest way. */
static void turn_round(const float *aim, const float *d, float *m)
{
    float v[3] = { aim[1] * d[2] - aim[2] * d[1], aim[2] * d[0] - aim[0] * d[2], aim[0] * d[1] - aim[1] * d[0] };
    float c = dot(aim, d);
    if (c > 0.999999f)
        return;
    if (c < -0.999f) {                           /* half a turn about what stands on aim */
        float p[3] = { 0, aim[2], -aim[1] }, q;
        if (fabsf(aim[0]) > 0.7f)
            p[0] = aim[1], p[1] = -aim[0], p[2] = 0;
        q = 2 / dot(p, p);
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 3; i++)
                m[4 * k + i] = q * p[i] * p[k] - (i == k ? 1.0f : 0);
        return;
    }
    for (int k = 0; k < 3; k++)                  /* c I + [v] + v v^T / (1 + c) */
        for (int i = 0; i < 3; i++)
            m[4 * k + i] = (i == k ? c : 0) + v[i] * v[k] / (1 + c);
    m[1] += v[2], m[2] -= v[1], m[4] -= v[2], m[6] += v[0], m[8] += v[1], m[9] -= v[0];
}

/* A lamp where it is now, as large and as bright. */
static void place_lamp(const sf_state *s, const ex_light *l, const ex_light *built, sfield_entity *e)
{
    const int small = l->kind == EX_LIGHT_SPOT || l->kind == EX_LIGHT_POINT;
    float *m = e->transform, scale = small ? 1 : l->radius / built->radius;
    if (l->kind == EX_LIGHT_SPOT || l->kind == EX_LIGHT_DISC)
        turn_round(built->direction, l->direction, m);
    if (l->kind == EX_LIGHT_LINE) {
        const float now = sqrtf(dot(l->u, l->u)), before = sqrtf(dot(built->u, built->u));
        const float from[3] = { built->u[0] / before, built->u[1] / before, built->u[2] / before };
        const float to[3] = { l->u[0] / now, l->u[1] / now, l->u[2] / now };
        turn_round(from, to, m);
    }
    if (l->kind == EX_LIGHT_RECT) {
        float now[9], before[9];
        scale = sqrtf(dot(l->u, l->u) / dot(built->u, built->u));
        rect_frame(l, now);
        rect_frame(built, before);
        for (int k = 0; k < 3 && memcmp(now, before, sizeof now) != 0; k++)
            for (int i = 0; i < 3; i++)
                m[4 * k + i] = now[i] * before[k] + now[3 + i] * before[3 + k] + now[6 + i] * before[6 + k];
    }
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++)
            m[4 * k + i] *= scale;
        m[12 + k] = l->position[k];
        if (l->kind == EX_LIGHT_RECT || l->kind == EX_LIGHT_LINE)
            m[12 + k] += 0.5f * (l->u[k] + (l->kind == EX_LIGHT_RECT ? l->v[k] : 0));
        e->tint[k] = small ? l->value[k] / (3.14159265f * s->lamp * s->lamp) : l->value[k];
    }
}

/* Bones of an object where they are now. */
static void place_bones(const sf_state *s, const ex_object *o, uint32_t object)
{
    const sf_bones *b = &s->bones[o->mesh];
    sfield_entity *e = s->entities + s->object_count + s->lamp_count + s->first_bone[object];
    for (size_t i = 0; i < b->count; i++, e++) {
        *e = upright;
        e->occlusion = b->bone[i].occlusion;
        for (int k = 0; k < 4; k++)
            for (int l = 0; l < 3; l++) {
                const float *m = o->transform, *q = b->bone[i].transform + 4 * k;
                e->transform[4 * k + l] = m[l] * q[0] + m[4 + l] * q[1] + m[8 + l] * q[2] + m[12 + l] * q[3];
            }
    }
}

static int place(sf_state *s, const rd_job *job, char *error)
{
    const ex_scene *scene = job->scene;
    size_t pixels = (size_t)job->gbuffer->width * job->gbuffer->height;
    sfield_result r;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *o = &scene->objects[i];
        sfield_entity *e = &s->entities[i];
        *e = upright;
        s->surface_of[i] = o->receiver_only || !s->surface[o->mesh].point_count ? NULL : &s->surface[o->mesh];
        if (!s->surface_of[i])
            continue;
        memcpy(e->transform, o->transform, sizeof e->transform);
        if (s->bones[o->mesh].count)
            place_bones(s, o, i);
        else
            e->occlusion = s->occlusion[s->same[o->mesh]];
    }
    for (size_t i = 0; i < s->light_count; i++) {
        sfield_entity *e = entity_of(s, scene, i);
        if (s->light_object[i] != UINT32_MAX) {
            memcpy(e->transform, scene->objects[s->light_object[i]].transform, sizeof e->transform);
        } else {
            *e = upright;
            place_lamp(s, &scene->lights[s->light_of[i]], &s->built[i], e);
        }
        e->source = s->light[i];
        e->time = job->time;
    }
    if (check_enclosed(s, job, error) != 0)
        return -1;
    r = sfield_scene_entities(s->scene, s->entities, entity_count(s));
    if (r == SFIELD_ERR_INPUT)
        return failed("objects that are stretched or mirrored are not treated", r, error);
    if (r != SFIELD_OK)
        return failed("entities", r, error);
    free(s->taps);
    s->taps = malloc((pixels + 1) * sizeof *s->taps);
    if (!s->taps || sf_taps_build(s->taps, job, s->surface_of) != 0)
        return out_of_memory(error);
    return 0;
}

/* Every pixel of flat receivers is a point. Those of one that shines, which its own light does not fall on, are in its
   space, and stand together behind the others. */
typedef struct flat {
    float *positions, *normals, *views;
    float *exponents, *materials;
    float *rgb, *gloss, *grazing;
    uint32_t *pixel;
    size_t count;
} flat;

/* entity: the receiver, or UINT32_MAX for all that do not shine. Returns how many were added. */
static size_t gather_pixels(flat *f, const sf_state *s, const rd_job *job, uint32_t entity)
{
    size_t pixels = (size_t)job->gbuffer->width * job->gbuffer->height, first = f->count;
    const float *m = entity == UINT32_MAX ? NULL : s->entities[entity].transform;
    const float square = m ? dot(m, m) : 1;
    for (size_t i = 0; i < pixels; i++) {
        const ex_pixel *p = &job->gbuffer->pixels[i];
        float alpha = p->roughness * p->roughness, *at = f->positions + 3 * f->count, *n = f->normals + 3 * f->count;
        if (p->object == UINT32_MAX || s->surface_of[p->object] ||
            entity != (s->entities[p->object].source ? p->object : UINT32_MAX))
            continue;
        memcpy(at, p->position, sizeof p->position);
        memcpy(n, p->normal, sizeof p->normal);
        for (int k = 0; k < 3 && m; k++) {
            const float from[3] = { p->position[0] - m[12], p->position[1] - m[13], p->position[2] - m[14] };
            at[k] = dot(m + 4 * k, from) / square;
            n[k] = dot(m + 4 * k, p->normal) / sqrtf(square);
        }
        memcpy(f->views + 3 * f->count, p->view, sizeof p->view);
        f->exponents[f->count] = alpha > 0.01f ? fmaxf(2 / (alpha * alpha) - 2, 1) : 1000;
        memset(f->materials + 5 * f->count, 0, 4 * sizeof *f->materials);
        f->materials[5 * f->count + 4] = fminf(fmaxf(p->roughness, 0), 1);
        f->pixel[f->count++] = (uint32_t)i;
    }
    return f->count - first;
}

static int make_flat(flat *f, const rd_job *job)
{
    size_t room = (size_t)job->gbuffer->width * job->gbuffer->height + 1;
    memset(f, 0, sizeof *f);
    f->positions = malloc(24 * room * sizeof *f->positions);
    f->pixel = malloc(room * sizeof *f->pixel);
    if (!f->positions || !f->pixel)
        return -1;
    f->normals = f->positions + 3 * room;
    f->views = f->normals + 3 * room;
    f->rgb = f->views + 3 * room;
    f->gloss = f->rgb + 3 * room;
    f->exponents = f->gloss + 3 * room;
    f->materials = f->exponents + room;
    f->grazing = f->materials + 5 * room;
    return 0;
}

/* Views of an object's chosen points, in the world. */
static float *views_of(const sf_surface *s, const ex_object *o, const ex_camera *camera)
{
    float *views = malloc((3 * s->chosen_count + 1) * sizeof *views);
    const float *m = o->transform;
    for (size_t i = 0; views && i < s->chosen_count; i++) {
        const float *p = s->chosen_positions + 3 * i;
        float *v = views + 3 * i, length = 0;
        for (int k = 0; k < 3; k++) {
            v[k] = camera->eye[k] - (m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
            length += v[k] * v[k];
        }
        for (int k = 0; k < 3; k++)
            v[k] /= length > 0 ? sqrtf(length) : 1;
    }
    return views;
}

/* grazing: what of gloss F0 does not color; of points without metal, F0 is 0.04. */
static void lay_pixel(const sf_state *s, const ex_pixel *p, const float *rgb, const float *gloss, const float *grazing,
                      float *out)
{
    for (int k = 0; k < 3; k++) {
        float albedo = fminf(p->albedo[k], 1), diffuse = s->full ? albedo * (1 - p->metallic) : albedo;
        float specular = 0.04f * (1 - p->metallic) + albedo * p->metallic;
        if (s->gltf)
            out[k] = diffuse * rgb[k] * (1 - specular) / 0.96f + (gloss[k] - grazing[k]) * specular / 0.04f +
                     grazing[k];
        else
            out[k] = diffuse * rgb[k] + (s->full ? specular * gloss[k] : 0);
        out[k] = fmaxf(out[k], 0);
    }
}

static void lay_pixels(const sf_state *s, const rd_job *job, const flat *f, ex_image *out)
{
    size_t pixels = (size_t)job->gbuffer->width * job->gbuffer->height;
    for (size_t i = 0; i < f->count; i++)
        lay_pixel(s, &job->gbuffer->pixels[f->pixel[i]], f->rgb + 3 * i, f->gloss + 3 * i, f->grazing + 3 * i,
                  out->rgb + 3 * (size_t)f->pixel[i]);
    for (size_t i = 0; i < pixels; i++) {
        const ex_pixel *p = &job->gbuffer->pixels[i];
        const sf_tap *tap = &s->taps[i];
        const sf_surface *surface = p->object == UINT32_MAX ? NULL : s->surface_of[p->object];
        float rgb[3] = { 0, 0, 0 }, gloss[3] = { 0, 0, 0 }, grazing[3] = { 0, 0, 0 };
        if (!surface)
            continue;
        for (int v = 0; v < 3; v++)
            for (int q = 0; q < 3; q++) {
                size_t at = 3 * (size_t)tap->point[v] + (size_t)q, from = 3 * (size_t)surface->sources[at];
                float w = tap->weight[v] * surface->weights[at];
                for (int k = 0; k < 3; k++) {
                    rgb[k] += w * s->rgb[p->object][from + (size_t)k];
                    gloss[k] += s->full ? w * s->gloss[p->object][from + (size_t)k] : 0;
                    grazing[k] += s->gltf ? w * s->grazing[p->object][from + (size_t)k] : 0;
                }
            }
        lay_pixel(s, p, rgb, gloss, grazing, out->rgb + 3 * i);
    }
}

/* What a set with gloss has besides: views and, by point, exponents or materials. */
static void add_gloss(const sf_state *s, sfield_points *set, const float *views, const float *exponents,
                      const float *materials, float *grazing)
{
    set->grazing = s->gltf ? grazing : NULL;
    set->to_eye = views;
    set->exponents = s->full && !s->gltf ? exponents : NULL;
    set->exponent_stride = sizeof(float);
    set->materials = s->full && s->gltf ? materials : NULL;
    set->material_stride = 5 * sizeof(float);
}

/* The next pixels of flat receivers as a set. */
static void add_flat(sf_state *s, const rd_job *job, flat *f, uint32_t entity, sfield_points *set)
{
    const size_t at = f->count, count = gather_pixels(f, s, job, entity);
    fill_set(set, count, f->positions + 3 * at, f->normals + 3 * at);
    set->entity = entity == UINT32_MAX ? 0 : entity + 1;
    set->rgb = f->rgb + 3 * at;
    set->gloss = s->full ? f->gloss + 3 * at : NULL;
    add_gloss(s, set, f->views + 3 * at, f->exponents + at, f->materials + 5 * at, f->grazing + 3 * at);
    s->points += count;
}

/* lazy=1: what hides each light is kept while the points stay; of flat receivers, sets from `flat` on, other pixels are
   other points. */
static sfield_result keep_caches(sf_state *s, uint32_t objects, sfield_points *sets, size_t count, size_t flat_from,
                                 const flat *f)
{
    const size_t bytes = 3 * f->count * sizeof(float);
    const int moved = s->flat_count != f->count || (bytes && memcmp(s->flat_positions, f->positions, bytes) != 0);
    for (size_t i = 0; i < count; i++) {
        sfield_cache **cache = &s->cache[sets[i].entity ? sets[i].entity - 1 : objects];
        sfield_result r;
        if (i >= flat_from && moved) {
            sfield_cache_free(*cache);
            *cache = NULL;
        }
        if (sets[i].count && !*cache) {
            r = sfield_cache_create(s->scene, sets[i].count, (uint32_t)s->light_count + 1, cache);
            if (r != SFIELD_OK)
                return r;
        }
        sets[i].cache = *cache;
    }
    free(s->flat_positions);
    s->flat_positions = malloc(bytes + 1);
    if (!s->flat_positions)
        return SFIELD_ERR_ALLOC;
    memcpy(s->flat_positions, f->positions, bytes);
    s->flat_count = f->count;
    return SFIELD_OK;
}

/* A set for each bone of an object that has points; results come bone by bone. Returns the next free set. */
static sfield_points *add_bones(sf_state *s, uint32_t mesh, uint32_t object, sfield_points *set)
{
    const sf_bones *b = &s->bones[mesh];
    for (size_t i = 0; i < b->count; i++) {
        const size_t first = b->first[i], count = b->first[i + 1] - first;
        if (!count)
            continue;
        fill_set(set, count, b->positions + 3 * first, b->normals + 3 * first);
        set->entity = (uint32_t)(s->object_count + s->lamp_count + s->first_bone[object] + i + 1);
        set->self = b->bone[i].self;
        set->rgb = s->rgb[object] + 3 * first;
        s->points += count;
        set++;
    }
    return set;
}

/* The set of a rigid object. */
static void add_surface(sf_state *s, const ex_scene *scene, uint32_t object, const float *views, sfield_points *set)
{
    const sf_surface *surface = s->surface_of[object];
    const uint32_t material = scene->objects[object].material;
    fill_set(set, surface->chosen_count, surface->chosen_positions, surface->chosen_normals);
    set->entity = object + 1;
    set->self = surface->self;
    set->rgb = s->rgb[object];
    set->gloss = s->full ? s->gloss[object] : NULL;
    add_gloss(s, set, views, surface->chosen_exponent, surface->chosen_material, s->grazing[object]);
    if (material && set->materials) {
        sf_material(&scene->materials[material - 1], s->material[object]);
        set->materials = s->material[object];
        set->material_stride = 0;
    }
    s->points += set->count;
}

/* Results of bones in the order of their surface's points. */
static sfield_result sort_bones(const sf_state *s, const ex_scene *scene)
{
    for (uint32_t object = 0; object < scene->object_count; object++) {
        const sf_bones *b = &s->bones[scene->objects[object].mesh];
        const size_t count = s->surface_of[object] && b->count ? s->surface_of[object]->chosen_count : 0;
        float *rgb = s->rgb[object], *sorted = count ? malloc(3 * count * sizeof *sorted) : NULL;
        if (count && !sorted)
            return SFIELD_ERR_ALLOC;
        for (size_t i = 0; i < count; i++)
            memcpy(sorted + 3 * (size_t)b->order[i], rgb + 3 * i, 3 * sizeof *sorted);
        if (count)
            memcpy(rgb, sorted, 3 * count * sizeof *sorted);
        free(sorted);
    }
    return SFIELD_OK;
}

static int frame_shadowfield(void *opaque, const rd_job *job, ex_image *out, char *error)
{
    sf_state *s = opaque;
    const ex_scene *scene = job->scene;
    sfield_points *sets = calloc(scene->object_count + s->bone_count + 1, sizeof *sets), *set = sets;
    float **views = calloc(scene->object_count + (size_t)1, sizeof *views);
    sfield_result r = SFIELD_ERR_ALLOC;
    flat f;
    size_t flat_from;
    int good = sets && views && make_flat(&f, job) == 0;
    s->points = 0;
    for (uint32_t i = 0; good && i < scene->object_count; i++) {
        const sf_surface *surface = s->surface_of[i];
        size_t floats = surface ? 3 * surface->chosen_count : 0;
        if (!surface)
            continue;
        s->rgb[i] = realloc(s->rgb[i], floats * sizeof(float));
        s->gloss[i] = realloc(s->gloss[i], floats * sizeof(float));
        views[i] = s->full ? views_of(surface, &scene->objects[i], &scene->camera) : NULL;
        s->grazing[i] = realloc(s->grazing[i], floats * sizeof(float));
        good = s->rgb[i] && s->gloss[i] && s->grazing[i] && (views[i] || !s->full);
        if (good && s->bones[scene->objects[i].mesh].count)
            set = add_bones(s, scene->objects[i].mesh, i, set);
        else
            add_surface(s, scene, i, views[i], set++);
    }
    if (good) {
        flat_from = (size_t)(set - sets);
        add_flat(s, job, &f, UINT32_MAX, set++);
        for (uint32_t i = 0; i < scene->object_count; i++)
            if (!s->surface_of[i] && s->entities[i].source)
                add_flat(s, job, &f, i, set++);
        /* bounce=1: rigid objects get the light that they send on as a source */
        r = s->bounces ? sf_bounces_light(s->bounces, s->scene, s->entities, entity_count(s)) : SFIELD_OK;
        if (r == SFIELD_OK && s->cache)
            r = keep_caches(s, scene->object_count, sets, (size_t)(set - sets), flat_from, &f);
        if (r != SFIELD_OK)
            good = 0;
        else if (!s->gl)
            r = sfield_shade(s->scene, sets, (size_t)(set - sets), &s->stats);
        else if (sf_gl_shade(s->gl, job, s->scene, s->entities, entity_count(s), sets,
                             (size_t)(set - sets), error) != 0)
            r = SFIELD_ERR_ARGUMENT;
    }
    if (r == SFIELD_OK)
        r = sort_bones(s, scene);
    if (r == SFIELD_OK)
        lay_pixels(s, job, &f, out);
    if (sets && views) {
        free(f.positions);
        free(f.pixel);
        for (uint32_t i = 0; i < scene->object_count; i++)
            free(views[i]);
    }
    free(sets);
    free(views);
    return r == SFIELD_OK ? 0 : good && s->gl ? -1 : failed("shading", r, error);
}

/* ---- opening and moving on ---- */

/* Fields to OpenGL; others in their place where there are some already. */
static int send_fields(sf_state *s, const rd_job *job, char *error)
{
    const int wavelets = s->basis == SFIELD_BASIS_HAAR;         /* self-visibility goes up with them */
    size_t count = s->mesh_count + s->light_count;
    const sfield_field **fields = calloc(count + 2 * s->bone_count + s->mesh_count + 1, sizeof *fields);
    int sent = 0;
    if (!job->gl || !fields) {
        free((void *)(size_t)fields);
        return job->gl ? out_of_memory(error) : 0;
    }
    memcpy((void *)(size_t)fields, s->occlusion, s->mesh_count * sizeof *fields);
    memcpy((void *)(size_t)(fields + s->mesh_count), s->light, s->light_count * sizeof *fields);
    for (uint32_t m = 0; m < s->mesh_count; m++)
        for (size_t i = 0; i < s->bones[m].count; i++) {
            fields[count++] = s->bones[m].bone[i].occlusion;
            fields[count++] = wavelets ? s->bones[m].bone[i].self : NULL;
        }
    for (uint32_t m = 0; m < s->mesh_count && wavelets; m++)
        fields[count++] = s->surface[m].self;
    if (s->gl)
        sent = sf_gl_fields(s->gl, job, fields, count, entity_count(s), error);
    else
        s->gl = sf_gl_open(job, fields, count, entity_count(s), !s->full ? SF_DULL : s->gltf ? SF_GLTF : SF_PHONG,
                           error);
    free((void *)(size_t)fields);
    return s->gl ? sent : -1;
}

static void free_old_lights(sf_state *s)
{
    for (size_t i = 0; s->old_light && i < s->light_count; i++) {
        sf_baked_drop(&s->baked, s->old_light[i]);
        s->old_light[i] = NULL;
    }
}

/* Fields, points and what hides them from each other take seconds for a mesh: none are made anew between frames. */
static int check_rigid(const sf_state *s, const ex_scene *scene, char *error)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *o = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[o->mesh];
        const sf_surface *surface = &s->surface[o->mesh];
        if (o->receiver_only || !mesh->deforms || !surface->point_count || s->bones[o->mesh].count ||
            memcmp(surface->positions, mesh->positions, 12 * (size_t)mesh->vertex_count) == 0)
            continue;
        snprintf(error, EX_ERROR_SIZE, "shadowfield: object %s deforms, which needs bones=1", o->name);
        return -1;
    }
    return 0;
}

static int update_shadowfield(void *opaque, const rd_job *job, char *error)
{
    sf_state *s = opaque;
    int built, placed;
    if (check_rigid(s, job->scene, error) != 0)
        return -1;
    for (uint32_t m = 0; m < s->mesh_count; m++)
        if (s->bones[m].count) {
            sf_surface_follow(&s->surface[m], &job->scene->meshes[m]);
            sf_bones_follow(&s->bones[m], &job->scene->meshes[m], &s->surface[m]);
        }
    built = follow_lights(s, job, error);
    placed = built < 0 ? -1 : place(s, job, error);
    if (placed == 0)
        free_old_lights(s);
    return placed == 0 && built ? send_fields(s, job, error) : placed;
}

static void close_shadowfield(void *opaque)
{
    sf_state *s = opaque;
    if (!s)
        return;
    sf_gl_close(s->gl);
    sfield_scene_free(s->scene);
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        if (s->occlusion)
            sf_baked_drop(&s->baked, s->occlusion[i]);
        if (s->surface) {
            sf_baked_drop(&s->baked, s->surface[i].self);
            s->surface[i].self = NULL;
            sf_surface_free(&s->surface[i]);
        }
        if (s->bones)
            sf_bones_free(&s->bones[i]);
    }
    free_old_lights(s);
    sf_bounces_free(s->bounces);
    for (size_t i = 0; i < s->light_count; i++) {
        sf_baked_drop(&s->baked, s->light[i]);
        sf_glow_free(&s->glow[i]);
    }
    for (size_t i = 0; s->cache && i <= s->object_count; i++)
        sfield_cache_free(s->cache[i]);
    for (size_t i = 0; s->rgb && s->rgb[i] != (float *)(void *)s; i++) {
        free(s->rgb[i]);
        if (s->gloss)
            free(s->gloss[i]);
        if (s->grazing)
            free(s->grazing[i]);
    }
    sf_baked_free(&s->baked);
    free(s->occlusion);
    free(s->surface);
    free(s->bones);
    free(s->first_bone);
    free(s->same_of);
    free(s->light);
    free(s->light_object);
    free(s->light_of);
    free(s->built);
    free(s->seen);
    free(s->cache);
    free(s->flat_positions);
    free(s->glow);
    free(s->old_light);
    free(s->entities);
    free((void *)(size_t)s->surface_of);
    free(s->taps);
    free(s->rgb);
    free(s->gloss);
    free(s->grazing);
    free(s->material);
    free(s);
}

/* Does what else is set go with bounce=1? Else the error is written. */
static int can_bounce(const rd_job *job, char *error)
{
    const rd_settings *s = job->settings;
    if (!rd_setting_is(s, "bounce", "1") ||
        (!job->gl && rd_setting_is(s, "basis", "sh") && rd_setting_is(s, "product", "triple") &&
         rd_setting_is(s, "lazy", "0") && rd_setting_is(s, "bones", "0")))
        return 1;
    snprintf(error, EX_ERROR_SIZE,
             "shadowfield: bounce=1 needs --backend cpu, basis=sh, product=triple, lazy=0 and bones=0");
    return 0;
}

static int build_bounces(sf_state *s, const rd_job *job, char *error)
{
    const sfield_desc d = desc_of(job, s->basis);
    sfield_result r = SFIELD_OK;
    if (rd_setting_is(job->settings, "bounce", "1"))
        r = sf_bounces_build(&s->bounces, job, s->surface_of, s->entities, &d);
    return r == SFIELD_OK ? 0 : failed("what objects send on", r, error);
}

static sfield_scene_desc scene_desc_of(const rd_job *job, sfield_basis basis)
{
    sfield_scene_desc d;
    memset(&d, 0, sizeof d);
    d.basis = basis;
    d.bands = (uint32_t)rd_setting_integer(job->settings, "bands");
    d.cube_side = (uint32_t)rd_setting_integer(job->settings, "cube_side");
    d.product = rd_setting_is(job->settings, "product", "exp") ? SFIELD_PRODUCT_EXP : SFIELD_PRODUCT_DEFAULT;
    d.reach = (float)rd_setting_number(job->settings, "reach");
    d.system.parallel_for = ex_pool_run;
    d.system.log = ex_pool_log;
    d.system.user = job->pool;
    return d;
}

static int open_shadowfield(void **opaque, const rd_job *job, char *error)
{
    const int lazy = rd_setting_is(job->settings, "lazy", "1");
    const size_t objects = job->scene->object_count, lights = job->scene->light_count + objects + 1;
    sf_state *s = calloc(1, sizeof *s);
    sfield_scene_desc d;
    sfield_result r;
    if (!s)
        return out_of_memory(error);
    s->basis = rd_setting_is(job->settings, "basis", "haar") ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    s->full = rd_setting_is(job->settings, "materials", "full");
    s->gltf = s->full && !rd_setting_is(job->settings, "gloss", "phong");
    s->material = calloc(objects + 1, sizeof *s->material);
    d = scene_desc_of(job, s->basis);
    s->light = calloc(lights, sizeof *s->light);
    s->light_object = calloc(lights, sizeof *s->light_object);
    s->light_of = calloc(lights, sizeof *s->light_of);
    s->built = calloc(lights, sizeof *s->built);
    s->object_count = objects;
    s->cache = lazy ? calloc(objects + 1, sizeof(sfield_cache *)) : NULL;
    s->glow = calloc(lights, sizeof *s->glow);
    s->old_light = calloc(lights, sizeof *s->old_light);
    s->surface_of = calloc(objects + 1, sizeof *s->surface_of);
    s->gloss = calloc(objects + 1, sizeof *s->gloss);
    s->grazing = calloc(objects + 1, sizeof *s->grazing);
    s->rgb = calloc(objects + 1, sizeof *s->rgb);
    if (s->rgb)
        s->rgb[objects] = (float *)(void *)s;            /* the end of the list */
    if (s->basis == SFIELD_BASIS_HAAR && (d.product == SFIELD_PRODUCT_EXP || (job->gl && s->gltf))) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: product=exp and, on GL, gloss=gltf need basis=sh");
    } else if (!job->gl && rd_setting_is(job->settings, "build", "gpu")) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: build=gpu needs --backend gl");
    } else if (lazy && job->gl) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: lazy=1 needs --backend cpu");
    } else if (rd_setting_is(job->settings, "bones", "1") && (s->full || lazy)) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: bones=1 needs materials=diffuse and lazy=0");
    } else if ((lazy && !s->cache) || !s->light || !s->light_object || !s->light_of || !s->built || !s->glow ||
               !s->old_light || !s->surface_of || !s->material || !s->gloss || !s->grazing || !s->rgb) {
        out_of_memory(error);
    } else if ((r = sfield_scene_create(&d, &s->scene)) != SFIELD_OK) {
        failed("scene", r, error);
    } else if (can_bounce(job, error) && sf_baked_open(&s->baked, job, s->basis, error) == 0 &&
               make_meshes(s, job, error) == 0 && build_lights(s, job, error) == 0 &&
               sf_baked_all_used(&s->baked, job, error) == 0 && place(s, job, error) == 0 &&
               build_bounces(s, job, error) == 0 && send_fields(s, job, error) == 0) {
        ex_progress(NULL, 1);
        *opaque = s;
        return 0;
    }
    ex_progress(NULL, 1);
    close_shadowfield(s);
    return -1;
}

static void report_shadowfield(const void *opaque, rd_report *report)
{
    const sf_state *s = opaque;
    uint64_t fields = 0, self = 0, sources = 0, count = 0, caches = 0;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        fields += sfield_bytes(s->occlusion[i]);
        self += sfield_bytes(s->surface[i].self);
        count += s->occlusion[i] != NULL;
        for (size_t k = 0; k < s->bones[i].count; k++) {
            fields += sfield_bytes(s->bones[i].bone[k].occlusion);
            self += sfield_bytes(s->bones[i].bone[k].self);
        }
    }
    for (size_t i = 0; i < s->light_count; i++) {
        size_t first = 0;
        while (s->light[first] != s->light[i])          /* baked ones are shared */
            first++;
        sources += first == i ? sfield_bytes(s->light[i]) : 0;
    }
    for (size_t i = 0; s->cache && i <= s->object_count; i++)
        caches += sfield_cache_bytes(s->cache[i]);
    report->memory_bytes = fields + self + sources + caches;
    report->peak_bytes = s->peak;
    rd_json_text(report->json, "basis", s->basis == SFIELD_BASIS_HAAR ? "haar" : "sh");
    rd_json_integer(report->json, "fields", count);
    rd_json_integer(report->json, "bones", s->bone_count);
    rd_json_integer(report->json, "field_bytes", fields);
    rd_json_integer(report->json, "self_bytes", self);
    rd_json_integer(report->json, "source_bytes", sources);
    rd_json_integer(report->json, "points", s->points);
    rd_json_integer(report->json, "products", s->stats.products);
    rd_json_integer(report->json, "culled", s->stats.culled_far + s->stats.culled_horizon + s->stats.culled_hidden);
    rd_json_integer(report->json, "overlaps", s->stats.overlaps);
    rd_json_integer(report->json, "rooms", s->stats.rooms);
    rd_json_integer(report->json, "reused", s->stats.reused);
    rd_json_integer(report->json, "cache_bytes", caches);
}

static const rd_key keys[] = {
    { "basis", RD_WORD, "sh|haar", 0, 0, "sh", "spherical harmonics, or wavelets for all frequencies" },
    { "bands", RD_INTEGER, NULL, 1, 8, "4", "of spherical harmonics" },
    { "product", RD_WORD, "triple|exp", 0, 0, "triple", "of harmonics; exp: logarithms are added" },
    { "shell_count", RD_INTEGER, "0", 2, 64, "0", "of a field; 0: 16, wavelets 32" },
    { "position_side", RD_INTEGER, "0", 2, 64, "0", "points a side of a shell's six faces; 0: 16, wavelets 32" },
    { "source_position_side", RD_INTEGER, "0", 2, 64, "0", "of what an object emits; 0: position_side" },
    { "source_shell_count", RD_INTEGER, "0", 2, 64, "0", "of that, which is built again when it changes; 0: shell_count" },
    { "bones", RD_WORD, "0|1", 0, 0, "0", "1: meshes that deform are rigid bodies that follow them" },
    { "bounce", RD_WORD, "0|1", 0, 0, "0", "1: rigid objects send light on to one another, once" },
    { "patches", RD_INTEGER, NULL, 1, 192, "24", "of bounce=1: of an object, each as bright as its light" },
    { "bounce_shell_count", RD_INTEGER, NULL, 2, 64, "8", "of bounce=1: as shell_count" },
    { "bounce_position_side", RD_INTEGER, NULL, 2, 64, "8", "of bounce=1: as position_side" },
    { "gloss", RD_WORD, "auto|gltf|phong", 0, 0, "auto",
      "of materials=full: glTF's BRDF, or a lobe as wide; auto: gltf" },
    { "lazy", RD_WORD, "0|1", 0, 0, "0", "1 keeps what hides each light until that moves, or the eye with materials=full" },
    { "build", RD_WORD, "cpu|gpu", 0, 0, "cpu", "where fields of meshes are made; gpu needs --backend gl" },
    { "cube_side", RD_INTEGER, "0", 4, 64, "0", "texels a side of a cube's face, a power of two; 0: 16, wavelets 32" },
    { "keep", RD_NUMBER, NULL, 0, 1, "0", "share of wavelets kept of a cube; 0: 0.01" },
    { "reach", RD_NUMBER, NULL, 0, 1000, "0", "how far objects hide, in radii; 0: their outermost shell" },
    { "point_spacing", RD_NUMBER, NULL, 0.001, 1, "0.02", "of shaded points, in radii of the scene" },
    { "lamp_radius", RD_NUMBER, NULL, 0.001, 1, "0.05", "radius that spots and points get, in radii of the scene" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

const rd_technique rd_shadowfield = {
    "shadowfield", "precomputed shadow fields of moving objects", NULL,
    0, 0, 0, 0, RD_MOST_BAKED, 0, keys, open_shadowfield, update_shadowfield, frame_shadowfield, report_shadowfield,
    close_shadowfield
};
