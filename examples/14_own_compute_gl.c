/* 14_own_compute_gl.c - compute passes of your own behind a technique, on OpenGL 4.3: csm_visible() lights a picture in
   floats whose brightness nobody knows; a first pass counts the pixels of each brightness in a storage buffer, a second
   one finds the middle of the counts and writes the picture exposed by it. Where the context has no compute shaders the
   program says so and ends with status 77.

   cc -O2 14_own_compute_gl.c -lglfw -lm -o own_compute_gl && ./own_compute_gl           Escape ends it
   ./own_compute_gl picture.ppm                  one picture, no visible window; without a display: xvfb-run -a */
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

enum { WIDTH = 640, HEIGHT = 400, RINGS = 96, SIDES = 48, BINS = 64 };

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

/* ---- a renderer of our own: it marches along the ray of a pixel, and writes radiance ---- */

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
    "    color = vec4(30.0, 40.0, 50.0, 1.0);\n"
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
    "    color.rgb = (is_torus ? vec3(0.9, 0.6, 0.4) : vec3(0.8)) * (8.0 + 90.0 * light / 64.0);\n"
    "}\n";

/* ---- the passes behind it. A bin is a quarter of a power of two, from 2^-8 on ---- */

#define COUNTS "layout(std430, binding = 0) buffer counted { uint counts[BINS]; };\n"
#define FRAME "layout(std140, binding = 0) uniform frame { uvec2 size; float grey; };\n"

static const char count_pixels[] =
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "uniform sampler2D glbk_user0;                       // the picture\n"
    COUNTS FRAME
    "void main()\n"
    "{\n"
    "    uvec2 at = gl_GlobalInvocationID.xy;\n"
    "    if (any(greaterThanEqual(at, size))) return;\n"
    "    float bright = dot(texelFetch(glbk_user0, ivec2(at), 0).rgb, vec3(0.2126, 0.7152, 0.0722));\n"
    "    int bin = int(4.0 * (log2(max(bright, 1e-9)) + 8.0));\n"
    "    atomicAdd(counts[clamp(bin, 0, BINS - 1)], 1u);\n"
    "}\n";

static const char expose_pixels[] =
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "uniform sampler2D glbk_user0;\n"
    "layout(rgba8, binding = 0) writeonly uniform image2D shown;\n"
    COUNTS FRAME
    "void main()\n"
    "{\n"
    "    uvec2 at = gl_GlobalInvocationID.xy;\n"
    "    int middle = 0;\n"
    "    for (uint below = counts[0]; 2u * below < size.x * size.y; below += counts[middle]) middle++;\n"
    "    float exposure = grey / exp2((float(middle) + 0.5) / 4.0 - 8.0);\n"
    "    if (any(greaterThanEqual(at, size))) return;\n"
    "    vec3 light = exposure * texelFetch(glbk_user0, ivec2(at), 0).rgb;\n"
    "    imageStore(shown, ivec2(at), vec4(pow(light / (1.0 + light), vec3(1.0 / 2.2)), 1.0));\n"
    "}\n";

static const char show_pixels[] =
    "uniform sampler2D glbk_user0;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main() { color = texelFetch(glbk_user0, ivec2(gl_FragCoord.xy), 0); }\n";

typedef struct frame_block { uint32_t size[2]; float grey; uint32_t unused; } frame_block;     /* std140: 16 bytes */

typedef struct exposer {
    glbk_program count, expose, show;
    glbk_texture light, shown;          /* radiance, and what is seen of it */
    glbk_target  light_target, shown_target;
    glbk_buffer  counts, frame;
} exposer;

static glbk_result compile(glbk_context *gl, const char *compute, const char *text, glbk_program *out)
{
    glbk_source source = { 0 };
    source.compute = compute;
    source.fragment = text;
    source.defines = "BINS=64";
    return glbk_program_compile(gl, &source, out);
}

static glbk_result make_target(glbk_context *gl, glbk_format format, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc desc = { GLBK_FORMAT_NONE, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    glbk_result result;
    desc.format = format;
    result = glbk_texture_create(gl, &desc, texture);
    to.color[0] = texture;
    return result == GLBK_OK ? glbk_target_create(gl, &to, target) : result;
}

static glbk_result exposer_create(glbk_context *gl, exposer *e)
{
    static const frame_block frame = { { WIDTH, HEIGHT }, 0.3f, 0 };
    glbk_result result = compile(gl, count_pixels, NULL, &e->count);
    if (result == GLBK_OK) result = compile(gl, expose_pixels, NULL, &e->expose);
    if (result == GLBK_OK) result = compile(gl, NULL, show_pixels, &e->show);
    if (result == GLBK_OK) result = make_target(gl, GLBK_FORMAT_RGBA16F, &e->light, &e->light_target);
    if (result == GLBK_OK) result = make_target(gl, GLBK_FORMAT_RGBA8, &e->shown, &e->shown_target);
    if (result == GLBK_OK) result = glbk_buffer_create(gl, BINS * sizeof(uint32_t), NULL, &e->counts);
    if (result == GLBK_OK) result = glbk_buffer_create(gl, sizeof frame, &frame, &e->frame);
    return result;
}

static void exposer_free(glbk_context *gl, exposer *e)
{
    glbk_program_free(gl, &e->count);
    glbk_program_free(gl, &e->expose);
    glbk_program_free(gl, &e->show);
    glbk_target_free(gl, &e->light_target);
    glbk_target_free(gl, &e->shown_target);
    glbk_texture_free(gl, &e->light);
    glbk_texture_free(gl, &e->shown);
    glbk_buffer_free(gl, &e->counts);
    glbk_buffer_free(gl, &e->frame);
}

/* Slots are bound before a dispatch, which makes what the first pass wrote visible to the second. */
static glbk_result expose(glbk_context *gl, exposer *e)
{
    static const uint32_t zeros[BINS] = { 0 };
    glbk_result result = glbk_buffer_update(gl, &e->counts, 0, sizeof zeros, zeros);
    glbk_bind_texture(gl, GLBK_SLOT_glbk_user0, &e->light);
    glbk_bind_storage(gl, 0, &e->counts);
    glbk_bind_block(gl, 0, &e->frame);
    glbk_bind_image(gl, 0, &e->shown);
    if (result == GLBK_OK) result = glbk_dispatch(gl, &e->count, (WIDTH + 7) / 8, (HEIGHT + 7) / 8, 1);
    if (result == GLBK_OK) result = glbk_dispatch(gl, &e->expose, (WIDTH + 7) / 8, (HEIGHT + 7) / 8, 1);
    return result;
}

/* The counts on the CPU: this waits for the GPU, so once, not in every frame. */
static glbk_result say_counts(glbk_context *gl, const exposer *e)
{
    uint32_t counts[BINS], all = 0;
    int first = 0, last = BINS - 1;
    glbk_result result = glbk_buffer_read(gl, &e->counts, 0, sizeof counts, counts);
    if (result != GLBK_OK) return result;
    while (first < last && !counts[first]) first++;
    while (last > first && !counts[last]) last--;
    for (int i = 0; i < BINS; i++) all += counts[i];
    printf("%u pixels, from %.3g to %.3g\n", (unsigned)all, exp2(first / 4.0 - 8), exp2((last + 1) / 4.0 - 8));
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

/* The torus in maps of 64 x 64 directions, on the GPU, and the program that asks them. */
static glbk_result make_scene(glbk_context *gl, glbk_csm_maps *uploaded, glbk_program *program)
{
    cohsm_mesh mesh = make_torus();
    cohsm_desc desc = { 0 };
    cohsm_maps *maps;
    glbk_csm_block block;
    glbk_csm_instance torus = { 0, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, 0 };
    glbk_source source = { 0 };
    glbk_result result;
    desc.domain.side[0] = desc.domain.side[1] = 64;
    if (cohsm_build(&desc, &mesh, &maps, NULL) != COHSM_OK) return GLBK_ERR_ALLOC;
    block.data = cohsm_data(maps, &block.bytes);
    source.fragment = fragment;
    source.parts[0] = glbk_csm_part();
    source.uses = "csm_visible";
    source.defines = uploaded->defines;     /* for these maps alone; the next call writes it */
    result = glbk_csm_maps_create(gl, &block, 1, 1, &torus.start, uploaded);
    if (result == GLBK_OK) result = glbk_csm_maps_place(gl, uploaded, &torus, 1);
    if (result == GLBK_OK) result = glbk_program_compile(gl, &source, program);
    cohsm_free(maps);
    return result;
}

static glbk_result draw(glbk_context *gl, exposer *e, const glbk_csm_maps *maps, glbk_program *program, float angle)
{
    glbk_pass pass = { 0 };
    glbk_result result;
    pass.target = &e->light_target;
    result = glbk_begin(gl, &pass, program);
    if (result != GLBK_OK) return result;
    glbk_csm_bind(gl, maps, NULL);
    gl->gl.Uniform1f(gl->gl.GetUniformLocation(program->name, "turn"), angle);
    glbk_draw_screen(gl);
    return expose(gl, e);
}

static glbk_result show(glbk_context *gl, exposer *e)
{
    glbk_pass pass = { 0 };                 /* to the window */
    glbk_result result;
    pass.viewport[2] = WIDTH;
    pass.viewport[3] = HEIGHT;
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);
    result = glbk_begin(gl, &pass, &e->show);
    glbk_bind_texture(gl, GLBK_SLOT_glbk_user0, &e->shown);
    if (result == GLBK_OK) glbk_draw_screen(gl);
    return result;
}

int main(int count, char **values)
{
    glbk_desc gl_desc = { 0 };
    glbk_context gl;
    glbk_csm_maps maps;
    glbk_program program;
    exposer e = { 0 };
    GLFWwindow *window;
    int status = 0;

    if (!glfwInit()) return fail("GLFW", "there is no display");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_RESIZABLE, 0);
    glfwWindowHint(GLFW_VISIBLE, count < 2);
    window = glfwCreateWindow(WIDTH, HEIGHT, "compute passes of your own", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 4.3, which has compute shaders"), 77;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);

    gl_desc.get_proc_fn = get_proc;
    gl_desc.system.log = say;
    if (glbk_init(&gl, &gl_desc) != GLBK_OK) return fail("OpenGL", "it does not work");
    if (!gl.compute) return fail("OpenGL", "no compute shaders here"), 77;
    if (make_scene(&gl, &maps, &program) != GLBK_OK || exposer_create(&gl, &e) != GLBK_OK)
        return fail("OpenGL", "it does not work");

    if (count > 1) {
        status = draw(&gl, &e, &maps, &program, 0.6f) != GLBK_OK || say_counts(&gl, &e) != GLBK_OK ||
                 save(&gl, &e.shown_target, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSetWindowShouldClose(window, 1);
    }
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (draw(&gl, &e, &maps, &program, (float)glfwGetTime() * 0.5f) != GLBK_OK || show(&gl, &e) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    exposer_free(&gl, &e);
    glbk_csm_maps_free(&gl, &maps);
    glbk_program_free(&gl, &program);
    glbk_free(&gl);
    glfwTerminate();
    return status;
}
