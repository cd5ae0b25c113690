/* ---- over frames ---- */

typedef struct lsamp_progressive {  /* sums of frames, from which their mean is taken (section 5.2); set sums
                                       and count, then call lsamp_progressive_reset */
    double  *sums;                  /* count doubles in your memory; precise enough for 1e6 frames */
    size_t   count;                 /* 3 x pixels */
    uint32_t frame_count;           /* how many frames the sums hold */
} lsamp_progressive;

LSAMP_DEF lsamp_result lsamp_progressive_reset(lsamp_progressive *p);
/* Forgets all frames. Call it before the first frame and after every change of camera, scene or light.
   Errors   LSAMP_ERR_ARGUMENT (NULL). There is no log */

LSAMP_DEF lsamp_result lsamp_progressive_add(lsamp_progressive *p, const float *frame);
/* Adds a frame of count floats to the sums.
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_LIMIT (there are 2^32 - 1 frames). There is no log */

LSAMP_DEF lsamp_result lsamp_progressive_mean(const lsamp_progressive *p, float *mean);
/* Writes the mean of the frames, count floats.
   Errors   LSAMP_ERR_ARGUMENT (NULL), LSAMP_ERR_ORDER (there is no frame yet). There is no log */

#define LSAMP_PATTERN_COUNT 256u    /* patterns that lsamp_patterns_build makes, as in the paper */

LSAMP_DEF size_t lsamp_patterns_bytes(uint32_t length);
/* Returns the bytes that lsamp_patterns_build needs for LSAMP_PATTERN_COUNT patterns of length points; 0 if
   length is not 1..65536. */

LSAMP_DEF lsamp_result lsamp_patterns_build(uint32_t length, uint32_t seed, float *patterns, size_t bytes);
/* Makes the paper's stratified patterns of points in the unit square (section 5.1), for
   lsamp_sample_desc.patterns. If the square is cut into length columns, each column holds one point of a
   pattern, jittered; if length is a power of 4, so does each cell of the square grid of length cells.
   lsamp_sample chooses a pattern by pixel and takes another one each frame; after 256 frames all have been
   used, and they come again, shifted.
   length    points of a pattern, 1..65536: the samples of each point, lsamp_sample_desc.sample_count
   patterns  receives the points, 2 floats each; those of pattern j begin at patterns + j * length * 2
   bytes     of patterns, at least lsamp_patterns_bytes(length)
   Errors    LSAMP_ERR_ARGUMENT (NULL, length), LSAMP_ERR_MEMORY (bytes). There is no log */
