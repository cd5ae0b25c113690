/* ---- emitter: a light, its texels, and what leaves a point of it ---- */

struct lsamp_light {
    lsamp_light_desc desc;       /* texels is NULL, or the frame at desc.time with bad channels as 0 */
    const double *edges;         /* environment: the cosines of the height + 1 edges of rows */
    lsamp__cdf2   cdf;           /* over the texels; unused without texels */
    const uint16_t *guide;       /* for lsamp__invert_sums: of the rows, then of the texels of each row */
    lsamp__v3     origin;
    lsamp__v3     n;             /* the normal of the side that emits; line: its axis; sun: towards it; spot:
                                    out of the lamp */
    lsamp__v3     ex, ey;        /* rectangle: vectors whose dot products with a point give its x and y; disc:
                                    unit axes in its plane */
    lsamp__v3     radiance;
    lsamp__v3     tint;          /* its dot product with a texel is the texel's density relative to uniform
                                    coordinates; of an environment per solid angle */
    float         lx, ly, area;  /* lengths of the edges; area of the shape */
    float         cos_cone;      /* spot: the cosine of the half angle */
    float         turn;          /* environment: rotation / (2 pi) */
    int           orthogonal;    /* rectangle: its edges are at right angles */
    float         location[4];   /* point and spot: the only location of their domain */
    const lsamp__curve *curve;   /* mesh: its pieces; desc.kind is CALLBACK then, as it is of a surface */
    int           round;         /* columns of texels go round */
};

typedef struct lsamp__aim {      /* a light as one point sees it, which all samples of the point share */
    const lsamp_light *light;
    lsamp__v3 p;                 /* the point */
    lsamp__v3 axis;              /* sphere: unit, to the centre; line: unit, from the line to p */
    float distance;              /* sphere: to the centre; line: to its axis */
    float spread;                /* sphere: 1 - cos of the cone that it fills; line: the largest sine, of the
                                    angle about the axis, that p sees */
    float solid_pdf;             /* above 0: points are drawn evenly by solid angle, with this density */
    float solid;                 /* the solid angle that p sees; exact only for spheres and large
                                    rectangles */
    float x0, x1, y0, y1;        /* rectangle: its sides as seen from p, along its edges */
    float z;                     /* rectangle: the distance of its plane from p, with a sign */
    float b0, b1, k;             /* rectangle: what Urena et al. 2013, "An area-preserving parametrization for
                                    spherical rectangles", call so */
} lsamp__aim;

/* Says whether a light has one direction only at each point. */
static int lsamp__is_delta(const lsamp_light *l)
{
    return l->desc.kind == LSAMP_LIGHT_SUN || l->desc.kind == LSAMP_LIGHT_POINT ||
           l->desc.kind == LSAMP_LIGHT_SPOT;
}

static lsamp__v3 lsamp__texel_radiance(const lsamp_light *l, uint32_t x, uint32_t y)
{
    const float *t = l->desc.texels;
    return t ? lsamp__v3_load(t + 3u * ((size_t)y * l->desc.width + x)) : lsamp__v3_make(1.0f, 1.0f, 1.0f);
}

/* Returns which of count equal parts of 0..1 x falls into. */
static uint32_t lsamp__cell_of(float x, uint32_t count)
{
    uint32_t i = (uint32_t)((double)x * count);
    return i < count ? i : count - 1u;
}

/* Returns the texel before or after x, y, by dx and dy of -1..1: beyond an edge the last one, or that of the
   other side where columns go round. */
static lsamp__v3 lsamp__texel_beside(const lsamp_light *l, uint32_t x, uint32_t y, int dx, int dy)
{
    const uint32_t w = l->desc.width, h = l->desc.height;
    if (dx < 0) x = x ? x - 1u : l->round ? w - 1u : 0u;
    if (dx > 0) x = x + 1u < w ? x + 1u : l->round ? 0u : x;
    if (dy < 0 && y) y--;
    if (dy > 0 && y + 1u < h) y++;
    return lsamp__texel_radiance(l, x, y);
}

/* Returns the mean of L over texel x, y. Linear between the centres a, b, c, it is (a + 6 b + c) / 8. */
static lsamp__v3 lsamp__texel_mean(const lsamp_light *l, uint32_t x, uint32_t y)
{
    static const float weight[3] = { 0.125f, 0.75f, 0.125f };
    lsamp__v3 sum = lsamp__v3_make(0.0f, 0.0f, 0.0f);
    int dx, dy;
    if (l->desc.filter != LSAMP_TEXELS_LINEAR) return lsamp__texel_radiance(l, x, y);
    for (dy = -1; dy <= 1; dy++)
        for (dx = -1; dx <= 1; dx++)
            sum = lsamp__v3_madd(sum, lsamp__texel_beside(l, x, y, dx, dy), weight[dx + 1] * weight[dy + 1]);
    return sum;
}

/* Returns L at x, y. */
static lsamp__v3 lsamp__texel_at(const lsamp_light *l, float x, float y)
{
    const uint32_t i = lsamp__cell_of(x, l->desc.width), j = lsamp__cell_of(y, l->desc.height);
    float fx, fy;
    int dx, dy;
    lsamp__v3 a, b;

    if (l->desc.filter != LSAMP_TEXELS_LINEAR) return lsamp__texel_radiance(l, i, j);
    fx = x * (float)l->desc.width - ((float)i + 0.5f);      /* from the centre, -0.5..0.5 */
    fy = y * (float)l->desc.height - ((float)j + 0.5f);
    dx = fx < 0.0f ? -1 : 1;
    dy = fy < 0.0f ? -1 : 1;
    fx = fabsf(fx);
    fy = fabsf(fy);
    a = lsamp__v3_scale(lsamp__texel_radiance(l, i, j), 1.0f - fx);
    a = lsamp__v3_madd(a, lsamp__texel_beside(l, i, j, dx, 0), fx);
    b = lsamp__v3_scale(lsamp__texel_beside(l, i, j, 0, dy), 1.0f - fx);
    b = lsamp__v3_madd(b, lsamp__texel_beside(l, i, j, dx, dy), fx);
    return lsamp__v3_madd(lsamp__v3_scale(a, 1.0f - fy), b, fy);
}

/* Returns the density of the coordinates that lsamp__pick_point draws, relative to uniform ones. */
static float lsamp__texel_density(const lsamp_light *l, float x, float y)
{
    if (!l->desc.texels) return 1.0f;
    return lsamp__v3_dot(lsamp__texel_mean(l, lsamp__cell_of(x, l->desc.width),
                                           lsamp__cell_of(y, l->desc.height)), l->tint);
}

/* Returns the cell of a cdf that u falls into, and writes how far inside of the cell. guide[b] is the cell
   that b / count of the total falls into, so that the search begins a step or two from its end, in the same
   cache line. The last loops correct rounding at the ends of a bucket, and step out of cells of weight 0. */
static uint32_t lsamp__invert_sums(const double *sums, const uint16_t *guide, uint32_t count, float u,
                                   float *fraction)
{
    double x = (double)u * sums[count], f;
    uint32_t bucket = lsamp__cell_of(u, count), lo = guide[bucket],
             hi = bucket + 1u < count ? guide[bucket + 1u] + 1u : count;
    while (hi - lo > 1u) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (sums[mid] <= x) lo = mid;
        else hi = mid;
    }
    while (lo + 1u < count && sums[lo + 1u] <= x) lo++;
    while (lo > 0 && (sums[lo] > x || !(sums[lo + 1u] > sums[lo]))) lo--;
    f = (x - sums[lo]) / (sums[lo + 1u] - sums[lo]);
    *fraction = lsamp__clamp_unit((float)f);
    return lo;
}

/* Makes the guide of lsamp__invert_sums. */
static void lsamp__guide_build(const double *sums, uint16_t *guide, uint32_t count)
{
    uint32_t b, i = 0;
    for (b = 0; b < count; b++) {
        double x = sums[count] * b / count;
        while (i + 1u < count && sums[i + 1u] <= x) i++;
        guide[b] = (uint16_t)i;
    }
}

/* Writes the texel that u picks, and which point inside of the texel. Returns 0 if all texels are black. */
static int lsamp__pick_cell(const lsamp_light *l, const float *u, uint32_t *x, uint32_t *y, float *fx,
                            float *fy)
{
    uint32_t w = l->desc.width;
    if (!(lsamp__cdf2_total(&l->cdf) > 0.0)) return 0;
    *y = lsamp__invert_sums(l->cdf.rows, l->guide, l->desc.height, u[1], fy);
    *x = lsamp__invert_sums(l->cdf.sums + (size_t)*y * (w + 1u), l->guide + l->desc.height + (size_t)*y * w,
                            w, u[0], fx);
    return 1;
}

/* Draws coordinates in proportion to the texels. */
static void lsamp__pick_point(const lsamp_light *l, const float *u, float *x, float *y)
{
    uint32_t i, j;
    *x = u[0];
    *y = u[1];
    if (!l->desc.texels || !lsamp__pick_cell(l, u, &i, &j, x, y)) return;
    *x = lsamp__clamp_unit(((float)i + *x) / (float)l->desc.width);
    *y = lsamp__clamp_unit(((float)j + *y) / (float)l->desc.height);
}

/* Writes the radiance that leaves the point out->coords along away: L times the texel and the angular
   factors. Returns 0 if it is black. */
static int lsamp__emit(const lsamp_light *l, lsamp__v3 texel, float cosine, lsamp__v3 away,
                       lsamp_emission *out)
{
    lsamp__v3 c = lsamp__v3_mul(l->radiance, texel);
    if (l->desc.cosine_power > 0.0f) c = lsamp__v3_scale(c, lsamp__pow(cosine, l->desc.cosine_power));
    if (l->desc.emission_fn) {
        float w[3], rgb[3] = { 0.0f, 0.0f, 0.0f };
        int i;
        lsamp__v3_store(w, away);
        l->desc.emission_fn(l->desc.user, l->desc.time, out->coords, w, rgb);
        for (i = 0; i < 3; i++)
            if (!lsamp__finite(rgb[i]) || rgb[i] < 0.0f) rgb[i] = 0.0f;
        c = lsamp__v3_mul(c, lsamp__v3_load(rgb));
    }
    lsamp__v3_store(out->radiance, c);
    return lsamp__v3_finite(c) && c.x + c.y + c.z > 0.0f;
}

/* Writes how p sees the point q of a light, which has the normal n (0: a volume) and the coordinates x, y.
   The density is a->solid_pdf; if that is 0, it is area_pdf, turned into a density per solid angle. Returns 0
   if no light of q reaches p. */
static int lsamp__emit_area(const lsamp__aim *a, lsamp__v3 q, lsamp__v3 n, float x, float y, float area_pdf,
                            lsamp_emission *out)
{
    const lsamp_light *l = a->light;
    lsamp__v3 d = lsamp__v3_sub(q, a->p), w;
    float d2 = lsamp__v3_dot(d, d), distance = sqrtf(d2), cosine;

    if (!(distance > 0.0f) || !lsamp__finite(d2)) return 0;
    w = lsamp__v3_scale(d, 1.0f / distance);
    cosine = n.x != 0.0f || n.y != 0.0f || n.z != 0.0f ? -lsamp__v3_dot(n, w) : 1.0f;
    if (!(cosine > 1e-7f)) return 0;
    if (cosine > 1.0f) cosine = 1.0f;
    out->coords[0] = lsamp__clamp_unit(x);
    out->coords[1] = lsamp__clamp_unit(y);
    out->distance = distance;
    out->pdf = a->solid_pdf > 0.0f ? a->solid_pdf : area_pdf * d2 / cosine;
    lsamp__v3_store(out->direction, w);
    return lsamp__emit(l, lsamp__texel_at(l, x, y), cosine, lsamp__v3_scale(w, -1.0f), out);
}
