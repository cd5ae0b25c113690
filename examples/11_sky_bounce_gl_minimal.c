/* 11_sky_bounce_gl_minimal.c - two techniques in one forward shader of your own: a sky with a sun shines into a yard by
   100 shadow maps (gl_envshadow.h), and what the sun lights shines on by a reflective shadow map (gl_rsm.h). An offset
   keeps the textures and uniform blocks of the two apart.

   cc -O2 11_sky_bounce_gl_minimal.c -lglfw -lm -o sky_bounce_gl_minimal && ./sky_bounce_gl_minimal     Escape ends it
   ./sky_bounce_gl_minimal picture.ppm              one picture, no visible window; without a display: xvfb-run -a */
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_ENVSHADOW_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#include "gl_backend/gl_envshadow.h"
#define GL_RSM_IMPLEMENTATION
#include "gl_backend/gl_rsm.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 400, QUADS = 8, CORNERS = 6 * QUADS, LIGHTS = 100, MAP = 128, BOUNCES = 256 };

static const float sun[3] = { 0.7f, 0.6f, 0.387f };         /* the way to it */

/* ---- the yard: parallelograms as corner, edge, edge, and their colours; the last five are a block that turns ---- */

static const float quads[QUADS][12] = {
    { -2, 0, -2, 4, 0, 0, 0, 0, 4, 0.75f, 0.75f, 0.75f },           /* ground */
    { -2, 0, -2, 4, 0, 0, 0, 1.7f, 0, 0.75f, 0.75f, 0.75f },        /* back */
    { -2, 0, -2, 0, 0, 4, 0, 1.7f, 0, 0.8f, 0.12f, 0.06f },         /* left */
    { -0.4f, 0, -0.4f, 0.8f, 0, 0, 0, 1, 0, 0.9f, 0.9f, 0.9f },
    { -0.4f, 0, 0.4f, 0.8f, 0, 0, 0, 1, 0, 0.9f, 0.9f, 0.9f },
    { -0.4f, 0, -0.4f, 0, 0, 0.8f, 0, 1, 0, 0.9f, 0.9f, 0.9f },
    { 0.4f, 0, -0.4f, 0, 0, 0.8f, 0, 1, 0, 0.9f, 0.9f, 0.9f },
    { -0.4f, 1, -0.4f, 0.8f, 0, 0, 0, 0, 0.8f, 0.9f, 0.9f, 0.9f }
};
static float positions[CORNERS][3], normals[QUADS][4];

static void turn_block(float angle)
{
    static const float at[6][2] = { { 0, 0 }, { 1, 0 }, { 0, 1 }, { 0, 1 }, { 1, 0 }, { 1, 1 } };
    for (int q = 0; q < QUADS; q++) {
        const float *e = quads[q] + 3, *f = quads[q] + 6, c = q < 3 ? 1 : cosf(angle), s = q < 3 ? 0 : sinf(angle);
        float n[3] = { e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0] };
        float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        normals[q][0] = (c * n[0] + s * n[2]) / length;
        normals[q][1] = n[1] / length;
        normals[q][2] = (c * n[2] - s * n[0]) / length;
        for (int k = 0; k < 6; k++) {
            float p[3], *out = positions[6 * q + k];
            for (int i = 0; i < 3; i++) p[i] = quads[q][i] + at[k][0] * e[i] + at[k][1] * f[i];
            out[0] = c * p[0] + s * p[2] - (q < 3 ? 0 : 0.8f);
            out[1] = p[1];
            out[2] = c * p[2] - s * p[0];
        }
    }
}

/* ---- the sky: blue, with a sun, whose irradiance comes back for the reflective shadow map ---- */

static envlt_lights *make_lights(float sun_value[3])
{
    static float sky[3 * 128 * 64];
    static const float blue[3] = { 0.12f, 0.16f, 0.25f }, glow[3] = { 110, 100, 80 };
    envlt_map map = { ENVLT_PROJECTION_LATLONG, 128, 64, sky, 0 };
    envlt_desc desc = { 0 };
    envlt_lights *lights = NULL;
    for (uint32_t i = 0; i < 128 * 64; i++) {
        float d[3], texel;
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, 128, 64, 0,
                              (float)(i % 128) + 0.5f, (float)(i / 128) + 0.5f, d);
        texel = sun[0] * d[0] + sun[1] * d[1] + sun[2] * d[2] > 0.995f ? 0.0024096f * sqrtf(1 - d[1] * d[1]) : 0;
        for (int c = 0; c < 3; c++) {
            sky[3 * i + (uint32_t)c] = (d[1] < 0 ? 0.04f : blue[c]) + (texel > 0 ? glow[c] : 0);
            sun_value[c] += texel * glow[c];
        }
    }
    desc.light_count = LIGHTS;
    envlt_create(&desc, &map, &lights, NULL);
    return lights;
}

/* ---- the shader: functions of two parts ---- */

static const char vertex[] =
    "layout(location = 0) in vec3 corner;\n"
    "uniform mat4 to_clip;\n"
    "out vec3 place;\n"
    "void main() { place = corner; gl_Position = to_clip * vec4(corner, 1.0); }\n";

static const char fragment[] =
    "in vec3 place;\n"
    "uniform vec4 eye, normal, albedo;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = dot(normal.xyz, eye.xyz - place) < 0.0 ? -normal.xyz : normal.xyz;\n"
    "    uint pixel = uint(gl_FragCoord.x) + 640u * uint(gl_FragCoord.y);\n"
    "    vec3 light = envsh_light(place, n, n, pixel);\n"
    "    light += rsm_gather_list(rsm_bound(), place, n, 0u, 256u, false, 0.0) / RSM_PI;\n"
    "    color = vec4(pow(albedo.rgb * light / 3.14159, vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

static const glbk_offset rsm_at = { GLBK_UNITS, GLBK_BLOCKS };      /* behind all of envshadow's */

/* ---- a frame ---- */

typedef struct app {
    glbk_context gl;
    glbk_program program;
    glbk_buffer  corners;
    uint32_t     vertex_array;
    int32_t      to_clip, eye, normal, albedo;      /* locations of uniforms */
    envlt_lights *lights;
    envsh_maps   *layout;
    glbk_envsh_maps   maps;
    glbk_rsm_renderer rsm;                          /* of 1 x 1 pixels: only its list of lights is wanted */
    glbk_rsm_map      sun_map;
    glbk_texture color, depth;
    glbk_target  target;                            /* of a picture; none for the window */
} app;

/* Everything that throws shadows, by one call for many lights. */
static glbk_result draw_casters(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    glbk_envsh_cast(gl, maps, unit);
    gl->gl.BindVertexArray(((app *)user)->vertex_array);
    gl->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, CORNERS, (int32_t)instances);
    return GLBK_OK;
}

/* Everything that the sun lights and that reflects. */
static void draw_reflectors(void *user, glbk_context *gl, glbk_rsm_renderer *r)
{
    gl->gl.BindVertexArray(((app *)user)->vertex_array);
    for (int q = 0; q < QUADS; q++) {
        glbk_surface s = { 0 };
        for (int c = 0; c < 3; c++) s.material.diffuse[c] = quads[q][9 + c];
        glbk_rsm_object(gl, r, &s, 0);
        gl->gl.DrawArrays(GLBK_GL_TRIANGLES, 6 * q, 6);
    }
}

/* The maps of the sky, then that of the sun and its list of lights. */
static glbk_result make_light(app *a)
{
    const envsh_mesh mesh = { positions[0], CORNERS, 0, NULL, 0, NULL, NULL, NULL };
    const envsh_view *views;
    uint32_t count;
    const envlt_light *list = envlt_get_lights(a->lights, &count);
    envsh_lights all = { count, list->direction, list->irradiance, list->axis_u, list->axis_v, sizeof *list };
    rsm_gather_desc by_flux = { 0 };
    glbk_rsm_map *map = &a->sun_map;
    glbk_result result;
    by_flux.sample_count = BOUNCES;
    by_flux.near_limit = 0.25f;
    envsh_maps_begin(a->layout, &all, envsh_bounds_of(&mesh, 1, NULL));
    views = envsh_views(a->layout, &count);
    result = glbk_envsh_maps_render(&a->gl, &a->maps, views, count, draw_casters, a);
    if (result == GLBK_OK) result = glbk_rsm_map_draw(&a->gl, &a->rsm, map, draw_reflectors, a);
    return result == GLBK_OK ? glbk_rsm_gather(&a->gl, &a->rsm, NULL, &map, 1, &by_flux) : result;
}

static const float eye[4] = { 0.2f, 2.3f, 5.6f, 1 }, seen[3] = { -0.35f, 0.6f, -0.4f };

/* world to clip, of a camera at eye that looks at seen */
static void look(float m[16])
{
    float f[3], r[3], u[3];
    float length = 0, wide = 2.2f, near_plane = 0.5f, far_plane = 50;
    int i;
    for (i = 0; i < 3; i++) f[i] = seen[i] - eye[i], length += f[i] * f[i];
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
    for (i = 0; i < 4; i++) m[12 + i] = -(m[i] * eye[0] + m[4 + i] * eye[1] + m[8 + i] * eye[2]);
    m[14] -= 2 * far_plane * near_plane / (far_plane - near_plane);
}

static glbk_result frame(app *a, float angle)
{
    static const float sky[4] = { 0.38f, 0.43f, 0.53f, 1 };
    const envsh_query query = { ENVSH_FILTER_PENUMBRA, 0, 0, 0, 0, 0, 0 };
    const glbk_functions *gl = &a->gl.gl;
    glbk_pass pass = { 0 };
    glbk_result result;
    float m[16];
    turn_block(angle);
    result = glbk_buffer_update(&a->gl, &a->corners, 0, sizeof positions, positions);
    if (result == GLBK_OK) result = make_light(a);
    if (result != GLBK_OK) return result;
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);        /* the window: the maps have bound others */
    pass.target = a->target.name ? &a->target : NULL;
    pass.viewport[2] = WIDTH;
    pass.viewport[3] = HEIGHT;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(&a->gl, &pass, &a->program);
    if (result == GLBK_OK) result = glbk_envsh_bind(&a->gl, &a->maps, &query, NULL);
    if (result != GLBK_OK) return result;
    glbk_rsm_bind(&a->gl, &a->rsm, &a->sun_map, &rsm_at);
    gl->ClearBufferfv(GLBK_GL_COLOR, 0, sky);
    glbk_clear_depth(&a->gl, 1);
    look(m);
    gl->UniformMatrix4fv(a->to_clip, 1, 0, m);
    gl->Uniform4fv(a->eye, 1, eye);
    gl->BindVertexArray(a->vertex_array);
    for (int q = 0; q < QUADS; q++) {
        const float albedo[4] = { quads[q][9], quads[q][10], quads[q][11], 1 };
        gl->Uniform4fv(a->normal, 1, normals[q]);
        gl->Uniform4fv(a->albedo, 1, albedo);
        gl->DrawArrays(GLBK_GL_TRIANGLES, 6 * q, 6);
    }
    return GLBK_OK;
}

/* ---- once ---- */

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
static glbk_result make_target(app *a)
{
    glbk_texture_desc desc = { GLBK_FORMAT_RGBA8, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    glbk_result result = glbk_texture_create(&a->gl, &desc, &a->color);
    desc.format = GLBK_FORMAT_DEPTH24;
    if (result == GLBK_OK) result = glbk_texture_create(&a->gl, &desc, &a->depth);
    to.color[0] = &a->color;
    to.depth = &a->depth;
    return result == GLBK_OK ? glbk_target_create(&a->gl, &to, &a->target) : result;
}

static glbk_result make_program(app *a)
{
    const glbk_functions *gl = &a->gl.gl;
    glbk_source source = { 0 };
    glbk_result result;
    source.vertex = vertex;
    source.fragment = fragment;
    source.uses = "envsh_light rsm_gather";
    source.defines = "ENVSH_FILTER=4 ENVSH_RGBA=0";
    source.parts[0] = glbk_envsh_part();
    source.parts[1] = glbk_rsm_part();
    source.offsets[1] = rsm_at;             /* without it: GLBK_ERR_MISMATCH, and say() is told which textures meet */
    result = glbk_program_compile(&a->gl, &source, &a->program);
    a->to_clip = gl->GetUniformLocation(a->program.name, "to_clip");
    a->eye = gl->GetUniformLocation(a->program.name, "eye");
    a->normal = gl->GetUniformLocation(a->program.name, "normal");
    a->albedo = gl->GetUniformLocation(a->program.name, "albedo");
    return result;
}

static int make_all(app *a, int picture)
{
    rsm_light lamp = { RSM_LIGHT_SUN, { 0, 0.8f, 0 }, { sun[0], sun[1], sun[2] }, { 0 }, { 0 }, 3.2f, 0, 0, 0 };
    glbk_rsm_renderer_desc size = { 1, 1, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    envsh_maps_desc layout_desc = { 0 };
    const glbk_envsh_maps_desc maps_desc = { LIGHTS, &layout_desc, { 0, 0, 0, 0, NULL, NULL } };
    glbk_desc desc = { 0 };
    a->lights = make_lights(lamp.value);
    layout_desc.map_side = MAP;
    layout_desc.no_depth = 1;               /* the GPU has it */
    if (!a->lights || envsh_maps_create(&layout_desc, LIGHTS, &a->layout) != ENVSH_OK)
        return fail("envshadow", "no lights");
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&a->gl, &desc) != GLBK_OK || glbk_envsh_maps_create(&a->gl, &maps_desc, &a->maps) != GLBK_OK ||
        glbk_rsm_renderer_create(&a->gl, &size, &a->rsm) != GLBK_OK ||
        glbk_rsm_map_create(&a->gl, &lamp, 256, &a->sun_map) != GLBK_OK || make_program(a) != GLBK_OK ||
        glbk_buffer_create(&a->gl, sizeof positions, NULL, &a->corners) != GLBK_OK ||
        (picture && make_target(a) != GLBK_OK))
        return fail("OpenGL", "it does not work");
    a->gl.gl.GenVertexArrays(1, &a->vertex_array);
    a->gl.gl.BindVertexArray(a->vertex_array);
    a->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, a->corners.name);
    a->gl.gl.EnableVertexAttribArray(0);
    a->gl.gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    return 0;
}

static void free_all(app *a)
{
    glbk_target_free(&a->gl, &a->target);
    glbk_texture_free(&a->gl, &a->depth);
    glbk_texture_free(&a->gl, &a->color);
    glbk_buffer_free(&a->gl, &a->corners);
    glbk_program_free(&a->gl, &a->program);
    glbk_rsm_map_free(&a->gl, &a->sun_map);
    glbk_rsm_renderer_free(&a->gl, &a->rsm);
    glbk_envsh_maps_free(&a->gl, &a->maps);
    glbk_free(&a->gl);
    envsh_maps_free(a->layout);
    envlt_free(a->lights);
}

static int save(app *a, const char *path)
{
    static float rgba[HEIGHT][WIDTH][4];
    FILE *file;
    int x, y, c;
    if (glbk_target_read(&a->gl, &a->target, 0, 0, 0, WIDTH, HEIGHT, rgba) != GLBK_OK)
        return fail("OpenGL", "no picture");
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
    static app a;
    GLFWwindow *window;
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "a sky and what it is reflected by", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    if (make_all(&a, count > 1) != 0) return 1;
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (frame(&a, count > 1 ? 0.5f : (float)glfwGetTime()) != GLBK_OK) return fail("OpenGL", "it does not work");
        if (count > 1) return save(&a, values[1]) || glbk_check(&a.gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    free_all(&a);
    glfwTerminate();
    return 0;
}
