/* ---- kernels: which neighbours show the same surface ---- */

/* Positions and normals of as many neighbours in a row as there are lanes. */
typedef struct gifilt__shapes { gifilt__lanes3 position, normal; } gifilt__shapes;

/* Loads shapes from planes that are s floats apart. */
static inline GIFILT__IN_KERNEL gifilt__shapes gifilt__shapes_load(const float *p, size_t s)
{
    gifilt__shapes a;
    a.position = gifilt__lanes3_load(p, p + s, p + 2 * s);
    a.normal = gifilt__lanes3_load(p + 3 * s, p + 4 * s, p + 5 * s);
    return a;
}

/* Returns how much neighbours b count for a, from 0 to 1: 0 if the normals differ by more than the limit or b
   lies off the plane of a, and falling smoothly to these. */
static inline GIFILT__IN_KERNEL gifilt__lanes gifilt__alike(const gifilt__shapes *a, const gifilt__shapes *b,
                                                            const float limits[3])
{
    const gifilt__lanes zero = gifilt__lanes_all(0.0f), one = gifilt__lanes_all(1.0f);
    const gifilt__lanes3 d = gifilt__lanes3_sub(b->position, a->position);
    const gifilt__lanes d2 = gifilt__lanes3_dot(d, d), off = gifilt__lanes3_dot(a->normal, d);
    const gifilt__lanes width2 = gifilt__lanes_mul(gifilt__lanes_all(limits[2]), d2);
    const gifilt__lanes slope2 = gifilt__lanes_div(gifilt__lanes_mul(off, off),
                                                   gifilt__lanes_add(width2, gifilt__lanes_all(1e-12f)));
    gifilt__lanes facing = gifilt__lanes3_dot(a->normal, b->normal);
    facing = gifilt__lanes_sub(facing, gifilt__lanes_all(limits[0]));
    facing = gifilt__lanes_mul(facing, gifilt__lanes_all(limits[1]));
    facing = gifilt__lanes_min(gifilt__lanes_max(facing, zero), one);
    return gifilt__lanes_mul(facing, gifilt__lanes_max(gifilt__lanes_sub(one, slope2), zero));
}
