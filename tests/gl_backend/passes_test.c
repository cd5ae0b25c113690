/* passes_test - all techniques in one context, one pass after the other, twice: every pass finds on its texture units
   what the others left there, and is drawn all the same; and once more after all were drawn at another size. A
   program of the user's shows the same with its part's slots moved by an offset. The watcher
   (examples/common/gl_watch.c) compares the kinds of samplers and textures at each draw, as browsers do; drivers do
   not. */
#define _POSIX_C_SOURCE 200809L
#include "envlights.h"
#include "envshadow.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_shadowfield.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"

#include "gl_test.h"
#include "sky_lights.h"

enum { SIDE = 8, PIXELS = SIDE * SIDE, LIGHTS = 4, POINTS = 64, CSM = 0, SFIELD, ENVSH, RSM, ISM, TECHNIQUES };
enum { WIDE = 3 * SIDE, HIGH = 2 * SIDE, MOST = WIDE * HIGH };     /* the other size */

static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
static const float eye[3] = { 4, 4, 4 };        /* from where all three walls are seen */
static const float view[16] = { 0.5f, -0.3f, -0.2f, 0, 0, 0.6f, -0.2f, 0, -0.5f, -0.3f, -0.2f, 0, 0, 0, 0, 1 };

/* What is seen in a turn: light of each technique's passes, what they resolve to, and pictures of a shader that calls
   one function of it. */
typedef struct turn {
    float light[TECHNIQUES][4 * MOST], bounced[4 * MOST], resolved[TECHNIQUES][4 * PIXELS];
    float own[TECHNIQUES][4 * PIXELS], visible[PIXELS];
} turn;

static struct {
    uint32_t    room;                   /* vertex array: three walls, places and normals */
    glbk_buffer corners;
    gl_canvas   screen;
    struct { glbk_csm_maps maps; glbk_csm_lights lights; glbk_csm_renderer renderer; glbk_csm_asker asker;
             glbk_gbuffer seen; uint32_t start; } csm;
    struct { sfield_algebra *algebra; glbk_sfield_scene scene; glbk_gbuffer gbuffer;
             glbk_sfield_renderer renderer; } sfield;
    struct { envlt_lights *lights; envsh_maps *layout; glbk_envsh_maps maps; glbk_envsh_renderer renderer;
        glbk_gbuffer seen; } envsh;
    struct { glbk_rsm_map map; glbk_rsm_renderer renderer; glbk_gbuffer seen; } rsm;
    struct { glbk_ism_maps maps; glbk_gbuffer seen; glbk_ism_renderer renderer; } ism;
    glbk_program own[2][TECHNIQUES];    /* the second with an offset */
} x;

static void draw_room(glbk_context *ctx, uint32_t instances)
{
    ctx->gl.BindVertexArray(x.room);
    ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, 18, (int32_t)instances);
}

static void make_room(gl_test *t)
{
    static const float u[6] = { -1, 1, 1, -1, 1, -1 }, v[6] = { -1, -1, 1, -1, 1, 1 };
    float corners[18][6] = { { 0 } };
    const glbk_functions *gl = &t->gl.gl;
    uint32_t i;
    for (i = 0; i < 18; i++) {
        corners[i][i / 6] = -1;
        corners[i][(i / 6 + 1) % 3] = u[i % 6];
        corners[i][(i / 6 + 2) % 3] = v[i % 6];
        corners[i][3 + i / 6] = 1;
    }
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof corners, corners, &x.corners));
    gl->GenVertexArrays(1, &x.room);
    gl->BindVertexArray(x.room);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, x.corners.name);
    for (i = 0; i < 2; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, 3, GLBK_GL_FLOAT, 0, sizeof corners[0], (const void *)(size_t)(12 * i));
    }
    gl->BindVertexArray(0);
    x.screen = gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 0);
}

static glbk_pass to_screen(void)
{
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.target = &x.screen.target;
    return pass;
}

static void read_screen(gl_test *t, float *out)
{
    assert_glbk(t, glbk_target_read(&t->gl, &x.screen.target, 0, 0, 0, SIDE, SIDE, out));
}

/* ---- csm: a sun, and no object that hides it ---- */

static void make_csm(gl_test *t)
{
    const glbk_csm_renderer_desc renderer = { SIDE, SIDE, 0, 0, NULL };
    const glbk_gbuffer_desc seen = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const float zeros[3 * PIXELS] = { 0 };
    cohsm_query questions;
    lsamp_light_desc light;
    glbk_csm_lights_desc lights;
    memset(&light, 0, sizeof light);
    memset(&lights, 0, sizeof lights);
    memset(&questions, 0, sizeof questions);
    questions.count = PIXELS;
    questions.positions = zeros;
    questions.lights = zeros;
    light.kind = LSAMP_LIGHT_SUN;
    light.direction[2] = 1;
    light.radiance[0] = 1;
    lights.lights = &light;
    lights.light_count = 1;
    assert_glbk(t, glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &x.csm.maps));
    assert_glbk(t, glbk_csm_lights_create(&t->gl, &lights, &x.csm.start, &x.csm.lights));
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &renderer, &x.csm.renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &seen, &x.csm.seen));
    assert_glbk(t, glbk_csm_asker_create(&t->gl, PIXELS, &x.csm.asker));
    assert_glbk(t, glbk_csm_ask_upload(&t->gl, &x.csm.asker, &questions));
}

static void run_csm(gl_test *t, turn *out)
{
    const glbk_pass pass = to_screen();
    glbk_csm_frame_desc frame;
    glbk_csm_use use;
    glbk_surface d;
    memset(&frame, 0, sizeof frame);
    memset(&use, 0, sizeof use);
    memset(&d, 0, sizeof d);
    memcpy(d.transform, unit, sizeof unit);
    d.material.kind = LSAMP_MATERIAL_LAMBERT;
    d.material.diffuse[0] = 0.5f;
    use.start = x.csm.start;
    use.kind = LSAMP_LIGHT_SUN;
    use.maps = &x.csm.maps;
    use.sample_count = 4;
    frame.lights = &x.csm.lights;
    frame.uses = &use;
    frame.use_count = 1;
    frame.bias = 1;
    memcpy(frame.eye, eye, sizeof eye);
    glbk_csm_reset(&x.csm.renderer);
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &x.csm.seen, view, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, &x.csm.seen, &d));
    draw_room(&t->gl, 1);
    assert_glbk(t, glbk_csm_render(&t->gl, &x.csm.renderer, &x.csm.seen, &frame));
    assert_glbk(t, glbk_csm_resolve(&t->gl, &x.csm.renderer, &x.csm.seen, &pass, NULL));
    read_screen(t, out->resolved[CSM]);
    assert_glbk(t, glbk_csm_read(&t->gl, &x.csm.renderer, out->light[CSM]));
    assert_glbk(t, glbk_csm_ask_run(&t->gl, &x.csm.asker, &x.csm.maps, PIXELS));
    assert_glbk(t, glbk_csm_ask_read(&t->gl, &x.csm.asker, PIXELS, out->visible));
}

static void destroy_csm(glbk_context *gl)
{
    glbk_csm_asker_free(gl, &x.csm.asker);
    glbk_csm_renderer_free(gl, &x.csm.renderer);
    glbk_gbuffer_free(gl, &x.csm.seen);
    glbk_csm_lights_free(gl, &x.csm.lights);
    glbk_csm_maps_free(gl, &x.csm.maps);
}

/* ---- sfield: an even sky ---- */

static void make_sfield(gl_test *t)
{
    static const float sky[3] = { 1, 2, 3 };
    glbk_sfield_scene_desc scene;
    glbk_sfield_renderer_desc renderer;
    glbk_gbuffer_desc gbuffer;
    memset(&gbuffer, 0, sizeof gbuffer);
    memset(&scene, 0, sizeof scene);
    memset(&renderer, 0, sizeof renderer);
    assert_int_equal(sfield_algebra_create(1, NULL, &x.sfield.algebra), SFIELD_OK);
    scene.algebra = renderer.algebra = x.sfield.algebra;
    scene.entity_capacity = 1;
    renderer.width = renderer.height = gbuffer.width = gbuffer.height = SIDE;
    renderer.self = 1;
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &scene, &x.sfield.scene));
    assert_glbk(t, glbk_sfield_scene_sky(&t->gl, &x.sfield.scene, sky));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &gbuffer, &x.sfield.gbuffer));
    assert_glbk(t, glbk_sfield_renderer_create(&t->gl, &renderer, &x.sfield.renderer));
}

static void run_sfield(gl_test *t, turn *out)
{
    glbk_surface surface;
    memset(&surface, 0, sizeof surface);
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &x.sfield.gbuffer, view, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, &x.sfield.gbuffer, &surface));
    draw_room(&t->gl, 1);
    assert_glbk(t, glbk_sfield_shade(&t->gl, &x.sfield.renderer, &x.sfield.gbuffer, &x.sfield.scene, NULL, 1));
    assert_glbk(t, glbk_sfield_read(&t->gl, &x.sfield.renderer, out->light[SFIELD], NULL));
}

static void destroy_sfield(glbk_context *gl)
{
    glbk_sfield_renderer_free(gl, &x.sfield.renderer);
    glbk_gbuffer_free(gl, &x.sfield.gbuffer);
    glbk_sfield_scene_free(gl, &x.sfield.scene);
    sfield_algebra_free(x.sfield.algebra);
}

/* ---- envsh: four lights ---- */

static const envsh_query soft = { ENVSH_FILTER_PENUMBRA, 4, 4, 1, 1, 0, 0 };

static void make_envsh(gl_test *t)
{
    static float sky[3 * 16 * 8];
    const envlt_map map = { ENVLT_PROJECTION_LATLONG, 16, 8, sky, 0 };
    const envsh_bounds bounds = { { -1, -1, -1 }, { 1, 1, 1 } };
    glbk_gbuffer_desc size;
    envsh_maps_desc layout;
    const glbk_envsh_maps_desc maps = { LIGHTS, &layout, { 0, 0, 0, 0, NULL, NULL } };
    envlt_desc d;
    const envlt_light *list;
    uint32_t count, i;
    memset(&layout, 0, sizeof layout);
    memset(&d, 0, sizeof d);
    for (i = 0; i < 3 * 16 * 8; i++) sky[i] = 1;
    d.light_count = LIGHTS;
    layout.map_side = 32;
    layout.no_depth = 1;
    assert_int_equal(envlt_create(&d, &map, &x.envsh.lights, NULL), ENVLT_OK);
    assert_int_equal(envsh_maps_create(&layout, LIGHTS, &x.envsh.layout), ENVSH_OK);
    list = envlt_get_lights(x.envsh.lights, &count);
    assert_int_equal(envsh_maps_begin(x.envsh.layout, AS_LIGHTS(list, count), bounds), ENVSH_OK);
    assert_glbk(t, glbk_envsh_maps_create(&t->gl, &maps, &x.envsh.maps));
    memset(&size, 0, sizeof size);
    size.width = size.height = SIDE;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &x.envsh.seen));
    assert_glbk(t, glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ SIDE, SIDE }, &x.envsh.renderer));
}

static glbk_result cast_room(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    glbk_result result = glbk_envsh_cast(ctx, maps, NULL);
    (void)user;
    draw_room(ctx, instances);
    return result;
}

static void run_envsh(gl_test *t, turn *out)
{
    const glbk_pass pass = to_screen();
    glbk_envsh_frame frame = { NULL, 0, cast_room, NULL, &soft };
    glbk_surface s;
    memset(&s, 0, sizeof s);
    s.material.diffuse[0] = s.material.diffuse[1] = s.material.diffuse[2] = 1;
    frame.views = envsh_views(x.envsh.layout, &frame.view_count);
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &x.envsh.seen, view, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, &x.envsh.seen, &s));
    draw_room(&t->gl, 1);
    assert_glbk(t, glbk_envsh_illuminate(&t->gl, &x.envsh.renderer, &x.envsh.seen, &x.envsh.maps, &frame));
    assert_glbk(t, glbk_envsh_resolve(&t->gl, &x.envsh.renderer, &x.envsh.seen, &pass, NULL));
    read_screen(t, out->resolved[ENVSH]);
    assert_glbk(t, glbk_envsh_read(&t->gl, &x.envsh.renderer, out->light[ENVSH]));
}

static void destroy_envsh(glbk_context *gl)
{
    glbk_envsh_renderer_free(gl, &x.envsh.renderer);
    glbk_gbuffer_free(gl, &x.envsh.seen);
    glbk_envsh_maps_free(gl, &x.envsh.maps);
    envsh_maps_free(x.envsh.layout);
    envlt_free(x.envsh.lights);
}

/* ---- rsm: a sun, no tables ---- */

static void make_rsm(gl_test *t)
{
    const glbk_rsm_renderer_desc renderer = { SIDE, SIDE, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_gbuffer_desc size;
    rsm_light lamp;
    memset(&size, 0, sizeof size);
    size.width = size.height = SIDE;
    memset(&lamp, 0, sizeof lamp);
    lamp.kind = RSM_LIGHT_SUN;
    lamp.direction[1] = 1;
    lamp.value[0] = lamp.value[1] = lamp.value[2] = 5;
    lamp.radius = 1.25f;
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &lamp, 16, &x.rsm.map));
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &renderer, &x.rsm.renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &x.rsm.seen));
}

static glbk_surface grey(void)
{
    glbk_surface s;
    memset(&s, 0, sizeof s);
    s.material.diffuse[0] = s.material.diffuse[1] = s.material.diffuse[2] = 0.7f;
    return s;
}

static void rsm_room(void *user, glbk_context *ctx, glbk_rsm_renderer *r)
{
    const glbk_surface s = grey();
    (void)user;
    assert_int_equal(glbk_rsm_object(ctx, r, &s, 0), GLBK_OK);
    draw_room(ctx, 1);
}

static void run_rsm(gl_test *t, turn *out)
{
    const glbk_pass pass = to_screen();
    const rsm_interpolation grid = { 4, 0, 0, 0, 0, 0, 0, NULL };
    const glbk_rsm_map *lit = &x.rsm.map;
    glbk_rsm_map *map = &x.rsm.map;
    glbk_rsm_renderer *r = &x.rsm.renderer;
    glbk_gbuffer *seen = &x.rsm.seen;
    const glbk_surface s = grey();
    rsm_gather_desc gather;
    gifilt_frame filter;
    memset(&gather, 0, sizeof gather);
    memset(&filter, 0, sizeof filter);
    gather.sample_count = 20;
    filter.world_to_clip = view;
    glbk_rsm_reset(r);
    /* before there is anything to resolve */
    assert_glbk(t, glbk_rsm_resolve(&t->gl, r, seen, &pass, NULL, 1, 1));
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, r, map, rsm_room, NULL));
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, seen, view, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, seen, &s));
    draw_room(&t->gl, 1);
    assert_glbk(t, glbk_rsm_interpolate(&t->gl, r, seen, &map, 1, &gather, &grid));
    assert_glbk(t, glbk_rsm_resolve(&t->gl, r, seen, &pass, NULL, 0, 1));
    assert_glbk(t, glbk_rsm_direct(&t->gl, r, seen, &lit, 1, NULL));
    assert_glbk(t, glbk_rsm_gather(&t->gl, r, seen, &map, 1, &gather));
    assert_glbk(t, glbk_rsm_denoise(&t->gl, r, seen, &filter, NULL));
    assert_glbk(t, glbk_rsm_resolve(&t->gl, r, seen, &pass, NULL, 1, 1));
    read_screen(t, out->resolved[RSM]);
    assert_glbk(t, glbk_rsm_read(&t->gl, r, 0, out->light[RSM]));
    assert_glbk(t, glbk_rsm_read(&t->gl, r, 1, out->bounced));
}

static void destroy_rsm(glbk_context *gl)
{
    glbk_gbuffer_free(gl, &x.rsm.seen);
    glbk_rsm_renderer_free(gl, &x.rsm.renderer);
    glbk_rsm_map_free(gl, &x.rsm.map);
}

/* ---- ism: a lamp over a table over a floor ---- */

static void make_ism(gl_test *t)
{
    static const float table[12] = { -0.5f, 1, -0.5f, 0.5f, 1, -0.5f, -0.5f, 1, 0.5f, 0.5f, 1, 0.5f };
    static const uint32_t triangles[6] = { 0, 1, 2, 1, 3, 2 };
    static const ism_vpl lamp = { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 2, 3 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 1, 0 };
    ism_info info;
    const ism_mesh mesh = { table, 4, 0, triangles, 6, NULL, NULL, NULL, NULL, NULL };
    const glbk_gbuffer_desc size = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    ism_surfel surfels[POINTS];
    ism_desc d;
    uint32_t i;
    for (i = 0; i < POINTS; i++) {
        surfels[i].triangle = i % 2;
        surfels[i].barycentric[0] = 0.1f + 0.1f * (float)(i % 8);
        surfels[i].barycentric[1] = (1 - surfels[i].barycentric[0]) * (0.1f + 0.1f * (float)(i / 8));
        surfels[i].area = 2.0f / POINTS;
    }
    memset(&info, 0, sizeof info);
    info.center[1] = 1;
    info.radius = 2;
    memset(&d, 0, sizeof d);
    d.vpl_count = d.lazy_frames = 1;
    d.surfel_count = POINTS;
    d.near_point_count = 1;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &x.ism.maps));
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &x.ism.maps, &mesh));
    assert_glbk(t, glbk_ism_surfels_upload(&t->gl, &x.ism.maps, 0, surfels, POINTS));
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &x.ism.maps, &lamp, 1, &info));
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, &x.ism.renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &x.ism.seen));
}

static void run_ism(gl_test *t, turn *out)
{
    const glbk_pass pass = to_screen();
    static glbk_pixel pixels[MOST];
    const uint32_t width = x.ism.seen.width, height = x.ism.seen.height;
    uint32_t i, k;
    memset(pixels, 0, sizeof pixels);
    for (i = 0; i < width * height; i++) {
        pixels[i].position[0] = 4 * ((float)(i % width) + 0.5f) / (float)width - 2;
        pixels[i].position[2] = 4 * ((float)(i / width) + 0.5f) / (float)height - 2;
        pixels[i].normal[1] = 1;
        for (k = 0; k < 3; k++) pixels[i].material.diffuse[k] = 0.5f;
    }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &x.ism.seen, 0, height, pixels));
    assert_glbk(t, glbk_ism_draw(&t->gl, &x.ism.maps, 0));
    assert_glbk(t, glbk_ism_shade(&t->gl, &x.ism.renderer, &x.ism.seen, &x.ism.maps, NULL, 0));
    assert_glbk(t, glbk_ism_resolve(&t->gl, &x.ism.renderer, &x.ism.seen, &pass, NULL));
    read_screen(t, out->resolved[ISM]);
    assert_glbk(t, glbk_ism_read(&t->gl, &x.ism.renderer, out->light[ISM]));
}

static void destroy_ism(glbk_context *gl)
{
    glbk_ism_renderer_free(gl, &x.ism.renderer);
    glbk_gbuffer_free(gl, &x.ism.seen);
    glbk_ism_maps_free(gl, &x.ism.maps);
}

/* ---- a shader of the user's for each ---- */

#define OWN(call)                                                                                   \
    "layout(location = 0) out glbk_color color;\n"                                                  \
    "void main()\n"                                                                                 \
    "{\n"                                                                                           \
    "    vec3 p = vec3(gl_FragCoord.xy / 4.0 - 1.0, 0.1), n = vec3(0.0, 1.0, 0.0), light;\n"        \
    "    " call "\n"                                                                                \
    "    color = glbk_pack(vec4(light, 1.0));\n"                                                    \
    "}\n"

static const glbk_offset offsets[2] = { { 0, 0 }, { 16, 8 } };

static void make_own(gl_test *t)
{
    const struct { const glbk_part *part; const char *uses, *defines, *text; } sources[TECHNIQUES] = {
        { glbk_csm_part(), "csm_visible", x.csm.maps.defines,
          OWN("cohsm_query ask = cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST, 1.0);"
              "light = vec3(csm_visible(0u, ask, p, n));") },
        { glbk_sfield_part(), "sfield_shade", "SFIELD_BANDS=1",
          OWN("float t[SFIELD_COEFS]; sfield_cosine(n, t); light = sfield_shade(p, n, 0u, t, t).light;") },
        { glbk_envsh_part(), "envsh_light", "ENVSH_FILTER=4 ENVSH_RGBA=0", OWN("light = envsh_light(p, n, n, 0u);") },
        { glbk_rsm_part(), "rsm_gather", NULL,
          OWN("light = rsm_gather_list(rsm_bound(), p, -n, 0u, 16u, false, 0.0);") },
        { glbk_ism_part(), "ism_light", "ISM_NEAR=6 ISM_PROJECTION=1", OWN("light = ism_light(p, n, n, 0u, 1u).rgb;") }
    };
    int i;
    for (i = 0; i < 2 * TECHNIQUES; i++) {
        const int which = i / 2;
        const glbk_source s = { NULL, sources[which].text, NULL, sources[which].uses, sources[which].defines, NULL,
                                { sources[which].part }, { offsets[i % 2] } };
        assert_glbk(t, glbk_program_compile(&t->gl, &s, &x.own[i % 2][which]));
    }
}

static void run_own(gl_test *t, int which, int moved, float *out)
{
    const glbk_pass pass = to_screen();
    const glbk_offset *at = moved ? &offsets[1] : NULL;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &x.own[moved][which]));
    switch (which) {
    case CSM: glbk_csm_bind(&t->gl, &x.csm.maps, at); break;
    case SFIELD: glbk_sfield_bind(&t->gl, &x.sfield.scene, at); break;
    case ENVSH: assert_glbk(t, glbk_envsh_bind(&t->gl, &x.envsh.maps, &soft, at)); break;
    case RSM: glbk_rsm_bind(&t->gl, &x.rsm.renderer, &x.rsm.map, at); break;
    default: assert_glbk(t, glbk_ism_bind(&t->gl, &x.ism.maps, NULL, at)); break;
    }
    glbk_draw_screen(&t->gl);
    read_screen(t, out);
}

/* Everything that stands at the slots as they are without an offset is taken away before. */
static void run_moved(gl_test *t, int which, const turn *same)
{
    float seen[4 * PIXELS];
    uint32_t i;
    for (i = 0; i < GLBK_UNITS; i++) glbk_bind_texture(&t->gl, i, NULL);
    for (i = 0; i < GLBK_BLOCKS; i++) t->gl.gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, i, 0);
    run_own(t, which, 1, seen);
    assert_memory_equal(seen, same->own[which], sizeof seen);
}

/* ---- another size ---- */

/* Gives every picture a size. Programs stay: the first of each technique has the name that it had. */
static void resize(gl_test *t, uint32_t width, uint32_t height)
{
    glbk_gbuffer *const buffers[TECHNIQUES] = { &x.csm.seen, &x.sfield.gbuffer, &x.envsh.seen, &x.rsm.seen,
                                                &x.ism.seen };
    const glbk_program *const programs[] = { &x.csm.renderer.resolve, &x.csm.renderer.shade.list[0],
                                             &x.sfield.renderer.shade, &x.envsh.renderer.resolve,
                                             &x.envsh.renderer.shade[2 * ENVSH_FILTER_PENUMBRA],
                                             &x.ism.renderer.blur, &x.rsm.seen.draw_program };
    enum { COUNT = sizeof programs / sizeof *programs };
    uint32_t before[COUNT + GLBK_RSM_PROGRAM_COUNT], i;
    glbk_gbuffer_desc size;
    memset(&size, 0, sizeof size);
    size.width = width;
    size.height = height;
    for (i = 0; i < COUNT; i++) before[i] = programs[i]->name;
    for (i = 0; i < GLBK_RSM_PROGRAM_COUNT; i++) before[COUNT + i] = x.rsm.renderer.programs[i].name;
    for (i = 0; i < TECHNIQUES; i++) {
        assert_glbk(t, glbk_gbuffer_resize(&t->gl, buffers[i], &size));
        assert_true(buffers[i]->width == width && buffers[i]->height == height && buffers[i]->depth.height == height);
    }
    assert_glbk(t, glbk_csm_renderer_resize(&t->gl, &x.csm.renderer, width, height));
    assert_glbk(t, glbk_sfield_renderer_resize(&t->gl, &x.sfield.renderer, width, height));
    assert_glbk(t, glbk_envsh_renderer_resize(&t->gl, &x.envsh.renderer, width, height));
    assert_glbk(t, glbk_rsm_renderer_resize(&t->gl, &x.rsm.renderer, width, height));
    assert_glbk(t, glbk_ism_renderer_resize(&t->gl, &x.ism.renderer, width, height));
    assert_true(x.csm.renderer.sums[0].width == width && x.sfield.renderer.self.height == height);
    assert_true(x.envsh.renderer.sums[0].height == height && x.ism.renderer.result.width == width);
    assert_true(x.rsm.renderer.history[1].width == width && x.rsm.renderer.grids[0].height == height / 2 + 2);
    for (i = 0; i < COUNT; i++) assert_int_equal(programs[i]->name, before[i]);
    for (i = 0; i < GLBK_RSM_PROGRAM_COUNT; i++) assert_int_equal(x.rsm.renderer.programs[i].name, before[COUNT + i]);
}

/* The mean of the first component over so many pixels. */
static double mean_of(const float *light, uint32_t pixels)
{
    double sum = 0;
    uint32_t i;
    for (i = 0; i < pixels; i++) sum += (double)light[4 * i];
    return sum / pixels;
}

/* At another size each technique draws what it has drawn, finer: the mean light is nearly the same. */
static void draw_wide(gl_test *t, void (*const runs[TECHNIQUES])(gl_test *, turn *), const turn *small)
{
    static turn wide;
    int i;
    resize(t, WIDE, HIGH);
    for (i = CSM; i <= TECHNIQUES; i++) {
        const float *light = i < TECHNIQUES ? wide.light[i] : wide.bounced;
        const float *before = i < TECHNIQUES ? small->light[i] : small->bounced;
        double ratio;
        if (i < TECHNIQUES) runs[i](t, &wide);
        ratio = mean_of(light, MOST) / mean_of(before, PIXELS);
        if (!(fabs(ratio - 1) < 0.1)) fail_msg("technique %d at another size: %f of its light", i, ratio);
    }
    resize(t, SIDE, SIDE);
}

/* ---- the test ---- */

static void is_lit(const char *what, const float *light, int components)
{
    int i, lit = 0;
    for (i = 0; i < PIXELS; i++) lit += light[components * i] > 0;
    if (!lit) fail_msg("%s is dark", what);
}

static void techniques_one_after_the_other_draw_the_same_at_each_turn(void **state)
{
    GL_TEST(t, state)
    static void (*const runs[TECHNIQUES])(gl_test *, turn *) = { run_csm, run_sfield, run_envsh, run_rsm, run_ism };
    static const char *const names[TECHNIQUES] = { "csm", "sfield", "envsh", "rsm", "ism" };
    static turn turns[3];
    int i, k;
    memset(&x, 0, sizeof x);
    memset(turns, 0, sizeof turns);
    make_room(t);
    make_csm(t);
    make_sfield(t);
    make_envsh(t);
    make_rsm(t);
    make_ism(t);
    make_own(t);
    for (k = 0; k < 3; k++) {
        if (k == 2) draw_wide(t, runs, &turns[0]);
        for (i = CSM; i < TECHNIQUES; i++) {
            runs[i](t, &turns[k]);
            run_own(t, i, 0, turns[k].own[i]);
            run_moved(t, i, &turns[k]);
        }
    }
    assert_memory_equal(&turns[0], &turns[1], sizeof turns[0]);
    assert_memory_equal(&turns[0], &turns[2], sizeof turns[0]);
    for (i = CSM; i < TECHNIQUES; i++) {
        is_lit(names[i], turns[0].light[i], 4);
        if (i != SFIELD) is_lit(names[i], turns[0].resolved[i], 4);
        is_lit(names[i], turns[0].own[i], 4);
    }
    is_lit("bounced light", turns[0].bounced, 4);
    is_lit("an answer", turns[0].visible, 1);
    for (i = 0; i < TECHNIQUES; i++) glbk_program_free(&t->gl, &x.own[0][i]), glbk_program_free(&t->gl, &x.own[1][i]);
    destroy_csm(&t->gl);
    destroy_sfield(&t->gl);
    destroy_envsh(&t->gl);
    destroy_rsm(&t->gl);
    destroy_ism(&t->gl);
    gl_canvas_free(t, &x.screen);
    glbk_buffer_free(&t->gl, &x.corners);
    t->gl.gl.DeleteVertexArrays(1, &x.room);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(techniques_one_after_the_other_draw_the_same_at_each_turn) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
