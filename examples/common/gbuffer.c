/* gbuffer.c - primary visibility: a tiled, multi-threaded rasteriser of homogeneous edge functions.

   With the eye at the origin and a ray d = (x, y, -1) through a pixel's centre, the triangle (a, b, c) is hit where the
   three volumes d.(b x c), d.(c x a), d.(a x b) have one sign (Olano and Greer, "Triangle scan conversion using 2D
   homogeneous coordinates", 1997). They are linear in x and y, their sum over a.(b x c) is 1 / depth, and their shares
   are the barycentric weights on the triangle itself: nothing is clipped and nothing needs perspective correction.
   Neighbours compute a shared edge from the same two corners, so its function differs in sign only, and a pixel centre
   exactly on it goes to the one side that a fixed rule names: no cracks, no pixel twice.

   1. every vertex into camera space           parallel over objects' vertices
   2. triangles that may touch a pixel centre   parallel over chunks; each keeps its own list
   3. lists per tile                            a counting sort, in order: the same on any number of threads
   4. tiles: nearest triangle, then attributes  parallel over tiles */
#include "internal.h"
#include <stdlib.h>
#include <string.h>

enum { TILE = 32, CHUNK = 16384, CLUSTER = 64, MAX_SIDE = 32768 };

typedef struct candidate { uint32_t object, triangle; uint16_t x0, y0, x1, y1; } candidate;   /* inclusive box */
typedef struct chunk { uint32_t object, first, count; candidate *found; uint32_t found_count; } chunk;

struct ex_clusters {
    v3     *boxes;                             /* low and high corner of CLUSTER triangles each, in world space */
    size_t *first;                             /* of each object */
    float   center[3], radius;                 /* of the scene */
};

typedef struct raster {
    const ex_scene *scene;
    ex_gbuffer     *out;
    v3              eye, axes[3];              /* right, up, back; it looks along -back */
    v3              from, to_from;             /* places count from here: the eye or, where that is far off, the scene's
                                                  middle; and where that is in camera space */
    double          step_x, step_y, x0, y0;    /* ray of pixel (i, j): (x0 + i step_x, y0 + j step_y, -1) */
    float           near_depth;
    v3            **vertices;                  /* camera space, an array for each object; NULL with clusters */
    const ex_clusters *clusters;               /* or NULL */
    chunk          *chunks;
    uint32_t        chunk_count, tiles_x, tiles_y;
    candidate      *sorted;
    size_t         *tile_start;                /* tiles + 1 */
    size_t         *tile_entries;              /* indices into sorted, tile by tile */
    size_t          sorted_count;
} raster;

/* ---- surface colour ---- */

/* Bilinear and repeating; the texels are made linear before they are mixed. */
static void sample_texture(const ex_texture *texture, float u, float v, float rgba[4])
{
    float x = (u - floorf(u)) * (float)texture->width - 0.5f, y = (v - floorf(v)) * (float)texture->height - 0.5f;
    float x_floor = floorf(x), y_floor = floorf(y);
    float fx = x - x_floor, fy = y - y_floor;
    for (int k = 0; k < 4; k++) rgba[k] = 0;
    for (int corner = 0; corner < 4; corner++) {
        int right = corner & 1, down = corner >> 1;
        uint32_t tx = (uint32_t)((int64_t)x_floor + right + (int64_t)texture->width) % texture->width;
        uint32_t ty = (uint32_t)((int64_t)y_floor + down + (int64_t)texture->height) % texture->height;
        const uint8_t *texel = texture->rgba + 4 * ((size_t)ty * texture->width + tx);
        float weight = (right ? fx : 1 - fx) * (down ? fy : 1 - fy);
        if (weight == 0) continue;
        for (int k = 0; k < 3; k++) rgba[k] += weight * ex_srgb_to_linear((float)texel[k] / 255);
        rgba[3] += weight * (float)texel[3] / 255;
    }
}

int ex_surface_color(const ex_scene *scene, const ex_object *object, uint32_t triangle, const float barycentric[3],
                     float albedo[3])
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    const ex_material *material = &scene->materials[ex_object_material(scene, object, triangle)];
    memcpy(albedo, material->base_color, 3 * sizeof(float));
    if (material->base_texture < 0 || !mesh->uvs) return 1;
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    float uv[2] = {0, 0}, rgba[4];
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 2; c++) uv[c] += barycentric[k] * mesh->uvs[2 * (size_t)index[k] + (size_t)c];
    sample_texture(&scene->textures[material->base_texture], uv[0], uv[1], rgba);
    for (int k = 0; k < 3; k++) albedo[k] *= rgba[k];
    return !(rgba[3] < material->alpha_cutoff);
}

/* ---- 1. vertices ---- */

static v3 to_camera(const raster *r, v3 world)
{
    v3 p = v3_sub(world, r->from);
    return v3_make(v3_dot(p, r->axes[0]) + r->to_from.x, v3_dot(p, r->axes[1]) + r->to_from.y,
                   v3_dot(p, r->axes[2]) + r->to_from.z);
}

static v3 transform_vertex(const raster *r, uint32_t i, size_t k)
{
    const ex_object *object = &r->scene->objects[i];
    return to_camera(r, ex_transform_point(object->transform,
                                           v3_load(r->scene->meshes[object->mesh].positions + 3 * k)));
}

static void transform_object(void *context, size_t i)
{
    raster *r = (raster *)context;
    const ex_mesh *mesh = &r->scene->meshes[r->scene->objects[i].mesh];
    for (size_t k = 0; k < mesh->vertex_count; k++) r->vertices[i][k] = transform_vertex(r, (uint32_t)i, k);
}

static v3 vertex(const raster *r, uint32_t object, uint32_t index)
{
    return r->vertices ? r->vertices[object][index] : transform_vertex(r, object, index);
}

/* ---- clusters ---- */

static void box_cluster(const ex_scene *scene, const ex_object *object, uint32_t first, v3 box[2])
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    uint32_t end = first + CLUSTER < mesh->triangle_count ? first + CLUSTER : mesh->triangle_count;
    box[0] = v3_make(HUGE_VALF, HUGE_VALF, HUGE_VALF);
    box[1] = v3_scale(box[0], -1);
    for (size_t k = 3 * (size_t)first; k < 3 * (size_t)end; k++) {
        v3 p = ex_transform_point(object->transform, v3_load(mesh->positions + 3 * (size_t)mesh->indices[k]));
        box[0] = v3_make(fminf(box[0].x, p.x), fminf(box[0].y, p.y), fminf(box[0].z, p.z));
        box[1] = v3_make(fmaxf(box[1].x, p.x), fmaxf(box[1].y, p.y), fmaxf(box[1].z, p.z));
    }
}

ex_clusters *ex_clusters_build(const ex_scene *scene)
{
    ex_clusters *c = (ex_clusters *)calloc(1, sizeof *c);
    size_t count = 0;
    if (!c) return NULL;
    ex_scene_bounds(scene, c->center, &c->radius);
    c->first = (size_t *)malloc((scene->object_count + (size_t)1) * sizeof *c->first);
    for (uint32_t i = 0; c->first && i < scene->object_count; i++) {
        c->first[i] = count;
        count += (scene->meshes[scene->objects[i].mesh].triangle_count + CLUSTER - 1) / CLUSTER;
    }
    c->boxes = (v3 *)malloc((2 * count + 1) * sizeof *c->boxes);
    if (!c->first || !c->boxes) {
        ex_clusters_free(c);
        return NULL;
    }
    for (uint32_t i = 0; i < scene->object_count; i++) {
        uint32_t triangles = scene->meshes[scene->objects[i].mesh].triangle_count;
        for (uint32_t t = 0; t < triangles; t += CLUSTER)
            box_cluster(scene, &scene->objects[i], t, c->boxes + 2 * (c->first[i] + t / CLUSTER));
    }
    return c;
}

void ex_clusters_free(ex_clusters *c)
{
    if (!c) return;
    free(c->boxes);
    free(c->first);
    free(c);
}

/* ---- 2. candidates ---- */

/* Grows a box of picture coordinates by the projection of a point in front of the near plane. */
static void grow_box(const raster *r, double box[4], double x, double y, double z)
{
    double px = (x / -z - r->x0) / r->step_x, py = (y / -z - r->y0) / r->step_y;
    if (px < box[0]) box[0] = px;
    if (py < box[1]) box[1] = py;
    if (px > box[2]) box[2] = px;
    if (py > box[3]) box[3] = py;
}

/* Box of the part that lies before the near plane, in pixels with centres at whole numbers. */
static void project_box(const raster *r, const v3 p[3], double box[4])
{
    double near_z = -(double)r->near_depth;
    box[0] = box[1] = 1e30;
    box[2] = box[3] = -1e30;
    for (int k = 0; k < 3; k++) {
        v3 a = p[k], b = p[(k + 1) % 3];
        double az = (double)a.z, bz = (double)b.z;
        if (az <= near_z) grow_box(r, box, (double)a.x, (double)a.y, az);
        if ((az <= near_z) == (bz <= near_z)) continue;
        double t = (near_z - az) / (bz - az);
        grow_box(r, box, (double)a.x + t * ((double)b.x - (double)a.x), (double)a.y + t * ((double)b.y - (double)a.y),
                 near_z);
    }
}

/* A hair wider than the exact box: its rounding must never cost a pixel, the edge functions decide. */
static int pixel_range(double low, double high, uint32_t size, uint16_t *first, uint16_t *last)
{
    low = ceil(low - 1e-6 * (1 + fabs(low)));
    high = floor(high + 1e-6 * (1 + fabs(high)));
    if (low < 0) low = 0;
    if (high > (double)size - 1) high = (double)size - 1;
    if (!(low <= high)) return 0;
    *first = (uint16_t)low;
    *last = (uint16_t)high;
    return 1;
}

/* 0: no pixel's centre can see a triangle of the cluster. The box is widened by what rounding moves its vertices, and a
   hundredth of a pixel besides. */
static int may_show(const raster *r, uint32_t object, uint32_t triangle)
{
    const v3 *corner = r->clusters->boxes + 2 * (r->clusters->first[object] + triangle / CLUSTER);
    double near_z = -(double)r->near_depth, box[4] = {1e30, 1e30, -1e30, -1e30};
    float size = v3_length(r->eye) + v3_length(corner[0]) + v3_length(corner[1]), wide = 1e-6f * size;
    int behind = 0;
    for (int k = 0; k < 8; k++) {
        v3 p = v3_make(corner[k & 1].x + (k & 1 ? wide : -wide), corner[k >> 1 & 1].y + (k & 2 ? wide : -wide),
                       corner[k >> 2].z + (k & 4 ? wide : -wide));
        p = to_camera(r, p);
        if ((double)p.z + (double)wide > near_z) behind++;
        else grow_box(r, box, (double)p.x, (double)p.y, (double)p.z);
    }
    if (behind == 8) return 0;
    if (behind) return 1;
    return ceil(box[0] - 0.01) <= floor(box[2] + 0.01) && ceil(box[1] - 0.01) <= floor(box[3] + 0.01) &&
           box[2] > -0.01 && box[3] > -0.01 && box[0] < (double)r->out->width - 0.99 &&
           box[1] < (double)r->out->height - 0.99;
}

static void find_candidates(void *context, size_t i)
{
    raster *r = (raster *)context;
    chunk *c = &r->chunks[i];
    const ex_mesh *mesh = &r->scene->meshes[r->scene->objects[c->object].mesh];
    candidate *found = (candidate *)malloc(c->count * sizeof *found);
    if (!found) return;                          /* bin_candidates sees it */
    for (uint32_t t = c->first; t < c->first + c->count; t++) {
        const uint32_t *index = mesh->indices + 3 * (size_t)t;
        v3 p[3];
        double box[4];
        candidate *to = &found[c->found_count];
        if (r->clusters && t % CLUSTER == 0 && !may_show(r, c->object, t)) {
            t += CLUSTER - 1;                    /* chunks are whole clusters */
            continue;
        }
        for (int k = 0; k < 3; k++) p[k] = vertex(r, c->object, index[k]);
        project_box(r, p, box);
        if (!pixel_range(box[0], box[2], r->out->width, &to->x0, &to->x1)) continue;
        if (!pixel_range(box[1], box[3], r->out->height, &to->y0, &to->y1)) continue;
        to->object = c->object;
        to->triangle = t;
        c->found_count++;
    }
    candidate *fitted = (candidate *)realloc(found, (c->found_count ? c->found_count : 1) * sizeof *found);
    c->found = fitted ? fitted : found;
}

/* ---- 3. tiles ---- */

static int bin_candidates(raster *r)
{
    size_t tiles = (size_t)r->tiles_x * r->tiles_y, at = 0;
    for (uint32_t i = 0; i < r->chunk_count; i++) {
        if (!r->chunks[i].found) return -1;
        r->sorted_count += r->chunks[i].found_count;
    }
    r->sorted = (candidate *)malloc((r->sorted_count + 1) * sizeof *r->sorted);
    r->tile_start = (size_t *)calloc(tiles + 2, sizeof *r->tile_start);
    if (!r->sorted || !r->tile_start) return -1;
    for (uint32_t i = 0; i < r->chunk_count; i++) {
        const chunk *c = &r->chunks[i];
        if (c->found_count) memcpy(r->sorted + at, c->found, c->found_count * sizeof *c->found);
        at += c->found_count;
    }
    /* tile_start runs one slot ahead while it is filled, so that it ends as the starts themselves. */
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < r->sorted_count; i++) {
            const candidate *c = &r->sorted[i];
            for (uint32_t y = c->y0 / TILE; y <= c->y1 / TILE; y++)
                for (uint32_t x = c->x0 / TILE; x <= c->x1 / TILE; x++) {
                    size_t tile = (size_t)y * r->tiles_x + x;
                    if (pass == 0)
                        r->tile_start[tile + 2]++;
                    else
                        r->tile_entries[r->tile_start[tile + 1]++] = i;
                }
        }
        if (pass == 1) break;
        for (size_t i = 1; i <= tiles; i++) r->tile_start[i + 1] += r->tile_start[i];
        r->tile_entries = (size_t *)malloc((r->tile_start[tiles + 1] + 1) * sizeof *r->tile_entries);
        if (!r->tile_entries) return -1;
    }
    return 0;
}

/* ---- 4. one tile ---- */

typedef struct edges { double a[3], b[3], c[3], determinant; } edges;   /* edge k at ray (x, y): a x + b y - c */

/* Exact products of floats in double, each difference rounded once. Oriented so that inside is positive. Returns 0 for
   triangles seen edge-on. */
static int set_up_edges(const v3 p[3], edges *e)
{
    for (int k = 0; k < 3; k++) {
        v3 u = p[(k + 1) % 3], v = p[(k + 2) % 3];
        e->a[k] = (double)u.y * (double)v.z - (double)u.z * (double)v.y;
        e->b[k] = (double)u.z * (double)v.x - (double)u.x * (double)v.z;
        e->c[k] = (double)u.x * (double)v.y - (double)u.y * (double)v.x;
    }
    e->determinant = (double)p[0].x * e->a[0] + (double)p[0].y * e->b[0] + (double)p[0].z * e->c[0];
    /* A ray looks along -z: for a triangle before the eye the edge functions have the sign of the determinant. */
    if (e->determinant < 0)
        for (int k = 0; k < 3; k++) { e->a[k] = -e->a[k]; e->b[k] = -e->b[k]; e->c[k] = -e->c[k]; }
    e->determinant = fabs(e->determinant);
    return e->determinant > 0;
}

static int owns_zero(const edges *e, int k) { return e->a[k] > 0 || (e->a[k] == 0 && e->b[k] > 0); }

/* Edge functions of one triangle at a ray; returns 1 inside. */
static int inside_edges(const edges *e, const int owned[3], double x, double y, double w[3])
{
    for (int k = 0; k < 3; k++) {
        w[k] = e->a[k] * x + e->b[k] * y - e->c[k];
        if (!(w[k] > 0 || (w[k] == 0 && owned[k]))) return 0;
    }
    return 1;
}

static int is_hole(const raster *r, const candidate *c, const double w[3])
{
    const ex_object *object = &r->scene->objects[c->object];
    const ex_material *material = &r->scene->materials[ex_object_material(r->scene, object, c->triangle)];
    if (!(material->alpha_cutoff > 0) || material->base_texture < 0) return 0;
    double sum = w[0] + w[1] + w[2];
    float barycentric[3] = {(float)(w[0] / sum), (float)(w[1] / sum), (float)(w[2] / sum)}, albedo[3];
    return !ex_surface_color(r->scene, object, c->triangle, barycentric, albedo);
}

static void corners_of(const raster *r, const candidate *c, v3 p[3])
{
    const ex_mesh *mesh = &r->scene->meshes[r->scene->objects[c->object].mesh];
    const uint32_t *index = mesh->indices + 3 * (size_t)c->triangle;
    for (int k = 0; k < 3; k++) p[k] = vertex(r, c->object, index[k]);
}

/* nearest: 1 / depth of the nearest triangle so far; winner: its candidate. */
static void draw(const raster *r, size_t id, const uint32_t box[4], double nearest[TILE][TILE],
                 size_t winner[TILE][TILE])
{
    const candidate *c = &r->sorted[id];
    v3 p[3];
    edges e;
    double w[3], max_inverse = 1 / (double)r->near_depth;
    corners_of(r, c, p);
    if (!set_up_edges(p, &e)) return;
    int owned[3] = {owns_zero(&e, 0), owns_zero(&e, 1), owns_zero(&e, 2)};
    uint32_t x0 = c->x0 > box[0] ? c->x0 : box[0], x1 = c->x1 < box[2] ? c->x1 : box[2];
    uint32_t y0 = c->y0 > box[1] ? c->y0 : box[1], y1 = c->y1 < box[3] ? c->y1 : box[3];
    for (uint32_t y = y0; y <= y1; y++)
        for (uint32_t x = x0; x <= x1; x++) {
            if (!inside_edges(&e, owned, r->x0 + x * r->step_x, r->y0 + y * r->step_y, w)) continue;
            double inverse = (w[0] + w[1] + w[2]) / e.determinant;
            uint32_t i = x - box[0], j = y - box[1];
            if (!(inverse > nearest[j][i] && inverse <= max_inverse) || is_hole(r, c, w)) continue;
            nearest[j][i] = inverse;
            winner[j][i] = id;
        }
}

/* Brings the shading normal n to the side of the geometric normal g, and off the far side of the silhouette: where it
   still points away from the viewer, it is bent until it is just perpendicular to the view. */
static v3 face_viewer(v3 n, v3 g, v3 view)
{
    if (v3_dot(n, g) < 0) n = v3_scale(n, -1);
    float away = v3_dot(n, view);
    return away < 1e-3f ? v3_unit_or(v3_mad(n, view, 1e-3f - away), g) : n;
}

static void shade_pixel(const raster *r, size_t id, uint32_t x, uint32_t y, ex_pixel *out)
{
    const candidate *c = &r->sorted[id];
    const ex_object *object = &r->scene->objects[c->object];
    const ex_mesh *mesh = &r->scene->meshes[object->mesh];
    const ex_material *material = &r->scene->materials[ex_object_material(r->scene, object, c->triangle)];
    const uint32_t *index = mesh->indices + 3 * (size_t)c->triangle;
    double w[3], sum = 0;
    float barycentric[3];
    v3 p[3], q[3], position = v3_make(0, 0, 0), normal = position;
    edges e;
    corners_of(r, c, p);
    set_up_edges(p, &e);
    for (int k = 0; k < 3; k++) {
        w[k] = e.a[k] * (r->x0 + x * r->step_x) + e.b[k] * (r->y0 + y * r->step_y) - e.c[k];
        sum += w[k];
    }
    /* Place and face normal by the object's own corners: camera space has lost digits of them. */
    for (int k = 0; k < 3; k++) {
        barycentric[k] = (float)(w[k] / sum);
        q[k] = v3_load(mesh->positions + 3 * (size_t)index[k]);
        position = v3_mad(position, ex_transform_point(object->transform, q[k]), barycentric[k]);
        normal = v3_mad(normal, v3_load(mesh->normals + 3 * (size_t)index[k]), barycentric[k]);
    }
    v3 view = v3_unit(v3_sub(r->eye, position));
    v3 front = ex_transform_normal(object->transform, v3_unit(v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]))));
    front = v3_unit_or(front, view);
    if (ex_determinant(object->transform) < 0) { front = v3_scale(front, -1); normal = v3_scale(normal, -1); }
    int from_behind = v3_dot(front, view) < 0;
    v3 geometric = from_behind ? v3_scale(front, -1) : front;
    normal = v3_unit_or(ex_transform_normal(object->transform, normal), geometric);
    v3_store(out->position, position);
    v3_store(out->view, view);
    v3_store(out->geometric, geometric);
    v3_store(out->normal, face_viewer(normal, geometric, view));
    ex_surface_color(r->scene, object, c->triangle, barycentric, out->albedo);
    if (!from_behind || material->double_sided) memcpy(out->emission, material->emission, sizeof out->emission);
    out->metallic = material->metallic;
    out->roughness = material->roughness;
    out->object = c->object;
}

static void render_tile(void *context, size_t tile)
{
    const raster *r = (const raster *)context;
    double nearest[TILE][TILE];
    size_t winner[TILE][TILE];
    uint32_t x = (uint32_t)(tile % r->tiles_x) * TILE, y = (uint32_t)(tile / r->tiles_x) * TILE;
    uint32_t box[4] = {x, y, x + TILE - 1, y + TILE - 1};
    if (box[2] >= r->out->width) box[2] = r->out->width - 1;
    if (box[3] >= r->out->height) box[3] = r->out->height - 1;
    memset(nearest, 0, sizeof nearest);
    for (size_t i = r->tile_start[tile]; i < r->tile_start[tile + 1]; i++)
        draw(r, r->tile_entries[i], box, nearest, winner);
    for (uint32_t j = 0; j + box[1] <= box[3]; j++)
        for (uint32_t i = 0; i + box[0] <= box[2]; i++) {
            ex_pixel *out = &r->out->pixels[(size_t)(box[1] + j) * r->out->width + box[0] + i];
            if (nearest[j][i] > 0)
                shade_pixel(r, winner[j][i], box[0] + i, box[1] + j, out);
            else
                out->object = UINT32_MAX;
        }
}

/* ---- set-up and clean-up ---- */

/* Its length before; 0 and no change where that is no number. */
static double unit3(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0 && length < HUGE_VAL)) return 0;
    for (int k = 0; k < 3; k++) v[k] /= length;
    return length;
}

static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross3(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* From a sun's eye, a thousand radii away, rounding would move corners by 6e-5 of the radius. */
static int set_up_camera(raster *r, const float center[3], float scene_radius)
{
    const ex_camera *camera = &r->scene->camera;
    double width = r->out->width, height = r->out->height, half = tan(0.5 * (double)camera->fovy);
    if (!(camera->fovy > 0) || !(camera->fovy < EX_PI) || !v3_finite(v3_load(camera->eye))) return -1;
    r->eye = v3_load(camera->eye);
    double right[3], up[3], back[3], roll[3], way[3] = {0, 0, 0}, distance = 0;
    for (int k = 0; k < 3; k++) {
        back[k] = (double)camera->eye[k] - (double)camera->target[k];
        roll[k] = (double)camera->up[k];
    }
    if (!(unit3(back) > 0)) return -1;
    double other[3] = {0, fabs(back[1]) < 0.9 ? 1 : 0, fabs(back[1]) < 0.9 ? 0 : -1};
    cross3(right, unit3(roll) > 0 ? roll : other, back);
    if (!(unit3(right) > 1e-6)) {              /* up along the view: any will do */
        cross3(right, other, back);
        unit3(right);
    }
    cross3(up, back, right);
    for (int k = 0; k < 3; k++) {
        way[k] = (double)center[k] - (double)camera->eye[k];
        distance += way[k] * way[k];
    }
    int far = distance > 64 * (double)scene_radius * (double)scene_radius;
    r->from = far ? v3_load(center) : r->eye;
    r->to_from = v3_make(0, 0, 0);
    if (far) r->to_from = v3_make((float)dot3(way, right), (float)dot3(way, up), (float)dot3(way, back));
    r->axes[0] = v3_make((float)right[0], (float)right[1], (float)right[2]);
    r->axes[1] = v3_make((float)up[0], (float)up[1], (float)up[2]);
    r->axes[2] = v3_make((float)back[0], (float)back[1], (float)back[2]);
    r->step_y = -2 * half / height;
    r->step_x = 2 * half / height;
    r->x0 = -half * width / height + 0.5 * r->step_x;
    r->y0 = half + 0.5 * r->step_y;
    r->near_depth = 1e-5f * (scene_radius > 0 ? scene_radius : 1);
    return 0;
}

static int allocate(raster *r)
{
    const ex_scene *scene = r->scene;
    if (!r->clusters) {
        r->vertices = (v3 **)calloc(scene->object_count ? scene->object_count : 1, sizeof *r->vertices);
        if (!r->vertices) return -1;
    }
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_mesh *mesh = &scene->meshes[scene->objects[i].mesh];
        if (r->vertices && !(r->vertices[i] = (v3 *)malloc((mesh->vertex_count + (size_t)1) * sizeof(v3)))) return -1;
        for (uint32_t first = 0; first < mesh->triangle_count; first += CHUNK) {
            uint32_t left = mesh->triangle_count - first;
            if (ex_grow(&r->chunks, &r->chunk_count, sizeof *r->chunks) != 0) return -1;
            chunk *c = &r->chunks[r->chunk_count - 1];
            c->object = i;
            c->first = first;
            c->count = left < CHUNK ? left : CHUNK;
        }
    }
    return 0;
}

static void release(raster *r)
{
    for (uint32_t i = 0; r->vertices && i < r->scene->object_count; i++) free(r->vertices[i]);
    for (uint32_t i = 0; i < r->chunk_count; i++) free(r->chunks[i].found);
    free(r->vertices);
    free(r->chunks);
    free(r->sorted);
    free(r->tile_start);
    free(r->tile_entries);
}

static int render_all(raster *r, int threads)
{
    ex_pool *pool = ex_pool_create(threads);
    if (allocate(r) != 0) { ex_pool_free(pool); return -1; }
    if (r->vertices) ex_pool_run(pool, r->scene->object_count, transform_object, r);
    ex_pool_run(pool, r->chunk_count, find_candidates, r);
    if (bin_candidates(r) != 0) { ex_pool_free(pool); return -1; }
    ex_pool_run(pool, (size_t)r->tiles_x * r->tiles_y, render_tile, r);
    ex_pool_free(pool);
    return 0;
}

static int render_by(ex_gbuffer *out, const ex_scene *scene, const ex_clusters *clusters, uint32_t width,
                     uint32_t height, uint32_t aa, int threads, char *error)
{
    raster r;
    float center[3] = {0, 0, 0}, radius = 0;
    memset(out, 0, sizeof *out);
    memset(&r, 0, sizeof r);
    if (aa == 0 || width == 0 || height == 0 || width > MAX_SIDE / aa || height > MAX_SIDE / aa)
        return ex_fail(error, "picture of %u x %u pixels with aa=%u: each side may have 1 to %d samples",
                       (unsigned)width, (unsigned)height, (unsigned)aa, MAX_SIDE);
    out->width = width * aa;
    out->height = height * aa;
    out->pixels = (ex_pixel *)calloc((size_t)out->width * out->height, sizeof *out->pixels);
    r.scene = scene;
    r.clusters = clusters;
    r.out = out;
    r.tiles_x = (out->width + TILE - 1) / TILE;
    r.tiles_y = (out->height + TILE - 1) / TILE;
    if (clusters) {
        memcpy(center, clusters->center, sizeof center);
        radius = clusters->radius;
    } else ex_scene_bounds(scene, center, &radius);
    if (set_up_camera(&r, center, radius) != 0) {
        ex_gbuffer_free(out);
        return ex_fail(error, "camera: eye and target must be finite and apart, the field of view between 0 and 180");
    }
    int result = out->pixels ? render_all(&r, threads) : -1;
    release(&r);
    if (result == 0) return 0;
    ex_gbuffer_free(out);
    return ex_fail(error, "out of memory for %u x %u samples", (unsigned)(width * aa), (unsigned)(height * aa));
}

int ex_gbuffer_render(ex_gbuffer *out, const ex_scene *scene, uint32_t width, uint32_t height, uint32_t aa,
                      int threads, char *error)
{
    return render_by(out, scene, NULL, width, height, aa, threads, error);
}

int ex_gbuffer_render_clusters(ex_gbuffer *out, const ex_scene *scene, const ex_clusters *clusters, uint32_t width,
                               uint32_t height, int threads, char *error)
{
    return render_by(out, scene, clusters, width, height, 1, threads, error);
}

void ex_gbuffer_free(ex_gbuffer *g)
{
    free(g->pixels);
    memset(g, 0, sizeof *g);
}
