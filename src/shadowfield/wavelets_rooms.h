/* ---- wavelets: lights inside of what hides ---- */

/* Takes a room behind the light that it holds. Lights that it does not hold stay behind it. The list has one
   order for all lights: these then lie behind the occluders between the room and the light that it holds,
   too. */
static void sfield__take_behind(const sfield_scene *s, sfield__ray *ray, uint32_t room, uint32_t light)
{
    const uint32_t item = ray[room].item;
    uint32_t i, first = room;           /* from here on: the room, and lights that it does not hold */
    for (i = room + 1; i <= light; i++) {
        const sfield__ray moved = ray[i];
        if (moved.light >= 0 && !sfield__is_held(s, (uint32_t)moved.light, item)) continue;
        memmove(ray + first + 1, ray + first, (i - first) * sizeof *ray);
        ray[first++] = moved;
    }
}

/* Orders rooms and the lights in them as x sees them, among the `count` entities of a point. A light that is
   seen from outside of its room goes behind all that is nearer than the room's centre; harmonics, whose masks
   are those of one light each, hide it by the room alone. */
static void sfield__order_rooms(const sfield__point *p, const float *x, uint32_t count)
{
    const sfield_scene *s = p->s;
    sfield__ray *ray = p->ray;
    uint32_t i, room, light;
    for (i = 0; i < s->held_count; i++) {
        const struct sfield__tenant *held = &s->held[i];
        for (room = 0; room < count && (ray[room].light >= 0 || ray[room].item != held->item);) room++;
        for (light = 0; light < count && ray[light].light != (int)held->light;) light++;
        if (room == count || light == count) continue;
        if (sfield__is_in_hull(&s->item[held->item], x, s->simd)) {
            if (room < light) sfield__take_behind(s, ray, room, light);
        } else if (light < room) {
            const sfield__ray moved = ray[light];
            memmove(ray + light, ray + light + 1, (room - light) * sizeof *ray);
            ray[room] = moved;
        }
    }
}

/* Returns whether points have a self-visibility and lie on an object that is a room for some light. */
static int sfield__has_home(const sfield_scene *s, const sfield_points *set)
{
    return set->entity && set->self && s->item[set->entity - 1].holds;
}
