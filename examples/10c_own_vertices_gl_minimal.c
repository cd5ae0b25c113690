/* 10c_own_vertices_gl_minimal.c - vertices and pixels by GLSL of one's own, in every pass: a column bends by two bones,
   and a screen before it has round holes, in a room that a spot lights by one bounce. G-buffer, reflective shadow map
   and the triangles of the imperfect shadow maps get the same function; the latter by transform feedback. Per frame the
   CPU sends two matrices, and nothing is read back.

   cc -O2 10c_own_vertices_gl_minimal.c -lglfw -lm -o own_vertices_gl && ./own_vertices_gl        Escape ends it
   ./own_vertices_gl picture.ppm                                          one picture, no visible window */
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

enum { WIDTH = 640, HEIGHT = 480, SIDE = 256, VPLS = 256, SURFELS = 2048 };
enum { QUADS = 6, RINGS = 9, VERTICES = 4 * QUADS + 4 * RINGS, TRIANGLES = 2 * QUADS + 8 * (RINGS - 1) };

/* ---- GLSL: what a mesh's vertices and pixels are ---- */

static const char vertices_glsl[] =
    "layout(location = 0) in vec3 at;\n"
    "layout(location = 1) in float weight;\n"          /* of the second bone; 0 but for the column */
    "layout(location = 2) in vec2 place;\n"            /* on the screen with holes; 0 0 elsewhere */
    "uniform mat4 bones[2];\n"
    "void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent)\n"
    "{\n"
    "    vec4 p = vec4(at, 1.0);\n"
    "    position = mix((bones[0] * p).xyz, (bones[1] * p).xyz, weight);\n"
    "    normal = vec3(0.0);\n"                        /* those of the triangles */
    "    uv = place;\n"
    "    tangent = vec4(0.0);\n"
    "}\n";
static const char pixels_glsl[] =
    "bool glbk_fragment(vec2 uv, inout vec4 color)\n"
    "{\n"
    "    vec2 p = fract(4.0 * uv) - 0.5;\n"
    "    return uv == vec2(0.0) || dot(p, p) > 0.09;\n"    /* 16 holes, each 0.28 of a square */
    "}\n";
/* The same function once more, which writes world positions into a buffer. */
static const char moves_glsl[] =
    "out vec4 moved;\n"
    "void main()\n"
    "{\n"
    "    vec3 position, normal;\n"
    "    vec2 uv;\n"
    "    vec4 tangent;\n"
    "    glbk_vertex(position, normal, uv, tangent);\n"
    "    moved = vec4(position, 1.0);\n"
    "    gl_Position = vec4(0.0);\n"
    "}\n";
static const char no_pixels[] = "void main() { }\n";
/* What calls of the library take that draw meshes. */
static const glbk_attributes own = { 0, 0, 0, 0, vertices_glsl, pixels_glsl };

/* ---- the room: parallelograms as corner, edge, edge, and their colours; the last one has holes ---- */

static const float quads[QUADS][12] = {
    { -1, 0, -1, 2, 0, 0, 0, 0, 2, 0.8f, 0.8f, 0.8f },          /* floor */
    { -1, 2, -1, 2, 0, 0, 0, 0, 2, 0.8f, 0.8f, 0.8f },          /* ceiling */
    { -1, 0, -1, 2, 0, 0, 0, 2, 0, 0.8f, 0.8f, 0.8f },          /* back */
    { -1, 0, -1, 0, 0, 2, 0, 2, 0, 0.75f, 0.1f, 0.05f },        /* left */
    { 1, 0, -1, 0, 0, 2, 0, 2, 0, 0.1f, 0.6f, 0.1f },           /* right */
    { -0.5f, 0.9f, 0.3f, 0.1f, 0.9f, 0, 0.5f, 0, 0.5f, 0.3f, 0.5f, 0.2f }
};
static const float column_color[3] = { 0.9f, 0.8f, 0.4f };

typedef struct vertex { float at[3], weight, place[2]; } vertex;
static vertex   vertices[VERTICES];
static float    positions[3 * VERTICES], opacities[TRIANGLES];
static uint32_t triangles[3 * TRIANGLES];

static void add_triangle(uint32_t *count, uint32_t a, uint32_t b, uint32_t c)
{
    triangles[3 * *count] = a, triangles[3 * *count + 1] = b, triangles[3 * *count + 2] = c;
    opacities[(*count)++] = 1;
}

static void make_mesh(void)
{
    uint32_t count = 0, q;
    uint32_t k, c, ring;
    for (q = 0; q < QUADS; q++) {
        for (k = 0; k < 4; k++) {
            vertex *v = &vertices[4 * q + k];
            for (c = 0; c < 3; c++)
                v->at[c] = quads[q][c] + (k & 1 ? quads[q][3 + c] : 0) + (k & 2 ? quads[q][6 + c] : 0);
            if (q == QUADS - 1) v->place[0] = k & 1 ? 1 : 1e-6f, v->place[1] = k & 2 ? 1 : 1e-6f;
        }
        add_triangle(&count, 4 * q, 4 * q + 1, 4 * q + 2);
        add_triangle(&count, 4 * q + 1, 4 * q + 3, 4 * q + 2);
    }
    opacities[count - 1] = opacities[count - 2] = 0.72f;    /* which imperfect shadow maps take for its holes */
    for (ring = 0; ring < RINGS; ring++)
        for (k = 0; k < 4; k++) {
            const float height = (float)ring / (RINGS - 1), bend = 2 * height - 0.5f;
            const uint32_t at = 4 * QUADS + 4 * ring, next = (k + 1) % 4;
            vertex *v = &vertices[at + k];
            v->at[0] = 0.3f + (k == 1 || k == 2 ? 0.12f : -0.12f);
            v->at[1] = 1.4f * height;
            v->at[2] = -0.2f + (k >= 2 ? 0.12f : -0.12f);
            v->weight = bend < 0 ? 0 : bend < 1 ? bend : 1;
            if (ring + 1 == RINGS) continue;
            add_triangle(&count, at + k, at + next, at + 4 + k);
            add_triangle(&count, at + next, at + 4 + next, at + 4 + k);
        }
    for (k = 0; k < VERTICES; k++) memcpy(positions + 3 * k, vertices[k].at, sizeof vertices[k].at);
}

/* The lower bone rests, the upper one turns about the middle of the column. */
static void set_bones(const glbk_context *gl, float time)
{
    const float s = sinf(0.9f * sinf(time)), c = cosf(0.9f * sinf(time)), x = 0.3f, y = 0.7f;
    const float bones[2][16] = { { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 },
                                 { c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x - c * x + s * y, y - s * x - c * y, 0, 1 } };
    gl->gl.UniformMatrix4fv(gl->gl.GetUniformLocation(gl->program, "bones"), 2, 0, bones[0]);
}

typedef struct app {
    glbk_context      gl;
    glbk_gbuffer      seen;
    glbk_rsm_renderer rsm;              /* of direct light */
    glbk_rsm_map      map;
    glbk_ism_renderer ism;              /* of bounced light */
    glbk_ism_maps     maps;
    glbk_ism_choice   choice;           /* of their VPLs */
    glbk_ism_spread   spread;           /* of their surfels */
    glbk_buffer       vertices, indices, moved;
    uint32_t          vertex_array;
    glbk_texture      light_texture, picture_texture;
    glbk_target       light, picture;
    glbk_program      tone, moves;
    float             time;
    uint32_t          index;            /* of the frame */
} app;

/* The spot sees the room through a renderer, we see it in a G-buffer, without. */
static void draw_room(void *user, glbk_context *gl, glbk_rsm_renderer *r)
{
    app *a = (app *)user;
    uint32_t q;
    set_bones(gl, a->time);
    gl->gl.BindVertexArray(a->vertex_array);
    for (q = 0; q <= QUADS; q++) {
        const uint32_t first = 6 * q, count = q < QUADS ? 6 : 3 * TRIANGLES - 6 * QUADS;
        glbk_surface s = { 0 };
        memcpy(s.material.diffuse, q < QUADS ? quads[q] + 9 : column_color, sizeof s.material.diffuse);
        if (r) glbk_rsm_object(gl, r, &s, 0);
        else glbk_gbuffer_object(gl, &a->seen, &s);
        gl->gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)count, GLBK_GL_UNSIGNED_INT, (const void *)(4 * (size_t)first));
    }
}

/* Bends the vertices into a buffer, and copies that into the table from which surfels are scattered and drawn: fewer
   than 1024 vertices are one row of it. */
static int move_triangles(app *a)
{
    enum { PIXEL_UNPACK_BUFFER = 0x88EC, RGBA = 0x1908 };
    const glbk_functions *gl = &a->gl.gl;
    glbk_pass pass = { 0 };
    pass.target = &a->light;            /* of which nothing is drawn */
    if (glbk_begin(&a->gl, &pass, &a->moves) != GLBK_OK) return 0;
    set_bones(&a->gl, a->time);
    gl->BindVertexArray(a->vertex_array);
    gl->BindBufferBase(GLBK_GL_TRANSFORM_FEEDBACK_BUFFER, 0, a->moved.name);
    gl->Enable(GLBK_GL_RASTERIZER_DISCARD);
    gl->BeginTransformFeedback(GLBK_GL_POINTS);
    gl->DrawArrays(GLBK_GL_POINTS, 0, VERTICES);
    gl->EndTransformFeedback();
    gl->Disable(GLBK_GL_RASTERIZER_DISCARD);
    gl->BindBufferBase(GLBK_GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    gl->BindBuffer(PIXEL_UNPACK_BUFFER, a->moved.name);
    gl->BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, a->maps.positions.name);
    gl->TexSubImage3D(GLBK_GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, VERTICES, 1, 1, RGBA, GLBK_GL_FLOAT, NULL);
    gl->BindBuffer(PIXEL_UNPACK_BUFFER, 0);
    return 1;
}

/* VPLs lie where the spot's map has flux, surfels where the camera or a VPL sees something. */
static int draw_maps(app *a)
{
    return glbk_rsm_map_draw(&a->gl, &a->rsm, &a->map, draw_room, a) == GLBK_OK &&
           glbk_ism_choose(&a->gl, &a->choice, &a->maps, &a->map.texels, &a->seen, a->index) == GLBK_OK &&
           glbk_ism_scatter(&a->gl, &a->spread, &a->maps, &a->seen, a->index) == GLBK_OK &&
           glbk_ism_draw(&a->gl, &a->maps, 0) == GLBK_OK;
}

/* ---- a frame ---- */

static int frame(app *a, float time)
{
    static const float eye[3] = { 0, 1, 4.4f },
                       view[16] = { 2, 0, 0, 0, 0, 2.667f, 0, 0, 0, 0, -1.02f, -1, 0, -2.667f, 4.286f, 4.4f };
    const glbk_rsm_map *lit = &a->map;
    ism_shading shading = { 0 };
    glbk_pass pass = { 0 };
    glbk_context *gl = &a->gl;
    a->time = time;
    if (!move_triangles(a) || glbk_gbuffer_begin(gl, &a->seen, view, eye) != GLBK_OK) return 0;
    draw_room(a, gl, NULL);
    if (!draw_maps(a)) return 0;
    shading.interleave = 4;                            /* 4 x 4 pixels share the VPLs; a blur mends that */
    pass.target = &a->light;
    if (glbk_rsm_direct(gl, &a->rsm, &a->seen, &lit, 1, NULL) != GLBK_OK ||
        glbk_ism_shade(gl, &a->ism, &a->seen, &a->maps, &shading, 0) != GLBK_OK ||
        glbk_rsm_resolve(gl, &a->rsm, &a->seen, &pass, NULL, 1, 0) != GLBK_OK)
        return 0;
    pass.blend = GLBK_BLEND_ADD;                    /* bounced light over direct light */
    a->index++;
    return glbk_ism_resolve(gl, &a->ism, &a->seen, &pass, NULL) == GLBK_OK;
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

static int make_light(app *a)
{
    const rsm_light spot = { RSM_LIGHT_SPOT, { -0.7f, 1.9f, 0.9f }, { 0.75f, -1, -0.8f }, { 0, 1, 0 }, { 14, 14, 14 },
                             0, 0.55f, 0.05f, 10 };
    const ism_mesh mesh = { positions, VERTICES, 0, triangles, 3 * TRIANGLES, NULL, opacities, NULL, NULL, NULL };
    glbk_rsm_renderer_desc size = { 0 };
    const glbk_ism_renderer_desc ism_size = { WIDTH, HEIGHT };
    const glbk_ism_choice_desc map_size = { SIDE, SIDE, 1, 0 };
    ism_desc sizes = { 0 };
    sizes.vpl_count = VPLS;
    sizes.surfel_count = SURFELS;
    size.width = WIDTH;
    size.height = HEIGHT;
    size.attributes = own;
    return glbk_ism_maps_create(&a->gl, &sizes, &a->maps) == GLBK_OK &&
           glbk_ism_mesh_upload(&a->gl, &a->maps, &mesh) == GLBK_OK &&
           glbk_ism_spread_create(&a->gl, &a->maps, &a->spread) == GLBK_OK &&
           glbk_ism_choice_create(&a->gl, &a->maps, &map_size, &a->choice) == GLBK_OK &&
           glbk_ism_renderer_create(&a->gl, &ism_size, &a->ism) == GLBK_OK &&
           glbk_rsm_renderer_create(&a->gl, &size, &a->rsm) == GLBK_OK &&
           glbk_rsm_map_create(&a->gl, &spot, SIDE, &a->map) == GLBK_OK;
}

static void make_arrays(app *a)
{
    const glbk_functions *gl = &a->gl.gl;
    gl->GenVertexArrays(1, &a->vertex_array);
    gl->BindVertexArray(a->vertex_array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, a->vertices.name);
    gl->EnableVertexAttribArray(0);
    gl->EnableVertexAttribArray(1);
    gl->EnableVertexAttribArray(2);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, sizeof(vertex), NULL);
    gl->VertexAttribPointer(1, 1, GLBK_GL_FLOAT, 0, sizeof(vertex), (const void *)12);
    gl->VertexAttribPointer(2, 2, GLBK_GL_FLOAT, 0, sizeof(vertex), (const void *)16);
    gl->GenBuffers(1, &a->indices.name);        /* WebGL wants buffers of indices to be nothing else */
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, a->indices.name);
    gl->BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, sizeof triangles, triangles, GLBK_GL_STATIC_DRAW);
}

static int make_all(app *a)
{
    static char moves[sizeof vertices_glsl + sizeof moves_glsl];
    const glbk_source source = { NULL, tone, NULL, "base_bindings", NULL, NULL, { NULL }, { { 0, 0 } } };
    const glbk_source mover = { moves, no_pixels, NULL, NULL, NULL, "moved", { NULL }, { { 0, 0 } } };
    glbk_gbuffer_desc view = { WIDTH, HEIGHT, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_desc desc = { 0 };
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    view.attributes = own;
    make_mesh();
    strcat(strcpy(moves, vertices_glsl), moves_glsl);
    if (glbk_init(&a->gl, &desc) != GLBK_OK || glbk_gbuffer_create(&a->gl, &view, &a->seen) != GLBK_OK ||
        glbk_program_compile(&a->gl, &source, &a->tone) != GLBK_OK ||
        glbk_program_compile(&a->gl, &mover, &a->moves) != GLBK_OK || !make_light(a) ||
        !make_canvas(a, GLBK_FORMAT_RGBA16F, &a->light_texture, &a->light) ||
        !make_canvas(a, GLBK_FORMAT_RGBA8, &a->picture_texture, &a->picture) ||
        glbk_buffer_create(&a->gl, sizeof vertices, vertices, &a->vertices) != GLBK_OK ||
        glbk_buffer_create(&a->gl, 16 * VERTICES, NULL, &a->moved) != GLBK_OK)
        return 0;
    make_arrays(a);
    return 1;
}

static void free_all(app *a)
{
    glbk_ism_choice_free(&a->gl, &a->choice);
    glbk_ism_spread_free(&a->gl, &a->spread);
    glbk_ism_maps_free(&a->gl, &a->maps);
    glbk_ism_renderer_free(&a->gl, &a->ism);
    glbk_rsm_map_free(&a->gl, &a->map);
    glbk_rsm_renderer_free(&a->gl, &a->rsm);
    glbk_gbuffer_free(&a->gl, &a->seen);
    glbk_target_free(&a->gl, &a->light);
    glbk_target_free(&a->gl, &a->picture);
    glbk_texture_free(&a->gl, &a->light_texture);
    glbk_texture_free(&a->gl, &a->picture_texture);
    glbk_program_free(&a->gl, &a->tone);
    glbk_program_free(&a->gl, &a->moves);
    glbk_buffer_free(&a->gl, &a->vertices);
    glbk_buffer_free(&a->gl, &a->indices);
    glbk_buffer_free(&a->gl, &a->moved);
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "vertices of one's own", NULL, NULL);
    if (!window) return NULL;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    return window;
}

int main(int count, char **values)
{
    static app a;
    GLFWwindow *window = open_window(count < 2);
    if (!window) return fail("GLFW", "there is no display, or no OpenGL 3.3");
    if (!make_all(&a)) return fail("OpenGL", "it does not work");
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (!frame(&a, count > 1 ? 1.0f : (float)glfwGetTime()) || !show(&a, count > 1 ? &a.picture : NULL))
            return fail("light", "it does not work");
        if (count > 1) return save(&a, values[1]) || glbk_check(&a.gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    free_all(&a);
    glfwTerminate();
    return 0;
}
