/* product.h - the parts of the page "product": a model under a sky that turns, drawn by csm.h's maps in WebGL 2.
   product.c has what the page calls, product_model.c the model on the GPU and the mesh that maps are built of,
   product_draw.c the passes of a frame. The page runs this program twice: beside the picture, and in a worker that
   builds maps. */
#ifndef WEB_PRODUCT_H
#define WEB_PRODUCT_H

#include "../gl_backend/gl_csm.h"
#include "../examples/common/common.h"

typedef struct pd_part {            /* triangles of one object with one material */
    uint32_t object, material;
    uint32_t first, count;          /* of the index buffer */
} pd_part;

typedef struct pd_mesh {            /* a mesh of the scene on the GPU, triangles in the order of materials */
    uint32_t    vertex_array;
    glbk_buffer vertices, indices;
} pd_mesh;

typedef struct pd_model {
    ex_scene      scene;            /* without its sky; the ground is its last object */
    float         center[3], radius;/* without the ground */
    float         ground;           /* its height */
    pd_mesh      *meshes;           /* one a mesh of the scene; NULL until pd_model_upload */
    pd_part      *parts;
    uint32_t      part_count;
    glbk_texture *textures;         /* one a texture of the scene */
} pd_model;

/* Loads a file, or builtin:NAME, and adds the ground. 0, or -1 with one line in error (EX_ERROR_SIZE). */
int  pd_model_load(pd_model *model, const char *path, char *error);
int  pd_model_upload(pd_model *model, glbk_context *gl, char *error);
void pd_model_free(pd_model *model, glbk_context *gl);      /* gl may be NULL where nothing was uploaded */
/* Fills the G-buffer. world: turns the scene, before its own transforms. */
int  pd_model_draw(const pd_model *model, glbk_context *gl, glbk_gbuffer *seen, const float clip[16], const float eye[3],
                   const float world[16]);
/* All that casts shadows as one object in world space. The arrays are freed by the caller. 0, or -1: out of memory. */
int  pd_model_merge(const pd_model *model, float **positions, size_t *vertex_count, uint32_t **indices,
                    size_t *index_count);

typedef struct pd_view {            /* what the page asks for */
    float azimuth, elevation, distance;     /* of the camera about the model, radians, and in radii of the model */
    float up;                       /* how far above the model's centre it looks, in radii */
    float sky_turn;                 /* radians about +Y */
    float exposure;                 /* factor of the automatic one */
    uint32_t samples;               /* a pixel and frame */
    int   show_sky;                 /* the sky itself behind the model, in place of a plain backdrop */
} pd_view;

typedef struct pd_picture {
    glbk_context      *gl;
    uint32_t           width, height;
    glbk_gbuffer       seen;
    glbk_csm_renderer  renderer;
    glbk_csm_lights    lights;      /* the sky */
    uint32_t           sky_start;
    glbk_texture       sky;         /* its texels, for the backdrop */
    float              sky_light;   /* what a white surface that looks up reflects of it, luminance */
    float              sky_mean[3];
    glbk_csm_maps      maps;        /* none until pd_picture_maps */
    float              offset;      /* of receivers, world */
    glbk_texture       light;       /* of this frame; sum[now] has the mean of all */
    glbk_texture       sum[2];
    glbk_target        light_target, sum_target[2];
    int                now;
    glbk_program       mix, show;
    uint32_t           window;      /* the framebuffer that is shown: 0 in a page */
    uint32_t           frames;      /* in the mean */
} pd_picture;

int  pd_picture_create(pd_picture *picture, glbk_context *gl, char *error);
void pd_picture_free(pd_picture *picture);
int  pd_picture_resize(pd_picture *picture, uint32_t width, uint32_t height, char *error);
int  pd_picture_sky(pd_picture *picture, const ex_sky *sky, char *error);
int  pd_picture_maps(pd_picture *picture, const void *block, size_t bytes, float radius, char *error);
/* Adds a frame to the mean, or begins a new one, and shows it. */
int  pd_picture_frame(pd_picture *picture, const pd_model *model, const pd_view *view, int anew, char *error);

#endif
