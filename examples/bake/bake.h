/* bake.h - what the files of the program `bake` share: options, the object that is baked, files, the two techniques. */
#ifndef BAKE_H
#define BAKE_H

#include "../common/common.h"
#include "../common/scene.h"
#include "../render/settings.h"

#include <stddef.h>
#include <stdint.h>

struct cohsm_domain;

/* bake csm --domain: where maps look from; all zero is the default. */
typedef struct bk_domain {
    const char *text, *path;            /* as typed, or NULL; the file of places, or NULL */
    int         number;                 /* of the table in domain.c */
    float       numbers[12], *locations;
    size_t      count;                  /* x, y, z, w each */
} bk_domain;

/* One rigid object: triangles in its own space, or the whole file's in world space. */
typedef struct bk_mesh {
    float    *positions;
    uint32_t *indices;
    size_t    vertices, triangles;
    uint32_t *lit;                      /* as sfield_build_emissive takes them: where both sides shine, twice */
    float    *radiance;                 /* of each of these; NULL, like lit, where nothing shines */
    size_t    lit_count;
    ex_scene  scene;                    /* where it is from */
    char      node[64];
    const bk_domain *domain;            /* of csm; NULL: the default */
    const char *path;
    int         as_film;                /* lit has both sides of what may shine, so that all frames have the same */
    const char *lamp_text;              /* or it is a lamp, as render's --light says it, and has no triangles */
    ex_light    lamp;
} bk_mesh;

/* Points on it, for its self-visibility. */
typedef struct bk_points { float *positions, *normals, offset; size_t count; } bk_points;

/* What a shard takes, relative to others: its units', and of each row of units that it touches what it needs however
   few of the row are its own; where it begins and ends within the object, it looks into overhang rows more. */
typedef struct bk_work { double *unit, *row, overhang; uint32_t units, row_units; } bk_work;

/* A technique bakes units (pixels of maps, shells) from..to of all into one file's bytes. Functions return 0, or -1
   with one line in error; bytes are freed with free(). */
typedef struct bk_technique {
    const char   *name;
    const rd_key *keys;
    int (*settle)(rd_settings *settings, const bk_mesh *mesh, ex_pool *pool, char *error);
    /* writes into the settings what depends on the object; may be NULL */
    int (*plan)(const rd_settings *settings, const bk_mesh *mesh, uint32_t *units, double *seconds, char *error);
    /* units: of the whole; seconds: about how long all of them take on one core */
    void        (*weigh)(const rd_settings *settings, const bk_mesh *mesh, bk_work *work);
    /* fills unit, and row with row_units and overhang, of zeros and one unit a row: the same in every shard */
    int         (*bake)(const rd_settings *settings, const bk_mesh *mesh, uint32_t from, uint32_t to, ex_pool *pool,
                        void **data, size_t *size, char *error);
    int         (*merge)(const void *const *parts, const size_t *sizes, size_t count, int packed, void **data,
                         size_t *size, char *error);
    int         (*info)(const void *data, size_t size, char *line, size_t room, char *error);
    int (*verify)(const rd_settings *settings, const void *data, size_t size, const bk_mesh *mesh, ex_pool *pool,
                  char *line, size_t room, char *error); /* 1: wrong */
} bk_technique;

extern const bk_technique bk_csm, bk_shadowfield;

/* ---- the command line ---- */

enum { BK_MOST_FILES = 1024 };

typedef struct bk_args {
    const char  *command;
    const bk_technique *technique;      /* of csm, shadowfield, merge, info and verify */
    const char  *out, *files[BK_MOST_FILES];
    size_t       file_count;
    uint32_t     shard, shards;         /* 1 of 1 */
    int          threads;
    char         node[64];
    const char  *env;                   /* --env, or NULL */
    const char  *lights[64];            /* --light, as typed */
    size_t       light_count;
    const char  *points;                /* --points, or NULL */
    bk_domain    domain;                /* --domain */
    const char  *report;                /* --report, or NULL */
    const char *const *parts;           /* merge: shards of a bake into a model, in order; else NULL */
    size_t       part_count;
    rd_settings  settings;
} bk_args;

/* Fills error with what, then value; returns -1. */
int bk_fail(char *error, const char *what, const char *value);

/* The other commands: each with its keys, and a function that does it. */
extern const rd_key bk_ao_keys[], bk_model_keys[], bk_lights_keys[];
extern const rd_key bk_light_keys[], bk_probes_keys[];
int bk_probes_run(const bk_args *args, char *error);
int bk_light_run(const bk_args *args, char *error);
int bk_lights_run(const bk_args *args, char *error);
int bk_ao_run(const bk_args *args, char *error);
int bk_model_run(const bk_args *args, char *error);
int bk_sky_run(const bk_args *args, char *error);          /* shadowfield with kind=sky */

/* ---- work.c: many values, computed in parts that are kept, or in shards ---- */

typedef struct bk_items {
    size_t   count, unit;               /* items, and floats of each */
    uint64_t key;                       /* of all that decides the values */
    double   seconds;                   /* about how long all take on one core */
    void    *context;
    /* items from..to - 1 into out; the same whatever the range is */
    int    (*compute)(void *context, size_t from, size_t to, float *out, char *error);
} bk_items;

/* All values into *values, for free(); or this shard's into args->out, and *values is NULL. Parts on the way are kept
   beside args->out as they become whole, and removed by bk_items_done. */
int  bk_items_run(const bk_args *args, const bk_items *items, float **values, char *error);
void bk_items_done(const bk_args *args, const bk_items *items);
/* Whether a file is a shard of these: its command and settings go into args, whose tables of keys follow the command.
 */
int  bk_part_look(const void *data, size_t size, char *command, size_t room);
int  bk_part_settings(const void *data, size_t size, bk_args *args, char *error);

uint64_t bk_hash(uint64_t h, const void *data, size_t size);      /* FNV-1a; begin with BK_HASH */
#define BK_HASH 1469598103934665603u
uint64_t bk_hash_settings(uint64_t h, const bk_args *args);

/* domain.c: 0, or -1 with one line in error. Load reads or makes its places, for free(). */
int         bk_domain_parse(bk_domain *out, const char *text, char *error);
int         bk_domain_load(bk_domain *domain, const bk_mesh *mesh, const rd_settings *settings, char *error);
void        bk_domain_sides(const bk_domain *domain, const rd_settings *settings, uint32_t side[3]);
void        bk_domain_fill(const bk_domain *domain, const rd_settings *settings, struct cohsm_domain *out);
const char *bk_domain_name(int kind);       /* of a cohsm_domain_kind */

/* files.c: whole files; writing goes to another name first, so that a file with its own name is always complete. */
int  bk_read(const char *path, void **data, size_t *size, char *error);
int  bk_write(const char *path, const void *data, size_t size, char *error);

/* object.c: what casts shadows in a scene, or node=NAME of it in its own space. */
int  bk_object(bk_mesh *out, const char *path, const char *node, char *error);
/* The same object with the radiance of each of so many frames, one after another; its triangles must rest. */
int  bk_film(bk_mesh *out, const bk_mesh *mesh, uint32_t frames, double frames_per_second, char *error);
void bk_object_free(bk_mesh *mesh);
/* Its vertices as they are, or with spacing > 0 the points that `render --set point_spacing=` shades. */
int  bk_points_of(bk_points *out, const bk_mesh *mesh, float spacing, char *error);
void bk_points_free(bk_points *points);

#endif
