/* ---- cull: VPLs that no receiver of a block can see ---- */

/* Flags the VPLs that no pixel of a block can see, since all eight corners of the pixels' box lie behind the
   VPL (T56). There is a flag for each place in `order`. counts: adds the pairs that are culled, and all
   pairs. */
static void ism__cull(const ism__shade_work *w, uint32_t bx, uint32_t by, uint8_t *skip, double counts[2])
{
    const ism_maps *m = w->m;
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), p, n;
    uint32_t x, y, i, k;
    for (y = by; y < by + ISM__BLOCK && y < w->view->height; y++)
        for (x = bx; x < bx + ISM__BLOCK && x < w->view->width; x++)
            if (ism__receiver(w->view, (size_t)y * w->view->width + x, &p, &n)) {
                lo = ism__v3_min(lo, p);
                hi = ism__v3_max(hi, p);
            }
    for (i = 0; i < m->vpl_count; i++) {
        const ism_vpl *v = &m->vpls[w->order[i]];
        ism__v3 at = ism__v3_load(v->position),
                normal = ism__v3_load(v->exponent == 1.0f ? v->normal : v->axis);
        float most = -1e30f,
              size = ism__v3_length(ism__v3_sub(hi, lo)) + fabsf(at.x) + fabsf(at.y) + fabsf(at.z);
        for (k = 0; k < 8u; k++) {
            ism__v3 c = ism__v3_make(k & 1u ? hi.x : lo.x, k & 2u ? hi.y : lo.y, k & 4u ? hi.z : lo.z);
            float d = ism__v3_dot(normal, ism__v3_sub(c, at));
            most = d > most ? d : most;
        }
        /* Rounding must not cull a VPL that is seen: culling changes no bit of the picture. */
        skip[i] = !v->directional && most < -1e-5f * size;
        counts[0] += skip[i];
    }
    counts[1] += (double)m->vpl_count;
}
