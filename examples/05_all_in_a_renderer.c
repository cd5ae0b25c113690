/* 05_all_in_a_renderer.c - a small deferred renderer that uses all five techniques at once, on OpenGL.

   build/05_all_in_a_renderer                               a window: keys 1 to 6 switch techniques, T times them,
                                                            space stops the clock, Escape ends
   build/05_all_in_a_renderer --headless PICTURE.png        one frame: .png or .pfm
       --size 1280x720   --time 0.8   --only csm|shadowfield|envshadow|rsm|ism|direct
       --step 3          light is computed for a pixel of 3 x 3, and spread; 1 where the GPU is fast
       --bands 5         of the shadow fields' spherical harmonics

   A room that is open towards us, where everything moves but the king. Each light goes to the technique that suits it:

     csm          the lamp below the ceiling: rigid objects wherever they are, precomputed maps of directions for each
     shadowfield  the glowing ball: a source field that flies among the occlusion fields of the same objects
     envshadow    the sky: 96 lights with shadow maps of all there is, the cloth too
     rsm          the sun: its bounced light, times the ambient occlusion of the shadow fields; and its direct light
     ism          the spot: rsm.h draws what it sees, ism.h makes 256 virtual lights of that list and shadows for them

   One G-buffer is read by five short shaders, each around one function of a header of gl_backend/. They share a trick:
   a pixel takes a 16th of a technique's samples, which 16th depends on its place in a 4 x 4 square, and one filter puts
   the squares together again. Shadow fields need no samples: they are asked at a quarter of the places. */
#define CSM_IMPLEMENTATION
#include "../csm.h"
#define SHADOWFIELD_IMPLEMENTATION
#include "../shadowfield.h"
#define ENVLIGHTS_IMPLEMENTATION
#define ENVSHADOW_IMPLEMENTATION
#include "../envlights.h"
#include "../envshadow.h"
#define RSM_IMPLEMENTATION
#include "../rsm.h"
#define ISM_IMPLEMENTATION
#include "../ism.h"
#include "../gl_backend/gl_csm.h"
#include "../gl_backend/gl_shadowfield.h"
#include "../gl_backend/gl_envshadow.h"
#include "../gl_backend/gl_rsm.h"
#include "../gl_backend/gl_ism.h"

#include "common/common.h"
#include "common/gl_context.h"
#include "common/gl_timer.h"
#include "common/internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if DAPPLE_HAVE_GLFW
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#endif

/* Rigid objects come first: instances of csm, entities of shadowfield have their numbers. The last cast no shadow. */
enum { KING, PAWN_A, PAWN_B, BLOCK, RIGID, CLOTH = RIGID, ROOM, CASTERS, BALL = CASTERS, LAMP, OBJECTS, KINDS = 3 };
enum { SKY_LIGHTS = 96, SPOT_SIDE = 128, VPLS = 256 };
enum { CSM, SHADOWFIELD, ENVSHADOW, RSM, ISM, DIRECT, TECHNIQUES };
enum { GBUFFER = TECHNIQUES, SMOOTH, COMPOSE, TONE, PROGRAMS };
enum { UNIT = 16 };             /* ours; the techniques' textures are at 0 to 15 */

static const char *const names[TECHNIQUES] = { "csm", "shadowfield", "envshadow", "rsm", "ism", "direct" };
static const float ball_radius = 0.12f, ball_light[3] = { 50, 26, 9 };
static const float lamp_light[4] = { 170, 150, 120, 0.1f };      /* radiance; radius */
static const rsm_desc spot = { .light = { .kind = RSM_LIGHT_SPOT,
                                          .position = { -1.5f, 2.2f, 1.2f },
                                          .direction = { 0.8f, -0.48f, -0.36f },
                                          .value = { 40, 37, 31 },
                                          .cone_half_angle = 0.45f,
                                          .near_depth = 0.1f,
                                          .far_depth = 8 },
                               .side = SPOT_SIDE };
static const rsm_light sun = { RSM_LIGHT_SUN, { 0, 1.2f, 0 }, { 0.5f, 0.6f, 0.6245f }, { 0 },
                               { 3.6f, 3.3f, 2.9f }, 3.4f, 0, 0, 0 };

typedef struct range { int object; const float *color; uint32_t first, count; } range;  /* triangles of one colour */

typedef struct app {
    glbk_context        gl;
    uint32_t            width, height, bands;       /* of spherical harmonics */
    uint32_t            step;                       /* light is computed for each step-th pixel both ways */
    uint32_t            frame;
    int                 on[TECHNIQUES], timing, still;
    double              ms[TECHNIQUES + 2], since;  /* and what all share: maps and G-buffer, filter */
    /* the scene: ex_scene's objects, and all their triangles in the world as they are now */
    ex_scene            scene;
    float              *positions, *normals;
    uint32_t           *indices, vertex_count, index_count, cast_indices;   /* the last: of shadow casters */
    range               ranges[16];
    uint32_t            range_count, cast_ranges;
    uint32_t            geometry;                   /* vertex array */
    glbk_buffer         buffers[3];
    /* pictures */
    glbk_texture        seen[4], depth, light, fields, smooth, picture;
    glbk_target         seen_target, light_target, fields_target, smooth_target, picture_target;
    glbk_program        programs[PROGRAMS];
    /* csm, shadowfield */
    glbk_csm_maps       csm;
    uint32_t            csm_start[KINDS];
    sfield_algebra     *algebra;
    sfield_field       *field[KINDS + 1];           /* the last shines */
    glbk_sfield_scene   fields_scene;
    /* envshadow */
    envlt_lights       *sky;
    envsh_maps         *sky_fit;
    glbk_envsh_maps     sky_maps;
    /* rsm, ism */
    glbk_rsm_renderer   rsm;
    glbk_rsm_map        sun_map, spot_map;
    void               *spot_memory;                /* of rsm.h's map */
    ism_maps           *ism;
    ism_surfel         *surfels;
    glbk_ism_maps       ism_maps;
} app;

static int failed(const char *what, const char *why)
{
    char error[EX_ERROR_SIZE];
    snprintf(error, sizeof error, "%s: %s", what, why);
    ex_complain("05_all_in_a_renderer", error);
    return -1;
}

static int gl_ok(glbk_result result, const char *what)
{
    return result == GLBK_OK ? 0 : failed(what, glbk_result_text(result));
}
#define TRY(call) do { if ((call) != 0) return -1; } while (0)
#define GL(call) TRY(gl_ok((call), #call))

/* ---- the scene: king and pawns on a lathe, a block, a cloth, a room of five walls ---- */

static const float king[][2] = { { 0, 0 }, { 0.24f, 0 }, { 0.24f, 0.07f }, { 0.19f, 0.12f }, { 0.12f, 0.22f },
    { 0.09f, 0.5f }, { 0.1f, 0.68f }, { 0.17f, 0.72f }, { 0.17f, 0.76f }, { 0.11f, 0.8f }, { 0.17f, 1.06f },
    { 0.1f, 1.12f }, { 0.03f, 1.15f }, { 0.04f, 1.22f }, { 0, 1.25f } };
static const float pawn[][2] = { { 0, 0 }, { 0.2f, 0 }, { 0.2f, 0.06f }, { 0.15f, 0.1f }, { 0.09f, 0.2f },
    { 0.07f, 0.36f }, { 0.12f, 0.38f }, { 0.12f, 0.4f }, { 0.08f, 0.42f }, { 0.12f, 0.49f }, { 0.13f, 0.54f },
    { 0.1f, 0.61f }, { 0.05f, 0.655f }, { 0, 0.665f } };

static void add(ex_builder *b, const char *name, uint32_t mesh) { ex_build_object(b, name, mesh); }

/* Walls are thick: light that grazes a corner stays outside, whatever the bias. */
static void add_room(ex_builder *b)
{
    const float x = 2.1f, y = 2.45f, z = 2, d = 0.2f;
    uint32_t white = ex_build_material(b, 0.7f, 0.7f, 0.68f), red = ex_build_material(b, 0.7f, 0.13f, 0.08f);
    uint32_t blue = ex_build_material(b, 0.1f, 0.35f, 0.6f);
    ex_build_box(b, v3_make(-x - d, -d, -z - d), v3_make(x + d, 0, z), white);
    ex_build_box(b, v3_make(-x - d, y, -z - d), v3_make(x + d, y + d, z), white);
    ex_build_box(b, v3_make(-x - d, 0, -z - d), v3_make(x + d, y, -z), white);
    ex_build_box(b, v3_make(-x - d, 0, -z), v3_make(-x, y, z), red);
    ex_build_box(b, v3_make(x, 0, -z), v3_make(x + d, y, z), blue);
    add(b, "room", ex_build_finish(b));
}

static int drape(app *a, float time)            /* the cloth at that time, in the place of the last one */
{
    const ex_drape d = { { 0.75f, 2.4f, 0.75f }, { 1.6f, 2.4f, 0.6f }, 1.0f, 0.05f, 2.5f, 0.5f, 1 };
    ex_builder b = ex_build_begin(&a->scene);
    ex_build_drape(&b, &d, time, 14, 14, 3);
    return ex_build_replace(&b, a->scene.objects[CLOTH].mesh) == 0 ? 0 : failed("cloth", "out of memory");
}

static int make_scene(app *a)
{
    ex_builder b = ex_build_begin(&a->scene);
    uint32_t ivory = ex_build_material(&b, 0.75f, 0.7f, 0.6f), grey = ex_build_material(&b, 0.55f, 0.55f, 0.6f);
    uint32_t wood = ex_build_material(&b, 0.6f, 0.4f, 0.2f), mesh, glow, warm;
    ex_build_material(&b, 0.7f, 0.6f, 0.2f);                    /* 3: the cloth's */
    ex_build_lathe(&b, king[0], sizeof king / sizeof *king, 32, 0.6f, ivory);
    add(&b, "king", ex_build_finish(&b));
    ex_build_lathe(&b, pawn[0], sizeof pawn / sizeof *pawn, 28, 0.6f, grey);
    mesh = ex_build_finish(&b);
    add(&b, "pawn", mesh);
    add(&b, "pawn", mesh);
    ex_build_block(&b, v3_make(-0.2f, -0.2f, -0.2f), v3_make(0.2f, 0.2f, 0.2f), 0.03f, wood);
    add(&b, "block", ex_build_finish(&b));
    add(&b, "cloth", ex_build_finish(&b));
    add_room(&b);
    glow = ex_build_material(&b, ball_light[0], ball_light[1], ball_light[2]);      /* of lamps: what they send out */
    warm = ex_build_material(&b, lamp_light[0], lamp_light[1], lamp_light[2]);
    ex_build_ball(&b, v3_make(0, 0, 0), v3_make(ball_radius, ball_radius, ball_radius), 24, glow);
    add(&b, "ball", ex_build_finish(&b));
    ex_build_ball(&b, v3_make(0, 0, 0), v3_make(lamp_light[3], lamp_light[3], lamp_light[3]), 24, warm);
    add(&b, "lamp", ex_build_finish(&b));
    ex_build_camera(&b, v3_make(0.15f, 1.15f, 3.6f), v3_make(0, 0.98f, 0), 52);
    return b.failed ? failed("scene", "out of memory") : drape(a, 0);
}

static void turn(float m[16], const float axis[3], float angle)
{
    float c = cosf(angle), s = sinf(angle);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[4 * j + i] = axis[i] * axis[j] * (1 - c) + (i == j ? c : 0);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        m[4 * j + k] += s * axis[i];
        m[4 * k + j] -= s * axis[i];
    }
}

static int move(app *a, float time)
{
    static const float axis[3] = { 0.6f, 0, 0.8f };
    ex_object *o = a->scene.objects;
    float x = 1.15f * cosf(0.5f * time), z = 0.95f * sinf(0.5f * time), height = 0.28f + 0.1f * sinf(1.7f * time);
    uint32_t v = 0, n = 0;
    ex_place(o[KING].transform, v3_make(-0.2f, 0, -0.4f), 0, 1.15f);
    ex_place(o[PAWN_A].transform, v3_make(-0.2f + x, 0, -0.3f + z), 0, 1.3f);
    ex_place(o[PAWN_B].transform, v3_make(-0.2f - x, 0, -0.3f - z), 0, 1.3f);
    ex_place(o[BLOCK].transform, v3_make(0.75f, 0.5f + 0.12f * sinf(1.3f * time), 0.7f), 0, 1);
    turn(o[BLOCK].transform, axis, 0.6f + 0.8f * time);
    ex_place(o[BALL].transform, v3_make(-0.2f + 0.6f * cosf(time), height, -0.4f - 0.6f * sinf(time)), 0, 1);
    ex_place(o[LAMP].transform, v3_make(0.3f * sinf(1.1f * time), 2.1f, -0.1f + 0.3f * cosf(1.1f * time)), 0, 1);
    TRY(drape(a, time));
    for (int i = 0; i < OBJECTS; i++) {
        const ex_mesh *m = &a->scene.meshes[o[i].mesh];
        for (uint32_t k = 0; k < 3 * m->triangle_count; k++) a->indices[n++] = v + m->indices[k];
        for (uint32_t k = 0; k < m->vertex_count; k++, v++) {
            v3_store(a->positions + 3 * v, ex_transform_point(o[i].transform, v3_load(m->positions + 3 * k)));
            v3_store(a->normals + 3 * v, v3_unit(ex_transform_vector(o[i].transform, v3_load(m->normals + 3 * k))));
        }
    }
    GL(glbk_buffer_update(&a->gl, &a->buffers[0], 0, 12 * v, a->positions));
    GL(glbk_buffer_update(&a->gl, &a->buffers[1], 0, 12 * v, a->normals));
    GL(glbk_buffer_update(&a->gl, &a->buffers[2], 0, 4 * n, a->indices));
    return 0;
}

/* ---- shaders: one function of the library each, between the G-buffer and a sum of irradiance ---- */

#define HEAD                                                                                                         \
    "uniform sampler2D seen_place, seen_normal, seen_flat, seen_color, light_map, fields_map;\n"                     \
    "layout(location = 0) out vec4 result;\n"                                                                        \
    "struct surface { vec3 p, n, flat_n; uint object, set; };    // set: the 16th of the samples that it takes\n"    \
    "bool see(ivec2 at, out surface s)\n"                                                                            \
    "{\n"                                                                                                            \
    "    vec4 place = texelFetch(seen_place, at, 0);\n"                                                              \
    "    ivec2 cell = at / STEP % 4;\n"                                                                              \
    "    s.p = place.xyz;\n"                                                                                         \
    "    s.n = texelFetch(seen_normal, at, 0).xyz;\n"                                                                \
    "    s.flat_n = texelFetch(seen_flat, at, 0).xyz;\n"                                                             \
    "    s.object = uint(place.w);\n"                                                                                \
    "    s.set = uint(cell.x + 4 * cell.y);\n"                                                                       \
    "    return place.w >= 0.0 && s.object < CASTERS;\n"                                                             \
    "}\n"                                                                                                            \
    "bool see_here(out surface s) { return see(ivec2(gl_FragCoord.xy) * STEP, s); }\n"                               \
    "float alike(surface a, surface b)                           // do they lie on one smooth surface?\n"            \
    "{\n"                                                                                                            \
    "    vec3 d = b.p - a.p;\n"                                                                                      \
    "    float facing = max(dot(a.n, b.n), 0.0), off = abs(dot(a.n, d)) + abs(dot(b.n, d));\n"                       \
    "    return pow(facing, 4.0) * max(1.0 - 2.0 * off / (length(d) + 1e-6), 0.0);\n"                                \
    "}\n"                                                                                                            \
    "vec4 spread(sampler2D map, int step, ivec2 at, surface s)   // of each step-th pixel to the one `at`\n"         \
    "{\n"                                                                                                            \
    "    ivec2 low = at / step, last = textureSize(map, 0) - 1;\n"                                                   \
    "    vec2 f = vec2(at - low * step) / float(step);\n"                                                            \
    "    vec4 sum = vec4(0.0);\n"                                                                                    \
    "    float total = 1e-9;\n"                                                                                      \
    "    surface n;\n"                                                                                               \
    "    for (int k = 0; k < 4; k++) {\n"                                                                            \
    "        ivec2 off = ivec2(k & 1, k >> 1), q = min(low + off, last);\n"                                          \
    "        vec2 share = mix(1.0 - f, f, vec2(off));\n"                                                             \
    "        if (!see(q * step, n)) continue;\n"                                                                     \
    "        float w = share.x * share.y * (alike(s, n) + 1e-4);\n"                                                  \
    "        sum += w * texelFetch(map, q, 0);\n"                                                                    \
    "        total += w;\n"                                                                                          \
    "    }\n"                                                                                                        \
    "    return sum / total;\n"                                                                                      \
    "}\n"

static const char geometry_vertex[] =
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "uniform mat4 clip;\n"
    "out vec3 place, facing;\n"
    "void main() { place = position; facing = normal; gl_Position = clip * vec4(position, 1.0); }\n";

static const char geometry_fragment[] =
    "in vec3 place, facing;\n"
    "uniform vec4 color, eye;                                    // w of color: number of the object\n"
    "layout(location = 0) out vec4 out_place;\n"
    "layout(location = 1) out vec4 out_normal;\n"
    "layout(location = 2) out vec4 out_flat;\n"
    "layout(location = 3) out vec4 out_color;\n"
    "void main()\n"
    "{\n"
    "    vec3 flat_n = normalize(cross(dFdx(place), dFdy(place))), n = normalize(facing);\n"
    "    if (dot(flat_n, eye.xyz - place) < 0.0) flat_n = -flat_n;\n"
    "    out_place = vec4(place, color.w);\n"
    "    out_normal = vec4(dot(n, flat_n) < 0.0 ? -n : n, 0.0);\n"
    "    out_flat = vec4(flat_n, 0.0);\n"
    "    out_color = vec4(color.rgb, 1.0);\n"
    "}\n";

typedef struct recipe { const glbk_part *(*part)(void); const char *uses, *vertex, *fragment; } recipe;
static const recipe recipes[PROGRAMS] = {
    [GBUFFER] = { NULL, NULL, geometry_vertex, geometry_fragment },
    [CSM] = { glbk_csm_part, "csm_visible", NULL, HEAD
        "uniform vec4 lamp, lamp_light;                          // place; radiance and radius\n"
        "void main()                                             // 32 points of a disc for the sphere, 2 each\n"
        "{\n"
        "    surface s;\n"
        "    result = vec4(0.0);\n"
        "    if (!see_here(s)) return;\n"
        "    cohsm_query ask = cohsm_ask(COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST, 1.0);\n"
        "    vec3 p = s.p + 0.004 * s.flat_n, d = normalize(lamp.xyz - p);\n"
        "    vec3 u = normalize(cross(d, abs(d.y) < 0.7 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));\n"
        "    vec3 v = cross(d, u);\n"
        "    float sine = min(lamp_light.w / distance(lamp.xyz, p), 0.99);\n"
        "    float size = lamp_light.w * sqrt(1.0 - sine * sine);\n"
        "    vec3 centre = lamp.xyz - lamp_light.w * sine * d;\n"
        "    uint self = s.object < RIGID ? s.object + 1u : 0u;         // instances count from 1\n"
        "    for (uint k = 0u; k < 2u; k++) {\n"
        "        float i = float(16u * k + s.set), r = size * sqrt((i + 0.5) / 32.0), angle = 2.39996323 * i;\n"
        "        vec3 from = centre + r * (cos(angle) * u + sin(angle) * v), l = from - p;\n"
        "        float form = max(dot(s.n, l), 0.0) * dot(d, l) / (dot(l, l) * dot(l, l));\n"
        "        if (form > 0.0 && dot(s.flat_n, l) > 0.0)\n"
        "            result.x += form * max(csm_visible(self, ask, p, from), 0.0);\n"
        "    }\n"
        "    result = vec4(lamp_light.rgb * result.x * (3.14159265 * size * size / 2.0), 0.0);\n"
        "}\n" },
    [SHADOWFIELD] = { glbk_sfield_part, "sfield_access sfield_field", NULL, HEAD
        "void main()                                             // smooth already: asked at a quarter of the places\n"
        "{\n"
        "    surface s;\n"
        "    float t[SFIELD_COEFS], none[SFIELD_COEFS];\n"
        "    result = vec4(0.0, 0.0, 0.0, 1.0);\n"
        "    if (!see(ivec2(gl_FragCoord.xy) * 2 * STEP, s)) return;\n"
        "    sfield_cosine(s.n, t);\n"
        "    for (int k = 0; k < SFIELD_COEFS; k++) none[k] = 0.0;\n"
        "    sfield_sums sums = sfield_shade(s.p, s.n, s.object < RIGID ? s.object + 1u : 0u, t, none);\n"
        "    result = vec4(SFIELD_PI * max(sums.light, vec3(0.0)), clamp(sums.open, 0.0, 1.0));   // irradiance\n"
        "}\n" },
    [ENVSHADOW] = { glbk_envsh_part, "envsh_light", NULL, HEAD
        "void main()                                             // each 16th light\n"
        "{\n"
        "    surface s;\n"
        "    result = vec4(0.0);\n"
        "    if (!see_here(s)) return;\n"
        "    envsh_query q = envsh_bound_query();\n"
        "    uint number = uint(gl_FragCoord.x) + 4096u * uint(gl_FragCoord.y);\n"
        "    for (uint i = s.set; i < glbk_envsh_scene.light_count; i += 16u)\n"
        "        result.rgb += 16.0 * envsh_irradiance(q, i, i + 1u, s.p, s.n, s.flat_n, number);\n"
        "}\n" },
    [RSM] = { glbk_rsm_part, "rsm_gather", NULL, HEAD
        "void main()                                             // 16 of 256 texels of the sun's map; times openness\n"
        "{\n"
        "    surface s;\n"
        "    result = vec4(0.0);\n"
        "    if (!see_here(s)) return;\n"
        "    for (uint i = s.set; i < 256u; i += 16u)\n"
        "        result.rgb += rsm_gather_list(rsm_bound(), s.p, s.n, i, i + 1u, false, 0.0);\n"
        "    result.rgb *= 16.0 / RSM_PI * spread(fields_map, 2 * STEP, ivec2(gl_FragCoord.xy) * STEP, s).w;\n"
        "}\n" },
    [ISM] = { glbk_ism_part, "ism_light", NULL, HEAD
        "void main()\n"
        "{\n"
        "    surface s;\n"
        "    result = vec4(0.0);\n"
        "    if (see_here(s)) result.rgb = ism_light(s.p, s.n, s.flat_n, s.set, 16u).rgb;\n"
        "}\n" },
    [DIRECT] = { glbk_rsm_part, "rsm_direct", NULL, HEAD
        "void main()                                             // of every pixel; the bound map's light itself\n"
        "{\n"
        "    surface s;\n"
        "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
        "    result = vec4(0.0);\n"
        "    vec3 color = texelFetch(seen_color, at, 0).rgb / RSM_PI;\n"
        "    if (see(at, s)) result.rgb = color * rsm_direct(rsm_bound(), s.p, s.n, 3, 0.5, 1.0);\n"
        "}\n" },
    [SMOOTH] = { NULL, NULL, NULL, HEAD
        "void main()                                             // a window that holds each set once\n"
        "{\n"
        "    ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(light_map, 0);\n"
        "    surface s, n;\n"
        "    result = vec4(0.0);\n"
        "    if (!see(at * STEP, s)) return;\n"
        "    for (int y = -2; y <= 2; y++)\n"
        "        for (int x = -2; x <= 2; x++) {\n"
        "            ivec2 q = at + ivec2(x, y);\n"
        "            if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size)) || !see(q * STEP, n)) continue;\n"
        "            float w = alike(s, n) * (abs(x) == 2 ? 0.5 : 1.0) * (abs(y) == 2 ? 0.5 : 1.0);\n"
        "            result += w * vec4(texelFetch(light_map, q, 0).rgb, 1.0);\n"
        "        }\n"
        "    result = vec4(result.rgb / max(result.w, 1e-6) + spread(fields_map, 2 * STEP, at * STEP, s).rgb, 1.0);\n"
        "}\n" },
    [COMPOSE] = { NULL, NULL, NULL, HEAD
        "void main()                                             // to all pixels, with their own colours\n"
        "{\n"
        "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
        "    vec3 color = texelFetch(seen_color, at, 0).rgb;\n"
        "    surface s;\n"
        "    result = vec4(color, 1.0);                          // lamps, and what lies behind the room\n"
        "    if (see(at, s)) result.rgb *= spread(light_map, STEP, at, s).rgb / 3.14159265;\n"
        "}\n" },
    [TONE] = { NULL, NULL, NULL, HEAD
        "void main()\n"
        "{\n"
        "    vec3 light = texelFetch(light_map, ivec2(gl_FragCoord.xy), 0).rgb;\n"
        "    result = vec4(pow(0.5 * light, vec3(1.0 / 2.2)), 1.0);\n"
        "}\n" }
};

/* ---- making things ---- */

/* Our shader behind the library's, whose product has its numbers written out: several times as fast as from a table. */
static char *unroll(const app *a, const char *fragment)
{
    const glbk_file *file = glbk_find_file(glbk_sfield_part(), "lib/sfield_shade.glsl");
    size_t product = glbk_sfield_write_product(a->algebra, NULL, 0);
    size_t size = product + strlen(fragment);
    char *text;
    for (const char *piece = glbk_file_text(file); *piece; piece += strlen(piece) + 1) size += strlen(piece);
    text = malloc(size);
    if (!text) return NULL;
    glbk_sfield_write_product(a->algebra, text, product);
    for (const char *piece = glbk_file_text(file); *piece; piece += strlen(piece) + 1) strcat(text, piece);
    return strcat(text, fragment);
}

static int make_algebra(app *a)
{
    const sfield_result result = sfield_algebra_create(a->bands, NULL, &a->algebra);
    return result == SFIELD_OK ? 0 : failed("shadow fields", sfield_result_text(result));
}

static int make_programs(app *a)
{
    static const char *const maps[] = { "seen_place", "seen_normal", "seen_flat", "seen_color", "light_map",
                                        "fields_map" };
    const glbk_functions *gl = &a->gl.gl;
    char defines[200];
    snprintf(defines, sizeof defines, "STEP=%u RIGID=%uu CASTERS=%uu SFIELD_UNROLLED SFIELD_BANDS=%u ENVSH_FILTER=%d "
             "ENVSH_RGBA=0 ISM_NEAR=3", (unsigned)a->step, (unsigned)RIGID, (unsigned)CASTERS, (unsigned)a->bands,
             (int)ENVSH_FILTER_PENUMBRA);
    for (int i = 0; i < PROGRAMS; i++) {
        char *unrolled = i == SHADOWFIELD ? unroll(a, recipes[i].fragment) : NULL;
        const recipe *r = &recipes[i];
        glbk_source source = { r->vertex, unrolled ? unrolled : r->fragment, NULL, r->uses, defines, NULL,
                               { r->part ? r->part() : NULL }, { { 0, 0 } } };
        glbk_result result = glbk_program_compile(&a->gl, &source, &a->programs[i]);
        free(unrolled);
        GL(result);
        glbk_program_use(&a->gl, &a->programs[i]);
        for (int k = 0; k < 6; k++) gl->Uniform1i(gl->GetUniformLocation(a->programs[i].name, maps[k]), UNIT + k);
    }
    return 0;
}

static int make_picture(app *a, glbk_format format, uint32_t step, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc desc = { 0 };
    glbk_target_desc to = { { texture }, { 0 }, NULL, 0, 0 };
    desc.format = format;
    desc.width = (a->width + step - 1) / step;
    desc.height = (a->height + step - 1) / step;
    GL(glbk_texture_create(&a->gl, &desc, texture));
    if (target) GL(glbk_target_create(&a->gl, &to, target));
    return 0;
}

static int make_pictures(app *a)
{
    glbk_target_desc to = { { &a->seen[0], &a->seen[1], &a->seen[2], &a->seen[3] }, { 0 }, &a->depth, 0, 0 };
    for (int i = 0; i < 4; i++)
        TRY(make_picture(a, i ? GLBK_FORMAT_RGBA16F : GLBK_FORMAT_RGBA32F, 1, &a->seen[i], NULL));
    TRY(make_picture(a, GLBK_FORMAT_DEPTH24, 1, &a->depth, NULL));
    GL(glbk_target_create(&a->gl, &to, &a->seen_target));
    TRY(make_picture(a, GLBK_FORMAT_RGBA16F, a->step, &a->light, &a->light_target));
    TRY(make_picture(a, GLBK_FORMAT_RGBA16F, 2 * a->step, &a->fields, &a->fields_target));
    TRY(make_picture(a, GLBK_FORMAT_RGBA16F, a->step, &a->smooth, &a->smooth_target));
    return make_picture(a, GLBK_FORMAT_RGBA16F, 1, &a->picture, &a->picture_target);
}

/* One vertex array for all; ranges of triangles that have one colour. */
static int make_geometry(app *a)
{
    const glbk_functions *gl = &a->gl.gl;
    for (int i = 0; i < OBJECTS; i++) {
        const ex_mesh *m = &a->scene.meshes[a->scene.objects[i].mesh];
        if (i == CASTERS) a->cast_indices = a->index_count, a->cast_ranges = a->range_count;
        for (uint32_t t = 0, end; t < m->triangle_count && a->range_count < 16; t = end) {
            range r = { i, a->scene.materials[m->materials[t]].base_color, a->index_count + 3 * t, 0 };
            for (end = t + 1; end < m->triangle_count && m->materials[end] == m->materials[t]; end++) {}
            r.count = 3 * (end - t);
            a->ranges[a->range_count++] = r;
        }
        a->vertex_count += m->vertex_count;
        a->index_count += 3 * m->triangle_count;
    }
    a->positions = calloc(a->vertex_count, 12);
    a->normals = calloc(a->vertex_count, 12);
    a->indices = calloc(a->index_count, 4);
    if (!a->positions || !a->normals || !a->indices) return failed("geometry", "out of memory");
    GL(glbk_buffer_create(&a->gl, 12 * a->vertex_count, NULL, &a->buffers[0]));
    GL(glbk_buffer_create(&a->gl, 12 * a->vertex_count, NULL, &a->buffers[1]));
    GL(glbk_indices_create(&a->gl, 4 * a->index_count, NULL, &a->buffers[2]));
    gl->GenVertexArrays(1, &a->geometry);
    gl->BindVertexArray(a->geometry);
    for (uint32_t i = 0; i < 2; i++) {
        gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, a->buffers[i].name);
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    }
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, a->buffers[2].name);
    gl->BindVertexArray(0);
    return 0;
}

static const int kind_of[RIGID] = { 0, 1, 1, 2 };               /* objects of one mesh share its maps and fields */
static const int first_of[KINDS] = { KING, PAWN_A, BLOCK };

/* What is precomputed: coherent shadow maps and fields of three meshes, and the field of the ball's light. */
static int make_csm(app *a, ex_pool *pool)
{
    glbk_csm_block blocks[KINDS];
    cohsm_maps *maps[KINDS] = { NULL };
    cohsm_desc desc = { 0 };
    cohsm_result result = COHSM_OK;
    int status = 0;
    desc.domain.side[0] = desc.domain.side[1] = 48;
    desc.map_side = 64;
    desc.order = COHSM_ORDER_HILBERT;
    desc.orientation = COHSM_ORIENTATION_POLAR;
    desc.system.parallel_for = ex_pool_run;
    desc.system.user = pool;
    for (int i = 0; i < KINDS && result == COHSM_OK; i++) {
        const ex_mesh *m = &a->scene.meshes[a->scene.objects[first_of[i]].mesh];
        cohsm_mesh mesh = { m->positions, m->vertex_count, 0, m->indices, 3 * m->triangle_count, NULL, NULL, NULL };
        result = cohsm_build(&desc, &mesh, &maps[i], NULL);
        if (result == COHSM_OK) blocks[i].data = cohsm_data(maps[i], &blocks[i].bytes);
    }
    if (result != COHSM_OK) status = failed("csm", cohsm_result_text(result));
    else status = gl_ok(glbk_csm_maps_create(&a->gl, blocks, KINDS, RIGID, a->csm_start, &a->csm), "csm");
    for (int i = 0; i < KINDS; i++) cohsm_free(maps[i]);
    return status;
}

static sfield_result make_fields(app *a, ex_pool *pool, sfield_field **fields)
{
    sfield_desc desc = { 0 };
    sfield_emitter ball = { 0 };
    sfield_result result = SFIELD_OK;
    desc.bands = a->bands;
    desc.shell_count = desc.position_side = 8;
    desc.cube_side = 8;
    desc.inner = 0.4f;
    desc.outer = 4;
    desc.system.parallel_for = ex_pool_run;
    desc.system.log = ex_pool_log;
    desc.system.user = pool;
    for (int i = 0; i < KINDS && result == SFIELD_OK; i++) {
        const ex_mesh *m = &a->scene.meshes[a->scene.objects[first_of[i]].mesh];
        sfield_mesh mesh = { m->positions, m->vertex_count, 0, m->indices, 3 * m->triangle_count, NULL, NULL, NULL };
        result = sfield_build(&desc, &mesh, &fields[i], NULL);
    }
    ball.radius = ball_radius;
    ball.radiance[0] = ball.radiance[1] = ball.radiance[2] = 1;
    desc.inner = 1;
    desc.outer = 30;
    desc.cube_side = 32;
    desc.shell_count = 12;
    desc.position_side = 4;
    return result == SFIELD_OK ? sfield_build_emitter(&desc, &ball, &fields[KINDS], NULL) : result;
}

static int make_world(app *a, ex_pool *pool)
{
    static const float dark[3 * SFIELD_MAX_COEFS];       /* a sky: then its open share comes out, too */
    const sfield_result result = make_fields(a, pool, a->field);
    glbk_sfield_scene_desc desc = { 0 };
    if (result != SFIELD_OK) return failed("shadow fields", sfield_result_text(result));
    desc.algebra = a->algebra;
    desc.fields = (const sfield_field *const *)a->field;
    desc.field_count = KINDS + 1;
    desc.entity_capacity = RIGID + 1;
    GL(glbk_sfield_scene_create(&a->gl, &desc, &a->fields_scene));
    GL(glbk_sfield_scene_sky(&a->gl, &a->fields_scene, dark));
    return 0;
}

static int make_sky(app *a)
{
    static float rgb[3 * 64 * 32];
    envlt_map map = { ENVLT_PROJECTION_LATLONG, 64, 32, rgb, 0 };
    envlt_desc desc = { 0 };
    envsh_maps_desc fit = { 0 };
    glbk_envsh_maps_desc maps = { 0 };
    envlt_result result;
    envsh_result maps_made;
    for (uint32_t i = 0; i < 64 * 32; i++) {                    /* black where no light can come in from */
        float d[3], up;
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 64, 32, 0, (float)(i % 64) + 0.5f, (float)(i / 64) + 0.5f, d);
        up = d[1] > 0 ? 1 - d[1] : 0;
        for (int k = 0; k < 3 && d[2] > 0; k++) {               /* dark ground, pale horizon, blue above */
            float high = 0.3f + 0.25f * (float)k, pale = 0.9f - 0.2f * (float)k;
            rgb[3 * i + (uint32_t)k] = d[1] < 0 ? 0.15f : high + pale * up * up;
        }
    }
    desc.light_count = SKY_LIGHTS;
    fit.no_depth = 1;
    fit.map_side = 128;
    maps.maps = &fit;
    maps.capacity = SKY_LIGHTS;
    result = envlt_create(&desc, &map, &a->sky, NULL);
    if (result != ENVLT_OK) return failed("envlights", envlt_result_text(result));
    maps_made = envsh_maps_create(&fit, SKY_LIGHTS, &a->sky_fit);
    if (maps_made != ENVSH_OK) return failed("envshadow", envsh_result_text(maps_made));
    GL(glbk_envsh_maps_create(&a->gl, &maps, &a->sky_maps));
    return 0;
}

static int make_bounces(app *a)
{
    /* its pictures are not used, only its list of lights */
    const glbk_rsm_renderer_desc desc = { 1, 1, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    ism_desc sizes = { 0 };
    GL(glbk_rsm_renderer_create(&a->gl, &desc, &a->rsm));
    GL(glbk_rsm_map_create(&a->gl, &sun, 512, &a->sun_map));
    GL(glbk_rsm_map_create(&a->gl, &spot.light, SPOT_SIDE, &a->spot_map));
    sizes.system.log = ex_pool_log;                             /* says which value it was, if a call fails */
    sizes.vpl_count = VPLS;
    sizes.surfel_count = 512;
    sizes.tile_side = 32;
    sizes.lazy_frames = 4;
    sizes.importance = ISM_IMPORTANCE_FLUX;
    sizes.spread = ISM_SPREAD_AREA;
    GL(glbk_ism_maps_create(&a->gl, &sizes, &a->ism_maps));
    a->surfels = malloc(VPLS * a->ism_maps.phase_surfel_count * sizeof *a->surfels);
    a->spot_memory = malloc(rsm_map_bytes(&spot));
    return a->surfels && a->spot_memory && ism_create(&sizes, &a->ism) == ISM_OK ? 0 : failed("ism", "out of memory");
}

static int make_all(app *a)
{
    ex_pool *pool = ex_pool_create(0);
    int bad = !pool || make_scene(a) != 0 || make_algebra(a) != 0 || make_programs(a) != 0 ||
              make_pictures(a) != 0 || make_geometry(a) != 0 || make_csm(a, pool) != 0 || make_world(a, pool) != 0 ||
              make_sky(a) != 0 || make_bounces(a) != 0;
    ex_pool_free(pool);
    return bad ? -1 : 0;
}

static void free_all(app *a)                    /* objects of GL go with its context */
{
    glbk_sfield_scene_free(&a->gl, &a->fields_scene);   /* has memory of ours, too */
    glbk_free(&a->gl);
    for (int i = 0; i < KINDS + 1; i++) sfield_free(a->field[i]);
    sfield_algebra_free(a->algebra);
    envsh_maps_free(a->sky_fit);
    envlt_free(a->sky);
    ism_free(a->ism);
    free(a->spot_memory);
    free(a->surfels);
    free(a->positions);
    free(a->normals);
    free(a->indices);
    ex_scene_free(&a->scene);
}

/* ---- a frame: where things are, what lights see, what we see, light by light ---- */

static void stamp(app *a, int stage)            /* what ran since the last stamp counts for that stage */
{
    double now;
    if (!a->timing) return;
    a->gl.gl.Finish();
    now = ex_seconds();
    if (stage >= 0) a->ms[stage] += 1e3 * (now - a->since);
    a->since = now;
}

static void draw_range(glbk_context *gl, const range *r)
{
    const void *from = (const void *)(uintptr_t)(4 * (size_t)r->first);
    gl->gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)r->count, GLBK_GL_UNSIGNED_INT, from);
}

static void draw_for_rsm(void *user, glbk_context *gl, glbk_rsm_renderer *rsm)
{
    const app *a = user;
    glbk_surface surface = { 0 };
    gl->gl.BindVertexArray(a->geometry);
    for (uint32_t i = 0; i < a->cast_ranges; i++) {
        memcpy(surface.material.diffuse, a->ranges[i].color, sizeof surface.material.diffuse);
        glbk_rsm_object(gl, rsm, &surface, 0);                  /* an error of it comes back from glbk_rsm_map_draw */
        draw_range(gl, &a->ranges[i]);
    }
}

static glbk_result draw_for_sky(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    const app *a = user;
    glbk_result result = glbk_envsh_cast(gl, maps, NULL);
    gl->gl.BindVertexArray(a->geometry);
    gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, (int32_t)a->cast_indices, GLBK_GL_UNSIGNED_INT, NULL,
                                 (int32_t)instances);
    return result;
}

static int see_from_sun(app *a)
{
    static const rsm_gather_desc by_flux = { .sample_count = 256, .offset = 0.12f, .near_limit = 0.25f };
    glbk_rsm_map *map = &a->sun_map;
    GL(glbk_rsm_map_draw(&a->gl, &a->rsm, map, draw_for_rsm, a));
    GL(glbk_rsm_gather(&a->gl, &a->rsm, NULL, &map, 1, &by_flux));    /* leaves 256 lights for our shader */
    return 0;
}

static int see_from_sky(app *a)
{
    envsh_mesh mesh = { a->positions, a->vertex_count, 0, a->indices, a->cast_indices, NULL, NULL, NULL };
    uint32_t count;
    const envlt_light *sky = envlt_get_lights(a->sky, &count);
    envsh_lights lights = { count, sky->direction, sky->irradiance, sky->axis_u, sky->axis_v, sizeof *sky };
    const envsh_view *views;
    envsh_result result = envsh_maps_begin(a->sky_fit, &lights, envsh_bounds_of(&mesh, 1, NULL));
    if (result != ENVSH_OK) return failed("envshadow", envsh_result_text(result));
    views = envsh_views(a->sky_fit, &count);
    GL(glbk_envsh_maps_render(&a->gl, &a->sky_maps, views, count, draw_for_sky, a));
    return 0;
}

/* rsm.h draws the spot's view on the CPU, for ism.h picks lights from it there; their maps are drawn on the GPU. */
static int see_from_spot(app *a)
{
    ism_source source = { ISM_SOURCE_SURFACE, SPOT_SIDE, SPOT_SIDE, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0 };
    ism_points view = { 0 };
    ism_mesh mesh = { a->positions, a->vertex_count, 0, a->indices, a->cast_indices, NULL, NULL, NULL, NULL, NULL };
    ism_frame frame = { &mesh, &source, 1, &view, a->frame };
    const rsm_texel *texels;
    rsm_map *map;
    rsm_mesh meshes[16];
    rsm_result seen = rsm_map_init(&spot, a->spot_memory, rsm_map_bytes(&spot), &map);
    ism_result chosen = ISM_OK;
    memset(meshes, 0, sizeof meshes);
    for (uint32_t i = 0; i < a->cast_ranges; i++) {
        meshes[i].positions = a->positions;
        meshes[i].vertex_count = a->vertex_count;
        meshes[i].indices = a->indices + a->ranges[i].first;
        meshes[i].index_count = a->ranges[i].count;
        memcpy(meshes[i].albedo, a->ranges[i].color, sizeof meshes[i].albedo);
    }
    if (seen == RSM_OK) seen = rsm_rasterize(map, meshes, a->cast_ranges);
    if (seen == RSM_OK) seen = rsm_finish(map, NULL);
    if (seen != RSM_OK) return failed("rsm", rsm_result_text(seen));
    texels = rsm_map_texels(map);
    GL(glbk_rsm_map_upload(&a->gl, &a->spot_map, texels));
    source.positions = texels->position;
    source.normals = texels->normal;
    source.fluxes = texels->flux;
    source.areas = &texels->area;
    source.position_stride = source.normal_stride = source.flux_stride = source.area_stride = sizeof *texels;
    view.count = a->vertex_count;
    view.positions = a->positions;
    view.normals = a->normals;
    chosen = ism_choose(a->ism, &frame);
    if (chosen == ISM_OK) chosen = ism_scatter(a->ism, &frame);
    return chosen == ISM_OK ? 0 : failed("ism", ism_result_text(chosen));
}

static int send_to_ism(app *a)
{
    ism_mesh mesh = { a->positions, a->vertex_count, 0, a->indices, a->cast_indices, NULL, NULL, NULL, NULL, NULL };
    const uint32_t phases = a->ism_maps.desc.lazy_frames;
    ism_info info;
    size_t count;
    const ism_vpl *from = ism_vpls(a->ism, &count);
    ism_get_info(a->ism, &info);
    GL(glbk_ism_vpls_upload(&a->gl, &a->ism_maps, from, (uint32_t)count, &info));   /* without near points */
    if (a->frame == 0) GL(glbk_ism_mesh_upload(&a->gl, &a->ism_maps, &mesh));
    else GL(glbk_ism_mesh_move(&a->gl, &a->ism_maps, a->positions, 0));
    for (uint32_t phase = 0; phase < phases; phase++) {         /* a frame renews one phase, the first all */
        if (a->frame != 0 && phase != a->frame % phases) continue;
        if (ism_phase_surfels(a->ism, phase, a->surfels, VPLS * a->ism_maps.phase_surfel_count, &count) != ISM_OK)
            return failed("ism", "no surfels");
        GL(glbk_ism_surfels_upload(&a->gl, &a->ism_maps, phase, a->surfels, count));
    }
    GL(glbk_ism_draw(&a->gl, &a->ism_maps, 0));
    return 0;
}

/* Where csm and shadowfield have the rigid objects. */
static int place(app *a)
{
    static const float none[3] = { 1, 1, 1 };
    glbk_csm_instance instances[RIGID];
    sfield_entity entities[RIGID + 1];
    memset(entities, 0, sizeof entities);
    for (int i = 0; i <= RIGID; i++) {
        const float *transform = a->scene.objects[i < RIGID ? i : BALL].transform;
        memcpy(entities[i].transform, transform, sizeof entities[i].transform);
        memcpy(entities[i].tint, i < RIGID ? none : ball_light, sizeof entities[i].tint);
        if (i == RIGID) break;
        memcpy(instances[i].transform, transform, sizeof instances[i].transform);
        instances[i].start = a->csm_start[kind_of[i]];
        instances[i].offset = 0;
        entities[i].occlusion = a->field[kind_of[i]];
    }
    entities[RIGID].source = a->field[KINDS];
    GL(glbk_csm_maps_place(&a->gl, &a->csm, instances, RIGID));
    GL(glbk_sfield_scene_entities(&a->gl, &a->fields_scene, entities, RIGID + 1));
    return 0;
}

static int32_t uniform(app *a, int program, const char *name)
{
    return a->gl.gl.GetUniformLocation(a->programs[program].name, name);
}

static int draw_gbuffer(app *a)
{
    static const float nothing[4] = { 0, 0, 0, -1 }, sky[4] = { 0.6f, 0.7f, 0.9f, 1 };
    const glbk_functions *gl = &a->gl.gl;
    glbk_pass pass = { &a->seen_target, { 0, 0, 0, 0 }, GLBK_DEPTH_LESS, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 } };
    const ex_camera *c = &a->scene.camera;
    v3 back = v3_unit(v3_sub(v3_load(c->eye), v3_load(c->target)));
    v3 right = v3_unit(v3_cross(v3_load(c->up), back)), up = v3_cross(back, right);
    float view[16] = { right.x, up.x, back.x, 0, right.y, up.y, back.y, 0, right.z, up.z, back.z, 0, 0, 0, 0, 1 };
    float lens[16] = { 0 }, near_plane = 0.1f, far_plane = 20, eye[4] = { c->eye[0], c->eye[1], c->eye[2], 1 };
    lens[5] = 1 / tanf(0.5f * c->fovy);
    lens[0] = lens[5] * (float)a->height / (float)a->width;
    lens[10] = (near_plane + far_plane) / (near_plane - far_plane);
    lens[14] = 2 * near_plane * far_plane / (near_plane - far_plane);
    lens[11] = -1;
    for (int i = 0; i < 3; i++) view[12 + i] = -(view[i] * eye[0] + view[4 + i] * eye[1] + view[8 + i] * eye[2]);
    ex_multiply(lens, lens, view);
    GL(glbk_begin(&a->gl, &pass, &a->programs[GBUFFER]));
    glbk_clear(&a->gl, &a->seen_target, 0, nothing);
    glbk_clear(&a->gl, &a->seen_target, 3, sky);
    glbk_clear_depth(&a->gl, 1);
    gl->UniformMatrix4fv(uniform(a, GBUFFER, "clip"), 1, 0, lens);
    gl->Uniform4fv(uniform(a, GBUFFER, "eye"), 1, eye);
    gl->BindVertexArray(a->geometry);
    for (uint32_t i = 0; i < a->range_count; i++) {
        const range *r = &a->ranges[i];
        float color[4] = { r->color[0], r->color[1], r->color[2], (float)r->object };
        gl->Uniform4fv(uniform(a, GBUFFER, "color"), 1, color);
        draw_range(&a->gl, r);
    }
    return 0;
}

/* Begins a screen pass of ours: G-buffer and two more pictures at the units from UNIT on. */
static int begin(app *a, int program, const glbk_target *to, glbk_blend blend, const glbk_texture *light,
                 const glbk_texture *fields)
{
    const int32_t width = (int32_t)(to ? to->width : a->width), height = (int32_t)(to ? to->height : a->height);
    const glbk_pass pass = { to, { 0, 0, width, height }, GLBK_DEPTH_OFF, blend, GLBK_CULL_OFF, 0, { 0, 0 } };
    GL(glbk_begin(&a->gl, &pass, &a->programs[program]));
    for (uint32_t i = 0; i < 6; i++) {
        a->gl.gl.ActiveTexture(GLBK_GL_TEXTURE0 + UNIT + i);
        a->gl.gl.BindTexture(GLBK_GL_TEXTURE_2D, i < 4 ? a->seen[i].name : i == 4 ? light->name : fields->name);
    }
    return 0;
}

static void bind_technique(app *a, int technique)
{
    const envsh_query query = { ENVSH_FILTER_PENUMBRA, 8, 32, 1, 1, 1, 0 };
    switch (technique) {
    case CSM:
        glbk_csm_bind(&a->gl, &a->csm, NULL);
        a->gl.gl.Uniform4fv(uniform(a, CSM, "lamp"), 1, a->scene.objects[LAMP].transform + 12);
        a->gl.gl.Uniform4fv(uniform(a, CSM, "lamp_light"), 1, lamp_light);
        break;
    case SHADOWFIELD: glbk_sfield_bind(&a->gl, &a->fields_scene, NULL); break;
    case ENVSHADOW: glbk_envsh_bind(&a->gl, &a->sky_maps, &query, NULL); break;
    case RSM: glbk_rsm_bind(&a->gl, &a->rsm, &a->sun_map, NULL); break;
    default: glbk_ism_bind(&a->gl, &a->ism_maps, NULL, NULL);
    }
}

static int light_up(app *a)
{
    static const float dark[4] = { 0, 0, 0, 0 }, open[4] = { 0, 0, 0, 1 };
    static const int order[] = { SHADOWFIELD, CSM, ENVSHADOW, RSM, ISM };       /* rsm reads what shadowfield writes */
    const glbk_rsm_map *maps[2] = { &a->sun_map, &a->spot_map };
    TRY(begin(a, SMOOTH, &a->fields_target, GLBK_BLEND_OFF, &a->light, &a->light));
    glbk_clear(&a->gl, &a->fields_target, 0, open);
    TRY(begin(a, SMOOTH, &a->light_target, GLBK_BLEND_OFF, &a->fields, &a->fields));
    glbk_clear(&a->gl, &a->light_target, 0, dark);
    for (int i = 0; i < 5; i++) {
        int t = order[i];
        if (!a->on[t]) continue;
        if (t == SHADOWFIELD) TRY(begin(a, t, &a->fields_target, GLBK_BLEND_OFF, &a->smooth, &a->smooth));
        else TRY(begin(a, t, &a->light_target, GLBK_BLEND_ADD, &a->smooth, &a->fields));
        bind_technique(a, t);
        glbk_draw_screen(&a->gl);
        stamp(a, t);
    }
    TRY(begin(a, SMOOTH, &a->smooth_target, GLBK_BLEND_OFF, &a->light, &a->fields));
    glbk_draw_screen(&a->gl);
    TRY(begin(a, COMPOSE, &a->picture_target, GLBK_BLEND_OFF, &a->smooth, &a->fields));
    glbk_draw_screen(&a->gl);
    stamp(a, TECHNIQUES + 1);
    for (int i = 0; i < 2 && a->on[DIRECT]; i++) {
        TRY(begin(a, DIRECT, &a->picture_target, GLBK_BLEND_ADD, &a->smooth, &a->fields));
        glbk_rsm_bind(&a->gl, NULL, maps[i], NULL);
        glbk_draw_screen(&a->gl);
    }
    stamp(a, DIRECT);
    return 0;
}

static int draw_frame(app *a, float time)
{
    if (a->timing) memset(a->ms, 0, sizeof a->ms), stamp(a, -1);
    TRY(move(a, time));
    TRY(place(a));
    TRY(draw_gbuffer(a));
    stamp(a, TECHNIQUES);
    if (a->on[ENVSHADOW]) TRY(see_from_sky(a));
    stamp(a, ENVSHADOW);
    if (a->on[RSM] || a->on[DIRECT]) TRY(see_from_sun(a));
    stamp(a, RSM);
    if (a->on[ISM] || a->on[DIRECT]) TRY(see_from_spot(a));
    if (a->on[ISM]) TRY(send_to_ism(a));
    stamp(a, ISM);
    TRY(light_up(a));
    a->frame++;
    return gl_ok(glbk_check(&a->gl), "frame");
}

static void print_times(const app *a)
{
    double sum = 0;
    for (int i = 0; i < TECHNIQUES + 2; i++) sum += a->ms[i];
    printf("%.1f ms: scene %.1f", sum, a->ms[TECHNIQUES]);
    for (int i = 0; i < TECHNIQUES; i++) printf(", %s %.1f", names[i], a->ms[i]);
    printf(", filter %.1f\n", a->ms[TECHNIQUES + 1]);
    fflush(stdout);
}

/* ---- the program ---- */

typedef struct options { const char *picture; int width, height, step, bands, only; float time; } options;

static int read_options(int count, char **values, options *o)
{
    for (int i = 1; i < count; i++) {
        const char *name = values[i], *value = i + 1 < count ? values[++i] : "";
        char end;
        int good = 0;
        if (strcmp(name, "--headless") == 0) good = *(o->picture = value) != 0;
        if (strcmp(name, "--size") == 0) good = sscanf(value, "%dx%d%c", &o->width, &o->height, &end) == 2;
        if (strcmp(name, "--time") == 0) good = sscanf(value, "%f%c", &o->time, &end) == 1;
        if (strcmp(name, "--step") == 0) good = sscanf(value, "%d%c", &o->step, &end) == 1;
        if (strcmp(name, "--bands") == 0) good = sscanf(value, "%d%c", &o->bands, &end) == 1;
        for (int t = 0; strcmp(name, "--only") == 0 && t < TECHNIQUES; t++)
            if (strcmp(value, names[t]) == 0) o->only = t, good = 1;
        if (!good || o->width < 4 || o->height < 4 || o->width > 8192 || o->height > 8192 || o->step < 1 ||
            o->step > 4 || o->bands < 2 || o->bands > 6)
            return failed(name, "unknown, or a value that does not fit");
    }
    return 0;
}

static int write_picture(app *a, const char *path)
{
    char error[EX_ERROR_SIZE];
    ex_image image;
    float *rgba = malloc(16 * (size_t)a->width * a->height);
    int status = rgba && ex_image_alloc(&image, a->width, a->height) == 0 ? 0 : failed(path, "out of memory");
    if (status == 0) {
        status = gl_ok(glbk_target_read(&a->gl, &a->picture_target, 0, 0, 0, a->width, a->height, rgba), path);
        for (size_t i = 0; i < (size_t)a->width * a->height; i++) {
            size_t x = i % a->width, y = a->height - 1 - i / a->width;     /* GL's rows go up */
            memcpy(image.rgb + 3 * (y * a->width + x), rgba + 4 * i, 12);
        }
        if (status == 0 && ex_image_write(&image, path, -1, error) != 0) status = failed(path, error);     /* as TONE */
        ex_image_free(&image);
    }
    free(rgba);
    return status;
}

static int run_headless(app *a, const options *o)
{
    a->timing = 1;
    for (int i = 0; i < 2; i++) TRY(draw_frame(a, o->time));    /* the first compiles shaders; times of the second */
    print_times(a);
    return write_picture(a, o->picture);
}

#if DAPPLE_HAVE_GLFW
static void on_key(GLFWwindow *window, int key, int code, int action, int mods)
{
    app *a = glfwGetWindowUserPointer(window);
    (void)code, (void)mods;
    if (action != GLFW_PRESS) return;
    if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + TECHNIQUES) {
        a->on[key - GLFW_KEY_1] ^= 1;
        printf("%s %s\n", names[key - GLFW_KEY_1], a->on[key - GLFW_KEY_1] ? "on" : "off");
    }
    if (key == GLFW_KEY_T) a->timing ^= 1;
    if (key == GLFW_KEY_SPACE) a->still ^= 1;
    if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, 1);
}

static int run_window(app *a, GLFWwindow *window, float time)
{
    double last = ex_seconds(), told = last;
    glfwSetWindowUserPointer(window, a);
    glfwSetKeyCallback(window, on_key);
    while (!glfwWindowShouldClose(window)) {
        double now = ex_seconds();
        if (!a->still) time += (float)(now - last);
        last = now;
        TRY(draw_frame(a, time));
        if (a->timing && now - told > 1) print_times(a), told = now;
        a->gl.gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);
        TRY(begin(a, TONE, NULL, GLBK_BLEND_OFF, &a->picture, &a->fields));
        glbk_draw_screen(&a->gl);
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    return 0;
}
#endif

int main(int count, char **values)
{
    static app a;
    char error[EX_ERROR_SIZE];
    options o = { NULL, 1280, 720, 3, 5, -1, 0.8f };
    ex_gl_options context = { 0 };
    glbk_desc desc = { 0 };
    glbk_result made;
    ex_gl *gl;
    int status;
    if (read_options(count, values, &o) != 0) return 2;
    a.width = (uint32_t)(context.width = o.width);
    a.height = (uint32_t)(context.height = o.height);
    a.step = (uint32_t)o.step;
    a.bands = (uint32_t)o.bands;
    for (int i = 0; i < TECHNIQUES; i++) a.on[i] = o.only < 0 || o.only == i;
    context.title = "Dapple: all in a renderer";
    gl = o.picture ? ex_gl_create(&context, error) : ex_gl_create_window(&context, error);
    if (!gl) return failed("OpenGL", error), 1;
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = gl;
    desc.system.log = ex_gl_log;
    made = glbk_init(&a.gl, &desc);
    if (made == GLBK_OK && ex_gl_is_software(a.gl.renderer)) {
        glbk_free(&a.gl);        /* which run groups of compute one invocation after the other: ism waits for it */
        desc.core_only = 1;
        made = glbk_init(&a.gl, &desc);
    }
    status = made == GLBK_OK ? make_all(&a) : failed("OpenGL", glbk_result_text(made));
#if DAPPLE_HAVE_GLFW
    if (status == 0 && !o.picture) status = run_window(&a, ex_gl_window(gl), o.time);
#endif
    if (status == 0 && o.picture) status = run_headless(&a, &o);
    free_all(&a);
    ex_gl_free(gl);
    return status == 0 ? 0 : 1;
}
