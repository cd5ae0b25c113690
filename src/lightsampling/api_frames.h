/* ---- over frames ---- */

typedef struct lsamp_progressive {  /* the mean of frames (section 5.2); sums of doubles, good for 1e6
                                       frames */
    double  *sums;                  /* count doubles of yours */
    size_t   count;                 /* 3 x pixels */
    uint32_t frames;                /* how many the sums hold */
} lsamp_progressive;

LSAMP_DEF lsamp_result lsamp_progressive_reset(lsamp_progressive *p);
/* Forgets all frames, as after every change of camera, scene or light.
   Errors   LSAMP_ERR_ARGUMENT */

LSAMP_DEF lsamp_result lsamp_progressive_add(lsamp_progressive *p, const float *frame);
/* Adds a frame of count floats.
   Errors   LSAMP_ERR_ARGUMENT */

LSAMP_DEF lsamp_result lsamp_progressive_mean(const lsamp_progressive *p, float *mean);
/* Writes the mean of the frames, count floats.
   Errors   LSAMP_ERR_ARGUMENT, also before the first frame */

#define LSAMP_PATTERN_COUNT 256u

LSAMP_DEF size_t lsamp_patterns_bytes(uint32_t length);
/* Returns the bytes of LSAMP_PATTERN_COUNT patterns of so many points in the unit square; 0 if length is not
   1..65536. */

LSAMP_DEF lsamp_result lsamp_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t bytes);
/* Makes the paper's patterns (section 5.1): pattern j holds its points at patterns + j * length * 2. Each of
   the length columns of the square holds one point, jittered; so does each cell of the square grid where
   length is a power of 4. lsamp_sample takes the pattern by pixel and moves to another one each frame; after
   256 frames all have been used and return shifted.
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_DESC (length), LSAMP_ERR_MEMORY (bytes) */
