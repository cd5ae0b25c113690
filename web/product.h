/* product.h - the page "product": a model under a sky that turns, drawn by csm.h's maps in WebGL 2. product.c has
   what the page calls, product_draw.c the light; the rest is what all pages share (stage.h). The page runs this
   program twice: beside the picture, and in a worker that builds maps. */
#ifndef WEB_PRODUCT_H
#define WEB_PRODUCT_H

#include "../gl_backend/gl_csm.h"
#include "stage.h"

typedef struct pd_question {         /* how the maps are asked */
    cohsm_filter   filter;
    float          bias;            /* as in glbk_csm_frame_desc */
    float          offset;          /* of receivers, in radii of the model */
    lsamp_sampling sampling;
} pd_question;

typedef struct pd_picture {
    pg_stage           stage;
    glbk_csm_renderer  renderer;
    glbk_csm_lights    lights;      /* the sky */
    uint32_t           sky_start;
    glbk_csm_maps      maps;        /* none until pd_picture_maps */
    float              radius;      /* of the model that the maps are of */
    pd_question        how;         /* set at will */
} pd_picture;

/* Loads a file, or builtin:NAME. 0, or -1 with one line in error (EX_ERROR_SIZE). */
int  pd_model_load(pg_model *model, const char *path, char *error);

int  pd_picture_create(pd_picture *picture, glbk_context *gl, char *error);
void pd_picture_free(pd_picture *picture);
int  pd_picture_resize(pd_picture *picture, uint32_t width, uint32_t height, char *error);
int  pd_picture_sky(pd_picture *picture, const ex_sky *sky, char *error);
int  pd_picture_maps(pd_picture *picture, const void *block, size_t bytes, float radius, char *error);
/* Adds a frame of so many samples a pixel to the mean, or begins a new one, and shows it. sky_turn: radians about
   +Y. */
int  pd_picture_frame(pd_picture *picture, const pg_model *model, const pg_view *view, float sky_turn, uint32_t samples,
                      int anew, char *error);

#endif
