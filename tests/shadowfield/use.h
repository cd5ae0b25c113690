/* use.h - calls every function on a field that was opened from bytes nobody vouches for: results must be finite
   and in range. Include shadowfield.h before. */
#ifndef SFIELD_USE_H
#define SFIELD_USE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

static inline int use_all_finite(const float *v, size_t n)
{
    size_t i;
    for (i = 0; i < n; i++)
        if (!isfinite(v[i])) return 0;
    return 1;
}

/* The field as the only entity of a scene, or as its points' self-visibility. */
static inline int use_in_a_scene(const sfield_field *f, const sfield_info *info, float *rgb)
{
    static const float p[12] = { 0, 0, 0, 1, 2, 3, -5, 0.1f, 0, 1e5f, -1e6f, 3 },
                       n[12] = { 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0 };
    static const float sky[3] = { 1, 1, 1 };
    sfield_scene_desc desc;
    sfield_entity e = upright;
    sfield_scene *s;
    sfield_points set;
    int good = 1;
    memset(&desc, 0, sizeof desc);
    desc.basis = info->basis;
    desc.bands = info->bands;
    desc.cube_side = info->basis == SFIELD_BASIS_HAAR ? info->cube_side : 4; /* a sky of one colour needs no more */
    if (info->logarithm) desc.product = SFIELD_PRODUCT_EXP;
    if (sfield_scene_create(&desc, &s) != SFIELD_OK) return 1;
    memset(&set, 0, sizeof set);
    if (info->kind == SFIELD_KIND_OCCLUSION) e.occlusion = f;
    if (info->kind == SFIELD_KIND_SOURCE) e.source = f;
    if (info->kind == SFIELD_KIND_SELF) set.self = f;
    e.time = 0.31f;
    sfield_scene_environment(s, sky, 1, 1, NULL);
    set.count = info->kind == SFIELD_KIND_SELF ? info->sample_count : 4;
    set.positions = p;
    set.normals = n;
    set.entity = 0;
    set.rgb = rgb;
    if (sfield_scene_entities(s, &e, info->kind != SFIELD_KIND_SELF) == SFIELD_OK && set.count <= 4 &&
        sfield_shade(s, &set, 1, NULL) != SFIELD_OK)
        good = 0;
    sfield_scene_free(s);
    return good;
}

/* 1, or 0 where something is wrong. */
static inline int use_field(const sfield_field *f)
{
    static const float p[15] = { 0, 0, 0, 0.3f, -0.2f, 0.1f, 3, 2, 1, -1000, 5, 1e12f, 1, 1, 1 };
    sfield_info info;
    size_t size, i;
    float ambient[5], rgb[12], *out;
    uint8_t *bytes;
    int good = 1;
    sfield_get_info(f, &info);
    size = info.basis == SFIELD_BASIS_HAAR ? 6 * info.cube_side * info.cube_side : info.bands * info.bands;
    out = (float *)malloc(3 * 5 * size * sizeof *out);
    bytes = (uint8_t *)malloc(sfield_bytes(f));
    if (!out || !bytes) good = 0;
    else if (info.shard_end) {      /* whole, or not mergeable alone; nothing else looks into it */
        sfield_field *whole = NULL;
        sfield_result r = sfield_merge(&f, 1, NULL, &whole);
        good = sfield_query(f, 1, p, 0, out) == SFIELD_ERR_MISMATCH &&
               r == (info.shard_begin || info.shard_end != info.shell_count * info.frame_count ? SFIELD_ERR_MISMATCH
                                                                                               : SFIELD_OK);
        if (r == SFIELD_OK) good = good && sfield_query(whole, 5, p, 0.2f, out) == SFIELD_OK;
        sfield_free(whole);
    } else if (info.kind == SFIELD_KIND_SELF) {
        good = sfield_self(f, 0, info.sample_count < 5 ? info.sample_count : 5, out) == SFIELD_OK;
    } else {
        good = sfield_query(f, 5, p, 0.2f, out) == SFIELD_OK &&
               use_all_finite(out, (info.kind == SFIELD_KIND_SOURCE ? 15u : 5u) * size);
        if (sfield_ambient(f, 5, p, ambient) == SFIELD_OK)
            for (i = 0; i < 5; i++) good = good && ambient[i] >= 0 && ambient[i] <= 1;
    }
    good = good && bytes && sfield_write(f, bytes, sfield_bytes(f)) == SFIELD_OK && use_in_a_scene(f, &info, rgb);
    free(out);
    free(bytes);
    return good;
}

#endif
