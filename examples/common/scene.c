/* scene.c - scenes as a whole: by name or by file, freeing, bounds, ground, the default camera. */
#include "internal.h"
#include <stdlib.h>
#include <string.h>

static const char *const scene_names[] = {"cornell", "chess", "plant", "knot", "uroom", "corridor", "atrium", "cloth",
                                          "figure", "robots", "spaceships", "explosion", NULL};

const char *const *ex_scene_names(void) { return scene_names; }

/* In the order of the names. build makes the scene, pose puts it where it is at a time; NULL where nothing moves. */
typedef struct builtin { void (*build)(ex_builder *); int (*pose)(ex_scene *, float); } builtin;
static const builtin builtins[] = {
    {ex_build_cornell, NULL}, {ex_build_chess, ex_pose_chess}, {ex_build_plant, NULL}, {ex_build_knot, ex_pose_knot},
    {ex_build_uroom, NULL}, {ex_build_corridor, NULL}, {ex_build_atrium, ex_pose_atrium},
    {ex_build_cloth, ex_pose_cloth}, {ex_build_figure, ex_pose_figure},
    {ex_build_robots, ex_pose_robots}, {ex_build_spaceships, ex_pose_spaceships},
    {ex_build_explosion, ex_pose_explosion}};

static int build(ex_scene *scene, const builtin *recipe, float time)
{
    ex_builder b = ex_build_begin(scene);
    b.split = 1;
    recipe->build(&b);
    ex_mesh_free(&b.mesh);
    scene->pose = recipe->pose;
    scene->animated = recipe->pose != NULL;
    return b.failed ? -1 : ex_scene_set_time(scene, time, NULL);
}

int ex_scene_builtin(ex_scene *scene, const char *name, float time, char *error)
{
    memset(scene, 0, sizeof *scene);
    for (int i = 0; scene_names[i]; i++) {
        if (strcmp(name, scene_names[i]) != 0) continue;
        snprintf(scene->name, sizeof scene->name, "builtin:%s", name);
        if (build(scene, &builtins[i], time) == 0) return 0;
        ex_scene_free(scene);
        return ex_fail(error, "scene %s: out of memory", name);
    }
    return ex_fail(error, "no built-in scene is called '%s'", name);
}

int ex_scene_set_time(ex_scene *scene, float time, char *error)
{
    if (!scene->pose || scene->pose(scene, time) == 0) return scene->guest ? ex_guest_pose(scene, time, error) : 0;
    return ex_fail(error, "%s: %.180s", scene->name, scene->rig ? ex_rig_problem(scene->rig) : "out of memory");
}

int ex_normal_maps;
int ex_animation = -1;

int ex_scene_load(ex_scene *scene, const char *path, char *error)
{
    memset(scene, 0, sizeof *scene);
    if (ex_gltf_load(scene, path, error) != 0) {
        ex_scene_free(scene);
        return -1;
    }
    const char *slash = strrchr(path, '/');
    snprintf(scene->name, sizeof scene->name, "%s", slash ? slash + 1 : path);
    return 0;
}

void ex_scene_free(ex_scene *scene)
{
    for (uint32_t i = 0; i < scene->mesh_count; i++) ex_mesh_free(&scene->meshes[i]);
    for (uint32_t i = 0; i < scene->texture_count; i++) free(scene->textures[i].rgba);
    free(scene->meshes);
    free(scene->objects);
    free(scene->materials);
    free(scene->textures);
    free(scene->lights);
    ex_rig_free(scene->rig);
    ex_guest_free(scene->guest);
    ex_sky_free(&scene->sky);
    memset(scene, 0, sizeof *scene);
}

uint64_t ex_scene_triangles(const ex_scene *scene)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < scene->object_count; i++) sum += scene->meshes[scene->objects[i].mesh].triangle_count;
    return sum;
}

/* Calls for the world position of every vertex of every object but the receivers. */
typedef void (*vertex_fn)(double state[7], v3 p);

static uint64_t for_vertices(const ex_scene *scene, vertex_fn fn, double state[7])
{
    uint64_t visited = 0;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[object->mesh];
        if (object->receiver_only) continue;
        visited += mesh->vertex_count;
        for (size_t k = 0; k < mesh->vertex_count; k++)
            fn(state, ex_transform_point(object->transform, v3_load(mesh->positions + 3 * k)));
    }
    return visited;
}

static void grow_box(double s[7], v3 p)
{
    double c[3] = {(double)p.x, (double)p.y, (double)p.z};
    for (int k = 0; k < 3; k++) {
        if (c[k] < s[k]) s[k] = c[k];
        if (c[k] > s[k + 3]) s[k + 3] = c[k];
    }
}

static void grow_radius(double s[7], v3 p)
{
    double x = (double)p.x - s[0], y = (double)p.y - s[1], z = (double)p.z - s[2], d = x * x + y * y + z * z;
    if (d > s[6]) s[6] = d;
}

/* Box of everything that casts shadows; state is low, high. A ground plane would drown the rest. */
static int scene_box(const ex_scene *scene, double box[7])
{
    for (int k = 0; k < 3; k++) { box[k] = 1e300; box[k + 3] = -1e300; }
    return for_vertices(scene, grow_box, box) ? 0 : -1;
}

int ex_scene_bounds(const ex_scene *scene, float center[3], float *radius)
{
    double box[7], sphere[7] = {0};
    if (scene_box(scene, box) != 0) return -1;
    for (int k = 0; k < 3; k++) {
        center[k] = (float)(0.5 * (box[k] + box[k + 3]));
        sphere[k] = (double)center[k];
    }
    for_vertices(scene, grow_radius, sphere);
    *radius = (float)sqrt(sphere[6]);
    return 0;
}

int ex_scene_has_emitters(const ex_scene *scene)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_mesh *mesh = &scene->meshes[scene->objects[i].mesh];
        for (uint32_t t = 0; t < mesh->triangle_count; t++) {
            const float *e = scene->materials[ex_object_material(scene, &scene->objects[i], t)].emission;
            if (e[0] > 0 || e[1] > 0 || e[2] > 0) return 1;
        }
    }
    return 0;
}

int ex_scene_add_ground(ex_scene *scene)
{
    float center[3], radius;
    double box[7];
    if (ex_scene_bounds(scene, center, &radius) != 0 || scene_box(scene, box) != 0) return -1;
    ex_builder b = ex_build_begin(scene);
    uint32_t grey = ex_build_material(&b, 0.5f, 0.5f, 0.5f);
    if (!b.failed) scene->materials[grey].double_sided = 1;
    float h = 200 * (radius > 0 ? radius : 1);      /* to a third of a degree below the default camera's horizon */
    ex_build_quad(&b, v3_make(-h, 0, h), v3_make(h, 0, h), v3_make(h, 0, -h), v3_make(-h, 0, -h), grey);
    ex_object *object = ex_build_object(&b, "ground", ex_build_finish(&b));
    if (!object) return -1;
    object->receiver_only = 1;
    v3_store(object->transform + 12, v3_make(center[0], (float)box[1], center[2]));
    return 0;
}

/* What docs/programs.md says of a scene without a camera: the bounding sphere fills 85 % of the shorter side, seen from
   azimuth 30 (from +Z towards +X, since glTF models face +Z) and elevation 20 degrees. A sphere of radius r at distance
   d covers the half angle asin(r / d), and fills a share f of a picture whose half side is tan(fov / 2) when tan of
   that angle is f tan(fov / 2). */
void ex_scene_default_camera(ex_scene *scene, uint32_t width, uint32_t height)
{
    const float fovy = 40 * EX_PI / 180, azimuth = EX_PI / 6, elevation = EX_PI / 9;
    float center[3] = {0, 0, 0}, radius = 1;
    if (ex_scene_bounds(scene, center, &radius) != 0 || !(radius > 0)) radius = 1;
    float half = tanf(fovy / 2);
    if (width < height && width > 0) half *= (float)width / (float)height;
    float distance = radius / sinf(atanf(0.85f * half));
    v3 to_eye = v3_make(cosf(elevation) * sinf(azimuth), sinf(elevation), cosf(elevation) * cosf(azimuth));
    ex_camera *camera = &scene->camera;
    memset(camera, 0, sizeof *camera);
    v3_store(camera->target, v3_load(center));
    v3_store(camera->eye, v3_mad(v3_load(center), to_eye, distance));
    camera->up[1] = 1;
    camera->fovy = fovy;
    scene->has_camera = 1;
}
