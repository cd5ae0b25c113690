/* builtin_cloth.c - hanging cloth that moves in the wind, by formula: any time can be asked for. */
#include "internal.h"

/* Each thread down the cloth keeps its length: it is walked from its top, leaning with the wind by an angle that
   travels down it as a wave. Folds start at the top edge and widen. */
void ex_build_drape(ex_builder *b, const ex_drape *d, float time, uint32_t across, uint32_t along, uint32_t material)
{
    v3 edge = v3_sub(d->to, d->from), side = v3_unit(edge), out = v3_cross(side, v3_make(0, 1, 0));
    uint32_t first = b->mesh.vertex_count;
    float step = d->length / (float)along;
    for (uint32_t i = 0; i <= across; i++) {
        float u = (float)i / (float)across, fold = 2 * EX_PI * d->folds * u + d->phase;
        v3 p = v3_mad(d->from, edge, u);
        for (uint32_t j = 0; j <= along; j++) {
            float s = (float)j / (float)along, t = time, w = d->wind * (0.15f + 0.85f * s);
            float gust = 0.6f + 0.4f * sinf(0.7f * t + d->phase);
            float lean = w * (0.35f * gust + 0.55f * sinf(5.2f * s - 2.9f * t + 1.6f * u + d->phase) * gust +
                              0.22f * sinf(9.5f * s - 5.1f * t - 3.1f * u + 2 * d->phase));
            float sway = 0.25f * w * sinf(2.2f * s - 1.3f * t + d->phase);
            float depth = d->fold_depth * (0.5f + s) * sinf(fold + 0.7f * sinf(1.7f * t + 3 * s) * s);
            ex_build_vertex(b, v3_mad(p, out, depth), v3_make(0, 0, 0));
            p = v3_mad(p, v3_make(0, -1, 0), step * cosf(lean) * cosf(sway));
            p = v3_mad(v3_mad(p, out, step * sinf(lean)), side, step * sinf(sway) * cosf(lean));
        }
    }
    for (uint32_t i = 0; i < across; i++)
        for (uint32_t j = 0; j < along; j++) {
            uint32_t a = first + i * (along + 1) + j, c = a + along + 1;
            ex_build_triangle(b, a, a + 1, c + 1, material);
            ex_build_triangle(b, a, c + 1, c, material);
        }
}
