/* pose.c - see rig.h: a glTF scene at a time. Tracks give nodes their transforms and bodies their weights; nodes are
   multiplied from the roots down; then morph targets and skins move vertices, as chapters 3.7.2 and 3.7.3 of the glTF
   2.0 specification say. */
#include "rig.h"
#include <stdlib.h>
#include <string.h>

/* ---- tracks ---- */

/* The last key that is not behind the time, with at least one key after it. */
static uint32_t key_before(const ex_track *track, float time)
{
    uint32_t low = 0, high = track->key_count - 1;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (track->times[middle] <= time) low = middle;
        else high = middle;
    }
    return low;
}

/* By the shorter arc between two rotations; nearly equal ones by the chord, whose error is below float's there. */
static void slerp(const float *a, const float *b, float s, float *value)
{
    float cosine = 0, from = 1 - s, to = s;
    for (int i = 0; i < 4; i++) cosine += a[i] * b[i];
    float sign = cosine < 0 ? -1.0f : 1.0f;
    cosine = fminf(cosine * sign, 1);
    if (cosine < 0.9999f) {
        float angle = acosf(cosine), sine = sinf(angle);
        from = sinf((1 - s) * angle) / sine;
        to = sinf(s * angle) / sine;
    }
    for (int i = 0; i < 4; i++) value[i] = from * a[i] + sign * to * b[i];
}

/* Hermite's cubic between two keys of (tangent in, value, tangent out), which are `seconds` apart. */
static void spline(const float *key, uint32_t width, float s, float seconds, float *value)
{
    float s2 = s * s, s3 = s2 * s;
    for (uint32_t i = 0; i < width; i++) {
        float from = key[width + i], out = key[2 * width + i], in = key[3 * width + i], to = key[4 * width + i];
        value[i] = (2 * s3 - 3 * s2 + 1) * from + seconds * (s3 - 2 * s2 + s) * out + (3 * s2 - 2 * s3) * to +
                   seconds * (s3 - s2) * in;
    }
}

void ex_track_value(const ex_track *track, float time, float *value)
{
    int is_spline = track->interpolation == GLTF_CUBICSPLINE;
    size_t width = track->width, stride = is_spline ? 3 * width : width;
    const float *values = track->values + (is_spline ? width : 0);
    uint32_t last = track->key_count - 1;
    if (time <= track->times[0] || time >= track->times[last]) {
        memcpy(value, values + (time <= track->times[0] ? 0 : last * stride), width * sizeof *value);
        return;
    }
    uint32_t key = key_before(track, time);
    float seconds = track->times[key + 1] - track->times[key], s = (time - track->times[key]) / seconds;
    const float *a = values + key * stride, *b = a + stride;
    if (is_spline) spline(track->values + key * stride, track->width, s, seconds, value);
    else if (track->interpolation == GLTF_STEP) memcpy(value, a, width * sizeof *value);
    else if (track->is_rotation) slerp(a, b, s, value);
    else
        for (size_t i = 0; i < width; i++) value[i] = ex_mix(a[i], b[i], s);
}

/* ---- nodes ---- */

void ex_compose(float m[16], const double part[10])
{
    const double *q = part + 3, *s = part + 7;
    double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], k = n > 0 ? 2 / n : 0;
    double x = q[0], y = q[1], z = q[2], w = q[3];
    double r[9] = {1 - k * (y * y + z * z), k * (x * y + z * w), k * (x * z - y * w),
                   k * (x * y - z * w), 1 - k * (x * x + z * z), k * (y * z + x * w),
                   k * (x * z + y * w), k * (y * z - x * w), 1 - k * (x * x + y * y)};
    ex_identity(m);
    for (int i = 0; i < 9; i++) m[4 * (i / 3) + i % 3] = (float)(r[i] * s[i / 3]);
    for (int i = 0; i < 3; i++) m[12 + i] = (float)part[i];
}

int ex_transform_usable(const float m[16])
{
    float largest = 0;
    for (int i = 0; i < 16; i++) {
        if (!(fabsf(m[i]) < HUGE_COORDINATE)) return 0;
        if (i % 4 < 3 && i < 12 && fabsf(m[i]) > largest) largest = fabsf(m[i]);
    }
    return largest > 0 && fabsf(m[3]) + fabsf(m[7]) + fabsf(m[11]) < 1e-6f && fabsf(m[15] - 1) < 1e-6f;
}

void ex_place_light(ex_light *light, const float m[16])
{
    v3 out = v3_unit_or(ex_transform_vector(m, v3_make(0, 0, -1)), v3_make(0, 0, -1));
    v3_store(light->position, ex_transform_point(m, v3_make(0, 0, 0)));
    v3_store(light->direction, light->kind == EX_LIGHT_SUN ? v3_scale(out, -1) : out);
}

static void play_tracks(ex_rig *rig, float time)
{
    static const int first[3] = {0, 3, 7};
    if (time > rig->duration) time = rig->duration > 0 ? fmodf(time, rig->duration) : 0;
    for (uint32_t i = 0; i < rig->channel_count; i++) {
        const ex_rig_channel *c = &rig->channels[i];
        const ex_track *track = &rig->tracks[c->track];
        ex_rig_node *node = &rig->nodes[c->node];
        float value[4];
        if (c->path == GLTF_WEIGHTS) {
            ex_track_value(track, time, rig->bodies[node->body].weights);
            continue;
        }
        ex_track_value(track, time, value);
        for (uint32_t k = 0; k < track->width; k++) node->now[first[c->path] + (int)k] = (double)value[k];
    }
}

static void place_nodes(ex_rig *rig)
{
    for (uint32_t i = 0; i < rig->node_count; i++) {
        ex_rig_node *node = &rig->nodes[rig->order[i]];
        if (!node->has_matrix) ex_compose(node->local, node->now);
        if (node->parent == RIG_NONE) memcpy(node->world, node->local, sizeof node->world);
        else ex_multiply(node->world, rig->nodes[node->parent].world, node->local);
    }
}

static int matrix_fails(ex_rig *rig, uint32_t node, const float m[16])
{
    for (int i = 0; i < 16; i++)
        if (!(fabsf(m[i]) < HUGE_COORDINATE))
            return ex_fail(rig->problem, "node %u: its matrix in the world holds %g: 1e9 is the most", (unsigned)node,
                           (double)m[i]);
    return 0;
}

void ex_transform_speck(float m[16])
{
    float largest = 0;
    for (int i = 0; i < 12; i++) largest = i % 4 < 3 ? fmaxf(largest, fabsf(m[i])) : largest;
    for (int i = 0; i < 12 && largest < 1e-6f; i++) m[i] = i % 5 == 0 ? 1e-6f : 0;
}

static int place_object(ex_rig *rig, uint32_t node, float transform[16])
{
    const float *m = rig->nodes[node].world;
    if (matrix_fails(rig, node, m) != 0) return -1;
    memcpy(transform, m, 16 * sizeof *m);
    ex_transform_speck(transform);
    return 0;
}

/* ---- vertices ---- */

/* Positions and normals with morph targets, into those of the mesh. */
static void morph(const ex_shape *shape, const float *weights, ex_mesh *mesh)
{
    size_t floats = 3 * (size_t)shape->vertex_count;
    memcpy(mesh->positions, shape->positions, floats * sizeof(float));
    memcpy(mesh->normals, shape->normals, floats * sizeof(float));
    for (uint32_t t = 0; t < shape->target_count; t++) {
        const float w = weights[t], *positions = shape->position_deltas + t * floats;
        const float *normals = shape->normal_deltas ? shape->normal_deltas + t * floats : NULL;
        for (size_t i = 0; i < floats && w != 0; i++) mesh->positions[i] += w * positions[i];
        for (size_t i = 0; i < floats && w != 0 && normals; i++) mesh->normals[i] += w * normals[i];
    }
}

static void skin_vertex(const ex_shape *shape, const ex_skin *skin, uint32_t vertex, ex_mesh *mesh)
{
    const uint16_t *joints = shape->joints + (size_t)vertex * shape->joints_per_vertex;
    const float *weights = shape->weights + (size_t)vertex * shape->joints_per_vertex;
    float *position = mesh->positions + 3 * (size_t)vertex, *normal = mesh->normals + 3 * (size_t)vertex;
    float m[16] = {0};
    for (uint32_t k = 0; k < shape->joints_per_vertex; k++) {
        const float *joint = skin->matrices + 16 * (size_t)joints[k];
        for (int i = 0; i < 16 && weights[k] != 0; i++) m[i] += weights[k] * joint[i];
    }
    v3_store(position, ex_transform_point(m, v3_load(position)));
    v3_store(normal, ex_transform_normal(m, v3_load(normal)));
}

/* What has no normals in the file has those of its triangles. */
static void flatten(const ex_shape *shape, ex_mesh *mesh)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *index = mesh->indices + 3 * t;
        v3 p[3];
        if (!shape->flat[index[0]]) continue;
        for (int k = 0; k < 3; k++) p[k] = v3_load(mesh->positions + 3 * (size_t)index[k]);
        v3 face = v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0]));
        if (!(v3_length(face) > 1e-30f)) continue;
        for (int k = 0; k < 3; k++) v3_store(mesh->normals + 3 * (size_t)index[k], face);
    }
}

static int pose_body(ex_rig *rig, const ex_body *body, ex_mesh *mesh)
{
    const ex_shape *shape = &rig->shapes[body->shape];
    if (mesh->vertex_count != shape->vertex_count) return 0;         /* emptied by whoever has the scene */
    morph(shape, body->weights, mesh);
    for (uint32_t i = 0; i < shape->vertex_count && body->skin != RIG_NONE; i++)
        skin_vertex(shape, &rig->skins[body->skin], i, mesh);
    flatten(shape, mesh);
    for (uint32_t i = 0; i < shape->vertex_count; i++) {
        float *p = mesh->positions + 3 * (size_t)i, *n = mesh->normals + 3 * (size_t)i;
        v3_store(n, v3_unit_or(v3_load(n), v3_load(shape->normals + 3 * (size_t)i)));
        if (fabsf(p[0]) < HUGE_COORDINATE && fabsf(p[1]) < HUGE_COORDINATE && fabsf(p[2]) < HUGE_COORDINATE) continue;
        int axis = fabsf(p[0]) < HUGE_COORDINATE ? fabsf(p[1]) < HUGE_COORDINATE ? 2 : 1 : 0;
        double reached = (double)p[axis];
        memcpy(mesh->positions, shape->positions, 3 * (size_t)shape->vertex_count * sizeof(float));
        return ex_fail(rig->problem, "node %u: its skin or morph targets move vertex %u to %g: 1e9 is the most",
                       (unsigned)body->node, (unsigned)i, reached);
    }
    return 0;
}

static int pose_skin(ex_rig *rig, ex_skin *skin)
{
    for (uint32_t i = 0; i < skin->joint_count; i++) {
        float *m = skin->matrices + 16 * (size_t)i;
        ex_multiply(m, rig->nodes[skin->joints[i]].world, skin->inverse_bind + 16 * (size_t)i);
        if (matrix_fails(rig, skin->joints[i], m) != 0) return -1;
    }
    return 0;
}

int ex_rig_pose(ex_scene *scene, float time)
{
    ex_rig *rig = scene->rig;
    for (uint32_t i = 0; i < rig->node_count; i++)
        memcpy(rig->nodes[i].now, rig->nodes[i].rest, sizeof rig->nodes[i].now);
    for (uint32_t i = 0; i < rig->body_count; i++)
        for (uint32_t t = 0; t < rig->shapes[rig->bodies[i].shape].target_count; t++)
            rig->bodies[i].weights[t] = rig->bodies[i].rest_weights[t];
    if (time >= 0) play_tracks(rig, time);
    place_nodes(rig);
    for (uint32_t i = 0; i < rig->skin_count; i++)
        if (pose_skin(rig, &rig->skins[i]) != 0) return -1;
    for (uint32_t i = 0; i < rig->object_count; i++)
        if (place_object(rig, rig->objects[i].node, scene->objects[rig->objects[i].item].transform) != 0) return -1;
    for (uint32_t i = 0; i < rig->light_count; i++) {
        if (matrix_fails(rig, rig->lights[i].node, rig->nodes[rig->lights[i].node].world) != 0) return -1;
        ex_place_light(&scene->lights[rig->lights[i].item], rig->nodes[rig->lights[i].node].world);
    }
    for (uint32_t i = 0; i < rig->body_count; i++)
        if (pose_body(rig, &rig->bodies[i], &scene->meshes[rig->bodies[i].mesh]) != 0) return -1;
    return 0;
}

const char *ex_rig_problem(const ex_rig *rig) { return rig->problem; }

void ex_rig_free(ex_rig *rig)
{
    if (!rig) return;
    for (uint32_t i = 0; i < rig->skin_count; i++) {
        free(rig->skins[i].joints);
        free(rig->skins[i].inverse_bind);
        free(rig->skins[i].matrices);
    }
    for (uint32_t i = 0; i < rig->shape_count; i++) {
        ex_shape *s = &rig->shapes[i];
        void *const arrays[] = {s->positions, s->normals, s->flat, s->joints, s->weights, s->position_deltas,
                                s->normal_deltas};
        for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
    }
    for (uint32_t i = 0; i < rig->body_count; i++) free(rig->bodies[i].rest_weights);    /* weights lie behind them */
    for (uint32_t i = 0; i < rig->track_count; i++) {
        free(rig->tracks[i].times);
        free(rig->tracks[i].values);
    }
    void *const arrays[] = {rig->nodes, rig->order, rig->skins, rig->shapes, rig->users, rig->bodies, rig->objects,
                            rig->lights, rig->tracks, rig->channels};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
    free(rig);
}
