/* ---- building: the public calls ---- */

/* Frees all that a build holds, and returns the result. */
static sfield_result sfield__end_build(sfield__build *b, sfield_result result)
{
    if (result == SFIELD_ERR_ALLOC) sfield__log_text(&b->log, "desc.system.allocator", "returned no memory");
    sfield__release_build(b);
    return result;
}

/* Returns the log of a call, for what is wrong before its desc is read. */
static sfield__logger sfield__log_of_desc(const sfield_desc *desc, const char *function)
{
    return sfield__logger_of(desc ? &desc->system : NULL, function);
}

SFIELD_DEF sfield_result sfield_build(const sfield_desc *desc, const sfield_mesh *mesh, sfield_field **out,
                                      sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build");
    sfield__build b;
    sfield_result result;
    if (!mesh || !out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, mesh ? "out" : "mesh", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_OCCLUSION, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__MESH;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

/* Checks the radiance of all triangles in all frames. Every number must be finite, 0..1e18. */
static sfield_result sfield__check_radiance(const sfield__build *b, const float *radiance, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++)
        if (!sfield__in(radiance[i], 0, 1e18f)) {
            sfield__log_element(&b->log, "radiance", i, "is", (double)radiance[i], "0..1e18");
            return SFIELD_ERR_INPUT;
        }
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh,
                                               const float *radiance, sfield_field **out, sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_emissive");
    sfield__build b;
    sfield_result result;
    if (!mesh || !out || !radiance)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !mesh ? "mesh" : !out ? "out" : "radiance", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_SOURCE, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__EMISSIVE;
    b.radiance = radiance;
    result = sfield__check_mesh(&b, mesh);
    if (result == SFIELD_OK)
        result = sfield__check_radiance(&b, radiance, 3 * (sfield__mesh_corners(mesh) / 3) * b.h.frames);
    if (result == SFIELD_OK) result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_emitter");
    sfield__build b;
    sfield_result result;
    if (!emitter || !out)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, emitter ? "out" : "emitter", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_SOURCE, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__ANALYTIC;
    b.emitter = *emitter;
    result = sfield__take_emitter(&b);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha_fn, void *user,
                                               sfield_field **out, sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_callback");
    sfield__build b;
    sfield_result result;
    if (!alpha_fn || !out || !desc)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !desc ? "desc" : !out ? "out" : "alpha_fn", "is NULL");
    result = sfield__read_desc(&b, desc, SFIELD__KIND_OCCLUSION, log.function);
    if (result == SFIELD_OK) result = sfield__need_radius(&b);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__CALLBACK;
    b.emitter.kind = SFIELD_EMITTER_CALLBACK;
    b.emitter.view_fn = alpha_fn;
    b.emitter.user = user;
    result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see_fn, void *user, sfield_field **out,
                                            sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_views");
    sfield__build b;
    sfield_result result;
    if (!see_fn || !out || (!mesh && !desc))
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !see_fn ? "see_fn" : !out ? "out" : "mesh", "is NULL");
    result = sfield__read_desc(&b, desc, source ? SFIELD__KIND_SOURCE : SFIELD__KIND_OCCLUSION, log.function);
    if (result == SFIELD_OK && !mesh) result = sfield__need_radius(&b);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__VIEWS;
    b.see = see_fn;
    b.see_user = user;
    if (mesh) result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}

/* Checks that positions are finite and in range, and that normals are unit or 0. */
static sfield_result sfield__check_points(const sfield__logger *log, const sfield_points *p)
{
    size_t i, k;
    for (i = 0; i < p->count; i++) {
        const float *at = sfield__row(p->positions, p->position_stride, i);
        for (k = 0; k < 3; k++)
            if (!sfield__in(at[k], -1e18f, 1e18f)) {
                sfield__log_element(log, "points->positions", i, "has a coordinate", (double)at[k],
                                    "-1e18..1e18");
                return SFIELD_ERR_INPUT;
            }
        at = sfield__row(p->normals, p->normal_stride, i);
        if (!sfield__finite(at[0]) || !sfield__finite(at[1]) || !sfield__finite(at[2]))
            return sfield__fail_at(log, SFIELD_ERR_INPUT, "points->normals", i, "is not finite");
    }
    return sfield__check_units(log, "points->normals", p->normals, p->normal_stride, p->count);
}

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh,
                                           const sfield_points *points, float offset, sfield_field **out,
                                           sfield_stats *stats)
{
    const sfield__logger log = sfield__log_of_desc(desc, "sfield_build_self");
    sfield__build b;
    sfield_result result;
    if (!mesh || !out || !points)
        return sfield__fail(&log, SFIELD_ERR_ARGUMENT, !mesh ? "mesh" : !out ? "out" : "points", "is NULL");
    if (!sfield__points_good(&log, points)) return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(&log, points->count > 0, "points->count", 0, "> 0") ||
        !sfield__check_value(&log, sfield__in(offset, 0, 1e18f), "offset", (double)offset, "0..1e18"))
        return SFIELD_ERR_ARGUMENT;
    if (!sfield__check_value(&log, points->count <= 0x7fffffffu, "points->count", (double)points->count,
                      "below 2^31"))
        return SFIELD_ERR_LIMIT;
    result = sfield__check_points(&log, points);
    if (result != SFIELD_OK) return result;
    result = sfield__read_desc(&b, desc, SFIELD__KIND_SELF, log.function);
    if (result != SFIELD_OK) return result;
    b.what = SFIELD__SELF;
    b.points = points;
    b.offset = offset;
    b.h.samples = (uint32_t)points->count;
    result = sfield__take_mesh(&b, mesh);
    if (result == SFIELD_OK) result = sfield__run_build(&b, out, stats);
    return sfield__end_build(&b, result);
}
