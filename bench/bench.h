/* bench.h - what the benchmarks share: options, models, lines of JSON. */
#ifndef BN_BENCH_H
#define BN_BENCH_H

#include "common.h"
#include "csm.h"

typedef struct bn_options {
    const char *program;         /* argv[0]: render and compare lie beside it */
    const char *model, *assets;  /* NULL where not given */
    int         threads, full;
    uint32_t    side, m;         /* of gl_csm_build, 0 where not given */
    ex_pool    *pool;            /* of `threads` */
    FILE       *json;            /* copy of the lines, or NULL */
} bn_options;

typedef struct bn_model {        /* one rigid object in world space */
    char      name[64];
    float    *positions;
    uint32_t *indices;
    size_t    vertices, triangles;
    float     low[3], high[3];
} bn_model;

#define BN_MOST_MODELS 8

/* Writes where a file of the assets is; `other` (or NULL) stands for it in a folder that has none. NULL without
   assets, and after a line on stderr where neither is there. */
const char *bn_asset(const bn_options *options, const char *file, const char *other, char path[1024]);
/* Loads --model, or bunny and dragon of the assets, built-in knot and plant in their place. -1: error was printed. */
int        bn_models_load(const bn_options *options, bn_model *models, size_t *count);
int        bn_model_load(bn_model *model, const char *scene);    /* file or builtin:NAME */
int bn_model_flatten(bn_model *model, const ex_scene *scene, uint32_t objects); /* the first; unnamed. -1: memory */
void       bn_model_free(bn_model *model);
cohsm_mesh bn_model_mesh(const bn_model *model);
cohsm_desc bn_desc(const bn_options *options);                   /* with threads and progress */

/* One line of JSON; begin writes what every line has. */
void bn_begin(const bn_options *options, const char *bench, int threads, const char *simd);
void bn_text(const char *name, const char *value);       /* NULL: null */
void bn_number(const char *name, double value);          /* not finite: null */
void bn_integer(const char *name, uint64_t value);
void bn_flag(const char *name, int value);               /* true, false */
void bn_end(const bn_options *options);
const char *bn_simd(void);                               /* what csm.h takes at run time here */

uint32_t bn_random(uint64_t *seed);
float    bn_random_in(uint64_t *seed, float low, float high);

int bn_failed(const char *what, const char *why);        /* one line on stderr; returns -1 */

/* child.c: a program beside this one; its run, 0 for exit status 0, and seconds of the processor that it took (cpu may
   be NULL); a number (not finite: none) and a text ("": none) of the JSON that it wrote. */
void   bn_program(const bn_options *options, const char *name, char path[1024]);
int    bn_start(const char *program, const char *const *arguments, double *cpu);
double bn_read_number(const char *path, const char *name);
void   bn_read_text(const char *path, const char *name, char *out, size_t room);

/* The benchmarks: 0, or -1 after a line on stderr. */
int bn_csm_compression(const bn_options *options);
int bn_csm_query(const bn_options *options);
int bn_csm_scene(const bn_options *options);
int bn_csm_render(const bn_options *options);
int bn_bake_ao(const bn_options *options);
int bn_rsm_gather(const bn_options *options);
int bn_rsm_maps(const bn_options *options);
int bn_rsm_masks(const bn_options *options);
int bn_gl_csm_query(const bn_options *options);
int bn_gl_csm_scene(const bn_options *options);
int bn_gl_csm_render(const bn_options *options);
int bn_gl_csm_build(const bn_options *options);
int bn_gl_ism(const bn_options *options);
int bn_gl_envshadow(const bn_options *options);
int bn_gl_sfield(const bn_options *options);
int bn_sfield_build(const bn_options *options);
int bn_sfield_algebra(const bn_options *options);
int bn_sfield_accuracy(const bn_options *options);
int bn_sfield_places(const bn_options *options);
int bn_sfield_chess(const bn_options *options);
int bn_sfield_crowd(const bn_options *options);
int bn_sfield_bones(const bn_options *options);
int bn_sfield_robots(const bn_options *options);
int bn_sfield_wavelet(const bn_options *options);
int bn_envshadow_lights(const bn_options *options);
int bn_ism(const bn_options *options);
int bn_ism_causes(const bn_options *options);
int bn_ism_frames(const bn_options *options);
int bn_ism_rivals(const bn_options *options);
int bn_ism_vpls(const bn_options *options);
int bn_ism_visibility(const bn_options *options);
int bn_ism_flicker(const bn_options *options);

/* csm_scalar.c: the queries of csm.h built with COHSM_NO_SIMD. */
typedef struct bn_scalar { cohsm_maps *maps; } bn_scalar;
cohsm_result bn_scalar_open(bn_scalar *scalar, const void *block, size_t size, cohsm_layout layout);
cohsm_result bn_scalar_visible(const bn_scalar *scalar, const cohsm_query *query, float *visible);
void         bn_scalar_free(bn_scalar *scalar);

/* tinybvh.cpp: another library of rays, one at a time, where make has TINYBVH=FOLDER. */
typedef struct bn_tinybvh bn_tinybvh;
bn_tinybvh *bn_tinybvh_create(const bn_model *model);           /* NULL: out of memory */
void        bn_tinybvh_free(bn_tinybvh *rays);
const char *bn_tinybvh_version(void);
/* lit[i] = 1 where nothing is in the way. */
void        bn_tinybvh_trace(const bn_tinybvh *rays, const float *points, const float *directions, size_t count,
                             float *lit);

/* rays.c: Embree, or nothing where it is missing. Its own modes come before BN_RAY_MODES, tinybvh after. */
typedef enum bn_ray_mode {
    BN_RAY1, BN_RAY8, BN_RAY16, BN_RAY_STREAM, BN_RAY_MODES, BN_RAY_TINYBVH = BN_RAY_MODES
} bn_ray_mode;
typedef struct bn_rays bn_rays;

bn_rays    *bn_rays_create(const bn_model *model, int threads);  /* NULL: not built in, or it failed */
void        bn_rays_free(bn_rays *rays);
const char *bn_rays_mode_name(bn_ray_mode mode);
const char *bn_rays_version(void);
const char *bn_rays_peer_version(void);     /* tinybvh's, NULL where it is not built in */
/* lit[i] = 1 where nothing is in the way. 0: there is no such mode here. */
int         bn_rays_trace(const bn_rays *rays, bn_ray_mode mode, int coherent, const float *points,
                          const float *directions, size_t count, float *lit);
/* lit[i] = 1 where nothing lies between the two points. */
void        bn_rays_segments(const bn_rays *rays, const float *from, const float *to, size_t count, float *lit);

#endif
