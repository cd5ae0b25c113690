/* ---- wavelets: what sixteen points share ---- */

/* Neighbours whose entities have the same order from near to far are shaded together, a lane each, face by
   face. Texels, wavelets and sums are planes of sixteen, so that directions, the sky, and the samples that
   several points lie between are read once for all lanes. */
enum { SFIELD__STRANDS = 32, SFIELD__STRAND_LISTS = 256, SFIELD__BLOCK = 64, SFIELD__FEWEST = 3 };

typedef struct sfield__listing {    /* what is kept at a sample, and how much of it each point takes */
    const uint32_t *e, *end;
    size_t sample;
    float weight[SFIELD__LANES];
} sfield__listing;

typedef struct sfield__strand {     /* an entity in the order */
    uint32_t item, lanes, count;
    int      light;                 /* its number, -1 an occluder, -2 the self-visibility */
    float    d2[SFIELD__LANES];
    sfield__listing *list;          /* room for SFIELD__STRAND_LISTS: 16 points between 8 samples of 2
                                       frames */
} sfield__strand;

typedef struct sfield__bundle {
    const sfield_scene *s;
    sfield__strand *strand, *trial;
    sfield__listing *list;
    uint32_t strands;
    int      ambient;
    float    n[3 * SFIELD__LANES];
    float   *t, *w;                 /* a face: texels of T; its wavelets, or those of what hides it */
    uint16_t *used;                 /* squares of a face with wavelets */
    uint8_t *marks;
    uint8_t  live[SFIELD__BLOCK];   /* blocks of 64 texels where T is not 0 */
    float    rgb[3 * SFIELD__LANES], open[SFIELD__LANES];
} sfield__bundle;
