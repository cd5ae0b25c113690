/* internal.h - what the files of examples/common share among themselves: small vectors and a mesh builder. */
#ifndef EX_INTERNAL_H
#define EX_INTERNAL_H

#include "common.h"
#include <math.h>

#define EX_PI 3.14159265358979323846f

typedef struct v3 { float x, y, z; } v3;

static inline v3 v3_make(float x, float y, float z) { v3 r = {x, y, z}; return r; }
static inline v3 v3_load(const float *p) { v3 r = {p[0], p[1], p[2]}; return r; }
static inline void v3_store(float *p, v3 a) { p[0] = a.x; p[1] = a.y; p[2] = a.z; }
static inline v3 v3_add(v3 a, v3 b) { return v3_make(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline v3 v3_sub(v3 a, v3 b) { return v3_make(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline v3 v3_scale(v3 a, float s) { return v3_make(a.x * s, a.y * s, a.z * s); }
static inline v3 v3_mad(v3 a, v3 b, float s) { return v3_add(a, v3_scale(b, s)); }
static inline float v3_dot(v3 a, v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline float v3_length(v3 a) { return sqrtf(v3_dot(a, a)); }
static inline v3 v3_cross(v3 a, v3 b)
{
    return v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Unit vector, or `otherwise` where the length is zero, tiny or not a number. */
static inline v3 v3_unit_or(v3 a, v3 otherwise)
{
    float length = v3_length(a);
    return length > 1e-30f && length < 1e30f ? v3_scale(a, 1.0f / length) : otherwise;
}

static inline v3 v3_unit(v3 a) { return v3_unit_or(a, v3_make(0, 1, 0)); }
static inline int v3_finite(v3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
static inline float ex_clamp(float x, float low, float high) { return x < low ? low : x > high ? high : x; }
static inline float ex_mix(float a, float b, float t) { return a + (b - a) * t; }
static inline float ex_smooth(float low, float high, float x)    /* 0 below low, 1 above high, smooth between */
{
    float t = ex_clamp((x - low) / (high - low), 0, 1);
    return t * t * (3 - 2 * t);
}

static inline float ex_srgb_to_linear(float s)
{
    return s <= 0.04045f ? s / 12.92f : powf((s + 0.055f) / 1.055f, 2.4f);
}

v3 ex_transform_point(const float m[16], v3 p);
v3 ex_transform_vector(const float m[16], v3 p);
v3 ex_transform_normal(const float m[16], v3 n);   /* by the cofactors; not normalised; winding sign included */
float ex_determinant(const float m[16]);           /* of the upper 3 x 3 */
void ex_identity(float m[16]);
void ex_multiply(float out[16], const float a[16], const float b[16]);   /* out may be a or b */
void ex_place(float m[16], v3 position, float yaw, float scale);         /* scale, turn about +Y, move */

int  ex_fail(char *error, const char *format, ...);   /* fills error, returns -1 */
int  ex_grow(void *array, uint32_t *count, size_t item_size);   /* one zeroed item more; array is a T** */

/* Grows a mesh; out of memory is remembered in `failed`, so that scene code needs one check at its end. */
typedef struct ex_builder {
    ex_scene *scene;
    ex_mesh   mesh;                    /* the one being built */
    size_t    vertex_room, triangle_room;
    int       with_uvs;                /* room for uvs too, zero until written */
    int       split;                   /* no smooth normal of a finished mesh may face away from its triangle */
    int       failed;
} ex_builder;

ex_builder ex_build_begin(ex_scene *scene);
uint32_t ex_build_material(ex_builder *b, float red, float green, float blue);
uint32_t ex_build_vertex(ex_builder *b, v3 position, v3 normal);
void ex_build_triangle(ex_builder *b, uint32_t i, uint32_t j, uint32_t k, uint32_t material);
void ex_build_quad(ex_builder *b, v3 p, v3 q, v3 r, v3 s, uint32_t material);    /* flat, counter-clockwise */
void ex_build_box(ex_builder *b, v3 low, v3 high, uint32_t material);            /* closed */
void ex_build_lathe(ex_builder *b, const float *profile, uint32_t points, uint32_t sides, float crease,
                    uint32_t material);
/* Turns points (radius, height), from the bottom's axis point to the top's, about +Y; first and last radius are 0.
   Normals are smooth where the profile bends by less than crease radians. Closed. */
void ex_build_tube(ex_builder *b, const v3 *path, const float *radii, uint32_t points, uint32_t sides,
                   uint32_t material);
/* Sweeps a circle along an open path, its frame carried along without twist; a cone to the end point ends it. */
/* Shapes of shapes.c. Closed unless a surface's flags leave it open; bevels > 0 may not eat a whole face. */
typedef struct ex_mark { uint32_t vertex, triangle; } ex_mark;
ex_mark ex_build_mark(const ex_builder *b);
void ex_build_transform(ex_builder *b, ex_mark since, const float m[16]);                /* what was built since */
void ex_build_copy(ex_builder *b, ex_mark since, ex_mark until, const float m[16]);
void ex_build_ring(ex_builder *b, ex_mark since, uint32_t count);    /* count - 1 more of it, turned about +Y */
typedef v3 (*ex_surface)(const void *context, float u, float v);     /* u, v in 0..1 */
enum { EX_WRAP = 1, EX_TIP_LOW = 2, EX_TIP_HIGH = 4 };   /* u = 1 is u = 0; v = 0, v = 1 is one point */
void ex_build_surface(ex_builder *b, ex_surface fn, const void *context, uint32_t across, uint32_t along, int flags,
                      uint32_t material);
/* A grid of across x along quads that faces where dp/du x dp/dv points; smooth. */
void ex_build_panel(ex_builder *b, v3 corner, v3 u, v3 v, uint32_t across, uint32_t along, uint32_t material);
/* A flat grid that faces u x v. */
void ex_build_ball(ex_builder *b, v3 center, v3 radii, uint32_t sides, uint32_t material);
void ex_build_prism(ex_builder *b, const float (*outline)[2], uint32_t points, float low, float high, float bevel,
                    uint32_t material);
/* An outline in x, y, counter-clockwise and star-shaped about its mean, from z = low to high. */
void ex_build_block(ex_builder *b, v3 low, v3 high, float bevel, uint32_t material);     /* a box, edges cut off */
void ex_build_tile(ex_builder *b, v3 corner, float wide, float deep, float bevel, float sunk, uint32_t material);
/* The top of a floor tile from corner along +X and +Z, its edges cut down by `sunk`; side by side they make a
   floor. */
/* Cloth that hangs from a straight edge; the front faces to the right of from -> to seen from above. */
typedef struct ex_drape {
    v3    from, to;
    float length, fold_depth, folds, wind, phase;    /* wind: radians it leans at the hem, about */
} ex_drape;
void ex_build_drape(ex_builder *b, const ex_drape *drape, float time, uint32_t across, uint32_t along,
                    uint32_t material);
float ex_random(uint32_t *state);                            /* in [0, 1), the same on every machine */

uint32_t ex_build_finish(ex_builder *b);                     /* hands the mesh to the scene, returns its index */
int  ex_build_replace(ex_builder *b, uint32_t mesh);         /* puts it in the place of a mesh that deforms; 0 or -1 */
void ex_build_camera(ex_builder *b, v3 eye, v3 target, float fovy_degrees);
ex_light *ex_build_light(ex_builder *b, ex_light_kind kind); /* the rest zeroed; NULL when failed */
ex_object *ex_build_object(ex_builder *b, const char *name, uint32_t mesh);      /* at the origin; NULL when failed */
int  ex_smooth_normals(ex_mesh *mesh);                       /* fills in zero ones from the faces; -1: no memory */
void ex_mesh_free(ex_mesh *mesh);

/* The built-in scenes. build: everything that does not depend on time; meshes that deform may be left empty. pose: the
   rest, see ex_scene_set_time; 0, or -1 for out of memory. */
void ex_build_cornell(ex_builder *b);
void ex_build_knot(ex_builder *b);
int  ex_pose_chess(ex_scene *scene, float time);
int  ex_pose_knot(ex_scene *scene, float time);
void ex_build_plant(ex_builder *b);
void ex_build_chess(ex_builder *b);
void ex_build_uroom(ex_builder *b);
void ex_build_corridor(ex_builder *b);
void ex_build_atrium(ex_builder *b);
int  ex_pose_atrium(ex_scene *scene, float time);
void ex_build_cloth(ex_builder *b);
int  ex_pose_cloth(ex_scene *scene, float time);
void ex_build_figure(ex_builder *b);
int  ex_pose_figure(ex_scene *scene, float time);
void ex_build_robots(ex_builder *b);
int  ex_pose_robots(ex_scene *scene, float time);
void ex_build_spaceships(ex_builder *b);
int  ex_pose_spaceships(ex_scene *scene, float time);
void ex_build_explosion(ex_builder *b);
int  ex_pose_explosion(ex_scene *scene, float time);

uint32_t ex_build_plant_mesh(ex_builder *b);                 /* with its pot; 1 metre high, on the floor */
void ex_build_horse(ex_builder *b, uint32_t material);       /* head and neck of the chess knight, metres, faces +X */

/* Loads through whatever glTF parser was built in; see gltf.c. */
int  ex_gltf_load(ex_scene *scene, const char *path, char *error);

/* What moves a glTF scene: rig.h. */
typedef struct ex_rig ex_rig;
void ex_rig_free(ex_rig *rig);                       /* NULL is allowed */
const char *ex_rig_problem(const ex_rig *rig);       /* why the last pose failed */

/* What ex_scene_add_figures keeps: guest.c. */
typedef struct ex_guest ex_guest;
int  ex_guest_pose(ex_scene *scene, float time, char *error);
void ex_guest_free(ex_guest *guest);                 /* NULL is allowed */

/* Whether stb may read a .hdr file: it is whole, and neither reading nor using it takes more than ex_memory_limit. -1
   with one line in error. */
int  ex_hdr_check(const char *path, char *error);

/* stb behind functions, see png.c. Pixels of read are malloc'ed, 3 numbers each. */
int  ex_stb_read_hdr(const char *path, uint32_t *width, uint32_t *height, float **rgb, char *error);
int  ex_stb_read_png16(const char *path, uint32_t *width, uint32_t *height, uint16_t **rgb, char *error);

#endif
