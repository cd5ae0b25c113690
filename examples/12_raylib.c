/* 12_raylib.c - a sky's soft shadows in a program of raylib: raylib has the window, the camera, the meshes and the
   rest of the picture; envlights.h turns the sky into lights, gl_envshadow.h draws their shadow maps with raylib's own
   vertex arrays, and a shader with envsh_light() lights the meshes within raylib's frame, beside what raylib draws.

   cc -O2 12_raylib.c -lraylib -lm -o raylib_shadows && ./raylib_shadows            Escape ends it
   --mesh FILE         a model that raylib can load (.glb, .gltf, .obj, .iqm) in place of a knot
   --lights N          that stand for the sky, 1..300 (100)
   --frames N          ends after so many frames, which turn by equal steps; no visible window
   --screenshot FILE   of the last of these frames, by raylib's ExportImage: .png, .bmp, ...

   raylib 4.5 or newer, on OpenGL 3.3 or ES 3.0; no other file of it is changed. */
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_ENVSHADOW_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#include "gl_backend/gl_envshadow.h"

#include <raylib.h>
#include <rlgl.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 800, HEIGHT = 500, MAP = 128, MOST_MESHES = 64, SKY_WIDTH = 128, SKY_HEIGHT = 64 };

/* ---- what is drawn: raylib's meshes, which keep their vertices in memory as well ---- */

typedef struct object {
    Mesh  mesh;
    float transform[16];                /* column-major, as GL has it */
    float albedo[3];
    int   casts;
} object;

typedef struct scene {
    object   objects[MOST_MESHES];
    uint32_t count;
    Model    model;                     /* of --mesh: its meshes are among the objects */
    float    lift, scale;               /* brings the model onto the floor, and to about the size of the knot */
} scene;

static object *add_object(scene *s, Mesh mesh, float r, float g, float b)
{
    object *o = &s->objects[s->count++];
    memset(o, 0, sizeof *o);
    o->mesh = mesh;
    o->transform[0] = o->transform[5] = o->transform[10] = o->transform[15] = 1;
    o->albedo[0] = r;
    o->albedo[1] = g;
    o->albedo[2] = b;
    o->casts = 1;
    return o;
}

static void place(object *o, float x, float y, float z, float scale, float angle)
{
    float c = scale * cosf(angle), n = scale * sinf(angle);
    const float transform[16] = { c, 0, -n, 0, 0, scale, 0, 0, n, 0, c, 0, x, y, z, 1 };
    memcpy(o->transform, transform, sizeof transform);
}

static envsh_mesh mesh_of(const Mesh *m)
{
    envsh_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = m->vertices;
    mesh.vertex_count = (size_t)m->vertexCount;
    mesh.indices16 = m->indices;
    mesh.index_count = m->indices ? 3 * (size_t)m->triangleCount : 0;
    return mesh;
}

/* 0: it is there. */
static int make_scene(scene *s, const char *path)
{
    object *floor;
    memset(s, 0, sizeof *s);
    s->scale = 1;
    if (path) {
        envsh_bounds all = { { 1e30f, 1e30f, 1e30f }, { -1e30f, -1e30f, -1e30f } };
        float size = 0;
        int i, k;
        if (!FileExists(path)) return 1;        /* some versions of raylib take a cube then */
        s->model = LoadModel(path);
        if (s->model.meshCount < 1 || s->model.meshCount > MOST_MESHES - 2) return 1;
        for (i = 0; i < s->model.meshCount; i++) {
            envsh_mesh mesh = mesh_of(&s->model.meshes[i]);
            envsh_bounds one = envsh_bounds_of(&mesh, 1, NULL);
            for (k = 0; k < 3; k++) {
                all.low[k] = fminf(all.low[k], one.low[k]);
                all.high[k] = fmaxf(all.high[k], one.high[k]);
                size = fmaxf(size, all.high[k] - all.low[k]);
            }
            add_object(s, s->model.meshes[i], 0.85f, 0.65f, 0.45f);
        }
        if (!(size > 0)) return 1;
        s->scale = 3.2f / size;
        s->lift = -all.low[1] * s->scale;
    } else {
        add_object(s, GenMeshKnot(1, 2, 24, 160), 0.85f, 0.55f, 0.35f);
        s->lift = 1.6f;
    }
    place(add_object(s, GenMeshSphere(0.6f, 24, 32), 0.5f, 0.7f, 0.85f), 2.6f, 0.6f, 1.2f, 1, 0);
    floor = add_object(s, GenMeshPlane(14, 14, 1, 1), 0.8f, 0.8f, 0.8f);
    place(floor, 0, -0.01f, 0, 1, 0);           /* raylib's grid lies at 0 */
    floor->casts = 0;
    return 0;
}

static void turn(scene *s, float angle)
{
    uint32_t i, turning = s->model.meshCount > 0 ? (uint32_t)s->model.meshCount : 1;
    for (i = 0; i < turning; i++) place(&s->objects[i], 0, s->lift, 0, s->scale, angle);
}

static void free_scene(scene *s)
{
    uint32_t i, of_model = s->model.meshCount > 0 ? (uint32_t)s->model.meshCount : 0;
    if (of_model) UnloadModel(s->model);
    for (i = of_model; i < s->count; i++) UnloadMesh(s->objects[i].mesh);
}

/* ---- the sky: blue, with a low sun ---- */

static envlt_lights *make_lights(uint32_t count)
{
    static float sky[3 * SKY_WIDTH * SKY_HEIGHT];
    envlt_map map;
    envlt_desc desc;
    envlt_lights *lights = NULL;
    uint32_t i;
    memset(&map, 0, sizeof map);
    memset(&desc, 0, sizeof desc);
    map.projection = ENVLT_PROJECTION_LATLONG;
    map.width = SKY_WIDTH;
    map.height = SKY_HEIGHT;
    map.rgb = sky;
    for (i = 0; i < SKY_WIDTH * SKY_HEIGHT; i++) {
        float d[3], *rgb = sky + 3 * i, glow;
        envlt_texel_direction(ENVLT_PROJECTION_LATLONG, SKY_WIDTH, SKY_HEIGHT, 0, (float)(i % SKY_WIDTH) + 0.5f,
                              (float)(i / SKY_WIDTH) + 0.5f, d);
        glow = 0.55f * d[0] + 0.62f * d[1] + 0.56f * d[2] > 0.995f ? 60.0f : 0.0f;
        rgb[0] = d[1] < 0 ? 0.1f : 0.3f + glow;
        rgb[1] = d[1] < 0 ? 0.1f : 0.4f + 0.9f * glow;
        rgb[2] = d[1] < 0 ? 0.1f : 0.6f + 0.7f * glow;
    }
    desc.light_count = count;
    return envlt_create(&desc, &map, &lights, NULL) == ENVLT_OK ? lights : NULL;
}

/* ---- drawing with raylib's vertex arrays: attribute 0 is the position, 2 the normal (rlgl.h has the list) ---- */

static const char vertex[] =
    "layout(location = 0) in vec3 vertex_position;\n"
    "layout(location = 2) in vec3 vertex_normal;\n"
    "uniform mat4 transform, view, projection;\n"
    "out vec3 place, normal;\n"
    "void main()\n"
    "{\n"
    "    vec4 p = transform * vec4(vertex_position, 1.0);\n"
    "    place = p.xyz;\n"
    "    normal = mat3(transform) * vertex_normal;       // a scale along all axes alike\n"
    "    gl_Position = projection * (view * p);\n"
    "}\n";

static const char fragment[] =
    "in vec3 place, normal;\n"
    "uniform vec4 albedo, eye;\n"
    "layout(location = 0) out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), flat_n = normalize(cross(dFdx(place), dFdy(place)));\n"
    "    if (dot(flat_n, eye.xyz - place) < 0.0) flat_n = -flat_n;\n"
    "    if (dot(n, flat_n) < 0.0) n = -n;\n"
    "    vec3 light = envsh_light(place, n, flat_n, uint(gl_FragCoord.x) + 4096u * uint(gl_FragCoord.y));\n"
    "    color = vec4(pow(albedo.rgb * light / 3.14159, vec3(1.0 / 2.2)), 1.0);    // raylib's colours are encoded\n"
    "}\n";

typedef struct shadows {
    glbk_context    gl;
    glbk_envsh_maps maps;
    glbk_program    program;
    int32_t         transform, view, projection, albedo, eye;   /* locations */
    envsh_maps     *layout;
    envlt_lights   *lights;
} shadows;

static void draw_mesh(glbk_context *gl, const Mesh *m, uint32_t instances)
{
    gl->gl.BindVertexArray(m->vaoId);
    if (m->indices) gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, 3 * m->triangleCount, GLBK_GL_UNSIGNED_SHORT, NULL,
                                                 (int32_t)instances);
    else gl->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, m->vertexCount, (int32_t)instances);
}

/* Everything that throws shadows, each object by one call for many lights. */
static glbk_result draw_casters(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    const scene *s = (const scene *)user;
    uint32_t i;
    for (i = 0; i < s->count; i++) {
        glbk_result result;
        if (!s->objects[i].casts) continue;
        result = glbk_envsh_cast(gl, maps, s->objects[i].transform);
        if (result != GLBK_OK) return result;
        draw_mesh(gl, &s->objects[i].mesh, instances);
    }
    return GLBK_OK;
}

static glbk_result make_maps(shadows *g, scene *s)
{
    envsh_mesh meshes[MOST_MESHES];
    float transforms[MOST_MESHES][16];
    envsh_lights all;
    const envsh_view *views;
    const envlt_light *list;
    uint32_t count, casters = 0, i;
    for (i = 0; i < s->count; i++) {
        if (!s->objects[i].casts) continue;
        meshes[casters] = mesh_of(&s->objects[i].mesh);
        memcpy(transforms[casters++], s->objects[i].transform, sizeof transforms[0]);
    }
    list = envlt_get_lights(g->lights, &count);
    memset(&all, 0, sizeof all);
    all.count = count;
    all.directions = list->direction;
    all.irradiances = list->irradiance;
    all.axes_u = list->axis_u;
    all.axes_v = list->axis_v;
    all.stride = sizeof *list;
    if (envsh_maps_begin(g->layout, &all, envsh_bounds_of(meshes, casters, transforms[0])) != ENVSH_OK)
        return GLBK_ERR_ARGUMENT;
    views = envsh_views(g->layout, &count);
    return glbk_envsh_maps_render(&g->gl, &g->maps, views, count, draw_casters, s);
}

static void to_floats(Matrix m, float out[16])
{
    const float columns[16] = { m.m0, m.m1, m.m2,  m.m3,  m.m4,  m.m5,  m.m6,  m.m7,
                                m.m8, m.m9, m.m10, m.m11, m.m12, m.m13, m.m14, m.m15 };
    memcpy(out, columns, sizeof columns);
}

static glbk_result light_objects(shadows *g, const scene *s, Vector3 from)
{
    glbk_context *gl = &g->gl;
    glbk_pass pass;
    glbk_result result;
    float view[16], projection[16], eye[4], albedo[4] = { 0, 0, 0, 1 };
    uint32_t i;
    memset(&pass, 0, sizeof pass);              /* target NULL: the framebuffer that raylib draws to */
    pass.viewport[2] = GetRenderWidth();
    pass.viewport[3] = GetRenderHeight();
    pass.depth = GLBK_DEPTH_LESS_EQUAL;
    to_floats(rlGetMatrixModelview(), view);
    to_floats(rlGetMatrixProjection(), projection);
    eye[0] = from.x;
    eye[1] = from.y;
    eye[2] = from.z;
    eye[3] = 0;
    result = glbk_begin(gl, &pass, &g->program);
    if (result == GLBK_OK) result = glbk_envsh_bind(gl, &g->maps, NULL, NULL);
    if (result != GLBK_OK) return result;
    gl->gl.UniformMatrix4fv(g->view, 1, 0, view);
    gl->gl.UniformMatrix4fv(g->projection, 1, 0, projection);
    gl->gl.Uniform4fv(g->eye, 1, eye);
    for (i = 0; i < s->count; i++) {
        memcpy(albedo, s->objects[i].albedo, sizeof s->objects[i].albedo);
        gl->gl.UniformMatrix4fv(g->transform, 1, 0, s->objects[i].transform);
        gl->gl.Uniform4fv(g->albedo, 1, albedo);
        draw_mesh(gl, &s->objects[i].mesh, 1);
    }
    return GLBK_OK;
}

/* Within BeginMode3D: what raylib has collected is drawn first, and it finds GL's state as it has left it. Making the
   maps binds other framebuffers, so the state comes back between the two passes as well. */
static glbk_result draw_shadows(shadows *g, scene *s, Vector3 from)
{
    glbk_state state;
    glbk_result result;
    rlDrawRenderBatchActive();
    glbk_state_save(&g->gl, &state);
    result = make_maps(g, s);
    glbk_state_restore(&g->gl, &state);
    if (result == GLBK_OK) result = light_objects(g, s, from);
    glbk_state_restore(&g->gl, &state);
    return result;
}

/* ---- making and ending it ---- */

/* From raylib 6 on rlgl.h finds GL's functions; before, GLFW, which raylib has within it on desktops. */
#if RAYLIB_VERSION_MAJOR >= 6
static glbk_proc_fn get_proc(const char *name, void *user)
{
    void *found = rlGetProcAddress(name);
    glbk_proc_fn proc = NULL;
    (void)user;
    memcpy(&proc, &found, sizeof proc);
    return proc;
}
#else
extern glbk_proc_fn glfwGetProcAddress(const char *name);
static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return glfwGetProcAddress(name);
}
#endif

/* The library says here why a call of it failed. */
static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

/* 0: all is there. */
static int make_shadows(shadows *g, uint32_t lights)
{
    envsh_maps_desc layout;
    glbk_envsh_maps_desc maps;
    glbk_desc desc;
    glbk_source source;
    memset(g, 0, sizeof *g);
    memset(&layout, 0, sizeof layout);
    memset(&maps, 0, sizeof maps);
    memset(&desc, 0, sizeof desc);
    memset(&source, 0, sizeof source);
    layout.system.log = say;
    layout.map_side = MAP;
    layout.no_depth = 1;                        /* the GPU has it */
    g->lights = make_lights(lights);
    if (!g->lights || envsh_maps_create(&layout, lights, &g->layout) != ENVSH_OK) return 1;
    desc.system.log = say;
    desc.get_proc_fn = get_proc;
    maps.capacity = lights;
    maps.maps = &layout;
    source.vertex = vertex;
    source.fragment = fragment;
    source.uses = "envsh_light";
    source.defines = "ENVSH_FILTER=4 ENVSH_RGBA=0";
    source.parts[0] = glbk_envsh_part();
    if (glbk_init(&g->gl, &desc) != GLBK_OK || glbk_envsh_maps_create(&g->gl, &maps, &g->maps) != GLBK_OK ||
        glbk_program_compile(&g->gl, &source, &g->program) != GLBK_OK)
        return 1;
    g->transform = g->gl.gl.GetUniformLocation(g->program.name, "transform");
    g->view = g->gl.gl.GetUniformLocation(g->program.name, "view");
    g->projection = g->gl.gl.GetUniformLocation(g->program.name, "projection");
    g->albedo = g->gl.gl.GetUniformLocation(g->program.name, "albedo");
    g->eye = g->gl.gl.GetUniformLocation(g->program.name, "eye");
    return 0;
}

static void free_shadows(shadows *g)
{
    glbk_program_free(&g->gl, &g->program);
    glbk_envsh_maps_free(&g->gl, &g->maps);
    glbk_free(&g->gl);
    envsh_maps_free(g->layout);
    envlt_free(g->lights);
}

typedef struct options {
    const char *mesh, *screenshot;
    int         frames, lights;
} options;

/* 0: understood. */
static int read_options(int count, char **values, options *o)
{
    int i;
    memset(o, 0, sizeof *o);
    o->lights = 100;
    for (i = 1; i + 1 < count; i += 2) {
        if (strcmp(values[i], "--mesh") == 0) o->mesh = values[i + 1];
        else if (strcmp(values[i], "--screenshot") == 0) o->screenshot = values[i + 1];
        else if (strcmp(values[i], "--frames") == 0) o->frames = atoi(values[i + 1]);
        else if (strcmp(values[i], "--lights") == 0) o->lights = atoi(values[i + 1]);
        else return 1;
    }
    if (o->screenshot && o->frames < 1) o->frames = 1;
    return i != count || o->frames < 0 || o->lights < 1 || o->lights > 300;
}

static int run(const options *o, shadows *g, scene *s)
{
    Camera3D camera;
    int frame;
    memset(&camera, 0, sizeof camera);
    camera.position.x = 1;
    camera.position.y = 4;
    camera.position.z = 8;
    camera.target.y = 1;
    camera.up.y = 1;
    camera.fovy = 45;
    camera.projection = CAMERA_PERSPECTIVE;
    for (frame = 0; o->frames ? frame < o->frames : !WindowShouldClose(); frame++) {
        glbk_result result;
        turn(s, o->frames ? 0.05f * (float)frame : (float)GetTime() * 0.5f);
        BeginDrawing();
        ClearBackground(SKYBLUE);
        BeginMode3D(camera);
        DrawCube(camera.target, 0.3f, 3, 0.3f, MAROON);        /* raylib's own, before and after us: one depth buffer */
        result = draw_shadows(g, s, camera.position);
        DrawGrid(14, 1);
        EndMode3D();
        DrawRectangle(0, HEIGHT - 30, WIDTH, 30, DARKBLUE);
        DrawText(TextFormat("%d lights of a sky", o->lights), 10, HEIGHT - 25, 20, RAYWHITE);
        if (result == GLBK_OK) result = glbk_check(&g->gl);
        if (result != GLBK_OK) return fprintf(stderr, "OpenGL: %s\n", glbk_result_text(result)), 1;
        if (o->screenshot && frame + 1 == o->frames) {
            Image image;
            rlDrawRenderBatchActive();
            image = LoadImageFromScreen();
            ExportImage(image, o->screenshot);
            UnloadImage(image);
        }
        EndDrawing();
    }
    return 0;
}

int main(int count, char **values)
{
    static shadows g;
    static scene s;
    options o;
    int failed;
    if (read_options(count, values, &o))
        return fprintf(stderr, "%s [--mesh FILE] [--lights 1..300] [--frames N] [--screenshot FILE]\n", values[0]), 2;
    SetTraceLogLevel(LOG_WARNING);
    if (o.frames) SetConfigFlags(FLAG_WINDOW_HIDDEN);
    InitWindow(WIDTH, HEIGHT, "shadows of a sky in raylib");
    if (!IsWindowReady()) return fprintf(stderr, "raylib: there is no display\n"), 1;
    if (!o.frames) SetTargetFPS(60);
    failed = make_scene(&s, o.mesh);
    if (failed) fprintf(stderr, "%s: no model, or one of too many meshes\n", o.mesh);
    else failed = make_shadows(&g, (uint32_t)o.lights) || run(&o, &g, &s);
    free_shadows(&g);
    free_scene(&s);
    CloseWindow();
    return failed;
}
