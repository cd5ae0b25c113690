/* ---- kernels: what receivers see of a triangle (paper 5.1, 5.2) ---- */

#if ISM__LANE_COUNT == 8
/* See ism__triangle_kernel. The solid angle of a triangle that is small for its distance is taken for area
   cos / d^2, whose relative error is at most area / d^2. */
ISM__KERNEL static float ism__mean_solid_angle(const ism__v3 p[3], ism__v3 normal2,
                                               const float views[3][ISM__VIEWS], uint32_t count)
{
    const ism__lanes area2 = ism__lanes_all(ism__v3_length(normal2));
    const ism__lanes3 n = ism__lanes3_all(normal2.x, normal2.y, normal2.z);
    const ism__lanes3 a = ism__lanes3_sub(ism__lanes3_all(p[0].x, p[0].y, p[0].z),
                                          ism__lanes3_load(views[0], views[1], views[2]));
    const ism__lanes d2 = ism__lanes3_dot(a, a);
    const ism__lane_mask distant = ism__lanes_greater(ism__lanes_mul(ism__lanes_all(0.01f), d2), area2);
    const ism__lanes solid = ism__lanes_div(
        ism__lanes_mul(ism__lanes_all(0.5f), ism__lanes_abs(ism__lanes3_dot(n, a))),
        ism__lanes_mul(d2, ism__lanes_sqrt(d2)));
    const uint32_t far_bits = ism__mask_bits(distant);
    float solids[ISM__VIEWS], sum = 0.0f;
    uint32_t k, i;
    ism__lanes_store(solids, solid);
    for (k = 0; k < count; k++) {
        float corners[9];
        for (i = 0; i < 3u && !(far_bits >> k & 1u); i++) {
            corners[3u * i] = p[i].x - views[0][k];
            corners[3u * i + 1u] = p[i].y - views[1][k];
            corners[3u * i + 2u] = p[i].z - views[2][k];
        }
        sum += far_bits >> k & 1u ? solids[k] : ism__solid_angle(corners, corners + 3, corners + 6);
    }
    return sum / (float)count;
}
#endif
