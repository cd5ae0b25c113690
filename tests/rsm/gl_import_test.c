/* gl_import_test - maps that glbk_rsm_map_import reads from textures of the user's own: against closed forms of a wall
   that every kind of light looks at, and against the map that glbk_rsm_map_draw draws of a scene which a program of the
   user's draws as well, with depths of both directions, into 2D textures, layers of arrays and faces of cubes. */
#define _POSIX_C_SOURCE 200809L
#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_rsm.h"

#include "gl_test.h"
#include "gl_count.h"
#include "gl_state.h"
#include "util.h"
#include "gl_util.h"

enum { SIDE = 16, TEXELS = SIDE * SIDE, LEFT = 3, BOTTOM = 5, ATLAS = 24, DRAWN = 48 };
enum { FLAT, ARRAY, CUBE, WAYS };       /* 2D textures, layers of arrays, cubes */
static const float ALBEDO = 0.5f;

/* ---- the closed form: a wall with a normal that all rays of a face meet ---- */

static const float eye[3] = { 0.5f, 1, -0.25f };

static rsm_light lamp_of(rsm_light_kind kind)
{
    rsm_light l;
    memset(&l, 0, sizeof l);
    l.kind = kind;
    memcpy(l.position, eye, sizeof eye);
    set3(l.direction, 0, 0, kind == RSM_LIGHT_SUN ? 1 : -1);
    set3(l.value, 3, 2, 1);
    l.cone_half_angle = 0.6f;
    l.radius = 1.5f;
    l.near_depth = kind == RSM_LIGHT_SUN ? -2.0f : 0.125f;
    l.far_depth = 20;
    return l;
}

static glbk_rsm_renderer renderer_of(gl_test *t)
{
    glbk_rsm_renderer r;
    glbk_rsm_renderer_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = 4;
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &d, &r));
    return r;
}

/* A depth buffer's value of a depth z, 0 near .. 1 far or reversed. */
static double stored_depth(const rsm_light *l, double z, int reversed)
{
    double n = (double)l->near_depth, f = (double)l->far_depth;
    double s = l->kind == RSM_LIGHT_SUN ? (z - n) / (f - n) : f * (z - n) / (z * (f - n));
    return reversed ? 1 - s : s;
}

/* Axes of face 0 .. 5 of a lamp that looks along -z with y up, as rsm_map_matrix names them: forward, right, left, up,
   down, back. */
static const double rights[6][3] = { { 1, 0, 0 }, { 0, 0, 1 }, { 0, 0, -1 }, { 1, 0, 0 }, { 1, 0, 0 }, { -1, 0, 0 } };
static const double ups[6][3] = { { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 0, 0, -1 }, { 0, 1, 0 } };
static const double forwards[6][3] = {
    { 0, 0, -1 }, { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }
};

/* The wall of a face: through its axis at a distance of 2 + face / 4, turned about the face's up by 0.3. */
typedef struct ray { double place[3], depth, normal[3]; } ray;

static ray ray_of(const rsm_light *l, uint32_t face, uint32_t i, uint32_t j)
{
    const double tilt = 0.3, away = 2 + 0.25 * face;
    const int sun = l->kind == RSM_LIGHT_SUN, wide = l->kind == RSM_LIGHT_POINT || l->kind == RSM_LIGHT_PATCH;
    const double extent = sun ? (double)l->radius : wide ? 1 : tan((double)l->cone_half_angle);
    const double x = ((i + 0.5) * 2 / SIDE - 1) * extent, y = ((j + 0.5) * 2 / SIDE - 1) * extent;
    ray r;
    int k;
    /* The wall's normal is n = sin(tilt) right - cos(tilt) forward, its plane z = away + tan(tilt) x. */
    r.depth = sun ? away + tan(tilt) * x : away / (1 - tan(tilt) * x);
    for (k = 0; k < 3; k++) {
        const double s = sun ? 1 : r.depth;
        r.place[k] = (double)eye[k] + s * (rights[face][k] * x + ups[face][k] * y) + forwards[face][k] * r.depth;
        r.normal[k] = sin(tilt) * rights[face][k] - cos(tilt) * forwards[face][k];
    }
    return r;
}

/* Direction through a texel of a face of a cube, as OpenGL's table of cube maps has it. */
static void cube_direction(uint32_t face, uint32_t i, uint32_t j, double d[3])
{
    static const double major[6][3] = {
        { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 }
    };
    static const double across[6][3] = {
        { 0, 0, -1 }, { 0, 0, 1 }, { 1, 0, 0 }, { 1, 0, 0 }, { 1, 0, 0 }, { -1, 0, 0 }
    };
    static const double along[6][3] = {
        { 0, -1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 }, { 0, -1, 0 }, { 0, -1, 0 }
    };
    double s = (i + 0.5) * 2 / SIDE - 1, t = (j + 0.5) * 2 / SIDE - 1;
    int k;
    for (k = 0; k < 3; k++) d[k] = major[face][k] + s * across[face][k] + t * along[face][k];
}

/* The face of the lamp and the texel that a direction passes. */
static uint32_t texel_of(const double d[3], uint32_t *i, uint32_t *j)
{
    uint32_t face;
    for (face = 0; face < 6; face++) {
        double z = 0, x = 0, y = 0;
        int k;
        for (k = 0; k < 3; k++) z += d[k] * forwards[face][k], x += d[k] * rights[face][k], y += d[k] * ups[face][k];
        if (z < 0.999999) continue;     /* cube_direction's are 1 along their axis */
        *i = (uint32_t)((x / z * 0.5 + 0.5) * SIDE);
        *j = (uint32_t)((y / z * 0.5 + 0.5) * SIDE);
        return face;
    }
    return fail(), 0u;
}

typedef struct pictures {
    float    depth[TEXELS], normals[4 * TEXELS], places[4 * TEXELS];
    uint32_t materials[TEXELS];
} pictures;

static void picture_texel(pictures *p, size_t at, const rsm_light *l, uint32_t face, uint32_t i, uint32_t j,
                          int reversed)
{
    const ray r = ray_of(l, face, i, j);
    int k;
    p->depth[at] = (float)stored_depth(l, r.depth, reversed);
    for (k = 0; k < 3; k++) {
        p->normals[4 * at + (size_t)k] = (float)r.normal[k];
        p->places[4 * at + (size_t)k] = (float)r.place[k];
    }
    p->places[4 * at + 3] = 1;
    p->materials[at] = 7 + face;
    if ((i + j) % 5) return;
    if (i % 2) p->depth[at] = reversed ? 0 : 1; /* nothing is seen, by the depth or by the normal */
    else memset(p->normals + 4 * at, 0, 16);
}

/* What a way of lying holds for a face of the lamp, or a face of GL's cube. */
static void make_pictures(pictures *p, const rsm_light *l, uint32_t face, int way, int reversed)
{
    uint32_t i, j, at_i = 0, at_j = 0, at_face;
    double d[3];
    for (j = 0; j < SIDE; j++)
        for (i = 0; i < SIDE; i++) {
            at_i = i, at_j = j, at_face = face;
            if (way == CUBE) cube_direction(face, i, j, d), at_face = texel_of(d, &at_i, &at_j);
            picture_texel(p, (size_t)j * SIDE + i, l, at_face, at_i, at_j, reversed);
        }
}

enum { GL_POSITIVE_X = 0x8515, GL_RED = 0x1903, GL_DEPTH_COMPONENT = 0x1902, GL_DEPTH_COMPONENT32F = 0x8CAC,
       GL_RGBA = 0x1908, GL_RGBA8 = 0x8058, GL_RGBA32F = 0x8814, GL_R32UI = 0x8236, GL_RED_INTEGER = 0x8D94,
       GL_MIN_FILTER = 0x2801, GL_MAG_FILTER = 0x2800, GL_NEAREST = 0x2600, GL_LINEAR = 0x2601 };

/* A cube of the user's: of one of the four formats of the pictures, or to be drawn to with NULL data. */
static glbk_texture cube_make(gl_test *t, uint32_t side, int internal, uint32_t format, uint32_t type)
{
    glbk_texture c;
    uint32_t face;
    memset(&c, 0, sizeof c);
    t->gl.gl.GenTextures(1, &c.name);
    c.width = c.height = side;
    c.gl_target = GLBK_GL_TEXTURE_CUBE_MAP;
    t->gl.gl.BindTexture(GLBK_GL_TEXTURE_CUBE_MAP, c.name);
    for (face = 0; face < 6; face++)
        t->gl.gl.TexImage2D(GL_POSITIVE_X + face, 0, internal, (int32_t)side, (int32_t)side, 0, format, type, NULL);
    t->gl.gl.TexParameteri(GLBK_GL_TEXTURE_CUBE_MAP, GL_MIN_FILTER, GL_NEAREST);
    t->gl.gl.TexParameteri(GLBK_GL_TEXTURE_CUBE_MAP, GL_MAG_FILTER, GL_NEAREST);
    return c;
}

typedef struct own { glbk_texture depth, normals, places, materials; } own;

static glbk_texture image(gl_test *t, glbk_format format, int way)
{
    glbk_texture texture;
    glbk_texture_desc d;
    if (way == CUBE) {
        if (format == GLBK_FORMAT_DEPTH32F)
            return cube_make(t, SIDE, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GLBK_GL_FLOAT);
        if (format == GLBK_FORMAT_R32UI) return cube_make(t, SIDE, GL_R32UI, GL_RED_INTEGER, GLBK_GL_UNSIGNED_INT);
        return cube_make(t, SIDE, GL_RGBA32F, GL_RGBA, GLBK_GL_FLOAT);
    }
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = d.height = way == FLAT ? ATLAS : SIDE;
    d.layers = way == ARRAY ? 7 : 0;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture));
    return texture;
}

static void put(gl_test *t, const glbk_texture *texture, int way, uint32_t face, uint32_t format, uint32_t type,
                const void *data)
{
    glbk_box box = { 0, LEFT, BOTTOM, 0, SIDE, SIDE, 1 };
    if (way == CUBE) {
        t->gl.gl.BindTexture(GLBK_GL_TEXTURE_CUBE_MAP, texture->name);
        t->gl.gl.TexSubImage2D(GL_POSITIVE_X + face, 0, 0, 0, SIDE, SIDE, format, type, data);
        return;
    }
    if (way == ARRAY) box.x = box.y = 0, box.layer = 1 + face;
    assert_glbk(t, glbk_texture_update(&t->gl, texture, &box, data));
}

/* Fills what face `face` reads; a cube as a whole. */
static void fill(gl_test *t, own *o, const rsm_light *l, uint32_t face, int way, int reversed)
{
    static pictures p;
    uint32_t first = way == CUBE ? 0 : face, last = way == CUBE ? 5 : face;
    for (face = first; face <= last; face++) {
        make_pictures(&p, l, face, way, reversed);
        put(t, &o->depth, way, face, GL_DEPTH_COMPONENT, GLBK_GL_FLOAT, p.depth);
        put(t, &o->normals, way, face, GL_RGBA, GLBK_GL_FLOAT, p.normals);
        put(t, &o->places, way, face, GL_RGBA, GLBK_GL_FLOAT, p.places);
        put(t, &o->materials, way, face, GL_RED_INTEGER, GLBK_GL_UNSIGNED_INT, p.materials);
    }
}

static glbk_rsm_import import_of(const own *o, uint32_t face, int way, int reversed)
{
    glbk_rsm_import in;
    memset(&in, 0, sizeof in);
    in.depth.texture = &o->depth;
    in.normals.texture = &o->normals;
    in.materials.texture = &o->materials;
    in.clip_depth = reversed ? GLBK_CLIP_DEPTH_REVERSED : GLBK_CLIP_DEPTH_DEFAULT;
    in.color[0] = in.color[1] = in.color[2] = ALBEDO;
    if (way == FLAT) in.left = LEFT, in.bottom = BOTTOM;
    if (way == ARRAY) in.depth.layer = in.normals.layer = in.positions.layer = in.materials.layer = 1 + face;
    return in;
}

static double distance(const float *a, const double *b)
{
    return sqrt(pow((double)a[0] - b[0], 2) + pow((double)a[1] - b[1], 2) + pow((double)a[2] - b[2], 2));
}

/* Compares a face with the closed form; returns the flux of its texels, and of those that nothing is seen in as if
   they had a wall too. */
static double check_face(const glbk_rsm_map *map, uint32_t face, const rsm_texel *texels, int by_depth, double bound)
{
    double sum = 0;
    uint32_t i, j;
    for (j = 0; j < SIDE; j++)
        for (i = 0; i < SIDE; i++) {
            const rsm_texel *x = &texels[(size_t)j * SIDE + i];
            const ray r = ray_of(&map->light, face, i, j);
            if ((i + j) % 5 == 0 && (by_depth || i % 2 == 0)) {
                assert_true(x->depth >= RSM_FAR);
                assert_true(!(x->flux[0] > 0) && !(x->area > 0));
                continue;
            }
            if (distance(x->position, r.place) > bound || fabs((double)x->depth - r.depth) > bound)
                print_message("face %u texel %u %u: %g %g %g depth %g, not %g %g %g depth %g\n", face, i, j,
                              (double)x->position[0], (double)x->position[1], (double)x->position[2], (double)x->depth,
                              r.place[0], r.place[1], r.place[2], r.depth);
            assert_true(distance(x->position, r.place) <= bound);
            assert_true(fabs((double)x->depth - r.depth) <= bound);
            assert_true(distance(x->normal, r.normal) <= 1e-6);
            assert_int_equal(x->material, 7 + face);
            assert_true(x->area > 0);
            sum += (double)x->flux[0];
        }
    return sum;
}

/* Light of value 1 through all texels of a face that have a wall, in the plane at distance 1 by the midpoint rule. */
static double light_through(const rsm_light *l, int by_depth)
{
    const int sun = l->kind == RSM_LIGHT_SUN, wide = l->kind == RSM_LIGHT_POINT, fine = 24;
    const double extent = sun ? (double)l->radius : wide ? 1 : tan((double)l->cone_half_angle);
    const double step = 2 * extent / SIDE / fine;
    double sum = 0;
    int i, j;
    for (j = 0; j < SIDE * fine; j++)
        for (i = 0; i < SIDE * fine; i++) {
            const int ti = i / fine, tj = j / fine;
            const double x = (i + 0.5) * step - extent, y = (j + 0.5) * step - extent;
            if ((ti + tj) % 5 == 0 && (by_depth || ti % 2 == 0)) continue;
            sum += step * step * (sun ? 1 : pow(1 + x * x + y * y, -1.5));
        }
    return sum;
}

/* All faces of a map by one way of lying, by depths or by positions. */
static void import_all(gl_test *t, glbk_rsm_renderer *r, glbk_rsm_map *map, own *o, int way, int reversed, int by_depth)
{
    static rsm_texel texels[TEXELS];
    const rsm_light *l = &map->light;
    uint32_t face;
    for (face = 0; face < map->face_count; face++) {
        glbk_rsm_import in = import_of(o, face, way, reversed);
        double flux;
        if (!by_depth) in.depth.texture = NULL, in.positions.texture = &o->places;
        if (way != CUBE || face == 0) fill(t, o, l, face, way, reversed);
        assert_glbk(t, glbk_rsm_map_import(&t->gl, r, map, face, &in));
        assert_glbk(t, glbk_rsm_map_read(&t->gl, map, face, texels));
        flux = check_face(map, face, texels, by_depth, by_depth ? 4e-5 : 1e-6);
        if (l->kind != RSM_LIGHT_PATCH)
            assert_true(fabs(flux - 3 * (double)ALBEDO * light_through(l, by_depth)) < 2e-5 * flux);
    }
}

static void a_wall_is_imported_by_every_light_from_every_kind_of_texture(void **state)
{
    GL_TEST(t, state)
    static const rsm_light_kind kinds[] = { RSM_LIGHT_SUN, RSM_LIGHT_SQUARE_SPOT, RSM_LIGHT_POINT, RSM_LIGHT_PATCH };
    glbk_rsm_renderer r = renderer_of(t);
    size_t k;
    int way, reversed;
    for (k = 0; k < sizeof kinds / sizeof kinds[0]; k++)
        for (way = FLAT; way < WAYS; way++) {
            rsm_light l = lamp_of(kinds[k]);
            glbk_rsm_map map;
            own o;
            /* A cube has other texels than a spot's narrow face. */
            if (way == CUBE && kinds[k] != RSM_LIGHT_POINT && kinds[k] != RSM_LIGHT_PATCH) continue;
            assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &map));
            o.depth = image(t, GLBK_FORMAT_DEPTH32F, way);
            o.normals = image(t, GLBK_FORMAT_RGBA32F, way);
            o.places = image(t, GLBK_FORMAT_RGBA32F, way);
            o.materials = image(t, GLBK_FORMAT_R32UI, way);
            for (reversed = 0; reversed < 2; reversed++) import_all(t, &r, &map, &o, way, reversed, 1);
            import_all(t, &r, &map, &o, way, 0, 0);
            glbk_texture_free(&t->gl, &o.depth);
            glbk_texture_free(&t->gl, &o.normals);
            glbk_texture_free(&t->gl, &o.places);
            glbk_texture_free(&t->gl, &o.materials);
            glbk_rsm_map_free(&t->gl, &map);
        }
    glbk_rsm_renderer_free(&t->gl, &r);
}

/* ---- a cube that does not lie along the light's axes ---- */

/* A room about the light whose walls are 2, 2.5 and 3 away, as a face of GL's cube sees it. */
static const double walls[3] = { 2, 2.5, 3 };

static void room_face(pictures *p, const rsm_light *l, uint32_t face)
{
    uint32_t i, j;
    memset(p, 0, sizeof *p);
    for (j = 0; j < SIDE; j++)
        for (i = 0; i < SIDE; i++) {
            const size_t at = (size_t)j * SIDE + i;
            double d[3], z = 1e30;
            int k, wall = 0;
            cube_direction(face, i, j, d);
            for (k = 0; k < 3; k++)
                if (walls[k] / fabs(d[k]) < z) z = walls[k] / fabs(d[k]), wall = k;
            p->depth[at] = (float)stored_depth(l, z, 0);
            p->normals[4 * at + (size_t)wall] = d[wall] > 0 ? -1.0f : 1.0f;
            p->materials[at] = (uint32_t)wall;
        }
}

/* Each texel has a place on a wall, which the cube's texel that its ray meets has seen: no farther from the ray than
   half of that. m: the matrix of the map's face, whose rows are the light's axes. Returns the flux of all. */
static double check_room(const float m[16], const rsm_texel *texels)
{
    double flux = 0;
    uint32_t i, j;
    for (j = 0; j < SIDE; j++)
        for (i = 0; i < SIDE; i++) {
            const rsm_texel *x = &texels[(size_t)j * SIDE + i];
            const double u = (i + 0.5) * 2 / SIDE - 1, v = (j + 0.5) * 2 / SIDE - 1;
            double d[3], q[3], most = 0, reach = 0, near_wall = 0, depth = 0;
            int k;
            for (k = 0; k < 3; k++) {
                d[k] = (double)m[4 * k + 3] + u * (double)m[4 * k] + v * (double)m[4 * k + 1];
                q[k] = (double)x->position[k] - (double)eye[k];
                most = fmax(most, fabs(d[k]));
                reach = fmax(reach, fabs(q[k]));
                near_wall = fmax(near_wall, fabs(q[k]) / walls[k]);
                depth += q[k] * (double)m[4 * k + 3];
            }
            assert_true(fabs(near_wall - 1) < 1e-5);
            for (k = 0; k < 3; k++) assert_true(fabs(q[k] / reach - d[k] / most) < 1.0 / SIDE + 1e-5);
            assert_true(x->material < 3 && fabs(fabs(q[x->material]) / walls[x->material] - 1) < 1e-5);
            assert_true((double)x->normal[x->material] * q[x->material] < -0.99 * walls[x->material]);
            assert_true(fabs((double)x->depth - depth) < 1e-5);
            flux += (double)x->flux[0];
        }
    return flux;
}

/* Lights that look askew, with five and six faces: texels of the cube lie across two faces of theirs. A patch sends
   value x pi, a spot value x 2 pi (1 - cos). */
static void a_cube_need_not_lie_along_the_axes_of_the_light(void **state)
{
    GL_TEST(t, state)
    static const rsm_light_kind kinds[] = { RSM_LIGHT_PATCH, RSM_LIGHT_SPOT };
    static rsm_texel texels[TEXELS];
    static pictures p;
    glbk_rsm_renderer r = renderer_of(t);
    uint32_t face;
    int k;
    for (k = 0; k < 2; k++) {
        rsm_light l = lamp_of(kinds[k]);
        const double pi = 3.14159265358979;
        glbk_rsm_import in;
        glbk_rsm_map map;
        rsm_map *matrices;
        rsm_desc desc;
        double flux = 0, wanted;
        float m[16];
        own o;
        set3(l.direction, 0.36, -0.8, -0.48);
        set3(l.up, 0.3, 0.1, -0.7);
        l.cone_half_angle = 2.5f;
        memset(&desc, 0, sizeof desc);
        desc.light = l;
        desc.side = SIDE;
        assert_int_equal(rsm_map_create(&desc, &matrices), RSM_OK);
        assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &map));
        assert_int_equal(map.face_count, k ? 6 : 5);
        o.depth = image(t, GLBK_FORMAT_DEPTH32F, CUBE);
        o.normals = image(t, GLBK_FORMAT_RGBA32F, CUBE);
        o.materials = image(t, GLBK_FORMAT_R32UI, CUBE);
        for (face = 0; face < 6; face++) {
            room_face(&p, &l, face);
            put(t, &o.depth, CUBE, face, GL_DEPTH_COMPONENT, GLBK_GL_FLOAT, p.depth);
            put(t, &o.normals, CUBE, face, GL_RGBA, GLBK_GL_FLOAT, p.normals);
            put(t, &o.materials, CUBE, face, GL_RED_INTEGER, GLBK_GL_UNSIGNED_INT, p.materials);
        }
        in = import_of(&o, 0, CUBE, 0);
        for (face = 0; face < map.face_count; face++) {
            assert_int_equal(rsm_map_matrix(matrices, face, m), RSM_OK);
            assert_glbk(t, glbk_rsm_map_import(&t->gl, &r, &map, face, &in));
            assert_glbk(t, glbk_rsm_map_read(&t->gl, &map, face, texels));
            flux += check_room(m, texels);
        }
        wanted = 3 * (double)ALBEDO * pi * (k ? 2 * (1 - cos(2.5)) : 1);
        print_message("%s askew: flux %g of %g\n", k ? "spot" : "patch", flux, wanted);
        assert_true(fabs(flux / wanted - 1) < 5e-3);
        rsm_map_free(matrices);
        glbk_rsm_map_free(&t->gl, &map);
        glbk_texture_free(&t->gl, &o.depth);
        glbk_texture_free(&t->gl, &o.normals);
        glbk_texture_free(&t->gl, &o.materials);
    }
    glbk_rsm_renderer_free(&t->gl, &r);
}

/* ---- colours that are no numbers, in maps that are drawn ---- */

/* GLSL of the user's gives one channel that is no number, or is endless, in half of the texels: these send no light,
   and the others do. */
static void a_colour_that_is_no_number_sends_no_light(void **state)
{
    GL_TEST(t, state)
    static const char *const bits[] = { "0x7fc00000u", "0xffc00001u", "0x7f800000u", "0x7f7fffffu" };
    static rsm_texel texels[TEXELS];
    static const float wall[9] = { -2, -2, -1, 4, 0, 0, 0, 4, 0 };
    model quad = model_quads(wall, 1);
    rsm_mesh mesh = mesh_of(&quad, 0.5);
    rsm_light l = lamp_of(RSM_LIGHT_SQUARE_SPOT);
    glbk_rsm_map map;
    scene s;
    size_t k, i;
    set3(l.position, 0, 0, 1);
    scene_make(t, &s, &mesh, 1);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &map));
    for (k = 0; k < sizeof bits / sizeof bits[0]; k++) {
        glbk_rsm_renderer r;
        glbk_rsm_renderer_desc d;
        size_t dark = 0;
        char fragment[200];
        snprintf(fragment, sizeof fragment,
                 "bool glbk_fragment(vec2 uv, inout vec4 color)\n{\n"
                 "    if (gl_FragCoord.x < 8.0) color.g = uintBitsToFloat(%s ^ uint(gl_FragCoord.y > 99.0));\n"
                 "    return true;\n}\n", bits[k]);
        memset(&d, 0, sizeof d);
        d.width = d.height = 4;
        d.attributes.fragment = fragment;
        assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &d, &r));
        assert_glbk(t, glbk_rsm_map_draw(&t->gl, &r, &map, scene_draw, &s));
        assert_glbk(t, glbk_rsm_map_read(&t->gl, &map, 0, texels));
        for (i = 0; i < TEXELS; i++) {
            const int odd = i % SIDE < 8;
            assert_true(texels[i].depth < 3);
            dark += texels[i].flux[0] == 0 && texels[i].flux[1] == 0 && texels[i].flux[2] == 0;
            if (!odd) assert_true(texels[i].flux[0] > 0 && texels[i].flux[1] > 0 && texels[i].flux[2] > 0);
        }
        assert_int_equal(dark, TEXELS / 2);
        glbk_rsm_renderer_free(&t->gl, &r);
    }
    scene_free(t, &s);
    glbk_rsm_map_free(&t->gl, &map);
    model_free(&quad);
}

/* ---- against the map that glbk_rsm_map_draw draws ---- */

/* A room open to the front with a box in it that stands askew. */
static const float quads[] = {
    -1, 0, -1, 2, 0, 0, 0, 0, 2,     -1, 0, -1, 2, 0, 0, 0, 2, 0,     -1, 0, -1, 0, 0, 2, 0, 2, 0,
    1, 0, -1, 0, 0, 2, 0, 2, 0,      -1, 2, -1, 2, 0, 0, 0, 0, 2,
    -0.3f, 0, 0, 0.5f, 0, 0.2f, 0, 0.7f, 0,     -0.3f, 0.7f, 0, 0.5f, 0, 0.2f, -0.2f, 0, 0.5f,
    0.2f, 0, 0.2f, -0.2f, 0, 0.5f, 0, 0.7f, 0
};

static const char own_vertex[] =
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip;\n"
    "out vec3 place;\n"
    "void main() { place = position; gl_Position = clip * vec4(position, 1.0); }\n";
static const char own_fragment[] =
    "in vec3 place;\n"
    "uniform vec4 eye, albedo;\n"       /* eye.w is 0: a direction */
    "layout(location = 0) out vec4 normal;\n"
    "layout(location = 1) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(cross(dFdx(place), dFdy(place)));\n"
    "    if (dot(n, eye.xyz - place * eye.w) < 0.0) n = -n;\n"
    "    normal = vec4(n * 0.5 + 0.5, 1.0);\n"
    "    color = albedo;\n"
    "}\n";

/* The user's renderer: its program, its framebuffer, and textures of a way of lying. */
typedef struct renderer { glbk_program program; uint32_t framebuffer; glbk_texture depth, normals, colors; } renderer;

enum { GL_DEPTH_TEST = 0x0B71, GL_LESS = 0x0201, GL_GREATER = 0x0204 };

static void renderer_make(gl_test *t, renderer *o, int way)
{
    glbk_texture_desc d;
    glbk_source source;
    memset(&source, 0, sizeof source);
    source.vertex = own_vertex;
    source.fragment = own_fragment;
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &o->program));
    t->gl.gl.GenFramebuffers(1, &o->framebuffer);
    if (way == CUBE) {
        o->depth = cube_make(t, DRAWN, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GLBK_GL_FLOAT);
        o->normals = cube_make(t, DRAWN, GL_RGBA8, GL_RGBA, GLBK_GL_UNSIGNED_BYTE);
        o->colors = cube_make(t, DRAWN, GL_RGBA8, GL_RGBA, GLBK_GL_UNSIGNED_BYTE);
        return;
    }
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_DEPTH32F;
    d.width = d.height = DRAWN;
    d.layers = way == ARRAY ? 6 : 0;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &o->depth));
    d.format = GLBK_FORMAT_RGBA8;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &o->normals));
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &o->colors));
}

static void renderer_free(gl_test *t, renderer *o)
{
    glbk_program_free(&t->gl, &o->program);
    t->gl.gl.DeleteFramebuffers(1, &o->framebuffer);
    glbk_texture_free(&t->gl, &o->depth);
    glbk_texture_free(&t->gl, &o->normals);
    glbk_texture_free(&t->gl, &o->colors);
}

static void attach(gl_test *t, uint32_t at, const glbk_texture *texture, int way, uint32_t face)
{
    if (way == ARRAY) t->gl.gl.FramebufferTextureLayer(GLBK_GL_FRAMEBUFFER, at, texture->name, 0, (int32_t)face);
    else
        t->gl.gl.FramebufferTexture2D(GLBK_GL_FRAMEBUFFER, at, way == CUBE ? GL_POSITIVE_X + face : GLBK_GL_TEXTURE_2D,
                                      texture->name, 0);
}

/* The user draws a face by a matrix; reversed: its depths are turned, as with a matrix made for that. */
static void draw_face(gl_test *t, const renderer *o, const scene *s, const rsm_light *l, const float matrix[16],
                      int way, uint32_t face, int reversed)
{
    static const float nothing[4] = { 0, 0, 0, 0 };
    static const uint32_t buffers[2] = { GLBK_GL_COLOR_ATTACHMENT0, GLBK_GL_COLOR_ATTACHMENT0 + 1 };
    const glbk_functions *gl = &t->gl.gl;
    const float cleared = reversed ? 0 : 1, sun = l->kind == RSM_LIGHT_SUN;
    const float *from = sun > 0 ? l->direction : l->position, seen_from[4] = { from[0], from[1], from[2], 1 - sun };
    float clip[16];
    size_t i;
    memcpy(clip, matrix, sizeof clip);
    for (i = 2; i < 16 && reversed; i += 4) clip[i] = -clip[i];
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, o->framebuffer);
    attach(t, GLBK_GL_COLOR_ATTACHMENT0, &o->normals, way, face);
    attach(t, GLBK_GL_COLOR_ATTACHMENT0 + 1, &o->colors, way, face);
    attach(t, GLBK_GL_DEPTH_ATTACHMENT, &o->depth, way, face);
    gl->DrawBuffers(2, buffers);
    assert_int_equal(gl->CheckFramebufferStatus(GLBK_GL_FRAMEBUFFER), 0x8CD5 /* FRAMEBUFFER_COMPLETE */);
    gl->Viewport(0, 0, DRAWN, DRAWN);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthMask(1);
    gl->DepthFunc(reversed ? GL_GREATER : GL_LESS);
    gl->ClearBufferfv(GLBK_GL_COLOR, 0, nothing);
    gl->ClearBufferfv(GLBK_GL_COLOR, 1, nothing);
    gl->ClearBufferfv(GLBK_GL_DEPTH, 0, &cleared);
    gl->UseProgram(o->program.name);
    gl->UniformMatrix4fv(gl->GetUniformLocation(o->program.name, "clip"), 1, 0, clip);
    gl->Uniform4fv(gl->GetUniformLocation(o->program.name, "eye"), 1, seen_from);
    for (i = 0; i < s->count; i++) {
        float albedo[4] = { 0, 0, 0, 1 };
        memcpy(albedo, s->meshes[i].albedo, 12);
        gl->Uniform4fv(gl->GetUniformLocation(o->program.name, "albedo"), 1, albedo);
        gl->BindVertexArray(s->arrays[i]);
        gl->DrawElements(GLBK_GL_TRIANGLES, (int32_t)s->meshes[i].index_count, GLBK_GL_UNSIGNED_INT, NULL);
    }
    gl->BindVertexArray(0);
    gl->Disable(GL_DEPTH_TEST);
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);
}

/* The matrix of a face of GL's cube about the lamp. */
static void cube_matrix(const rsm_light *l, uint32_t face, float m[16])
{
    const float n = l->near_depth, f = l->far_depth;
    double a[3], b[3], c[3];
    int k;
    cube_direction(face, SIDE - 1, SIDE / 2, b);
    cube_direction(face, 0, SIDE / 2, a);
    for (k = 0; k < 3; k++) a[k] = (b[k] - a[k]) * SIDE / (2 * (SIDE - 1.0));     /* across: s from -1 to 1 */
    cube_direction(face, SIDE / 2, SIDE - 1, c);
    cube_direction(face, SIDE / 2, 0, b);
    for (k = 0; k < 3; k++) b[k] = (c[k] - b[k]) * SIDE / (2 * (SIDE - 1.0));     /* along: t */
    for (k = 0; k < 3; k++) c[k] = -(a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
    memset(m, 0, 16 * sizeof *m);
    for (k = 0; k < 3; k++) {
        const float e = l->position[k];
        m[4 * k] = (float)a[k];
        m[4 * k + 1] = (float)b[k];
        m[4 * k + 2] = (f + n) / (f - n) * (float)c[k];
        m[4 * k + 3] = (float)c[k];
        m[12] -= (float)a[k] * e;
        m[13] -= (float)b[k] * e;
        m[14] -= (f + n) / (f - n) * (float)c[k] * e;
        m[15] -= (float)c[k] * e;
    }
    m[14] -= 2 * n * f / (f - n);
}

typedef struct judged { size_t seen, other; double apart, turned, flux, light; } judged;

/* One face against the other map's; texels at edges may see another surface. */
static void judge(const rsm_texel *drawn, const rsm_texel *read, judged *j)
{
    size_t i, k;
    for (i = 0; i < DRAWN * DRAWN; i++) {
        const rsm_texel *x = &drawn[i], *y = &read[i];
        double apart = 0, cosine = 0;
        j->seen += x->depth < RSM_FAR;
        j->light += (double)(y->flux[0] - x->flux[0]);
        j->flux += (double)x->flux[0];
        for (k = 0; k < 3; k++) {
            apart += pow((double)(x->position[k] - y->position[k]), 2);
            cosine += (double)(x->normal[k] * y->normal[k]);
        }
        if ((x->depth < RSM_FAR) != (y->depth < RSM_FAR) || (x->depth < RSM_FAR && cosine < 0.9)) j->other++;
        if (!(x->depth < RSM_FAR && y->depth < RSM_FAR) || cosine < 0.9) continue;
        j->apart = fmax(j->apart, sqrt(apart));
        j->turned = fmax(j->turned, 1 - cosine);
        for (k = 0; k < 3; k++) assert_true(fabsf(x->flux[k] - y->flux[k]) <= 1e-5f * x->flux[k]);
    }
}

static judged compare_maps(gl_test *t, const scene *s, const rsm_light *lamp, int way, int reversed)
{
    static rsm_texel drawn[DRAWN * DRAWN], read[DRAWN * DRAWN];
    glbk_rsm_renderer r = renderer_of(t);
    glbk_rsm_map by_draw, map;
    rsm_map *matrices;
    rsm_desc desc;
    renderer o;
    glbk_rsm_import in;
    judged j;
    float matrix[16];
    uint32_t face;
    memset(&desc, 0, sizeof desc);
    memset(&in, 0, sizeof in);
    memset(&j, 0, sizeof j);
    desc.light = *lamp;
    desc.side = DRAWN;
    assert_int_equal(rsm_map_create(&desc, &matrices), RSM_OK);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, lamp, DRAWN, &by_draw));
    assert_glbk(t, glbk_rsm_map_create(&t->gl, lamp, DRAWN, &map));
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, &r, &by_draw, scene_draw, (void *)(size_t)s));
    renderer_make(t, &o, way);
    in.depth.texture = &o.depth;
    in.normals.texture = &o.normals;
    in.normal_packing = GLBK_NORMAL_PACKING_UNIT;
    in.colors.texture = &o.colors;
    in.clip_depth = reversed ? GLBK_CLIP_DEPTH_REVERSED : GLBK_CLIP_DEPTH_ZERO_TO_ONE;
    for (face = 0; face < 6 && way == CUBE; face++) {
        cube_matrix(lamp, face, matrix);
        draw_face(t, &o, s, lamp, matrix, way, face, reversed);
    }
    for (face = 0; face < map.face_count; face++) {
        assert_int_equal(rsm_map_matrix(matrices, face, matrix), RSM_OK);
        if (way != CUBE) draw_face(t, &o, s, lamp, matrix, way, face, reversed);
        if (way == ARRAY) in.depth.layer = in.normals.layer = in.colors.layer = face;
        assert_glbk(t, glbk_rsm_map_import(&t->gl, &r, &map, face, &in));       /* compiles the program */
        gl_count_begin(&t->gl);
        GL_SAVED(t, assert_glbk(t, glbk_rsm_map_import(&t->gl, &r, &map, face, &in)));
        gl_count_end(&t->gl);
        assert_glbk(t, glbk_rsm_map_read(&t->gl, &by_draw, face, drawn));
        assert_glbk(t, glbk_rsm_map_read(&t->gl, &map, face, read));
        judge(drawn, read, &j);
    }
    renderer_free(t, &o);
    rsm_map_free(matrices);
    glbk_rsm_map_free(&t->gl, &by_draw);
    glbk_rsm_map_free(&t->gl, &map);
    glbk_rsm_renderer_free(&t->gl, &r);
    return j;
}

static void what_the_user_drew_becomes_the_map_that_would_be_drawn(void **state)
{
    GL_TEST(t, state)
    static const rsm_light_kind kinds[] = { RSM_LIGHT_SUN, RSM_LIGHT_SPOT, RSM_LIGHT_POINT, RSM_LIGHT_PATCH };
    model room[2] = { model_quads(quads, 5), model_quads(quads + 45, 3) };
    rsm_mesh meshes[2] = { mesh_of(&room[0], 0.6), mesh_of(&room[1], 0.8) };
    scene s;
    size_t k;
    int way, reversed;
    meshes[0].albedo[1] = 0.4f;     /* 0.4, 0.6 and 0.8 are 102, 153 and 204 of 255 */
    scene_make(t, &s, meshes, 2);
    for (k = 0; k < sizeof kinds / sizeof kinds[0]; k++)
        for (way = FLAT; way < WAYS; way++)
            for (reversed = 0; reversed < 2; reversed++) {
                rsm_light l = lamp_of(kinds[k]);
                judged j;
                if (way == CUBE && k < 2) continue;
                set3(l.position, 0.137, 1.683, 0.591);         /* edges meet no centres of texels */
                if (k < 2) set3(l.direction, 0.36, k ? -0.8 : 0.48, k ? -0.48 : 0.8);
                if (!k) set3(l.position, 0, 1, 0);
                if (k) l.near_depth = 0.0625f;
                j = compare_maps(t, &s, &l, way, reversed);
                print_message("kind %d, way %d, reversed %d: %zu of %zu texels see another surface; %.1e apart, normal "
                              "%.1e, flux %.1e\n", (int)kinds[k], way, reversed, j.other, j.seen, j.apart, j.turned,
                              j.light / j.flux);
                assert_true(j.seen > DRAWN * DRAWN / 2);
                assert_true(j.other <= j.seen / 200);
                /* Where corners of triangles lie on a coarse grid, depths at a pixel's middle differ more. */
                assert_true(j.apart < (gl_corner_grid(t) < 256 ? 5e-3 : 1e-3) && j.turned < 1e-4);
                assert_true(fabs(j.light / j.flux) < 0.002);
            }
    scene_free(t, &s);
    model_free(&room[0]);
    model_free(&room[1]);
}

/* ---- what is refused, and what is empty ---- */

#define REFUSES(error, text) \
    do { \
        assert_int_equal(glbk_rsm_map_import(&t->gl, &r, &map, 0, &in), error); \
        assert_string_equal(t->log, "glbk_rsm_map_import: " text); \
        in = good; \
    } while (0)

static void bad_imports_are_refused_with_their_field(void **state)
{
    GL_TEST(t, state)
    glbk_rsm_renderer r = renderer_of(t);
    rsm_light l = lamp_of(RSM_LIGHT_SUN);
    glbk_texture flat = image(t, GLBK_FORMAT_RGBA32F, FLAT), array = image(t, GLBK_FORMAT_RGBA32F, ARRAY);
    glbk_texture cube = flat, none = flat;
    glbk_rsm_map map;
    glbk_rsm_import in, good;
    cube.gl_target = GLBK_GL_TEXTURE_CUBE_MAP;
    none.name = 0;
    memset(&good, 0, sizeof good);
    good.depth.texture = good.normals.texture = &flat;
    in = good;
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &map));
    assert_int_equal(glbk_rsm_map_import(NULL, &r, &map, 0, &in), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_import(&t->gl, NULL, &map, 0, &in), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_import(&t->gl, &r, NULL, 0, &in), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_import(&t->gl, &r, &map, 1, &in), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_import(&t->gl, &r, &map, 0, NULL), GLBK_ERR_ARGUMENT);
    in.normals.texture = NULL;
    REFUSES(GLBK_ERR_DESC, "import.normals is NULL");
    in.depth.texture = NULL;
    REFUSES(GLBK_ERR_DESC, "import.depth and import.positions are NULL; one is needed");
    in.positions.texture = &none;
    REFUSES(GLBK_ERR_DESC, "import.positions has no name of GL");
    in.colors.texture = &array;
    REFUSES(GLBK_ERR_DESC, "import.colors and import.normals are not of one kind: 2D, arrays or cubes");
    in.depth.texture = in.normals.texture = &cube;
    REFUSES(GLBK_ERR_DESC, "import.depth is a cube, and the light is a sun");
    in.depth.texture = in.normals.texture = &array;
    in.normals.layer = 7;
    REFUSES(GLBK_ERR_DESC, "import.normals.layer is 7; it must be below the layers of the texture");
    in.normals.layer = 1;
    REFUSES(GLBK_ERR_DESC, "import.normals.layer is 1; it must be below the layers of the texture");
    in.left = ATLAS - SIDE + 1;
    REFUSES(GLBK_ERR_MISMATCH, "import.depth is not as wide as import.left and the map's side");
    in.bottom = UINT32_MAX;
    REFUSES(GLBK_ERR_MISMATCH, "import.depth is not as high as import.bottom and the map's side");
    in.color[1] = -1;
    REFUSES(GLBK_ERR_DESC, "import.color[1] is -1; it must be 0..1000000000000");
    in.color[2] = NAN;
    assert_int_equal(glbk_rsm_map_import(&t->gl, &r, &map, 0, &in), GLBK_ERR_DESC);
    in = good;
    in.color_kind = GLBK_RSM_COLOR_COUNT;
    REFUSES(GLBK_ERR_DESC, "import.color_kind is 3; it must be 0..2");
    glbk_rsm_map_free(&t->gl, &map);
    l.kind = RSM_LIGHT_POINT;
    l.near_depth = l.far_depth = 0;
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &map));
    in.depth.texture = in.normals.texture = &cube;
    REFUSES(GLBK_ERR_MISMATCH, "import.depth is a cube that has not the side of the map");
    glbk_rsm_map_free(&t->gl, &map);
    glbk_texture_free(&t->gl, &flat);
    glbk_texture_free(&t->gl, &array);
    glbk_rsm_renderer_free(&t->gl, &r);
}

/* Flux comes as it is; texels with a colour below 0 or that is no number, or a place that is not finite, are empty; and
   a light that is gathered from the map has the flux that the import gave. */
static void flux_is_taken_as_it_is_and_bad_texels_are_empty(void **state)
{
    GL_TEST(t, state)
    static float normals[4 * TEXELS], places[4 * TEXELS], colors[4 * TEXELS];
    static rsm_texel texels[TEXELS];
    glbk_rsm_renderer r = renderer_of(t);
    rsm_light l = lamp_of(RSM_LIGHT_SQUARE_SPOT);
    glbk_texture by[3];
    glbk_rsm_import in;
    glbk_rsm_map map;
    size_t i, k;
    for (i = 0; i < TEXELS; i++) {
        set3(normals + 4 * i, 0, 0, 1);
        set3(places + 4 * i, (double)i, 2, -3);
        places[4 * i + 3] = 1;
        for (k = 0; k < 3; k++) colors[4 * i + k] = 0.25f * (float)(i + k);
    }
    colors[4] = -1;
    colors[4 * 2 + 1] = NAN;
    places[4 * 3] = INFINITY;
    places[4 * 4 + 2] = NAN;
    places[4 * 5 + 3] = 0;
    normals[4 * 6 + 2] = 0.4f;
    by[0] = gl_texture(t, GLBK_FORMAT_RGBA32F, SIDE, SIDE, normals);
    by[1] = gl_texture(t, GLBK_FORMAT_RGBA32F, SIDE, SIDE, places);
    by[2] = gl_texture(t, GLBK_FORMAT_RGBA32F, SIDE, SIDE, colors);
    memset(&in, 0, sizeof in);
    in.normals.texture = &by[0];
    in.positions.texture = &by[1];
    in.colors.texture = &by[2];
    in.color_kind = GLBK_RSM_COLOR_FLUX;
    set3(in.color, 2, 4, 8);
    in.material = 3;
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &map));
    assert_glbk(t, glbk_rsm_map_import(&t->gl, &r, &map, 0, &in));
    assert_glbk(t, glbk_rsm_map_read(&t->gl, &map, 0, texels));
    for (i = 0; i < TEXELS; i++) {
        if (i >= 1 && i <= 6) {
            assert_true(texels[i].depth >= RSM_FAR && texels[i].material == 0);
            continue;
        }
        assert_int_equal(texels[i].material, 3);
        assert_true(distance(texels[i].position, (const double[3]){ (double)i, 2, -3 }) < 1e-6);
        for (k = 0; k < 3; k++)
            assert_true(fabsf(texels[i].flux[k] - 0.25f * (float)(i + k) * (float)(2 << k)) < 1e-4f);
    }
    for (k = 0; k < 3; k++) glbk_texture_free(&t->gl, &by[k]);
    glbk_rsm_map_free(&t->gl, &map);
    glbk_rsm_renderer_free(&t->gl, &r);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(a_wall_is_imported_by_every_light_from_every_kind_of_texture),
                                  gl_unit_test(a_cube_need_not_lie_along_the_axes_of_the_light),
                                  gl_unit_test(a_colour_that_is_no_number_sends_no_light),
                                  gl_unit_test(what_the_user_drew_becomes_the_map_that_would_be_drawn),
                                  gl_unit_test(bad_imports_are_refused_with_their_field),
                                  gl_unit_test(flux_is_taken_as_it_is_and_bad_texels_are_empty) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
