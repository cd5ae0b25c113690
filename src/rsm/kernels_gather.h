/* ---- kernels of gather ---- */

/* As many pixel lights as there are lanes, or one light in every lane; and receivers in the same way. */
typedef struct rsm__lights { rsm__lanes3 position, normal, flux; rsm__lanes rounding, bound; } rsm__lights;
typedef struct rsm__receivers { rsm__lanes3 position, normal; rsm__lanes rounding; } rsm__receivers;

static inline RSM__IN_KERNEL rsm__lights rsm__lights_load(const rsm__block *k, size_t i)
{
    rsm__lights lights;
    lights.position = rsm__lanes3_load(k->px + i, k->py + i, k->pz + i);
    lights.normal = rsm__lanes3_load(k->nx + i, k->ny + i, k->nz + i);
    lights.flux = rsm__lanes3_load(k->r + i, k->g + i, k->b + i);
    lights.rounding = rsm__lanes_load(k->rounding + i);
    lights.bound = rsm__lanes_load(k->cap + i);
    return lights;
}

/* Returns the light of one lane of a block, in all lanes. */
static inline RSM__IN_KERNEL rsm__lights rsm__light_in_all(const rsm__block *k, size_t i)
{
    rsm__lights lights;
    lights.position = rsm__lanes3_all(k->px[i], k->py[i], k->pz[i]);
    lights.normal = rsm__lanes3_all(k->nx[i], k->ny[i], k->nz[i]);
    lights.flux = rsm__lanes3_all(k->r[i], k->g[i], k->b[i]);
    lights.rounding = rsm__lanes_all(k->rounding[i]);
    lights.bound = rsm__lanes_all(k->cap[i]);
    return lights;
}

/* The factor cos cos / d^2 of equation (1) for lights and receivers, computed as two cosines times d over
   d^4. The caller multiplies it by the flux, and by the 1 / pi that the equation lacks. */
typedef struct rsm__forms {
    rsm__lanes whole, bounded;     /* the factor without the light's bound and with it */
    rsm__lanes d2, inverse;        /* the squared distance, and one over it */
} rsm__forms;

/* Computes the factors. Cosines times d must exceed the rounding of both positions, so that a plane does not
   light itself (T40). */
static inline RSM__IN_KERNEL rsm__forms rsm__forms_make(const rsm__lights *lights,
                                                        const rsm__receivers *receivers)
{
    const rsm__lanes zero = rsm__lanes_all(0.0f),
        rounding = rsm__lanes_max(lights->rounding, receivers->rounding);
    const rsm__lanes3 d = rsm__lanes3_sub(lights->position, receivers->position);
    rsm__lanes at_receiver = rsm__lanes3_dot(receivers->normal, d);
    rsm__lanes at_light = rsm__lanes_negate(rsm__lanes3_dot(lights->normal, d));
    rsm__forms f;
    f.d2 = rsm__lanes3_dot(d, d);
    at_receiver = rsm__lanes_max(rsm__lanes_sub(at_receiver, rounding), zero);
    at_light = rsm__lanes_max(rsm__lanes_sub(at_light, rounding), zero);
    f.inverse = rsm__lanes_div(rsm__lanes_all(1.0f), rsm__lanes_max(f.d2, rsm__lanes_all(1e-18f)));
    f.whole = rsm__lanes_mul(rsm__lanes_mul(at_receiver, f.inverse), rsm__lanes_mul(at_light, f.inverse));
    f.bounded = rsm__lanes_min(f.whole, lights->bound);
    return f;
}

/* Sums of each lane, which are added up in one order at the end, so that all instruction sets give the same
   bits. */
typedef struct rsm__lane_sums { rsm__lanes red, green, blue, full, lost, nearby; } rsm__lane_sums;

static inline RSM__IN_KERNEL rsm__lane_sums rsm__sums_zero(void)
{
    rsm__lane_sums s;
    s.red = s.green = s.blue = s.full = s.lost = s.nearby = rsm__lanes_all(0.0f);
    return s;
}

/* Adds lights by their factors. */
static inline RSM__IN_KERNEL rsm__lane_sums rsm__sums_add(rsm__lane_sums s, const rsm__lights *lights,
                                                          const rsm__forms *f, int lossy)
{
    const rsm__lanes3 flux = lights->flux;
    s.red = rsm__lanes_add(s.red, rsm__lanes_mul(flux.x, f->bounded));
    s.green = rsm__lanes_add(s.green, rsm__lanes_mul(flux.y, f->bounded));
    s.blue = rsm__lanes_add(s.blue, rsm__lanes_mul(flux.z, f->bounded));
    if (lossy) {
        const rsm__lanes all = rsm__lanes_add(rsm__lanes_add(flux.x, flux.y), flux.z);
        s.full = rsm__lanes_add(s.full, rsm__lanes_mul(all, f->whole));
        s.lost = rsm__lanes_add(s.lost, rsm__lanes_mul(all, rsm__lanes_sub(f->whole, f->bounded)));
    }
    return s;
}

#if RSM__LANE_COUNT == 8                          /* in AVX-512 too, so that sums have the same bits */
/* Adds up the lanes, and adds them to a receiver's sum. */
static inline RSM__IN_KERNEL void rsm__sums_reduce(const rsm__lane_sums *s, int lossy, int nearest,
                                                 rsm__sum *sum)
{
    float red[8], green[8], blue[8];
    float full[8], lost[8], nearby[8];
    int l;
    rsm__lanes_store(red, s->red);
    rsm__lanes_store(green, s->green);
    rsm__lanes_store(blue, s->blue);
    rsm__lanes_store(full, s->full);
    rsm__lanes_store(lost, s->lost);
    rsm__lanes_store(nearby, s->nearby);
    for (l = 0; l < 8; l++) {
        sum->rgb[0] += red[l];
        sum->rgb[1] += green[l];
        sum->rgb[2] += blue[l];
        if (lossy) {
            sum->full += full[l];
            sum->lost += lost[l];
        }
        if (nearest) sum->nearby = nearby[l] > sum->nearby ? nearby[l] : sum->nearby;
    }
}

/* Adds the light of pixel lights, block by block, to one receiver's sum. lossy also sums what bounds take
   off; nearest finds the nearest light. */
static inline RSM__IN_KERNEL void rsm__sum_blocks(const rsm__block *k, size_t count, const float x[7],
                                                int lossy, int nearest, rsm__sum *sum)
{
    rsm__receivers receiver;
    rsm__lane_sums s = rsm__sums_zero();
    size_t i, end;
    receiver.position = rsm__lanes3_all(x[0], x[1], x[2]);
    receiver.normal = rsm__lanes3_all(x[3], x[4], x[5]);
    receiver.rounding = rsm__lanes_all(x[6]);
    for (; count > 0; count -= end, k++) {
        end = count < RSM__BLOCK ? count : (size_t)RSM__BLOCK;
        for (i = 0; i < end; i += 8) {
            const rsm__lights lights = rsm__lights_load(k, i);
            const rsm__forms f = rsm__forms_make(&lights, &receiver);
            s = rsm__sums_add(s, &lights, &f, lossy);
            if (nearest) {                       /* lights that are edge-on do not count */
                rsm__lane_mask seen = rsm__lanes_greater(rsm__lanes_mul(f.whole, f.d2),
                                                         rsm__lanes_all(1e-3f));
                s.nearby = rsm__lanes_max(rsm__lanes_keep(seen, f.inverse), s.nearby);
            }
        }
    }
    rsm__sums_reduce(&s, lossy, nearest, sum);
}

RSM__KERNEL static void rsm__sum_lights(const rsm__block *k, size_t count, const float x[7], rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 0, 0, sum);
}

RSM__KERNEL static void rsm__sum_lights_lossy(const rsm__block *k, size_t count, const float x[7],
                                              rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 1, 0, sum);
}

RSM__KERNEL static void rsm__sum_lights_near(const rsm__block *k, size_t count, const float x[7],
                                             rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 0, 1, sum);
}

RSM__KERNEL static void rsm__sum_lights_near_lossy(const rsm__block *k, size_t count, const float x[7],
                                                   rsm__sum *sum)
{
    rsm__sum_blocks(k, count, x, 1, 1, sum);
}
#endif

/* Adds a few lights, one after the other, to the sums of as many receivers as there are lanes. */
static inline RSM__IN_KERNEL void rsm__sum_on_receivers(const rsm__block *k, size_t count, int lossy,
                                                        rsm__receiver_lanes *p)
{
    rsm__receivers receivers;
    rsm__lane_sums s = rsm__sums_zero();
    size_t i;
    receivers.position = rsm__lanes3_load(p->x[0], p->x[1], p->x[2]);
    receivers.normal = rsm__lanes3_load(p->x[3], p->x[4], p->x[5]);
    receivers.rounding = rsm__lanes_load(p->x[6]);
    for (i = 0; i < count; i++) {
        const rsm__lights light = rsm__light_in_all(k + i / RSM__BLOCK, i % RSM__BLOCK);
        const rsm__forms f = rsm__forms_make(&light, &receivers);
        s = rsm__sums_add(s, &light, &f, lossy);
    }
    rsm__lanes_store(p->sums[0], rsm__lanes_add(rsm__lanes_load(p->sums[0]), s.red));
    rsm__lanes_store(p->sums[1], rsm__lanes_add(rsm__lanes_load(p->sums[1]), s.green));
    rsm__lanes_store(p->sums[2], rsm__lanes_add(rsm__lanes_load(p->sums[2]), s.blue));
    rsm__lanes_store(p->sums[3], rsm__lanes_add(rsm__lanes_load(p->sums[3]), s.full));
    rsm__lanes_store(p->sums[4], rsm__lanes_add(rsm__lanes_load(p->sums[4]), s.lost));
}

RSM__KERNEL static void rsm__light_receivers(const rsm__block *k, size_t count, rsm__receiver_lanes *p)
{
    rsm__sum_on_receivers(k, count, 0, p);
}

RSM__KERNEL static void rsm__light_receivers_lossy(const rsm__block *k, size_t count, rsm__receiver_lanes *p)
{
    rsm__sum_on_receivers(k, count, 1, p);
}
