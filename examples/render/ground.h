/* ground.h - the ground around the scene in the light of lamps without place: suns, directions of a sky.

   Pictures of such lamps (reflective shadow maps) show the scene and its shadow. Beyond them the ground goes on, and
   light bounces from there too: all that a wall gets from below, half of it from farther than the wall is high. It is
   lit evenly, for no shadow reaches it, so that it needs no pictures: rings of squares, each six times the last, whose
   texels grow with their distance. A texel is dark for the lamps whose pictures show it, by exact areas. */
#ifndef RD_GROUND_H
#define RD_GROUND_H

#include "technique.h"

#define RD_COVER_PLANES 6

typedef struct rd_cover {      /* a lamp: what its picture shows, n . p + d >= 0 for all, and its light on the ground */
    double planes[RD_COVER_PLANES][4];
    int    plane_count;
    float  irradiance[3];
} rd_cover;

#define RD_RING_SIDE 64u

typedef struct rd_ring {       /* RD_RING_SIDE^2 texels of a square seen from above, u along +X and v along -Z */
    float  center[3];
    float  half;               /* of the square's sides */
    float *positions, *normals;/* positions begins one block of all four arrays */
    float *radiosity;          /* reflected by the whole texel, over its area */
    float *areas;              /* of the texel's ground */
} rd_ring;

/* Rings about the scene, the first one a whole square, up to the ground's end; none where no lamp is above it or there
   is no ground: an object that only receives, a level rectangle along the axes. 0, or -1: out of memory. */
int  rd_rings_build(rd_ring **rings, size_t *count, const rd_job *job, const rd_cover *covers, size_t cover_count);
void rd_rings_free(rd_ring *rings, size_t count);

/* 1, and the corners of its part about the scene, twice the sphere's radius wide, counter-clockwise seen from above; 0:
   none. */
int  rd_ground_near(const rd_job *job, float corners[4][3]);

#endif
