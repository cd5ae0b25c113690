/* 09_shadowfield_gl_minimal.c - soft shadows of moving objects from a moving lamp in a shader of your own:
   shadowfield.h computes a field of the object and one of the lamp, once; gl_shadowfield.h brings both to the GPU, and
   the fragment shader below asks for light by sfield_shade().

   cc -O2 09_shadowfield_gl_minimal.c -lglfw -lm -o shadowfield_gl_minimal && ./shadowfield_gl_minimal   Escape ends it
   ./shadowfield_gl_minimal picture.ppm             one picture, no visible window; without a display: xvfb-run -a */
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_SHADOWFIELD_IMPLEMENTATION
#include "gl_backend/gl_shadowfield.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 400, RINGS = 40, SIDES = 20, TORI = 3, BANDS = 4 };

/* ---- fields: a torus, and a lamp ---- */

static sfield_field *make_torus(void)
{
    static float    positions[RINGS * SIDES * 3];
    static uint32_t indices[RINGS * SIDES * 6];
    sfield_mesh mesh = { positions, RINGS * SIDES, 0, indices, RINGS * SIDES * 6, NULL, NULL, NULL };
    sfield_desc desc;
    sfield_field *field = NULL;
    uint32_t i, j, k = 0;
    for (i = 0; i < RINGS; i++)
        for (j = 0; j < SIDES; j++) {
            float a = 6.2831853f * (float)i / RINGS, b = 6.2831853f * (float)j / SIDES;
            float *p = positions + 3 * (i * SIDES + j);
            uint32_t i2 = (i + 1) % RINGS, j2 = (j + 1) % SIDES;
            p[0] = (1 + 0.35f * cosf(b)) * cosf(a);
            p[1] = 0.35f * sinf(b);
            p[2] = (1 + 0.35f * cosf(b)) * sinf(a);
            indices[k++] = i * SIDES + j, indices[k++] = i * SIDES + j2, indices[k++] = i2 * SIDES + j2;
            indices[k++] = i * SIDES + j, indices[k++] = i2 * SIDES + j2, indices[k++] = i2 * SIDES + j;
        }
    memset(&desc, 0, sizeof desc);
    desc.position_side = 12;                    /* 16 by default; this takes half the time */
    sfield_build(&desc, &mesh, &field, NULL);
    return field;
}

static sfield_field *make_lamp(void)
{
    sfield_emitter lamp = { SFIELD_EMITTER_SPHERE, 0.6f, { 0 }, { 0 }, { 0 }, { 60, 55, 45 }, 0, NULL, NULL };
    sfield_field *field = NULL;
    sfield_build_emitter(NULL, &lamp, &field, NULL);
    return field;
}

/* ---- a renderer of our own: it marches along the ray of a pixel ---- */

static const char fragment[] =
    "uniform vec4 tori[3];                               // place, and the angle about x\n"
    "layout(location = 0) out vec4 color;\n"
    "vec3 about_x(vec3 p, float a) { return vec3(p.x, cos(a) * p.y - sin(a) * p.z, cos(a) * p.z + sin(a) * p.y); }\n"
    "float torus(vec3 q) { return length(vec2(length(q.xz) - 1.0, q.y)) - 0.35; }\n"
    "void main()\n"
    "{\n"
    "    vec3 ray = normalize(vec3((gl_FragCoord.x - 320.0) / 400.0, gl_FragCoord.y / 400.0 - 1.05, -1.2));\n"
    "    vec3 p = vec3(0.0, 4.5, 8.0), n = vec3(0.0, 1.0, 0.0), q;\n"
    "    float d = 1.0, t[SFIELD_COEFS];\n"
    "    uint entity = 0u;                               // that is hit, from 1; 0: the floor\n"
    "    for (int i = 0; i < 200 && d > 1e-3; i++) {\n"
    "        d = p.y;\n"
    "        entity = 0u;\n"
    "        for (uint k = 0u; k < 3u; k++) {\n"
    "            float near = torus(about_x(p - tori[k].xyz, -tori[k].w));\n"
    "            if (near < d) entity = k + 1u;\n"
    "            d = min(d, near);\n"
    "        }\n"
    "        p += d * ray;\n"
    "    }\n"
    "    color = vec4(0.02, 0.03, 0.05, 1.0);\n"
    "    if (d > 1e-3) return;\n"
    "    if (entity > 0u) {\n"
    "        q = about_x(p - tori[entity - 1u].xyz, -tori[entity - 1u].w);\n"
    "        n = about_x(normalize(q - vec3(normalize(q.xz), 0.0).xzy), tori[entity - 1u].w);\n"
    "    }\n"
    "    sfield_cosine(n, t);                            // sfield_self has visibility by the object itself, too\n"
    "    sfield_sums sums = sfield_shade(p, n, entity, t, t);\n"
    "    vec3 light = max(sums.light, 0.0) + 0.02;\n"
    "    color.rgb = pow((entity > 0u ? vec3(0.9, 0.6, 0.4) : vec3(0.8)) * light, vec3(1.0 / 2.2));\n"
    "}\n";

static int32_t tori_at;                         /* location of the uniform */

/* Three tori that tumble, and the lamp that circles over them. */
static glbk_result frame(glbk_context *gl, sfield_field *const *fields, glbk_sfield_scene *scene,
                         glbk_program *program, float time, const glbk_target *target)
{
    static const float places[TORI][3] = { { -2.2f, 1.6f, 0.4f }, { 1.8f, 1.7f, -1.5f }, { 0.8f, 1.5f, 2 } };
    const glbk_pass screen = {
        target, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    sfield_entity entities[TORI + 1];
    float tori[TORI][4];
    glbk_result result;
    int i;
    memset(entities, 0, sizeof entities);
    for (i = 0; i <= TORI; i++) {
        float *m = entities[i].transform;
        float a = i < TORI ? (1 + 0.3f * (float)i) * time : 0;
        m[0] = m[15] = 1;
        m[5] = m[10] = cosf(a);
        m[6] = sinf(a);
        m[9] = -sinf(a);
        memcpy(m + 12, i < TORI ? places[i] : (float[3]) { 4 * cosf(time), 5, 4 * sinf(time) }, 3 * sizeof *m);
        entities[i].tint[0] = entities[i].tint[1] = entities[i].tint[2] = 1;
        if (i == TORI) entities[i].source = fields[1];
        else {
            memcpy(tori[i], places[i], sizeof places[i]);
            tori[i][3] = a;
            entities[i].occlusion = fields[0];
        }
    }
    result = glbk_sfield_scene_entities(gl, scene, entities, TORI + 1);
    if (result == GLBK_OK) result = glbk_begin(gl, &screen, program);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(gl, scene, NULL);
    gl->gl.Uniform4fv(tori_at, TORI, tori[0]);
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
    sfield_field *fields[2] = { make_torus(), make_lamp() };
    sfield_algebra *algebra;
    glbk_desc desc = { 0 };
    glbk_context gl;
    glbk_sfield_scene_desc up = { NULL, (const sfield_field *const *)fields, 2, TORI + 1, 0, NULL };
    glbk_sfield_scene scene;
    glbk_source source = { NULL, fragment, NULL, "sfield_shade", "SFIELD_BANDS=4", NULL, { glbk_sfield_part() },
                           { { 0, 0 } } };
    glbk_program program;
    glbk_texture texture = { 0 };
    glbk_target target = { 0 };
    GLFWwindow *window;

    if (!fields[0] || !fields[1] || sfield_algebra_create(BANDS, NULL, &algebra) != SFIELD_OK)
        return fail("shadowfield", "a field cannot be built");
    up.algebra = algebra;                       /* tables that the GPU's product is made from, and rotations */
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
    window = glfwCreateWindow(WIDTH, HEIGHT, "shadow fields", NULL, NULL);
    if (!window) return fail("GLFW", "no OpenGL 3.3");
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    desc.get_proc_fn = get_proc;
    desc.system.log = say;
    if (glbk_init(&gl, &desc) != GLBK_OK || glbk_sfield_scene_create(&gl, &up, &scene) != GLBK_OK ||
        glbk_program_compile(&gl, &source, &program) != GLBK_OK ||
        (count > 1 && make_target(&gl, &texture, &target) != GLBK_OK))
        return fail("OpenGL", "it does not work");
    tori_at = gl.gl.GetUniformLocation(program.name, "tori");

    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (frame(&gl, fields, &scene, &program, count > 1 ? 0.7f : (float)glfwGetTime(),
                  count > 1 ? &target : NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        if (count > 1) return save(&gl, &target, values[1]) || glbk_check(&gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    glbk_sfield_scene_free(&gl, &scene);
    sfield_algebra_free(algebra);
    sfield_free(fields[0]);
    sfield_free(fields[1]);
    glbk_program_free(&gl, &program);
    glbk_target_free(&gl, &target);
    glbk_texture_free(&gl, &texture);
    glbk_free(&gl);
    glfwTerminate();
    return 0;
}
