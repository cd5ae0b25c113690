/* 10b_rsm_ism_gl_minimal.c - two bounces with their shadows, by complete passes: a spot shines on the wall of a room in
   which a plate swings. Per frame the spot's reflective shadow map is drawn, virtual point lights are chosen from it,
   surfels are scattered over the triangles, an eighth of them a frame, shadow maps are drawn from these and the
   G-buffer is lit, all on the GPU: nothing is read back. The lights of the second bounce are chosen from what these
   maps show. gl_rsm.h adds the spot itself.

   cc -O2 10b_rsm_ism_gl_minimal.c -lglfw -lm -o rsm_ism_gl_minimal && ./rsm_ism_gl_minimal        Escape ends it
   ./rsm_ism_gl_minimal picture.ppm                                            one picture, no visible window
   ./rsm_ism_gl_minimal picture.ppm exact          the same with exact shadows of the plate, to compare the maps with */
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_RSM_IMPLEMENTATION
#define GL_ISM_IMPLEMENTATION
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 480, QUADS = 6, SIDE = 64, VPLS = 256, SURFELS = 2048, LAZY = 8, BOUNCES = 2, CELLS = 8 };

/* ---- the room: parallelograms as corner, edge, edge, and their colours; the last one swings ---- */

static float quads[QUADS][12] = {
    { -1, 0, -1, 2, 0, 0, 0, 0, 2, 0.8f, 0.8f, 0.8f },          /* floor */
    { -1, 2, -1, 2, 0, 0, 0, 0, 2, 0.8f, 0.8f, 0.8f },          /* ceiling */
    { -1, 0, -1, 2, 0, 0, 0, 2, 0, 0.8f, 0.8f, 0.8f },          /* back */
    { -1, 0, -1, 0, 0, 2, 0, 2, 0, 0.75f, 0.1f, 0.05f },        /* left */
    { 1, 0, -1, 0, 0, 2, 0, 2, 0, 0.1f, 0.6f, 0.1f },           /* right */
    { -0.4f, 0.6f, -0.3f, 0.7f, 0, 0, 0, 0, 0.7f, 0.9f, 0.8f, 0.4f }
};

static float    corners[QUADS][4][3];
static uint32_t triangles[QUADS][6];
static float    albedos[QUADS][2][3];        /* of triangles, for the second bounce */

static void place_room(float time)
{
    int q, k, c;
    quads[QUADS - 1][1] = 0.6f + 0.3f * sinf(time);
    for (q = 0; q < QUADS; q++) {
        const float *at = quads[q], *u = at + 3, *v = at + 6;
        for (k = 0; k < 4; k++)
            for (c = 0; c < 3; c++) corners[q][k][c] = at[c] + (k & 1 ? u[c] : 0) + (k & 2 ? v[c] : 0);
        for (k = 0; k < 2; k++) memcpy(albedos[q][k], at + 9, sizeof albedos[q][k]);
        for (k = 0; k < 6; k++) triangles[q][k] = (uint32_t)(4 * q + (k < 3 ? k : 6 - k));
    }
}

typedef struct app {
    glbk_context      gl;
    glbk_gbuffer      seen;
    glbk_rsm_renderer rsm;              /* of direct light */
    glbk_rsm_map      map;
    glbk_ism_renderer ism;              /* of bounced light */
    glbk_ism_maps     maps[BOUNCES];
    glbk_ism_choice   choice[BOUNCES];  /* of their VPLs */
    glbk_ism_spread   spread[BOUNCES];  /* of their surfels */
    glbk_ism_bounces  bounced;          /* what the VPLs of the first bounce shine on */
    glbk_buffer       vertices;
    uint32_t          vertex_array;
    glbk_texture      light_texture, picture_texture;
    glbk_target       light, picture;
    glbk_program      tone;
    uint32_t          index;            /* of the frame */
} app;

/* The spot sees the room through a renderer, we see it in a G-buffer, without. */
static void draw_room(void *user, glbk_context *gl, glbk_rsm_renderer *r)
{
    app *a = (app *)user;
    int q;
    gl->gl.BindVertexArray(a->vertex_array);
    for (q = 0; q < QUADS; q++) {
        glbk_surface s = { 0 };
        memcpy(s.material.diffuse, quads[q] + 9, sizeof s.material.diffuse);
        if (r) glbk_rsm_object(gl, r, &s, 0);
        else glbk_gbuffer_object(gl, &a->seen, &s);
        gl->gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 4 * q, 4);
    }
}

/* ---- from the spot's map to VPLs with their maps ---- */

/* VPLs lie where the spot's map has flux, those of the second bounce on what the maps of the first show; surfels lie
   where the camera or a VPL sees something. */
static int draw_maps(app *a)
{
    glbk_context *gl = &a->gl;
    int k;
    if (glbk_rsm_map_draw(gl, &a->rsm, &a->map, draw_room, a) != GLBK_OK) return 0;
    for (k = 0; k < BOUNCES; k++) {
        const glbk_texture *from = k ? &a->bounced.texels : &a->map.texels;
        if (k && glbk_ism_bounce(gl, &a->bounced, &a->maps[0]) != GLBK_OK) return 0;
        if (glbk_ism_choose(gl, &a->choice[k], &a->maps[k], from, &a->seen, a->index) != GLBK_OK ||
            glbk_ism_scatter(gl, &a->spread[k], &a->maps[k], &a->seen, a->index) != GLBK_OK ||
            glbk_ism_draw(gl, &a->maps[k], 0) != GLBK_OK)
            return 0;
    }
    return 1;
}

/* ---- a frame ---- */

static int frame(app *a, float time)
{
    static const float eye[3] = { 0, 1, 4.4f },
                       view[16] = { 2, 0, 0, 0, 0, 2.667f, 0, 0, 0, 0, -1.02f, -1, 0, -2.667f, 4.286f, 4.4f };
    const ism_mesh mesh = { corners[0][0], 4 * QUADS, 0, triangles[0], 6 * QUADS, NULL, NULL, albedos[0][0], NULL,
                            NULL };
    const glbk_rsm_map *lit = &a->map;
    ism_shading shading = { 0 };
    glbk_pass pass = { 0 };
    glbk_context *gl = &a->gl;
    int k;
    place_room(time);
    if (glbk_buffer_update(gl, &a->vertices, 0, sizeof corners, corners) != GLBK_OK ||
        glbk_gbuffer_begin(gl, &a->seen, view, eye) != GLBK_OK)
        return 0;
    draw_room(a, gl, NULL);
    for (k = 0; k < BOUNCES; k++)
        if ((a->index ? glbk_ism_mesh_move(gl, &a->maps[k], corners[0][0], 0)
                      : glbk_ism_mesh_upload(gl, &a->maps[k], &mesh)) != GLBK_OK)
            return 0;
    if (!draw_maps(a)) return 0;
    shading.interleave = 4;                            /* 4 x 4 pixels share the VPLs; a blur mends that */
    pass.target = &a->light;
    if (glbk_rsm_direct(gl, &a->rsm, &a->seen, &lit, 1, NULL) != GLBK_OK ||
        glbk_rsm_resolve(gl, &a->rsm, &a->seen, &pass, NULL, 1, 0) != GLBK_OK)
        return 0;
    pass.blend = GLBK_BLEND_ADD;                    /* bounced light over direct light */
    for (k = 0; k < BOUNCES; k++)
        if (glbk_ism_shade(gl, &a->ism, &a->seen, &a->maps[k], &shading, 0) != GLBK_OK ||
            glbk_ism_resolve(gl, &a->ism, &a->seen, &pass, NULL) != GLBK_OK)
            return 0;
    a->index++;
    return 1;
}

/* How much of a VPL a pixel sees, by a ray: the plate alone stands between two places of this room. */
static const char by_rays[] =
    "uniform vec4 plate[3];                              // a corner and two edges\n"
    "float glbk_visible(uint vpl, vec3 position, vec3 geometric_normal)\n"
    "{\n"
    "    vec3 ray = ism_read_vpl(vpl).position - position, across = cross(plate[1].xyz, plate[2].xyz);\n"
    "    float t = dot(plate[0].xyz - position, across) / dot(ray, across);\n"
    "    vec3 at = position + t * ray - plate[0].xyz;\n"
    "    vec2 c = vec2(dot(at, plate[1].xyz), dot(at, plate[2].xyz)) / vec2(dot(plate[1], plate[1]), dot(plate[2], plate[2]));\n"
    "    bool meets = t > 1e-3 && t < 0.999 && all(greaterThan(c, vec2(0.0))) && all(lessThan(c, vec2(1.0)));\n"
    "    return meets ? 0.0 : 1.0;\n"
    "}\n";

static void set_plate(void *user, glbk_context *gl)
{
    float plate[3][4] = { { 0 } };
    int k;
    (void)user;
    for (k = 0; k < 9; k++) plate[k / 3][k % 3] = quads[QUADS - 1][k];
    gl->gl.Uniform4fv(gl->gl.GetUniformLocation(gl->program, "plate"), 3, plate[0]);
}

/* From radiance to what a window shows. */
static const char tone[] =
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 light = glbk_unpack(texelFetch(glbk_source, ivec2(gl_FragCoord.xy), 0)).rgb;\n"
    "    color = vec4(pow(1.5 * light, vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

/* target: of a picture, since what a window holds that is not shown is undefined; NULL = the window */
static int show(app *a, const glbk_target *target)
{
    glbk_pass screen = { 0 };
    screen.target = target;
    screen.viewport[2] = WIDTH;
    screen.viewport[3] = HEIGHT;
    a->gl.gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);         /* the window: passes have bound others */
    if (glbk_begin(&a->gl, &screen, &a->tone) != GLBK_OK) return 0;
    glbk_bind_texture(&a->gl, GLBK_SLOT_glbk_source, &a->light_texture);
    glbk_draw_screen(&a->gl);
    return 1;
}

static int fail(const char *what, const char *why) { return fprintf(stderr, "%s: %s\n", what, why), 1; }

static int save(app *a, const char *path)
{
    static float rgba[HEIGHT][WIDTH][4];
    FILE *file;
    int x, y, c;
    if (glbk_target_read(&a->gl, &a->picture, 0, 0, 0, WIDTH, HEIGHT, rgba) != GLBK_OK)
        return fail("OpenGL", "no picture");
    file = fopen(path, "wb");
    if (!file) return fail(path, "cannot be written");
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = HEIGHT - 1; y >= 0; y--)
        for (x = 0; x < WIDTH; x++)
            for (c = 0; c < 3; c++) putc((int)(rgba[y][x][c] * 255 + 0.5f), file);
    return fclose(file) != 0;
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

static int make_canvas(app *a, glbk_format format, glbk_texture *texture, glbk_target *target)
{
    const glbk_texture_desc desc = { format, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    to.color[0] = texture;
    return glbk_texture_create(&a->gl, &desc, texture) == GLBK_OK &&
           glbk_target_create(&a->gl, &to, target) == GLBK_OK;
}

/* Where the vertex array has what it has: the position alone; normals are those of the triangles. */
static const glbk_attributes where = { 3, -1, -1, -1, NULL, NULL };

static int make_light(app *a)
{
    const rsm_light spot = { RSM_LIGHT_SPOT, { 0.2f, 1.9f, 0.8f }, { -1, -0.5f, -0.5f }, { 0, 1, 0 }, { 25, 25, 25 }, 0,
                             0.35f, 0.05f, 10 };
    glbk_rsm_renderer_desc size = { 0 };
    const glbk_ism_renderer_desc ism_size = { WIDTH, HEIGHT };
    const glbk_ism_choice_desc from[BOUNCES] = { { SIDE, SIDE, 1, 0 }, { CELLS * CELLS, VPLS, 1, 1 } };
    ism_desc sizes = { 0 };
    int k;
    sizes.vpl_count = VPLS;
    sizes.surfel_count = SURFELS;
    sizes.lazy_frames = LAZY;
    size.width = WIDTH;
    size.height = HEIGHT;
    size.attributes = where;
    for (k = 0; k < BOUNCES; k++) {
        sizes.keep_hits = k + 1 < BOUNCES;          /* there is a next bounce */
        if (glbk_ism_maps_create(&a->gl, &sizes, &a->maps[k]) != GLBK_OK ||
            glbk_ism_spread_create(&a->gl, &a->maps[k], &a->spread[k]) != GLBK_OK ||
            glbk_ism_choice_create(&a->gl, &a->maps[k], &from[k], &a->choice[k]) != GLBK_OK)
            return 0;
    }
    return glbk_ism_bounces_create(&a->gl, &a->maps[0], CELLS, &a->bounced) == GLBK_OK &&
           glbk_ism_renderer_create(&a->gl, &ism_size, &a->ism) == GLBK_OK &&
           glbk_rsm_renderer_create(&a->gl, &size, &a->rsm) == GLBK_OK &&
           glbk_rsm_map_create(&a->gl, &spot, SIDE, &a->map) == GLBK_OK;
}

static int make_all(app *a)
{
    const glbk_source source = { NULL, tone, NULL, "base_bindings", NULL, NULL, { NULL }, { { 0, 0 } } };
    glbk_gbuffer_desc view = { WIDTH, HEIGHT, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_desc desc = { 0 };
    const glbk_functions *gl = &a->gl.gl;
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    view.attributes = where;
    if (glbk_init(&a->gl, &desc) != GLBK_OK || glbk_gbuffer_create(&a->gl, &view, &a->seen) != GLBK_OK ||
        glbk_program_compile(&a->gl, &source, &a->tone) != GLBK_OK || !make_light(a) ||
        !make_canvas(a, GLBK_FORMAT_RGBA16F, &a->light_texture, &a->light) ||
        !make_canvas(a, GLBK_FORMAT_RGBA8, &a->picture_texture, &a->picture) ||
        glbk_buffer_create(&a->gl, sizeof corners, NULL, &a->vertices) != GLBK_OK)
        return 0;
    gl->GenVertexArrays(1, &a->vertex_array);
    gl->BindVertexArray(a->vertex_array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, a->vertices.name);
    gl->EnableVertexAttribArray((uint32_t)where.position);
    gl->VertexAttribPointer((uint32_t)where.position, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    return 1;
}

static void free_all(app *a)
{
    int k;
    for (k = 0; k < BOUNCES; k++) {
        glbk_ism_choice_free(&a->gl, &a->choice[k]);
        glbk_ism_spread_free(&a->gl, &a->spread[k]);
        glbk_ism_maps_free(&a->gl, &a->maps[k]);
    }
    glbk_ism_bounces_free(&a->gl, &a->bounced);
    glbk_ism_renderer_free(&a->gl, &a->ism);
    glbk_rsm_map_free(&a->gl, &a->map);
    glbk_rsm_renderer_free(&a->gl, &a->rsm);
    glbk_gbuffer_free(&a->gl, &a->seen);
    glbk_target_free(&a->gl, &a->light);
    glbk_target_free(&a->gl, &a->picture);
    glbk_texture_free(&a->gl, &a->light_texture);
    glbk_texture_free(&a->gl, &a->picture_texture);
    glbk_program_free(&a->gl, &a->tone);
    glbk_buffer_free(&a->gl, &a->vertices);
    glbk_free(&a->gl);
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "two bounces with their shadows", NULL, NULL);
    if (!window) return NULL;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    return window;
}

int main(int count, char **values)
{
    static const glbk_ism_visible exact = { by_rays, set_plate, NULL };
    static app a;
    GLFWwindow *window = open_window(count < 2);
    if (!window) return fail("GLFW", "there is no display, or no OpenGL 3.3");
    if (!make_all(&a) ||
        (count > 2 && !strcmp(values[2], "exact") && glbk_ism_renderer_see(&a.gl, &a.ism, &exact) != GLBK_OK))
        return fail("OpenGL", "it does not work");
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (!frame(&a, count > 1 ? 0.0f : (float)glfwGetTime()) || !show(&a, count > 1 ? &a.picture : NULL))
            return fail("light", "it does not work");
        if (count > 1) return save(&a, values[1]) || glbk_check(&a.gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    free_all(&a);
    glfwTerminate();
    return 0;
}
