/* ---- building: sample points inside a mesh ---- */

/* Fields are interpolated: a position inside the mesh, which sees nothing, would darken receivers between it
   and the next one outside. It takes the view from the surface instead, that of a receiver there. */

enum { SFIELD__INSIDE_RAYS = 27, SFIELD__CROSSINGS = 32 };
static const float sfield__outside = 1e-3f;     /* over the surface, in r; gaps below twice that are none */

typedef struct sfield__inside_ray {        /* a ray from the eye */
    float d[3];
    uint32_t face;                  /* of the cube about the eye that it goes through */
    float at[SFIELD__CROSSINGS];    /* where it meets the mesh, rising; < 0: goes in at that distance, > 0:
                                       comes out */
    int   count;                    /* of them; those beyond the last are left out */
    int   winding;                  /* times that it comes out, less times that it goes in */
} sfield__inside_ray;

/* Aims the rays: outwards, and to faces, edges and corners of a cube. All are turned a little, so that none
   runs along the edges of a mesh. */
static void sfield__aim_rays(const float *eye, sfield__inside_ray *ray)
{
    int i;
    for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
        sfield__v3 d = sfield__v3_make((float)(i % 3 - 1), (float)(i / 3 % 3 - 1), (float)(i / 9 - 1));
        if (i == SFIELD__INSIDE_RAYS / 2) d = sfield__v3_load(eye);
        d = sfield__v3_add(sfield__v3_normalize(d), sfield__v3_make(0.0131f, -0.0079f, 0.0107f));
        sfield__v3_store(ray[i].d, sfield__v3_normalize(d));
        ray[i].face = sfield__face_of(ray[i].d);
        ray[i].count = ray[i].winding = 0;
    }
}

static void sfield__add_crossing(sfield__inside_ray *ray, float t, int out)
{
    int i = ray->count < SFIELD__CROSSINGS ? ray->count++ : SFIELD__CROSSINGS;
    ray->winding += out ? 1 : -1;
    for (; i > 0 && fabsf(ray->at[i - 1]) > t; i--)
        if (i < SFIELD__CROSSINGS) ray->at[i] = ray->at[i - 1];
    if (i < SFIELD__CROSSINGS) ray->at[i] = out ? t : -t;
}

/* Finds where all rays from the eye meet the mesh, triangle after triangle. */
static void sfield__find_crossings16(const sfield__build *b, const float *eye, sfield__inside_ray *ray);

/* Returns the distance at which a ray that starts inside is out of everything; 0 if there is none. */
static float sfield__find_way_out(const sfield__inside_ray *ray)
{
    int i, inside = ray->winding;
    for (i = 0; i < ray->count && inside > 0; i++) {
        inside += ray->at[i] < 0 ? 1 : -1;
        if (inside <= 0 && i + 1 < SFIELD__CROSSINGS &&
            (i + 1 == ray->count || fabsf(ray->at[i + 1]) > ray->at[i] + 2 * sfield__outside))
            return ray->at[i];
    }
    return 0;
}

static float sfield__share_hidden(const sfield__build *b, const float *texel)
{
    float sum = 0;
    uint32_t c;
    for (c = 0; c < b->cells; c++) sum += texel[c];
    return sum / (float)b->cells;
}

/* Moves the eye out of the mesh. Returns 0 if the eye is not inside. It is inside if nearly all directions
   are hidden and most rays leave the mesh once more than they enter it, counter-clockwise triangles being
   seen from outside. So nothing is inside a single sheet, a room or a cup. */
static int sfield__move_out(const sfield__build *b, float hidden, float *eye)
{
    sfield__inside_ray ray[SFIELD__INSIDE_RAYS];
    float nearest = 0;
    int i, k, inside = 0, best = 0;
    if (hidden < 0.99f) return 0;
    sfield__aim_rays(eye, ray);
    sfield__find_crossings16(b, eye, ray);
    for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
        float t = sfield__find_way_out(&ray[i]);
        inside += ray[i].winding > 0;
        if (!(t > 0 && t < 1000) || (nearest > 0 && t >= nearest)) continue;
        nearest = t;
        best = i;
    }
    if (2 * inside <= SFIELD__INSIDE_RAYS || !(nearest > 0)) return 0;
    for (k = 0; k < 3; k++) eye[k] += (nearest + sfield__outside) * ray[best].d[k];
    return 1;
}

/* Finds the eyes that are inside the mesh, by what was seen from them, and moves them out. */
static void sfield__find_inside_task(void *context, size_t piece)
{
    const sfield__build *b = (const sfield__build *)context;
    sfield__view *v = &b->view[piece];
    size_t i;
    for (i = piece; i < b->to - b->from; i += b->pieces) {
        const float *seen = b->seen + i * b->seen_size;
        float hidden = b->h.basis == SFIELD_BASIS_SH ? seen[0] / 3.54490770f : sfield__share_hidden(b, seen);
        b->moved[i] = 0;
        if (!(hidden >= 0.99f)) continue;
        b->moved[i] = (uint8_t)sfield__move_out(b, hidden, b->eyes + 3 * i);
        v->moved += b->moved[i];
    }
}
