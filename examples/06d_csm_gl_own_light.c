/* 06d_csm_gl_own_light.c - a lamp by GLSL of your own: a ribbon of light that winds upwards and turns, brighter where
   it is high and coloured by the direction in which it shines. A torus below it has coherent shadow maps; the renderer
   of gl_csm.h draws points of the ribbon by your functions, weighs them with the material, and asks the maps.

   cc -O2 06d_csm_gl_own_light.c -lglfw -lm -o own_light && ./own_light          Escape ends it
   ./own_light picture.ppm                                                one picture, no visible window */
#define CSM_IMPLEMENTATION
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_CSM_IMPLEMENTATION
#include "csm.h"
#include "gl_backend/gl_csm.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 400, RINGS = 64, SIDES = 32, VERTICES = RINGS * SIDES + 4,
       INDICES = 6 * RINGS * SIDES + 6 };

/* ---- the lamp: A and what it emits; own.x is the angle by which it has turned ---- */

static const char lamp_glsl[] =
    "void glbk_light_point(vec4 own, vec3 x, out vec3 position, out vec3 normal, out float area)\n"
    "{\n"
    "    float angle = 9.0 * x.x + own.x, radius = 1.1;\n"
    "    vec3 out_of = vec3(cos(angle), 0.0, sin(angle)), along = vec3(-out_of.z, 0.0, out_of.x);\n"
    "    position = out_of * radius + vec3(0.0, 1.2 + 1.0 * x.x + 0.16 * x.y, 0.0);\n"
    "    vec3 side = 9.0 * radius * along + vec3(0.0, 1.0, 0.0);      // d position / dx; the other one is upwards\n"
    "    normal = cross(side, vec3(0.0, 0.16, 0.0));\n"
    "    area = length(normal);\n"
    "    normal = -out_of;                                          // it shines inwards\n"
    "}\n"
    "vec3 glbk_light_emission(vec4 own, vec3 x, vec3 direction)\n"
    "{\n"
    "    vec3 warm = vec3(1.0, 0.55, 0.2), cold = vec3(0.25, 0.5, 1.0);\n"
    "    return (0.3 + 1.4 * x.x) * mix(warm, cold, 0.5 - 0.5 * direction.y);\n"
    "}\n";

/* On the CPU these would be functions; a table of lights only asks whether there are any. */
static void no_shape(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    (void)user, (void)time, (void)x, (void)position, (void)normal, (void)area;
}
static void no_emission(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)user, (void)time, (void)x, (void)direction, (void)rgb;
}

/* ---- a torus and a floor ---- */

static float positions[3 * VERTICES], normals[3 * VERTICES];
static uint32_t indices[INDICES], vertex_array;

static void make_scene(glbk_context *gl)
{
    static const float corners[4][2] = { { -6, -6 }, { 6, -6 }, { -6, 6 }, { 6, 6 } };
    static const uint32_t floor_indices[6] = { 0, 2, 1, 1, 2, 3 };
    glbk_buffer buffers[3];
    uint32_t i, j, k = 0;

    for (i = 0; i < RINGS; i++)
        for (j = 0; j < SIDES; j++) {
            const float a = 6.2831853f * (float)i / RINGS, b = 6.2831853f * (float)j / SIDES;
            const uint32_t v = i * SIDES + j, next = (i + 1) % RINGS * SIDES, up = (j + 1) % SIDES;
            float *n = normals + 3 * v, *p = positions + 3 * v;
            n[0] = cosf(b) * cosf(a), n[1] = sinf(b), n[2] = cosf(b) * sinf(a);
            p[0] = 0.6f * cosf(a) + 0.25f * n[0], p[1] = 0.25f * n[1] + 0.5f, p[2] = 0.6f * sinf(a) + 0.25f * n[2];
            indices[k++] = v, indices[k++] = i * SIDES + up, indices[k++] = next + up;
            indices[k++] = v, indices[k++] = next + up, indices[k++] = next + j;
        }
    for (i = 0; i < 4; i++) {
        const uint32_t v = 3 * (RINGS * SIDES + i);
        positions[v] = corners[i][0], positions[v + 2] = corners[i][1], normals[v + 1] = 1;
    }
    for (i = 0; i < 6; i++) indices[k++] = RINGS * SIDES + floor_indices[i];
    gl->gl.GenVertexArrays(1, &vertex_array);
    if (glbk_buffer_create(gl, sizeof positions, positions, &buffers[0]) != GLBK_OK ||
        glbk_buffer_create(gl, sizeof normals, normals, &buffers[1]) != GLBK_OK ||
        glbk_buffer_create(gl, sizeof indices, indices, &buffers[2]) != GLBK_OK)
        return;
    gl->gl.BindVertexArray(vertex_array);
    for (i = 0; i < 2; i++) {
        gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, buffers[i].name);
        gl->gl.EnableVertexAttribArray(i);
        gl->gl.VertexAttribPointer(i, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    }
    gl->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, buffers[2].name);
}

static glbk_result make_maps(glbk_context *gl, glbk_csm_maps *out)
{
    cohsm_mesh mesh = { positions, RINGS * SIDES, 0, indices, INDICES - 6, NULL, NULL, NULL };
    glbk_csm_instance instance = { 0 };
    glbk_csm_block block;
    cohsm_desc desc = { 0 };
    cohsm_maps *maps;
    glbk_result result;
    desc.domain.side[0] = desc.domain.side[1] = 64;
    if (cohsm_build(&desc, &mesh, &maps, NULL) != COHSM_OK) return GLBK_ERR_INPUT;
    block.data = cohsm_data(maps, &block.bytes);
    instance.offset = 0.01f;
    result = glbk_csm_maps_create(gl, &block, 1, 1, &instance.start, out);
    if (result == GLBK_OK) result = glbk_csm_maps_place(gl, out, &instance, 1);
    cohsm_free(maps);
    return result;
}

static glbk_result make_lamp(glbk_context *gl, glbk_csm_lights *out, glbk_csm_use *use)
{
    glbk_csm_lights_desc desc = { 0 };
    lsamp_light_desc lamp = { 0 };
    lamp.kind = use->kind = LSAMP_LIGHT_CALLBACK;
    lamp.shape_fn = no_shape;
    lamp.emission_fn = no_emission;
    lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 12;
    desc.lights = &lamp;
    desc.light_count = 1;
    desc.own = 1;
    use->ask = COHSM_LIGHT_POSITION;
    use->sample_count = 64;
    return glbk_csm_lights_create(gl, &desc, &use->start, out);
}

/* ---- a frame ---- */

typedef struct scene {
    glbk_gbuffer seen;
    glbk_csm_maps maps;
    glbk_csm_lights lights;
    glbk_csm_renderer renderer;
    glbk_csm_use use;
    uint32_t frame;
} scene;

static glbk_result draw(glbk_context *gl, scene *s, float turned, const glbk_target *light)
{
    static const float eye[3] = { 0, 2.4f, 4.2f };
    /* looks down by an angle whose sine is 0.38 */
    static const float view[16] = { 1.3f, 0, 0, 0,  0, 1.924f, -0.3838f, -0.38f,  0, -0.7904f, -0.9343f, -0.925f,
                                    0, -1.2979f, 4.6442f, 4.797f };
    const glbk_pass pass = { light, { 0, 0, 0, 0 }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 } };
    glbk_surface torus = { 0 }, ground = { 0 };
    glbk_csm_frame_desc frame = { 0 };
    glbk_result result = glbk_gbuffer_begin(gl, &s->seen, view, eye);
    int k;

    if (result != GLBK_OK) return result;
    for (k = 0; k < 3; k++) torus.material.diffuse[k] = ground.material.diffuse[k] = 0.7f;
    torus.material.kind = LSAMP_MATERIAL_PHONG;
    for (k = 0; k < 3; k++) torus.material.specular[k] = 0.3f;
    torus.material.exponent = 60;
    torus.entity = 1;
    gl->gl.BindVertexArray(vertex_array);
    glbk_gbuffer_object(gl, &s->seen, &torus);
    gl->gl.DrawElements(GLBK_GL_TRIANGLES, INDICES - 6, GLBK_GL_UNSIGNED_INT, NULL);
    glbk_gbuffer_object(gl, &s->seen, &ground);
    gl->gl.DrawElements(GLBK_GL_TRIANGLES, 6, GLBK_GL_UNSIGNED_INT, (const void *)(4 * (uintptr_t)(INDICES - 6)));
    s->use.maps = &s->maps;
    s->use.own[0] = turned;
    frame.lights = &s->lights;
    frame.uses = &s->use;
    frame.use_count = 1;
    for (k = 0; k < 3; k++) frame.eye[k] = eye[k];
    frame.filter = COHSM_FILTER_ROULETTE;
    frame.frame = s->frame++;
    result = glbk_csm_render(gl, &s->renderer, &s->seen, &frame);
    return result == GLBK_OK ? glbk_csm_resolve(gl, &s->renderer, &s->seen, &pass, NULL) : result;
}

/* ---- from radiance to what a window shows ---- */

static const char tone[] =
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 light = glbk_unpack(texelFetch(glbk_source, ivec2(gl_FragCoord.xy), 0)).rgb;\n"
    "    color = vec4(pow(light / (1.0 + 0.3 * light), vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

typedef struct canvas { glbk_texture texture; glbk_target target; } canvas;

static glbk_result make_canvas(glbk_context *gl, glbk_format format, canvas *out)
{
    const glbk_texture_desc desc = { format, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    glbk_result result = glbk_texture_create(gl, &desc, &out->texture);
    to.color[0] = &out->texture;
    return result == GLBK_OK ? glbk_target_create(gl, &to, &out->target) : result;
}

/* target: of a picture, since what a window holds that is not shown is undefined; NULL = the window */
static glbk_result show(glbk_context *gl, glbk_program *program, const canvas *light, const glbk_target *target)
{
    const glbk_pass screen = {
        target, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    glbk_result result;
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, 0);         /* the window: passes have bound others */
    result = glbk_begin(gl, &screen, program);
    glbk_bind_texture(gl, GLBK_SLOT_glbk_source, &light->texture);
    glbk_draw_screen(gl);
    return result;
}

static int fail(const char *what, const char *why) { return fprintf(stderr, "%s: %s\n", what, why), 1; }

/* The library says here why a call of it failed. */
static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)glfwGetProcAddress(name);
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
    glbk_gbuffer_desc view = { WIDTH, HEIGHT, { 0, 1, -1, -1, NULL, NULL }, NULL };
    glbk_csm_renderer_desc size = { WIDTH, HEIGHT, 0, 0, lamp_glsl };
    glbk_source source = { NULL, tone, NULL, "base_bindings", NULL, NULL, { NULL }, { { 0, 0 } } };
    static scene s;
    glbk_desc desc = { 0 };
    glbk_context gl;
    glbk_program program;
    canvas light, picture;
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "a lamp of your own", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_gbuffer_create(&gl, &view, &s.seen) != GLBK_OK ||
        glbk_csm_renderer_create(&gl, &size, &s.renderer) != GLBK_OK ||
        glbk_program_compile(&gl, &source, &program) != GLBK_OK ||
        make_canvas(&gl, GLBK_FORMAT_COLOR, &light) != GLBK_OK ||
        make_canvas(&gl, GLBK_FORMAT_RGBA8, &picture) != GLBK_OK)
        return fail("OpenGL", "it does not work");
    make_scene(&gl);
    if (make_maps(&gl, &s.maps) != GLBK_OK || make_lamp(&gl, &s.lights, &s.use) != GLBK_OK)
        return fail("the lamp", "it cannot be made");
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        glbk_csm_reset(&s.renderer);                        /* the lamp has turned */
        if (draw(&gl, &s, count > 1 ? 0.4f : (float)glfwGetTime(), &light.target) != GLBK_OK ||
            show(&gl, &program, &light, count > 1 ? &picture.target : NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        if (count > 1) return save(&gl, &picture.target, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_target_free(&gl, &picture.target);
    glbk_texture_free(&gl, &picture.texture);
    glbk_target_free(&gl, &light.target);
    glbk_texture_free(&gl, &light.texture);
    glbk_program_free(&gl, &program);
    glbk_csm_renderer_free(&gl, &s.renderer);
    glbk_csm_lights_free(&gl, &s.lights);
    glbk_csm_maps_free(&gl, &s.maps);
    glbk_gbuffer_free(&gl, &s.seen);
    glbk_free(&gl);
    glfwTerminate();
    return 0;
}
