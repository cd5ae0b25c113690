/* 08_envshadow_gl_minimal.c - the shadows of a whole sky in a shader of your own: envlights.h turns the sky into 100
   lights, envshadow.h fits a map to each, gl_envshadow.h draws the maps, and the fragment shader below asks all of them
   by envsh_light().

   cc -O2 08_envshadow_gl_minimal.c -lglfw -lm -o envshadow_gl_minimal && ./envshadow_gl_minimal     Escape ends it
   ./envshadow_gl_minimal picture.ppm               one picture, no visible window; without a display: xvfb-run -a */
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_ENVSHADOW_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#include "gl_backend/gl_envshadow.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 400, RINGS = 96, SIDES = 48, CORNERS = RINGS * SIDES * 6, LIGHTS = 100, MAP = 128 };

/* ---- the object: a torus as a list of triangles; it may deform from frame to frame, this one only tumbles ---- */

static float positions[CORNERS * 3];

static envsh_mesh make_torus(void)
{
    static const int at[6][2] = { { 0, 0 }, { 0, 1 }, { 1, 1 }, { 0, 0 }, { 1, 1 }, { 1, 0 } };
    envsh_mesh mesh = { positions, CORNERS, 0, NULL, 0, NULL, NULL, NULL };
    float *p = positions;
    int i, j, k;
    for (i = 0; i < RINGS; i++)
        for (j = 0; j < SIDES; j++)
            for (k = 0; k < 6; k++, p += 3) {
                float a = 6.2831853f * (float)(i + at[k][0]) / RINGS, b = 6.2831853f * (float)(j + at[k][1]) / SIDES;
                p[0] = (1 + 0.4f * cosf(b)) * cosf(a);
                p[1] = 0.4f * sinf(b);
                p[2] = (1 + 0.4f * cosf(b)) * sinf(a);
            }
    return mesh;
}

/* ---- the sky: blue, with a low sun ---- */

static envlt_lights *make_lights(void)
{
    static float sky[3 * 128 * 64];
    envlt_map map = { ENVLT_PROJECTION_LATLONG, 128, 64, sky, 0 };
    envlt_desc desc = { 0 };
    envlt_lights *lights = NULL;
    for (uint32_t i = 0; i < 128 * 64; i++) {
        float d[3], *rgb = sky + 3 * i, glow;
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 128, 64, 0,
                              (float)(i % 128) + 0.5f, (float)(i / 128) + 0.5f, d);
        glow = 0.55f * d[0] + 0.62f * d[1] + 0.56f * d[2] > 0.995f ? 60.0f : 0.0f;
        rgb[0] = d[1] < 0 ? 0.1f : 0.3f + glow;
        rgb[1] = d[1] < 0 ? 0.1f : 0.4f + 0.9f * glow;
        rgb[2] = d[1] < 0 ? 0.1f : 0.6f + 0.7f * glow;
    }
    desc.light_count = LIGHTS;
    envlt_create(&desc, &map, &lights, NULL);
    return lights;
}

/* ---- a renderer of our own: it marches along the ray of a pixel ---- */

static const char fragment[] =
    "uniform float turn;                                 // of the torus, about x\n"
    "layout(location = 0) out vec4 color;\n"
    "vec3 about_x(vec3 p, float a) { return vec3(p.x, cos(a) * p.y - sin(a) * p.z, cos(a) * p.z + sin(a) * p.y); }\n"
    "float torus(vec3 q) { return length(vec2(length(q.xz) - 1.0, q.y)) - 0.4; }\n"
    "void main()\n"
    "{\n"
    "    vec3 ray = normalize(vec3((gl_FragCoord.x - 320.0) / 400.0, gl_FragCoord.y / 400.0 - 1.15, -1.2));\n"
    "    vec3 p = vec3(0.0, 2.9, 5.2), n = vec3(0.0, 1.0, 0.0);\n"
    "    float d = 1.0;\n"
    "    for (int i = 0; i < 200 && d > 1e-3; i++) {\n"
    "        d = min(torus(about_x(p, -turn)), p.y + 1.5);\n"
    "        p += d * ray;\n"
    "    }\n"
    "    color = vec4(0.55, 0.65, 0.75, 1.0);\n"
    "    if (d > 1e-3) return;\n"
    "    vec3 q = about_x(p, -turn);\n"
    "    bool is_torus = torus(q) < p.y + 1.5;\n"
    "    vec2 ring = normalize(q.xz);\n"
    "    if (is_torus) n = about_x(normalize(q - vec3(ring.x, 0.0, ring.y)), turn);\n"
    "    vec3 light = envsh_light(p, n, n, uint(gl_FragCoord.x) + 640u * uint(gl_FragCoord.y));\n"
    "    color.rgb = pow((is_torus ? vec3(0.9, 0.6, 0.4) : vec3(0.8)) * light / 3.14159, vec3(1.0 / 2.2));\n"
    "}\n";

static uint32_t vertex_array;
static int32_t  turn;                           /* location of that uniform */
static float    transform[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* Everything that throws shadows, each object by one call for many lights. */
static glbk_result draw(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    (void)user;
    glbk_envsh_cast(gl, maps, transform);
    gl->gl.BindVertexArray(vertex_array);
    gl->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, CORNERS, (int32_t)instances);
    return GLBK_OK;
}

static glbk_result frame(glbk_context *gl, envsh_maps *layout, glbk_envsh_maps *maps, glbk_program *program,
                         const envsh_mesh *mesh, const envlt_lights *lights, float angle, const glbk_target *target)
{
    const envsh_query query = { ENVSH_FILTER_PENUMBRA, 0, 0, 0, 0, 0, 0 };
    const glbk_pass screen = {
        target, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    const envsh_view *views;
    uint32_t count;
    const envlt_light *list = envlt_get_lights(lights, &count);
    envsh_lights all = { count, list->direction, list->irradiance, list->axis_u, list->axis_v, sizeof *list };
    glbk_result result;
    transform[5] = transform[10] = cosf(angle);
    transform[6] = sinf(angle);
    transform[9] = -transform[6];
    envsh_maps_begin(layout, &all, envsh_bounds_of(mesh, 1, transform));
    views = envsh_views(layout, &count);
    result = glbk_envsh_maps_render(gl, maps, views, count, draw, NULL);
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);         /* the window: the maps have bound others */
    if (result == GLBK_OK) result = glbk_begin(gl, &screen, program);
    if (result == GLBK_OK) result = glbk_envsh_bind(gl, maps, &query, NULL);
    if (result != GLBK_OK) return result;
    gl->gl.Uniform1f(turn, angle);
    glbk_draw_screen(gl);
    return GLBK_OK;
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

int main(int count, char **values)
{
    envsh_mesh mesh = make_torus();
    envlt_lights *lights = make_lights();
    envsh_maps_desc layout_desc = { 0 };
    const glbk_envsh_maps_desc maps_desc = { LIGHTS, &layout_desc, { 0, 0, 0, 0, NULL, NULL } };
    envsh_maps *layout;
    glbk_envsh_maps maps;
    glbk_desc desc = { 0 };
    glbk_context gl;
    glbk_source source = { NULL, fragment, NULL, "envsh_light", "ENVSH_FILTER=4 ENVSH_RGBA=0", NULL,
                           { glbk_envsh_part() }, { { 0, 0 } } };
    glbk_program program;
    glbk_buffer buffer;
    glbk_texture texture = { 0 };
    glbk_target target = { 0 };
    GLFWwindow *window;

    layout_desc.map_side = MAP;
    layout_desc.no_depth = 1;           /* the GPU has it */
    if (!lights || envsh_maps_create(&layout_desc, LIGHTS, &layout) != ENVSH_OK) return fail("envshadow", "no lights");
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "shadows of a sky", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_envsh_maps_create(&gl, &maps_desc, &maps) != GLBK_OK ||
        glbk_program_compile(&gl, &source, &program) != GLBK_OK ||
        glbk_buffer_create(&gl, sizeof positions, positions, &buffer) != GLBK_OK ||
        (count > 1 && make_target(&gl, &texture, &target) != GLBK_OK))
        return fail("OpenGL", "it does not work");
    turn = gl.gl.GetUniformLocation(program.name, "turn");
    gl.gl.GenVertexArrays(1, &vertex_array);
    gl.gl.BindVertexArray(vertex_array);
    gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, buffer.name);
    gl.gl.EnableVertexAttribArray(0);
    gl.gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);

    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (frame(&gl, layout, &maps, &program, &mesh, lights, count > 1 ? 0.9f : (float)glfwGetTime(),
                  count > 1 ? &target : NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        if (count > 1) return save(&gl, &target, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_buffer_free(&gl, &buffer);
    glbk_program_free(&gl, &program);
    glbk_target_free(&gl, &target);
    glbk_texture_free(&gl, &texture);
    glbk_envsh_maps_free(&gl, &maps);
    glbk_free(&gl);
    envsh_maps_free(layout);
    envlt_free(lights);
    glfwTerminate();
    return 0;
}
