/* 13_deferred_gl.c - a deferred renderer that is there already, lit by two techniques. It has vertex arrays, shaders,
   framebuffers and textures of its own; glbk_gbuffer_import reads its depth, normals, colours and object numbers where
   they are. A lamp shines by coherent shadow maps (gl_csm.h), a sky by shadow maps of 64 lights (gl_envshadow.h), and
   their pictures go over what the renderer has drawn before: a background, and glowing beads with their depths. A
   program of the renderer's, which it links itself, calls a function of the library: glbk_write_glsl, glbk_set_slots.

   cc -O2 13_deferred_gl.c -lglfw -lm -o deferred_gl && ./deferred_gl     a click says what is there, Escape ends it
   ./deferred_gl picture.ppm                        one picture, no visible window; without a display: xvfb-run -a */
#define CSM_IMPLEMENTATION
#include "csm.h"
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_CSM_IMPLEMENTATION
#define GL_ENVSHADOW_IMPLEMENTATION
#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_envshadow.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 400, SKY_LIGHTS = 64, MAP = 128, LAMP_SAMPLES = 64, BEADS = 9 };
enum { RINGS = 64, SIDES = 32, RING_VERTICES = RINGS * SIDES, RING_INDICES = 6 * RING_VERTICES };
enum { BALL = 16, BALL_VERTICES = 2 * BALL * (BALL + 1), BALL_INDICES = 6 * 2 * BALL * BALL };
enum { QUADS = 4, VERTICES = RING_VERTICES + 4 * QUADS + BALL_VERTICES };
enum { INDICES = RING_INDICES + 6 * QUADS + BALL_INDICES };
enum { RING_AT = 0, ROOM_AT = RING_INDICES, MIST_AT = ROOM_AT + 18, BALL_AT = MIST_AT + 6 };    /* in the indices */

/* GL's numbers that gl_backend.h has no name for. */
enum { NUMBER_DEPTH_TEST = 0x0B71, NUMBER_LESS = 0x0201, NUMBER_NEAREST = 0x2600, NUMBER_MIN_FILTER = 0x2801,
       NUMBER_MAG_FILTER = 0x2800, NUMBER_VERTEX_SHADER = 0x8B31, NUMBER_FRAGMENT_SHADER = 0x8B30,
       NUMBER_LINK_STATUS = 0x8B82, NUMBER_RGBA = 0x1908, NUMBER_RED_INTEGER = 0x8D94, NUMBER_DEPTH_COMPONENT = 0x1902,
       NUMBER_UNSIGNED_INT_2_10_10_10_REV = 0x8368, NUMBER_RGBA8 = 0x8058, NUMBER_RGB10_A2 = 0x8059,
       NUMBER_R8UI = 0x8232, NUMBER_DEPTH_COMPONENT24 = 0x81A6, NUMBER_RGBA16F = 0x881A };

/* ---- the renderer as it was before: meshes ---- */

typedef struct vertex { float position[3]; signed char normal[4]; unsigned char color[4]; } vertex;

static vertex   vertices[VERTICES];
static uint32_t indices[INDICES], vertex_count, index_count;

static void add_vertex(const float p[3], const float n[3], const float color[3])
{
    vertex *v = &vertices[vertex_count++];
    for (int k = 0; k < 3; k++) {
        v->position[k] = p[k];
        v->normal[k] = (signed char)(127 * n[k]);
        v->color[k] = (unsigned char)(255 * color[k]);
    }
}

static void add_quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    const uint32_t corners[6] = { a, b, d, a, d, c };
    for (int k = 0; k < 6; k++) indices[index_count++] = corners[k];
}

static void make_ring(void)
{
    static const float color[3] = { 0.85f, 0.6f, 0.35f };
    for (uint32_t i = 0; i < RINGS; i++)
        for (uint32_t j = 0; j < SIDES; j++) {
            float a = 6.2831853f * (float)i / RINGS, b = 6.2831853f * (float)j / SIDES;
            float n[3] = { cosf(b) * cosf(a), sinf(b), cosf(b) * sinf(a) };
            float p[3] = { 0.8f * cosf(a) + 0.28f * n[0], 0.28f * n[1], 0.8f * sinf(a) + 0.28f * n[2] };
            uint32_t i2 = (i + 1) % RINGS, j2 = (j + 1) % SIDES;
            add_vertex(p, n, color);
            add_quad(i * SIDES + j, i * SIDES + j2, i2 * SIDES + j, i2 * SIDES + j2);
        }
}

/* Ground, back and a side, and a sheet of mist: corner, edge, edge, normal, colour. */
static void make_room(void)
{
    static const float quads[QUADS][15] = {
        { -3, 0, -2, 6, 0, 0, 0, 0, 5, 0, 1, 0, 0.75f, 0.75f, 0.75f },
        { -3, 0, -2, 6, 0, 0, 0, 1.6f, 0, 0, 0, 1, 0.5f, 0.7f, 0.75f },
        { -3, 0, -2, 0, 0, 5, 0, 1.1f, 0, 1, 0, 0, 0.8f, 0.3f, 0.2f },
        { -3, 0.12f, -2, 6, 0, 0, 0, 0, 5, 0, 1, 0, 0.8f, 0.85f, 0.9f }
    };
    for (int q = 0; q < QUADS; q++) {
        const float *s = quads[q];
        for (int k = 0; k < 4; k++) {
            float u = (float)(k & 1), v = (float)(k >> 1);
            float p[3] = { s[0] + u * s[3] + v * s[6], s[1] + u * s[4] + v * s[7], s[2] + u * s[5] + v * s[8] };
            add_vertex(p, s + 9, s + 12);
        }
        add_quad(vertex_count - 4, vertex_count - 3, vertex_count - 2, vertex_count - 1);
    }
}

static void make_ball(void)
{
    static const float white[3] = { 1, 1, 1 };
    const uint32_t first = vertex_count;
    for (uint32_t i = 0; i <= BALL; i++)
        for (uint32_t j = 0; j < 2 * BALL; j++) {
            float a = 3.14159265f * (float)i / BALL, b = 3.14159265f * (float)j / BALL;
            float n[3] = { sinf(a) * cosf(b), cosf(a), sinf(a) * sinf(b) };
            uint32_t at = first + i * 2 * BALL, next = (j + 1) % (2 * BALL);
            add_vertex(n, n, white);
            if (i < BALL) add_quad(at + j, at + next, at + 2 * BALL + j, at + 2 * BALL + next);
        }
}

/* ---- its shaders ---- */

static const char gbuffer_vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec3 color;\n"
    "uniform mat4 transform, to_clip;\n"
    "out vec3 facing, albedo;\n"
    "void main()\n"
    "{\n"
    "    facing = mat3(transform) * normal;\n"
    "    albedo = color;\n"
    "    gl_Position = to_clip * (transform * vec4(position, 1.0));\n"
    "}\n";
static const char gbuffer_fragment[] =
    "#version 330 core\n"
    "in vec3 facing, albedo;\n"
    "uniform int object;\n"
    "layout(location = 0) out vec4 out_color;                // RGBA8\n"
    "layout(location = 1) out vec4 out_normal;               // RGB10_A2: 0..1 for -1..1\n"
    "layout(location = 2) out uint out_object;               // R8UI: from 1; 0 for what never moves\n"
    "void main()\n"
    "{\n"
    "    out_color = vec4(albedo, 1.0);\n"
    "    out_normal = vec4(0.5 + 0.5 * normalize(facing), 0.0);\n"
    "    out_object = uint(object);\n"
    "}\n";
static const char glow_fragment[] =
    "#version 330 core\n"
    "in vec3 facing, albedo;\n"
    "uniform vec4 glow;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main() { color = glow + 0.0 * vec4(facing + albedo, 1.0); }\n";
static const char screen_vertex[] =
    "#version 330 core\n"
    "void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID & 2) - 1, 0.0, 1.0); }\n";
static const char background_fragment[] =
    "#version 330 core\n"
    "layout(location = 0) out vec4 color;\n"
    "void main() { color = mix(vec4(0.75, 0.6, 0.45, 1.0), vec4(0.1, 0.2, 0.5, 1.0), gl_FragCoord.y / 400.0); }\n";
static const char tone_fragment[] =
    "#version 330 core\n"
    "uniform sampler2D light;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main() { color = pow(texelFetch(light, ivec2(gl_FragCoord.xy), 0), vec4(1.0 / 2.2)); }\n";

/* ---- what there is ---- */

enum { GBUFFER, GLOW, BACKGROUND, TONE, OWN_PROGRAMS, MIST = OWN_PROGRAMS, PROGRAMS };
enum { ALBEDO, NORMALS, OBJECTS, DEPTH, LIT, LIT_DEPTH, SHOWN, TEXTURES };

typedef struct app {
    glbk_context    gl;
    /* the renderer's own */
    uint32_t        programs[PROGRAMS], textures[TEXTURES];
    uint32_t        seen, lit, shown;               /* framebuffers: G-buffer, light, the picture as it is shown */
    uint32_t        vertex_array, empty_array, buffers[2];
    float           to_clip[16], eye[3], ring[16], lamp[3];
    /* Dapple's */
    glbk_gbuffer        gbuffer;
    glbk_csm_maps       csm_maps;
    glbk_csm_instance   csm_ring;
    lsamp_light_desc    csm_lamp;
    glbk_csm_lights     csm_lights;
    glbk_csm_use        csm_use;
    glbk_csm_renderer   csm;
    envlt_lights       *sky;
    envsh_maps         *sky_layout;
    glbk_envsh_maps     sky_maps;
    glbk_envsh_renderer envsh;
} app;

static int fail(const char *what, const char *why) { return fprintf(stderr, "%s: %s\n", what, why), 1; }

static int32_t uniform(app *a, int program, const char *name)
{
    return a->gl.gl.GetUniformLocation(a->programs[program], name);
}

static void draw(app *a, int first, int count)
{
    a->gl.gl.BindVertexArray(a->vertex_array);
    a->gl.gl.DrawElements(GLBK_GL_TRIANGLES, count, GLBK_GL_UNSIGNED_INT, (const void *)((size_t)first * 4));
}

/* ---- the renderer's passes. Depth test and viewport are set once and for all ---- */

static void draw_gbuffer(app *a)
{
    static const float nothing[4] = { 0, 0, 0, 0 }, far_depth = 1;
    static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    static const uint32_t none[4] = { 0, 0, 0, 0 };
    const glbk_functions *gl = &a->gl.gl;
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, a->seen);
    gl->ClearBufferfv(GLBK_GL_COLOR, 0, nothing);
    gl->ClearBufferfv(GLBK_GL_COLOR, 1, nothing);
    gl->ClearBufferuiv(GLBK_GL_COLOR, 2, none);
    gl->ClearBufferfv(GLBK_GL_DEPTH, 0, &far_depth);
    gl->UseProgram(a->programs[GBUFFER]);
    gl->UniformMatrix4fv(uniform(a, GBUFFER, "to_clip"), 1, 0, a->to_clip);
    gl->UniformMatrix4fv(uniform(a, GBUFFER, "transform"), 1, 0, a->ring);
    gl->Uniform1i(uniform(a, GBUFFER, "object"), 1);
    draw(a, RING_AT, RING_INDICES);
    gl->UniformMatrix4fv(uniform(a, GBUFFER, "transform"), 1, 0, unit);
    gl->Uniform1i(uniform(a, GBUFFER, "object"), 0);
    draw(a, ROOM_AT, 18);
}

static void draw_glow(app *a, float x, float y, float z, float radius, const float color[4])
{
    const float transform[16] = { radius, 0, 0, 0, 0, radius, 0, 0, 0, 0, radius, 0, x, y, z, 1 };
    a->gl.gl.UniformMatrix4fv(uniform(a, GLOW, "transform"), 1, 0, transform);
    a->gl.gl.Uniform4fv(uniform(a, GLOW, "glow"), 1, color);
    draw(a, BALL_AT, BALL_INDICES);
}

/* What needs no light, into the picture that light will go to. It has a depth buffer of its own, as windows have. */
static void draw_background_and_beads(app *a, float angle)
{
    static const float far_depth = 1, white[4] = { 1.2f, 1.1f, 0.9f, 1 };
    const glbk_functions *gl = &a->gl.gl;
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, a->lit);
    gl->ClearBufferfv(GLBK_GL_DEPTH, 0, &far_depth);
    gl->Disable(NUMBER_DEPTH_TEST);
    gl->UseProgram(a->programs[BACKGROUND]);
    gl->BindVertexArray(a->empty_array);
    gl->DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
    gl->Enable(NUMBER_DEPTH_TEST);
    gl->UseProgram(a->programs[GLOW]);
    gl->UniformMatrix4fv(uniform(a, GLOW, "to_clip"), 1, 0, a->to_clip);
    draw_glow(a, a->lamp[0], a->lamp[1], a->lamp[2], a->csm_lamp.radius, white);
    for (int i = 0; i < BEADS; i++) {
        float t = angle + 6.2831853f * (float)i / BEADS, high = 1.15f + 0.25f * sinf(3 * t);
        const float color[4] = { 0.1f, 0.9f, 0.4f + 0.6f * (float)i / BEADS, 1 };
        draw_glow(a, 0.85f * cosf(t), high, 0.85f * sinf(t), 0.07f, color);
    }
}

/* ---- what is new: light ---- */

/* Everything that shadows the sky, each object by one call for many lights. */
static glbk_result draw_casters(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    app *a = (app *)user;
    glbk_result result = glbk_envsh_cast(gl, maps, a->ring);
    gl->gl.BindVertexArray(a->vertex_array);
    gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, RING_INDICES, GLBK_GL_UNSIGNED_INT, NULL, (int32_t)instances);
    if (result == GLBK_OK) result = glbk_envsh_cast(gl, maps, NULL);
    gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, 18, GLBK_GL_UNSIGNED_INT, (const void *)((size_t)ROOM_AT * 4),
                                 (int32_t)instances);
    return result;
}

/* The renderer's textures, by their GL names: nothing of them is copied or changed. */
static glbk_result import(app *a)
{
    glbk_texture own[4] = { { 0 } };
    glbk_import import = { 0 };
    for (int i = 0; i < 4; i++) {
        own[i].name = a->textures[i];
        own[i].width = WIDTH;
        own[i].height = HEIGHT;
    }
    import.color_map = &own[ALBEDO];
    import.normals = &own[NORMALS];
    import.normal_packing = GLBK_NORMAL_PACKING_UNIT;
    import.entities = &own[OBJECTS];
    import.depth = &own[DEPTH];
    memcpy(import.world_to_clip, a->to_clip, sizeof a->to_clip);
    memcpy(import.eye, a->eye, sizeof a->eye);
    for (int c = 0; c < 3; c++) import.material.diffuse[c] = 1;     /* a factor of the texture's */
    return glbk_gbuffer_import(&a->gl, &a->gbuffer, &import);
}

static glbk_csm_frame_desc lamp_frame(const app *a)
{
    glbk_csm_frame_desc frame = { 0 };
    frame.lights = &a->csm_lights;
    frame.uses = &a->csm_use;
    frame.use_count = 1;
    memcpy(frame.eye, a->eye, sizeof frame.eye);
    frame.offset = 1;
    return frame;
}

static glbk_result light_of_lamp(app *a)
{
    const glbk_csm_frame_desc frame = lamp_frame(a);
    glbk_result result = glbk_csm_maps_place(&a->gl, &a->csm_maps, &a->csm_ring, 1);
    if (result == GLBK_OK) result = glbk_csm_lights_update(&a->gl, &a->csm_lights, a->csm_use.start, &a->csm_lamp);
    glbk_csm_reset(&a->csm);                    /* things move: the frames before do not count */
    return result == GLBK_OK ? glbk_csm_render(&a->gl, &a->csm, &a->gbuffer, &frame) : result;
}

static glbk_result light_of_sky(app *a)
{
    static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    envsh_mesh casters[2] = {
        { vertices[0].position, RING_VERTICES, sizeof *vertices, NULL, 0, NULL, NULL, NULL },
        { vertices[RING_VERTICES].position, 12, sizeof *vertices, NULL, 0, NULL, NULL, NULL }
    };
    uint32_t count;
    const envlt_light *list = envlt_get_lights(a->sky, &count);
    envsh_lights all = { count, list->direction, list->irradiance, list->axis_u, list->axis_v, sizeof *list };
    glbk_envsh_frame frame = { 0 };
    envsh_result fitted;
    float transforms[2][16];
    memcpy(transforms[0], a->ring, sizeof transforms[0]);
    memcpy(transforms[1], unit, sizeof transforms[1]);
    fitted = envsh_maps_begin(a->sky_layout, &all, envsh_bounds_of(casters, 2, transforms[0]));
    if (fitted != ENVSH_OK) return fail("envshadow", envsh_result_text(fitted)), GLBK_ERR_INPUT;
    frame.views = envsh_views(a->sky_layout, &frame.view_count);
    frame.draw_fn = draw_casters;
    frame.user = a;
    return glbk_envsh_illuminate(&a->gl, &a->envsh, &a->gbuffer, &a->sky_maps, &frame);
}

/* Over what lies in the framebuffer: the sky's picture where it is nearer than the beads, with its depths; to it the
   lamp's, which is moved a little to the eye so that it passes there, too, and behind beads does not. Where the
   G-buffer sees nothing, the background stays. */
static glbk_result draw_pictures(app *a)
{
    float nearer[16];
    glbk_picture picture = { 1, a->to_clip };
    glbk_pass pass = { 0 };
    glbk_result result;
    memcpy(nearer, a->to_clip, sizeof nearer);
    for (int i = 0; i < 4; i++) nearer[4 * i + 2] -= 1e-5f * nearer[4 * i + 3];
    a->gl.gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, a->lit);          /* the techniques have bound their own */
    pass.viewport[2] = WIDTH;
    pass.viewport[3] = HEIGHT;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_envsh_resolve(&a->gl, &a->envsh, &a->gbuffer, &pass, &picture);
    pass.blend = GLBK_BLEND_ADD;
    picture.world_to_clip = nearer;
    return result == GLBK_OK ? glbk_csm_resolve(&a->gl, &a->csm, &a->gbuffer, &pass, &picture) : result;
}

/* A shader of the renderer's that reads the G-buffer: mist that grows thin towards what stands in it. glbk_write_glsl
   puts the version and the library's functions before the text, which is compiled and linked as the others are. */
static const char mist_vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 to_clip;\n"
    "out vec3 place;\n"
    "void main() { place = position; gl_Position = to_clip * vec4(position, 1.0); }\n";
static const char mist_fragment[] =
    "in vec3 place;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    glbk_point p;\n"
    "    float deep = glbk_read_point(ivec2(gl_FragCoord.xy), p) ? distance(p.position, place) : 10.0;\n"
    "    color = vec4(vec3(0.55, 0.6, 0.65), 0.35 * (1.0 - exp(-1.5 * deep)));\n"
    "}\n";

static glbk_result draw_mist(app *a)
{
    glbk_pass pass = { 0 };
    glbk_result result;
    pass.viewport[2] = WIDTH;
    pass.viewport[3] = HEIGHT;
    pass.depth = GLBK_DEPTH_LESS;
    pass.blend = GLBK_BLEND_OVER;
    result = glbk_begin(&a->gl, &pass, NULL);
    if (result == GLBK_OK) result = glbk_gbuffer_bind(&a->gl, &a->gbuffer, NULL);
    a->gl.gl.UseProgram(a->programs[MIST]);
    a->gl.gl.UniformMatrix4fv(uniform(a, MIST, "to_clip"), 1, 0, a->to_clip);
    draw(a, MIST_AT, 6);
    return result;
}

/* The renderer finds GL's state as it left it. */
static glbk_result draw_light(app *a)
{
    glbk_state state;
    glbk_result result;
    glbk_state_save(&a->gl, &state);
    result = import(a);
    if (result == GLBK_OK) result = light_of_lamp(a);
    if (result == GLBK_OK) result = light_of_sky(a);
    if (result == GLBK_OK) result = draw_pictures(a);
    if (result == GLBK_OK) result = draw_mist(a);
    glbk_state_restore(&a->gl, &state);
    return result;
}

static void look_at(app *a)
{
    static const float to[3] = { 0, 0.7f, 0 };
    float f[3], r[3], u[3], *m = a->to_clip;
    float length = 0, wide = 1.9f, near_plane = 0.5f, far_plane = 20;
    int i;
    a->eye[0] = 0.9f, a->eye[1] = 2.1f, a->eye[2] = 4.4f;
    for (i = 0; i < 3; i++) f[i] = to[i] - a->eye[i], length += f[i] * f[i];
    for (i = 0; i < 3; i++) f[i] /= sqrtf(length);
    length = sqrtf(f[0] * f[0] + f[2] * f[2]);
    r[0] = -f[2] / length, r[1] = 0, r[2] = f[0] / length;
    u[0] = r[1] * f[2] - r[2] * f[1], u[1] = r[2] * f[0] - r[0] * f[2], u[2] = r[0] * f[1] - r[1] * f[0];
    for (i = 0; i < 3; i++) {
        m[4 * i] = wide * r[i];
        m[4 * i + 1] = wide * WIDTH / HEIGHT * u[i];
        m[4 * i + 2] = (far_plane + near_plane) / (far_plane - near_plane) * f[i];
        m[4 * i + 3] = f[i];
    }
    for (i = 0; i < 4; i++) m[12 + i] = -(m[i] * a->eye[0] + m[4 + i] * a->eye[1] + m[8 + i] * a->eye[2]);
    m[14] -= 2 * far_plane * near_plane / (far_plane - near_plane);
}

static glbk_result frame(app *a, float angle, uint32_t to)
{
    const float c = cosf(1.9f * angle), s = sinf(1.9f * angle);
    const float ring[16] = { 1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 1.15f, 0, 1 };         /* it tumbles */
    const glbk_functions *gl = &a->gl.gl;
    glbk_result result;
    look_at(a);
    memcpy(a->ring, ring, sizeof ring);
    memcpy(a->csm_ring.transform, ring, sizeof ring);
    a->lamp[0] = -1.2f, a->lamp[1] = 1.95f, a->lamp[2] = 0.6f + 0.4f * c;
    memcpy(a->csm_lamp.position, a->lamp, sizeof a->lamp);
    draw_gbuffer(a);
    draw_background_and_beads(a, angle);
    result = draw_light(a);
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, to);
    gl->Disable(NUMBER_DEPTH_TEST);
    gl->UseProgram(a->programs[TONE]);
    gl->BindTexture(GLBK_GL_TEXTURE_2D, a->textures[LIT]);
    gl->BindVertexArray(a->empty_array);
    gl->DrawArrays(GLBK_GL_TRIANGLES, 0, 3);
    gl->Enable(NUMBER_DEPTH_TEST);
    return result;
}

/* ---- once: the renderer's own ---- */

static uint32_t link_program(const glbk_functions *gl, const char *vertex_text, const char *fragment_text)
{
    const char *texts[2] = { vertex_text, fragment_text };
    const uint32_t kinds[2] = { NUMBER_VERTEX_SHADER, NUMBER_FRAGMENT_SHADER }, program = gl->CreateProgram();
    int32_t linked = 0;
    for (int i = 0; i < 2; i++) {
        uint32_t shader = gl->CreateShader(kinds[i]);
        gl->ShaderSource(shader, 1, &texts[i], NULL);
        gl->CompileShader(shader);
        gl->AttachShader(program, shader);
        gl->DeleteShader(shader);
    }
    gl->LinkProgram(program);
    gl->GetProgramiv(program, NUMBER_LINK_STATUS, &linked);
    return linked ? program : 0;
}

static void make_texture(app *a, int which, int32_t internal, uint32_t format, uint32_t type)
{
    const glbk_functions *gl = &a->gl.gl;
    gl->BindTexture(GLBK_GL_TEXTURE_2D, a->textures[which]);
    gl->TexImage2D(GLBK_GL_TEXTURE_2D, 0, internal, WIDTH, HEIGHT, 0, format, type, NULL);
    gl->TexParameteri(GLBK_GL_TEXTURE_2D, NUMBER_MIN_FILTER, NUMBER_NEAREST);
    gl->TexParameteri(GLBK_GL_TEXTURE_2D, NUMBER_MAG_FILTER, NUMBER_NEAREST);
}

static uint32_t make_framebuffer(app *a, int first, uint32_t count, int depth)
{
    static const uint32_t all[3] = { GLBK_GL_COLOR_ATTACHMENT0, GLBK_GL_COLOR_ATTACHMENT0 + 1,
                                     GLBK_GL_COLOR_ATTACHMENT0 + 2 };
    const glbk_functions *gl = &a->gl.gl;
    uint32_t name;
    gl->GenFramebuffers(1, &name);
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, name);
    for (uint32_t i = 0; i < count; i++)
        gl->FramebufferTexture2D(GLBK_GL_FRAMEBUFFER, all[i], GLBK_GL_TEXTURE_2D, a->textures[(uint32_t)first + i], 0);
    if (depth)
        gl->FramebufferTexture2D(GLBK_GL_FRAMEBUFFER, GLBK_GL_DEPTH_ATTACHMENT, GLBK_GL_TEXTURE_2D,
                                 a->textures[depth], 0);
    gl->DrawBuffers((int32_t)count, all);
    return name;
}

static void make_vertex_array(app *a)
{
    const glbk_functions *gl = &a->gl.gl;
    make_ring();
    make_room();
    make_ball();
    gl->GenVertexArrays(1, &a->empty_array);
    gl->GenVertexArrays(1, &a->vertex_array);
    gl->BindVertexArray(a->vertex_array);
    gl->GenBuffers(2, a->buffers);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, a->buffers[0]);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, sizeof vertices, vertices, GLBK_GL_STATIC_DRAW);
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, a->buffers[1]);
    gl->BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, sizeof indices, indices, GLBK_GL_STATIC_DRAW);
    for (uint32_t i = 0; i < 3; i++) gl->EnableVertexAttribArray(i);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, sizeof(vertex), NULL);
    gl->VertexAttribPointer(1, 3, GLBK_GL_BYTE, 1, sizeof(vertex), (const void *)12);
    gl->VertexAttribPointer(2, 3, GLBK_GL_UNSIGNED_BYTE, 1, sizeof(vertex), (const void *)16);
}

static int make_renderer(app *a)
{
    static const char *const texts[OWN_PROGRAMS][2] = {
        { gbuffer_vertex, gbuffer_fragment }, { gbuffer_vertex, glow_fragment },
        { screen_vertex, background_fragment }, { screen_vertex, tone_fragment }
    };
    const glbk_functions *gl = &a->gl.gl;
    make_vertex_array(a);
    gl->GenTextures(TEXTURES, a->textures);
    make_texture(a, ALBEDO, NUMBER_RGBA8, NUMBER_RGBA, GLBK_GL_UNSIGNED_BYTE);
    make_texture(a, NORMALS, NUMBER_RGB10_A2, NUMBER_RGBA, NUMBER_UNSIGNED_INT_2_10_10_10_REV);
    make_texture(a, OBJECTS, NUMBER_R8UI, NUMBER_RED_INTEGER, GLBK_GL_UNSIGNED_BYTE);
    make_texture(a, DEPTH, NUMBER_DEPTH_COMPONENT24, NUMBER_DEPTH_COMPONENT, GLBK_GL_UNSIGNED_INT);
    make_texture(a, LIT, NUMBER_RGBA16F, NUMBER_RGBA, GLBK_GL_FLOAT);
    make_texture(a, LIT_DEPTH, NUMBER_DEPTH_COMPONENT24, NUMBER_DEPTH_COMPONENT, GLBK_GL_UNSIGNED_INT);
    make_texture(a, SHOWN, NUMBER_RGBA8, NUMBER_RGBA, GLBK_GL_UNSIGNED_BYTE);
    a->seen = make_framebuffer(a, ALBEDO, 3, DEPTH);
    a->lit = make_framebuffer(a, LIT, 1, LIT_DEPTH);
    a->shown = make_framebuffer(a, SHOWN, 1, 0);
    gl->Viewport(0, 0, WIDTH, HEIGHT);
    gl->DepthFunc(NUMBER_LESS);
    gl->Enable(NUMBER_DEPTH_TEST);
    for (int i = 0; i < OWN_PROGRAMS; i++) {
        a->programs[i] = link_program(gl, texts[i][0], texts[i][1]);
        if (!a->programs[i]) return fail("OpenGL", "a shader of the renderer does not link");
    }
    return 0;
}

/* ---- once: Dapple's ---- */

static glbk_result make_lamp(app *a)
{
    cohsm_mesh mesh = { vertices[0].position, RING_VERTICES, sizeof *vertices, indices, RING_INDICES,
                        NULL, NULL, NULL };
    glbk_csm_renderer_desc size = { WIDTH, HEIGHT, 0, 0, NULL };
    glbk_csm_lights_desc lights = { 0 };
    glbk_csm_frame_desc first;
    cohsm_desc desc = { 0 };
    cohsm_maps *maps;
    cohsm_result built;
    glbk_csm_block block;
    glbk_result result;
    desc.domain.side[0] = desc.domain.side[1] = 96;
    built = cohsm_build(&desc, &mesh, &maps, NULL);
    if (built != COHSM_OK) return fail("csm", cohsm_result_text(built)), GLBK_ERR_INPUT;
    block.data = cohsm_data(maps, &block.bytes);
    a->csm_lamp.kind = LSAMP_LIGHT_SPHERE;
    a->csm_lamp.radius = 0.15f;
    a->csm_lamp.radiance[0] = 60, a->csm_lamp.radiance[1] = 52, a->csm_lamp.radiance[2] = 40;
    lights.lights = &a->csm_lamp;
    lights.light_count = 1;
    a->csm_use.kind = LSAMP_LIGHT_SPHERE;
    a->csm_use.ask = COHSM_LIGHT_POSITION;
    a->csm_use.maps = &a->csm_maps;
    a->csm_use.sample_count = LAMP_SAMPLES;
    result = glbk_csm_maps_create(&a->gl, &block, 1, 1, &a->csm_ring.start, &a->csm_maps);
    cohsm_free(maps);
    if (result == GLBK_OK) result = glbk_csm_lights_create(&a->gl, &lights, &a->csm_use.start, &a->csm_lights);
    if (result == GLBK_OK) result = glbk_csm_renderer_create(&a->gl, &size, &a->csm);
    first = lamp_frame(a);
    return result == GLBK_OK ? glbk_csm_prepare(&a->gl, &a->csm, &first) : result;      /* compiles it now */
}

static glbk_result make_sky(app *a)
{
    static float rgb[3 * 64 * 32];
    envlt_map map = { ENVLT_PROJECTION_LATLONG, 64, 32, rgb, 0 };
    const glbk_envsh_renderer_desc size = { WIDTH, HEIGHT };
    envsh_maps_desc layout = { 0 };
    const glbk_envsh_maps_desc maps = { SKY_LIGHTS, &layout, { 0, 0, 0, 0, NULL, NULL } };
    envlt_desc desc = { 0 };
    envlt_result lit;
    envsh_result laid;
    glbk_result result;
    for (uint32_t i = 0; i < 64 * 32; i++) {
        float d[3];
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 64, 32, 0, (float)(i % 64) + 0.5f, (float)(i / 64) + 0.5f, d);
        for (uint32_t c = 0; c < 3; c++)
            rgb[3 * i + c] = d[1] < 0 ? 0.05f : 0.12f + 0.05f * (float)c + (d[0] > 0.6f ? 0.9f - 0.25f * (float)c : 0);
    }
    desc.light_count = SKY_LIGHTS;
    layout.map_side = MAP;
    layout.no_depth = 1;                        /* the GPU has it */
    lit = envlt_create(&desc, &map, &a->sky, NULL);
    if (lit != ENVLT_OK) return fail("envlights", envlt_result_text(lit)), GLBK_ERR_INPUT;
    laid = envsh_maps_create(&layout, SKY_LIGHTS, &a->sky_layout);
    if (laid != ENVSH_OK) return fail("envshadow", envsh_result_text(laid)), GLBK_ERR_INPUT;
    result = glbk_envsh_maps_create(&a->gl, &maps, &a->sky_maps);
    return result == GLBK_OK ? glbk_envsh_renderer_create(&a->gl, &size, &a->envsh) : result;
}

/* The slots are set once. They are those of one part; each further part that the shader used would get an offset. */
static glbk_result make_mist(app *a)
{
    static char text[16384];
    glbk_shader shader = { 0 };
    size_t bytes;
    shader.uses = "gbuffer";
    shader.text = mist_fragment;
    shader.parts[0] = glbk_gbuffer_part();
    bytes = glbk_write_glsl(GLBK_GLSL_330, !a->gl.float_targets, &shader, text, sizeof text);
    if (!bytes || bytes > sizeof text) return fail("the mist's shader", "its text does not fit"), GLBK_ERR_NAME;
    a->programs[MIST] = link_program(&a->gl.gl, mist_vertex, text);
    if (!a->programs[MIST]) return fail("OpenGL", "the mist's shader does not link"), GLBK_ERR_LINK;
    return glbk_set_slots(&a->gl, glbk_gbuffer_part(), NULL, a->programs[MIST]);
}

static glbk_result make_light(app *a)
{
    const glbk_gbuffer_desc desc = { WIDTH, HEIGHT, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_result result = glbk_gbuffer_create(&a->gl, &desc, &a->gbuffer);
    if (result == GLBK_OK) result = make_mist(a);
    if (result == GLBK_OK) result = make_lamp(a);
    return result == GLBK_OK ? make_sky(a) : result;
}

static void free_light(app *a)
{
    glbk_envsh_renderer_free(&a->gl, &a->envsh);
    glbk_envsh_maps_free(&a->gl, &a->sky_maps);
    envsh_maps_free(a->sky_layout);
    envlt_free(a->sky);
    glbk_csm_renderer_free(&a->gl, &a->csm);
    glbk_csm_lights_free(&a->gl, &a->csm_lights);
    glbk_csm_maps_free(&a->gl, &a->csm_maps);
    glbk_gbuffer_free(&a->gl, &a->gbuffer);
    glbk_free(&a->gl);
}

/* ---- the program ---- */

static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)glfwGetProcAddress(name);
}

/* The library says here why a call of it failed. */
static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

static int save(app *a, const char *path)
{
    static unsigned char rgba[HEIGHT][WIDTH][4];
    FILE *file;
    int x, y;
    a->gl.gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, a->shown);
    a->gl.gl.ReadPixels(0, 0, WIDTH, HEIGHT, NUMBER_RGBA, GLBK_GL_UNSIGNED_BYTE, rgba);
    file = fopen(path, "wb");
    if (!file) return fail(path, "cannot be written");
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = HEIGHT - 1; y >= 0; y--)
        for (x = 0; x < WIDTH; x++) fwrite(rgba[y][x], 1, 3, file);
    return fclose(file) != 0;
}

/* Picking: what the G-buffer holds at the mouse. */
static void say_what_is_there(app *a, GLFWwindow *window)
{
    static glbk_pixel row[WIDTH];
    double x, y;
    glfwGetCursorPos(window, &x, &y);
    if (!(x >= 0 && y >= 0 && x < WIDTH && y < HEIGHT)) return;
    if (glbk_gbuffer_read(&a->gl, &a->gbuffer, HEIGHT - 1 - (uint32_t)y, 1, row) != GLBK_OK) return;
    if (row[(int)x].normal[0] == 0 && row[(int)x].normal[1] == 0 && row[(int)x].normal[2] == 0) printf("nothing\n");
    else printf("%s at %.2f %.2f %.2f\n", row[(int)x].entity == 1 ? "the ring" : "the room",
                (double)row[(int)x].position[0], (double)row[(int)x].position[1], (double)row[(int)x].position[2]);
}

int main(int count, char **values)
{
    static app a;
    GLFWwindow *window;
    glbk_desc desc = { 0 };
    glbk_result result;
    if (!glfwInit()) return fail("GLFW", "there is no display");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
#ifdef __APPLE__
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, 1);      /* there is no other */
    glfwWindowHint(GLFW_COCOA_RETINA_FRAMEBUFFER, 0);   /* WIDTH x HEIGHT pixels */
#endif
    glfwWindowHint(GLFW_RESIZABLE, 0);
    glfwWindowHint(GLFW_VISIBLE, count < 2);
    window = glfwCreateWindow(WIDTH, HEIGHT, "a deferred renderer, lit", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    result = glbk_init(&a.gl, &desc);
    if (result != GLBK_OK) return fail("OpenGL", glbk_result_text(result));
    if (make_renderer(&a) != 0) return 1;
    result = make_light(&a);
    while (result == GLBK_OK && !glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        result = frame(&a, count > 1 ? 0.5f : (float)glfwGetTime() * 0.3f, count > 1 ? a.shown : 0);
        if (result == GLBK_OK) result = glbk_check(&a.gl);
        if (count > 1) break;
        if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS) say_what_is_there(&a, window);
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    if (result != GLBK_OK) return fail("OpenGL", glbk_result_text(result));
    count = count > 1 && save(&a, values[1]);
    free_light(&a);
    glfwTerminate();
    return count;
}
