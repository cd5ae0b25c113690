/* ---- near points: in place of the VPLs that are near a receiver ---- */

/* The light of all VPLs is right on the mean, but not beside one of them: in a corner a single VPL makes a
   spot of light that a whole surface should have spread. There near points take over, samples of a second,
   finer choice, each as far as its reach. The reach depends on the place alone, so that the sum over VPLs
   gives way to the sum over near points without a loss. */
typedef struct ism__near_work {
    ism_maps        *m;
    const ism__job  *job;
    double           total;
    const uint64_t  *sorted;        /* the VPLs of surfaces without lobes, in their order along `axis`; the
                                       low half of each is the VPL's number */
    uint32_t         sorted_count;
    uint32_t         drawn;         /* samples of the second choice */
    uint32_t         axis;          /* along which the VPLs' box is longest */
    ism_near_point  *out;           /* in the order in which they are drawn; vpl < 0: there is no point */
} ism__near_work;

/* Returns whether near points may take the place of a VPL: a diffuse one on a surface. */
static int ism__has_near(const ism_vpl *v) { return !v->directional && v->exponent == 1.0f; }

/* Returns the VPL with this place in the sorted list. */
static const ism_vpl *ism__sorted_vpl(const ism__near_work *w, uint32_t i)
{
    return &w->m->vpls[(uint32_t)w->sorted[i]];
}

/* Returns how far a near point at p reaches, and writes the number of the nearest VPL, in whose choice alone
   VPLs with other normals count as farther. The sorted VPLs are walked through both ways from p, until their
   distance along the axis alone is too large. */
static float ism__reach_of(const ism__near_work *w, ism__v3 p, ism__v3 n, uint32_t *nearest)
{
    float near2[ISM__NEAR_RANK], best = 1e30f;
    uint32_t lo = 0, hi = w->sorted_count, left;
    uint32_t right, k;
    float x = w->axis == 0 ? p.x : w->axis == 1u ? p.y : p.z;
    for (k = 0; k < ISM__NEAR_RANK; k++) near2[k] = 1e30f;
    while (lo < hi) {
        uint32_t mid = lo + (hi - lo) / 2u;
        if (ism__sorted_vpl(w, mid)->position[w->axis] < x) lo = mid + 1u;
        else hi = mid;
    }
    for (left = right = lo; left > 0 || right < w->sorted_count;) {
        float before = left > 0 ? x - ism__sorted_vpl(w, left - 1u)->position[w->axis] : 1e30f, d2, cosine;
        float behind = right < w->sorted_count ? ism__sorted_vpl(w, right)->position[w->axis] - x : 1e30f;
        int leftwards = right == w->sorted_count || (left > 0 && before < behind);
        float step = leftwards ? before : behind;
        uint32_t i = (uint32_t)w->sorted[leftwards ? --left : right++];
        const ism_vpl *v = &w->m->vpls[i];
        ism__v3 d = ism__v3_sub(ism__v3_load(v->position), p);
        if (step * step > near2[ISM__NEAR_RANK - 1u] && step * step > best) break;
        d2 = ism__v3_dot(d, d);
        for (k = ISM__NEAR_RANK - 1u; k > 0 && near2[k - 1u] > d2; k--) near2[k] = near2[k - 1u];
        if (near2[k] > d2) near2[k] = d2;
        cosine = ism__v3_dot(n, ism__v3_load(v->normal));
        d2 *= cosine > 0.5f ? 1.0f : cosine > 0.0f ? 4.0f : 16.0f;
        if (d2 < best) {
            best = d2;
            *nearest = i;
        }
    }
    return 2.0f * sqrtf(near2[ISM__NEAR_RANK - 1u]);
}

static void ism__reach_task(void *context, size_t index)
{
    const ism__near_work *w = (const ism__near_work *)context;
    ism_vpl *v = &w->m->vpls[index];
    uint32_t nearest = 0;
    if (ism__has_near(v))
        v->reach = ism__reach_of(w, ism__v3_load(v->position), ism__v3_load(v->normal), &nearest);
}

/* Draws 64 near points. A point's square has the texel's area, or that which the point stands for if it is
   larger, but no more than an eighth of the disc within its reach. Without areas, the density of VPLs around
   the point tells the area. */
static void ism__near_task(void *context, size_t index)
{
    const ism__near_work *w = (const ism__near_work *)context;
    uint32_t i, k;
    for (i = (uint32_t)index * ISM__NEAR_BLOCK; i < w->drawn && i < (uint32_t)(index + 1u) * ISM__NEAR_BLOCK;
         i++) {
        ism_near_point *to = &w->out[i];
        const ism_source *s;
        uint32_t nearest = 0;
        float area, most;
        ism_vpl v;
        to->vpl = -1.0f;
        if (!ism__draw_vpl(w->m, w->job, w->total, i, w->drawn, 13u, &v) || !ism__has_near(&v)) continue;
        s = &w->job->frame->sources[v.source];
        for (k = 0; k < 3u; k++) {
            to->position[k] = v.position[k];
            to->normal[k] = v.normal[k];
            to->flux[k] = v.flux[k];
        }
        to->reach = ism__reach_of(w, ism__v3_load(v.position), ism__v3_load(v.normal), &nearest);
        area = s->areas ? *ism__at(s->areas, s->area_stride ? s->area_stride : 4u, v.texel)
                        : ISM__PI * 0.25f * to->reach * to->reach /
                              (float)(ISM__NEAR_RANK * (uint32_t)w->m->desc.near_point_count);
        if (!(area >= v.area) || !ism__finite(area)) area = v.area;
        most = 0.125f * ISM__PI * to->reach * to->reach;
        to->edge = sqrtf(area < most ? area : most);
        to->vpl = (float)nearest;
    }
}

/* Returns ten bits spread over thirty, each at every third place. */
static uint32_t ism__spread_bits(uint32_t x)
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/* Writes a key for each point that was drawn, and returns how many there are. A key's upper half is the place
   on Morton's curve through the box of all points, its lower half is the point's number. */
static uint32_t ism__near_keys(const ism__near_work *w, uint64_t *keys)
{
    ism__v3 lo = ism__v3_make(1e30f, 1e30f, 1e30f), hi = ism__v3_make(-1e30f, -1e30f, -1e30f), size;
    uint32_t i, count = 0;
    float most;
    for (i = 0; i < w->drawn; i++)
        if (w->out[i].vpl >= 0.0f) {
            lo = ism__v3_min(lo, ism__v3_load(w->out[i].position));
            hi = ism__v3_max(hi, ism__v3_load(w->out[i].position));
        }
    size = ism__v3_sub(hi, lo);
    most = size.x > size.y ? size.x : size.y;
    most = most > size.z ? most : size.z;
    for (i = 0; i < w->drawn; i++)
        if (w->out[i].vpl >= 0.0f) {
            ism__v3 p = ism__v3_sub(ism__v3_load(w->out[i].position), lo);
            uint32_t key;
            if (most > 0.0f) p = ism__v3_scale(p, 1.0f / most);
            p = ism__v3_max(p, ism__v3_make(0.0f, 0.0f, 0.0f));     /* in a box wider than a float p may be no
                                                                       number: it becomes 0 */
            key = ism__spread_bits(ism__texel_of(p.x, 1024u)) |
                  ism__spread_bits(ism__texel_of(p.y, 1024u)) << 1 |
                  ism__spread_bits(ism__texel_of(p.z, 1024u)) << 2;
            keys[count++] = (uint64_t)key << 32 | i;
        }
    return count;
}

/* Sorts keys by their upper halves, in four passes of 8 bits; the result lies where the keys were. */
static void ism__sort_keys(uint64_t *keys, uint64_t *other, uint32_t count)
{
    uint32_t shift, i;
    for (shift = 32u; shift < 64u; shift += 8u) {
        uint32_t starts[257] = { 0 };
        uint64_t *swap = keys;
        for (i = 0; i < count; i++) starts[(keys[i] >> shift & 255u) + 1u]++;
        for (i = 0; i < 256u; i++) starts[i + 1u] += starts[i];
        for (i = 0; i < count; i++) other[starts[keys[i] >> shift & 255u]++] = keys[i];
        keys = other;
        other = swap;
    }
}

/* Writes the centre and radius of a sphere beyond which no point of a block reaches. */
static void ism__near_sphere(const ism_near_point *points, uint32_t count, float sphere[4])
{
    ism__v3 lo = ism__v3_load(points->position), hi = lo, c;
    float most = 0.0f;
    uint32_t i;
    for (i = 1; i < count; i++) {
        lo = ism__v3_min(lo, ism__v3_load(points[i].position));
        hi = ism__v3_max(hi, ism__v3_load(points[i].position));
    }
    c = ism__v3_scale(ism__v3_add(lo, hi), 0.5f);
    for (i = 0; i < count; i++) {
        float d = ism__v3_length(ism__v3_sub(ism__v3_load(points[i].position), c)) + points[i].reach;
        most = d > most ? d : most;
    }
    ism__v3_store(sphere, c);
    sphere[3] = most;
}

static int ism__grow_near(ism_maps *m)
{
    size_t n = m->desc.vpl_count, drawn = n * (size_t)m->desc.near_point_count;
    return !drawn ||
           (ism__grow(m, &m->near_points, drawn, sizeof(ism_near_point)) &&
            ism__grow(m, &m->near_drawn, drawn, sizeof(ism_near_point)) &&
            ism__grow(m, &m->near_keys, 2u * drawn, sizeof(uint64_t)) &&
            ism__grow(m, &m->near_blocks, drawn / ISM__NEAR_BLOCK + 1u, 4u * sizeof(float)));
}

/* Sorts the VPLs that near points may stand for along the longest side of their box. They lie where the
   points' keys are written later. */
static void ism__sort_by_x(ism__near_work *w, uint64_t *keys)
{
    const ism_maps *m = w->m;
    float lo[3] = { 1e30f, 1e30f, 1e30f }, hi[3] = { -1e30f, -1e30f, -1e30f };
    uint32_t i, k, bits;
    for (i = 0; i < m->vpl_count; i++)
        for (k = 0; k < 3u && ism__has_near(&m->vpls[i]); k++) {
            lo[k] = m->vpls[i].position[k] < lo[k] ? m->vpls[i].position[k] : lo[k];
            hi[k] = m->vpls[i].position[k] > hi[k] ? m->vpls[i].position[k] : hi[k];
        }
    for (k = 1; k < 3u; k++)
        if (hi[k] - lo[k] > hi[w->axis] - lo[w->axis]) w->axis = k;
    for (i = 0; i < m->vpl_count; i++)
        if (ism__has_near(&m->vpls[i])) {
            bits = ism__to_bits(m->vpls[i].position[w->axis] + 0.0f);       /* + 0 turns -0 into 0 */
            /* As unsigned numbers, these bits have the order of the floats. */
            bits = bits >> 31 ? ~bits : bits | 0x80000000u;
            keys[w->sorted_count++] = (uint64_t)bits << 32 | i;
        }
    ism__sort_keys(keys, keys + w->drawn, w->sorted_count);
    w->sorted = keys;
}

static ism_result ism__draw_near(ism_maps *m, const ism__job *job, double total, float from, float to)
{
    uint32_t n = m->vpl_count, i, drawn = m->desc.vpl_count * (uint32_t)m->desc.near_point_count;
    ism__near_work w = { m, job, total, NULL, 0, drawn, 0, NULL };
    ism_near_point *points = (ism_near_point *)m->near_points.data;
    uint64_t *keys = (uint64_t *)m->near_keys.data;
    if (!drawn || !(total > 0.0)) return ISM_OK;
    ism__sort_by_x(&w, keys);
    if (w.sorted_count <= ISM__NEAR_RANK) return ISM_OK;
    w.out = (ism_near_point *)m->near_drawn.data;
    if (!ism__run(m, &job->part, from, 0.5f * (from + to), n, ism__reach_task, &w) ||
        !ism__run(m, &job->part, 0.5f * (from + to), to, (drawn + ISM__NEAR_BLOCK - 1u) / ISM__NEAR_BLOCK,
                  ism__near_task, &w))
        return m->chosen = 0, ISM_ERR_CANCELLED;
    m->near_count = m->stats.near_points = ism__near_keys(&w, keys);
    ism__sort_keys(keys, keys + drawn, m->near_count);
    for (i = 0; i < m->near_count; i++) points[i] = w.out[(uint32_t)keys[i]];
    for (i = 0; i < m->near_count; i += ISM__NEAR_BLOCK)
        ism__near_sphere(points + i,
                         m->near_count - i < ISM__NEAR_BLOCK ? m->near_count - i : ISM__NEAR_BLOCK,
                         (float *)m->near_blocks.data + i / ISM__NEAR_BLOCK * 4u);
    return ISM_OK;
}
