/* model.h - a .glb file that light is baked into: its scene, what of it receives light, and the file that is changed.
 */
#ifndef BAKE_MODEL_H
#define BAKE_MODEL_H

#include "bake.h"
#include "glb.h"
#include "receive.h"

typedef struct bk_file bk_file;      /* that is written beside the model */

typedef struct bk_model {
    ex_scene      scene;
    bk_glb        glb;
    bk_primitives primitives;
    bk_receivers  receivers;
    uint32_t     *primitive_values;      /* of each primitive: the number of its object in the JSON */
    uint32_t     *materials;             /* of the file: the numbers of their objects */
    uint32_t      material_count;
    uint32_t     *users;                 /* of each material: primitives that have it */
    bk_text       members, extras;       /* of the materials of the sheet whose images are being added */
    bk_file      *files;
    size_t        file_count;
} bk_model;

typedef enum bk_format { BK_PNG, BK_RGBE, BK_HDR, BK_EXR } bk_format;

/* full: what a whole pixel of a PNG stands for, where the file shall say so; else 0. */
typedef struct bk_image_desc { int bits, dilate, denoise; bk_format format; float full; } bk_image_desc;

/* All return 0, or -1 with one line in error. */
int   bk_model_open(bk_model *model, const char *path, bk_into into, uint32_t image_side, char *error);
void  bk_model_close(bk_model *model);
float bk_model_lowest(const bk_model *model);        /* height of the lowest vertex of the scene */

/* Values of a sheet's receivers as COLOR_0: channels is 1 or 3; what is there already is multiplied, or replaced. */
void  bk_model_colors(bk_model *model, const bk_sheet *sheet, const float *values, int channels, int bits, int replace);
/* Three floats of each receiver as an attribute. */
void  bk_model_vectors(bk_model *model, const bk_sheet *sheet, const char *name, const float *values);
/* Values as an image, for the sheet's materials: channels 1 is a grey one from 0 to 1 that becomes a member of that
   name, 3 are vectors from -1 to 1 that become one of the material's extras. bk_model_materials ends the sheet. */
int   bk_model_image(bk_model *model, const bk_sheet *sheet, const char *name, const float *values, int channels,
                     const bk_image_desc *desc, char *error);
/* Three values of each receiver as a light map, member `name` of the materials' extras: of a PNG from 0 to 1, of the
   other formats as they are. .hdr and .exr become files beside `out`, written by bk_model_write. */
int   bk_model_map(bk_model *model, const bk_sheet *sheet, const char *name, const float *values,
                   const bk_image_desc *desc, const char *out, char *error);
/* Gives the images to the materials of the sheet's primitives: a copy of a material that others have too. */
int   bk_model_materials(bk_model *model, const bk_sheet *sheet, char *error);
/* The files beside it first: after an error those are gone again that were not there before. */
int   bk_model_write(bk_model *model, const char *path, char *error);

void  bk_unit_or(float *v, const float *otherwise);  /* unit length; or the other vector */

/* image.c: texels of a sheet as a picture; everything that no chart covers is filled from charts up to `dilate` texels
   away, the rest by the mean of all. */
float *bk_image_fill(const bk_receivers *receivers, const bk_sheet *sheet, const float *values, int channels,
                     const bk_image_desc *desc);
/* A PNG of values 0..1, for free(). NULL: out of memory. */
void  *bk_image_png(const float *values, uint32_t side, int channels, int bits, size_t *size);

/* maps.c: pictures of any values that are not negative (.exr: of any), for free(); NULL: out of memory. */
void  *bk_image_rgbe(const float *rgb, uint32_t side, size_t *size);     /* a PNG whose alpha is the exponent */
void  *bk_image_hdr(const float *rgb, uint32_t side, size_t *size);
void  *bk_image_exr(const float *rgb, uint32_t side, int half, size_t *size);
int    bk_files_write(bk_model *model, char *error);
void   bk_files_remove(bk_model *model);         /* those that were not there before */
void   bk_files_free(bk_model *model);

#endif
