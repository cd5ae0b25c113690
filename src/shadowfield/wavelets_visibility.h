/* ---- wavelets: the texels of a point times the visibility of an occluder ---- */

typedef struct sfield__ray {
    float d2;
    uint32_t item;
    int light;
} sfield__ray; /* light: the number of a light; -1: the item is an occluder */

typedef struct sfield__point {
    const sfield_scene *s;
    const sfield_points *set;
    float       *t, *haar, *coefs, *work;       /* 6 N^2, 6 N^2, 3 x 6 N^2, 6 N^2 */
    uint8_t     *marks;                         /* six faces of SFIELD__MARKS */
    sfield__ray *ray;
    float       *rgb;                           /* of one point */
#ifndef SFIELD_WITHOUT_GLOSS
    float       *kernels;                       /* with gloss: 3 x 6 N^2, BRDFs on texels */
    const float *kernel;                        /* the one that T begins with; NULL: the cosine */
#endif
#ifndef SFIELD_WITHOUT_ROOMS
    const sfield_points *own;                    /* the set; the walk of lights in the own room, `home`, has a
                                                    copy without self-visibility */
    int          home;
#endif
    uint64_t     all_hash, set_hash;             /* sfield__hash_set; and sfield__hash_brdfs of a point */
    uint32_t     chain, chains;                  /* T of the moment, of so many */
    sfield_scene_stats stats;
} sfield__point;

/* Divides memory among the arrays of a point. kernels: how many planes of texels BRDFs need. */
static size_t sfield__carve_point(sfield__point *p, uint8_t *memory, uint32_t rays, uint32_t cells,
                                  uint32_t kernels)
{
    size_t floats = (6 + kernels) * (size_t)cells;
    if (memory) {
#ifndef SFIELD_WITHOUT_GLOSS
        p->kernels = (float *)(void *)memory + 6 * (size_t)cells;
#endif
        p->t = (float *)(void *)memory;
        p->haar = p->t + cells;
        p->coefs = p->haar + cells;
        p->work = p->coefs + 3 * (size_t)cells;
        p->ray = (sfield__ray *)(void *)(p->t + floats);
        p->marks = (uint8_t *)(p->ray + rays + 1);
        memset(p->coefs, 0, 3 * (size_t)cells * sizeof *p->coefs);
        memset(p->marks, 0, 6 * SFIELD__MARKS);
    }
    return (floats * sizeof(float) + (rays + 1) * sizeof(sfield__ray) + 6 * SFIELD__MARKS + 63) / 64 * 64;
}

/* Multiplies the texels of each face by 1 - the function in p->coefs. */
static void sfield__shade_faces(const sfield__point *p)
{
    const uint32_t side = p->s->side, n = side * side;
    uint32_t face;
    for (face = 0; face < 6; face++)
        sfield__darken16(p->coefs + face * n, p->marks + face * SFIELD__MARKS, side, p->t + face * n,
                         p->s->simd);
}

/* Adds the lists of an occluder up in p->coefs, which is clean before, and marks the squares that they use
   and all above these. Square k of all levels in turn lies in square (k - 1) / 4. sfield__clear_lists cleans
   up. */
static void sfield__add_lists(sfield__point *p, const sfield_field *f, const sfield__lists *lists,
                              float factor)
{
    uint32_t i, bits = 0;
    while (1u << bits < p->s->side * p->s->side) bits++;
    for (i = 0; i < lists->count; i++) {
        const float weight = lists->weight[i] * factor * f->sample_scale[lists->sample[i]];
        const uint32_t *e = f->entry + f->offset[lists->sample[i]],
                       *end = f->entry + f->offset[lists->sample[i] + 1];
        for (; e < end; e++) {
            const uint32_t index = *e >> 16, in_face = index & ((1u << bits) - 1);
            uint8_t *marks = p->marks + (index >> bits) * SFIELD__MARKS;
            uint32_t square = (in_face - 1) / 3;
            p->coefs[index] += weight * sfield__signed_short(*e);
            if (!in_face) continue;
            for (; !marks[square]; square = (square - 1) / 4) {
                marks[square] = 1;
                if (!square) break;
            }
        }
    }
}

static void sfield__clear_lists(sfield__point *p)
{
    const uint32_t used = sfield__mark_base(p->s->side * p->s->side);
    uint32_t face;
    memset(p->coefs, 0, p->s->cells * sizeof *p->coefs);
    for (face = 0; face < 6; face++) memset(p->marks + face * SFIELD__MARKS, 0, used);
}

/* Multiplies T by the visibility in p->coefs: expanded only where it has detail; rotated entities texel by
   texel. */
static void sfield__hide_texels(sfield__point *p, uint32_t map)
{
    const sfield_scene *s = p->s;
    uint32_t i;
    if (map) {
        const sfield__taps *taps = s->taps + (size_t)(map - 1) * s->cells;
        sfield__haar_texels(s->side, p->coefs, p->work);
        for (i = 0; i < s->cells; i++) {
            const sfield__taps *q = taps + i;
            p->t[i] *= 1 - (q->weight[0] * p->work[q->texel[0]] + q->weight[1] * p->work[q->texel[1]] +
                            q->weight[2] * p->work[q->texel[2]] + q->weight[3] * p->work[q->texel[3]]);
        }
    } else if (s->desc.product == SFIELD_PRODUCT_SPARSE) {
        sfield__haar_multiply(s->side, p->haar, p->coefs, p->work);
        for (i = 0; i < s->cells; i++) p->haar[i] -= p->work[i];
    } else
        sfield__shade_faces(p);
}
