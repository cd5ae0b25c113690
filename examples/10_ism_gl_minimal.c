/* 10_ism_gl_minimal.c - bounced light with moving shadows in a shader of your own: ism.h chooses 256 virtual point
   lights and the surfels of their shadow maps, gl_ism.h draws these maps, and the fragment shader below sums all
   lights by ism_light().

   cc -O2 10_ism_gl_minimal.c -lglfw -lm -o ism_gl_minimal && ./ism_gl_minimal                     Escape ends it
   ./ism_gl_minimal picture.ppm                     one picture, no visible window; without a display: xvfb-run -a */
#define ISM_IMPLEMENTATION
#include "ism.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_ISM_IMPLEMENTATION
#include "gl_backend/gl_ism.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 480, HEIGHT = 300, RSM = 64, SEEN_W = 64, SEEN_H = 40, VPLS = 256, SURFELS = 4096, LAZY = 8 };

/* ---- the scene: a room lit by the sun through its open roof, and a block that swings in it ---- */

static float    boxes[2][2][3] = { { { -3, 0, -3 }, { 3, 3, 3 } }, { { -0.8f, 1, -1.2f }, { 0.8f, 1.3f, 0.4f } } };
static float    corners[2 * 8 * 3];
static uint32_t triangles[2 * 36];

static ism_mesh make_mesh(float time)
{
    static const uint32_t faces[36] = { 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                        2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5 };
    ism_mesh mesh = { corners, 16, 0, triangles, 72, NULL, NULL, NULL, NULL, NULL };
    uint32_t b, i, k;
    boxes[1][0][0] = -0.8f + sinf(time);
    boxes[1][1][0] = 0.8f + sinf(time);
    for (b = 0; b < 2; b++) {
        for (i = 0; i < 8; i++)
            for (k = 0; k < 3; k++) corners[3 * (8 * b + i) + k] = boxes[b][i >> k & 1u][k];
        for (i = 0; i < 36; i++) triangles[36 * b + i] = 8 * b + faces[i];
    }
    return mesh;
}

/* Nearest wall along a ray: position and normal. The room is seen from inside, the block from outside. */
static void trace(const float *o, const float *d, float *p, float *n)
{
    float best = 1e30f;
    int b, k, side, j;
    for (b = 0; b < 2; b++)
        for (k = 0; k < 3; k++)
            for (side = 0; side < 2; side++) {
                float plane = boxes[b][side][k], t = (plane - o[k]) / d[k], q[3];
                int hit = t > 1e-4f && t < best && (d[k] > 0) == (b == 0 ? side == 1 : side == 0);
                for (j = 0; j < 3 && hit; j++) {
                    q[j] = j == k ? plane : o[j] + t * d[j];
                    hit = j == k || (q[j] >= boxes[b][0][j] && q[j] <= boxes[b][1][j]);
                }
                if (!hit) continue;
                best = t;
                for (j = 0; j < 3; j++) {
                    p[j] = q[j];
                    n[j] = j != k ? 0.0f : d[k] > 0 ? -1.0f : 1.0f;
                }
            }
}

/* The same in the shader. */
static const char fragment[] =
    "uniform float swing;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 o = vec3(0.0, 1.6, 2.9), d = vec3((gl_FragCoord.xy - vec2(240.0, 150.0)) / 300.0, -0.7);\n"
    "    vec3 to_room = ((step(0.0, d) * 2.0 - 1.0) * vec3(3.0, 1.5, 3.0) + vec3(0.0, 1.5, 0.0) - o) / d;\n"
    "    vec3 middle = vec3(swing, 1.15, -0.4), size = sign(d) * vec3(0.8, 0.15, 0.8);\n"
    "    vec3 enter = (middle - size - o) / d, leave = (middle + size - o) / d, hit = to_room;\n"
    "    float t = min(min(to_room.x, to_room.y), to_room.z), first = max(max(enter.x, enter.y), enter.z);\n"
    "    if (first > 0.0 && first < min(min(leave.x, leave.y), leave.z)) {\n"
    "        t = first;\n"
    "        hit = enter;\n"
    "    }\n"
    "    vec3 p = o + t * d, n = -sign(d) * vec3(equal(hit, vec3(t)));\n"
    "    vec4 light = ism_light(p, n, n, 0u, 1u);        // every VPL from the first on, in steps of 1\n"
    "    color = vec4(pow(0.08 * light.rgb, vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

/* ---- a frame's work on the CPU: lights and surfels, and their upload ---- */

static int prepare(glbk_context *gl, ism_maps *ism, glbk_ism_maps *maps, const ism_frame *frame)
{
    static ism_surfel surfels[VPLS * (SURFELS / LAZY)];
    const ism_near_point *near_points;
    const ism_vpl *chosen;
    ism_info info;
    size_t n, near_count;
    uint32_t phase;
    if (ism_choose(ism, frame) != ISM_OK || ism_scatter(ism, frame) != ISM_OK) return 0;
    for (phase = 0; phase < LAZY; phase++) {        /* all at first, then one a frame */
        if (frame->index && phase != frame->index % LAZY) continue;
        if (ism_phase_surfels(ism, phase, surfels, VPLS * (SURFELS / LAZY), &n) != ISM_OK) return 0;
        if (glbk_ism_surfels_upload(gl, maps, phase, surfels, n) != GLBK_OK) return 0;
    }
    chosen = ism_vpls(ism, &n);
    near_points = ism_near_points(ism, &near_count);
    ism_get_info(ism, &info);
    return glbk_ism_vpls_upload(gl, maps, chosen, (uint32_t)n, &info) == GLBK_OK &&
           glbk_ism_near_points_upload(gl, maps, near_points, (uint32_t)near_count) == GLBK_OK &&
           glbk_ism_mesh_move(gl, maps, corners, 0) == GLBK_OK && glbk_ism_draw(gl, maps, 0) == GLBK_OK;
}

/* What the sun sees (a reflective shadow map), what the eye sees in large pixels, to choose lights by, and the maps. */
static int light(glbk_context *gl, ism_maps *ism, glbk_ism_maps *maps, float time, uint32_t index)
{
    static float at[3 * RSM * RSM], normal[3 * RSM * RSM], flux[3 * RSM * RSM], area[RSM * RSM];
    static float seen[3 * SEEN_W * SEEN_H], seen_normal[3 * SEEN_W * SEEN_H];
    const float eye[3] = { 0, 1.6f, 2.9f }, sun[3] = { 0.1f, -1, -0.05f }, texel = 5.0f * 5.0f / (RSM * RSM);
    ism_mesh mesh = make_mesh(time);
    ism_source source = { ISM_SOURCE_SURFACE, RSM, RSM, 0, at, 0, normal, 0, flux, 0, area, 0, NULL, 0 };
    ism_points view = { 0 };
    ism_frame frame = { &mesh, &source, 1, &view, index };
    int i, k;
    for (i = 0; i < RSM * RSM; i++) {
        float from[3] = { 5 * ((float)(i % RSM) + 0.5f) / RSM - 2.5f, 2.99f,
                          5 * ((float)(i / RSM) + 0.5f) / RSM - 2.5f };
        trace(from, sun, at + 3 * i, normal + 3 * i);
        area[i] = texel;
        for (k = 0; k < 3; k++)             /* albedo x irradiance x area; the floor is red, the block grey */
            flux[3 * i + k] =
                (at[3 * i + 1] < 0.5f && k ? 0.2f : 0.7f) * 20 * texel * (normal[3 * i + 1] > 0.5f ? 1.0f : 0.0f);
    }
    for (i = 0; i < SEEN_W * SEEN_H; i++) {
        float d[3] = { ((float)(i % SEEN_W) + 0.5f - SEEN_W / 2) / SEEN_H,
                       (SEEN_H / 2 - (float)(i / SEEN_W) - 0.5f) / SEEN_H, -0.7f };
        trace(eye, d, seen + 3 * i, seen_normal + 3 * i);
    }
    view.count = SEEN_W * SEEN_H;
    view.positions = seen;
    view.normals = seen_normal;
    view.width = SEEN_W;
    return prepare(gl, ism, maps, &frame);
}

static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)glfwGetProcAddress(name);
}
static int fail(const char *what, const char *why) { return fprintf(stderr, "%s: %s\n", what, why), 1; }

/* The library says here why a call of it failed. */
static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

/* A picture is drawn to a target: what a window holds that is not shown is undefined. */
static glbk_result make_target(glbk_context *gl, glbk_texture *texture, glbk_target *target)
{
    const glbk_texture_desc desc = { GLBK_FORMAT_RGBA8, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    glbk_result result = glbk_texture_create(gl, &desc, texture);
    to.color[0] = texture;
    return result == GLBK_OK ? glbk_target_create(gl, &to, target) : result;
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "bounced light with shadows", NULL, NULL);
    if (!window) return NULL;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    return window;
}

int main(int count, char **values)
{
    glbk_texture texture = { 0 };
    glbk_target target = { 0 };
    const glbk_pass screen = {
        count > 1 ? &target : NULL, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    ism_desc sizes = { 0 };
    glbk_source source = { NULL, fragment, NULL, "ism_light", "ISM_NEAR=6 ISM_PROJECTION=1", NULL,
                           { glbk_ism_part() }, { { 0, 0 } } };
    ism_mesh mesh = { corners, 16, 0, triangles, 72, NULL, NULL, NULL, NULL, NULL };
    glbk_desc desc = { 0 };
    glbk_context gl;
    glbk_ism_maps maps;
    glbk_program program;
    ism_maps *ism;
    GLFWwindow *window = open_window(count < 2);
    uint32_t index;
    int32_t swing;

    if (!window) return fail("GLFW", "there is no display, or no OpenGL 3.3");
    sizes.vpl_count = VPLS;
    sizes.surfel_count = SURFELS;
    sizes.lazy_frames = LAZY;
    if (ism_create(&sizes, &ism) != ISM_OK) return fail("ism", "no memory");
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    make_mesh(0);
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_ism_maps_create(&gl, &sizes, &maps) != GLBK_OK ||
        glbk_ism_mesh_upload(&gl, &maps, &mesh) != GLBK_OK || glbk_program_compile(&gl, &source, &program) != GLBK_OK ||
        (count > 1 && make_target(&gl, &texture, &target) != GLBK_OK))
        return fail("OpenGL", "it does not work");
    swing = gl.gl.GetUniformLocation(program.name, "swing");
    for (index = 0; !glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS; index++) {
        float time = count > 1 ? 0 : (float)glfwGetTime();
        if (!light(&gl, ism, &maps, time, index)) return fail("light", "it does not work");
        gl.gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);      /* the window: the maps have bound others */
        if (glbk_begin(&gl, &screen, &program) != GLBK_OK || glbk_ism_bind(&gl, &maps, NULL, NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        gl.gl.Uniform1f(swing, sinf(time));
        glbk_draw_screen(&gl);
        if (count > 1) return save(&gl, &target, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_ism_maps_free(&gl, &maps);
    glbk_program_free(&gl, &program);
    glbk_target_free(&gl, &target);
    glbk_texture_free(&gl, &texture);
    glbk_free(&gl);
    ism_free(ism);
    glfwTerminate();
    return 0;
}
