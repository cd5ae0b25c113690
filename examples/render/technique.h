/* technique.h - the small interface between the program `render` and the techniques that it runs.

   A technique is one rd_technique in the table of techniques.c. main.c loads the scene, resolves lights and settings,
   renders the G-buffer and calls
       open    once: build whatever is precomputed (timed as precompute_ms)
       update  before a frame whose scene differs from the last one (its time counts as the frame's); where it is NULL,
               the technique is closed and opened again
       frame   once per frame: fill `out`, one value per G-buffer pixel (timed as frame_ms)
       report  once, at the end: sizes and the technique's own figures
       close   once; accepts NULL
   With --backend gl, job->gl is a context that is current in all of these calls; a technique with a GL path does its
   work there (and stands in the list of rd_technique_has_gl); frame still fills `out`. main.c averages aa x aa
   sub-pixels and frames, adds what background=1 and emission=1 ask for, and writes files. */
#ifndef RD_TECHNIQUE_H
#define RD_TECHNIQUE_H

#include "../../gl_backend/gl_programs.h"
#include "../common/common.h"
#include "json.h"
#include "settings.h"

/* One emissive triangle in world space. It emits from the side that v0, v1, v2 turn round counter-clockwise. */
typedef struct rd_emitter {
    float    v[3][3];
    float    normal[3];        /* unit, of the emitting side */
    float    area;             /* > 0 */
    uint32_t object, triangle; /* in scene->objects and in that object's mesh */
    uint32_t material;         /* radiance: scene->materials[material].emission; both sides where double_sided */
} rd_emitter;

/* All light of a picture: scene->lights (the file's and --light), scene->sky (width 0 = none) and the emitters. */
typedef struct rd_job {
    const ex_scene    *scene;          /* the same object for all frames; its contents change when it is animated */
    const ex_gbuffer  *gbuffer;        /* aa times as wide and high as the picture */
    const rd_emitter  *emitters;
    size_t             emitter_count;
    float              center[3];      /* bounding sphere of the scene without the ground that ground=1 adds */
    float              radius;
    float              ring[4];        /* centre and radius that the setting `lamp_count` goes by */
    uint32_t           ring_count;     /* the last ones of scene->lights */
    ex_light           sun;            /* the first one of scene->lights as it is at time 0, for `sun_turn` */
    uint32_t           sun_number;     /* which of them it is */
    double             sun_turn;       /* degrees a second; 0 = no sun moves */
    const rd_settings *settings;       /* rd_setting_text(), _integer(), _number() */
    const char *const *baked;          /* --baked FILE, each */
    size_t             baked_count;
    uint32_t           samples;        /* for each G-buffer pixel, i.e. --samples over aa * aa, rounded up */
    uint32_t           aa;
    uint32_t           frames;
    uint32_t           frame;          /* 0 .. frames - 1 */
    float              time;           /* seconds, of an animated scene as it is now */
    uint32_t           seed;           /* --seed + frame */
    int                threads;
    ex_pool           *pool;
    glbk_context      *gl;             /* --backend gl, else NULL */
} rd_job;

enum { RD_MOST_BAKED = 64 };           /* --baked, of all techniques the most */

typedef struct rd_technique {
    const char   *name;
    const char   *summary;             /* for --list */
    const char   *missing;             /* NULL, or why this build cannot run it; nothing below is used then */
    uint32_t      samples;             /* default of --samples; below least_samples: by other settings */
    uint32_t      least_samples, most_samples;     /* both 0: --samples is refused */
    int           averages;            /* averages the frames of a static scene; else the last frame is written */
    int           accepts_baked;       /* reads files of --baked */
    int           last_alone;          /* of an animated scene it draws the last frame alone: it keeps nothing from
                                          frame to frame */
    const rd_key *keys;                /* its own --set keys, ended by a NULL name */
    int         (*open)(void **state, const rd_job *job, char *error);
    int         (*update)(void *state, const rd_job *job, char *error);
    int         (*frame)(void *state, const rd_job *job, ex_image *out, char *error);   /* out: zeroed */
    void        (*report)(const void *state, rd_report *report);
    void        (*close)(void *state);
} rd_technique;                        /* functions return 0, or -1 with one line in error */

const rd_technique *const *rd_techniques(void);                 /* NULL-terminated */
const rd_technique        *rd_technique_find(const char *name); /* NULL when unknown */
int                        rd_technique_has_gl(const rd_technique *technique);

/* Emissive triangles of every object, in order; *out is freed with free(). -1: out of memory. */
int rd_emitters_build(const ex_scene *scene, rd_emitter **out, size_t *count);

extern const rd_technique rd_csm;
extern const rd_technique rd_envshadow;
extern const rd_technique rd_shadowfield;
extern const rd_technique rd_rsm;
extern const rd_technique rd_ism;
extern const rd_technique rd_reference;

#endif
