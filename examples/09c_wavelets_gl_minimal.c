/* 09c_wavelets_gl_minimal.c - shadows with edges from objects and a small lamp that move: shadowfield.h computes their
   fields of wavelets, once; gl_wavelets.h lights what a G-buffer holds. Here a CPU fills it, a ray a pixel.

   cc -O2 09c_wavelets_gl_minimal.c -lglfw -lm -o wavelets_gl_minimal && ./wavelets_gl_minimal    Escape ends it
   ./wavelets_gl_minimal picture.ppm                one picture, no visible window; without a display: xvfb-run -a */
#define SHADOWFIELD_IMPLEMENTATION
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_SHADOWFIELD_IMPLEMENTATION
#define GL_WAVELETS_IMPLEMENTATION
#include "gl_backend/gl_wavelets.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 192, HEIGHT = 120, BOARDS = 3, SIDE = 32 };

static const float half[3] = { 0.9f, 1.1f, 0.1f }, camera[3] = { 0, 3.2f, 7 };      /* of a board; where the eye is */

/* ---- fields: a board, and a lamp ---- */

static sfield_field *make_board(void)
{
    static const uint32_t indices[36] = { 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                          2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5 };
    float positions[24];
    sfield_mesh mesh = { positions, 8, 0, indices, 36, NULL, NULL, NULL };
    sfield_desc desc;
    sfield_field *field = NULL;
    for (int i = 0; i < 24; i++) positions[i] = (i / 3 >> i % 3 & 1) ? half[i % 3] : -half[i % 3];
    memset(&desc, 0, sizeof desc);
    desc.basis = SFIELD_BASIS_HAAR;
    desc.cube_side = SIDE;
    desc.position_side = 12;                    /* 16 by default; this takes half the time */
    sfield_build(&desc, &mesh, &field, NULL);
    return field;
}

static sfield_field *make_lamp(void)
{
    const sfield_emitter lamp = { SFIELD_EMITTER_SPHERE, 0.3f, { 0 }, { 0 }, { 0 }, { 190, 175, 150 }, 0, NULL, NULL };
    sfield_desc desc;
    sfield_field *field = NULL;
    memset(&desc, 0, sizeof desc);
    desc.basis = SFIELD_BASIS_HAAR;
    desc.cube_side = SIDE;
    desc.position_side = 6;                     /* a ball is the same from all sides */
    sfield_build_emitter(&desc, &lamp, &field, NULL);
    return field;
}

/* ---- a renderer of our own: a ray for each pixel, to the floor or to a board ---- */

/* Where a ray enters a board, by slabs in its space; returns the distance, or a large number. */
static float meet_board(const float *m, const float *ray, float *normal)
{
    float near = -1e9f, far = 1e9f;
    for (int k = 0; k < 3; k++) {
        const float *axis = m + 4 * k;
        float from = 0, along = 0, a, b;
        for (int i = 0; i < 3; i++) {
            from += axis[i] * (camera[i] - m[12 + i]);
            along += axis[i] * ray[i];
        }
        along = fabsf(along) > 1e-9f ? along : 1e-9f;
        a = (-half[k] - from) / along;
        b = (half[k] - from) / along;
        if (fminf(a, b) > near) {
            near = fminf(a, b);
            for (int i = 0; i < 3; i++) normal[i] = along > 0 ? -axis[i] : axis[i];
        }
        far = fminf(far, fmaxf(a, b));
    }
    return near < far && near > 0 ? near : 1e9f;
}

static void see(const sfield_entity *entities, glbk_pixel *pixels)
{
    memset(pixels, 0, WIDTH * HEIGHT * sizeof *pixels);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const float x = ((float)(i % WIDTH) - WIDTH / 2.0f) / HEIGHT, y = (float)(i / WIDTH) / HEIGHT - 0.9f;
        const float length = sqrtf(x * x + y * y + 1), ray[3] = { x / length, y / length, -1 / length };
        float nearest = ray[1] < 0 ? -camera[1] / ray[1] : 1e9f;
        glbk_pixel *p = &pixels[i];
        p->normal[1] = 1;
        for (uint32_t b = 0; b < BOARDS; b++) {
            float normal[3], at = meet_board(entities[b].transform, ray, normal);
            if (at >= nearest) continue;
            nearest = at;
            p->entity = b + 1;
            memcpy(p->normal, normal, sizeof normal);
        }
        for (int k = 0; k < 3; k++) {
            static const float wood[3] = { 0.85f, 0.55f, 0.32f };
            p->position[k] = camera[k] + nearest * ray[k];
            p->material.diffuse[k] = p->entity ? wood[k] : 0.75f;
        }
        if (nearest > 1e8f) p->normal[1] = 0;   /* nothing is seen */
    }
}

/* The lighting pass: light times colour. */
static const char fragment[] =
    "uniform glbk_color_sampler glbk_user0;              // haar.light\n"
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    glbk_point p;\n"
    "    color = vec4(0.05, 0.06, 0.08, 1.0);\n"
    "    if (!glbk_read_point(at, p)) return;\n"
    "    vec3 light = max(glbk_unpack(texelFetch(glbk_user0, at, 0)).rgb, 0.0) + 0.05;\n"
    "    color.rgb = pow(p.diffuse * light, vec3(1.0 / 2.2));\n"
    "}\n";

typedef struct stage {
    glbk_context      gl;
    glbk_sfield_scene scene;
    glbk_sfield_haar  haar;
    glbk_gbuffer      seen;
    glbk_program      light;
    glbk_texture      texture;
    glbk_target       target;                   /* of a picture: windows that are not shown have no pixels */
    sfield_field     *fields[2];                /* board, lamp */
    glbk_pixel        pixels[WIDTH * HEIGHT];
} stage;

static glbk_result create(stage *s)
{
    const glbk_texture_desc picture = { GLBK_FORMAT_RGBA8, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_gbuffer_desc sizes;
    glbk_sfield_haar_scene_desc scene;
    glbk_sfield_haar_desc haar;
    glbk_source source;
    glbk_target_desc target;
    glbk_result result;
    memset(&sizes, 0, sizeof sizes);
    memset(&scene, 0, sizeof scene);
    memset(&haar, 0, sizeof haar);
    memset(&source, 0, sizeof source);
    memset(&target, 0, sizeof target);
    scene.fields = (const sfield_field *const *)s->fields;
    scene.field_count = 2;
    scene.entity_capacity = BOARDS + 1;
    sizes.width = haar.width = WIDTH;
    sizes.height = haar.height = HEIGHT;
    scene.cube_side = haar.cube_side = SIDE;
    source.parts[0] = glbk_gbuffer_part();
    source.uses = "gbuffer";
    source.fragment = fragment;
    target.color[0] = &s->texture;
    result = glbk_sfield_haar_upload(&s->gl, &scene, &s->scene);
    if (result == GLBK_OK) result = glbk_sfield_haar_create(&s->gl, &haar, &s->haar);
    if (result == GLBK_OK) result = glbk_gbuffer_create(&s->gl, &sizes, &s->seen);
    if (result == GLBK_OK) result = glbk_program_compile(&s->gl, &source, &s->light);
    if (result == GLBK_OK) result = glbk_texture_create(&s->gl, &picture, &s->texture);
    return result == GLBK_OK ? glbk_target_create(&s->gl, &target, &s->target) : result;
}

/* Three boards that turn, and the lamp that goes to and fro behind them. */
static glbk_result frame(stage *s, float time, const glbk_target *target)
{
    const glbk_pass screen = {
        target, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    sfield_entity entities[BOARDS + 1];
    glbk_result result;
    memset(entities, 0, sizeof entities);
    for (int i = 0; i <= BOARDS; i++) {
        float *m = entities[i].transform, a = i < BOARDS ? 0.5f * time + 0.9f * (float)i : 0;
        m[0] = m[10] = cosf(a);
        m[8] = sinf(a);
        m[2] = -m[8];
        m[5] = m[15] = 1;
        m[12] = i < BOARDS ? 2.6f * (float)(i - 1) : 2 * sinf(0.6f * time);
        m[13] = i < BOARDS ? half[1] : 3.6f;
        m[14] = i < BOARDS ? 0 : -3.5f;
        for (int k = 0; k < 3; k++) entities[i].tint[k] = 1;
        if (i < BOARDS) entities[i].occlusion = s->fields[0];
        else entities[i].source = s->fields[1];
    }
    see(entities, s->pixels);
    result = glbk_sfield_scene_entities(&s->gl, &s->scene, entities, BOARDS + 1);
    if (result == GLBK_OK) result = glbk_gbuffer_upload(&s->gl, &s->seen, 0, HEIGHT, s->pixels);
    if (result == GLBK_OK) result = glbk_sfield_haar_shade(&s->gl, &s->haar, &s->seen, &s->scene, camera, 0);
    if (result == GLBK_OK) result = glbk_begin(&s->gl, &screen, &s->light);
    if (result == GLBK_OK) result = glbk_gbuffer_bind(&s->gl, &s->seen, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(&s->gl, GLBK_SLOT_glbk_user0, &s->haar.light);
    glbk_draw_screen(&s->gl);
    return GLBK_OK;
}

static void destroy(stage *s)
{
    glbk_target_free(&s->gl, &s->target);
    glbk_texture_free(&s->gl, &s->texture);
    glbk_program_free(&s->gl, &s->light);
    glbk_gbuffer_free(&s->gl, &s->seen);
    glbk_sfield_haar_free(&s->gl, &s->haar);
    glbk_sfield_scene_free(&s->gl, &s->scene);
    glbk_free(&s->gl);
    sfield_free(s->fields[0]);
    sfield_free(s->fields[1]);
}

/* ---- window and picture ---- */

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

static int save(stage *s, const char *path)
{
    static float rgba[HEIGHT][WIDTH][4];
    FILE *file;
    if (glbk_target_read(&s->gl, &s->target, 0, 0, 0, WIDTH, HEIGHT, rgba) != GLBK_OK)
        return fail("OpenGL", "no picture");
    file = fopen(path, "wb");
    if (!file) return fail(path, "cannot be written");
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (int y = HEIGHT - 1; y >= 0; y--)
        for (int x = 0; x < WIDTH; x++)
            for (int c = 0; c < 3; c++) putc((int)(fminf(rgba[y][x][c], 1) * 255 + 0.5f), file);
    return fclose(file) != 0;
}

int main(int count, char **values)
{
    static stage s;
    glbk_desc desc = { 0 };
    GLFWwindow *window;

    s.fields[0] = make_board();
    s.fields[1] = make_lamp();
    if (!s.fields[0] || !s.fields[1]) return fail("shadowfield", "a field cannot be built");
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "wavelets", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&s.gl, &desc) != GLBK_OK || create(&s) != GLBK_OK) return fail("OpenGL", "it does not work");

    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (frame(&s, count > 1 ? 0.8f : (float)glfwGetTime(), count > 1 ? &s.target : NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        if (count > 1) return save(&s, values[1]) || glbk_check(&s.gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    destroy(&s);
    glfwTerminate();
    return 0;
}
