/* ---- splat: points are fetched, and drawn as discs into one tile (paper 3.3) ---- */

/* Has the corners of the point ISM__AHEAD places on fetched, and the indices of the one twice as far: points
   lie in the mesh's order, but so far apart that the processor does not foresee the next. */
ISM__INLINE void ism__read_ahead(const ism_mesh *mesh, const ism__surfel *points, uint32_t count, uint32_t j)
{
    uint32_t k;
    if (mesh->indices && j + 2u * ISM__AHEAD < count) {
        const uint32_t *at = mesh->indices + 3u * (size_t)points[j + 2u * ISM__AHEAD].triangle;
        ISM__PREFETCH(at);
        ISM__PREFETCH(at + 2);
    } else if (mesh->indices16 && j + 2u * ISM__AHEAD < count) {
        ISM__PREFETCH(mesh->indices16 + 3u * (size_t)points[j + 2u * ISM__AHEAD].triangle);
    }
    if (j + ISM__AHEAD >= count) return;
    for (k = 0; k < 3u; k++) {
        size_t i = 3u * (size_t)points[j + ISM__AHEAD].triangle + k;
        const float *at = ism__at(mesh->positions, mesh->vertex_stride, ism__index(mesh, i));
        ISM__PREFETCH(at);
        ISM__PREFETCH(at + 2);
    }
}

/* Adds a point to those that wait to be drawn. */
static void ism__add_point(const ism_mesh *mesh, const ism__surfel *point, ism__discs *s)
{
    uint32_t i = s->count++, k;
    s->triangle[i] = point->triangle;
    s->weight[i] = point->weight;
    s->b1[i] = (float)point->b1 * (1.0f / 65535.0f);
    s->b2[i] = (float)point->b2 * (1.0f / 65535.0f);
    for (k = 0; k < 3u; k++) {
        const float *p = ism__at(mesh->positions, mesh->vertex_stride,
                                 ism__index(mesh, 3u * (size_t)point->triangle + k));
        s->corners[k][0][i] = p[0];
        s->corners[k][1][i] = p[1];
        s->corners[k][2][i] = p[2];
    }
}

/* Draws the points of VPL `number` into its tile, ISM__DISCS together. */
static void ism__draw_points(ism__tile *tile, const ism__splat *kernels, const ism__surfel *points,
                             uint32_t count, uint32_t number)
{
    const ism_mesh *mesh = tile->mesh;
    uint32_t j, column = number % tile->m->tiles, row = number / tile->m->tiles;
    ism__discs discs;
    memset(&discs, 0, sizeof discs);
    for (j = 0; j < count; j++) {
        ism__read_ahead(mesh, points, count, j);
        /* Opacity is dithered over 2 x 2 tiles, not texels: pull and push would close the gaps that dithering
           leaves. Points in holes have no weight. */
        if (points[j].weight > 0.0f &&
            (!mesh->opacities || ism__dither(column, row, mesh->opacities[points[j].triangle])))
            ism__add_point(mesh, &points[j], &discs);
        if (discs.count < ISM__DISCS && j + 1u < count) continue;
        kernels->draw(tile, &discs, kernels->place(tile, &discs));
        discs.count = 0;
    }
}
