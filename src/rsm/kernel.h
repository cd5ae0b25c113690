/* ---- kernel: pixel lights on one receiver, or on as many as lanes ---- */

/* What cosines times distances from a place must exceed. Each light's own, not that of the map's farthest: a
   sky dome far off would take all light between near surfaces away. */
static inline float rsm__rounding(float x, float y, float z)
{
    float most = fabsf(x) > fabsf(y) ? fabsf(x) : fabsf(y);
    return 4e-7f * (most > fabsf(z) ? most : fabsf(z));
}

/* A block of pixel lights, a lane each, as arrays that vectors read. Lanes that are not in use have no
   flux. */
typedef struct rsm__block {
    float px[RSM__BLOCK], py[RSM__BLOCK], pz[RSM__BLOCK];    /* where each light is */
    float nx[RSM__BLOCK], ny[RSM__BLOCK], nz[RSM__BLOCK];    /* its normal */
    float r[RSM__BLOCK], g[RSM__BLOCK], b[RSM__BLOCK];       /* its flux */
    float cap[RSM__BLOCK];         /* what bounds cos cos / d^2 */
    float rounding[RSM__BLOCK];    /* of its position, see rsm__rounding */
    float lx[RSM__BLOCK], ly[RSM__BLOCK], lz[RSM__BLOCK];    /* with MIXED its place in the map, see
                                                                centred.h; with a near field lx is its texel's
                                                                face */
    float density[RSM__BLOCK];     /* with MIXED the density that it was picked with; with a near field the
                                      squared distance within which its texel is near */
} rsm__block;

typedef struct rsm__gloss {        /* a light's Phong lobe */
    float mirror[3], exponent;
    float scale[3];                /* pi x intensity of the lobe */
} rsm__gloss;

typedef struct rsm__sum {          /* what one receiver has got so far */
    float rgb[3];
    float full, lost;              /* light without bounds and what the bounds took; summed if asked for */
    float nearby;                  /* 1 / squared distance of the nearest light that is not edge-on; if asked
                                      for */
} rsm__sum;

#define RSM__NO_CAP 3.0e38f

/* As many receivers as a vector has lanes, which take a few lights one by one. */
typedef struct rsm__crowd {
    float  x[7][RSM__WIDE];        /* positions, normals, roundings; no normal: no receiver */
    float  sums[5][RSM__WIDE];     /* red, green, blue; full and lost */
    size_t at[RSM__WIDE], count;
} rsm__crowd;

typedef void (*rsm__crowd_kernel)(const rsm__block *k, size_t count, rsm__crowd *p);

/* k: as many blocks as count lanes fill, a multiple of RSM__LANES. x: position, normal, rounding of the
   receiver. */
typedef void (*rsm__kernel)(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum);

/* The glossy part of a light towards a receiver: a Phong lobe about the mirrored direction of the light
   (section 7). mean: of cos cos / d^2 over a texel that is near, whose lobe is that of its centre; below 0: a
   point. */
static inline void rsm__add_gloss(const rsm__gloss *gloss, const rsm__block *k, size_t i, const float x[7],
                                  float mean, rsm__sum *sum)
{
    rsm__v3 d = rsm__v3_make(k->px[i] - x[0], k->py[i] - x[1], k->pz[i] - x[2]);
    float d2 = rsm__v3_dot(d, d), inverse = 1.0f / (d2 > 1e-18f ? d2 : 1e-18f), root = sqrtf(inverse), f;
    float rounding = k->rounding[i] > x[6] ? k->rounding[i] : x[6];
    float cr = (x[3] * d.x + x[4] * d.y + x[5] * d.z - rounding) * root;
    float ce = (-(k->nx[i] * d.x + k->ny[i] * d.y + k->nz[i] * d.z) - rounding) * root;
    float cm = -(gloss->mirror[0] * d.x + gloss->mirror[1] * d.y + gloss->mirror[2] * d.z) * root;
    int c;
    if (!(cm > 0.0f && (mean >= 0.0f || (cr > 0.0f && ce > 0.0f)))) return;
    f = mean >= 0.0f ? mean : cr * ce * inverse;
    f = (f < k->cap[i] ? f : k->cap[i]) * rsm__pow(cm < 1.0f ? cm : 1.0f, gloss->exponent);
    for (c = 0; c < 3; c++) sum->rgb[c] += gloss->scale[c] * f;
}
