/* 06c_csm_gl_build.c - ambient occlusion of a mesh's vertices on the GPU: gl_csm.h draws the maps of a knot from all
   directions and finds their segments, csm.h makes one block of them, and an asker of gl_csm.h says for each vertex
   from which of 64 directions the sky reaches it. csm.h answers the same questions on the CPU, and what differs is
   counted.

   cc -O2 06c_csm_gl_build.c -lglfw -lm -o csm_gl_build && ./csm_gl_build picture.ppm     no display: xvfb-run -a */
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

enum { WIDTH = 480, HEIGHT = 400, RINGS = 256, SIDES = 24, VERTICES = RINGS * SIDES, SAMPLES = 64 };
enum { QUESTIONS = VERTICES * SAMPLES };

/* ---- the object: a knot as plain arrays, and as a vertex array of OpenGL ---- */

static float    positions[3 * VERTICES], normals[3 * VERTICES], open[VERTICES];
static uint32_t indices[6 * VERTICES];

static void curve(float t, float *p)
{
    p[0] = (2 + cosf(3 * t)) * cosf(2 * t);
    p[1] = (2 + cosf(3 * t)) * sinf(2 * t);
    p[2] = sinf(3 * t);
}

static void normalize(float *v)
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    int k;
    for (k = 0; k < 3; k++) v[k] /= length;
}

static void cross(const float *a, const float *b, float *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void make_knot(void)
{
    const float up[3] = { 0, 0, 1 };
    uint32_t i, j, k, n = 0;
    for (i = 0; i < RINGS; i++) {
        float t = 6.2831853f * (float)i / RINGS;
        float p[3], q[3], u[3], v[3];
        curve(t, p);
        curve(t + 1e-2f, q);
        for (k = 0; k < 3; k++) q[k] -= p[k];
        cross(q, up, u);
        normalize(u);
        cross(u, q, v);
        normalize(v);
        for (j = 0; j < SIDES; j++) {
            float a = 6.2831853f * (float)j / SIDES;
            uint32_t at = i * SIDES + j, i2 = (i + 1) % RINGS, j2 = (j + 1) % SIDES;
            for (k = 0; k < 3; k++) {
                normals[3 * at + k] = cosf(a) * u[k] + sinf(a) * v[k];
                positions[3 * at + k] = p[k] + 0.5f * normals[3 * at + k];
            }
            indices[n++] = at, indices[n++] = i * SIDES + j2, indices[n++] = i2 * SIDES + j2;
            indices[n++] = at, indices[n++] = i2 * SIDES + j2, indices[n++] = i2 * SIDES + j;
        }
    }
}

typedef struct object {
    uint32_t       vertex_array;
    uint32_t       buffers[3];          /* positions, indices, openness */
    cohsm_builder *builder;             /* whose cameras the views have */
} object;

static void upload(glbk_context *gl, object *o)
{
    gl->gl.GenVertexArrays(1, &o->vertex_array);
    gl->gl.GenBuffers(3, o->buffers);
    gl->gl.BindVertexArray(o->vertex_array);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, o->buffers[0]);
    gl->gl.BufferData(GLBK_GL_ARRAY_BUFFER, sizeof positions, positions, GLBK_GL_STATIC_DRAW);
    gl->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    gl->gl.EnableVertexAttribArray(0);
    gl->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, o->buffers[1]);
    gl->gl.BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, sizeof indices, indices, GLBK_GL_STATIC_DRAW);
}

static void draw(void *user, glbk_context *gl)
{
    gl->gl.BindVertexArray(((object *)user)->vertex_array);
    gl->gl.DrawElements(GLBK_GL_TRIANGLES, 6 * VERTICES, GLBK_GL_UNSIGNED_INT, NULL);
}

/* ---- the maps: drawn on the GPU, in batches of views, and made one block by csm.h's builder ---- */

static void view_of(void *user, uint32_t index, cohsm_view *out)
{
    cohsm_builder_view(((object *)user)->builder, index, out);
}

static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

/* Returns NULL if the maps cannot be made; say has told why. */
static cohsm_maps *build(glbk_context *gl, object *o)
{
    cohsm_desc desc = { 0 };
    glbk_csm_builder_desc gpu_desc = { 0 };
    glbk_csm_builder gpu = { 0 };
    cohsm_maps *maps = NULL;
    glbk_result result;
    uint32_t from, n, count;

    desc.system.log = say;
    desc.domain.side[0] = desc.domain.side[1] = 32;
    desc.map_side = 64;
    desc.radius = 3.6f;                     /* about 0 0 0; a builder knows no mesh to fit a sphere to */
    desc.layout = COHSM_LAYOUT_FAST;        /* which takes more memory, and is asked faster */
    if (cohsm_builder_create(&desc, &o->builder) != COHSM_OK) return NULL;
    gpu_desc.maps = &desc;
    gpu_desc.view_fn = view_of;
    gpu_desc.draw_fn = draw;
    gpu_desc.user = o;
    result = glbk_csm_builder_create(gl, &gpu_desc, &gpu);
    count = cohsm_builder_view_count(o->builder);
    for (from = 0; from < count && result == GLBK_OK; from += n) {
        n = count - from < gpu.batch ? count - from : gpu.batch;
        result = glbk_csm_builder_draw(gl, &gpu, from, n);
        if (result == GLBK_OK) result = glbk_csm_builder_compress(gl, &gpu);
    }
    if (result == GLBK_OK) result = glbk_csm_builder_end(gl, &gpu);
    if (result == GLBK_OK && cohsm_builder_import(o->builder, gpu.segments, gpu.segment_count) == COHSM_OK)
        cohsm_builder_finish(o->builder, &maps, NULL);
    glbk_csm_builder_free(gl, &gpu);
    cohsm_builder_free(o->builder);
    return maps;
}

/* ---- the questions: 64 directions for each vertex, many where the light comes steeply ---- */

static float points[3 * QUESTIONS], directions[3 * QUESTIONS], visible[QUESTIONS], by_cpu[QUESTIONS];

static void make_questions(void)
{
    uint32_t i, s, k;
    for (i = 0; i < VERTICES; i++) {
        const float *normal = normals + 3 * i, side[3] = { normal[1], normal[2], normal[0] };
        float u[3], v[3];
        cross(normal, side, u);
        normalize(u);
        cross(normal, u, v);
        for (s = 0; s < SAMPLES; s++) {
            float r = sqrtf(((float)s + 0.5f) / SAMPLES), a = 2.39996323f * (float)(s + 7 * i);
            for (k = 0; k < 3; k++) {
                directions[3 * (i * SAMPLES + s) + k] =
                    sqrtf(1 - r * r) * normal[k] + r * (cosf(a) * u[k] + sinf(a) * v[k]);
                points[3 * (i * SAMPLES + s) + k] = positions[3 * i + k] + 0.02f * normal[k];
            }
        }
    }
}

/* Asks the maps on the GPU; the bytes that go there are those of the fast layout. */
static glbk_result ask(glbk_context *gl, const cohsm_maps *maps, const cohsm_query *query)
{
    glbk_csm_block block;
    glbk_csm_instance knot = { 0, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, 0 };
    glbk_csm_maps uploaded = { 0 };
    glbk_csm_asker asker = { 0 };
    glbk_result result;

    block.data = cohsm_fast_data(maps, &block.bytes);
    result = glbk_csm_maps_create(gl, &block, 1, 1, &knot.start, &uploaded);
    if (result == GLBK_OK) result = glbk_csm_maps_place(gl, &uploaded, &knot, 1);
    if (result == GLBK_OK) result = glbk_csm_asker_create(gl, QUESTIONS, &asker);
    if (result == GLBK_OK) result = glbk_csm_ask_upload(gl, &asker, query);
    if (result == GLBK_OK) result = glbk_csm_ask_run(gl, &asker, &uploaded, QUESTIONS);
    if (result == GLBK_OK) result = glbk_csm_ask_read(gl, &asker, QUESTIONS, visible);
    glbk_csm_asker_free(gl, &asker);
    glbk_csm_maps_free(gl, &uploaded);
    return result;
}

/* Finds the share of the sky that each vertex sees, and prints how the answers of the GPU and the CPU agree. */
static int occlude(glbk_context *gl, const cohsm_maps *maps)
{
    cohsm_query query = { 0 };
    uint32_t i, s, differ = 0;
    float low = 1, mean = 0;

    make_questions();
    query.count = QUESTIONS;
    query.positions = points;
    query.lights = directions;
    if (ask(gl, maps, &query) != GLBK_OK || cohsm_visible(maps, &query, by_cpu, NULL) != COHSM_OK) return 1;
    for (i = 0; i < VERTICES; i++) {
        float sum = 0;
        for (s = 0; s < SAMPLES; s++) {
            sum += visible[i * SAMPLES + s];
            differ += fabsf(visible[i * SAMPLES + s] - by_cpu[i * SAMPLES + s]) > 0.5f;
        }
        open[i] = sum / SAMPLES;
        mean += open[i] / VERTICES;
        if (open[i] < low) low = open[i];
    }
    printf("%d questions, %u answers differ from the CPU's; vertices see %.2f of the sky, at least %.2f\n", QUESTIONS,
           (unsigned)differ, (double)mean, (double)low);
    return 0;
}

/* ---- the picture ---- */

static const char vertex[] =
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in float open;\n"
    "out float light;\n"
    "void main()\n"
    "{\n"
    "    vec3 p = vec3(position.x, 0.6 * position.y + 0.8 * position.z, 0.6 * position.z - 0.8 * position.y);\n"
    "    float away = 9.0 - p.z;                            // from an eye above the knot; 4 near, 14 far\n"
    "    light = open;\n"
    "    gl_Position = vec4(2.1 * p.x, 2.52 * p.y, 1.8 * away - 11.2, away);\n"
    "}\n";

static const char fragment[] =
    "in float light;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main() { color = vec4(pow(vec3(0.9, 0.7, 0.5) * light, vec3(1.0 / 2.2)), 1.0); }\n";

static int save(glbk_context *gl, const glbk_target *target, const char *path)
{
    static float rgba[HEIGHT][WIDTH][4];
    FILE *file;
    int x, y, c;
    if (glbk_target_read(gl, target, 0, 0, 0, WIDTH, HEIGHT, rgba) != GLBK_OK) return 1;
    file = fopen(path, "wb");
    if (!file) return fprintf(stderr, "%s cannot be written\n", path), 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (y = HEIGHT - 1; y >= 0; y--)
        for (x = 0; x < WIDTH; x++)
            for (c = 0; c < 3; c++) putc((int)(rgba[y][x][c] * 255 + 0.5f), file);
    return fclose(file) != 0;
}

static int picture(glbk_context *gl, object *o, const char *path)
{
    static const float sky[4] = { 0.85f, 0.9f, 0.95f, 1 };
    glbk_texture_desc desc = { GLBK_FORMAT_RGBA8, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_texture color = { 0 }, depth = { 0 };
    glbk_target_desc target_desc = { { NULL }, { 0 }, NULL, 0, 0 };
    glbk_target target = { 0 };
    glbk_source source = { 0 };
    glbk_program program = { 0 };
    glbk_pass pass = { 0 };
    int failed;

    target_desc.color[0] = &color;
    target_desc.depth = &depth;
    source.vertex = vertex;
    source.fragment = fragment;
    pass.target = &target;
    pass.depth = GLBK_DEPTH_LESS;
    failed = glbk_texture_create(gl, &desc, &color) != GLBK_OK;
    desc.format = GLBK_FORMAT_DEPTH32F;
    failed = failed || glbk_texture_create(gl, &desc, &depth) != GLBK_OK ||
             glbk_target_create(gl, &target_desc, &target) != GLBK_OK ||
             glbk_program_compile(gl, &source, &program) != GLBK_OK || glbk_begin(gl, &pass, &program) != GLBK_OK;
    if (!failed) {
        glbk_clear(gl, &target, 0, sky);
        glbk_clear_depth(gl, 1);
        gl->gl.BindVertexArray(o->vertex_array);
        gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, o->buffers[2]);
        gl->gl.BufferData(GLBK_GL_ARRAY_BUFFER, sizeof open, open, GLBK_GL_STATIC_DRAW);
        gl->gl.VertexAttribPointer(1, 1, GLBK_GL_FLOAT, 0, 0, NULL);
        gl->gl.EnableVertexAttribArray(1);
        draw(o, gl);
        failed = save(gl, &target, path) || glbk_check(gl) != GLBK_OK;
    }
    glbk_program_free(gl, &program);
    glbk_target_free(gl, &target);
    glbk_texture_free(gl, &depth);
    glbk_texture_free(gl, &color);
    return failed;
}

static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)glfwGetProcAddress(name);
}

int main(int count, char **values)
{
    glbk_desc desc = { 0 };
    glbk_context gl;
    GLFWwindow *window;
    object knot = { 0, { 0 }, NULL };
    cohsm_maps *maps;
    cohsm_info info;
    int failed;

    if (!glfwInit()) return fprintf(stderr, "there is no display\n"), 1;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
#ifdef __APPLE__
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, 1);      /* there is no other */
#endif
    glfwWindowHint(GLFW_VISIBLE, 0);
    window = glfwCreateWindow(16, 16, "ambient occlusion", NULL, NULL);
    if (!window) return fprintf(stderr, "no OpenGL 3.3\n"), 1;
    glfwMakeContextCurrent(window);
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&gl, &desc) != GLBK_OK) return 1;

    make_knot();
    upload(&gl, &knot);
    maps = build(&gl, &knot);
    if (!maps) return 1;
    cohsm_get_info(maps, &info);
    printf("%u maps in %.1f MB, %.0f times smaller, and trays of %.1f MB\n", (unsigned)info.map_count,
           (double)info.bytes * 1e-6, info.ratio, (double)info.fast_bytes * 1e-6);
    failed = occlude(&gl, maps) || picture(&gl, &knot, count > 1 ? values[1] : "occlusion.ppm");
    cohsm_free(maps);
    gl.gl.DeleteVertexArrays(1, &knot.vertex_array);
    gl.gl.DeleteBuffers(3, knot.buffers);
    glbk_free(&gl);
    glfwTerminate();
    return failed;
}
