/* ---- building: what lines and cylinders radiate ---- */

/* A tube, a line or the side of a cylinder, as an eye sees it, in r. */
typedef struct sfield__tube {
    sfield__v3 axis, toward, across; /* unit: along the tube; from the eye to its axis by the shortest way;
                                        the cross product of both */
    float length, size;             /* half its length; the radius of a cylinder, 0 of a line */
    float along, away;              /* of the eye, from the middle along the axis, and from the axis */
    float sine[8 * 64 + 1];         /* edges of slices through the eye, across the axis: of their angles above
                                       the shortest way */
} sfield__tube;

static int sfield__is_tube(const sfield_emitter *e)
{
    return e->kind == SFIELD_EMITTER_LINE || e->kind == SFIELD_EMITTER_CYLINDER;
}

static sfield__v3 sfield__weigh2(sfield__v3 a, float s, sfield__v3 b, float t)
{
    return sfield__v3_add(sfield__v3_scale(a, s), sfield__v3_scale(b, t));
}

/* Looks at the emitter from the eye. A texel is four slices wide where the slices are widest. */
static void sfield__face_tube(const sfield__build *b, const float *eye, sfield__tube *t)
{
    const sfield_emitter *e = &b->emitter;
    const float inverse = 1 / b->h.radius;
    const uint32_t count = 8 * b->h.cube_side;
    sfield__v3 u = sfield__v3_scale(sfield__v3_load(e->u), inverse), at = sfield__v3_load(eye), shortest;
    float cosine;
    uint32_t i;
    t->axis = sfield__v3_normalize(u);
    t->length = sfield__v3_length(u);
    t->size = e->kind == SFIELD_EMITTER_CYLINDER ? e->radius * inverse : 0;
    t->along = sfield__v3_dot(at, t->axis);
    shortest = sfield__weigh2(t->axis, t->along, at, -1);
    t->away = sfield__v3_length(shortest);
    if (!(t->away > 1e-6f)) {           /* on the axis: any way will do */
        shortest = fabsf(t->axis.x) < 0.7f ? sfield__v3_make(1, 0, 0) : sfield__v3_make(0, 1, 0);
        shortest = sfield__weigh2(shortest, 1, t->axis, -sfield__v3_dot(shortest, t->axis));
    }
    t->toward = sfield__v3_normalize(shortest);
    t->across = sfield__v3_cross(t->axis, t->toward);
    for (i = 0; i <= count; i++)
        sfield__sincos(3.14159265f * ((float)i / (float)count - 0.5f), &t->sine[i], &cosine);
}

static int sfield__leaves_cone(const sfield__build *b, const float *d)
{
    const float *n = b->emitter.normal;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) return 0;
    return -(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]) < b->cosine;
}

/* Adds a share of light to the four texels about a direction, so that its middle stays where it is: one texel
   alone would move thin tubes by half a texel. */
static void sfield__spread_light(const sfield__build *b, sfield__view *v, const float *d, float share)
{
    const uint32_t n = b->h.cube_side, face = sfield__face_of(d);
    uint32_t at[2], i;
    float q[3], part[2];
    sfield__to_face(face, d, q);
    for (i = 0; i < 2; i++) {
        float x = (q[i] / q[2] + 1) * 0.5f * (float)n - 0.5f;
        x = x > 0 ? x : 0;
        at[i] = (uint32_t)x < n - 2 ? (uint32_t)x : n - 2;
        part[i] = x - (float)at[i] < 1 ? x - (float)at[i] : 1;
    }
    for (i = 0; i < 4; i++) {
        const float x = i & 1 ? part[0] : 1 - part[0], y = i & 2 ? part[1] : 1 - part[1];
        v->texel[sfield__texel_number(n, face, at[0] + (i & 1), at[1] + (i >> 1))] += share * x * y;
    }
}

/* Adds what lies in a strip along the tube: turned about the axis by an angle of this sine and cosine from
   the shortest way, so far from the eye, and so wide an angle. Between two slices it fills a solid angle of
   width times the difference of their sines. */
static void sfield__add_strip(const sfield__build *b, sfield__view *v, const sfield__tube *t, float sine,
                              float cosine, float distance, float width)
{
    const float low = -t->length - t->along, high = t->length - t->along;
    const float first = low / sqrtf(low * low + distance * distance);
    const float last = high / sqrtf(high * high + distance * distance);
    const sfield__v3 out = sfield__weigh2(t->toward, cosine, t->across, sine);
    uint32_t i;
    for (i = 0; i < 8 * b->h.cube_side; i++) {
        const float from = t->sine[i] > first ? t->sine[i] : first;
        const float to = t->sine[i + 1] < last ? t->sine[i + 1] : last;
        const float middle = 0.5f * (from + to);
        float d[3];
        if (!(from < to)) continue;
        sfield__v3_store(d, sfield__weigh2(out, sqrtf(1 - middle * middle), t->axis, middle));
        if (!sfield__leaves_cone(b, d)) sfield__spread_light(b, v, d, (to - from) * width);
    }
}

/* Adds the strips of a cylinder that face an eye outside. They are even about its axis, so that their
   distance is smooth up to the edge of the cylinder. */
static void sfield__add_strips(const sfield__build *b, sfield__view *v, const sfield__tube *t)
{
    const float ratio = t->size / t->away, widest = sfield__asin(ratio);
    const uint32_t count = 8 + (uint32_t)(5.1f * widest * (float)b->h.cube_side);
    float before = -widest;
    uint32_t i;
    for (i = 0; i < count; i++) {
        const float step = 3.14159265f / (float)count, angle = step * ((float)i + 0.5f) - 1.57079633f;
        float s, c, edge, after;
        float sine, cosine, distance;
        sfield__sincos(angle, &s, &c);
        sfield__sincos(angle + 0.5f * step, &edge, &cosine);
        after = i + 1 < count ? sfield__asin(ratio * edge) : widest;
        sine = ratio * s;
        cosine = sqrtf(1 - sine * sine);
        distance = t->away * cosine - t->size * c;
        sfield__add_strip(b, v, t, sine, cosine, distance > 1e-6f ? distance : 1e-6f, after - before);
        before = after;
    }
}

/* Samples a line or cylinder. A line is a cylinder that became thin as its radiance rose, so that radiance
   times diameter stayed: from h away that is a strip as wide as the diameter over h. Nearer than half the way
   to the next sample point it does not grow, for fields are interpolated. */
static void sfield__sample_tube(const sfield__build *b, sfield__view *v, const float *eye)
{
    const float *radiance = b->emitter.radiance;
    sfield__tube t;
    uint32_t i, c;
    sfield__face_tube(b, eye, &t);
    if (b->emitter.kind == SFIELD_EMITTER_LINE) {
        const float apart = 1.57079633f / (float)(b->h.position_side - 1);
        const float least = 0.5f * apart * sfield__v3_length(sfield__v3_load(eye));
        const float h = t.away > least ? t.away : least;
        sfield__add_strip(b, v, &t, 0, 1, h, 1 / (h * b->h.radius));
    } else if (t.away > t.size) sfield__add_strips(b, v, &t);
    else if (fabsf(t.along) <= t.length)        /* inside: as inside a sphere */
        for (i = 0; i < b->cells; i++)
            if (!sfield__leaves_cone(b, b->texels.direction + 3 * i)) v->texel[i] = b->texels.angle[i];
    for (i = 0; i < b->cells; i++) {
        const float bright = v->texel[i] / b->texels.angle[i];
        for (c = 0; c < 3; c++) {
            const float x = bright * radiance[c];
            v->texel[c * b->cells + i] = x < 1e18f ? x : 1e18f;
        }
    }
}
