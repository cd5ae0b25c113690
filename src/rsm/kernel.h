/* ---- kernel: pixel lights on one receiver, or on as many as lanes ---- */

/* Returns by how much rounding may move a point at (x, y, z) off its plane: 4e-7 of its largest coordinate. A
   light counts only if it stands out of the receiver's plane, and the receiver out of the light's, by more
   than that, so that a plane does not light itself. Each light has its own bound. One for the whole map, by
   its farthest texel, would take away the light between near surfaces if there is a sky dome far off. */
static inline float rsm__rounding(float x, float y, float z)
{
    float most = fabsf(x) > fabsf(y) ? fabsf(x) : fabsf(y);
    return 4e-7f * (most > fabsf(z) ? most : fabsf(z));
}

/* A block of pixel lights, each in a lane of arrays that vectors read. A lane that is not in use has no flux.
   */
typedef struct rsm__block {
    float px[RSM__BLOCK], py[RSM__BLOCK], pz[RSM__BLOCK];    /* where each light is */
    float nx[RSM__BLOCK], ny[RSM__BLOCK], nz[RSM__BLOCK];    /* its normal */
    float r[RSM__BLOCK], g[RSM__BLOCK], b[RSM__BLOCK];       /* its flux */
    float cap[RSM__BLOCK];         /* the bound on cos cos / d^2 */
    float rounding[RSM__BLOCK];    /* rsm__rounding of its position */
    float lx[RSM__BLOCK], ly[RSM__BLOCK], lz[RSM__BLOCK];    /* with MIXED the light's place in the map
                                                                (centred.h); with a near field lx is the face
                                                                that its texel lies in */
    float density[RSM__BLOCK];     /* with MIXED the density with which the light was picked; with a near
                                      field the squared distance within which its texel is near */
} rsm__block;

typedef struct rsm__gloss {        /* a light's Phong lobe */
    float mirror[3], exponent;
    float scale[3];                /* pi x intensity of the lobe, along its axis */
} rsm__gloss;

typedef struct rsm__sum {          /* what one receiver has got so far */
    float rgb[3];
    float full, lost;              /* the light without bounds, and what the bounds took of it; kernels named
                                      lossy sum them, others leave them */
    float nearby;                  /* 1 / squared distance of the nearest light that is not edge-on; kernels
                                      named near find it */
} rsm__sum;

#define RSM__NO_CAP 3.0e38f        /* the bound of a light without one */

/* As many receivers as a vector has lanes. A few lights are taken one by one, each for all of these
   receivers. */
typedef struct rsm__receiver_lanes {
    float  x[7][RSM__WIDE];        /* positions, normals, roundings; a lane without a normal gets no light */
    float  sums[5][RSM__WIDE];     /* red, green, blue; full and lost, as in rsm__sum */
    size_t at[RSM__WIDE], count;   /* the numbers of the receivers, and how many there are */
} rsm__receiver_lanes;

typedef void (*rsm__receiver_lanes_kernel)(const rsm__block *k, size_t count, rsm__receiver_lanes *p);

/* Adds the light of `count` lanes, a multiple of RSM__LANES, of the blocks from k on to the receiver's sum. x
   holds the receiver's position, normal and rounding. */
typedef void (*rsm__kernel)(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum);

/* Adds the glossy part of a light towards a receiver: a Phong lobe about the mirrored direction of the light
   (section 7). If the light's texel is near, `mean` is the mean of cos cos / d^2 over the texel, and the lobe
   is evaluated at its centre; a `mean` below 0 says that the light is a point. */
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
