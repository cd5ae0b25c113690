/* gallery.h - the program `gallery`: pages and pictures of a run of `make demo`, from the list and the JSON files that
   examples/demo.sh leaves in its folder.

   The list, gallery.tsv, has one thing a line, its fields separated by tabs:
       group  scene  direct|bounced  title  stem of the reference, or nothing
       row    technique  cpu|gl  what is special about it  stem
       left   what was left out
       run    what was asked for, in words
       best   stem of the picture that the page opens with, if it is there; else the first is
       scenes how many groups there will be, and how many are whole (the last such line counts)
   Files of a stem: STEM.pfm and STEM.json of render, STEM-compare.json and STEM-diff.png of compare. */
#ifndef GALLERY_H
#define GALLERY_H

#include "../common/internal.h"

#include <stdio.h>

typedef struct gal_row {
    char   technique[20], backend[8], label[160], stem[100];
    double precompute_ms, frame_ms, memory_bytes;
    double error, ssim, mean_ratio;             /* NaN without a reference */
} gal_row;

typedef struct gal_group {                      /* one scene's direct or bounced light */
    char     scene[40], kind[20], title[200], reference[100];
    double   reference_ms, noise, triangles;
    double   kept_ms, samples;                  /* of a reference that was there already; kept_ms is NaN of others */
    float    ev;                                /* of all its pictures: the reference's */
    uint32_t row_count;
    gal_row *rows;
} gal_group;

typedef struct gallery {
    const char *folder;
    char        left_out[800], run[300], machine[400], gl_renderer[120];
    char        best[100];
    uint32_t    scenes, done;                   /* groups that there will be, and that are whole */
    uint32_t    width, height, group_count;
    gal_group  *groups;
} gallery;

int  gal_read(gallery *g, const char *folder, char *error);
void gal_free(gallery *g);

/* Each writes files into the folder; 0, or -1 with a reason. */
int gal_pictures(gallery *g, char *error);      /* STEM.png of every STEM.pfm */
int gal_sheet(gallery *g, char *error);         /* contact.png */
int gal_index(gallery *g, char *error);         /* index.html */
int gal_which(gallery *g, char *error);         /* which.html, and which-one.md with the same words */

#endif
