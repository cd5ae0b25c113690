/* ---- scenes: lights inside of what hides ---- */

/* A field says in which directions its object hides, but not how far away. Where the object is a room, it
   hides all that lies beyond its walls, and nothing of a light between them. A light from whose middle more
   than half of all directions are hidden lies in the convex hull of the object, since what lies on one side
   of a plane hides no more than half. The object then is a room for this light, taken for convex: from points
   that lie in the hull as well it does not hide the light; from all others it comes before the light,
   whichever centre is nearer. */

/* Returns the share of directions that an occluder hides from lane l of a place. Of logarithms that is
   unknown: 0, so that there are no rooms. */
static float sfield__share_at(const sfield__item *it, const sfield__place *at, uint32_t l, int simd)
{
    const sfield_field *f = it->e.occlusion;
    float first[16];
    if (f->h.logarithm) return 0;
#ifndef SFIELD_WITHOUT_WAVELETS
    if (f->h.basis == SFIELD_BASIS_HAAR) return sfield__hidden_share(f, at, (int)l);
#endif
    sfield__fetch_lane(f, at, (int)l, 0, 8, first, simd);
    return first[0] * sfield__y00;
}

/* Returns which lanes lie in an occluder's hull, of some whose places are p, in planes, and d2 the squares of
   their distances from its centre. */
static uint32_t sfield__find_inside(const sfield__item *it, const float *p, const float *d2, uint32_t lanes,
                                    int simd)
{
    float local[48];
    sfield__place at;
    uint32_t l, near_by = 0, inside = 0;
    for (l = 0; l < SFIELD__LANES; l++)
        if (lanes >> l & 1 && d2[l] < it->radius[0] * it->radius[0]) near_by |= 1u << l;
    if (!near_by) return 0;
    sfield__move_to_local(it, 0, p, local, simd);
    sfield__locate16(it->e.occlusion, local, &at, simd);
    for (l = 0; l < SFIELD__LANES; l++)
        if (near_by >> l & 1 && sfield__share_at(it, &at, l, simd) > 0.5f) inside |= 1u << l;
    return inside;
}

static int sfield__is_in_hull(const sfield__item *it, const float *x, int simd)
{
    float p[48] = { 0 }, d2[SFIELD__LANES] = { 0 };
    uint32_t k;
    for (k = 0; k < 3; k++) {
        p[16 * k] = x[k];
        d2[0] += (x[k] - it->center[0][k]) * (x[k] - it->center[0][k]);
    }
    return sfield__find_inside(it, p, d2, 1, simd) != 0;
}

/* Lists the lights that lie in the hull of another entity. Returns 0 without memory. A heap of thousands of
   lights and bodies would take gigabytes and minutes, and is no room. */
static int sfield__find_rooms(sfield_scene *s)
{
    uint32_t i, j;
    if (s->overlaps > 65536) return 1;
    s->held = (struct sfield__tenant *)sfield__alloc_array(&s->allocator, s->overlaps, sizeof *s->held);
    if (!s->held) return 0;
    for (i = 0; i < s->light_count; i++)
        for (j = 0; j < s->occluder_count; j++) {
            const uint32_t item = s->occluder[j];
            sfield__item *it = &s->item[item];
            if (s->light[i] == item || s->held_count == s->overlaps) continue;
            if (!sfield__is_in_hull(it, s->item[s->light[i]].center[1], s->simd)) continue;
            s->held[s->held_count].light = i;
            s->held[s->held_count++].item = item;
            if (it->holds) continue;
            it->holds = 1;
            it->inscribed = 0;          /* its middle, which nobody sees from outside, hides nothing inside */
            it->body = sfield__hash(it->body, 1) | 1;
        }
    return 1;
}

/* Returns whether light j lies in the hull of an entity. The list rises with the light, then the entity. */
static int sfield__is_held(const sfield_scene *s, uint32_t j, uint32_t item)
{
    uint32_t low = 0, high = s->held_count;
    if (!s->item[item].holds || j == s->light_count) return 0;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        const struct sfield__tenant *held = &s->held[middle];
        if (held->light < j || (held->light == j && held->item < item)) low = middle + 1;
        else high = middle;
    }
    return low < s->held_count && s->held[low].light == j && s->held[low].item == item;
}

/* Returns whether points lie on the room in which light j is: their self-visibility, which says that the room
   is all around, does not count for the light. Nobody asks on which side of a wall they lie: points on the
   outside that face the light get it through the wall. */
static int sfield__is_home(const sfield_scene *s, const sfield_points *set, uint32_t j)
{
    return set->entity && set->self && sfield__is_held(s, j, set->entity - 1);
}

/* Returns the lanes from which candidate o hides light j that lies in it. */
static uint32_t sfield__mask_room(const sfield__tile *t, uint32_t o)
{
    const float *d2 = t->d2 + (size_t)o * SFIELD__LANES;
    return t->used[o] & ~sfield__find_inside(&t->s->item[t->item[o]], t->p, d2, t->used[o], t->s->simd);
}

static void sfield__start_tile(sfield__tile *t);
static void sfield__fetch_occluder(sfield__tile *t, uint32_t i);
static void sfield__apply_occluder(sfield__tile *t, uint32_t i, uint32_t mask, float *chain);

/* Computes T of a light in the room that the points lie on, from the first of `count` occluders on. */
static void sfield__chain_at_home(sfield__tile *t, const uint16_t *mask, uint32_t count, float *light)
{
    const sfield_points *set = t->set;
    sfield_points bare = *set;
    float *start = t->start;
    uint32_t i;
    bare.self = NULL;
    t->set = &bare;
    t->start = light;
    sfield__start_tile(t);
    t->set = set;
    t->start = start;
    for (i = 0; i < count; i++) {
        sfield__fetch_occluder(t, t->order[i]);
        sfield__apply_occluder(t, t->order[i], mask[i], light);
    }
}
