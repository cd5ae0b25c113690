/* ---- kernels: sixteen triangles seen from an eye ---- */

#define sfield__trio SFIELD__NAME_IN_SET(sfield__trio, SFIELD__SET)
#define sfield__sides SFIELD__NAME_IN_SET(sfield__sides, SFIELD__SET)
#define sfield__boxes SFIELD__NAME_IN_SET(sfield__boxes, SFIELD__SET)
#define sfield__edge SFIELD__NAME_IN_SET(sfield__edge, SFIELD__SET)
#define sfield__cones SFIELD__NAME_IN_SET(sfield__cones, SFIELD__SET)
#define sfield__lanes3_cross SFIELD__NAME_IN_SET(sfield__lanes3_cross, SFIELD__SET)
#define sfield__lanes3_add SFIELD__NAME_IN_SET(sfield__lanes3_add, SFIELD__SET)
#define sfield__lanes_whole SFIELD__NAME_IN_SET(sfield__lanes_whole, SFIELD__SET)
#define sfield__lanes_up SFIELD__NAME_IN_SET(sfield__lanes_up, SFIELD__SET)
#define sfield__lanes_min3 SFIELD__NAME_IN_SET(sfield__lanes_min3, SFIELD__SET)
#define sfield__lanes_max3 SFIELD__NAME_IN_SET(sfield__lanes_max3, SFIELD__SET)
#define sfield__load_trio SFIELD__NAME_IN_SET(sfield__load_trio, SFIELD__SET)
#define sfield__pick_trio SFIELD__NAME_IN_SET(sfield__pick_trio, SFIELD__SET)
#define sfield__sides_of SFIELD__NAME_IN_SET(sfield__sides_of, SFIELD__SET)
#define sfield__on_one_face SFIELD__NAME_IN_SET(sfield__on_one_face, SFIELD__SET)
#define sfield__turn_to_sides SFIELD__NAME_IN_SET(sfield__turn_to_sides, SFIELD__SET)
#define sfield__turn_to_face SFIELD__NAME_IN_SET(sfield__turn_to_face, SFIELD__SET)
#define sfield__round_boxes SFIELD__NAME_IN_SET(sfield__round_boxes, SFIELD__SET)
#define sfield__edge_between SFIELD__NAME_IN_SET(sfield__edge_between, SFIELD__SET)
#define sfield__find_cones SFIELD__NAME_IN_SET(sfield__find_cones, SFIELD__SET)
#define sfield__cut_rows SFIELD__NAME_IN_SET(sfield__cut_rows, SFIELD__SET)
#define sfield__store_planes SFIELD__NAME_IN_SET(sfield__store_planes, SFIELD__SET)
#define sfield__store_trio SFIELD__NAME_IN_SET(sfield__store_trio, SFIELD__SET)
#define sfield__draw_rows SFIELD__NAME_IN_SET(sfield__draw_rows, SFIELD__SET)
#define sfield__draw_across SFIELD__NAME_IN_SET(sfield__draw_across, SFIELD__SET)
#define sfield__draw_triangles SFIELD__NAME_IN_SET(sfield__draw_triangles, SFIELD__SET)

/* SFIELD__IN_VIEW stands after `static`, before a function that these kernels call. SSE2 beside AVX2 is for
   old processors: calls in place of copies spare compilers a fifteenth of their time for the whole header,
   and make a build two fifths longer there. */
#undef SFIELD__IN_VIEW
#if defined(__GNUC__) && SFIELD__SIMD_SETS && SFIELD__WIDTH == 4
#define SFIELD__IN_VIEW __attribute__((noinline)) SFIELD__KERNEL
#else
#define SFIELD__IN_VIEW inline SFIELD__IN_KERNEL
#endif

typedef struct sfield__trio { sfield__lanes3 a, b, c; } sfield__trio;   /* the corners of triangles */

static SFIELD__IN_VIEW sfield__lanes3 sfield__lanes3_cross(sfield__lanes3 a, sfield__lanes3 b)
{
    sfield__lanes3 n;
    n.x = sfield__lanes_sub(sfield__lanes_mul(a.y, b.z), sfield__lanes_mul(a.z, b.y));
    n.y = sfield__lanes_sub(sfield__lanes_mul(a.z, b.x), sfield__lanes_mul(a.x, b.z));
    n.z = sfield__lanes_sub(sfield__lanes_mul(a.x, b.y), sfield__lanes_mul(a.y, b.x));
    return n;
}

static SFIELD__IN_VIEW sfield__lanes3 sfield__lanes3_add(sfield__lanes3 a, sfield__lanes3 b)
{
    a.x = sfield__lanes_add(a.x, b.x);
    a.y = sfield__lanes_add(a.y, b.y);
    a.z = sfield__lanes_add(a.z, b.z);
    return a;
}

/* Rounds floats from 0 to 2^31 down; sfield__lanes_up rounds them up. */
static SFIELD__IN_VIEW sfield__lanes sfield__lanes_whole(sfield__lanes a)
{
    return sfield__lanes_of_ints(sfield__lanes_truncate(a));
}

static SFIELD__IN_VIEW sfield__lanes sfield__lanes_up(sfield__lanes a)
{
    const sfield__lanes whole = sfield__lanes_whole(a);
    const sfield__lanes one = sfield__lanes_all(1);
    return sfield__lanes_add(whole, sfield__lanes_keep(sfield__lanes_greater(a, whole), one));
}

static SFIELD__IN_VIEW sfield__lanes sfield__lanes_min3(sfield__lanes a, sfield__lanes b,
                                                        sfield__lanes c)
{
    return sfield__lanes_min(sfield__lanes_min(a, b), c);
}

static SFIELD__IN_VIEW sfield__lanes sfield__lanes_max3(sfield__lanes a, sfield__lanes b,
                                                        sfield__lanes c)
{
    return sfield__lanes_max(sfield__lanes_max(a, b), c);
}

/* Loads the corners of sixteen triangles from planes that are `room` apart, about an eye. */
static SFIELD__IN_VIEW sfield__trio sfield__load_trio(const float *from, size_t room,
                                                      const float *eye)
{
    const sfield__lanes3 origin = sfield__lanes3_all(eye[0], eye[1], eye[2]);
    sfield__trio t;
    t.a = sfield__lanes3_sub(sfield__lanes3_load(from, from + room, from + 2 * room), origin);
    from += 3 * room;
    t.b = sfield__lanes3_sub(sfield__lanes3_load(from, from + room, from + 2 * room), origin);
    from += 3 * room;
    t.c = sfield__lanes3_sub(sfield__lanes3_load(from, from + room, from + 2 * room), origin);
    return t;
}

/* Loads triangles by their numbers, sixteen of them. */
static SFIELD__IN_VIEW sfield__trio sfield__pick_trio(const float *from, size_t room,
                                                      const float *eye, const uint32_t *number)
{
    float all[9 * 16];
    uint32_t k, l;
    for (k = 0; k < 9; k++)
        for (l = 0; l < 16; l++) all[16 * k + l] = from[k * room + number[l]];
    return sfield__load_trio(all, 16, eye);
}

/* The faces that corners lie on, as sfield__face_of finds them. */
typedef struct sfield__sides {
    sfield__lane_mask x, y;             /* the axis; z where neither */
    sfield__lane_mask front;            /* of the axis: on its positive side */
    sfield__lanes     number;           /* 0..5 */
} sfield__sides;

static SFIELD__IN_VIEW sfield__sides sfield__sides_of(sfield__lanes3 p)
{
    const sfield__lanes x = sfield__lanes_abs(p.x), y = sfield__lanes_abs(p.y), z = sfield__lanes_abs(p.z);
    const sfield__lanes none = sfield__lanes_all(0);
    sfield__sides s;
    s.x = sfield__mask_and(sfield__lanes_at_least(x, y), sfield__lanes_at_least(x, z));
    s.y = sfield__mask_and(sfield__lanes_greater(y, x), sfield__lanes_at_least(y, z));
    s.front = sfield__lanes_greater(
        sfield__lanes_select(s.x, p.x, sfield__lanes_select(s.y, p.y, p.z)), none);
    s.number = sfield__lanes_select(s.x, none, sfield__lanes_select(s.y, sfield__lanes_all(2),
                                                                    sfield__lanes_all(4)));
    s.number = sfield__lanes_add(s.number, sfield__lanes_select(s.front, none, sfield__lanes_all(1)));
    return s;
}

/* Returns which triangles have their three corners on the face of the first, as bits. */
static SFIELD__IN_VIEW uint32_t sfield__on_one_face(const sfield__trio *t, sfield__lanes number)
{
    const sfield__lanes b = sfield__sides_of(t->b).number, c = sfield__sides_of(t->c).number;
    return ~sfield__mask_bits(sfield__mask_or(sfield__lanes_differ(number, b),
                                              sfield__lanes_differ(number, c))) & 0xffffu;
}

/* Turns the corners of triangles as sfield__to_face does, each to a face of its own, on which the corners
   lie: the part along the axis is its absolute value. */
static SFIELD__IN_VIEW sfield__trio sfield__turn_to_sides(const sfield__trio *t,
                                                          const sfield__sides *on)
{
    const sfield__lanes one = sfield__lanes_all(1), minus = sfield__lanes_all(-1);
    const sfield__lanes front = sfield__lanes_select(on->front, one, minus);
    const sfield__lanes back = sfield__lanes_select(on->front, minus, one);
    const sfield__lanes s = sfield__lanes_select(on->x, back, sfield__lanes_select(on->y, one, front));
    const sfield__lanes u = sfield__lanes_select(on->y, front, minus);
    sfield__trio q;
#define SFIELD__TURN(p)                                                                                    \
    q.p.x = sfield__lanes_mul(s, sfield__lanes_select(on->x, t->p.z, t->p.x));                             \
    q.p.y = sfield__lanes_mul(u, sfield__lanes_select(on->y, t->p.z, t->p.y));                             \
    q.p.z = sfield__lanes_abs(                                                                             \
        sfield__lanes_select(on->x, t->p.x, sfield__lanes_select(on->y, t->p.y, t->p.z)))
    SFIELD__TURN(a);
    SFIELD__TURN(b);
    SFIELD__TURN(c);
#undef SFIELD__TURN
    return q;
}

static SFIELD__IN_VIEW sfield__lanes3 sfield__turn_to_face(uint32_t face, sfield__lanes3 p)
{
    sfield__lanes3 q = p;
    const sfield__lanes3 back = sfield__lanes3_scale(p, sfield__lanes_all(-1));
    switch (face) {
    case 0: q.x = back.z, q.y = back.y, q.z = p.x; break;
    case 1: q.x = p.z, q.y = back.y, q.z = back.x; break;
    case 2: q.y = p.z, q.z = p.y; break;
    case 3: q.y = back.z, q.z = back.y; break;
    case 4: q.y = back.y; break;
    default: q = back; break;
    }
    return q;
}

/* Places of samples, whole numbers: those that may lie inside triangles. */
typedef struct sfield__boxes {
    sfield__lanes     x0, y0, x1, y1;
    sfield__lane_mask used;             /* lanes with one sample at least */
} sfield__boxes;

/* Rounds boxes to samples, outwards by a little. */
static SFIELD__IN_VIEW sfield__boxes sfield__round_boxes(sfield__boxes b, float width)
{
    const sfield__lanes none = sfield__lanes_all(0), most = sfield__lanes_all(width - 1);
    const sfield__lanes a_little = sfield__lanes_all(0.01f);
    b.x0 = sfield__lanes_max(sfield__lanes_sub(b.x0, a_little), none);
    b.y0 = sfield__lanes_max(sfield__lanes_sub(b.y0, a_little), none);
    b.x1 = sfield__lanes_min(sfield__lanes_add(b.x1, a_little), most);
    b.y1 = sfield__lanes_min(sfield__lanes_add(b.y1, a_little), most);
    b.used = sfield__mask_and(sfield__lanes_at_least(b.x1, b.x0), sfield__lanes_at_least(b.y1, b.y0));
    b.x0 = sfield__lanes_up(sfield__lanes_keep(b.used, b.x0));
    b.y0 = sfield__lanes_up(sfield__lanes_keep(b.used, b.y0));
    b.x1 = sfield__lanes_whole(sfield__lanes_keep(b.used, b.x1));
    b.y1 = sfield__lanes_whole(sfield__lanes_keep(b.used, b.y1));
    b.used = sfield__mask_and(b.used, sfield__lanes_at_least(b.x1, b.x0));
    b.used = sfield__mask_and(b.used, sfield__lanes_at_least(b.y1, b.y0));
    return b;
}

/* Edges: c.x s + c.y t + c.z >= 0 on the inner side. */
typedef struct sfield__edge {
    sfield__lanes3    c;
    sfield__lanes     inverse;          /* 1 / c.x */
    sfield__lane_mask left, right, flat;    /* of the samples inside: where the edge is; c.x = 0 */
} sfield__edge;

typedef struct sfield__cones {
    sfield__edge a, b, c;
    sfield__lanes det;                  /* > 0: counter-clockwise for the eye */
} sfield__cones;

static SFIELD__IN_VIEW void sfield__edge_between(sfield__edge *e, sfield__lanes turn)
{
    const sfield__lanes none = sfield__lanes_all(0), one = sfield__lanes_all(1);
    e->c = sfield__lanes3_scale(e->c, turn);
    e->inverse = sfield__lanes_keep(sfield__lanes_differ(e->c.x, none), sfield__lanes_div(one, e->c.x));
    e->left = sfield__lanes_greater(e->c.x, none);
    e->right = sfield__lanes_greater(none, e->c.x);
    e->flat = sfield__lanes_greater(
        sfield__lanes_select(sfield__mask_or(e->left, e->right), none, one), none);
}

/* Describes triangles as the cones from the eye through their edges. So nothing is clipped or divided, and
   an edge that two triangles share has the same numbers in both but for their sign: no sample falls between
   them. Returns, as bits, those that are not seen from their edge. */
static SFIELD__IN_VIEW uint32_t sfield__find_cones(const sfield__trio *q, sfield__cones *e)
{
    const sfield__lanes none = sfield__lanes_all(0);
    sfield__lane_mask front, back;
    sfield__lanes turn;
    e->a.c = sfield__lanes3_cross(q->a, q->b);
    e->b.c = sfield__lanes3_cross(q->b, q->c);
    e->c.c = sfield__lanes3_cross(q->c, q->a);
    e->det = sfield__lanes3_dot(q->c, e->a.c);
    front = sfield__lanes_greater(e->det, none);
    back = sfield__lanes_greater(none, e->det);
    turn = sfield__lanes_select(back, sfield__lanes_all(-1), sfield__lanes_all(1));
    sfield__edge_between(&e->a, turn);
    sfield__edge_between(&e->b, turn);
    sfield__edge_between(&e->c, turn);
    return sfield__mask_bits(sfield__mask_or(front, back));
}

/* Finds the samples of a row t inside an edge: narrows low..high. */
static SFIELD__IN_VIEW void sfield__cut_rows(const sfield__edge *e, sfield__lanes t, float half,
                                             sfield__lanes *low, sfield__lanes *high)
{
    const sfield__lanes c = sfield__lanes_add(sfield__lanes_mul(e->c.y, t), e->c.z);
    const sfield__lanes part = sfield__lanes_sub(sfield__lanes_all(1), sfield__lanes_mul(c, e->inverse));
    const sfield__lanes x = sfield__lanes_sub(sfield__lanes_mul(part, sfield__lanes_all(half)),
                                              sfield__lanes_all(0.5f));
    const sfield__lane_mask beyond =
        sfield__mask_and(e->flat, sfield__lanes_greater(sfield__lanes_all(0), c));
    *low = sfield__lanes_select(e->left, sfield__lanes_max(x, *low), *low);
    *low = sfield__lanes_select(beyond, sfield__lanes_all(3e38f), *low);
    *high = sfield__lanes_select(e->right, sfield__lanes_min(x, *high), *high);
}

/* The planes of 1 / distance of triangles, in rows: s, t, 1, and what the sum is divided by. Sides that do
   not emit are drawn a little farther away; otherwise those of a sheet that shines on both sides would hide
   its light by rounding. */
static SFIELD__IN_VIEW void sfield__store_planes(const sfield__cones *e, float *planes)
{
    const sfield__lanes3 sum = sfield__lanes3_add(sfield__lanes3_add(e->a.c, e->b.c), e->c.c);
    const sfield__lane_mask front = sfield__lanes_greater(e->det, sfield__lanes_all(0));
    const sfield__lanes back = sfield__lanes_mul(sfield__lanes_all(-1.00001f), e->det);
    sfield__lanes_store(planes, sum.x);
    sfield__lanes_store(planes + 16, sum.y);
    sfield__lanes_store(planes + 32, sum.z);
    sfield__lanes_store(planes + 48, sfield__lanes_select(front, e->det, back));
}

/* Stores the corners of triangles: x, y, z of the first corner of each, then those of the others. */
static SFIELD__IN_VIEW void sfield__store_trio(const sfield__trio *q, float *to)
{
    sfield__lanes_store(to, q->a.x);
    sfield__lanes_store(to + 16, q->a.y);
    sfield__lanes_store(to + 32, q->a.z);
    sfield__lanes_store(to + 48, q->b.x);
    sfield__lanes_store(to + 64, q->b.y);
    sfield__lanes_store(to + 80, q->b.z);
    sfield__lanes_store(to + 96, q->c.x);
    sfield__lanes_store(to + 112, q->c.y);
    sfield__lanes_store(to + 128, q->c.z);
}

/* Draws the triangles that `bits` names, each within its box on its face, which they are turned to.
   number: of each lane, read where there are depths or a mask. */
static SFIELD__IN_VIEW void sfield__draw_rows(const sfield__build *b, sfield__view *v,
                                              const sfield__trio *q, sfield__lanes face,
                                              const sfield__boxes *box, uint32_t bits,
                                              const uint32_t *number)
{
    const float half = 0.5f * (float)v->width;
    const size_t words = v->width / 64;
    float planes[64], corners[9 * 16];
    int32_t first[16], x0[16], x1[16];
    sfield__lanes y = box->y0;
    sfield__lane_mask rows;
    sfield__cones e;
    uint32_t front, down;
    bits &= sfield__find_cones(q, &e);
    if (!bits) return;
    front = sfield__mask_bits(sfield__lanes_greater(e.det, sfield__lanes_all(0)));
    sfield__ints_store(first, sfield__lanes_truncate(sfield__lanes_add(
        sfield__lanes_mul(face, sfield__lanes_all((float)v->width)), y)));
    if (v->depth) sfield__store_planes(&e, planes);
    if (b->mask_fn) sfield__store_trio(q, corners);
    rows = sfield__mask_of_bits(bits);
    for (down = 0; bits; down++) {
        sfield__lanes t = sfield__lanes_mul(sfield__lanes_add(y, sfield__lanes_all(0.5f)),
                                            sfield__lanes_all(1 / half));
        sfield__lanes low = box->x0, high = box->x1;
        sfield__lane_mask some;
        t = sfield__lanes_sub(t, sfield__lanes_all(1));
        sfield__cut_rows(&e.a, t, half, &low, &high);
        sfield__cut_rows(&e.b, t, half, &low, &high);
        sfield__cut_rows(&e.c, t, half, &low, &high);
        some = sfield__mask_and(rows, sfield__lanes_at_least(high, low));
        low = sfield__lanes_up(sfield__lanes_keep(some, low));
        high = sfield__lanes_whole(sfield__lanes_keep(some, high));
        some = sfield__mask_and(some, sfield__lanes_at_least(high, low));
        sfield__ints_store(x0, sfield__lanes_truncate(low));
        sfield__ints_store(x1, sfield__lanes_truncate(high));
        for (bits = sfield__mask_bits(some); bits; bits &= bits - 1) {
            const uint32_t l = sfield__first_bit(bits);
            const size_t row = (size_t)first[l] + down;
            uint32_t owner = 0;
            v->touched[row] = 1;
            if (v->depth || b->mask_fn)
                owner = (b->original[number[l]] + 1) | (front >> l & 1 ? 0 : 0x80000000u);
            if (b->mask_fn)
                sfield__draw_masked_span(b, v, row, x0[l], x1[l], planes + l, owner, corners + l);
            else if (v->depth) sfield__draw_span(v, row, x0[l], x1[l], planes + l, owner);
            else sfield__set_bits(v->bits + row * words, x0[l], x1[l]);
        }
        y = sfield__lanes_add(y, sfield__lanes_all(1));
        rows = sfield__mask_and(rows, sfield__lanes_at_least(box->y1, y));
        bits = sfield__mask_bits(rows);
    }
}

/* Draws sixteen triangles that lie over several faces, on each face whose pyramid they may touch. */
SFIELD__KERNEL static void sfield__draw_across(const sfield__build *b, sfield__view *v, const float *eye,
                                               const uint32_t *number)
{
    const sfield__trio t = sfield__pick_trio(b->corner, b->corner_room, eye, number);
    const float width = (float)v->width, h = 0.5f * width;
    const sfield__lanes half = sfield__lanes_all(h), middle = sfield__lanes_all(h - 0.5f);
    const sfield__lanes none = sfield__lanes_all(0);
    uint32_t face;
    for (face = 0; face < 6; face++) {
        sfield__trio q;
        sfield__lanes3 x, y, z, minus;
        sfield__lane_mask all, any;
        sfield__boxes box;
        uint32_t out, whole, used;
        q.a = sfield__turn_to_face(face, t.a);
        q.b = sfield__turn_to_face(face, t.b);
        q.c = sfield__turn_to_face(face, t.c);
        x.x = q.a.x, x.y = q.b.x, x.z = q.c.x;
        y.x = q.a.y, y.y = q.b.y, y.z = q.c.y;
        z.x = q.a.z, z.y = q.b.z, z.z = q.c.z;
#define SFIELD__ALL_BEYOND(v)                                                                              \
    sfield__mask_and(sfield__mask_and(sfield__lanes_greater(v.x, z.x), sfield__lanes_greater(v.y, z.y)),   \
                     sfield__lanes_greater(v.z, z.z))
        minus = sfield__lanes3_scale(x, sfield__lanes_all(-1));
        all = sfield__mask_or(SFIELD__ALL_BEYOND(x), SFIELD__ALL_BEYOND(minus));
        minus = sfield__lanes3_scale(y, sfield__lanes_all(-1));
        all = sfield__mask_or(all, sfield__mask_or(SFIELD__ALL_BEYOND(y), SFIELD__ALL_BEYOND(minus)));
#undef SFIELD__ALL_BEYOND
        out = sfield__mask_bits(all);
        all = sfield__lanes_greater(sfield__lanes_min3(z.x, z.y, z.z), none);
        any = sfield__lanes_greater(sfield__lanes_max3(z.x, z.y, z.z), none);
        used = sfield__mask_bits(any) & ~out;
        if (!used) continue;
        whole = sfield__mask_bits(all);
        x.x = sfield__lanes_div(x.x, z.x);
        x.y = sfield__lanes_div(x.y, z.y);
        x.z = sfield__lanes_div(x.z, z.z);
        y.x = sfield__lanes_div(y.x, z.x);
        y.y = sfield__lanes_div(y.y, z.y);
        y.z = sfield__lanes_div(y.z, z.z);
        box.x0 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_min3(x.x, x.y, x.z), half), middle);
        box.y0 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_min3(y.x, y.y, y.z), half), middle);
        box.x1 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_max3(x.x, x.y, x.z), half), middle);
        box.y1 = sfield__lanes_add(sfield__lanes_mul(sfield__lanes_max3(y.x, y.y, y.z), half), middle);
        box = sfield__round_boxes(box, width);
        used &= (whole & sfield__mask_bits(box.used)) | ~whole;
        box.used = sfield__mask_of_bits(used);
        box.x0 = sfield__lanes_keep(all, box.x0);
        box.y0 = sfield__lanes_keep(all, box.y0);
        box.x1 = sfield__lanes_select(all, box.x1, sfield__lanes_all(width - 1));
        box.y1 = sfield__lanes_select(all, box.y1, sfield__lanes_all(width - 1));
        if (used) sfield__draw_rows(b, v, &q, sfield__lanes_all((float)face), &box, used, number);
    }
}

/* See sfield__draw_triangles16. Triangles that lie over several faces wait until there are sixteen; the last
   of them go with some that were drawn before, which changes nothing. Triangles with a corner at the eye, and
   those of three equal corners in the last lanes of the planes, have no cone. */
SFIELD__KERNEL static void sfield__draw_triangles(const sfield__build *b, sfield__view *v, const float *eye)
{
    const float width = (float)v->width;
    const sfield__lanes half = sfield__lanes_all(0.5f * width), one_half = sfield__lanes_all(0.5f);
    uint32_t across[32], number[16], waiting = 0, l;
    size_t i;
    memset(across, 0, sizeof across);
    for (i = 0; i < b->triangles; i += 16) {
        const sfield__trio t = sfield__load_trio(b->corner + i, b->corner_room, eye);
        const sfield__sides on = sfield__sides_of(t.a);
        const sfield__trio q = sfield__turn_to_sides(&t, &on);
        sfield__lanes3 scale, x, y;
        sfield__boxes box;
        uint32_t one = sfield__on_one_face(&t, on.number), used;
        for (used = ~one & 0xffffu; used; used &= used - 1)
            across[waiting++] = (uint32_t)i + sfield__first_bit(used);
        scale.x = sfield__lanes_div(half, q.a.z);
        scale.y = sfield__lanes_div(half, q.b.z);
        scale.z = sfield__lanes_div(half, q.c.z);
#define SFIELD__PLACE(a, scale)                                                                            \
    sfield__lanes_sub(sfield__lanes_add(sfield__lanes_mul(a, scale), half), one_half)
        x.x = SFIELD__PLACE(q.a.x, scale.x);
        x.y = SFIELD__PLACE(q.b.x, scale.y);
        x.z = SFIELD__PLACE(q.c.x, scale.z);
        y.x = SFIELD__PLACE(q.a.y, scale.x);
        y.y = SFIELD__PLACE(q.b.y, scale.y);
        y.z = SFIELD__PLACE(q.c.y, scale.z);
#undef SFIELD__PLACE
        box.x0 = sfield__lanes_min3(x.x, x.y, x.z);
        box.y0 = sfield__lanes_min3(y.x, y.y, y.z);
        box.x1 = sfield__lanes_max3(x.x, x.y, x.z);
        box.y1 = sfield__lanes_max3(y.x, y.y, y.z);
        box = sfield__round_boxes(box, width);
        used = one & sfield__mask_bits(box.used);
        if (used) {
            for (l = 0; l < 16 && (v->depth || b->mask_fn); l++) number[l] = (uint32_t)i + l;
            sfield__draw_rows(b, v, &q, on.number, &box, used, number);
        }
        if (waiting < 16) continue;
        sfield__draw_across(b, v, eye, across);
        waiting -= 16;
        for (l = 0; l < waiting; l++) across[l] = across[16 + l];
    }
    if (waiting) sfield__draw_across(b, v, eye, across);
}
