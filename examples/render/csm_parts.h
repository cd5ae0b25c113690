/* csm_parts.h - what the files of the technique csm share: settings, shadow casters with maps, lights. */
#ifndef RD_CSM_PARTS_H
#define RD_CSM_PARTS_H

#include "technique.h"
#include "csm.h"
#include "lightsampling.h"

#include <pthread.h>

/* Counts what the header asks for; several threads may ask at once. */
typedef struct cs_memory { size_t now, peak; pthread_mutex_t lock; } cs_memory;

typedef struct cs_options {      /* --set, resolved */
    uint32_t     side, map_side;             /* of the maps of directions */
    uint32_t     light_side, light_map_size; /* of the maps of places on lights */
    uint32_t     hard_size;                  /* pixels a side of the map of a light without size */
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_orientation orientation;           /* of maps of directions */
    uint32_t     depth_bits;
    float        open_thickness;             /* map pixels */
    cohsm_layout layout;
    cohsm_filter filter;
    float        bias, offset;               /* map pixels: towards the light, and along the geometric normal */
    int          semi, shared_sun, whole;
    int          emitters_cast;              /* emissive triangles shadow their own light */
} cs_options;

/* How far from its centre an object's maps can shadow: see csm_ask.c. */
typedef struct cs_reach { float center[3], radius, slack; } cs_reach;

/* Objects with maps of one domain: what cohsm_visible_scene takes. */
typedef struct cs_casters {
    cohsm_instance *instances;
    float          *offsets;     /* of each: world units that a receiver on it moves along its geometric normal */
    cs_reach       *reach;
    size_t          count;
    int             movable;     /* rigid objects, each with maps of its own space: cs_casters_move may do */
    cohsm_maps    **maps;        /* distinct ones; instances share them */
    int             borrowed;    /* they are a file's of --baked, which keeps them */
    size_t          map_count;
    uint32_t       *entity;      /* by object of the scene, counted from 1; 0 for receivers */
} cs_casters;

/* A flat object that only receives (the ground) has no maps: it counts as an infinite plane, and a sample on its other
   side is not lit. */
typedef struct cs_plane { float normal[3], distance; uint32_t object; } cs_plane;

typedef struct cs_light {
    lsamp_light    *emitter;
    lsamp_light_desc desc;     /* that it was made from */
    void             *memory;    /* of the emitter */
    size_t            bytes;
    int               is_mesh;   /* emissive triangles */
    int               is_delta;  /* sun, spot, point: one sample is enough */
    int               at_infinity;
    const ex_light   *wide_spot; /* a cone above 180 degrees, treated as a point light and cut here */
    uint32_t          map_side;  /* of its own maps */
    uint32_t          object;    /* in scene->objects, of an emissive mesh */
    float             sun[3];    /* direction, where is_delta and at_infinity */
    cohsm_light_kind       ask;
    const cs_casters *casters;
    cs_casters        own;       /* maps for this light alone */
} cs_light;

/* Room for the samples that one object is asked about. */
typedef struct cs_near { float *point, *light, *answer; uint32_t *sample; } cs_near;

/* Triangles without order, indexed; source: the triangle of its object that each is of, or NULL. */
typedef struct cs_soup { float *positions; uint32_t *indices, *source; size_t vertices, triangles; } cs_soup;

typedef struct cs_baked cs_baked;

typedef struct cs_state {
    cs_options  options;
    cs_memory   memory;
    cs_light   *lights;
    size_t      light_count, area_count;     /* area_count: those that samples are shared among */
    cs_plane   *planes;
    size_t      plane_count;
    cs_casters  directions;      /* maps of all directions, for sky and semi-local light */
    cs_baked   *baked;           /* files of --baked */
    size_t      baked_count;
    float       sphere[4];       /* centre and radius of all casters, where there are such files */
    int         full;            /* materials=full */
    uint64_t    queries, refused;
    struct cs_gl *gl;            /* --backend gl, else NULL */
} cs_state;

typedef struct cs_gl cs_gl;

int  cs_out_of_memory(char *error);          /* all three return -1 */
int  cs_failed(const char *what, cohsm_result result, char *error);
int  cs_refused(uint64_t samples, char *error);

void cs_memory_init(cs_memory *memory);
cohsm_allocator cs_memory_allocator(cs_memory *memory);

/* csm_maps.c. direction: NULL, or unit and towards a sun: each caster gets one map, of that direction. */
int  cs_casters_build(cs_casters *casters, cs_state *state, const rd_job *job, const float *direction, char *error);
/* Whole static scene as one rigid object with maps of places on a light, whose own emissive triangles cast no shadow
   unless options say so. */
int  cs_casters_build_local(cs_casters *casters, cs_state *state, const rd_job *job, const cohsm_domain *domain,
                            const cs_light *light, char *error);
/* The sphere that csm.h fits to all casters, centre and radius. */
int  cs_casters_sphere(const rd_job *job, float sphere[4], char *error);
/* The whole scene as one rigid object whose maps, of either kind, are there; they stay the caller's. */
int  cs_casters_of(cs_casters *casters, const cs_state *state, const rd_job *job, cohsm_maps *maps, char *error);
void cs_casters_free(cs_casters *casters);
/* Instances to where the objects are now. 0: the casters must be built anew. */
int  cs_casters_move(cs_casters *casters, const cs_state *state, const ex_scene *scene);

int  cs_planes_build(cs_plane **planes, size_t *count, const ex_scene *scene, char *error);

/* csm_cut.c: adds to what count found, without the holes of alpha masks; dark: without emissive triangles */
int  cs_has_holes(const ex_scene *scene, const ex_object *object);

/* The same holes as they are: a mask_fn of csm.h and envshadow.h, whose `user` is a cs_masked. */
typedef struct cs_masked { const ex_scene *scene; const ex_object *object; } cs_masked;
int  cs_is_there(void *masked, uint32_t triangle, const float weights[3]);
void cs_soup_count(const ex_scene *scene, const ex_object *object, size_t *vertices, size_t *triangles);
void cs_soup_add(cs_soup *soup, const ex_scene *scene, const ex_object *object, const float *transform, int dark);

/* csm_ask.c: query->positions, lights and entities are packed arrays */
cohsm_result cs_visible(const cs_casters *casters, const cohsm_query *query, cs_near *near, float *visible,
                        size_t *refused);

/* csm_lights.c */
int  cs_lights_build(cs_state *state, const rd_job *job, char *error);       /* lights alone, no maps yet */
int  cs_light_domain(const cs_light *light, const cs_options *options, cohsm_domain *out, char *error);
void cs_light_free(cs_light *light);

/* csm_baked.c: files of --baked. Directions and places return 1 with casters whose maps one of the files has, 0 if none
   fits, or -1. After all lights were asked for, all_used refuses a file that served none of them. */
int  cs_baked_open(cs_state *state, const rd_job *job, char *error);
int  cs_baked_begin(cs_state *state, const rd_job *job, char *error);     /* before lights ask, of each frame */
void cs_baked_close(cs_state *state);
int  cs_baked_directions(cs_state *state, const rd_job *job, cs_casters *out, char *error);
int  cs_baked_places(cs_state *state, const rd_job *job, const cohsm_domain *domain, cs_casters *out, char *error);
int  cs_baked_all_used(const cs_state *state, char *error);

/* csm_gl.c: --backend gl. open after everything is built. */
int  cs_gl_open(cs_state *state, const rd_job *job, char *error);
int  cs_gl_frame(cs_state *state, const rd_job *job, ex_image *out, char *error);
void cs_gl_close(cs_state *state);

#endif
