/* gltf_rig.c - see rig.h: nodes, skins and morph targets of a glTF file are read and checked, so that pose.c needs no
   check. A message names the element of the file, the field and its value. */
#include "rig.h"
#include <stdlib.h>
#include <string.h>

#if defined(DAPPLE_HAVE_TINYGLTF) && DAPPLE_HAVE_TINYGLTF

#define MOST_MOVED 300000000.0       /* vertices times targets: a pose takes a nanosecond for each */

void *ex_rig_room(ex_rig *rig, double count, size_t size, const char *path, char *error)
{
    rig->bytes += count * (double)size;
    if (rig->bytes > 0.5 * (double)ex_memory_limit) {
        ex_fail(error, "%s: its skins, morph targets and animations take too much memory: --limit-memory", path);
        return NULL;
    }
    void *memory = calloc((size_t)count + 1, size);
    if (!memory) ex_fail(error, "%s: out of memory", path);
    return memory;
}

int ex_rig_wanted(const gltf_file *file)
{
    int wanted = file->animation_count > 0;
    for (size_t i = 0; i < file->node_count; i++) wanted |= file->nodes[i].skin >= 0;
    for (size_t i = 0; i < file->primitive_count; i++) wanted |= file->primitives[i].target_count > 0;
    return wanted;
}

/* ---- nodes ---- */

static int read_place(ex_rig_node *to, const gltf_node *from, uint32_t number, const char *path, char *error)
{
    to->has_matrix = from->has_matrix;
    memcpy(to->rest, from->translation, sizeof from->translation);
    memcpy(to->rest + 3, from->rotation, sizeof from->rotation);
    memcpy(to->rest + 7, from->scale, sizeof from->scale);
    for (int k = 0; k < 16; k++) {
        to->local[k] = (float)from->matrix[k];
        if (!(fabs(from->matrix[k]) < (double)HUGE_COORDINATE))
            return ex_fail(error, "%s: node %u: matrix holds %g: 1e9 is the most", path, (unsigned)number,
                           from->matrix[k]);
    }
    for (int k = 0; k < 10; k++)
        if (!(fabs(to->rest[k]) < (double)HUGE_COORDINATE))
            return ex_fail(error, "%s: node %u: %s holds %g: 1e9 is the most", path, (unsigned)number,
                           k < 3 ? "translation" : k < 7 ? "rotation" : "scale", to->rest[k]);
    return 0;
}

static int read_nodes(ex_rig *rig, const gltf_file *f, const char *path, char *error)
{
    rig->nodes = (ex_rig_node *)ex_rig_room(rig, (double)f->node_count, sizeof *rig->nodes, path, error);
    if (!rig->nodes) return -1;
    rig->node_count = (uint32_t)f->node_count;
    for (size_t i = 0; i < f->node_count; i++) rig->nodes[i].parent = rig->nodes[i].body = RIG_NONE;
    for (size_t i = 0; i < f->node_count; i++) {
        const gltf_node *from = &f->nodes[i];
        if (read_place(&rig->nodes[i], from, (uint32_t)i, path, error) != 0) return -1;
        if (from->mesh >= 0 && (size_t)from->mesh < f->mesh_count) rig->users[from->mesh]++;
        for (size_t k = 0; k < from->child_count; k++) {
            int child = from->children[k];
            if (child < 0 || (size_t)child >= f->node_count)
                return ex_fail(error, "%s: node %u: child %d does not exist", path, (unsigned)i, child);
            if (rig->nodes[child].parent != RIG_NONE)
                return ex_fail(error, "%s: node %d has two parents, %u and %u: not a tree", path, child,
                               (unsigned)rig->nodes[child].parent, (unsigned)i);
            rig->nodes[child].parent = (uint32_t)i;
        }
    }
    return 0;
}

/* Parents before children. With one parent each, what no root reaches is a cycle or hangs on one. */
static int order_nodes(ex_rig *rig, const gltf_file *f, const char *path, char *error)
{
    uint32_t count = 0;
    rig->order = (uint32_t *)ex_rig_room(rig, (double)f->node_count, sizeof *rig->order, path, error);
    if (!rig->order) return -1;
    for (uint32_t i = 0; i < rig->node_count; i++)
        if (rig->nodes[i].parent == RIG_NONE) rig->order[count++] = i;
    for (uint32_t at = 0; at < count; at++) {
        const gltf_node *node = &f->nodes[rig->order[at]];
        for (size_t k = 0; k < node->child_count; k++) rig->order[count++] = (uint32_t)node->children[k];
    }
    if (count == rig->node_count) return 0;
    for (uint32_t at = 0; at < count; at++) rig->nodes[rig->order[at]].now[0] = 1;      /* reached */
    for (uint32_t i = 0; i < rig->node_count; i++)
        if (!(rig->nodes[i].now[0] > 0))
            return ex_fail(error, "%s: node %u is among its own ancestors, or below such a one: not a tree", path,
                           (unsigned)i);
    return -1;
}

/* ---- skins ---- */

static int read_inverse_bind(ex_skin *skin, const gltf_accessor *a, size_t number, const char *path, char *error)
{
    for (uint32_t i = 0; i < skin->joint_count; i++) {
        float *m = skin->inverse_bind + 16 * (size_t)i;
        for (int k = 0; k < 16; k++) {
            m[k] = a ? ex_gltf_float(a, i, k) : k % 5 == 0;
            if (!(fabsf(m[k]) < HUGE_COORDINATE))
                return ex_fail(error, "%s: skin %u: inverseBindMatrices: matrix %u holds %g: 1e9 is the most", path,
                               (unsigned)number, (unsigned)i, (double)m[k]);
        }
        for (int k = 3; k < 16; k += 4)
            if (!(fabsf(m[k] - (k == 15)) < 1e-3f))
                return ex_fail(error, "%s: skin %u: inverseBindMatrices: matrix %u has %g in its last row, not %d",
                               path, (unsigned)number, (unsigned)i, (double)m[k], k == 15);
    }
    return 0;
}

static int read_skin(ex_rig *rig, const gltf_file *f, size_t number, const char *path, char *error)
{
    const gltf_skin *from = &f->skins[number];
    const gltf_accessor *a = NULL;
    ex_skin *to = &rig->skins[number];
    char what[64];
    snprintf(what, sizeof what, "skin %u: inverseBindMatrices", (unsigned)number);
    if (from->joint_count == 0) return ex_fail(error, "%s: skin %u has no joints", path, (unsigned)number);
    if (from->inverse_bind >= 0) {
        if (!(a = ex_gltf_accessor(f, from->inverse_bind, 16, what, path, error))) return -1;
        if (a->component_type != 5126)
            return ex_fail(error, "%s: %s: accessor %d does not hold floats", path, what, from->inverse_bind);
        if (a->count < from->joint_count)
            return ex_fail(error, "%s: %s: %u matrices for %u joints", path, what, (unsigned)a->count,
                           (unsigned)from->joint_count);
    }
    to->joints = (uint32_t *)ex_rig_room(rig, (double)from->joint_count, sizeof *to->joints, path, error);
    if (to->joints)
        to->inverse_bind = (float *)ex_rig_room(rig, (double)from->joint_count, 16 * sizeof(float), path, error);
    if (to->inverse_bind)
        to->matrices = (float *)ex_rig_room(rig, (double)from->joint_count, 16 * sizeof(float), path, error);
    if (!to->matrices) return -1;
    to->joint_count = (uint32_t)from->joint_count;
    for (size_t i = 0; i < from->joint_count; i++) {
        if (from->joints[i] < 0 || (size_t)from->joints[i] >= f->node_count)
            return ex_fail(error, "%s: skin %u: joint %u is node %d, which does not exist", path, (unsigned)number,
                           (unsigned)i, from->joints[i]);
        to->joints[i] = (uint32_t)from->joints[i];
    }
    return read_inverse_bind(to, a, number, path, error);
}

ex_rig *ex_rig_begin(const gltf_file *f, const char *path, char *error)
{
    ex_rig *rig = (ex_rig *)calloc(1, sizeof *rig);
    if (!rig) {
        ex_fail(error, "%s: out of memory", path);
        return NULL;
    }
    rig->shapes = (ex_shape *)ex_rig_room(rig, (double)f->mesh_count, sizeof *rig->shapes, path, error);
    if (rig->shapes) rig->users = (uint32_t *)ex_rig_room(rig, (double)f->mesh_count, sizeof *rig->users, path, error);
    if (rig->users) rig->skins = (ex_skin *)ex_rig_room(rig, (double)f->skin_count, sizeof *rig->skins, path, error);
    int result = rig->skins ? 0 : -1;
    if (result == 0) {
        rig->shape_count = (uint32_t)f->mesh_count;
        rig->skin_count = (uint32_t)f->skin_count;
        result = read_nodes(rig, f, path, error) || order_nodes(rig, f, path, error) ? -1 : 0;
    }
    for (size_t i = 0; i < f->skin_count && result == 0; i++) result = read_skin(rig, f, i, path, error);
    if (result == 0) return rig;
    ex_rig_free(rig);
    return NULL;
}

/* ---- shapes ---- */

typedef struct shape_reader {
    ex_rig          *rig;
    const gltf_file *file;
    ex_shape        *shape;
    const ex_source *sources;
    const char      *path;
    char            *error;
    uint32_t         mesh, primitive, first, end;    /* a primitive, and the vertices that come of it */
} shape_reader;

/* An attribute of the primitive, or one of its targets', with as many elements as POSITION. */
static const gltf_accessor *attribute(const shape_reader *r, int index, int components, const char *name)
{
    const gltf_primitive *p = &r->file->primitives[r->primitive];
    const gltf_accessor *a, *positions = &r->file->accessors[p->positions];
    char what[96];
    snprintf(what, sizeof what, "mesh %u: %s", (unsigned)r->mesh, name);
    if (!(a = ex_gltf_accessor(r->file, index, components, what, r->path, r->error))) return NULL;
    if (a->count == positions->count) return a;
    ex_fail(r->error, "%s: %s has %u elements, POSITION %u", r->path, what, (unsigned)a->count,
            (unsigned)positions->count);
    return NULL;
}

static int read_influence(const shape_reader *r, const gltf_accessor *joints, const gltf_accessor *weights, int set,
                          uint32_t vertex)
{
    const uint32_t at = r->sources[vertex].vertex;
    ex_shape *shape = r->shape;
    for (uint32_t k = 0; k < 4; k++) {
        const size_t to = (size_t)vertex * shape->joints_per_vertex + 4 * (size_t)set + k;
        const float weight = ex_gltf_float(weights, at, (int)k), joint = ex_gltf_float(joints, at, (int)k);
        if (!(weight >= 0 && weight < HUGE_COORDINATE))
            return ex_fail(r->error, "%s: mesh %u: WEIGHTS_%d of vertex %u is %g: 0 to 1e9 is allowed", r->path,
                           (unsigned)r->mesh, set, (unsigned)at, (double)weight);
        shape->weights[to] = weight;
        if (!(weight > 0)) continue;
        shape->joints[to] = (uint16_t)joint;
        if (shape->joints[to] <= shape->highest_joint) continue;
        shape->highest_joint = shape->joints[to];
        shape->highest_vertex = at;
    }
    return 0;
}

static int read_influences(const shape_reader *r, int set)
{
    const gltf_primitive *p = &r->file->primitives[r->primitive];
    const gltf_accessor *joints, *weights;
    char names[2][16];
    snprintf(names[0], sizeof names[0], "JOINTS_%d", set);
    snprintf(names[1], sizeof names[1], "WEIGHTS_%d", set);
    if (p->joints[set] < 0 && p->weights[set] < 0 && set > 0) return 0;
    if (p->joints[set] < 0 || p->weights[set] < 0)
        return ex_fail(r->error, "%s: mesh %u: a primitive has no %s, but others or it have joints and weights",
                       r->path, (unsigned)r->mesh, names[p->joints[set] >= 0]);
    if (!(joints = attribute(r, p->joints[set], 4, names[0]))) return -1;
    if (!(weights = attribute(r, p->weights[set], 4, names[1]))) return -1;
    if (joints->component_type != 5121 && joints->component_type != 5123)
        return ex_fail(r->error, "%s: mesh %u: %s are of the type %d, not of unsigned bytes or shorts", r->path,
                       (unsigned)r->mesh, names[0], joints->component_type);
    if (weights->component_type != 5121 && weights->component_type != 5123 && weights->component_type != 5126)
        return ex_fail(r->error, "%s: mesh %u: %s are of the type %d, not of floats, unsigned bytes or shorts", r->path,
                       (unsigned)r->mesh, names[1], weights->component_type);
    gltf_accessor plain = *joints;
    plain.normalized = 0;
    for (uint32_t i = r->first; i < r->end; i++)
        if (read_influence(r, &plain, weights, set, i) != 0) return -1;
    return 0;
}

/* So that weights sum to 1, which makes up for rounded ones; without any the first joint has it all. */
static void normalise_weights(ex_shape *shape)
{
    const uint32_t each = shape->joints_per_vertex;
    for (uint32_t i = 0; i < shape->vertex_count; i++) {
        float *weights = shape->weights + (size_t)i * each, sum = 0;
        for (uint32_t k = 0; k < each; k++) sum += weights[k];
        if (sum > 0)
            for (uint32_t k = 0; k < each; k++) weights[k] /= sum;
        else weights[0] = 1;
    }
}

static int read_deltas(const shape_reader *r, uint32_t target, int index, const char *name, float *deltas)
{
    const gltf_accessor *a;
    char what[64];
    if (index < 0) return 0;
    snprintf(what, sizeof what, "target %u: %s", (unsigned)target, name);
    if (!(a = attribute(r, index, 3, what))) return -1;
    for (uint32_t i = r->first; i < r->end; i++)
        for (int k = 0; k < 3; k++) {
            const float delta = ex_gltf_float(a, r->sources[i].vertex, k);
            if (!(fabsf(delta) < HUGE_COORDINATE))
                return ex_fail(r->error, "%s: mesh %u: %s of vertex %u is %g: 1e9 is the most", r->path,
                               (unsigned)r->mesh, what, (unsigned)r->sources[i].vertex, (double)delta);
            deltas[3 * ((size_t)target * r->shape->vertex_count + i) + (size_t)k] = delta;
        }
    return 0;
}

static int read_primitive(const shape_reader *r)
{
    const gltf_primitive *p = &r->file->primitives[r->primitive];
    ex_shape *shape = r->shape;
    for (int set = 0; 4 * (uint32_t)set < shape->joints_per_vertex; set++)
        if (read_influences(r, set) != 0) return -1;
    if (p->target_count != shape->target_count)
        return ex_fail(r->error, "%s: mesh %u: a primitive has %u morph targets, another one %u", r->path,
                       (unsigned)r->mesh, (unsigned)p->target_count, (unsigned)shape->target_count);
    for (uint32_t t = 0; t < shape->target_count; t++) {
        const gltf_target *target = &r->file->targets[p->first_target + t];
        if (read_deltas(r, t, target->positions, "POSITION", shape->position_deltas) != 0) return -1;
        if (p->normals >= 0 && read_deltas(r, t, target->normals, "NORMAL", shape->normal_deltas) != 0) return -1;
    }
    for (uint32_t i = r->first; i < r->end; i++) shape->flat[i] = p->normals < 0;
    return 0;
}

/* What the shape needs, by the largest of its primitives, and the memory. */
static int begin_shape(const shape_reader *r, const ex_mesh *mesh)
{
    ex_shape *s = r->shape;
    ex_rig *rig = r->rig;
    const double n = mesh->vertex_count;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const gltf_primitive *p = &r->file->primitives[r->sources[i].primitive];
        for (uint32_t set = 0; set < 2; set++)
            if ((p->joints[set] >= 0 || p->weights[set] >= 0) && s->joints_per_vertex < 4 * (set + 1))
                s->joints_per_vertex = 4 * (set + 1);
        if (p->target_count > s->target_count) s->target_count = (uint32_t)p->target_count;
    }
    if (s->joints_per_vertex == 0 && s->target_count == 0) return 0;
    const double influences = n * s->joints_per_vertex, deltas = 3 * n * s->target_count;
    if (!(s->positions = (float *)ex_rig_room(rig, 3 * n, sizeof(float), r->path, r->error)) ||
        !(s->normals = (float *)ex_rig_room(rig, 3 * n, sizeof(float), r->path, r->error)) ||
        !(s->flat = (uint8_t *)ex_rig_room(rig, n, 1, r->path, r->error)) ||
        !(s->joints = (uint16_t *)ex_rig_room(rig, influences, sizeof *s->joints, r->path, r->error)) ||
        !(s->weights = (float *)ex_rig_room(rig, influences, sizeof(float), r->path, r->error)) ||
        !(s->position_deltas = (float *)ex_rig_room(rig, deltas, sizeof(float), r->path, r->error)) ||
        !(s->normal_deltas = (float *)ex_rig_room(rig, deltas, sizeof(float), r->path, r->error)))
        return -1;
    s->vertex_count = mesh->vertex_count;
    memcpy(s->positions, mesh->positions, 3 * (size_t)s->vertex_count * sizeof(float));
    memcpy(s->normals, mesh->normals, 3 * (size_t)s->vertex_count * sizeof(float));
    return 0;
}

int ex_rig_add_shape(ex_rig *rig, const gltf_file *file, const ex_mesh *mesh, uint32_t number,
                     const ex_source *sources, const char *path, char *error)
{
    shape_reader r = {rig, file, &rig->shapes[number], sources, path, error, number, 0, 0, 0};
    if (begin_shape(&r, mesh) != 0) return -1;
    for (; r.end < r.shape->vertex_count; r.first = r.end) {
        r.primitive = sources[r.first].primitive;
        while (r.end < r.shape->vertex_count && sources[r.end].primitive == r.primitive) r.end++;
        if (read_primitive(&r) != 0) return -1;
    }
    if (r.shape->joints_per_vertex) normalise_weights(r.shape);
    return 0;
}

/* ---- bodies ---- */

int ex_rig_moves(const ex_rig *rig, const gltf_file *file, uint32_t node)
{
    const gltf_node *n = &file->nodes[node];
    const ex_shape *shape = n->mesh >= 0 && (size_t)n->mesh < file->mesh_count ? &rig->shapes[n->mesh] : NULL;
    if (!shape || shape->vertex_count == 0) return 0;
    return n->skin >= 0 && shape->joints_per_vertex ? 2 : shape->target_count > 0;
}

int ex_rig_add_placed(ex_placed **list, uint32_t *count, uint32_t item, uint32_t node)
{
    if (ex_grow(list, count, sizeof **list) != 0) return -1;
    (*list)[*count - 1].item = item;
    (*list)[*count - 1].node = node;
    return 0;
}

static void *copy_of(const void *from, size_t bytes, int *failed)
{
    void *to = from ? malloc(bytes + 1) : NULL;
    if (to) memcpy(to, from, bytes);
    *failed |= from && !to;
    return to;
}

/* A mesh that several nodes show has a copy for each that moves. */
static int copy_mesh(ex_scene *scene, uint32_t number, const char *path, char *error)
{
    ex_mesh from, *to;
    int failed = 0;
    size_t n = scene->meshes[number].vertex_count, triangles = scene->meshes[number].triangle_count;
    scene->rig->bytes += 32.0 * (double)n + 16.0 * (double)triangles;
    if (scene->rig->bytes > 0.5 * (double)ex_memory_limit)
        return ex_fail(error, "%s: its skinned nodes take too much memory: --limit-memory", path);
    if (ex_grow(&scene->meshes, &scene->mesh_count, sizeof *scene->meshes) != 0)
        return ex_fail(error, "%s: out of memory", path);
    from = scene->meshes[number];
    to = &scene->meshes[scene->mesh_count - 1];
    *to = from;
    to->positions = (float *)copy_of(from.positions, 3 * n * sizeof(float), &failed);
    to->normals = (float *)copy_of(from.normals, 3 * n * sizeof(float), &failed);
    to->uvs = (float *)copy_of(from.uvs, 2 * n * sizeof(float), &failed);
    to->indices = (uint32_t *)copy_of(from.indices, 3 * triangles * sizeof(uint32_t), &failed);
    to->materials = (uint32_t *)copy_of(from.materials, triangles * sizeof(uint32_t), &failed);
    return failed ? ex_fail(error, "%s: out of memory", path) : 0;
}

static int set_weights(ex_rig *rig, const gltf_file *file, uint32_t node, ex_body *body, const char *path, char *error)
{
    const gltf_node *n = &file->nodes[node];
    const gltf_weights *weights = n->weights.count ? &n->weights : &file->weights[n->mesh];
    const uint32_t count = rig->shapes[body->shape].target_count;
    if (weights->count && weights->count != count)
        return ex_fail(error, "%s: %s %d has %u weights for %u morph targets", path, n->weights.count ? "node" : "mesh",
                       n->weights.count ? (int)node : n->mesh, (unsigned)weights->count, (unsigned)count);
    body->rest_weights = (float *)ex_rig_room(rig, 2.0 * count, sizeof(float), path, error);
    if (!body->rest_weights) return -1;
    body->weights = body->rest_weights + count;
    for (uint32_t i = 0; i < count && weights->count; i++) {
        body->rest_weights[i] = (float)weights->values[i];
        if (!(fabsf(body->rest_weights[i]) < HUGE_COORDINATE))
            return ex_fail(error, "%s: node %u: weight %u is %g: 1e9 is the most", path, (unsigned)node, (unsigned)i,
                           weights->values[i]);
    }
    return 0;
}

/* Which joint moves a vertex most: what holds a skin to be rigid parts needs no more of it. */
static int set_parts(ex_rig *rig, const ex_shape *shape, ex_mesh *mesh, const char *path, char *error)
{
    const uint32_t each = shape->joints_per_vertex;
    mesh->parts = (uint16_t *)ex_rig_room(rig, (double)shape->vertex_count, sizeof *mesh->parts, path, error);
    for (size_t i = 0; mesh->parts && i < shape->vertex_count; i++) {
        uint32_t best = 0;
        for (uint32_t k = 1; k < each; k++)
            if (shape->weights[i * each + k] > shape->weights[i * each + best]) best = k;
        mesh->parts[i] = shape->joints[i * each + best];
    }
    return mesh->parts ? 0 : -1;
}

int ex_rig_add_body(ex_scene *scene, const gltf_file *file, uint32_t node, uint32_t object, const char *path,
                    char *error)
{
    const gltf_node *n = &file->nodes[node];
    ex_rig *rig = scene->rig;
    const ex_shape *shape = &rig->shapes[n->mesh];
    const int is_skinned = ex_rig_moves(rig, file, node) == 2;
    if (is_skinned && (size_t)n->skin >= file->skin_count)
        return ex_fail(error, "%s: node %u: skin %d does not exist", path, (unsigned)node, n->skin);
    if (is_skinned && shape->highest_joint >= rig->skins[n->skin].joint_count)
        return ex_fail(error, "%s: mesh %d: JOINTS of vertex %u is %u, skin %d has %u joints", path, n->mesh,
                       (unsigned)shape->highest_vertex, (unsigned)shape->highest_joint, n->skin,
                       (unsigned)rig->skins[n->skin].joint_count);
    rig->moved += (double)shape->vertex_count * (1.0 + shape->target_count);
    if (rig->moved > MOST_MOVED)
        return ex_fail(error, "%s: vertices times morph targets of its nodes are more than %g", path, MOST_MOVED);
    if (ex_grow(&rig->bodies, &rig->body_count, sizeof *rig->bodies) != 0)
        return ex_fail(error, "%s: out of memory", path);
    ex_body *body = &rig->bodies[rig->body_count - 1];
    body->shape = body->mesh = (uint32_t)n->mesh;
    body->object = object;
    body->node = node;
    body->skin = is_skinned ? (uint32_t)n->skin : RIG_NONE;
    rig->nodes[node].body = rig->body_count - 1;
    if (rig->users[n->mesh] > 1) {
        if (copy_mesh(scene, body->mesh, path, error) != 0) return -1;
        body->mesh = scene->objects[object].mesh = scene->mesh_count - 1;
    }
    if (is_skinned && set_parts(rig, shape, &scene->meshes[body->mesh], path, error) != 0) return -1;
    return set_weights(rig, file, node, body, path, error);
}

#endif
