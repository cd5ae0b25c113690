/* ---- sun ---- */

/* Finds the sun: the connected spot about the brightest texel in which luminance is above a tenth of the
   greatest. It must be smaller than 0.03 sr (11 degrees across) and have a light's share of the energy.
   Writes its texels to the queue, which has room for all texels, and returns how many they are; 0 if there is
   no sun. */
static uint32_t envlt__find_sun(const envlt__grid *g, uint32_t k, uint32_t *queue, uint8_t *seen)
{
    uint32_t head = 0, tail = 0, next[4], i;
    size_t t, top = 0;
    double energy = 0.0, omega = 0.0;
    for (t = 1; t < g->count; t++)
        if (g->lum[t] > g->lum[top]) top = t;
    if (!(g->lum[top] > 0.0f)) return 0;
    memset(seen, 0, g->count);
    queue[tail++] = (uint32_t)top;
    seen[top] = 1;
    while (head < tail && omega < 0.03) {
        t = queue[head++];
        energy += envlt__texel_weight(g, t);
        omega += (double)g->omega[t];
        envlt__neighbours(g, (uint32_t)t, next);
        for (i = 0; i < 4; i++)
            if (!seen[next[i]] && g->lum[next[i]] > 0.1f * g->lum[top]) {
                seen[next[i]] = 1;
                queue[tail++] = next[i];
            }
    }
    return head == tail && omega < 0.03 && energy * k >= g->total && k > 1 ? tail : 0;
}

/* Returns how many texels are lit. If label is not NULL, texels with label 0, those of the sun, do not count.
   */
static size_t envlt__count_lit(const envlt__grid *g, const uint32_t *label)
{
    size_t t, lit = 0;
    for (t = 0; t < g->count; t++) lit += g->lum[t] > 0.0f && !(label && label[t] == 0);
    return lit;
}
