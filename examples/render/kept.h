/* kept.h - pictures of the path tracer that are kept in files, since they take hours: which picture a command line asks
   for, and whether it is there. docs/programs.md describes the folder. */
#ifndef RD_KEPT_H
#define RD_KEPT_H

#include "args.h"

/* A number for what a picture shows: scene, lights, sky, camera and size as the job has them now, and the settings of
   its command line, but not for how it is drawn: paths, seed, threads, exposure. Triangles, colours and skies enter by
   sums that are rounded to a thousandth, so that another mathematics library gives the same number, nearly always. */
uint64_t rd_picture_hash(const rd_args *args, const rd_job *job);

typedef struct rd_kept {
    ex_image picture;          /* rgb is NULL where the folder has none of this hash */
    uint64_t samples;          /* paths a pixel */
    double   noise;            /* relative, as the path tracer found it */
    double   milliseconds;     /* that it took */
} rd_kept;

/* Looks into FOLDER/list.tsv, whose lines are hash, name, paths a pixel, noise, milliseconds and the command line, with
   tabs between them, and reads FOLDER/NAME.half.png. 0, also where nothing is found, or where the build has no stb,
   which reads pictures; -1 with one line in error: a file cannot be read, or the picture has another size. */
int rd_kept_read(rd_kept *kept, const char *folder, uint64_t hash, uint32_t width, uint32_t height, char *error);

#endif
