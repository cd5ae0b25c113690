/* ---- splat: discs into one tile (paper 3.3) ---- */

struct ism__disc;

typedef struct ism__tile {          /* one VPL's map while it is drawn */
    const ism_maps *m;
    const ism_mesh *mesh;
    const ism_vpl  *vpl;
    ism__orientation   frame;
    ism_projection  projection;
    uint32_t        size;
    const ism__window *window;      /* NULL: the whole square */
    const float    *x, *y, *z;      /* directions of texel centres, in the tile's frame; x, y, 1 of sky maps
                                       in units of radius */
    float          *depth;          /* at texel centres; ISM_FAR = empty */
    ism__texel     *texels;
    void          (*draw)(struct ism__tile *tile, const struct ism__disc *s, const uint32_t box[4]);
    uint64_t        splats, wide, filled;
} ism__tile;

typedef struct ism__disc {
    ism__v3  at, g;
    float    radius2, depth, u, v;
    uint32_t triangle;
    int      capped, cut;           /* cut: off at the triangle's edges */
    float    b1, b2;                /* barycentric at `at`; in the disc's plane they grow by d1, d2 */
    ism__v3  d1, d2;
} ism__disc;

/* Returns the depth of the surfel's plane at a texel; 0 if the texel's ray does not meet the plane. */
static float ism__plane_depth(const ism__tile *tile, const float g[3], size_t i)
{
    float s = g[0] * tile->x[i] + g[1] * tile->y[i] + g[2] * tile->z[i];
    if (tile->vpl->directional) return s > 0.0f ? s : 0.0f;
    return s > 1e-20f ? 1.0f / s : 0.0f;
}

/* A disc that stands for its triangle's neighbours too is about as far off their surface as it is wide, and
   would hide that surface from the VPL: it is drawn a radius farther away, as large as before for the VPL. */
static void ism__move_away(ism__disc *s)
{
    float away = 1.0f + sqrtf(s->radius2) / s->depth;
    s->at = ism__v3_scale(s->at, away);
    s->g = ism__v3_scale(s->g, 1.0f / away);
    s->radius2 *= away * away;
    s->depth *= away;
}

/* Finds where a surfel's disc lies in the tile. Returns 0 if the VPL does not see it before itself. */
static int ism__place_surfel(const ism__tile *tile, ism__v3 p, ism__v3 normal, float area, ism__disc *s)
{
    const ism_maps *m = tile->m;
    s->radius2 = area * (1.0f / ISM__PI);
    if (tile->vpl->directional) {
        ism__v3 l = ism__to_local(&tile->frame, ism__v3_sub(p, ism__v3_load(m->center)));
        ism__v3 n = ism__to_local(&tile->frame, normal);
        float r = m->radius, slope = fabsf(n.z) > 0.05f ? 1.0f / n.z : 0.0f;
        s->depth = l.z + r;         /* the frame's z is the way that light travels */
        s->u = 0.5f * l.x / r + 0.5f;
        s->v = 0.5f * l.y / r + 0.5f;
        s->at = ism__v3_make(l.x, l.y, s->depth);
        s->g = ism__v3_make(-n.x * slope * r, -n.y * slope * r, s->depth + (n.x * l.x + n.y * l.y) * slope);
        return s->u >= 0.0f && s->v >= 0.0f && s->u < 1.0f && s->v < 1.0f;
    } else {
        ism__v3 l = ism__to_local(&tile->frame, ism__v3_sub(p, ism__v3_load(tile->vpl->position)));
        ism__v3 n = ism__to_local(&tile->frame, normal);
        float d2 = ism__v3_dot(l, l), along = ism__v3_dot(n, l), direction[3], uv[2];
        s->depth = sqrtf(d2);
        if (!(d2 > 1e-30f) || !(l.z > 1e-3f * s->depth)) return 0;
        /* The surface that the VPL lies on is no occluder in a lobe's tilted map either. */
        if (tile->projection == ISM_PROJECTION_LOBE &&
            !(fabsf(ism__v3_dot(ism__to_world(&tile->frame, l), ism__v3_load(tile->vpl->normal))) >
              1e-3f * s->depth))
            return 0;
        /* Seen from behind, a near disc most likely juts out over the edge of something thin on the surface
           that the VPL lies on: the front of a skirting board must not hide the wall that it hangs on. */
        if (s->radius2 > (along > 0.0f && !s->cut ? ISM__WIDEST_BACK : ISM__WIDEST) * d2) {
            s->radius2 = (along > 0.0f && !s->cut ? ISM__WIDEST_BACK : ISM__WIDEST) * d2;
            s->capped = 1;
        }
        ism__v3_store(direction, ism__v3_scale(l, 1.0f / s->depth));
        if (!ism_map_coordinates(tile->projection, tile->vpl->exponent, direction, uv)) return 0;
        s->at = l;
        s->u = uv[0];
        s->v = uv[1];
        /* edge-on: a plane facing the VPL instead */
        s->g = fabsf(along) > 1e-3f * s->depth ? ism__v3_scale(n, 1.0f / along) : ism__v3_scale(l, 1.0f / d2);
        if (!s->cut) ism__move_away(s);
        return 1;
    }
}

/* Writes the texels of columns box[0] to box[1] and rows box[2] to box[3] whose rays meet the disc, and
   nothing nearer. No disc is widened to a whole texel: where many small ones share it, the chance that one
   holds the centre is the share of the texel that they cover, so that over many VPLs thin things throw thin
   shadows. Eight texels at a time, for the compiler to vectorise; a row's last eight may begin before column
   box[0]. */
ISM__INLINE void ism__draw_disc(ism__tile *tile, const ism__disc *s, const uint32_t box[4], int sky)
{
    uint32_t x, y, size = tile->size, k;
    float g0 = s->g.x, g1 = s->g.y, g2 = s->g.z, ax = s->at.x, ay = s->at.y, az = s->at.z,
          radius2 = s->radius2;
    float b1 = s->b1, b1x = s->d1.x, b1y = s->d1.y;
    float b1z = s->d1.z, r = tile->m->radius;
    float b2 = s->b2, b2x = s->d2.x, b2y = s->d2.y, b2z = s->d2.z;      /* all 0 where nothing is cut:
                                                                           passes */
    for (y = box[2]; y <= box[3]; y++)
        for (x = box[0]; x <= box[1]; x += ISM__TEXELS) {
            uint32_t column = x < size - ISM__TEXELS ? x : size - ISM__TEXELS, any = 0, hit[ISM__TEXELS];
            size_t i = (size_t)y * size + column;
            const float *wx = tile->x + i, *wy = tile->y + i, *wz = tile->z + i, *nearest = tile->depth + i;
            int32_t first = (int32_t)(x - column), last = (int32_t)(box[1] - column);
            float t[ISM__TEXELS];
            for (k = 0; k < ISM__TEXELS; k++) {
                float plane = g0 * wx[k] + g1 * wy[k] + g2 * wz[k], wide, dx, dy;
                float dz, at1, at2;
                int meets = plane > (sky ? 0.0f : 1e-20f);
                float depth = sky ? plane : 1.0f / plane;
                wide = sky ? r : depth;
                dx = wx[k] * wide - ax;
                dy = wy[k] * wide - ay;
                dz = (sky ? depth : wz[k] * depth) - az;
                at1 = b1 + (dx * b1x + dy * b1y + dz * b1z);
                at2 = b2 + (dx * b2x + dy * b2y + dz * b2z);
                t[k] = depth;
                hit[k] = (uint32_t)(meets & (depth > 0.0f) & (depth < nearest[k]) &
                                    (dx * dx + dy * dy + dz * dz <= radius2) & (at1 >= -ISM__EDGE) &
                                    (at2 >= -ISM__EDGE) & (at1 + at2 <= 1.0f + ISM__EDGE) &
                                    ((int32_t)k >= first) & ((int32_t)k <= last));
            }
            for (k = 0; k < ISM__TEXELS; k++) any |= hit[k];
            for (k = 0; any && k < ISM__TEXELS; k++)
                if (hit[k]) {
                    ism__texel *to = &tile->texels[i + k];
                    ism__v3_store(to->g, s->g);
                    to->triangle = s->triangle;
                    tile->depth[i + k] = t[k];
                }
        }
}

#define ISM__DRAWS(name, target)                                                                             \
    target ISM__HOT static void name(ism__tile *tile, const ism__disc *s, const uint32_t box[4])           \
    {                                                                                                        \
        ism__draw_disc(tile, s, box, 0);                                                                     \
    }                                                                                                        \
    target ISM__HOT static void name##_sky(ism__tile *tile, const ism__disc *s, const uint32_t box[4])     \
    {                                                                                                        \
        ism__draw_disc(tile, s, box, 1);                                                                     \
    }

#define ISM__ANY_TARGET
ISM__DRAWS(ism__draw_plain, ISM__ANY_TARGET)
#if ISM__X86
ISM__DRAWS(ism__draw_avx2, ISM__TARGET_AVX2)
#endif

static void ism__choose_draw(ism__tile *tile)
{
    tile->draw = tile->vpl->directional ? ism__draw_plain_sky : ism__draw_plain;
#if ISM__X86
    if (ism__cpu_has_avx2()) tile->draw = tile->vpl->directional ? ism__draw_avx2_sky : ism__draw_avx2;
#endif
}

/* Returns how many texels a unit of angle (of a sky: of world space) spans at most, in either direction of
   the square, without a window. */
static float ism__texels_per_unit(const ism__tile *tile)
{
    float size = (float)tile->size;
    if (tile->vpl->directional) return 0.5f * size / tile->m->radius;
    if (tile->projection == ISM_PROJECTION_PARABOLOID) return 0.5f * size;
    if (tile->projection == ISM_PROJECTION_LOBE)
        return 0.9f * size * sqrtf(0.5f * (tile->vpl->exponent + 1.0f));
    return 0.9f * size;
}

static void ism__splat(ism__tile *tile, const ism__disc *s)
{
    float reach = sqrtf(s->radius2) * ism__texels_per_unit(tile) / (tile->vpl->directional ? 1.0f : s->depth);
    float most = (float)tile->size;
    uint32_t box[4];
    tile->splats++;
    if (!(reach > 0.0f)) return;
    if (!(reach < most)) reach = most;
    tile->wide += (uint64_t)s->capped;
    /* the map is continuous but across its diagonals near the border, where a disc is cut off */
    ism__span(&tile->window->u, s->u, reach, tile->size, &box[0], &box[1]);
    ism__span(&tile->window->v, s->v, reach, tile->size, &box[2], &box[3]);
    tile->draw(tile, s, box);
}

/* Prepares a disc to be cut off at its triangle's edges. Points that stand for less than their triangle are
   cut, and may be large: so a wall has neither gaps nor discs that jut out over its end. A point that stands
   for neighbouring triangles too remains a disc. */
static void ism__cut(const ism__tile *tile, ism__v3 e1, ism__v3 e2, ism__v3 n, float b1, float b2,
                     ism__disc *s)
{
    float inverse = 1.0f / ism__v3_dot(n, n);
    s->cut = 1;
    s->b1 = b1;
    s->b2 = b2;
    s->d1 = ism__to_local(&tile->frame, ism__v3_scale(ism__v3_cross(e2, n), inverse));
    s->d2 = ism__to_local(&tile->frame, ism__v3_scale(ism__v3_cross(n, e1), inverse));
}

/* Asks for the memory from which the points one block and two blocks ahead are read. Points lie in the mesh's
   order, but far apart. */
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

static void ism__draw_points(ism__tile *tile, const ism__surfel *points, uint32_t count, uint32_t number)
{
    const ism_mesh *mesh = tile->mesh;
    float scale = tile->m->desc.splat_scale;
    uint32_t j, column = number % tile->m->tiles, row = number / tile->m->tiles;
    for (j = 0; j < count; j++) {
        uint32_t t = points[j].triangle;
        float b1 = (float)points[j].b1 * (1.0f / 65535.0f), b2 = (float)points[j].b2 * (1.0f / 65535.0f),
              length, area;
        ism__v3 p[3], e1, e2, n;
        ism__disc s;
        ism__read_ahead(mesh, points, count, j);
        /* dithered over 2 x 2 tiles, not texels: pull and push would close the gaps that dithering leaves */
        if (mesh->opacities && !ism__dither(column, row, mesh->opacities[t])) continue;
        ism__corners(mesh, t, p);
        e1 = ism__v3_sub(p[1], p[0]);
        e2 = ism__v3_sub(p[2], p[0]);
        n = ism__v3_cross(e1, e2);
        length = ism__v3_length(n);
        if (!(length > 0.0f) || !ism__finite(length)) continue;
        p[0] = ism__v3_madd(ism__v3_madd(p[0], e1, b1), e2, b2);
        memset(&s, 0, sizeof s);
        s.triangle = t;
        area = scale * points[j].weight * 0.5f * length;
        if (points[j].weight < 1.0f) {
            ism__cut(tile, e1, e2, n, b1, b2, &s);
            area *= ISM__CUT_SCALE;
        }
        if (ism__place_surfel(tile, p[0], ism__v3_scale(n, 1.0f / length), area, &s))
            ism__splat(tile, &s);
    }
}
