/* ism_parts.h - what the files of the technique ism share: the lit surface points that light becomes. */
#ifndef RD_ISM_PARTS_H
#define RD_ISM_PARTS_H

#include "technique.h"
#include "../../gl_backend/gl_ism.h"
#include "ism.h"

/* One place or direction that light comes from: a whole sun, spot or point light, or a sample of an area light, of an
   emissive mesh or of the sky. */
typedef struct im_lamp {
    enum { IM_FAR, IM_EVEN, IM_COSINE } kind;    /* parallel; the same to all sides; cosine about normal */
    float    position[3];      /* FAR: unit direction to the light */
    float    normal[3];        /* COSINE: of the emitting side */
    float    cos_cone;         /* EVEN: of a spot's half angle; -1 for all sides */
    float    value[3];         /* FAR: W/m^2 facing it; EVEN: W/sr; COSINE: W/sr along the normal */
    uint32_t light;            /* index in scene->lights of sun, spot, point; else UINT32_MAX */
} im_lamp;

/* Pictures from the lamps: reflective shadow maps, one source each. */
typedef struct im_rsms {
    ism_source *sources;
    float     **arrays;        /* of each source: positions, normals, fluxes, areas in one block */
    size_t      count;
    size_t      rings;         /* the last ones of these: not pictures but the ground beyond them */
    im_lamp    *lamps;
    size_t      lamp_count;
    size_t     *first;         /* source that each lamp begins with, and the first one behind all of them */
    uint64_t    key;           /* of all that the pictures show, and their size */
    size_t      kept;          /* pictures, and rings, that are those of the frame before */
} im_rsms;

/* Lights without size and the sky, and with areas area lights and emissive meshes; samples: lamps for the sky, for each
   area light and for the meshes together. */
int  im_lamps_build(im_rsms *out, const rd_job *job, uint32_t samples, int areas, char *error);
/* For the sun and the sky also the ground beyond. last: those of the frame before, or NULL. Pictures of a lamp that is
   as it was there, if the scene is, are taken from it and not rendered: they would have the same bytes. */
int  im_rsms_render(im_rsms *out, im_rsms *last, const rd_job *job, uint32_t size, char *error);
void im_rsms_free(im_rsms *rsms);

/* Light of suns, spots and points that reaches the G-buffer directly, tested against shadow maps of size x size texels,
   drawn one after the other; map_bytes: of the largest, 0 where there is none. */
int  im_direct(ex_image *out, const im_rsms *lamps, const rd_job *job, uint32_t size, size_t *map_bytes, char *error);
/* Emitted light as sources: points on area lights and emissive meshes and, with_sky, directions of the sky; none is no
   error. */
int  im_emission_sources(im_rsms *out, const rd_job *job, uint32_t points, int with_sky, char *error);
void im_emission_free(im_rsms *emission);

/* The scene as one mesh in world space, with an albedo and an opacity for each triangle. casters: with the ground only
   where it is near. Maps of directions cover their mesh: with all the ground, the rest would be a texel of them. */
typedef struct im_origin { const ex_object *object; uint32_t triangle; } im_origin;   /* of a triangle; NULL: ground */
typedef struct im_masked { const ex_scene *scene; const im_origin *origins; } im_masked;

typedef struct im_mesh {
    ism_mesh mesh, casters;
    float *positions, *albedos, *opacities;
    uint32_t *indices;
    im_origin *origins;                          /* where masks cut holes */
    im_masked masked, masked_casters;            /* what mask_fn of the two is given */
} im_mesh;

int  im_mesh_build(im_mesh *out, const rd_job *job, char *error);
void im_mesh_free(im_mesh *mesh);

/* On OpenGL: the maps of a level drawn and its VPLs' light on the picture. view and, after the mesh was built anew,
   moved come before; the pixels must stay until the light is read. All return 0 or -1. */
typedef struct im_gl im_gl;

im_gl *im_gl_open(const rd_job *job, int levels, char *error);
void   im_gl_moved(im_gl *gl);
int    im_gl_view(im_gl *gl, const ex_gbuffer *pixels, char *error);
int    im_gl_draw(im_gl *gl, int level, const ism_desc *desc, const ism_maps *maps, const ism_frame *frame, int no_maps,
                  char *error);
int    im_gl_shade(im_gl *gl, int level, const ism_shading *shading, float *light, double *lost,
                   char *error);
void   im_gl_close(im_gl *gl);

/* What it draws and shades with, to do so again. */
glbk_ism_maps     *im_gl_maps(im_gl *gl, int level);
glbk_ism_renderer *im_gl_renderer(im_gl *gl);
glbk_gbuffer      *im_gl_gbuffer(im_gl *gl);

void im_view(ism_points *out, const rd_job *job);
int  im_failed(const char *what, ism_result result, char *error);    /* both return -1 */
int  im_out_of_memory(char *error);

#endif
