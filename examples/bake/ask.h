/* ask.h - which directions see the sky from many points at once: by maps of csm.h, or by Embree's rays. Points are
   asked in groups that lie close together, one direction for all points of a group, which is what both are fastest at.
 */
#ifndef BAKE_ASK_H
#define BAKE_ASK_H

#include "bake.h"

/* bk_ask_open takes AUTO as EMBREE where there is a distance, else as CSM. */
typedef enum bk_engine { BK_ENGINE_AUTO, BK_ENGINE_CSM, BK_ENGINE_EMBREE } bk_engine;

typedef struct bk_ask_desc {
    bk_engine engine;
    uint32_t  side;                  /* side x side directions, in cells of equal solid angle */
    uint32_t  map_side;
    float     distance;              /* what is further away does not count; 0: everything does */
    int       has_ground;
    float     ground;                /* height of a plane that hides what is below it */
    int       self_only;             /* only the receiver's own object is in the way */
} bk_ask_desc;

/* Points of one group that face a direction, and which of them see it. */
typedef struct bk_answer {
    const uint32_t *points;          /* numbers within what bk_ask_all was given */
    const float    *cosines, *visible;
    size_t          count;
    float           direction[3];    /* in the mesh's space, */
    float           world[3];        /* and in the world's: unit */
} bk_answer;

typedef void (*bk_take)(void *user, const bk_answer *answer); /* called from many threads, for other points each */

typedef struct bk_ask bk_ask;

/* All return 0, or -1 with one line in error. The scene must outlive what is opened. */
int         bk_ask_open(bk_ask **out, const bk_ask_desc *desc, const ex_scene *scene, ex_pool *pool, char *error);
bk_engine   bk_ask_engine(const bk_ask *ask);
/* By which of the two side x side directions of so many points of each mesh take less time, of which a share of `open`
   sees the sky; the same on every machine. */
bk_engine   bk_ask_cheaper(const bk_ask *ask, uint32_t side, const size_t *points, double open);
/* Other directions, side x side of them, for what was opened with rays. */
int         bk_ask_turn(bk_ask *ask, uint32_t side, char *error);
/* Points from..to - 1 of a mesh's, each direction of the hemisphere about its normal, once for each object of the mesh.
 */
int         bk_ask_all(bk_ask *ask, uint32_t mesh, const float *positions, const float *normals, size_t from, size_t to,
                       bk_take take, void *user, char *error);
void        bk_ask_close(bk_ask *ask);

/* rays.c: Embree, or nothing where it is missing. */
typedef struct bk_rays bk_rays;
int      bk_rays_there(void);
bk_rays *bk_rays_create(const float *positions, size_t vertices, const uint32_t *indices, size_t triangles);
/* visible[i] = 1 where nothing is in the way of a ray within the distance; directions: one for all, or `each` its own.
 */
void     bk_rays_trace(const bk_rays *rays, const float *points, const float *directions, int each, size_t count,
                       float distance, float *visible);
void     bk_rays_free(bk_rays *rays);

#endif
