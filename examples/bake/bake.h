/* bake.h - what the files of the program `bake` share: options, the object that is baked, files, the two techniques. */
#ifndef BAKE_H
#define BAKE_H

#include "../common/common.h"
#include "../common/scene.h"
#include "../render/settings.h"

#include <stddef.h>
#include <stdint.h>

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
} bk_mesh;

/* Points on it, for its own visibility. */
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

/* files.c: whole files; writing goes to another name first, so that a file with its own name is always complete. */
int  bk_read(const char *path, void **data, size_t *size, char *error);
int  bk_write(const char *path, const void *data, size_t size, char *error);

/* object.c: what casts shadows in a scene, or node=NAME of it in its own space. */
int  bk_object(bk_mesh *out, const char *path, const char *node, char *error);
void bk_object_free(bk_mesh *mesh);
/* Its vertices as they are, or with spacing > 0 the points that `render --set point_spacing=` shades. */
int  bk_points_of(bk_points *out, const bk_mesh *mesh, float spacing, char *error);
void bk_points_free(bk_points *points);

#endif
