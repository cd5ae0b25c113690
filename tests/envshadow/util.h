/* util.h - what the tests of envshadow.h share: meshes, and what those of envlights.h have. Include envshadow.h and
   envlights.h before. */
#ifndef ENVSH_UTIL_H
#define ENVSH_UTIL_H

#include "../envlights/util.h"
#include "sky_lights.h"

UNUSED_OK envsh_allocator shadow_allocator(ledger *l)
{
    envsh_allocator a;
    a.alloc_fn = ledger_alloc;
    a.free_fn = ledger_free;
    a.user = l;
    return a;
}

/* ---- meshes ---- */

typedef struct soup { float p[3 * 3 * 4096]; size_t vertices; } soup;

UNUSED_OK void soup_quad(soup *s, const double *a, const double *u, const double *v)
{
    static const int corner[6][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 0 }, { 1, 1 }, { 0, 1 } };
    int i, c;
    for (i = 0; i < 6; i++, s->vertices++)
        for (c = 0; c < 3; c++)
            s->p[3 * s->vertices + (size_t)c] = (float)(a[c] + corner[i][0] * u[c] + corner[i][1] * v[c]);
}

/* The six sides of an axis-aligned box. */
UNUSED_OK void soup_box(soup *s, const double *low, const double *high)
{
    int axis, side, c;
    for (axis = 0; axis < 3; axis++)
        for (side = 0; side < 2; side++) {
            double a[3], u[3] = { 0, 0, 0 }, v[3] = { 0, 0, 0 };
            for (c = 0; c < 3; c++) a[c] = low[c];
            if (side) a[axis] = high[axis];
            u[(axis + 1) % 3] = high[(axis + 1) % 3] - low[(axis + 1) % 3];
            v[(axis + 2) % 3] = high[(axis + 2) % 3] - low[(axis + 2) % 3];
            soup_quad(s, a, u, v);
        }
}

UNUSED_OK envsh_mesh soup_mesh(const soup *s)
{
    envsh_mesh m;
    memset(&m, 0, sizeof m);
    m.positions = s->p;
    m.vertex_count = s->vertices;
    return m;
}

#endif
