/* 09b_shadowfield_gl_passes.c - 09 as complete passes, with an object that shadows itself: a bowl turns above
   a floor, under a circling lamp. shadowfield.h computes the bowl's field, the lamp's, and what each vertex
   of the bowl sees past the bowl itself. Meshes are drawn into a G-buffer, the bowl once more with its own
   visibility; gl_shadowfield.h shades all pixels, and a lighting pass of your own multiplies the light by the
   colours.

   cc -O2 09b_shadowfield_gl_passes.c -lglfw -lm -o shadowfield_gl_passes && ./shadowfield_gl_passes
   ./shadowfield_gl_passes picture.ppm      one picture, no visible window; without a display: xvfb-run -a

   Escape ends it. */
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

enum { WIDTH = 640, HEIGHT = 400, BANDS = 4, COEFS = BANDS * BANDS };
enum { RINGS = 40, SIDES = 48, CORNERS = RINGS * SIDES };

/* ---- a bowl: its vertices are what GL draws, its fields are computed of the same ---- */

typedef struct vertex {
    float position[3];
    float normal[3];
    float self[COEFS];                              /* self-visibility x cosine */
} vertex;

static vertex   bowl[CORNERS];
static uint32_t bowl_indices[CORNERS * 6];
static const vertex floor_corners[4] = {
    { { -6, 0, -6 }, { 0, 1, 0 }, { 0 } }, { { -6, 0, 6 }, { 0, 1, 0 }, { 0 } },
    { { 6, 0, -6 }, { 0, 1, 0 }, { 0 } }, { { 6, 0, 6 }, { 0, 1, 0 }, { 0 } }
};

/* A thick half of a sphere, open above: ring j goes down its outer side and up its inner one. */
static void make_bowl(void)
{
    uint32_t i, j, k = 0;
    for (j = 0; j < RINGS; j++)
        for (i = 0; i < SIDES; i++) {
            const int inside = j >= RINGS / 2;
            float a = 1.5707963f * (float)(inside ? RINGS - 1 - j : j) / (RINGS / 2 - 1);
            float b = 6.2831853f * (float)i / SIDES, radius = inside ? 0.85f : 1;
            vertex *v = &bowl[j * SIDES + i];
            uint32_t i2 = (i + 1) % SIDES, j2 = (j + 1) % RINGS;
            v->normal[0] = cosf(a) * cosf(b);
            v->normal[1] = -sinf(a);
            v->normal[2] = cosf(a) * sinf(b);
            for (int c = 0; c < 3; c++) {
                v->position[c] = radius * v->normal[c];
                if (inside) v->normal[c] = -v->normal[c];
            }
            if (j == 0 || j == RINGS - 1) v->normal[0] = v->normal[2] = 0, v->normal[1] = 1;    /* the rim */
            const uint32_t corner[6] = { j * SIDES + i, j * SIDES + i2, j2 * SIDES + i2,
                                         j * SIDES + i, j2 * SIDES + i2, j2 * SIDES + i };
            for (int c = 0; c < 6; c++) bowl_indices[k++] = corner[c];
        }
}

/* The field of what the bowl hides of others, and for each of its vertices what it hides of itself. */
static sfield_field *build_bowl(void)
{
    const sfield_mesh mesh = { bowl[0].position, CORNERS, sizeof *bowl, bowl_indices, CORNERS * 6, NULL, NULL, NULL };
    static float coefs[CORNERS][COEFS];
    sfield_desc desc;
    sfield_points points;
    sfield_field *field = NULL, *self = NULL;
    int i;
    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.bands = BANDS;
    desc.position_side = 12;                        /* 16 by default; this takes half the time */
    points.count = CORNERS;
    points.positions = bowl[0].position;
    points.normals = bowl[0].normal;
    points.position_stride = points.normal_stride = sizeof *bowl;
    if (sfield_build_self(&desc, &mesh, &points, 0.002f, &self, NULL) != SFIELD_OK ||
        sfield_self(self, 0, CORNERS, coefs[0]) != SFIELD_OK)
        return NULL;
    for (i = 0; i < CORNERS; i++) memcpy(bowl[i].self, coefs[i], sizeof coefs[i]);
    sfield_free(self);
    return sfield_build(&desc, &mesh, &field, NULL) == SFIELD_OK ? field : NULL;
}

static sfield_field *make_lamp(void)
{
    const sfield_emitter lamp = { SFIELD_EMITTER_SPHERE, 0.6f, { 0 }, { 0 }, { 0 },
                                  { 60, 55, 45 },        0,    NULL,  NULL };
    sfield_field *field = NULL;
    sfield_build_emitter(NULL, &lamp, &field, NULL);
    return field;
}

/* ---- a renderer of our own ---- */

/* The lighting pass: light times colour. */
static const char fragment[] =
    "uniform glbk_color_sampler glbk_user0;              // renderer.light\n"
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    glbk_point p;\n"
    "    color = vec4(0.02, 0.03, 0.05, 1.0);\n"
    "    if (!glbk_read_point(at, p)) return;\n"
    "    vec3 light = max(glbk_unpack(texelFetch(glbk_user0, at, 0)).rgb, 0.0) + 0.01;\n"
    "    color.rgb = pow(p.diffuse * light, vec3(1.0 / 2.2));\n"
    "}\n";

typedef struct stage {
    glbk_context         gl;
    glbk_sfield_scene    scene;
    glbk_sfield_renderer renderer;
    glbk_gbuffer         seen;
    glbk_program         light;
    glbk_texture         texture;
    glbk_target target; /* of a picture: windows that are not shown have no pixels */
    uint32_t             arrays[2], buffers[3];     /* floor, bowl; their vertices, the bowl's indices */
    sfield_field        *fields[2];                 /* bowl, lamp */
} stage;

/* Position and normal, and self-visibility where renderers of gl_shadowfield.h look for it. */
static void make_arrays(stage *s)
{
    glbk_functions *gl = &s->gl.gl;
    gl->GenVertexArrays(2, s->arrays);
    gl->GenBuffers(3, s->buffers);
    for (int i = 0; i < 2; i++) {
        gl->BindVertexArray(s->arrays[i]);
        gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s->buffers[i]);
        gl->BufferData(GLBK_GL_ARRAY_BUFFER, i ? (ptrdiff_t)sizeof bowl : (ptrdiff_t)sizeof floor_corners,
                       i ? bowl : floor_corners, GLBK_GL_STATIC_DRAW);
        for (uint32_t k = 0; k < 6; k++) {          /* 0 and 1: position, normal; 4 to 7: self-visibility */
            const size_t at = k < 2 ? 12 * (size_t)k : 24 + 16 * (size_t)(k - 2);
            gl->EnableVertexAttribArray(k < 2 ? k : k + 2);
            gl->VertexAttribPointer(k < 2 ? k : k + 2, k < 2 ? 3 : 4, GLBK_GL_FLOAT, 0, sizeof(vertex),
                                    (const void *)at);
        }
    }
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, s->buffers[2]);
    gl->BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, sizeof bowl_indices, bowl_indices, GLBK_GL_STATIC_DRAW);
    gl->BindVertexArray(0);
}

static void draw_bowl(stage *s)
{
    s->gl.gl.BindVertexArray(s->arrays[1]);
    s->gl.gl.DrawElements(GLBK_GL_TRIANGLES, CORNERS * 6, GLBK_GL_UNSIGNED_INT, NULL);
}

/* What the camera sees: the floor, which is entity 0, and the bowl, which is entity 1. */
static glbk_result draw_gbuffer(stage *s, const float bowl_to_world[16])
{
    /* A camera at 0 4.5 8 that looks down a little, half a picture wide at 0.8 of the distance. */
    static const float eye[3] = { 0, 4.5f, 8 }, down = 0.44f, near_z = 1, far_z = 30;
    const float c = cosf(down), d = sinf(down), a = (far_z + near_z) / (near_z - far_z);
    const float f = 2 * far_z * near_z / (near_z - far_z), y = -c * eye[1] + d * eye[2],
                z = -d * eye[1] - c * eye[2];
    const float clip[16] = { 1.25f, 0,      0,     0,  0, 2 * c, a * d,     -d,
                             0,     -2 * d, a * c, -c, 0, 2 * y, a * z + f, -z };
    glbk_surface ground, thing;
    glbk_result result;
    memset(&ground, 0, sizeof ground);
    for (int i = 0; i < 3; i++) ground.material.diffuse[i] = 0.8f;
    thing = ground;
    memcpy(thing.transform, bowl_to_world, sizeof thing.transform);
    thing.material.diffuse[2] = 0.5f;
    thing.entity = 1;
    result = glbk_gbuffer_begin(&s->gl, &s->seen, clip, eye);
    if (result == GLBK_OK) result = glbk_gbuffer_object(&s->gl, &s->seen, &ground);
    if (result != GLBK_OK) return result;
    s->gl.gl.BindVertexArray(s->arrays[0]);
    s->gl.gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
    result = glbk_gbuffer_object(&s->gl, &s->seen, &thing);
    if (result != GLBK_OK) return result;
    draw_bowl(s);
    /* The bowl once more, for its self-visibility. */
    result = glbk_sfield_self_begin(&s->gl, &s->renderer, &s->seen);
    if (result == GLBK_OK) result = glbk_sfield_self_object(&s->gl, &s->renderer, thing.transform);
    if (result == GLBK_OK) draw_bowl(s);
    return result;
}

static glbk_result frame(stage *s, float time, const glbk_target *target)
{
    const glbk_pass screen = {
        target, { 0, 0, WIDTH, HEIGHT }, GLBK_DEPTH_OFF, GLBK_BLEND_OFF, GLBK_CULL_OFF, 0, { 0, 0 }
    };
    sfield_entity entities[2];
    glbk_result result;
    float *m = entities[0].transform;
    memset(entities, 0, sizeof entities);
    m[15] = 1;
    m[0] = 2;                                       /* a rotation about x, twice as large */
    m[5] = m[10] = 2 * cosf(0.5f * sinf(time));
    m[6] = 2 * sinf(0.5f * sinf(time));
    m[9] = -m[6];
    m[13] = 2.2f;
    entities[0].occlusion = s->fields[0];
    entities[1].source = s->fields[1];
    for (int i = 0; i < 4; i++) entities[1].transform[5 * i] = 1;
    entities[1].transform[12] = 4 * cosf(0.7f * time);
    entities[1].transform[13] = 5;
    entities[1].transform[14] = 4 * sinf(0.7f * time);
    for (int i = 0; i < 3; i++) entities[0].tint[i] = entities[1].tint[i] = 1;
    result = glbk_sfield_scene_entities(&s->gl, &s->scene, entities, 2);
    if (result == GLBK_OK) result = draw_gbuffer(s, m);
    if (result == GLBK_OK) result = glbk_sfield_shade(&s->gl, &s->renderer, &s->seen, &s->scene, NULL, 0);
    if (result == GLBK_OK) result = glbk_begin(&s->gl, &screen, &s->light);
    if (result == GLBK_OK) result = glbk_gbuffer_bind(&s->gl, &s->seen, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(&s->gl, GLBK_SLOT_glbk_user0, &s->renderer.light);
    glbk_draw_screen(&s->gl);
    return GLBK_OK;
}

static glbk_result create(stage *s, const sfield_algebra *algebra)
{
    const glbk_texture_desc picture = {
        GLBK_FORMAT_RGBA8, WIDTH, HEIGHT, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL
    };
    const glbk_gbuffer_desc sizes = { WIDTH, HEIGHT, { 0, 1, -1, -1, NULL, NULL }, NULL };
    glbk_sfield_scene_desc scene;
    glbk_sfield_renderer_desc renderer;
    glbk_source source;
    glbk_target_desc target;
    glbk_result result;
    memset(&scene, 0, sizeof scene);
    memset(&renderer, 0, sizeof renderer);
    memset(&source, 0, sizeof source);
    memset(&target, 0, sizeof target);
    scene.algebra = renderer.algebra =
        algebra; /* tables that the GPU's product is made from, and rotations */
    scene.fields = (const sfield_field *const *)s->fields;
    scene.field_count = scene.entity_capacity = 2;
    renderer.width = WIDTH;
    renderer.height = HEIGHT;
    renderer.self = 1;
    source.parts[0] = glbk_gbuffer_part();
    source.uses = "gbuffer";
    source.fragment = fragment;
    target.color[0] = &s->texture;
    result = glbk_sfield_scene_create(&s->gl, &scene, &s->scene);
    if (result == GLBK_OK) result = glbk_sfield_renderer_create(&s->gl, &renderer, &s->renderer);
    if (result == GLBK_OK) result = glbk_gbuffer_create(&s->gl, &sizes, &s->seen);
    if (result == GLBK_OK) result = glbk_program_compile(&s->gl, &source, &s->light);
    if (result == GLBK_OK) result = glbk_texture_create(&s->gl, &picture, &s->texture);
    if (result == GLBK_OK) result = glbk_target_create(&s->gl, &target, &s->target);
    if (result == GLBK_OK) make_arrays(s);
    return result;
}

static void destroy(stage *s)
{
    s->gl.gl.DeleteVertexArrays(2, s->arrays);
    s->gl.gl.DeleteBuffers(3, s->buffers);
    glbk_target_free(&s->gl, &s->target);
    glbk_texture_free(&s->gl, &s->texture);
    glbk_program_free(&s->gl, &s->light);
    glbk_gbuffer_free(&s->gl, &s->seen);
    glbk_sfield_renderer_free(&s->gl, &s->renderer);
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
    int x, y, c;
    if (glbk_target_read(&s->gl, &s->target, 0, 0, 0, WIDTH, HEIGHT, rgba) != GLBK_OK)
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
    static stage s;
    sfield_algebra *algebra;
    glbk_desc desc = { 0 };
    GLFWwindow *window;

    make_bowl();
    s.fields[0] = build_bowl();
    s.fields[1] = make_lamp();
    if (!s.fields[0] || !s.fields[1] || sfield_algebra_create(BANDS, NULL, &algebra) != SFIELD_OK)
        return fail("shadowfield", "a field cannot be built");
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
    if (glbk_init(&s.gl, &desc) != GLBK_OK || create(&s, algebra) != GLBK_OK)
        return fail("OpenGL", "it does not work");

    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        if (frame(&s, count > 1 ? 0.5f : (float)glfwGetTime(), count > 1 ? &s.target : NULL) != GLBK_OK)
            return fail("OpenGL", "it does not work");
        if (count > 1) return save(&s, values[1]) || glbk_check(&s.gl) != GLBK_OK;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    destroy(&s);
    sfield_algebra_free(algebra);
    glfwTerminate();
    return 0;
}
