/* 06_csm_gl_minimal.c - soft shadows in a shader of your own: csm.h builds the maps, gl_csm.h brings them to the
   GPU, and the fragment shader below calls csm_visible() of the library for each of its light samples.

   cc -O2 06_csm_gl_minimal.c -lglfw -lm -o csm_gl_minimal && ./csm_gl_minimal           Escape ends it
   ./csm_gl_minimal picture.ppm                  one picture, no visible window; without a display: xvfb-run -a */
#define CSM_IMPLEMENTATION
#include "csm.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_CSM_IMPLEMENTATION
#include "gl_backend/gl_csm.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 400, RINGS = 96, SIDES = 48 };

/* ---- the object: a torus as plain arrays ---- */

static float    positions[RINGS * SIDES * 3];
static uint32_t indices[RINGS * SIDES * 6];

static cohsm_mesh make_torus(void)
{
    cohsm_mesh mesh = { positions, RINGS * SIDES, 0, indices, RINGS * SIDES * 6, NULL, NULL, NULL };
    uint32_t i, j, k = 0;
    for (i = 0; i < RINGS; i++)
        for (j = 0; j < SIDES; j++) {
            float a = 6.2831853f * (float)i / RINGS, b = 6.2831853f * (float)j / SIDES;
            float *p = positions + 3 * (i * SIDES + j);
            uint32_t i2 = (i + 1) % RINGS, j2 = (j + 1) % SIDES;
            p[0] = (1 + 0.4f * cosf(b)) * cosf(a);
            p[1] = 0.4f * sinf(b);
            p[2] = (1 + 0.4f * cosf(b)) * sinf(a);
            indices[k++] = i * SIDES + j, indices[k++] = i * SIDES + j2, indices[k++] = i2 * SIDES + j2;
            indices[k++] = i * SIDES + j, indices[k++] = i2 * SIDES + j2, indices[k++] = i2 * SIDES + j;
        }
    return mesh;
}

/* ---- a renderer of our own: it marches along the ray of a pixel ---- */

static const char fragment[] =
    "uniform float turn;                                 // of the light, about y\n"
    "layout(location = 0) out vec4 color;\n"
    "float torus(vec3 p) { return length(vec2(length(p.xz) - 1.0, p.y)) - 0.4; }\n"
    "void main()\n"
    "{\n"
    "    vec3 ray = normalize(vec3((gl_FragCoord.x - 320.0) / 400.0, gl_FragCoord.y / 400.0 - 1.15, -1.2));\n"
    "    vec3 p = vec3(0.0, 2.9, 5.2), n = vec3(0.0, 1.0, 0.0);\n"
    "    float d = 1.0, light = 0.0;\n"
    "    for (int i = 0; i < 200 && d > 1e-3; i++) {\n"
    "        d = min(torus(p), p.y + 0.7);\n"
    "        p += d * ray;\n"
    "    }\n"
    "    color = vec4(0.55, 0.65, 0.75, 1.0);\n"
    "    if (d > 1e-3) return;\n"
    "    bool is_torus = torus(p) < p.y + 0.7;\n"
    "    vec2 ring = normalize(p.xz);\n"
    "    if (is_torus) n = normalize(p - vec3(ring.x, 0.0, ring.y));\n"
    "    cohsm_query ask = cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST, 1.0);\n"
    "    for (int i = 0; i < 64; i++) {                   // a disc in the sky\n"
    "        float r = 0.35 * sqrt((float(i) + 0.5) / 64.0), a = 2.39996323 * float(i) + turn;\n"
    "        vec3 l = normalize(vec3(0.8 * cos(turn) + r * cos(a), 0.9, 0.8 * sin(turn) + r * sin(a)));\n"
    "        float facing = max(dot(n, l), 0.0);\n"
    "        if (facing > 0.0)                            // instance 1 is the torus, 0 none\n"
    "            light += facing * csm_visible(is_torus ? 1u : 0u, ask, p + 0.01 * n, l);\n"
    "    }\n"
    "    vec3 albedo = is_torus ? vec3(0.9, 0.6, 0.4) : vec3(0.8);\n"
    "    color.rgb = pow(albedo * (0.08 + 0.9 * light / 64.0), vec3(1.0 / 2.2));\n"
    "}\n";

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

int main(int count, char **values)
{
    cohsm_mesh mesh = make_torus();
    cohsm_desc desc = { 0 };
    cohsm_maps *maps;
    glbk_csm_block block;
    glbk_csm_instance torus = { 0, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, 0 };
    glbk_csm_maps uploaded;
    glbk_desc gl_desc = { 0 };
    glbk_context gl;
    glbk_source source = { 0 };
    glbk_program program;
    glbk_pass pass = { 0 };                 /* to the window */
    glbk_texture texture = { 0 };
    glbk_target target = { 0 };
    GLFWwindow *window;
    int32_t turn;

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
    window = glfwCreateWindow(WIDTH, HEIGHT, "csm in a shader of your own", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);

    gl_desc.get_proc_fn = get_proc;
    gl_desc.system.log = say;
    if (glbk_init(&gl, &gl_desc) != GLBK_OK) return fail("OpenGL", "it does not work");
    desc.domain.side[0] = desc.domain.side[1] = 64;
    if (cohsm_build(&desc, &mesh, &maps, NULL) != COHSM_OK) return fail("csm", "the maps cannot be built");
    block.data = cohsm_data(maps, &block.bytes);
    source.fragment = fragment;
    source.parts[0] = glbk_csm_part();
    source.uses = "csm_visible";
    source.defines = uploaded.defines;      /* for these maps alone; the first call below writes it */
    if (glbk_csm_maps_create(&gl, &block, 1, 1, &torus.start, &uploaded) != GLBK_OK ||
        glbk_csm_maps_place(&gl, &uploaded, &torus, 1) != GLBK_OK ||
        glbk_program_compile(&gl, &source, &program) != GLBK_OK ||
        (count > 1 && make_target(&gl, &texture, &target) != GLBK_OK))
        return fail("OpenGL", "it does not work");
    cohsm_free(maps);

    turn = gl.gl.GetUniformLocation(program.name, "turn");
    if (count > 1) pass.target = &target;
    pass.viewport[2] = WIDTH;
    pass.viewport[3] = HEIGHT;
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (glbk_begin(&gl, &pass, &program) != GLBK_OK) return fail("OpenGL", "it does not work");
        glbk_csm_bind(&gl, &uploaded, NULL);
        gl.gl.Uniform1f(turn, count > 1 ? 0.6f : (float)glfwGetTime() * 0.5f);
        glbk_draw_screen(&gl);
        if (count > 1) return save(&gl, &target, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_csm_maps_free(&gl, &uploaded);
    glbk_program_free(&gl, &program);
    glbk_target_free(&gl, &target);
    glbk_texture_free(&gl, &texture);
    glbk_free(&gl);
    glfwTerminate();
    return 0;
}
