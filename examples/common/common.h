/* common.h - images, primary visibility, threads and progress for the example programs. See scene.h for conventions. */
#ifndef EX_COMMON_H
#define EX_COMMON_H

#include "scene.h"
#include <stdio.h>

/* ---- images: 3 floats a pixel, rows from the top down ---- */

typedef struct ex_image { uint32_t width, height; float *rgb; } ex_image;

int   ex_image_alloc(ex_image *image, uint32_t width, uint32_t height);
void  ex_image_free(ex_image *image);
/* .pfm; .half.png, 16 bits a value, the bits of a half float of 0 to 65504; other .png: sRGB of 2^ev L. */
int   ex_image_write(const ex_image *image, const char *path, float ev, char *error);
int   ex_image_read_pfm(ex_image *image, const char *path, char *error);
int   ex_image_read_half(ex_image *image, const char *path, char *error);        /* .half.png; wants stb */
float ex_image_auto_ev(const ex_image *image);   /* 98th percentile of lit luminance to 0.9 */

/* 8-bit RGB, rows from the top down; compressed where stb was found. */
int   ex_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb, char *error);
/* A PNG in memory, for free(): channels 1 to 4, 8 or 16 bits, the high byte first. NULL: out of memory. */
void *ex_png_encode(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits, const uint8_t *pixels,
                    size_t *size);
const char *ex_glyph(char c);       /* 7 rows of 5 characters, '#' is ink; letters are capitals */

/* ---- primary visibility through pixel centres; every technique shades this ---- */

typedef struct ex_pixel {
    float    position[3];        /* world */
    float    normal[3];          /* shading normal, faces the camera */
    float    geometric[3];       /* face normal, faces the camera; offsets go along it */
    float    view[3];            /* unit, towards the camera */
    float    albedo[3];          /* base colour times texture, linear */
    float    emission[3];        /* of the side that is seen */
    float    metallic, roughness;
    uint32_t object;             /* UINT32_MAX: background */
} ex_pixel;

typedef struct ex_gbuffer { uint32_t width, height; ex_pixel *pixels; } ex_gbuffer;  /* rows from the top down */

/* aa * aa sub-pixels a pixel on a regular grid: the buffer is aa times as wide and high. Tiled, multi-threaded. */
int  ex_gbuffer_render(ex_gbuffer *out, const ex_scene *scene, uint32_t width, uint32_t height, uint32_t aa,
                       int threads, char *error);
void ex_gbuffer_free(ex_gbuffer *g);

/* For many small pictures of one scene: boxes about neighbouring triangles, by which those that no pixel's centre can
   see are passed by. The bytes are those of ex_gbuffer_render. The scene must not change meanwhile; NULL: no memory. */
typedef struct ex_clusters ex_clusters;
ex_clusters *ex_clusters_build(const ex_scene *scene);
void ex_clusters_free(ex_clusters *clusters);
int  ex_gbuffer_render_clusters(ex_gbuffer *out, const ex_scene *scene, const ex_clusters *clusters, uint32_t width,
                                uint32_t height, int threads, char *error);

/* ---- files ---- */

/* Bytes that reading one scene or sky may take, nearly: --limit-memory sets it. 1 GB at first. */
extern size_t ex_memory_limit;
void *ex_file_read(const char *path, size_t *size, char *error);      /* all of it, for free(); NULL: error filled in */

/* ---- threads, time, progress ---- */

typedef void (*ex_task)(void *context, size_t index);
typedef struct ex_pool ex_pool;                       /* workers on pthreads, dynamic scheduling */
ex_pool *ex_pool_create(int threads);                 /* 0 = all cores; the caller is one of them */
void     ex_pool_run(void *pool, size_t count, ex_task task, void *context);   /* signature of the headers' callback */
void     ex_pool_label(ex_pool *pool, const char *label);   /* kept: what ex_pool_progress calls the work */
int      ex_pool_progress(void *pool, float fraction);      /* as ex_progress; systems have one user, the pool */
void     ex_pool_log(void *pool, const char *message);      /* kept for ex_complain: the headers' callback */
int      ex_pool_threads(const ex_pool *pool);
void     ex_pool_free(ex_pool *pool);

/* One line on stderr: "program: error", and in brackets what a header has logged of it. */
void     ex_complain(const char *program, const char *error);

double   ex_seconds(void);                            /* monotonic */
int      ex_terminal(void);                           /* whether progress would be seen: its steps cost a little */
int      ex_progress(void *label, float fraction);    /* stderr, on a terminal only; 0 = go on. Headers' callback */

#endif
