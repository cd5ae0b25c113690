/* ---- bounce: imperfect reflective shadow maps ---- */

/* The arrays to which the source of the next bounce is written. */
typedef struct ism__bounce_out { float *positions, *normals, *fluxes; } ism__bounce_out;

/* Writes one texel of a tile as pVPL i of the next bounce. share: the part of the VPL's flux that leaves
   through the texel. */
static void ism__bounce_texel(const ism_maps *m, const ism_mesh *mesh, uint32_t v, const uint32_t texel[2],
                              float share, const ism__bounce_out *out, size_t i)
{
    size_t column = v % m->tiles, row = v / m->tiles, size = m->desc.tile_side;
    size_t at = (row * size + texel[1]) * m->side + column * size + texel[0];
    uint32_t t = ((const uint32_t *)m->hits.data)[at], k;
    const ism_vpl *vpl = &m->vpls[v];
    ism__orientation f = ism__vpl_axes(m, vpl);
    float uv[2], direction[3], length;
    ism__v3 p[3], n, d, none = ism__v3_make(0.0f, 0.0f, 0.0f);
    ism__v3_store(out->positions + 3u * i, none);
    ism__v3_store(out->normals + 3u * i, ism__v3_make(0.0f, 1.0f, 0.0f));
    ism__v3_store(out->fluxes + 3u * i, none);
    if (t == UINT32_MAX || vpl->directional) return;
    uv[0] = ((float)texel[0] + 0.5f) / (float)size;
    uv[1] = ((float)texel[1] + 0.5f) / (float)size;
    ism_map_direction(ism__projection_of(m, vpl), vpl->exponent, uv, direction);
    if (!(direction[2] > 0.0f)) return;
    ism__corners(mesh, t, p);
    n = ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0]));
    length = ism__v3_length(n);
    if (!(length > 0.0f) || !ism__finite(length)) return;
    d = ism__to_world(&f, ism__v3_load(direction));
    n = ism__v3_scale(n, (ism__v3_dot(n, d) > 0.0f ? -1.0f : 1.0f) / length);
    ism__v3_store(out->positions + 3u * i,
                  ism__v3_madd(ism__v3_load(vpl->position), d, ((const float *)m->atlas.data)[at]));
    ism__v3_store(out->normals + 3u * i, n);
    for (k = 0; k < 3u; k++)
        out->fluxes[3u * i + k] = vpl->flux[k] * share * (mesh->albedos ? mesh->albedos[3u * t + k] : 0.5f);
}

/* Returns how much of a VPL's light leaves through a cell, but for a factor: the VPL's intensity x solid
   angle at the centre of texel (x, y), which stands for the cell. All cells of COSINE and LOBE maps are
   equal. */
static float ism__cell_weight(const ism_maps *m, const ism_vpl *v, uint32_t x, uint32_t y)
{
    ism_projection projection = ism__projection_of(m, v);
    float size = (float)m->desc.tile_side, e = 0.25f / size, uv[2], d[4][3];
    int k;
    ism__v3 n;
    if (projection == ISM_PROJECTION_COSINE || projection == ISM_PROJECTION_LOBE) return 1.0f;
    for (k = 0; k < 4; k++) {       /* the corners of a small square in the map, as directions */
        uv[0] = ((float)x + 0.5f) / size + (k == 1 || k == 2 ? e : -e);
        uv[1] = ((float)y + 0.5f) / size + (k >= 2 ? e : -e);
        ism_map_direction(projection, v->exponent, uv, d[k]);
    }
    n = ism__v3_cross(ism__v3_sub(ism__v3_load(d[2]), ism__v3_load(d[0])),
                      ism__v3_sub(ism__v3_load(d[3]), ism__v3_load(d[1])));
    if (!(d[0][2] > 0.0f)) return 0.0f;
    return ism__v3_length(n) * (v->exponent == 1.0f ? d[0][2] : ism__pow(d[0][2], v->exponent));
}

/* Writes the side * side pVPLs of one VPL's tile: zeros if there is no such VPL. */
static void ism__bounce_vpl(const ism_maps *m, const ism_mesh *mesh, uint32_t v, uint32_t side,
                            const ism__bounce_out *out)
{
    size_t cells = (size_t)side * side, first = v * cells, c;
    uint32_t step = m->desc.tile_side / side, texel[2];
    float sum = 0.0f;
    if (v >= m->vpl_count) {
        memset(out->positions + 3u * first, 0, 3u * cells * sizeof(float));
        memset(out->normals + 3u * first, 0, 3u * cells * sizeof(float));
        memset(out->fluxes + 3u * first, 0, 3u * cells * sizeof(float));
        return;
    }
    for (c = 0; c < cells; c++)
        sum += ism__cell_weight(m, &m->vpls[v], (uint32_t)(c % side) * step + step / 2u,
                                (uint32_t)(c / side) * step + step / 2u);
    for (c = 0; c < cells; c++) {
        texel[0] = (uint32_t)(c % side) * step + step / 2u;
        texel[1] = (uint32_t)(c / side) * step + step / 2u;
        ism__bounce_texel(m, mesh, v, texel, ism__cell_weight(m, &m->vpls[v], texel[0], texel[1]) / sum, out,
                          first + c);
    }
}

ISM_DEF ism_result ism_bounce(const ism_maps *m, const ism_mesh *mesh, uint32_t side, float *positions,
                              float *normals, float *fluxes)
{
    uint32_t v;
    ism__bounce_out out;
    ism__job job;
    ism_result result;
    if (!m) return ISM_ERR_ARGUMENT;
    ism__begin_job(&m->desc.system, "ism_bounce", NULL, &job);
    if (!mesh || !positions || !normals || !fluxes)
        return ism__is_null(&job.log, !mesh        ? "mesh"
                                      : !positions ? "positions"
                                      : !normals   ? "normals"
                                                   : "fluxes");
    if (!side || (side & (side - 1u)) || side > m->desc.tile_side) {
        ism__log_value(&job.log, "side", (double)side, "a power of two, desc.tile_side at most");
        return ISM_ERR_ARGUMENT;
    }
    if (!m->desc.keep_hits) {
        ism__log_text(&job.log, "maps", "have no hits: they were made without desc.keep_hits");
        return ISM_ERR_MISMATCH;
    }
    if (!m->built || !m->hits.data)
        return ism__too_early(&job.log, "maps", "are not drawn: call ism_build before");
    result = ism__check_mesh(&job.log, mesh);
    if (result == ISM_OK && m->triangles && ism__mesh_triangles(mesh) != m->triangles) {
        ism__log_value(&job.log, "the mesh's count of triangles", (double)ism__mesh_triangles(mesh),
                       "that of the last ism_build");
        result = ISM_ERR_MISMATCH;
    }
    if (result == ISM_OK) result = ism__check_indices(&job.log, mesh);
    if (result != ISM_OK) return result;
    out.positions = positions;
    out.normals = normals;
    out.fluxes = fluxes;
    for (v = 0; v < m->desc.vpl_count; v++) ism__bounce_vpl(m, mesh, v, side, &out);
    return ISM_OK;
}
