/* shadowfield_baked.c - see shadowfield_parts.h */
#include "shadowfield_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int failed(const char *path, const char *why, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield: %.150s: %s", path, why);
    return -1;
}

/* ---- files ---- */

static int open_file(const char *path, const rd_job *job, sfield_basis basis, sfield_field **out, char *error)
{
    sfield_info info;
    sfield_system services;
    sfield_result r;
    size_t size;
    void *data = ex_file_read(path, &size, error);
    if (!data)
        return -1;
    memset(&services, 0, sizeof services);
    services.progress = ex_progress;
    services.user = (void *)(size_t)"shadowfield";
    r = sfield_open(data, size, &services, out);
    free(data);
    if (r != SFIELD_OK)
        return failed(path, sfield_result_text(r), error);
    sfield_get_info(*out, &info);
    if (info.basis == basis && !info.logarithm && !info.shard_end &&
        (basis != SFIELD_BASIS_SH || info.bands == (uint32_t)rd_setting_integer(job->settings, "bands")))
        return 0;
    return failed(path, "not a whole field of this basis and these bands", error);
}

int sf_baked_open(sf_baked *b, const rd_job *job, sfield_basis basis, char *error)
{
    memset(b, 0, sizeof *b);
    b->field = calloc(job->baked_count + 1, sizeof *b->field);
    b->used = calloc(job->baked_count + 1, sizeof *b->used);
    if (!b->field || !b->used)
        return failed("--baked", "out of memory", error);
    for (; b->count < job->baked_count; b->count++)
        if (open_file(job->baked[b->count], job, basis, &b->field[b->count], error) != 0) {
            b->count += b->field[b->count] != NULL;
            return -1;
        }
    return 0;
}

int sf_baked_all_used(const sf_baked *b, const rd_job *job, char *error)
{
    for (size_t i = 0; i < b->count; i++)
        if (!b->used[i])
            return failed(job->baked[i], "the field of another object", error);
    return 0;
}

void sf_baked_drop(const sf_baked *b, sfield_field *field)
{
    for (size_t i = 0; i < b->count; i++)
        if (b->field[i] == field)
            return;
    sfield_free(field);
}

void sf_baked_free(sf_baked *b)
{
    for (size_t i = 0; i < b->count; i++)
        sfield_free(b->field[i]);
    free(b->field);
    free(b->used);
    memset(b, 0, sizeof *b);
}

/* ---- whose they are ---- */

/* Its sphere holds and just holds the vertices. */
static int holds(const sfield_info *info, const ex_mesh *mesh)
{
    float farthest = 0;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const float *p = mesh->positions + 3 * (size_t)i;
        float d[3] = { p[0] - info->center[0], p[1] - info->center[1], p[2] - info->center[2] };
        farthest = fmaxf(farthest, sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
    }
    return farthest > 0.99f * info->radius && farthest < 1.001f * info->radius;
}

/* The sum over all directions, up to a factor, of each vector in turn: of c channels. */
static float total(const sfield_info *info, const float *v, size_t vector)
{
    const size_t n =
        info->basis == SFIELD_BASIS_SH ? info->bands * info->bands : 6u * info->cube_side * info->cube_side;
    float sum = 0;
    if (info->basis == SFIELD_BASIS_SH)
        return v[vector * n];
    for (size_t i = 0; i < n; i++)
        sum += v[vector * n + i];
    return sum;
}

static int alike(const sfield_info *info, const float *a, const float *b, size_t vectors)
{
    float most = 0, off = 0;
    for (size_t i = 0; i < vectors; i++) {
        most = fmaxf(most, fabsf(total(info, b, i)));
        off = fmaxf(off, fabsf(total(info, a, i) - total(info, b, i)));
    }
    return off <= 0.03f * most;
}

/* The desc of a small field of the same kind whose last shell has the corners of the file's. */
static sfield_desc corners_of(const sfield_info *info)
{
    sfield_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.basis = info->basis;
    desc.bands = info->bands;
    desc.cube_side = info->cube_side;
    desc.shell_count = desc.position_side = 2;
    desc.inner = info->inner;
    desc.outer = info->outer;
    desc.spacing = info->spacing;
    desc.keep = 1;
    memcpy(desc.center, info->center, sizeof desc.center);
    desc.radius = info->radius;
    return desc;
}

/* Does the field shine at a time, asked from those corners, as the small one does? */
static int same_at_corners(const sfield_field *field, const sfield_info *info, const sfield_field *corners, float time)
{
    const size_t vector =
        info->basis == SFIELD_BASIS_SH ? info->bands * info->bands : 6u * info->cube_side * info->cube_side;
    const float d = info->outer * info->radius / sqrtf(3.0f);
    float p[24], *values = malloc(2 * 8 * 3 * vector * sizeof *values);
    int same;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            p[3 * i + k] = info->center[k] + (i >> k & 1 ? d : -d);
    same = values && sfield_query(field, 8, p, time, values) == SFIELD_OK &&
           sfield_query(corners, 8, p, 0, values + 24 * vector) == SFIELD_OK &&
           alike(info, values, values + 24 * vector, 24);
    free(values);
    return same;
}

/* Does it shine as the object does now? The corners alone are built here. */
static int shines_so(const sfield_field *field, const sfield_info *info, const ex_mesh *mesh, const sf_glow *glow,
                     float time)
{
    const sfield_mesh m = { mesh->positions, mesh->vertex_count, 0, glow->indices, 3 * (size_t)glow->count,
                            NULL, NULL, NULL };
    const sfield_desc desc = corners_of(info);
    sfield_field *corners = NULL;
    const int same = sfield_build_emissive(&desc, &m, glow->radiance, &corners, NULL) == SFIELD_OK &&
                     same_at_corners(field, info, corners, time);
    sfield_free(corners);
    return same;
}

/* The same of a lamp, whose field lies about the origin with its own radius. */
static int is_of_lamp(const sfield_field *field, const sfield_info *info, const sfield_emitter *emitter)
{
    sfield_desc desc = corners_of(info);
    sfield_info own;
    sfield_field *corners = NULL;
    int same;
    desc.radius = 0;
    same = sfield_build_emitter(&desc, emitter, &corners, NULL) == SFIELD_OK;
    if (same) {
        sfield_get_info(corners, &own);
        same = fabsf(own.radius - info->radius) < 1e-4f * own.radius && same_at_corners(field, info, corners, 0);
    }
    sfield_free(corners);
    return same;
}

/* Is it of these points? Some of them are built again. */
static int sees_so(const sfield_field *field, const sfield_info *info, const sfield_desc *from, const sfield_mesh *mesh,
                   const sf_surface *s, float offset)
{
    enum { ASKED = 8 };
    const size_t vector =
        info->basis == SFIELD_BASIS_SH ? info->bands * info->bands : 6u * info->cube_side * info->cube_side;
    float p[3 * ASKED], n[3 * ASKED], *values;
    sfield_desc d = *from;
    sfield_field *some = NULL;
    int same = 0;
    if (info->sample_count != s->chosen_count || info->cube_side != (info->basis == SFIELD_BASIS_SH ? 16u : 32u))
        return 0;
    values = malloc(2 * ASKED * vector * sizeof *values);
    for (size_t i = 0; values && i < ASKED; i++) {
        const size_t at = i * (s->chosen_count - 1) / (ASKED - 1);
        memcpy(p + 3 * i, s->chosen_positions + 3 * at, 3 * sizeof *p);
        memcpy(n + 3 * i, s->chosen_normals + 3 * at, 3 * sizeof *n);
        sfield_self(field, at, 1, values + i * vector);
    }
    d.system.progress = NULL;
    if (values && sfield_build_self(&d, mesh, &(const sfield_points){ .count = ASKED, .positions = p, .normals = n },
                                    offset, &some, NULL) == SFIELD_OK &&
        sfield_self(some, 0, ASKED, values + ASKED * vector) == SFIELD_OK)
        same = alike(info, values, values + ASKED * vector, ASKED);
    sfield_free(some);
    free(values);
    return same;
}

sfield_field *sf_baked_occlusion(sf_baked *b, const ex_mesh *mesh)
{
    for (size_t i = 0; i < b->count; i++) {
        sfield_info info;
        sfield_get_info(b->field[i], &info);
        if (info.kind != SFIELD_KIND_OCCLUSION || !holds(&info, mesh))
            continue;
        b->used[i] = 1;
        return b->field[i];
    }
    return NULL;
}

sfield_field *sf_baked_source(sf_baked *b, const ex_mesh *mesh, const sf_glow *glow, float time)
{
    for (size_t i = 0; i < b->count; i++) {
        sfield_info info;
        sfield_get_info(b->field[i], &info);
        if (info.kind != SFIELD_KIND_SOURCE || !holds(&info, mesh) || !shines_so(b->field[i], &info, mesh, glow, time))
            continue;
        b->used[i] = 1;
        return b->field[i];
    }
    return NULL;
}

sfield_field *sf_baked_lamp(sf_baked *b, const sfield_emitter *emitter)
{
    for (size_t i = 0; i < b->count; i++) {
        sfield_info info;
        const float *c = info.center;
        sfield_get_info(b->field[i], &info);
        if (info.kind != SFIELD_KIND_SOURCE || fabsf(c[0]) + fabsf(c[1]) + fabsf(c[2]) > 0 ||
            !is_of_lamp(b->field[i], &info, emitter))
            continue;
        b->used[i] = 1;
        return b->field[i];
    }
    return NULL;
}

sfield_field *sf_baked_self(sf_baked *b, const sfield_desc *desc, const ex_mesh *mesh, const sf_surface *surface,
                            float offset)
{
    const sfield_mesh m = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                           3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
    for (size_t i = 0; i < b->count; i++) {
        sfield_info info;
        sfield_get_info(b->field[i], &info);
        if (info.kind != SFIELD_KIND_SELF || !holds(&info, mesh) ||
            !sees_so(b->field[i], &info, desc, &m, surface, offset))
            continue;
        b->used[i] = 1;
        return b->field[i];
    }
    return NULL;
}
