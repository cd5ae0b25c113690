/* receive.h - what of a .glb file gets light: the vertices of its primitives, or the texels of their UV sets. */
#ifndef BAKE_RECEIVE_H
#define BAKE_RECEIVE_H

#include <stddef.h>
#include <stdint.h>

/* A primitive of triangles as the file has it; positions and so on are in its mesh's space. */
typedef struct bk_primitive {
    uint32_t  mesh, number;              /* the mesh, and which of its primitives */
    int       accessors[3];              /* POSITION, NORMAL, COLOR_0 */
    uint32_t  vertex_count, triangle_count;
    float    *positions, *normals;       /* unit; the mean of the triangles' where the file has none */
    float    *uvs[2];                    /* or NULL */
    float    *colors;                    /* RGBA, linear, or NULL */
    uint32_t *indices;
    uint8_t  *used;                      /* 1: a triangle has the vertex */
    int       material;                  /* -1: none */
    uint32_t owner; /* the first primitive of the mesh that has these vertices: those are kept there */
} bk_primitive;

typedef struct bk_primitives { bk_primitive *list; uint32_t count; } bk_primitives;

/* What gets one array of values: the vertices of a primitive and of those that share them, or an image. */
typedef struct bk_sheet {
    uint32_t  mesh;
    uint32_t *primitives, primitive_count;   /* numbers in bk_primitives */
    uint32_t  side;                          /* of the image; 0: vertices */
    int       uv;                            /* of the image: TEXCOORD_0 or _1 */
    size_t    first, count;                  /* receivers */
} bk_sheet;

typedef struct bk_receivers {
    size_t    count;
    float    *positions, *normals;           /* in the mesh's space */
    uint32_t *places;                        /* the vertex or texel of each */
    bk_sheet *sheets;
    uint32_t  sheet_count;
} bk_receivers;

typedef enum bk_into { BK_INTO_AUTO, BK_INTO_VERTEX, BK_INTO_TEXTURE } bk_into;

/* All return 0, or -1 with one line in error. */
int  bk_primitives_read(bk_primitives *out, const char *path, char *error);
void bk_primitives_free(bk_primitives *primitives);
/* Receivers of all meshes for which wanted is not 0; of each sheet they lie along a curve through space. auto: an image
   where a UV set has no overlaps, else vertices; texture: an error where there is none. */
int  bk_receivers_make(bk_receivers *out, const bk_primitives *primitives, const uint8_t *wanted, uint32_t mesh_count,
                       bk_into into, uint32_t side, char *error);
void bk_receivers_free(bk_receivers *receivers);

#endif
