/* shadowfield_parts.h - what the files of the technique shadowfield share: the points of an object that are shaded, and
   how pixels are interpolated among them. */
#ifndef RD_SHADOWFIELD_PARTS_H
#define RD_SHADOWFIELD_PARTS_H

#include "technique.h"
#include "shadowfield.h"

/* Points on one mesh, in its own space: its vertices, and more inside of large triangles. */
typedef struct sf_surface {
    float    *positions, *normals;      /* 3 a point */
    uint32_t *triangles;                /* 3 points each */
    uint32_t *material;                 /* number of each point's */
    uint32_t *corners;                  /* of each point: 3 vertices of the mesh between which it lies, and ... */
    float    *shares;                   /* ... their 3 weights */
    size_t    point_count, triangle_count;
    uint32_t *chosen;                   /* those that are shaded; the others take from three of them */
    size_t    chosen_count;
    uint32_t *sources;
    float    *weights;
    float    *chosen_positions, *chosen_normals;
    float    *chosen_exponent, *chosen_material;        /* of Phong's lobe; as sfield_points.materials */
    sfield_field *self;                 /* of the chosen ones */
} sf_surface;

/* As in sfield_points.materials: its roughness, of no metal. Pixels lay their color and metal over the results. */
void sf_material(const ex_material *material, float values[5]);

/* Where a pixel takes its light from: three points of its object's surface; weight sum 1, or 0 where there is none. */
typedef struct sf_tap { uint32_t point[3]; float weight[3]; } sf_tap;

/* spacing: in the mesh's units. piece: a number of each vertex; light is not interpolated between points of different
   ones. NULL: it is, wherever they are near. 0, or -1: out of memory. */
int  sf_surface_build(sf_surface *surface, const ex_scene *scene, const ex_mesh *mesh, float spacing,
                      const uint32_t *piece);
void sf_surface_free(sf_surface *surface);
void sf_surface_follow(sf_surface *surface, const ex_mesh *mesh);       /* to where the vertices are now */

/* bones=1 (shadowfield_bones.c): a mesh that deforms as rigid bodies that follow it. */
typedef struct sf_bone {
    uint32_t     *vertex;               /* by which it follows */
    float        *rest;                 /* where those were in the first frame */
    size_t        vertex_count;
    ex_mesh       hull;                 /* closed and convex, as in the first frame: no normals, no materials */
    float         inner;                /* how far the hull is from its middle at least, in radii */
    float         transform[16];        /* from the first frame to now, in the mesh's space: rotation, scale, shift */
    sfield_field *occlusion, *self;     /* of the hull; of its points by its own triangles. Freed with the bone */
} sf_bone;
typedef struct sf_bones {
    sf_bone  *bone;
    size_t    count;
    uint32_t *of_vertex;                /* number of the bone that it lies on */
    uint32_t *piece;                    /* of each vertex: number of what hangs together, before pieces were joined */
    uint32_t *order;                    /* chosen points of the surface, bone by bone */
    size_t   *first;                    /* of each bone, and one more: where its points begin in `order` */
    float    *positions, *normals;      /* of the points, in that order, each in the space of its bone */
} sf_bones;

/* The first two: 0, or -1: out of memory. follow: to where mesh and surface are now. triangles: those of a bone, to be
   freed, three times as many numbers in *count; NULL: out of memory. */
int  sf_bones_build(sf_bones *bones, const ex_mesh *mesh);
int  sf_bones_points(sf_bones *bones, const sf_surface *surface);
void sf_bones_follow(sf_bones *bones, const ex_mesh *mesh, const sf_surface *surface);
uint32_t *sf_bone_triangles(const sf_bones *bones, const ex_mesh *mesh, size_t bone, size_t *count);
void sf_bones_free(sf_bones *bones);

/* taps: one for each pixel; surface: by object, NULL entries are left alone. */
int  sf_taps_build(sf_tap *taps, const rd_job *job, const sf_surface *const *surfaces);

/* What an object emits, as a mesh for sfield_build_emissive: a row for each side of its triangles; dark ones hide. */
typedef struct sf_glow { uint32_t *indices; float *radiance; uint32_t count; } sf_glow;

/* 0, or -1: out of memory. */
int  sf_glow_build(sf_glow *glow, const ex_scene *scene, const ex_object *object);
int  sf_glow_same(const sf_glow *a, const sf_glow *b);
void sf_glow_free(sf_glow *glow);

/* A lamp about the centre of its field, of radiance 1; lamp_radius: of points and spots. -1: not of a kind that shadow
   fields treat. */
int  sf_emitter_of(const ex_light *light, float lamp_radius, sfield_emitter *out);

/* --baked (shadowfield_baked.c): what bake has written, by bounding sphere and, of sources and points, by what a few
   positions see. Instances share a field: those of the files live until sf_baked_free, and others are freed by
   sf_baked_drop. NULL: build it. */
typedef struct sf_baked { sfield_field **field; int *used; size_t count; } sf_baked;
int  sf_baked_open(sf_baked *baked, const rd_job *job, sfield_basis basis, char *error);
int  sf_baked_all_used(const sf_baked *baked, const rd_job *job, char *error);      /* else -1: one is no object's */
sfield_field *sf_baked_occlusion(sf_baked *baked, const ex_mesh *mesh);
sfield_field *sf_baked_source(sf_baked *baked, const ex_mesh *mesh, const sf_glow *glow, float time);
sfield_field *sf_baked_lamp(sf_baked *baked, const sfield_emitter *emitter);
sfield_field *sf_baked_self(sf_baked *baked, const sfield_desc *desc, const ex_mesh *mesh, const sf_surface *surface,
                            float offset);
void sf_baked_drop(const sf_baked *baked, sfield_field *field);
void sf_baked_free(sf_baked *baked);

/* bounce=1 (shadowfield_bounce.c): one interreflection between objects that hide and do not shine. light: shades their
   patches under what shines, and gives the entities what they send on. What build has begun, free takes back. */
typedef struct sf_bounces sf_bounces;
sfield_result sf_bounces_build(sf_bounces **out, const rd_job *job, const sf_surface *const *surface_of,
                               const sfield_entity *entities, const sfield_desc *desc);
sfield_result sf_bounces_light(sf_bounces *bounces, sfield_scene *scene, sfield_entity *entities, size_t entity_count);
void          sf_bounces_free(sf_bounces *bounces);

/* On OpenGL (shadowfield_gl.c): fields, NULL ones left out, go up; then sf_gl_shade does what sfield_shade does for
   sets with their own rgb, and with gloss where it was asked for. */
typedef struct sf_gl sf_gl;
typedef enum sf_gloss { SF_DULL, SF_PHONG, SF_GLTF } sf_gloss;
sf_gl *sf_gl_open(const rd_job *job, const sfield_field *const *fields, size_t field_count, size_t entity_count,
                  sf_gloss gloss, char *error);
int    sf_gl_fields(sf_gl *gl, const rd_job *job, const sfield_field *const *fields, size_t field_count,
                    size_t entity_count, char *error);       /* others in their place */
int    sf_gl_shade(sf_gl *gl, const rd_job *job, const sfield_scene *scene, const sfield_entity *entities,
                   size_t entity_count, const sfield_points *sets, size_t set_count, char *error);
void   sf_gl_close(sf_gl *gl);

#endif
