/* ---- sources: points on lamps, directions of a sky, points as VPLs ---- */

/* Writes the power that leaves each triangle, over pi; 0 if the triangle's radiance cannot be used. */
static void ism__weigh_emitters(const ism_mesh *mesh, const float *radiances, size_t triangles,
                                float *weights)
{
    size_t t;
    for (t = 0; t < triangles; t++) {
        ism__v3 p[3];
        ism__corners(mesh, t, p);
        weights[t] = ism__flux_ok(radiances + 3u * t)
                   ? ism__luminance(radiances + 3u * t) * 0.5f *
                     ism__v3_length(ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0])))
                   : 0.0f;
    }
}

/* Draws count points on triangles in proportion to their power: point i at (i + 0.5) / count of the sum of
   all, and within its triangle by the golden ratio. */
static void ism__place_emitters(const ism_mesh *mesh, const float *radiances, const ism__cdf *cdf,
                                uint32_t count, uint32_t seed, float *positions, float *normals,
                                float *fluxes)
{
    const uint32_t key = ism__hash_combine(seed, 21u);
    uint32_t i, k;
    for (i = 0; i < count; i++) {
        ism__cdf_sample s = ism__cdf_sample_at(cdf, (float)(((double)i + 0.5) / (double)count));
        ism__v3 p[3], n;
        float b1, b2, area;
        ism__triangle_map(ism__to_unit(key + i * 3242174889u),
                          ism__to_unit(ism__hash32(key) + i * 2447445413u), &b1, &b2);
        ism__corners(mesh, s.index, p);
        p[1] = ism__v3_sub(p[1], p[0]);
        p[2] = ism__v3_sub(p[2], p[0]);
        n = ism__v3_cross(p[1], p[2]);
        area = 0.5f * ism__v3_length(n);
        ism__v3_store(positions + 3u * (size_t)i, ism__v3_madd(ism__v3_madd(p[0], p[1], b1), p[2], b2));
        ism__v3_store(normals + 3u * (size_t)i, ism__v3_normalize(n));
        for (k = 0; k < 3u; k++)
            fluxes[3u * (size_t)i + k] =
                ISM__PI * radiances[3u * (size_t)s.index + k] * area / ((float)count * s.probability);
    }
}

ISM_DEF ism_result ism_emitter_points(const ism_mesh *mesh, const float *radiances, uint32_t count,
                                      uint32_t seed, const ism_system *system, float *positions,
                                      float *normals, float *fluxes)
{
    ism__allocator memory;
    ism__cdf cdf;
    size_t triangles = ism__mesh_triangles(mesh);
    float *weights;
    double *sums;
    int shines;
    ism_system zero = { { NULL, NULL, NULL }, NULL, NULL, NULL, NULL };
    ism__job job;
    ism_result result;
    if (system) zero = *system;
    ism__begin_job(&zero, "ism_emitter_points", NULL, &job);
    if (!mesh || !radiances || !positions || !normals || !fluxes)
        return ism__is_null(&job.log, !mesh        ? "mesh"
                                      : !radiances ? "radiances"
                                      : !positions ? "positions"
                                      : !normals   ? "normals"
                                                   : "fluxes");
    if (!count) {
        ism__log_value(&job.log, "count", 0.0, "above 0");
        return ISM_ERR_ARGUMENT;
    }
    if (!ism__allocator_valid(zero.allocator.alloc_fn, zero.allocator.free_fn)) {
        ism__log_text(&job.log, "system.allocator", "has one function of two");
        return ISM_ERR_DESC;
    }
    result = ism__check_mesh(&job.log, mesh);
    if (result == ISM_OK) result = ism__check_indices(&job.log, mesh);
    if (result != ISM_OK) return result;
    if (!triangles || triangles >= 1u << 31) {
        ism__log_value(&job.log, "the mesh's count of triangles", (double)triangles, "1..2^31 - 1");
        return triangles ? ISM_ERR_LIMIT : ISM_ERR_ARGUMENT;
    }
    memory = ism__allocator_make(zero.allocator.alloc_fn, zero.allocator.free_fn, zero.allocator.user);
    weights = (float *)ism__alloc_array(&memory, triangles, sizeof *weights);
    sums = (double *)ism__alloc_array(&memory, triangles + 1u, sizeof *sums);
    if (!weights || !sums) {
        ism__free(&memory, sums);
        ism__free(&memory, weights);
        return ism__no_memory(&job.log);
    }
    ism__weigh_emitters(mesh, radiances, triangles, weights);
    ism__cdf_build(&cdf, sums, weights, (uint32_t)triangles, 1.0);
    shines = ism__cdf_total(&cdf) > 0.0;
    if (shines) ism__place_emitters(mesh, radiances, &cdf, count, seed, positions, normals, fluxes);
    ism__free(&memory, sums);
    ism__free(&memory, weights);
    if (shines) return ISM_OK;
    ism__log_text(&job.log, "radiances", "are all 0: no triangle emits");
    return ISM_ERR_INPUT;
}

ISM_DEF ism_result ism_sky_directions(const float *texels, uint32_t width, uint32_t height, float rotation,
                                      float *directions, float *fluxes, uint64_t *bad_texels)
{
    uint32_t x, y, k;
    uint64_t bad = 0;
    double turns = (double)rotation * 0.15915494309189535;
    float half, unused;
    if (!texels || !width || !height || !directions || !fluxes || !ism__finite(rotation))
        return ISM_ERR_ARGUMENT;
    if (fabs(turns) < 1e15) rotation = (float)((double)rotation - 6.283185307179586 * (double)(int64_t)turns);
    else rotation = 0.0f;                        /* neighbouring floats are more than a turn apart there */
    ism__sincos(0.5f * ISM__PI / (float)height, &half, &unused);
    for (y = 0; y < height; y++) {
        /* Angles are taken from the nearer pole, where they are exact. Solid angles are a product: the
           difference of cosines there would have no right digit. */
        uint32_t from = y < height / 2u ? y : height - 1u - y;
        float theta = ISM__PI * ((float)from + 0.5f) / (float)height, st, ct, solid;
        ism__sincos(theta, &st, &ct);
        if (from != y) ct = -ct;
        solid = st * half * 4.0f * ISM__PI / (float)width;
        for (x = 0; x < width; x++) {
            size_t i = 3u * ((size_t)y * width + x);
            float phi = 2.0f * ISM__PI * (((float)x + 0.5f) / (float)width - 0.5f) - rotation, s, c;
            int wrong = 0;
            ism__sincos(phi, &s, &c);
            directions[i] = st * c;
            directions[i + 1u] = ct;
            directions[i + 2u] = st * s;
            for (k = 0; k < 3u; k++) {
                float value = texels[i + k];
                int good = ism__finite(value) && value >= 0.0f;
                wrong |= !good;
                fluxes[i + k] = good ? value * solid : 0.0f;
            }
            bad += (uint64_t)wrong;
        }
    }
    if (bad_texels) *bad_texels = bad;
    return ISM_OK;
}

/* Writes point i of a source as a VPL. What a point without flux has of vectors is not read. */
static void ism__point_vpl(const ism_source *s, size_t source, size_t i, ism_vpl *v)
{
    const float *flux = ism__at(s->fluxes, s->flux_stride, i);
    ism__v3 p = ism__v3_make(0.0f, 0.0f, 0.0f), n = ism__v3_make(0.0f, 1.0f, 0.0f);
    memset(v, 0, sizeof *v);
    memcpy(v->flux, flux, sizeof v->flux);
    v->source = (uint32_t)source;
    v->texel = (uint32_t)i;
    v->directional = s->kind == ISM_SOURCE_DIRECTIONS;
    if (!ism__flux_ok(flux) || ism__luminance(flux) > 0.0f) {
        p = ism__v3_load(ism__at(s->positions, s->position_stride, i));
        n = v->directional ? ism__v3_scale(p, -1.0f)
                           : ism__v3_load(ism__at(s->normals, s->normal_stride, i));
    }
    ism__v3_store(v->position, p);
    ism__v3_store(v->normal, n);
    ism__v3_store(v->axis, n);
    v->exponent = 1.0f;
    if (v->directional) return;
    if (s->lobes && ism__luminance(flux) > 0.0f) {
        memcpy(v->axis, ism__lobe(s, i), sizeof v->axis);
        v->exponent = ism__lobe(s, i)[3];
    }
    if (s->areas) v->area = *ism__at(s->areas, s->area_stride ? s->area_stride : 4u, i);
    if (!ism__in(v->area, 0.0f, ISM__MAX_FLOAT)) v->area = 0.0f;
}

ISM_DEF ism_result ism_set_sources(ism_maps *m, const ism_source *sources, size_t source_count)
{
    ism__job job;
    ism_frame frame;
    ism_vpl v;
    size_t count = 0, doubles;
    size_t s, i, n = 0;
    ism_result result;
    if (!m) return ISM_ERR_ARGUMENT;
    memset(&frame, 0, sizeof frame);
    frame.sources = sources;
    frame.source_count = source_count;
    ism__begin_job(&m->desc.system, "ism_set_sources", &frame, &job);
    result = ism__check_sources(&job.log, &frame, &count, &doubles);
    if (result != ISM_OK) return result;
    if (count > m->desc.vpl_count) {
        ism__log_value(&job.log, "the sources' count of points", (double)count, "desc.vpl_count at most");
        return ISM_ERR_LIMIT;
    }
    for (s = 0; s < source_count; s++)
        for (i = 0; i < (size_t)sources[s].width * sources[s].height; i++, n++) {
            ism__point_vpl(&sources[s], s, i, &v);
            if ((result = ism__check_vpl(&job.log, &v, n)) != ISM_OK) return result;
        }
    for (s = n = 0; s < source_count; s++)
        for (i = 0; i < (size_t)sources[s].width * sources[s].height; i++)
            ism__point_vpl(&sources[s], s, i, &m->vpls[n++]);
    m->vpl_count = (uint32_t)count;
    m->stats.jumped = 0;
    m->built = 0;
    return ism__finish_vpls(m, &job.part, 0.0f, 1.0f);
}
