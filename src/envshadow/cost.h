/* ---- cost ---- */

ENVSH_DEF int envsh_cost_fit(uint32_t light_count, const uint32_t *clusters, const double *ms, size_t count,
                             envsh_cost *out)
{
    double aa = 0.0;
    double ab = 0.0;
    double bb = 0.0;
    double at = 0.0;
    double bt = 0.0;
    double det;
    size_t i;
    if (!clusters || !ms || !out || !light_count) return 0;
    for (i = 0; i < count; i++) {
        double passes, slots;
        if (!clusters[i] || !(ms[i] >= 0.0 && ms[i] < 1e12)) return 0;
        passes = (double)((light_count - 1) / clusters[i] + 1);
        slots = passes * (double)clusters[i];
        /* Least squares of relative errors: each row is divided by its time. */
        passes /= ms[i] + 1e-9;
        slots /= ms[i] + 1e-9;
        aa += passes * passes;
        ab += passes * slots;
        bb += slots * slots;
        at += passes * ms[i] / (ms[i] + 1e-9);
        bt += slots * ms[i] / (ms[i] + 1e-9);
    }
    det = aa * bb - ab * ab;
    if (!(det > 1e-9 * aa * bb)) return 0;
    out->pass = (at * bb - bt * ab) / det;
    out->slot = (bt * aa - at * ab) / det;
    if (out->pass < 0.0) {                  /* by noise; then the other cost explains all of the times */
        out->pass = 0.0;
        out->slot = bt / bb;
    } else if (out->slot < 0.0) {
        out->slot = 0.0;
        out->pass = at / aa;
    }
    return 1;
}

ENVSH_DEF uint32_t envsh_cost_cluster(const envsh_cost *cost, uint32_t light_count, uint32_t most)
{
    uint32_t best = 1, c;
    double least = -1.0;
    if (!cost || !light_count || !most) return 1;
    most = most < light_count ? most : light_count;
    for (c = 1; c <= most; c++) {
        double passes = (double)((light_count - 1) / c + 1);
        double ms = passes * (cost->pass + (double)c * cost->slot);
        if (least >= 0.0 && ms >= least) continue;
        least = ms;
        best = c;
    }
    return best;
}
