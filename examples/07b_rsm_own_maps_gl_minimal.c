/* 07b_rsm_own_maps_gl_minimal.c - 07 with a map of your own renderer: its shader draws colours, normals and depth of
   what the spot sees into textures of its own formats, and glbk_rsm_map_import takes them as they are.

   cc -O2 07b_rsm_own_maps_gl_minimal.c -lglfw -lm -o rsm_own_maps_gl && ./rsm_own_maps_gl       Escape ends it
   ./rsm_own_maps_gl picture.ppm                                           one picture, no visible window */
#define RSM_IMPLEMENTATION
#include "rsm.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_RSM_IMPLEMENTATION
#include "gl_backend/gl_rsm.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 480, QUADS = 8, SIDE = 256 };

/* ---- the room: parallelograms as corner, edge, edge, and their colours ---- */

static const float quads[QUADS][12] = {
    { -1, 0, -1, 2, 0, 0, 0, 0, 2, 0.8f, 0.8f, 0.8f },          /* floor */
    { -1, 2, -1, 2, 0, 0, 0, 0, 2, 0.8f, 0.8f, 0.8f },          /* ceiling */
    { -1, 0, -1, 2, 0, 0, 0, 2, 0, 0.8f, 0.8f, 0.8f },          /* back */
    { -1, 0, -1, 0, 0, 2, 0, 2, 0, 0.75f, 0.1f, 0.05f },        /* left */
    { 1, 0, -1, 0, 0, 2, 0, 2, 0, 0.1f, 0.6f, 0.1f },           /* right */
    { 0.3f, 0, 0.5f, 0.45f, 0, -0.4f, 0, 0.8f, 0, 0.9f, 0.8f, 0.4f },      /* a block */
    { 0.3f, 0, 0.5f, -0.4f, 0, -0.45f, 0, 0.8f, 0, 0.9f, 0.8f, 0.4f },
    { 0.3f, 0.8f, 0.5f, 0.45f, 0, -0.4f, -0.4f, 0, -0.45f, 0.9f, 0.8f, 0.4f }
};

static uint32_t room;                           /* vertex array */

static void make_room(glbk_context *gl)
{
    static float corners[QUADS][4][3];
    glbk_buffer buffer;
    int q, k, c;
    for (q = 0; q < QUADS; q++)
        for (k = 0; k < 4; k++)
            for (c = 0; c < 3; c++)
                corners[q][k][c] = quads[q][c] + (k & 1 ? quads[q][3 + c] : 0) + (k & 2 ? quads[q][6 + c] : 0);
    gl->gl.GenVertexArrays(1, &room);
    if (glbk_buffer_create(gl, sizeof corners, corners, &buffer) != GLBK_OK) return;
    gl->gl.BindVertexArray(room);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, buffer.name);
    gl->gl.EnableVertexAttribArray(0);
    gl->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
}

static void draw_seen(glbk_context *gl, glbk_gbuffer *seen)
{
    int q, c;
    gl->gl.BindVertexArray(room);
    for (q = 0; q < QUADS; q++) {
        glbk_surface s = { 0 };
        for (c = 0; c < 3; c++) s.material.diffuse[c] = quads[q][9 + c];
        glbk_gbuffer_object(gl, seen, &s);
        gl->gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 4 * q, 4);
    }
}

/* ---- what the spot sees, by your own renderer ---- */

static const char lit_vertex[] =
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 world_to_clip;\n"
    "out vec3 place;\n"
    "void main() { place = position; gl_Position = world_to_clip * vec4(position, 1.0); }\n";
static const char lit_fragment[] =
    "uniform vec4 albedo, lamp;\n"
    "in vec3 place;\n"
    "layout(location = 0) out vec4 color;\n"
    "layout(location = 1) out vec4 normal;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(cross(dFdx(place), dFdy(place)));\n"
    "    color = albedo;\n"
    "    normal = vec4(0.5 * faceforward(n, place - lamp.xyz, n) + 0.5, 1.0);\n"
    "}\n";

typedef struct own_map { glbk_texture color, normal, depth; glbk_target target; glbk_program program; } own_map;

static int make_own_map(glbk_context *gl, own_map *m)
{
    const glbk_source source = { lit_vertex, lit_fragment, NULL, NULL, NULL, NULL, { NULL }, { { 0, 0 } } };
    glbk_texture_desc desc = { GLBK_FORMAT_RGBA8, SIDE, SIDE, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    to.color[0] = &m->color;
    to.color[1] = &m->normal;
    to.depth = &m->depth;
    if (glbk_texture_create(gl, &desc, &m->color) != GLBK_OK || glbk_texture_create(gl, &desc, &m->normal) != GLBK_OK)
        return 0;
    desc.format = GLBK_FORMAT_DEPTH32F;
    return glbk_texture_create(gl, &desc, &m->depth) == GLBK_OK && glbk_target_create(gl, &to, &m->target) == GLBK_OK &&
           glbk_program_compile(gl, &source, &m->program) == GLBK_OK;
}

/* rsm.h says by which matrix the light looks. */
static glbk_result draw_own_map(glbk_context *gl, own_map *m, const rsm_light *lamp)
{
    static const float nothing[4] = { 0, 0, 0, 0 };
    const glbk_pass pass = {
        &m->target, { 0, 0, 0, 0 }, GLBK_DEPTH_LESS, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    const float at[4] = { lamp->position[0], lamp->position[1], lamp->position[2], 1 };
    float matrix[16];
    rsm_map *looks;
    rsm_desc desc = { 0 };
    glbk_result result = glbk_begin(gl, &pass, &m->program);
    int q;
    desc.side = SIDE;
    desc.light = *lamp;
    if (result != GLBK_OK || rsm_map_create(&desc, &looks) != RSM_OK) return result;
    rsm_map_matrix(looks, 0, matrix);
    rsm_map_free(looks);
    glbk_clear(gl, &m->target, 0, nothing);
    glbk_clear(gl, &m->target, 1, nothing);
    glbk_clear_depth(gl, 1);
    gl->gl.UniformMatrix4fv(gl->gl.GetUniformLocation(gl->program, "world_to_clip"), 1, 0, matrix);
    gl->gl.Uniform4fv(gl->gl.GetUniformLocation(gl->program, "lamp"), 1, at);
    gl->gl.BindVertexArray(room);
    for (q = 0; q < QUADS; q++) {
        const float albedo[4] = { quads[q][9], quads[q][10], quads[q][11], 1 };
        gl->gl.Uniform4fv(gl->gl.GetUniformLocation(gl->program, "albedo"), 1, albedo);
        gl->gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 4 * q, 4);
    }
    return GLBK_OK;
}

static glbk_result take_own_map(glbk_context *gl, glbk_rsm_renderer *r, const own_map *m, glbk_rsm_map *map)
{
    glbk_rsm_import in = { 0 };
    in.depth.texture = &m->depth;
    in.normals.texture = &m->normal;
    in.normal_packing = GLBK_NORMAL_PACKING_UNIT;       /* 0..1 for -1..1 */
    in.colors.texture = &m->color;
    return glbk_rsm_map_import(gl, r, map, 0, &in);
}

/* What the map holds; the call waits for the GPU. */
static int tell(glbk_context *gl, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    rsm_stats s;
    if (glbk_rsm_map_stats(gl, r, map, 1, &s) != GLBK_OK) return 1;
    printf("%u of %u texels are lit: the room reflects %.3f of %.3f W\n", (unsigned)s.lit_texels, SIDE * SIDE,
           (double)s.reflected[0], (double)s.incident[0]);
    return 0;
}

/* ---- from radiance to what a window shows ---- */

static const char tone[] =
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 light = glbk_unpack(texelFetch(glbk_source, ivec2(gl_FragCoord.xy), 0)).rgb;\n"
    "    color = vec4(pow(light, vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

typedef struct canvas { glbk_texture texture; glbk_target target; } canvas;

static glbk_result make_canvas(glbk_context *gl, glbk_format format, canvas *out)
{
    const glbk_texture_desc desc = { format, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    glbk_result result = glbk_texture_create(gl, &desc, &out->texture);
    to.color[0] = &out->texture;
    return result == GLBK_OK ? glbk_target_create(gl, &to, &out->target) : result;
}

/* target: of a picture, since what a window holds that is not shown is undefined; NULL = the window */
static glbk_result show(glbk_context *gl, glbk_program *program, const canvas *light, const glbk_target *target)
{
    const glbk_pass screen = {
        target, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    glbk_result result;
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);         /* the window: passes have bound others */
    result = glbk_begin(gl, &screen, program);
    glbk_bind_texture(gl, GLBK_SLOT_glbk_source, &light->texture);
    glbk_draw_screen(gl);
    return result;
}

static int fail(const char *what, const char *why) { return fprintf(stderr, "%s: %s\n", what, why), 1; }

/* The library says here why a call of it failed. */
static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}
static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)glfwGetProcAddress(name);
}

static int save(glbk_context *gl, const glbk_target *target, const char *path)
{
    static float rgba[HEIGHT][WIDTH][4];
    FILE *file;
    int x, y, c;
    if (glbk_target_read(gl, target, 0, 0, 0, WIDTH, HEIGHT, rgba) != GLBK_OK) return fail("OpenGL", "no picture");
    file = fopen(path, "wb");
    if (!file) return fail(path, "cannot be written");
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = HEIGHT - 1; y >= 0; y--)
        for (x = 0; x < WIDTH; x++)
            for (c = 0; c < 3; c++) putc((int)(rgba[y][x][c] * 255 + 0.5f), file);
    return fclose(file) != 0;
}

typedef struct shot { float angle, eye_x; uint32_t index; } shot;      /* of the spot; of the eye; of the frame */

static glbk_result frame(glbk_context *gl, glbk_rsm_renderer *r, glbk_gbuffer *seen, own_map *own,
                         glbk_rsm_map *map, rsm_light *lamp, const shot *now, const canvas *light)
{
    const float eye[3] = { now->eye_x, 1, 4.4f };
    const float view[16] = { 2, 0, 0, 0, 0, 2.667f, 0, 0, 0, 0, -1.02f, -1, -2 * now->eye_x, -2.667f, 4.286f, 4.4f };
    gifilt_frame filter = { 0 };
    rsm_direct_desc direct = { 0 };
    rsm_gather_desc gather = { 0 };             /* by flux */
    const glbk_pass to_light = {
        &light->target, { 0, 0, 0, 0 }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    const glbk_rsm_map *lit = map;
    glbk_result result;
    direct.tap_side = 3;
    gather.sample_count = 400;
    gather.seed = now->index;
    gather.near_limit = 0.3f;
    filter.world_to_clip = view;
    filter.history = 4;
    filter.passes = -1;                         /* over frames, not over neighbours */
    lamp->direction[0] = 0.8f * sinf(now->angle);
    lamp->direction[1] = -0.6f;
    lamp->direction[2] = -0.8f * cosf(now->angle);
    result = glbk_rsm_map_place(gl, map, lamp);
    if (result == GLBK_OK) result = draw_own_map(gl, own, lamp);
    if (result == GLBK_OK) result = take_own_map(gl, r, own, map);
    if (result == GLBK_OK) result = glbk_gbuffer_begin(gl, seen, view, eye);
    if (result != GLBK_OK) return result;
    draw_seen(gl, seen);
    result = glbk_rsm_direct(gl, r, seen, &lit, 1, &direct);
    if (result == GLBK_OK) result = glbk_rsm_interpolate(gl, r, seen, &map, 1, &gather, NULL);
    if (result == GLBK_OK) result = glbk_rsm_denoise(gl, r, seen, &filter, NULL);
    return result == GLBK_OK ? glbk_rsm_resolve(gl, r, seen, &to_light, NULL, 1, 1) : result;
}

static GLFWwindow *open_window(int visible)
{
    GLFWwindow *window;
    if (!glfwInit()) return NULL;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
#ifdef __APPLE__
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, 1);      /* there is no other */
    glfwWindowHint(GLFW_COCOA_RETINA_FRAMEBUFFER, 0);   /* WIDTH x HEIGHT pixels */
#endif
    glfwWindowHint(GLFW_RESIZABLE, 0);
    glfwWindowHint(GLFW_VISIBLE, visible);
    window = glfwCreateWindow(WIDTH, HEIGHT, "bounced light", NULL, NULL);
    if (!window) return NULL;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    return window;
}

int main(int count, char **values)
{
    rsm_light lamp = { RSM_LIGHT_SPOT, { 0, 1.9f, 0.9f }, { 0, -1, 0 }, { 0, 0, 0 }, { 9, 9, 9 }, 0, 0.5f, 0.05f, 10 };
    glbk_rsm_renderer_desc size = { WIDTH, HEIGHT, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_desc desc = { 0 };
    glbk_context gl;
    glbk_rsm_renderer renderer;
    glbk_gbuffer_desc view = { WIDTH, HEIGHT, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer seen;
    glbk_rsm_map map;
    own_map own = { 0 };
    glbk_source source = { NULL, tone, NULL, "base_bindings", NULL, NULL, { NULL }, { { 0, 0 } } };
    glbk_program program;
    canvas light, picture;
    shot now = { 0, 0, 0 };
    GLFWwindow *window;

    window = open_window(count < 2);
    if (!window) return fail("GLFW", "there is no display, or no OpenGL 3.3");
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_rsm_renderer_create(&gl, &size, &renderer) != GLBK_OK ||
        glbk_gbuffer_create(&gl, &view, &seen) != GLBK_OK ||
        glbk_rsm_map_create(&gl, &lamp, SIDE, &map) != GLBK_OK || !make_own_map(&gl, &own) ||
        glbk_program_compile(&gl, &source, &program) != GLBK_OK ||
        make_canvas(&gl, GLBK_FORMAT_COLOR, &light) != GLBK_OK ||
        make_canvas(&gl, GLBK_FORMAT_RGBA8, &picture) != GLBK_OK)
        return fail("OpenGL", "it does not work");
    make_room(&gl);
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        const float time = count > 1 ? 0.0f : (float)glfwGetTime(), eye_x = fmodf(time, 8) < 4 ? 0.0f : 0.6f;
        if (now.eye_x < eye_x || now.eye_x > eye_x) glbk_rsm_reset(&renderer);     /* a cut */
        now.eye_x = eye_x;
        now.angle = count > 1 ? -0.6f : sinf(time);
        if (frame(&gl, &renderer, &seen, &own, &map, &lamp, &now, &light) != GLBK_OK ||
            show(&gl, &program, &light, count > 1 ? &picture.target : NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        now.index++;
        if (count > 1)
            return save(&gl, &picture.target, values[1]) || tell(&gl, &renderer, &map) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_target_free(&gl, &picture.target);
    glbk_texture_free(&gl, &picture.texture);
    glbk_target_free(&gl, &light.target);
    glbk_texture_free(&gl, &light.texture);
    glbk_program_free(&gl, &program);
    glbk_rsm_map_free(&gl, &map);
    glbk_program_free(&gl, &own.program);
    glbk_target_free(&gl, &own.target);
    glbk_texture_free(&gl, &own.color);
    glbk_texture_free(&gl, &own.normal);
    glbk_texture_free(&gl, &own.depth);
    glbk_rsm_renderer_free(&gl, &renderer);
    glbk_gbuffer_free(&gl, &seen);
    glbk_free(&gl);
    glfwTerminate();
    return 0;
}
