/* envshadow_parts.h - what the files of the technique "envshadow" share: envshadow.c (lights, shading, settings),
   envshadow_casters.c (what casts shadows), envshadow_gl.c (--backend gl). */
#ifndef RD_ENVSHADOW_PARTS_H
#define RD_ENVSHADOW_PARTS_H

#include "envlights.h"
#include "envshadow.h"
#include "technique.h"
#include "csm_parts.h"

/* What the header has asked for; it asks from one thread only. */
typedef struct es_memory { size_t now, peak; } es_memory;

/* A mesh that casts shadows: an object's, or what is left of it where an alpha mask cuts holes. */
typedef struct es_caster {
    envsh_mesh   mesh;
    const float *transform;
    float       *positions;      /* its own where there are holes, else NULL */
    uint32_t    *indices;
    cs_masked    masked;         /* what the mesh's mask_fn is given */
    int          moves, receiver_only;
} es_caster;

typedef struct es_gl es_gl;

enum { ES_MOST_CHOSEN = 64 };    /* the most lights that capacity=auto holds at once */

typedef struct es_state {
    es_memory     memory;
    envlt_lights *sky;           /* NULL: no sky */
    envlt_light  *lights;        /* of the frame: the sky's, turned, then the suns */
    uint32_t      sky_count, count;
    envsh_maps   *maps;          /* with GL: layout and matrices only, of all lights */
    uint32_t      cluster, rgba; /* lights that are held at once */
    int           choose_cluster;   /* not 0: the first frame on GL finds it */
    es_caster    *casters;       /* one an object */
    uint32_t      caster_count;
    envsh_query   query;
    envsh_points  receivers;     /* all pixels */
    float *points, *normals, *geometric, *irradiance; /* of all pixels; where nothing is seen, normals are 0 */
    double       *sum;           /* jitter=1: of the frames so far */
    size_t        pixels;
    float         residual[27];
    int           has_residual;
    envlt_stats   stats;
    envsh_info   atlas;
    double        lights_ms, maps_ms, shade_ms;
    es_gl        *gl;            /* --backend gl, else NULL */
} es_state;

/* Both return -1. */
int es_failed(const char *what, const char *why, char *error);
int es_refuse(const char *why, char *error);

/* envshadow_casters.c */
/* Anew, after each change. cut: not 0 where holes are cut out of the meshes, as the GPU draws triangles as they are. */
int          es_casters_build(es_state *s, const ex_scene *scene, int cut, char *error);
void         es_casters_free(es_state *s);
envsh_bounds es_casters_bounds(const es_state *s);      /* without those that only receive */
envsh_result es_casters_draw(const es_state *s, envsh_maps *maps);

/* envshadow_gl.c */
int  es_gl_open(es_state *s, const rd_job *job, char *error);
int  es_gl_update(es_state *s, char *error);             /* casters that moved */
int  es_gl_frame(es_state *s, const rd_job *job, char *error);      /* fills s->irradiance */
void es_gl_report(const es_state *s, rd_report *report);
void es_gl_close(es_state *s);

#endif
