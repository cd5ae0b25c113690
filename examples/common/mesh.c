/* mesh.c - the mesh builder and the few matrices that scenes need. */
#include "internal.h"
#include "gltf.h"
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- affine matrices, column-major ---- */

v3 ex_transform_point(const float m[16], v3 p)
{
    return v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                   m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

v3 ex_transform_vector(const float m[16], v3 p)
{
    return v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z, m[1] * p.x + m[5] * p.y + m[9] * p.z,
                   m[2] * p.x + m[6] * p.y + m[10] * p.z);
}

/* The cofactors are the inverse transpose times the determinant: no division, so flattened objects work too. Under a
   mirroring transform they turn a vector round, just as the winding of the mirrored triangles does. */
v3 ex_transform_normal(const float m[16], v3 n)
{
    v3 x = v3_load(m), y = v3_load(m + 4), z = v3_load(m + 8);
    return v3_add(v3_add(v3_scale(v3_cross(y, z), n.x), v3_scale(v3_cross(z, x), n.y)), v3_scale(v3_cross(x, y), n.z));
}

float ex_determinant(const float m[16]) { return v3_dot(v3_load(m), v3_cross(v3_load(m + 4), v3_load(m + 8))); }

void ex_identity(float m[16])
{
    for (int i = 0; i < 16; i++) m[i] = i % 5 == 0 ? 1.0f : 0.0f;
}

void ex_multiply(float out[16], const float a[16], const float b[16])
{
    float r[16];
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0;
            for (int k = 0; k < 4; k++) sum += (double)a[4 * k + row] * (double)b[4 * column + k];
            r[4 * column + row] = (float)sum;
        }
    memcpy(out, r, sizeof r);
}

void ex_place(float m[16], v3 position, float yaw, float scale)
{
    float c = scale * cosf(yaw), s = scale * sinf(yaw);
    ex_identity(m);
    m[0] = c;  m[2] = -s;
    m[5] = scale;
    m[8] = s;  m[10] = c;
    v3_store(m + 12, position);
}

/* ---- errors and arrays ---- */

void ex_one_line(char *error)
{
    error[strcspn(error, "\r\n")] = 0;          /* of a parser's many lines the first says what is wrong */
    for (; *error; error++)                     /* names in files must not talk to a terminal */
        if ((unsigned char)*error < 32 || *error == 127) *error = '?';
}

int ex_fail(char *error, const char *format, ...)
{
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(error, EX_ERROR_SIZE, format, arguments);
        va_end(arguments);
        ex_one_line(error);
    }
    return -1;
}

int ex_grow(void *array, uint32_t *count, size_t item_size)
{
    void *old, *bigger;
    memcpy(&old, array, sizeof old);
    bigger = *count < 0x7fffffff ? realloc(old, (*count + (size_t)1) * item_size) : NULL;
    if (!bigger) return -1;
    memset((char *)bigger + *count * item_size, 0, item_size);
    memcpy(array, &bigger, sizeof bigger);
    (*count)++;
    return 0;
}

void ex_mesh_free(ex_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uvs);
    free(mesh->indices);
    free(mesh->materials);
    free(mesh->parts);
    memset(mesh, 0, sizeof *mesh);
}

/* ---- the builder ---- */

ex_builder ex_build_begin(ex_scene *scene)
{
    ex_builder b;
    memset(&b, 0, sizeof b);
    b.scene = scene;
    return b;
}

uint32_t ex_build_material(ex_builder *b, float red, float green, float blue)
{
    ex_scene *s = b->scene;
    if (b->failed || ex_grow(&s->materials, &s->material_count, sizeof *s->materials) != 0) {
        b->failed = 1;
        return 0;
    }
    ex_material *m = &s->materials[s->material_count - 1];
    m->base_color[0] = red;
    m->base_color[1] = green;
    m->base_color[2] = blue;
    m->roughness = 1;
    m->base_texture = m->normal_texture = m->rough_texture = -1;
    return s->material_count - 1;
}

static int reserve(void *array, size_t room, size_t item_size)
{
    void *old, *bigger;
    memcpy(&old, array, sizeof old);
    bigger = realloc(old, room * item_size);
    if (bigger) memcpy(array, &bigger, sizeof bigger);
    return bigger ? 0 : -1;
}

uint32_t ex_build_vertex(ex_builder *b, v3 position, v3 normal)
{
    ex_mesh *m = &b->mesh;
    if (m->vertex_count == b->vertex_room && !b->failed) {
        size_t room = b->vertex_room ? 2 * b->vertex_room : 1024;
        b->failed = reserve(&m->positions, room, 3 * sizeof(float)) || reserve(&m->normals, room, 3 * sizeof(float)) ||
                    (b->with_uvs && reserve(&m->uvs, room, 2 * sizeof(float)));
        if (!b->failed) b->vertex_room = room;
    }
    if (b->failed) return 0;
    if (b->with_uvs) memset(m->uvs + 2 * (size_t)m->vertex_count, 0, 2 * sizeof(float));
    v3_store(m->positions + 3 * (size_t)m->vertex_count, position);
    v3_store(m->normals + 3 * (size_t)m->vertex_count, normal);
    return m->vertex_count++;
}

void ex_build_triangle(ex_builder *b, uint32_t i, uint32_t j, uint32_t k, uint32_t material)
{
    ex_mesh *m = &b->mesh;
    if (m->triangle_count == b->triangle_room && !b->failed) {
        size_t room = b->triangle_room ? 2 * b->triangle_room : 1024;
        b->failed = reserve(&m->indices, room, 3 * sizeof(uint32_t)) || reserve(&m->materials, room, sizeof(uint32_t));
        if (!b->failed) b->triangle_room = room;
    }
    if (b->failed) return;
    uint32_t *to = m->indices + 3 * (size_t)m->triangle_count;
    to[0] = i;
    to[1] = j;
    to[2] = k;
    m->materials[m->triangle_count++] = material;
}

void ex_build_quad(ex_builder *b, v3 p, v3 q, v3 r, v3 s, uint32_t material)
{
    v3 n = v3_unit(v3_cross(v3_sub(r, p), v3_sub(s, q)));
    uint32_t i = ex_build_vertex(b, p, n), j = ex_build_vertex(b, q, n);
    uint32_t k = ex_build_vertex(b, r, n), l = ex_build_vertex(b, s, n);
    ex_build_triangle(b, i, j, k, material);
    ex_build_triangle(b, i, k, l, material);
}

void ex_build_box(ex_builder *b, v3 low, v3 high, uint32_t material)
{
    v3 c[8];
    for (int i = 0; i < 8; i++)
        c[i] = v3_make(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    static const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; f++)
        ex_build_quad(b, c[faces[f][0]], c[faces[f][1]], c[faces[f][2]], c[faces[f][3]], material);
}

/* One ring of a lathe, or a single vertex on the axis. (nr, nh) is the normal in the profile's plane. */
static uint32_t lathe_ring(ex_builder *b, const float point[2], float nr, float nh, uint32_t sides)
{
    uint32_t first = b->mesh.vertex_count;
    if (point[0] <= 0) return ex_build_vertex(b, v3_make(0, point[1], 0), v3_make(0, nh < 0 ? -1.0f : 1.0f, 0));
    for (uint32_t i = 0; i < sides; i++) {
        float angle = 2 * EX_PI * (float)i / (float)sides, c = cosf(angle), s = sinf(angle);
        ex_build_vertex(b, v3_make(point[0] * c, point[1], point[0] * s), v3_make(nr * c, nh, nr * s));
    }
    return first;
}

void ex_build_lathe(ex_builder *b, const float *profile, uint32_t points, uint32_t sides, float crease,
                    uint32_t material)
{
    for (uint32_t i = 0; i + 1 < points; i++) {
        /* The outward normal of a segment (dr, dh) is (dh, -dr); at a soft bend it is averaged with the neighbour's. */
        const float *p = profile + 2 * i, *q = p + 2;
        float n[2][2], own[2] = {q[1] - p[1], p[0] - q[0]};
        for (int end = 0; end < 2; end++) {
            n[end][0] = own[0];
            n[end][1] = own[1];
            if ((end == 0 && i == 0) || (end == 1 && i + 2 == points)) continue;
            const float *r = end == 0 ? p - 2 : q, *s = r + 2;
            float other[2] = {s[1] - r[1], r[0] - s[0]};
            float dot = own[0] * other[0] + own[1] * other[1], cross = own[0] * other[1] - own[1] * other[0];
            if (fabsf(atan2f(cross, dot)) >= crease) continue;
            n[end][0] += other[0];
            n[end][1] += other[1];
        }
        uint32_t ring[2];
        for (int end = 0; end < 2; end++) {
            float length = sqrtf(n[end][0] * n[end][0] + n[end][1] * n[end][1]);
            length = length > 0 ? 1 / length : 0;
            ring[end] = lathe_ring(b, end ? q : p, n[end][0] * length, n[end][1] * length, sides);
        }
        for (uint32_t k = 0; k < sides; k++) {
            uint32_t next = (k + 1) % sides;
            uint32_t low = ring[0] + (p[0] > 0 ? k : 0), low_next = ring[0] + (p[0] > 0 ? next : 0);
            uint32_t high = ring[1] + (q[0] > 0 ? k : 0), high_next = ring[1] + (q[0] > 0 ? next : 0);
            if (high != high_next) ex_build_triangle(b, low, high, high_next, material);
            if (low != low_next) ex_build_triangle(b, low, high_next, low_next, material);
        }
    }
}

void ex_build_tube(ex_builder *b, const v3 *path, const float *radii, uint32_t points, uint32_t sides,
                   uint32_t material)
{
    uint32_t previous = 0;
    v3 side = v3_make(0, 0, 0);
    for (uint32_t i = 0; i < points; i++) {
        int tip = i == 0 || i + 1 == points;
        v3 tangent = v3_unit(v3_sub(path[i + 1 < points ? i + 1 : i], path[i > 0 ? i - 1 : 0]));
        if (i == 0) side = fabsf(tangent.y) < 0.9f ? v3_make(0, 1, 0) : v3_make(1, 0, 0);
        side = v3_unit(v3_mad(side, tangent, -v3_dot(side, tangent)));
        v3 up = v3_cross(tangent, side);
        uint32_t first = b->mesh.vertex_count;
        if (tip) ex_build_vertex(b, path[i], v3_scale(tangent, i == 0 ? -1.0f : 1.0f));
        for (uint32_t k = 0; !tip && k < sides; k++) {
            float angle = 2 * EX_PI * (float)k / (float)sides;
            v3 n = v3_add(v3_scale(side, cosf(angle)), v3_scale(up, sinf(angle)));
            ex_build_vertex(b, v3_mad(path[i], n, radii[i]), n);
        }
        for (uint32_t k = 0; i > 0 && k < sides; k++) {
            uint32_t next = (k + 1) % sides;
            if (i == 1)
                ex_build_triangle(b, previous, first + next, first + k, material);
            else if (tip)
                ex_build_triangle(b, previous + k, previous + next, first, material);
            else {
                ex_build_triangle(b, previous + k, previous + next, first + next, material);
                ex_build_triangle(b, previous + k, first + next, first + k, material);
            }
        }
        previous = first;
    }
}

/* The normals that are still zero become the sum of the neighbouring faces' normals, weighted by area. */
int ex_smooth_normals(ex_mesh *m)
{
    size_t count = 3 * (size_t)m->vertex_count;
    uint8_t *missing = (uint8_t *)calloc(m->vertex_count ? m->vertex_count : 1, 1);
    if (!missing) return -1;
    for (size_t i = 0; i < count; i += 3) missing[i / 3] = !(v3_length(v3_load(m->normals + i)) > 0);
    for (size_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *index = m->indices + 3 * t;
        v3 p[3];
        for (int k = 0; k < 3; k++) p[k] = v3_load(m->positions + 3 * (size_t)index[k]);
        v3 n = v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0]));
        for (int k = 0; k < 3; k++) {
            float *to = m->normals + 3 * (size_t)index[k];
            if (missing[index[k]]) v3_store(to, v3_add(v3_load(to), n));
        }
    }
    for (size_t i = 0; i < count; i += 3) v3_store(m->normals + i, v3_unit(v3_load(m->normals + i)));
    free(missing);
    return 0;
}

/* At a sharp edge of a smooth surface the mean normal may face away from a small triangle: its corner then gets a
   vertex of its own with the triangle's normal. */
static void split_contrary(ex_builder *b)
{
    for (size_t i = 0; i < 3 * (size_t)b->mesh.triangle_count && !b->failed; i++) {
        const uint32_t *index = b->mesh.indices + i / 3 * 3;
        v3 p[3], normal = v3_load(b->mesh.normals + 3 * (size_t)index[i % 3]);
        for (int k = 0; k < 3; k++) p[k] = v3_load(b->mesh.positions + 3 * (size_t)index[k]);
        v3 face = v3_unit_or(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])), normal);
        if (v3_dot(face, normal) > 0) continue;
        uint32_t own = ex_build_vertex(b, p[i % 3], face);
        if (!b->failed) b->mesh.indices[i] = own;
    }
}

uint32_t ex_build_finish(ex_builder *b)
{
    ex_scene *s = b->scene;
    if (!b->failed) b->failed = ex_smooth_normals(&b->mesh) != 0;
    if (b->split) split_contrary(b);
    if (b->failed || ex_grow(&s->meshes, &s->mesh_count, sizeof *s->meshes) != 0) {
        b->failed = 1;
        ex_mesh_free(&b->mesh);
    } else {
        s->meshes[s->mesh_count - 1] = b->mesh;
    }
    memset(&b->mesh, 0, sizeof b->mesh);
    b->vertex_room = b->triangle_room = 0;
    return s->mesh_count ? s->mesh_count - 1 : 0;
}

int ex_build_replace(ex_builder *b, uint32_t mesh)
{
    ex_mesh *to = &b->scene->meshes[mesh];
    if (b->failed || ex_smooth_normals(&b->mesh) != 0) {
        ex_mesh_free(&b->mesh);
        return -1;
    }
    ex_mesh_free(to);
    *to = b->mesh;
    to->deforms = 1;
    memset(&b->mesh, 0, sizeof b->mesh);
    b->vertex_room = b->triangle_room = 0;
    return 0;
}

void ex_build_camera(ex_builder *b, v3 eye, v3 target, float fovy_degrees)
{
    ex_camera *camera = &b->scene->camera;
    v3_store(camera->eye, eye);
    v3_store(camera->target, target);
    v3_store(camera->up, v3_make(0, 1, 0));
    camera->fovy = fovy_degrees * EX_PI / 180;
    b->scene->has_camera = 1;
}

ex_light *ex_build_light(ex_builder *b, ex_light_kind kind)
{
    ex_scene *s = b->scene;
    if (b->failed || ex_grow(&s->lights, &s->light_count, sizeof *s->lights) != 0) {
        b->failed = 1;
        return NULL;
    }
    s->lights[s->light_count - 1].kind = kind;
    return &s->lights[s->light_count - 1];
}

ex_object *ex_build_object(ex_builder *b, const char *name, uint32_t mesh)
{
    ex_scene *s = b->scene;
    if (b->failed || ex_grow(&s->objects, &s->object_count, sizeof *s->objects) != 0) {
        b->failed = 1;
        return NULL;
    }
    ex_object *object = &s->objects[s->object_count - 1];
    snprintf(object->name, sizeof object->name, "%s", name);
    object->mesh = mesh;
    ex_identity(object->transform);
    return object;
}
