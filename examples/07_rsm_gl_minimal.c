/* 07_rsm_gl_minimal.c - bounced light on the GPU: a spot turns in a coloured room. Per frame its reflective shadow map
   and the picture's G-buffer are drawn by one function, then direct and bounced light are added by passes of
   gl_backend.h.

   cc -O2 07_rsm_gl_minimal.c -lglfw -lm -o rsm_gl_minimal && ./rsm_gl_minimal       Escape ends it
   ./rsm_gl_minimal picture.ppm                                            one picture, no visible window */
#define GL_BACKEND_IMPLEMENTATION
#include "gl_backend.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 480, QUADS = 8 };

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

/* Called for the light's view and for ours. */
static void draw_room(void *user, glbk_context *gl, glbk_rsm_renderer *r)
{
    int q, c;
    (void)user;
    gl->gl.BindVertexArray(room);
    for (q = 0; q < QUADS; q++) {
        glbk_rsm_surface s = { { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 0, 0, 0 }, 0, NULL, 0 };
        for (c = 0; c < 3; c++) s.albedo[c] = quads[q][9 + c];
        glbk_rsm_object(gl, r, &s);
        gl->gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 4 * q, 4);
    }
}

static int fail(const char *what, const char *why) { return fprintf(stderr, "%s: %s\n", what, why), 1; }
static glbk_proc get_proc(const char *name, void *user) { return (void)user, (glbk_proc)glfwGetProcAddress(name); }

static int save(glbk_context *gl, const char *path)
{
    static unsigned char rgba[HEIGHT][WIDTH][4];
    FILE *file = fopen(path, "wb");
    int x, y;
    if (!file) return fail(path, "cannot be written");
    gl->gl.ReadPixels(0, 0, WIDTH, HEIGHT, 0x1908 /* GL_RGBA */, GLBK_GL_UNSIGNED_BYTE, rgba);
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = HEIGHT - 1; y >= 0; y--)
        for (x = 0; x < WIDTH; x++) fwrite(rgba[y][x], 1, 3, file);
    return fclose(file) != 0;
}

static glbk_result frame(glbk_context *gl, glbk_rsm_renderer *r, glbk_rsm_map *map, glbk_rsm_lamp *lamp, float angle)
{
    static const float eye[3] = { 0, 1, 4.4f },
                       view[16] = { 2, 0, 0, 0, 0, 2.667f, 0, 0, 0, 0, -1.02f, -1, 0, -2.667f, 4.286f, 4.4f };
    const glbk_rsm_direct_desc direct = { 3, 0.5f, 1 };
    const glbk_rsm_gather_desc gather = { GLBK_RSM_PATTERN_FLUX, 400, 0, 0, 0, 0.3f, 0, 1, 0, 0 };
    const glbk_rsm_grid grid = { 0, 0, 0, 0, 0, 0, 0 };        /* all defaults */
    const glbk_pass screen = {
        NULL, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    const glbk_rsm_map *lit = map;
    glbk_result result;
    lamp->direction[0] = 0.8f * sinf(angle);
    lamp->direction[1] = -0.6f;
    lamp->direction[2] = -0.8f * cosf(angle);
    result = glbk_rsm_map_place(gl, map, lamp);
    if (result == GLBK_OK) result = glbk_rsm_map_draw(gl, r, map, draw_room, NULL);
    if (result == GLBK_OK) result = glbk_rsm_gbuffer_draw(gl, r, view, eye, draw_room, NULL);
    if (result == GLBK_OK) result = glbk_rsm_direct(gl, r, &lit, 1, &direct);
    if (result == GLBK_OK) result = glbk_rsm_gather(gl, r, &map, 1, &gather, &grid);
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);         /* the window: passes have bound others */
    return result == GLBK_OK ? glbk_rsm_resolve(gl, r, &screen, 1, 1) : result;
}

int main(int count, char **values)
{
    glbk_rsm_lamp lamp = { GLBK_RSM_SPOT, { 0, 1.9f, 0.9f }, { 0, -1, 0 }, { 0, 0, 0 }, { 9, 9, 9 }, 0, 1, 0.05f, 10 };
    glbk_rsm_renderer_desc size = { WIDTH, HEIGHT, 1, 0 };
    glbk_desc desc = { 0 };
    glbk_context gl;
    glbk_rsm_renderer renderer;
    glbk_rsm_map map;
    GLFWwindow *window;
    static char log[2000];

    if (!glfwInit()) return fail("GLFW", "there is no display");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SRGB_CAPABLE, 1);       /* the passes write linear colours */
    glfwWindowHint(GLFW_RESIZABLE, 0);
    glfwWindowHint(GLFW_VISIBLE, count < 2);
    window = glfwCreateWindow(WIDTH, HEIGHT, "bounced light", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    desc.get_proc = get_proc;
    desc.log = log;
    desc.log_size = sizeof log;
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_rsm_renderer_create(&gl, &size, &renderer) != GLBK_OK ||
        glbk_rsm_map_create(&gl, &lamp, 256, &map) != GLBK_OK)
        return fail("OpenGL", log);
    make_room(&gl);
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (frame(&gl, &renderer, &map, &lamp, count > 1 ? -0.6f : sinf((float)glfwGetTime())) != GLBK_OK)
            return fail("OpenGL", log);
        if (count > 1) return save(&gl, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_rsm_map_destroy(&gl, &map);
    glbk_rsm_renderer_destroy(&gl, &renderer);
    glbk_destroy(&gl);
    glfwTerminate();
    return 0;
}
