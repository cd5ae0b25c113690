/* ---- kernels of query: which instances a sample's ray meets ---- */

/* Rays of samples: from points along directions up to `reach`. Points lie up to `slack` off, as far as
   rounding takes them on their way to an object's space. Directions are longer than 1 by more than rounding
   takes from distances, which so come out too short. */
typedef struct cohsm__rays { cohsm__lanes3 point, direction; cohsm__lanes reach, slack; } cohsm__rays;

static inline COHSM__IN_KERNEL cohsm__rays cohsm__load_rays(const cohsm_query *q, size_t first, size_t count)
{
    const size_t point = q->position_stride ? q->position_stride : 12;
    const size_t light = q->light_stride ? q->light_stride : 12;
    const size_t from = q->one_light ? 0 : first;
    cohsm__rays r;
    cohsm__lanes length;
    r.point = cohsm__load_strided((const char *)(const void *)q->positions + point * first, point, count);
    r.direction = cohsm__load_strided((const char *)q->lights + light * from, q->one_light ? 0 : light,
                                      count);
    if (q->light_kind == COHSM_LIGHT_POSITION) r.direction = cohsm__lanes3_sub(r.direction, r.point);
    length = cohsm__lanes_sqrt(cohsm__lanes3_dot(r.direction, r.direction));
    r.reach = length;
    r.direction = cohsm__lanes3_scale(r.direction, cohsm__lanes_div(cohsm__lanes_all(1.000001f), length));
    length = cohsm__lanes_add(cohsm__lanes_abs(r.point.x), cohsm__lanes_abs(r.point.y));
    length = cohsm__lanes_add(length, cohsm__lanes_abs(r.point.z));
    r.slack = cohsm__lanes_mul(length, cohsm__lanes_all(COHSM__SLACK));
    return r;
}

/* Returns the lanes whose segments miss a sphere: the nearest point of each lies outside. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__segments_miss(const cohsm__rays *r, cohsm__lanes along,
                                                                     cohsm__lanes square, cohsm__lanes radius)
{
    const cohsm__lanes t = cohsm__lanes_min(cohsm__lanes_max(along, cohsm__lanes_all(0.0f)), r->reach);
    const cohsm__lanes w = cohsm__lanes_mul(t, cohsm__lanes_sub(t, cohsm__lanes_add(along, along)));
    return cohsm__lanes_greater(cohsm__lanes_add(w, square), cohsm__lanes_mul(radius, radius));
}

/* Returns the lanes whose cones miss a sphere of radius r: all of the sphere lies behind the apex, or, with
   the centre at the distance `along` on the axis and at p from it, p cos a - along sin a > r. */
static inline COHSM__IN_KERNEL cohsm__lane_mask cohsm__cones_miss(const cohsm__sphere *s, cohsm__lanes along,
                                                                  cohsm__lanes square, cohsm__lanes slack)
{
    const cohsm__lanes radius = cohsm__lanes_add(cohsm__lanes_all(s->radius), slack);
    const cohsm__lanes behind = cohsm__lanes_add(along, radius);
    cohsm__lanes limit = cohsm__lanes_add(cohsm__lanes_all(s->cone_radius), cohsm__lanes_add(slack, slack));
    limit = cohsm__lanes_muladd(along, cohsm__lanes_all(s->slope), limit);
    square = cohsm__lanes_sub(square, cohsm__lanes_mul(along, along));
    return cohsm__mask_or(cohsm__lanes_greater(cohsm__lanes_all(0.0f), behind),
                          cohsm__lanes_greater(square, cohsm__lanes_mul(limit, limit)));
}

/* Sets a bit for each sample from number `first` on and each sphere if the sample's ray may meet the sphere.
   Comparisons with what is not a number are false, so that such a sample asks. */
COHSM__KERNEL static void cohsm__meet_spheres(const cohsm_query *q, size_t first, size_t count,
                                              cohsm__bunch *b)
{
    size_t k;
    uint32_t j;
    for (k = 0; k < count; k += COHSM__LANE_COUNT) {
        const cohsm__rays r = cohsm__load_rays(q, first + k, count - k);
        for (j = 0; j < b->count; j++) {
            const cohsm__sphere *s = &b->sphere[j];
            const cohsm__lanes3 v = cohsm__lanes3_sub(cohsm__lanes3_all(s->x, s->y, s->z), r.point);
            const cohsm__lanes square = cohsm__lanes3_dot(v, v), along = cohsm__lanes3_dot(v, r.direction);
            cohsm__lane_mask miss;
            if (q->light_kind == COHSM_LIGHT_POSITION)
                miss = cohsm__segments_miss(&r, along, square,
                                            cohsm__lanes_add(cohsm__lanes_all(s->radius), r.slack));
            else miss = cohsm__cones_miss(s, along, square, r.slack);
            b->asked[j][k / 32] |= (cohsm__mask_bits(miss) ^ COHSM__ALL_LANES) << k % 32;
        }
    }
}
