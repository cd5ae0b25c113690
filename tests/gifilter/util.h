/* util.h - what the tests of gifilter.h share: shorthands, and a system that counts. */
#ifndef GIFILTER_UTIL_H
#define GIFILTER_UTIL_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ledger.h"

#if defined(__GNUC__)
#define UNUSED_OK __attribute__((unused)) static
#else
#define UNUSED_OK static
#endif

UNUSED_OK gifilt_system ledger_system(ledger *l)
{
    gifilt_system s;
    memset(l, 0, sizeof *l);
    memset(&s, 0, sizeof s);
    s.allocator.alloc_fn = ledger_alloc;
    s.allocator.free_fn = ledger_free;
    s.allocator.user = l;
    return s;
}

UNUSED_OK void set3(float *p, double x, double y, double z)
{
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
}

UNUSED_OK gifilt_points points_of(const float *positions, const float *normals, size_t count)
{
    gifilt_points p;
    memset(&p, 0, sizeof p);
    p.count = count;
    p.positions = positions;
    p.normals = normals;
    return p;
}

UNUSED_OK gifilt_desc desc_of(uint32_t width, uint32_t height, const gifilt_system *system)
{
    gifilt_desc d;
    memset(&d, 0, sizeof d);
    if (system) d.system = *system;
    d.width = width;
    d.height = height;
    return d;
}

/* system may be NULL. */
UNUSED_OK gifilt_result create(uint32_t width, uint32_t height, const gifilt_system *system, gifilt_filter **out)
{
    gifilt_desc d = desc_of(width, height, system);
    return gifilt_create(&d, out);
}

#endif
