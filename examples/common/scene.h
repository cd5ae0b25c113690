/* scene.h - what a renderer has anyway: meshes, materials, lights, a camera, a sky.
   Part of examples/common, the small library behind the example programs. The Dapple headers never see these types:
   they take plain arrays. Conventions: right-handed, +Y up, column-major float[16], linear Rec. 709 radiance in
   W/(sr m^2), angles in radians, directions have unit length. */
#ifndef EX_SCENE_H
#define EX_SCENE_H

#include <stddef.h>
#include <stdint.h>

typedef struct ex_texture {      /* 8-bit sRGB RGBA as glTF stores base colours; row 0 is v = 0 */
    uint32_t width, height;
    uint8_t *rgba;
} ex_texture;

typedef struct ex_material {
    float base_color[3];         /* linear albedo, multiplied by the texture where there is one */
    float emission[3];           /* emitted radiance, W/(sr m^2) */
    float metallic, roughness;   /* metal-rough GGX; used by materials=full only */
    float alpha_cutoff;          /* > 0: texels below it are holes (glTF alpha mask) */
    int   double_sided;
    int   base_texture;          /* index into ex_scene.textures, -1 for none */
    int   normal_texture;        /* the same, of normals in tangent space; by ex_normal_maps alone */
    int   rough_texture;         /* the same, g multiplies roughness and b metallic, neither is sRGB */
} ex_material;

typedef struct ex_mesh {         /* one piece in its own space, indexed triangles */
    float    *positions;         /* 3 per vertex, finite */
    float    *normals;           /* 3 per vertex, unit shading normals, always present */
    float    *uvs;               /* 2 per vertex or NULL */
    uint32_t *indices;           /* 3 per triangle, all < vertex_count */
    uint32_t *materials;         /* 1 per triangle, index into ex_scene.materials */
    uint32_t  vertex_count, triangle_count;
    uint16_t *parts;             /* 1 per vertex: the joint of a skin that moves it most, or NULL */
    int       deforms;           /* vertices or materials change with time; all other meshes are rigid */
} ex_mesh;

typedef struct ex_object {       /* a mesh placed in the world; several objects may share a mesh */
    char     name[48];
    uint32_t mesh;
    float    transform[16];      /* object to world, affine */
    uint32_t material;           /* 0: each triangle its own; else 1 + the index of the material of all of them */
    int      receiver_only;      /* planar or convex receiver (a ground plane) that need not cast shadows */
} ex_object;

typedef enum ex_light_kind {
    EX_LIGHT_SUN, EX_LIGHT_SPOT, EX_LIGHT_POINT, EX_LIGHT_SPHERE, EX_LIGHT_RECT, EX_LIGHT_DISC, EX_LIGHT_LINE
} ex_light_kind;

typedef struct ex_light {
    ex_light_kind kind;
    float position[3];           /* spot, point, sphere and disc centre; rect corner; line start */
    float direction[3];          /* sun: towards the sun; spot: out of the lamp; disc: normal; unit length */
    float u[3], v[3];            /* rect: edges, emits along u x v; line: u = end - start */
    float radius;                /* sphere, disc, line */
    float cos_half_angle;        /* spot: hard cone of uniform intensity */
    float value[3];              /* sun E (W/m^2); spot, point I (W/sr); others L (W/(sr m^2)), one-sided */
} ex_light;

typedef struct ex_sky {          /* latitude-longitude radiance; row 0 is +Y, the centre is +X */
    uint32_t width, height;      /* 0 = no sky */
    float   *rgb;                /* scale already applied */
    float    rotation;           /* about +Y, by the right-hand rule */
} ex_sky;

typedef struct ex_camera {
    float eye[3], target[3], up[3];
    float fovy;
} ex_camera;

typedef struct ex_scene {
    char         name[64];
    ex_mesh     *meshes;    uint32_t mesh_count;
    ex_object   *objects;   uint32_t object_count;
    ex_material *materials; uint32_t material_count;
    ex_texture  *textures;  uint32_t texture_count;
    ex_light    *lights;    uint32_t light_count;
    ex_sky       sky;
    ex_camera    camera;    int has_camera;
    uint32_t     skipped_vertices, skipped_triangles;   /* non-finite, out of range or degenerate; never loaded */
    int          animated;       /* another `time` would change it: a built-in scene, or a glTF file's animation */
    int        (*pose)(struct ex_scene *, float time);  /* how; NULL = nothing moves. For ex_scene_set_time */
    struct ex_rig *rig;          /* what moves a glTF file; NULL for other scenes */
    struct ex_guest *guest;      /* the file whose figures were added; NULL = none */
} ex_scene;

#define EX_ERROR_SIZE 256        /* room that every char *error argument must have; one line, no newline */

/* All return 0, or -1 with error filled in and *scene zeroed, if not said otherwise. */
int  ex_scene_load(ex_scene *scene, const char *path, char *error);                 /* .glb, .gltf */
extern int ex_normal_maps;       /* not 0: ex_scene_load reads normal maps and maps of roughness and metal, too; 0 at
                                    first, as few programs use them */
extern int ex_animation;         /* number of the animation that ex_scene_load reads, with skins and morph targets, for
                                    ex_scene_set_time; before it, a scene is as the file holds it at rest. -1, at first:
                                    none of that, vertices are those of the file */
int  ex_scene_builtin(ex_scene *scene, const char *name, float time, char *error);  /* a name of ex_scene_names() */
const char *const *ex_scene_names(void);                                            /* NULL-terminated */
/* Moves an animated scene: transforms, lights, emission and meshes that deform. Objects, meshes, materials and lights
   keep their numbers, what was added behind them stays as it is, and the bytes are those of a new scene at that time.
   Does nothing to other scenes. After an error (out of memory) the scene is whole but may be between two times. */
int  ex_scene_set_time(ex_scene *scene, float time, char *error);
/* Adds the meshes of a glTF file that are under a skin or have morph targets, once, with the file's origin at `at`; its
   other meshes, lights and camera stay out. Set ex_animation before. They move by ex_scene_set_time. After an error the
   scene can only be freed. */
int  ex_scene_add_figures(ex_scene *scene, const char *path, const float at[3], char *error);
void ex_scene_keep_figures(ex_scene *scene);   /* as they are: they do not move any more */
int  ex_sky_load(ex_sky *sky, const char *path, char *error);                       /* .hdr */
int  ex_sky_builtin(ex_sky *sky, const char *name, char *error);                    /* sky, overcast, studio, uniform */
const char *const *ex_sky_names(void);
void ex_scene_free(ex_scene *scene);
void ex_sky_free(ex_sky *sky);

/* Derived facts */
uint64_t ex_scene_triangles(const ex_scene *scene);                       /* of all objects, instances counted each */
int      ex_scene_bounds(const ex_scene *scene, float center[3], float *radius);   /* no receivers; -1 = empty */
int      ex_scene_has_emitters(const ex_scene *scene);
int      ex_scene_add_ground(ex_scene *scene);                         /* plane of albedo 0.5 under it, receiver_only */
void     ex_scene_default_camera(ex_scene *scene, uint32_t width, uint32_t height); /* docs/programs.md */
/* Unit direction of the point (x, y) of an unrotated map, in texels from its top left corner; (0.5, 0.5) is the centre
   of the first texel. */
void     ex_sky_texel_direction(uint32_t width, uint32_t height, float x, float y, float direction[3]);
void     ex_sky_radiance(const ex_sky *sky, const float direction[3], float rgb[3]); /* bilinear */

/* Index of the material that a triangle of an object's mesh has on this object. */
static inline uint32_t ex_object_material(const ex_scene *scene, const ex_object *object, uint32_t triangle)
{
    return object->material ? object->material - 1 : scene->meshes[object->mesh].materials[triangle];
}

/* Colour of a point of a triangle: base colour times texture, linear. barycentric: weights of its three corners.
   Returns 0 where the alpha mask cuts a hole, else 1. Any ray tracer needs the same answer as the rasteriser. */
int      ex_surface_color(const ex_scene *scene, const ex_object *object, uint32_t triangle,
                          const float barycentric[3], float albedo[3]);

#endif
