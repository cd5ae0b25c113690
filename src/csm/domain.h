/* ---- domain: D (the mapping from parameters to rays), cells, and axes of their maps ---- */

static uint32_t cohsm__dimensions(cohsm_domain_kind kind, const uint32_t *side)
{
    switch (kind) {
    case COHSM_DOMAIN_LINE: return 1;
    case COHSM_DOMAIN_VOLUME: return 3;
    case COHSM_DOMAIN_LIST: return 0;
    case COHSM_DOMAIN_TABLE: return side[2] > 1 ? 3 : side[1] > 1 ? 2 : 1;
    default: return 2;
    }
}

static int cohsm__has_table(uint32_t kind) { return kind == COHSM_DOMAIN_TABLE || kind == COHSM_DOMAIN_LIST; }

static cohsm__v3 cohsm__affine_point(const cohsm__header *h, float s, float t, float r)
{
    cohsm__v3 p = cohsm__v3_load(h->origin);
    p = cohsm__v3_madd(p, cohsm__v3_load(h->u), s);
    p = cohsm__v3_madd(p, cohsm__v3_load(h->v), t);
    return cohsm__v3_madd(p, cohsm__v3_load(h->w), r);
}

/* Returns D at the parameters s, t, r, for every kind but TABLE and LIST. */
static cohsm__v3 cohsm__map_parameter(const cohsm__header *h, float s, float t, float r)
{
    float sine, cosine, ring;
    float x, y;
    cohsm__v3 p;

    switch (h->domain) {
    case COHSM_DOMAIN_OCTAHEDRAL: return cohsm__octa_direction(s, t);
    case COHSM_DOMAIN_DISC:
        cohsm__concentric(s, t, &x, &y);
        return cohsm__affine_point(h, x, y, 0.0f);
    case COHSM_DOMAIN_SPHERE:
        cohsm__sincos((s - 0.5f) * 6.28318531f, &sine, &cosine);
        y = 1.0f - 2.0f * t;
        ring = sqrtf(y >= 1.0f || y <= -1.0f ? 0.0f : 1.0f - y * y);
        p = cohsm__v3_make(ring * cosine, y, ring * sine);
        return cohsm__v3_madd(cohsm__v3_load(h->origin), p, cohsm__v3_length(cohsm__v3_load(h->u)));
    case COHSM_DOMAIN_LATLONG:
        cohsm__sincos((s - 0.5f) * 6.28318531f, &sine, &cosine);
        cohsm__sincos(t * 3.14159265f, &ring, &y);
        return cohsm__v3_make(ring * cosine, y, ring * sine);
    default: return cohsm__affine_point(h, s, t, r);
    }
}

static void cohsm__cell_split(const uint32_t *side, uint32_t cell, uint32_t *c)
{
    c[0] = cell % side[0];
    c[1] = cell / side[0] % side[1];
    c[2] = cell / (side[0] * side[1]);
}

static cohsm__v3 cohsm__cell_location(const cohsm__header *h, const float *table, uint32_t cell)
{
    uint32_t c[3];
    if (cohsm__has_table(h->domain)) return cohsm__v3_load(table + 4 * (size_t)cell);
    cohsm__cell_split(h->side, cell, c);
    return cohsm__map_parameter(h, ((float)c[0] + 0.5f) / (float)h->side[0],
                                ((float)c[1] + 0.5f) / (float)h->side[1],
                                ((float)c[2] + 0.5f) / (float)h->side[2]);
}

/* The axes of the image of a direction's map; back points to the light. */
typedef struct cohsm__axes { cohsm__v3 right, up, back; } cohsm__axes;

static cohsm__axes cohsm__axes_of(uint32_t kind, cohsm__v3 d)
{
    cohsm__axes f;
    float s, a, h;

    f.back = d;
    if (kind == COHSM_ORIENTATION_POLAR) {
        h = sqrtf(d.x * d.x + d.z * d.z);
        f.right = h > 1e-6f ? cohsm__v3_make(-d.z / h, 0.0f, d.x / h) : cohsm__v3_make(0.0f, 0.0f, 1.0f);
        f.up = cohsm__v3_cross(f.right, d);
        return f;
    }
    s = kind == COHSM_ORIENTATION_MINIMAL || d.y >= 0.0f ? 1.0f : -1.0f;
    if (s + d.y > -1e-6f && s + d.y < 1e-6f) {       /* MINIMAL at -Y: all rotations are as short */
        f.right = cohsm__v3_make(1.0f, 0.0f, 0.0f);
        f.up = cohsm__v3_make(0.0f, 0.0f, 1.0f);
        return f;
    }
    a = -1.0f / (s + d.y);
    f.right = cohsm__v3_make(1.0f + s * d.x * d.x * a, -s * d.x, s * d.x * d.z * a);
    f.up = cohsm__v3_make(d.x * d.z * a, -d.z, s + d.z * d.z * a);
    return f;
}

/* Returns the polar axes of a LATLONG map from the cosines and sines of its two angles, by which even the
   poles have a right. */
static cohsm__axes cohsm__axes_latlong(float cos_phi, float sin_phi, float cos_theta, float sin_theta)
{
    cohsm__axes f;
    f.right = cohsm__v3_make(-sin_phi, 0.0f, cos_phi);
    f.up = cohsm__v3_make(-cos_theta * cos_phi, sin_theta, -cos_theta * sin_phi);
    f.back = cohsm__v3_make(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi);
    return f;
}

/* Writes cos, sin of each column's azimuth, then of each row's polar angle: 2 (side[0] + side[1]) floats. */
static void cohsm__latlong_angles(const uint32_t *side, float *angles)
{
    uint32_t i;
    for (i = 0; i < side[0]; i++, angles += 2)
        cohsm__sincos((((float)i + 0.5f) / (float)side[0] - 0.5f) * 6.28318531f, angles + 1, angles);
    for (i = 0; i < side[1]; i++, angles += 2)
        cohsm__sincos(((float)i + 0.5f) / (float)side[1] * 3.14159265f, angles + 1, angles);
}

static cohsm__axes cohsm__cell_axes(const cohsm__header *h, const float *table, const float *angles,
                                    uint32_t cell)
{
    const float *column, *row;
    cohsm__axes f;
    if (h->domain != COHSM_DOMAIN_LATLONG)
        return cohsm__axes_of(h->orientation, cohsm__cell_location(h, table, cell));
    column = angles + 2 * (cell % h->side[0]);
    row = angles + 2 * h->side[0] + 2 * (cell / h->side[0]);
    f = cohsm__axes_latlong(column[0], column[1], row[0], row[1]);
    return h->orientation == COHSM_ORIENTATION_POLAR ? f : cohsm__axes_of(h->orientation, f.back);
}

/* Writes the coordinates of q for a face of a cube, on which q lies at x / w and y / w within -1..1. A face
   has the number 2 axis, + 1 if it looks along the negative axis. Pixel x runs along the next axis and y
   along the one after, in every face: so neighbours along an edge need no rotation, and the mirroring of some
   faces does no harm. */
static void cohsm__face_coordinates(uint32_t face, cohsm__v3 q, float *x, float *y, float *w)
{
    float c[3];
    c[0] = q.x;
    c[1] = q.y;
    c[2] = q.z;
    *w = face & 1u ? -c[face >> 1] : c[face >> 1];
    *x = c[((face >> 1) + 1u) % 3u];
    *y = c[((face >> 1) + 2u) % 3u];
}

static uint32_t cohsm__face_of(cohsm__v3 q)
{
    float x = fabsf(q.x), y = fabsf(q.y), z = fabsf(q.z);
    if (x >= y && x >= z) return q.x < 0.0f ? 1u : 0u;
    if (y >= z) return q.y < 0.0f ? 3u : 2u;
    return q.z < 0.0f ? 5u : 4u;
}
