/* shadowfield_mesh.c - see shadowfield_parts.h */
#include "shadowfield_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CUTS = 48, MOST_PIECES = 1000 };

static float edge(const float *a, const float *b)
{
    return sqrtf((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* Into how many pieces each side of a triangle is cut. */
static uint32_t cuts(const ex_mesh *mesh, size_t t, float spacing)
{
    const uint32_t *i = mesh->indices + 3 * t;
    float longest = 0;
    for (int k = 0; k < 3; k++)
        longest =
            fmaxf(longest, edge(mesh->positions + 3 * (size_t)i[k], mesh->positions + 3 * (size_t)i[(k + 1) % 3]));
    longest = ceilf(longest / (2 * spacing));
    return longest > 1 ? longest < MOST_CUTS ? (uint32_t)longest : MOST_CUTS : 1;
}

static float exponent_of(const ex_material *m)
{
    float alpha = m->roughness * m->roughness, n = alpha > 0.01f ? 2 / (alpha * alpha) - 2 : 1000;
    return n > 1 ? n < 1000 ? n : 1000 : 1;
}

void sf_material(const ex_material *material, float values[5])
{
    memset(values, 0, 4 * sizeof *values);
    values[4] = fminf(fmaxf(material->roughness, 0), 1);
}

/* A triangle of c x c small ones, with points of its own. */
static void cut_triangle(sf_surface *s, const ex_mesh *mesh, size_t t, uint32_t c)
{
    const uint32_t *index = mesh->indices + 3 * t;
    uint32_t base = (uint32_t)s->point_count;
    for (uint32_t j = 0; j <= c; j++)
        for (uint32_t i = 0; i + j <= c; i++) {
            float b[3] = { (float)(c - i - j) / (float)c, (float)i / (float)c, (float)j / (float)c }, length = 0;
            float *p = s->positions + 3 * s->point_count, *n = s->normals + 3 * s->point_count;
            memcpy(s->corners + 3 * s->point_count, index, 3 * sizeof *index);
            memcpy(s->shares + 3 * s->point_count, b, sizeof b);
            for (int k = 0; k < 3; k++) {
                p[k] = n[k] = 0;
                for (int v = 0; v < 3; v++) {
                    p[k] += b[v] * mesh->positions[3 * (size_t)index[v] + (size_t)k];
                    n[k] += b[v] * mesh->normals[3 * (size_t)index[v] + (size_t)k];
                }
                length += n[k] * n[k];
            }
            for (int k = 0; k < 3; k++)
                n[k] = length > 1e-12f ? n[k] / sqrtf(length) : k == 1;
            s->material[s->point_count++] = mesh->materials[t];
        }
    for (uint32_t j = 0, row = base; j < c; row += c + 1 - j, j++)
        for (uint32_t i = 0; i + j < c; i++) {
            uint32_t above = row + c + 1 - j, *to = s->triangles + 3 * s->triangle_count++;
            to[0] = row + i, to[1] = row + i + 1, to[2] = above + i;
            if (i + j + 1 < c) {
                to = s->triangles + 3 * s->triangle_count++;
                to[0] = row + i + 1, to[1] = above + i + 1, to[2] = above + i;
            }
        }
}

/* Positions of which those of different pieces lie far apart: layers of cloth are each other's neighbours otherwise. */
static float *spread_pieces(const sf_surface *s, const uint32_t *piece)
{
    float *out = malloc((3 * s->point_count + 1) * sizeof *out), most = 0;
    uint32_t pieces = 0;
    for (size_t i = 0; out && i < 3 * s->point_count; i++)
        most = fmaxf(most, fabsf(out[i] = s->positions[i]));
    for (size_t i = 0; out && i < s->point_count; i++)
        pieces = piece[s->corners[3 * i]] > pieces ? piece[s->corners[3 * i]] : pieces;
    for (size_t i = 0; out && pieces <= MOST_PIECES && i < s->point_count; i++)
        out[3 * i] += 4 * most * (float)piece[s->corners[3 * i]];
    return out;
}

static int choose(sf_surface *s, const ex_scene *scene, float spacing, const uint32_t *piece)
{
    size_t n = s->point_count;
    float *apart = piece ? spread_pieces(s, piece) : NULL;
    sfield_result r;
    if (piece && !apart)
        return -1;
    s->chosen = malloc(n * sizeof *s->chosen);
    s->sources = malloc(3 * n * sizeof *s->sources);
    s->weights = malloc(3 * n * sizeof *s->weights);
    r = !s->chosen || !s->sources || !s->weights
            ? SFIELD_ERR_ALLOC
            : sfield_sparse(&(const sfield_points){ .count = n, .positions = piece ? apart : s->positions,
                                                    .normals = s->normals },
                            spacing, NULL, s->chosen, &s->chosen_count, s->sources, s->weights);
    free(apart);
    if (r != SFIELD_OK)
        return -1;
    s->chosen_positions = malloc(3 * s->chosen_count * sizeof *s->chosen_positions);
    s->chosen_normals = malloc(3 * s->chosen_count * sizeof *s->chosen_normals);
    s->chosen_exponent = malloc(s->chosen_count * sizeof *s->chosen_exponent);
    s->chosen_material = malloc(5 * s->chosen_count * sizeof *s->chosen_material);
    if (!s->chosen_positions || !s->chosen_normals || !s->chosen_exponent || !s->chosen_material)
        return -1;
    for (size_t i = 0; i < s->chosen_count; i++) {
        memcpy(s->chosen_positions + 3 * i, s->positions + 3 * (size_t)s->chosen[i], 3 * sizeof(float));
        memcpy(s->chosen_normals + 3 * i, s->normals + 3 * (size_t)s->chosen[i], 3 * sizeof(float));
        s->chosen_exponent[i] = exponent_of(&scene->materials[s->material[s->chosen[i]]]);
        sf_material(&scene->materials[s->material[s->chosen[i]]], s->chosen_material + 5 * i);
    }
    return 0;
}

int sf_surface_build(sf_surface *s, const ex_scene *scene, const ex_mesh *mesh, float spacing, const uint32_t *piece)
{
    size_t points = mesh->vertex_count, triangles = 0;
    memset(s, 0, sizeof *s);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        size_t c = cuts(mesh, t, spacing);
        points += c > 1 ? (c + 1) * (c + 2) / 2 : 0;
        triangles += c * c;
    }
    s->positions = malloc((3 * points + 1) * sizeof *s->positions);
    s->normals = malloc((3 * points + 1) * sizeof *s->normals);
    s->material = calloc(points + 1, sizeof *s->material);
    s->corners = malloc((3 * points + 1) * sizeof *s->corners);
    s->shares = malloc((3 * points + 1) * sizeof *s->shares);
    s->triangles = malloc((3 * triangles + 1) * sizeof *s->triangles);
    if (!s->positions || !s->normals || !s->material || !s->triangles || !s->corners || !s->shares) {
        sf_surface_free(s);
        return -1;
    }
    memcpy(s->positions, mesh->positions, 3 * (size_t)mesh->vertex_count * sizeof *s->positions);
    memcpy(s->normals, mesh->normals, 3 * (size_t)mesh->vertex_count * sizeof *s->normals);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        for (size_t k = 0; k < 3; k++) {
            s->corners[3 * i + k] = (uint32_t)i;
            s->shares[3 * i + k] = k == 0;
        }
    }
    s->point_count = mesh->vertex_count;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *index = mesh->indices + 3 * t;
        uint32_t c = cuts(mesh, t, spacing);
        if (c > 1) {
            cut_triangle(s, mesh, t, c);
            continue;
        }
        for (int k = 0; k < 3; k++)
            s->material[index[k]] = mesh->materials[t];
        memcpy(s->triangles + 3 * s->triangle_count++, index, 3 * sizeof *index);
    }
    if (choose(s, scene, spacing, piece) == 0)
        return 0;
    sf_surface_free(s);
    return -1;
}

void sf_surface_follow(sf_surface *s, const ex_mesh *mesh)
{
    for (size_t i = 0; i < s->point_count; i++) {
        float *p = s->positions + 3 * i, *n = s->normals + 3 * i, length = 0;
        for (size_t k = 0; k < 3; k++) {
            p[k] = n[k] = 0;
            for (size_t v = 0; v < 3; v++) {
                const size_t at = 3 * (size_t)s->corners[3 * i + v] + k;
                p[k] += s->shares[3 * i + v] * mesh->positions[at];
                n[k] += s->shares[3 * i + v] * mesh->normals[at];
            }
            length += n[k] * n[k];
        }
        for (int k = 0; k < 3; k++)
            n[k] = length > 1e-12f ? n[k] / sqrtf(length) : k == 1;
    }
    for (size_t i = 0; i < s->chosen_count; i++) {
        memcpy(s->chosen_positions + 3 * i, s->positions + 3 * (size_t)s->chosen[i], 3 * sizeof(float));
        memcpy(s->chosen_normals + 3 * i, s->normals + 3 * (size_t)s->chosen[i], 3 * sizeof(float));
    }
}

void sf_surface_free(sf_surface *s)
{
    free(s->positions);
    free(s->normals);
    free(s->material);
    free(s->corners);
    free(s->shares);
    free(s->triangles);
    free(s->chosen);
    free(s->sources);
    free(s->weights);
    free(s->chosen_positions);
    free(s->chosen_normals);
    free(s->chosen_exponent);
    free(s->chosen_material);
    sfield_free(s->self);
    memset(s, 0, sizeof *s);
}

/* ---- what shines ---- */

int sf_glow_build(sf_glow *glow, const ex_scene *scene, const ex_object *object)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    glow->indices = malloc((6 * (size_t)mesh->triangle_count + 1) * sizeof *glow->indices);
    glow->radiance = malloc((6 * (size_t)mesh->triangle_count + 1) * sizeof *glow->radiance);
    glow->count = 0;
    if (!glow->indices || !glow->radiance) {
        sf_glow_free(glow);
        return -1;
    }
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const ex_material *material = &scene->materials[ex_object_material(scene, object, t)];
        const uint32_t *from = mesh->indices + 3 * (size_t)t;
        const int shines = material->emission[0] > 0 || material->emission[1] > 0 || material->emission[2] > 0;
        for (int side = 0; side <= (shines && material->double_sided); side++, glow->count++) {
            uint32_t *to = glow->indices + 3 * (size_t)glow->count;
            memcpy(to, from, 3 * sizeof *from);
            if (side)
                to[0] = from[1], to[1] = from[0];
            memcpy(glow->radiance + 3 * (size_t)glow->count, material->emission, 3 * sizeof *glow->radiance);
        }
    }
    return 0;
}

int sf_glow_same(const sf_glow *a, const sf_glow *b)
{
    return a->count == b->count && memcmp(a->indices, b->indices, 3 * sizeof *a->indices * (size_t)a->count) == 0 &&
           memcmp(a->radiance, b->radiance, 3 * sizeof *a->radiance * (size_t)a->count) == 0;
}

void sf_glow_free(sf_glow *glow)
{
    free(glow->indices);
    free(glow->radiance);
    memset(glow, 0, sizeof *glow);
}

/* ---- pixels ---- */

typedef struct frame_of { float eye[3], right[3], up[3], back[3], focal_x, focal_y, width, height; } frame_of;

static void cross(const float *a, const float *b, float *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void normalise(float *a)
{
    float length = sqrtf(dot(a, a));
    for (int k = 0; k < 3; k++)
        a[k] /= length > 0 ? length : 1;
}

static void make_frame(frame_of *f, const rd_job *job)
{
    const ex_camera *c = &job->scene->camera;
    memcpy(f->eye, c->eye, sizeof f->eye);
    for (int k = 0; k < 3; k++)
        f->back[k] = c->eye[k] - c->target[k];
    normalise(f->back);
    cross(c->up, f->back, f->right);
    normalise(f->right);
    cross(f->back, f->right, f->up);
    f->width = (float)job->gbuffer->width;
    f->height = (float)job->gbuffer->height;
    f->focal_x = f->focal_y = 0.5f * f->height / tanf(0.5f * c->fovy);
}

/* How far p is off the triangle, in units of its size; b: nearest weights inside. */
static float off(const float v[3][3], const float *p, float *b)
{
    float e[3], g[3], n[3], q[3], r[3], nn, sum = 0, worst;
    for (int k = 0; k < 3; k++) {
        e[k] = v[1][k] - v[0][k];
        g[k] = v[2][k] - v[0][k];
        q[k] = p[k] - v[0][k];
    }
    cross(e, g, n);
    nn = dot(n, n);
    if (!(nn > 0))
        return HUGE_VALF;
    cross(q, g, r);
    b[1] = dot(r, n) / nn;
    cross(e, q, r);
    b[2] = dot(r, n) / nn;
    b[0] = 1 - b[1] - b[2];
    worst = fabsf(dot(q, n)) / powf(nn, 0.75f);
    for (int k = 0; k < 3; k++) {
        worst = fmaxf(worst, -b[k]);
        b[k] = fmaxf(b[k], 0);
        sum += b[k];
    }
    for (int k = 0; k < 3; k++)
        b[k] /= sum;
    return worst;
}

/* The box of pixels that a triangle may show in; a corner behind the eye: all of them. */
static void box_of(const frame_of *f, const float v[3][3], int *box)
{
    float low[2] = { 1e9f, 1e9f }, high[2] = { -1e9f, -1e9f };
    box[0] = box[1] = 0;
    box[2] = (int)f->width - 1;
    box[3] = (int)f->height - 1;
    for (int i = 0; i < 3; i++) {
        float d[3] = { v[i][0] - f->eye[0], v[i][1] - f->eye[1], v[i][2] - f->eye[2] }, depth = -dot(d, f->back), at[2];
        if (!(depth > 1e-4f * sqrtf(dot(d, d))))
            return;
        at[0] = 0.5f * f->width + f->focal_x * dot(d, f->right) / depth;
        at[1] = 0.5f * f->height - f->focal_y * dot(d, f->up) / depth;
        for (int k = 0; k < 2; k++) {
            low[k] = fminf(low[k], at[k]);
            high[k] = fmaxf(high[k], at[k]);
        }
    }
    box[0] = (int)fmaxf(low[0] - 2, 0);
    box[1] = (int)fmaxf(low[1] - 2, 0);
    box[2] = (int)fminf(high[0] + 2, f->width - 1);
    box[3] = (int)fminf(high[1] + 2, f->height - 1);
}

int sf_taps_build(sf_tap *taps, const rd_job *job, const sf_surface *const *surfaces)
{
    size_t pixels = (size_t)job->gbuffer->width * job->gbuffer->height;
    float *best = malloc((pixels + 1) * sizeof *best);
    frame_of f;
    if (!best)
        return -1;
    make_frame(&f, job);
    memset(taps, 0, pixels * sizeof *taps);
    for (size_t i = 0; i < pixels; i++)
        best[i] = HUGE_VALF;
    for (uint32_t o = 0; o < job->scene->object_count; o++) {
        const sf_surface *s = surfaces[o];
        const float *m = job->scene->objects[o].transform;
        for (size_t t = 0; s && t < s->triangle_count; t++) {
            const uint32_t *index = s->triangles + 3 * t;
            float v[3][3];
            int box[4];
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < 3; k++) {
                    const float *p = s->positions + 3 * (size_t)index[i];
                    v[i][k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
                }
            box_of(&f, (const float (*)[3])v, box);
            for (int y = box[1]; y <= box[3]; y++)
                for (int x = box[0]; x <= box[2]; x++) {
                    size_t at = (size_t)y * job->gbuffer->width + (size_t)x;
                    float b[3], e;
                    if (job->gbuffer->pixels[at].object != o)
                        continue;
                    e = off((const float (*)[3])v, job->gbuffer->pixels[at].position, b);
                    if (!(e < best[at]))
                        continue;
                    best[at] = e;
                    memcpy(taps[at].point, index, sizeof taps[at].point);
                    memcpy(taps[at].weight, b, sizeof taps[at].weight);
                }
        }
    }
    free(best);
    return 0;
}

int sf_emitter_of(const ex_light *light, float lamp_radius, sfield_emitter *out)
{
    memset(out, 0, sizeof *out);
    out->radiance[0] = out->radiance[1] = out->radiance[2] = 1;
    out->radius = light->radius;
    switch (light->kind) {
    case EX_LIGHT_SPOT:
        memcpy(out->normal, light->direction, sizeof out->normal);
        out->cone_half_angle = acosf(light->cos_half_angle);
        /* fall through */
    case EX_LIGHT_POINT:
        out->radius = lamp_radius;
        return 0;
    case EX_LIGHT_DISC:
        out->kind = SFIELD_EMITTER_DISC;
        memcpy(out->normal, light->direction, sizeof out->normal);
        return 0;
    case EX_LIGHT_RECT:
        out->kind = SFIELD_EMITTER_RECTANGLE;
        for (int k = 0; k < 3; k++) {
            out->u[k] = 0.5f * light->u[k];
            out->v[k] = 0.5f * light->v[k];
        }
        return 0;
    case EX_LIGHT_LINE:
        out->kind = SFIELD_EMITTER_CYLINDER;
        for (int k = 0; k < 3; k++)
            out->u[k] = 0.5f * light->u[k];
        return 0;
    case EX_LIGHT_SPHERE:
        return 0;
    default:
        return -1;
    }
}
