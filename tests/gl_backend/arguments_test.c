/* arguments_test - every argument of glbk's functions and every field of their descs, wrong in one place at a time: the
   call is refused and what it was to make stays zero. Each list begins with the same call as it should be, which works:
   nothing else is wrong. The calls of sfield: shadowfield/gl_arguments_test. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"

#include "gl_test.h"
#include "gl_wrong.h"
#include "csm/util.h"

enum { SIDE = 8 };

#define IS_EARLY(call) ERROR_IS(GLBK_ERR_ORDER, call)

/* Another size that is refused leaves a renderer as it was. */
#define RESIZES(resize, r, none)                                            \
    do {                                                                    \
        REFUSED(resize(NULL, &(r), SIDE, SIDE));                            \
        REFUSED(resize(gl, NULL, SIDE, SIDE));                              \
        REFUSED(resize(gl, &(none), SIDE, SIDE));                           \
        ERROR_IS(GLBK_ERR_DESC, resize(gl, &(r), 0, SIDE));                 \
        ERROR_IS(GLBK_ERR_LIMIT, resize(gl, &(r), SIDE, gl->max_side + 1)); \
        assert_true((r).width == SIDE && (r).height == SIDE);               \
        assert_glbk(t, resize(gl, &(r), SIDE + 1, SIDE));                   \
    } while (0)

static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* ---- the layer below ---- */

static void textures_and_tables_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    static const uint32_t words[2048];
    glbk_texture_desc d = { GLBK_FORMAT_RGBA8, 8, 4, 3, 2, GLBK_SAMPLING_LINEAR, 0, NULL };
    glbk_texture x, table;
    size_t room = (size_t)1024 * 2;

    assert_glbk(t, glbk_texture_create(gl, &d, &x));
    glbk_texture_free(gl, &x);
    REFUSED(glbk_texture_create(gl, &d, NULL));
    REFUSED(glbk_texture_create(NULL, &d, &x));
    MAKES(x, glbk_texture_create(gl, NULL, &x));
    DESC_WRONG(x, d.format, GLBK_FORMAT_NONE, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.format, GLBK_FORMAT_COUNT, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.sampling, GLBK_SAMPLING_COUNT, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.width, 0, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.height, 0, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.levels, 5, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.sampling, GLBK_SAMPLING_COMPARE, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.format, GLBK_FORMAT_RGBA8UI, glbk_texture_create(gl, &d, &x));
    DESC_WRONG(x, d.format, GLBK_FORMAT_DEPTH24, glbk_texture_create(gl, &d, &x));
    WRONG_IS(GLBK_ERR_LIMIT, x, d.width, gl->max_side + 1, glbk_texture_create(gl, &d, &x));
    WRONG_IS(GLBK_ERR_LIMIT, x, d.height, gl->max_side + 1, glbk_texture_create(gl, &d, &x));
    WRONG_IS(GLBK_ERR_LIMIT, x, d.layers, gl->max_layers + 1, glbk_texture_create(gl, &d, &x));

    assert_glbk(t, glbk_texture_create(gl, &d, &x));
    assert_glbk(t, glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 1, 1, 3, 1, 2 }, words));
    REFUSED(glbk_texture_update(NULL, &x, &(glbk_box){ 1, 1, 1, 1, 3, 1, 2 }, words));
    REFUSED(glbk_texture_update(gl, NULL, &(glbk_box){ 1, 1, 1, 1, 3, 1, 2 }, words));
    REFUSED(glbk_texture_update(gl, &(glbk_texture){ 0 }, &(glbk_box){ 1, 1, 1, 1, 3, 1, 2 }, words));
    REFUSED(glbk_texture_update(gl, &x, NULL, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 2, 1, 1, 1, 3, 1, 2 }, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 1, 1, 3, 1, 2 }, NULL));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 5, 1, 1, 0, 1, 2 }, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 1, 1, 4, 1, 2 }, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 3, 1, 3, 0, 2 }, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 1, 1, 3, 2, 2 }, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 1, 4, 3, 1, 0 }, words));
    REFUSED(glbk_texture_update(gl, &x, &(glbk_box){ 1, 1, 1, 1, 3, 1, 3 }, words));

    assert_glbk(t, glbk__table_create(gl, GLBK_FORMAT_R32UI, words, 2048, &table));
    assert_glbk(t, glbk__table_update(gl, &table, 2000, 48, words));
    REFUSED(glbk__table_update(NULL, &table, 2000, 48, words));
    REFUSED(glbk__table_update(gl, NULL, 2000, 48, words));
    REFUSED(glbk__table_update(gl, &(glbk_texture){ 0 }, 2000, 48, words));
    REFUSED(glbk__table_update(gl, &x, 0, 8, words));                    /* not a table: 8 wide */
    REFUSED(glbk__table_update(gl, &table, 2000, 48, NULL));
    REFUSED(glbk__table_update(gl, &table, room + 1, 0, words));
    REFUSED(glbk__table_update(gl, &table, 2000, 49, words));
    {
        glbk_texture flat = table;
        flat.layers = 0;                                                /* a 2D texture as wide as a table */
        REFUSED(glbk__table_update(gl, &flat, 0, 8, words));
        flat = table;
        REFUSED(glbk__table_create(gl, GLBK_FORMAT_R32UI, words, 2048, NULL));
        MAKES(flat, glbk__table_create(NULL, GLBK_FORMAT_R32UI, words, 2048, &flat));
        MAKES(flat, glbk__table_create(gl, GLBK_FORMAT_R32UI, words, 0, &flat));
        assert_int_equal(glbk__table_create(gl, GLBK_FORMAT_R32UI, NULL, ((size_t)gl->max_layers << 20) + 1, &flat),
                         GLBK_ERR_LIMIT);
        gl->lost = 1;
        assert_int_equal(glbk__table_create(gl, GLBK_FORMAT_R32UI, NULL, ((size_t)gl->max_layers << 20) + 1, &flat),
                         GLBK_ERR_LOST);
        gl->lost = 0;
    }
    glbk_texture_free(gl, &table);
    glbk_texture_free(gl, &x);
}

static void buffers_and_targets_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    gl_canvas a = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 8, 4, 1), b = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 8, 2, 0);
    glbk_texture none = { 0 };
    glbk_target_desc d = { { &a.color, NULL, NULL, NULL }, { 0, 0, 0, 0 }, &a.depth, 0, 0 };
    glbk_buffer x;
    glbk_target target;
    float rgba[8 * 4 * 4];
    const glbk_texture *wide = &b.color;

    assert_glbk(t, glbk_buffer_create(gl, 16, NULL, &x));
    assert_glbk(t, glbk_buffer_update(gl, &x, 12, 4, rgba));
    REFUSED(glbk_buffer_create(gl, 16, NULL, NULL));
    REFUSED(glbk_buffer_update(NULL, &x, 12, 4, rgba));
    REFUSED(glbk_buffer_update(gl, NULL, 12, 4, rgba));
    REFUSED(glbk_buffer_update(gl, &(glbk_buffer){ 0 }, 0, 0, rgba));
    REFUSED(glbk_buffer_update(gl, &x, 17, 0, rgba));
    REFUSED(glbk_buffer_update(gl, &x, 12, 5, rgba));
    REFUSED(glbk_buffer_update(gl, &x, 12, 4, NULL));
    if (!gl->es) {
        assert_glbk(t, glbk_buffer_read(gl, &x, 12, 4, rgba));
        REFUSED(glbk_buffer_read(gl, NULL, 12, 4, rgba));
        REFUSED(glbk_buffer_read(gl, &x, 12, 5, rgba));
        REFUSED(glbk_buffer_read(gl, &x, 12, 4, NULL));
    }
    glbk_buffer_free(gl, &x);
    MAKES(x, glbk_buffer_create(NULL, 16, NULL, &x));
    MAKES(x, glbk_buffer_create(gl, 0, NULL, &x));
    REFUSED(glbk_indices_create(gl, 16, NULL, NULL));
    MAKES(x, glbk_indices_create(NULL, 16, NULL, &x));
    MAKES(x, glbk_indices_create(gl, 0, NULL, &x));

    assert_glbk(t, glbk_target_create(gl, &d, &target));
    glbk_target_free(gl, &target);
    REFUSED(glbk_target_create(gl, &d, NULL));
    MAKES(target, glbk_target_create(NULL, &d, &target));
    MAKES(target, glbk_target_create(gl, NULL, &target));
    DESC_WRONG(target, d.color[0], &none, glbk_target_create(gl, &d, &target));
    DESC_WRONG(target, d.level, 1, glbk_target_create(gl, &d, &target));
    DESC_WRONG(target, d.layer[0], 1, glbk_target_create(gl, &d, &target));
    DESC_WRONG(target, d.depth_layer, 1, glbk_target_create(gl, &d, &target));
    WRONG_IS(GLBK_ERR_MISMATCH, target, d.color[0], &a.depth, glbk_target_create(gl, &d, &target));
    WRONG_IS(GLBK_ERR_MISMATCH, target, d.depth, &a.color, glbk_target_create(gl, &d, &target));
    DESC_WRONG(target, d.color[2], &a.color, glbk_target_create(gl, &d, &target));        /* a gap */
    WRONG_IS(GLBK_ERR_MISMATCH, target, d.color[1], wide, glbk_target_create(gl, &d, &target));      /* in height */
    {
        gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 4, 4, 0);
        WRONG_IS(GLBK_ERR_MISMATCH, target, d.color[1], &c.color, glbk_target_create(gl, &d, &target));
        gl_canvas_free(t, &c);
    }
    memset(&d, 0, sizeof d);
    MAKES_IS(GLBK_ERR_DESC, target, glbk_target_create(gl, &d, &target));

    assert_glbk(t, glbk_target_read(gl, &a.target, 0, 1, 1, 7, 3, rgba));
    REFUSED(glbk_target_read(NULL, &a.target, 0, 1, 1, 7, 3, rgba));
    REFUSED(glbk_target_read(gl, NULL, 0, 1, 1, 7, 3, rgba));
    REFUSED(glbk_target_read(gl, &(glbk_target){ 0 }, 0, 0, 0, 0, 0, rgba));
    REFUSED(glbk_target_read(gl, &a.target, 1, 1, 1, 7, 3, rgba));
    REFUSED(glbk_target_read(gl, &a.target, 0, 1, 1, 7, 3, NULL));
    REFUSED(glbk_target_read(gl, &a.target, 0, 9, 1, 0, 3, rgba));
    REFUSED(glbk_target_read(gl, &a.target, 0, 1, 1, 8, 3, rgba));
    REFUSED(glbk_target_read(gl, &a.target, 0, 1, 5, 7, 0, rgba));
    REFUSED(glbk_target_read(gl, &a.target, 0, 1, 1, 7, 4, rgba));
    gl_canvas_free(t, &b);
    gl_canvas_free(t, &a);
}

/* A pass that is refused has touched nothing; what binds nothing leaves what was bound, but no texture takes the place
   of one. */
static void passes_and_bindings_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    gl_canvas a = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 8, 4, 1);
    const float white[4] = { 1, 1, 1, 1 };
    glbk_target none = { 0 };
    glbk_buffer buffer;
    glbk_program program = { 0 };
    glbk_pass p = { 0 };
    glbk_texture_desc d = { 0 };
    glbk_texture layers, none_yet = { 0 };
    float rgba[4];
    int32_t before, after, i;
    uint32_t slot = 3;
    d.format = GLBK_FORMAT_RGBA8;
    d.width = d.height = d.layers = 1;
    assert_glbk(t, glbk_texture_create(gl, &d, &layers));

    p.target = &a.target;
    assert_glbk(t, glbk_begin(gl, &p, NULL));
    REFUSED(glbk_begin(NULL, &p, NULL));
    REFUSED(glbk_begin(gl, NULL, NULL));
    DESC_BAD(p.depth, GLBK_DEPTH_COUNT, glbk_begin(gl, &p, NULL));
    DESC_BAD(p.blend, GLBK_BLEND_COUNT, glbk_begin(gl, &p, NULL));
    DESC_BAD(p.cull, GLBK_CULL_COUNT, glbk_begin(gl, &p, NULL));
    DESC_BAD(p.target, &none, glbk_begin(gl, &p, NULL));
    DESC_BAD(p.viewport[2], -1, glbk_begin(gl, &p, NULL));
    DESC_BAD(p.viewport[3], -1, glbk_begin(gl, &p, NULL));
    p.target = NULL;
    ERROR_IS(GLBK_ERR_DESC, glbk_begin(gl, &p, NULL));
    p.viewport[2] = 8;
    ERROR_IS(GLBK_ERR_DESC, glbk_begin(gl, &p, NULL));
    p.viewport[2] = 0;
    p.viewport[3] = 4;
    ERROR_IS(GLBK_ERR_DESC, glbk_begin(gl, &p, NULL));
    p.viewport[2] = 8;
    assert_glbk(t, glbk_begin(gl, &p, NULL));           /* into the framebuffer that is bound, the canvas */
    p.viewport[2] = 0;
    p.target = &a.target;
    assert_glbk(t, glbk_begin(gl, &p, NULL));           /* one side given */
    p.viewport[3] = 0;
    p.offset[1] = 2;
    assert_glbk(t, glbk_begin(gl, &p, NULL));
    assert_int_equal(gl->gl.IsEnabled(0x8037 /* POLYGON_OFFSET_FILL */), 1);
    p.offset[1] = 0;
    assert_glbk(t, glbk_begin(gl, &p, NULL));
    assert_int_equal(gl->gl.IsEnabled(0x8037), 0);

    glbk_clear(gl, &a.target, 0, white);
    glbk_clear(NULL, &a.target, 0, rgba);
    glbk_clear(gl, NULL, 0, rgba);
    glbk_clear(gl, &a.target, 1, rgba);
    glbk_clear(gl, &a.target, 0, NULL);
    glbk_clear_depth(NULL, 0);
    glbk_draw_screen(NULL);
    assert_glbk(t, glbk_target_read(gl, &a.target, 0, 7, 3, 1, 1, rgba));
    assert_memory_equal(rgba, white, sizeof rgba);

    assert_glbk(t, glbk_buffer_create(gl, 64, NULL, &buffer));
    glbk_bind_block(gl, slot, &buffer);
    gl->gl.GetIntegeri_v(0x8A28 /* UNIFORM_BUFFER_BINDING */, slot, &before);
    assert_int_equal(before, buffer.name);
    glbk_bind_block(NULL, slot, &(glbk_buffer){ 0 });
    glbk_bind_block(gl, slot, NULL);
    glbk_bind_block(gl, GLBK_MAX_BLOCKS, &buffer);
    gl->gl.GetIntegeri_v(0x8A28, slot, &after);
    assert_int_equal(before, after);
    for (i = 0; i < 2; i++) {
        glbk_bind_texture(gl, slot, &a.color);
        gl->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, layers.name);
        glbk_bind_texture(NULL, slot, &none_yet);
        glbk_bind_texture(gl, GLBK_MAX_UNITS, &none_yet);
        gl->gl.GetIntegerv(0x8069 /* TEXTURE_BINDING_2D */, &after);
        assert_int_equal(after, a.color.name);
        glbk_bind_texture(gl, slot, i ? &none_yet : NULL);
        gl->gl.GetIntegerv(0x8069, &after);
        gl->gl.GetIntegerv(0x8C1D /* TEXTURE_BINDING_2D_ARRAY */, &before);
        assert_true(after == 0 && before == 0);
    }
    glbk_bind_storage(NULL, slot, &buffer);
    glbk_bind_image(NULL, slot, &a.color);
    glbk_bind_storage(gl, slot, gl->compute ? NULL : &buffer);
    glbk_bind_image(gl, slot, gl->compute ? NULL : &a.color);
    if (gl->compute) {
        glbk_bind_storage(gl, slot, &buffer);
        glbk_bind_storage(gl, GLBK_BLOCKS, &buffer);
        gl->gl.GetIntegeri_v(0x90D3 /* SHADER_STORAGE_BUFFER_BINDING */, slot, &after);
        assert_int_equal(after, buffer.name);
        glbk_bind_image(gl, slot, &a.color);
        glbk_bind_image(gl, slot, &(glbk_texture){ 0 });
        glbk_bind_image(gl, GLBK_IMAGES, &a.color);
        gl->gl.GetIntegeri_v(0x8F3A /* IMAGE_BINDING_NAME */, slot, &after);
        assert_int_equal(after, a.color.name);
        gl->gl.BindImageTexture(slot, 0, 0, 0, 0, 0x88BA, 0x8058);
        gl->gl.BindBufferBase(GLBK_GL_SHADER_STORAGE_BUFFER, slot, 0);
    }
    REFUSED(glbk_dispatch(NULL, &program, 1, 1, 1));
    REFUSED(glbk_dispatch(gl, NULL, 1, 1, 1));
    REFUSED(glbk_dispatch(gl, &program, 1, 1, 1));
    glbk_program_use(NULL, &program);
    glbk_program_use(gl, NULL);
    REFUSED(glbk_set_slots(NULL, NULL, NULL, 1));
    REFUSED(glbk_set_slots(gl, NULL, NULL, 0));
    gl->gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, slot, 0);
    glbk_buffer_free(gl, &buffer);
    glbk_texture_free(gl, &layers);
    gl_canvas_free(t, &a);
}

/* ---- csm ---- */

typedef struct csm_stage {
    cohsm_maps          *built;
    glbk_csm_block       block;
    glbk_csm_instance    plate;
    glbk_csm_maps        maps;
    lsamp_light_desc  light;
    glbk_csm_lights      lights;
    uint32_t             start;
} csm_stage;

static void csm_stage_make(gl_test *t, csm_stage *s)
{
    static const double low[3] = { -0.8, -0.4, 0.2 }, high[3] = { -0.2, 0.4, 0.25 };
    model m = model_box(low, high, 0);
    cohsm_mesh mesh = mesh_of(&m);
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 8, 32);
    glbk_csm_lights_desc lights = { 0 };

    memset(s, 0, sizeof *s);
    assert_int_equal(cohsm_build(&d, &mesh, &s->built, NULL), COHSM_OK);
    model_free(&m);
    s->block.data = cohsm_data(s->built, &s->block.bytes);
    memcpy(s->plate.transform, unit, sizeof unit);
    s->light.kind = LSAMP_LIGHT_DISC;
    s->light.direction[2] = -1;
    s->light.radius = 1;
    s->light.radiance[0] = 1;
    lights.lights = &s->light;
    lights.light_count = 1;
    assert_glbk(t, glbk_csm_maps_create(&t->gl, &s->block, 1, 2, &s->plate.start, &s->maps));
    assert_glbk(t, glbk_csm_lights_create(&t->gl, &lights, &s->start, &s->lights));
}

static void csm_stage_free(gl_test *t, csm_stage *s)
{
    glbk_csm_lights_free(&t->gl, &s->lights);
    glbk_csm_maps_free(&t->gl, &s->maps);
    cohsm_free(s->built);
}

static void csm_blocks_and_instances_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static csm_stage s;
    static uint8_t bytes[512];
    glbk_context *gl = &t->gl;
    glbk_csm_block b;
    glbk_csm_maps x;
    uint32_t start, i;

    csm_stage_make(t, &s);
    b = s.block;
    REFUSED(glbk_csm_maps_create(gl, &b, 1, 2, &start, NULL));
    REFUSED(glbk_csm_maps_create(NULL, &b, 1, 2, &start, &x));
    MAKES(x, glbk_csm_maps_create(gl, NULL, 1, 2, &start, &x));
    MAKES(x, glbk_csm_maps_create(gl, &b, 1, 2, NULL, &x));
    REFUSED((b.data = NULL, glbk_csm_maps_create(gl, &b, 1, 2, &start, &x)));
    b = s.block;
    BAD_IS(GLBK_ERR_FORMAT, b.bytes, 384, glbk_csm_maps_create(gl, &b, 1, 2, &start, &x));
    BAD_IS(GLBK_ERR_FORMAT, b.bytes, b.bytes - 8, glbk_csm_maps_create(gl, &b, 1, 2, &start, &x));
    for (i = 0; i < 3; i++) {           /* magic, format, length */
        memcpy(bytes, s.block.data, sizeof bytes);
        bytes[4 * i + 1] ^= 1;
        BAD_IS(i == 1 ? GLBK_ERR_VERSION : GLBK_ERR_FORMAT, b.data, bytes,
               glbk_csm_maps_create(gl, &b, 1, 2, &start, &x));
    }
    REFUSED(glbk_csm_maps_create(gl, &b, 1, 0xffffffffu, &start, &x));
    assert_glbk(t, glbk_csm_maps_create(gl, NULL, 0, 0, NULL, &x));     /* a scene without maps */
    glbk_csm_maps_free(gl, &x);

    assert_glbk(t, glbk_csm_maps_place(gl, &s.maps, &s.plate, 1));
    REFUSED(glbk_csm_maps_place(NULL, &s.maps, &s.plate, 1));
    REFUSED(glbk_csm_maps_place(gl, NULL, &s.plate, 1));
    REFUSED(glbk_csm_maps_place(gl, &(glbk_csm_maps){ 0 }, NULL, 0));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_csm_maps_place(gl, &s.maps, &s.plate, 3));
    REFUSED(glbk_csm_maps_place(gl, &s.maps, NULL, 1));
    BAD_IS(GLBK_ERR_INPUT, s.plate.start, s.maps.texel_count, glbk_csm_maps_place(gl, &s.maps, &s.plate, 1));
    for (i = 0; i < wrong_transform_count; i++) {
        memcpy(s.plate.transform, unit, sizeof unit);
        wrong_transform(i, s.plate.transform);
        ERROR_IS(GLBK_ERR_INPUT, glbk_csm_maps_place(gl, &s.maps, &s.plate, 1));
    }
    glbk_csm_bind(NULL, &s.maps, NULL);
    glbk_csm_bind(gl, NULL, NULL);
    csm_stage_free(t, &s);
}

static void csm_askers_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static csm_stage s;
    glbk_context *gl = &t->gl;
    float words[12] = { 0 }, visible[2];
    cohsm_query q = { 0 };
    glbk_csm_asker a, none = { 0 };

    csm_stage_make(t, &s);
    q.count = 2;
    q.positions = q.lights = words;
    q.filter = COHSM_FILTER_PCF;
    REFUSED(glbk_csm_asker_create(NULL, 2, &a));
    REFUSED(glbk_csm_asker_create(gl, 2, NULL));
    MAKES(a, glbk_csm_asker_create(gl, 0, &a));
    MAKES(a, glbk_csm_asker_create(gl, ((uint32_t)1 << 22) + 1, &a));
    assert_glbk(t, glbk_csm_asker_create(gl, 2, &a));
    ERROR_IS(GLBK_ERR_ORDER, glbk_csm_ask_run(gl, &a, &s.maps, 2));     /* nothing was uploaded */
    assert_glbk(t, glbk_csm_ask_upload(gl, &a, &q));
    REFUSED(glbk_csm_ask_upload(NULL, &a, &q));
    REFUSED(glbk_csm_ask_upload(gl, NULL, &q));
    REFUSED(glbk_csm_ask_upload(gl, &none, &q));
    REFUSED(glbk_csm_ask_upload(gl, &a, NULL));
    BAD(q.positions, NULL, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.lights, NULL, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.count, 0, glbk_csm_ask_upload(gl, &a, &q));
    BAD_IS(GLBK_ERR_LIMIT, q.count, 3, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.position_stride, 8, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.position_stride, 13, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.light_stride, 8, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.light_stride, 14, glbk_csm_ask_upload(gl, &a, &q));
    BAD(q.light_kind, COHSM_LIGHT_PARAMETER, glbk_csm_ask_upload(gl, &a, &q));  /* of how many dimensions? */
    assert_non_null(strstr(t->log, "query.light_stride is 0"));
    DESC_BAD(q.light_kind, COHSM_LIGHT_COUNT, glbk_csm_ask_upload(gl, &a, &q));
    DESC_BAD(q.filter, COHSM_FILTER_COUNT, glbk_csm_ask_upload(gl, &a, &q));
    DESC_BAD(q.bias, NAN, glbk_csm_ask_upload(gl, &a, &q));
    assert_glbk(t, glbk_csm_ask_run(gl, &a, &s.maps, 2));
    REFUSED(glbk_csm_ask_run(NULL, &a, &s.maps, 2));
    REFUSED(glbk_csm_ask_run(gl, NULL, &s.maps, 2));
    REFUSED(glbk_csm_ask_run(gl, &a, NULL, 2));
    REFUSED(glbk_csm_ask_run(gl, &a, &s.maps, 0));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_csm_ask_run(gl, &a, &s.maps, 3));
    assert_glbk(t, glbk_csm_ask_read(gl, &a, 2, visible));
    REFUSED(glbk_csm_ask_read(NULL, &a, 2, visible));
    REFUSED(glbk_csm_ask_read(gl, NULL, 2, visible));
    REFUSED(glbk_csm_ask_read(gl, &a, 0, visible));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_csm_ask_read(gl, &a, 3, visible));
    REFUSED(glbk_csm_ask_read(gl, &a, 2, NULL));
    glbk_csm_asker_free(gl, NULL);
    glbk_csm_asker_free(gl, &a);
    csm_stage_free(t, &s);
}

static void shine(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)user, (void)time, (void)x, (void)direction;
    rgb[0] = rgb[1] = rgb[2] = 1;
}

/* Texels that a light needs, 0 where its desc is refused. */
static void csm_lights_refuse_bad_descs(void **state)
{
    (void)state;
    static const float grey[12] = { 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 }, corners[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    static const lsamp_light_desc plain = { .direction = { 0, 0, -1 }, .u = { 1, 0, 0 }, .v = { 0, 1, 0 },
                                               .radius = 1, .cone_half_angle = 1 };
    lsamp_light_desc d = plain;
    static const uint32_t indices[3] = { 0, 1, 2 };
    static const uint16_t indices16[3] = { 0, 1, 2 };
    static const lsamp_mesh one = { corners, 3, 0, NULL, 0, NULL };
    static const lsamp_surface grid = { 2, 2, grey, 0 };
    lsamp_mesh m = one;
    lsamp_surface s = grid;
    char said[GL_LOG];
    uint32_t words[4 * 64];
    int shape, i;

#define NO_LIGHT_SO(expected, field, value)                             \
    do {                                                                \
        lsamp_light_desc keep = d;                                      \
        (field) = (value);                                              \
        assert_int_equal(glbk_csm_light_texels(&d), 0);                 \
        assert_int_equal(glbk_csm_light_write(&d, words), expected);    \
        d = keep;                                                       \
    } while (0)
#define NO_LIGHT(field, value) NO_LIGHT_SO(GLBK_ERR_DESC, field, value)
    for (shape = 0; shape < LSAMP_LIGHT_COUNT; shape++) {
        d = plain;
        d.kind = (lsamp_light_kind)shape;
        if (shape == LSAMP_LIGHT_MESH) d.mesh = &one;
        if (shape == LSAMP_LIGHT_SURFACE) d.surface = &grid;
        assert_true(glbk_csm_light_texels(&d) > 0);
        assert_int_equal(glbk_csm_light_write(&d, words), GLBK_OK);
        REFUSED(glbk_csm_light_write(&d, NULL));
        d.system.log = gl_log;
        d.system.user = said;
        REFUSED(glbk_csm_light_write(&d, NULL));
        assert_string_equal(said, "glbk_csm_light_write: words is NULL");
        d.system.log = NULL;
        NO_LIGHT(d.kind, LSAMP_LIGHT_COUNT);
        if (shape >= LSAMP_LIGHT_SUN && shape <= LSAMP_LIGHT_SPOT)
            NO_LIGHT(d.emission_fn, shine);
        NO_LIGHT(d.filter, LSAMP_TEXELS_COUNT);
        for (i = 0; i < 3; i++) {
            NO_LIGHT(d.radiance[i], -1);
            NO_LIGHT(d.radiance[i], INFINITY);
            NO_LIGHT(d.position[i], 1e19f);
            NO_LIGHT(d.position[i], NAN);
        }
        NO_LIGHT(d.cosine_power, -1);
        NO_LIGHT(d.cosine_power, 1e6f);
        NO_LIGHT(d.rotation, 1001);
        NO_LIGHT(d.rotation, -1001);
        NO_LIGHT(d.time, NAN);
        NO_LIGHT(d.frames_per_second, -1);
        NO_LIGHT(d.frame_count, 2);                          /* frames without texels */
        NO_LIGHT(d.width, 2);                           /* a size without texels */
        NO_LIGHT(d.height, 2);
        d.texels = grey;
        d.width = 4;
        d.height = 1;
        switch (shape) {
        case LSAMP_LIGHT_SUN: case LSAMP_LIGHT_POINT: case LSAMP_LIGHT_SPOT: case LSAMP_LIGHT_MESH:
            assert_int_equal(glbk_csm_light_texels(&d), 0);
            break;
        default:
            assert_true(glbk_csm_light_texels(&d) > 0);
            NO_LIGHT(d.width, 0);
            NO_LIGHT(d.height, 0);
            NO_LIGHT(d.width, 65537);
            NO_LIGHT(d.height, 65537);
            d.width = d.height = 65536;                 /* each may be, their product not */
            assert_int_equal(glbk_csm_light_texels(&d), 0);
            assert_int_equal(glbk_csm_light_write(&d, words),
                             shape == LSAMP_LIGHT_LINE ? GLBK_ERR_DESC : GLBK_ERR_LIMIT);
        }
    }
#define OF(name) (d = plain, d.kind = LSAMP_LIGHT_##name)
    OF(SUN);
    NO_LIGHT(d.direction[2], 0);
    NO_LIGHT(d.direction[2], 1.1f);
    OF(SPOT);
    NO_LIGHT(d.direction[2], 0.5f);
    NO_LIGHT(d.cone_half_angle, 0);
    NO_LIGHT(d.cone_half_angle, 3.2f);
    OF(LINE);
    NO_LIGHT(d.u[0], 0);
    NO_LIGHT(d.u[1], 1e19f);
    NO_LIGHT(d.radius, 0);
    NO_LIGHT(d.radius, 1e19f);
    d.u[0] = 0, d.u[1] = 1;
    assert_true(glbk_csm_light_texels(&d) > 0);
    d.u[1] = 0, d.u[2] = 1;
    assert_true(glbk_csm_light_texels(&d) > 0);
    d.texels = grey;
    d.width = 4;
    d.height = 2;
    assert_int_equal(glbk_csm_light_texels(&d), 0);     /* a line has one row */
    OF(RECTANGLE);
    NO_LIGHT(d.u[0], 1e19f);
    NO_LIGHT(d.v[1], 1e19f);
    NO_LIGHT(d.v[1], 0);
    d.u[0] = 1e18f;
    NO_LIGHT(d.v[1], 1e18f);                            /* an area whose square is no float */
    OF(DISC);
    NO_LIGHT(d.direction[2], 0);
    NO_LIGHT(d.radius, 0);
    OF(SPHERE);
    NO_LIGHT(d.radius, -1);
    OF(SURFACE);
    NO_LIGHT(d.surface, NULL);
    d.surface = &s;
    NO_LIGHT(s.points, NULL);
    s = grid;
    NO_LIGHT(s.height, 4097);
    OF(MESH);
    NO_LIGHT(d.mesh, NULL);
    d.mesh = &m;
    assert_true(glbk_csm_light_texels(&d) > 0);
    NO_LIGHT_SO(GLBK_ERR_ARGUMENT, m.positions, NULL);
    m = one;
    NO_LIGHT_SO(GLBK_ERR_ARGUMENT, m.vertex_count, 0);
    m = one;
    NO_LIGHT_SO(GLBK_ERR_ARGUMENT, m.vertex_count, 2);
    m = one;
    NO_LIGHT_SO(GLBK_ERR_LIMIT, m.vertex_count, (size_t)3 << 26);
    m = one;
    NO_LIGHT_SO(GLBK_ERR_ARGUMENT, m.vertex_stride, 8);
    m = one;
    m.indices = indices;
    m.indices16 = indices16;
    assert_int_equal(glbk_csm_light_texels(&d), 0);     /* both */
    assert_int_equal(glbk_csm_light_write(&d, words), GLBK_ERR_ARGUMENT);
    m.indices16 = NULL;
    m.index_count = 3;
    m.vertex_count = 2;
    d.system.log = gl_log;
    d.system.user = said;
    assert_int_equal(glbk_csm_light_write(&d, words), GLBK_ERR_INPUT);
    assert_non_null(strstr(said, "_write: desc.mesh: index 2 of triangle 0 is 2, but the mesh has 2 vertices"));
    m.indices = NULL;
    m.indices16 = indices16;
    m.vertex_count = 3;
    assert_int_equal(glbk_csm_light_write(&d, words), GLBK_OK);
    d.mesh = NULL;
    OF(ENVIRONMENT);
    NO_LIGHT(d.cosine_power, 1);
    assert_int_equal(glbk_csm_light_texels(NULL), 0);
}

static void csm_light_tables_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static csm_stage s;
    static const float patterns[4 * 128];
    glbk_context *gl = &t->gl;
    lsamp_lobe lobes[2] = { { { -1, -1, 1 }, 10, { 1, 1, 1 } }, { { -1, -1, 1 }, 20, { 1, 1, 1 } } };
    lsamp_light_desc two[2];
    glbk_csm_lights_desc d = { 0 };
    glbk_csm_lights x, none = { 0 };
    uint32_t starts[2];

    csm_stage_make(t, &s);
    two[0] = two[1] = s.light;
    d.lights = two;
    d.light_count = 2;
    d.lobes = lobes;
    d.lobe_count = 2;
    d.patterns = patterns;
    d.pattern_length = 1;
    REFUSED(glbk_csm_lights_create(NULL, &d, starts, &x));
    REFUSED(glbk_csm_lights_create(gl, &d, starts, NULL));
    MAKES(x, glbk_csm_lights_create(gl, NULL, starts, &x));
    MAKES(x, glbk_csm_lights_create(gl, &d, NULL, &x));
    DESC_WRONG(x, d.lights, NULL, glbk_csm_lights_create(gl, &d, starts, &x));
    DESC_WRONG(x, d.lobes, NULL, glbk_csm_lights_create(gl, &d, starts, &x));
    DESC_WRONG(x, d.lobe_count, ((uint32_t)1 << 20) + 1, glbk_csm_lights_create(gl, &d, starts, &x));
    DESC_WRONG(x, d.patterns, NULL, glbk_csm_lights_create(gl, &d, starts, &x));
    DESC_WRONG(x, d.pattern_length, 0, glbk_csm_lights_create(gl, &d, starts, &x));
    DESC_WRONG(x, d.pattern_length, 65537, glbk_csm_lights_create(gl, &d, starts, &x));
    DESC_WRONG(x, two[1].radius, 0, glbk_csm_lights_create(gl, &d, starts, &x));
    assert_string_equal(t->log, "glbk_csm_lights_create: desc.lights[1].radius is 0; it must be 1e-18..1e18");
    DESC_WRONG(x, two[0].direction[2], 0.5f, glbk_csm_lights_create(gl, &d, starts, &x));
    assert_string_equal(t->log, "glbk_csm_lights_create: desc.lights[0].direction: its length is 0.5; it must be "
                                "0.97..1.03");
    {
        static const lsamp_mesh crowd = { patterns, 3 * ((size_t)1 << 26) - 3, 12, NULL, 0, NULL };
        lsamp_light_desc many[2] = { s.light, s.light };       /* 2^26 triangles less one, twice: over 2^28 texels */
        many[0].kind = many[1].kind = LSAMP_LIGHT_MESH;
        many[0].mesh = many[1].mesh = &crowd;
        WRONG_IS(GLBK_ERR_LIMIT, x, d.lights, many, glbk_csm_lights_create(gl, &d, starts, &x));
    }
    assert_glbk(t, glbk_csm_lights_create(gl, &d, starts, &x));
    assert_glbk(t, glbk_csm_lights_update(gl, &x, starts[1], &two[1]));
    REFUSED(glbk_csm_lights_update(NULL, &x, starts[1], &two[1]));
    REFUSED(glbk_csm_lights_update(gl, NULL, starts[1], &two[1]));
    REFUSED(glbk_csm_lights_update(gl, &none, starts[1], &two[1]));
    REFUSED(glbk_csm_lights_update(gl, &x, starts[1], NULL));
    REFUSED(glbk_csm_lights_update(gl, &x, 3, &two[1]));                        /* among the lobes */
    REFUSED(glbk_csm_lights_update(gl, &x, starts[1] + 1, &two[1]));
    REFUSED(glbk_csm_lights_update(gl, &x, x.patterns_at + 1, &two[1]));
    glbk_csm_lights_free(gl, NULL);
    glbk_csm_lights_free(gl, &x);
    csm_stage_free(t, &s);
}

static void csm_frames_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static csm_stage s;
    static float rgba[4 * SIDE * SIDE];
    glbk_context *gl = &t->gl;
    gl_canvas screen = gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 0);
    glbk_csm_renderer_desc d = { SIDE, SIDE, 1, 0, NULL };
    const glbk_gbuffer_desc sizes = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_gbuffer_desc small = { SIDE, 4, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer_desc wide = { SIDE + 1, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer seen, wrong, unmade = { 0 };
    glbk_csm_renderer r, none = { 0 };
    glbk_csm_frame_desc f = { 0 };
    glbk_csm_use use = { 0 };
    glbk_csm_lights no_lights = { 0 };
    glbk_csm_maps no_maps = { 0 };
    glbk_pass pass = { 0 };

    csm_stage_make(t, &s);
    pass.target = &screen.target;
    REFUSED(glbk_csm_renderer_create(NULL, &d, &r));
    REFUSED(glbk_csm_renderer_create(gl, &d, NULL));
    MAKES(r, glbk_csm_renderer_create(gl, NULL, &r));
    DESC_WRONG(r, d.width, 0, glbk_csm_renderer_create(gl, &d, &r));
    DESC_WRONG(r, d.height, 0, glbk_csm_renderer_create(gl, &d, &r));
    DESC_WRONG(r, d.lobe_count, 9, glbk_csm_renderer_create(gl, &d, &r));
    assert_glbk(t, glbk_csm_renderer_create(gl, &d, &r));
    RESIZES(glbk_csm_renderer_resize, r, (glbk_csm_renderer){ .width = 0 });
    assert_glbk(t, glbk_csm_renderer_resize(gl, &r, SIDE, SIDE));
    assert_glbk(t, glbk_gbuffer_create(gl, &sizes, &seen));
    REFUSED(glbk_gbuffer_resize(NULL, &seen, &sizes));
    REFUSED(glbk_gbuffer_resize(gl, NULL, &sizes));
    REFUSED(glbk_gbuffer_resize(gl, &seen, NULL));
    REFUSED(glbk_gbuffer_resize(gl, &(glbk_gbuffer){ 0 }, &sizes));
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_resize(gl, &seen, &(glbk_gbuffer_desc){ .width = SIDE }));
    wide.depth = &seen.depth;
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_gbuffer_resize(gl, &seen, &wide));
    assert_true(seen.width == sizes.width && seen.words[3].name);
    assert_glbk(t, glbk_gbuffer_resize(gl, &seen, &sizes));
    assert_glbk(t, glbk_gbuffer_create(gl, &small, &wrong));

    f.lights = &s.lights;
    f.uses = &use;
    f.use_count = 1;
    use.start = s.start;
    use.kind = LSAMP_LIGHT_DISC;
    use.maps = &s.maps;
    use.sample_count = 1;
    assert_glbk(t, glbk_csm_prepare(gl, &r, &f));
    assert_glbk(t, glbk_csm_render(gl, &r, &seen, &f));
    REFUSED(glbk_csm_prepare(NULL, &r, &f));
    REFUSED(glbk_csm_prepare(gl, NULL, &f));
    REFUSED(glbk_csm_render(NULL, &r, &seen, &f));
    REFUSED(glbk_csm_render(gl, &none, &seen, &f));
    REFUSED(glbk_csm_render(gl, &r, &seen, NULL));
    REFUSED(glbk_csm_render(gl, &r, NULL, &f));
    REFUSED(glbk_csm_render(gl, &r, &unmade, &f));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_csm_render(gl, &r, &wrong, &f));
    DESC_BAD(f.lights, NULL, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.lights, &no_lights, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.uses, NULL, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.plane_count, GLBK_CSM_MAX_PLANES + 1, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.sampling, LSAMP_SAMPLING_COUNT, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.filter, COHSM_FILTER_COUNT, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.bias, NAN, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.offset, NAN, glbk_csm_render(gl, &r, &seen, &f));
    f.plane_count = 2;
    f.planes[0][1] = 1;
    f.planes[1][2] = 0.98f;                     /* lengths from 0.97 to 1.03 are unit */
    assert_glbk(t, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.planes[1][2], 0.96f, glbk_csm_render(gl, &r, &seen, &f));
    assert_string_equal(t->log, "glbk_csm_render: desc.planes[1]'s normal: its length is 0.96; it must be 0.97..1.03");
    DESC_BAD(f.planes[1][2], 0, glbk_csm_prepare(gl, &r, &f));
    DESC_BAD(f.planes[0][1], NAN, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(f.planes[0][3], INFINITY, glbk_csm_render(gl, &r, &seen, &f));
    f.plane_count = 1;                          /* what lies behind the last is not read */
    f.planes[1][2] = 0;
    assert_glbk(t, glbk_csm_render(gl, &r, &seen, &f));
    f.plane_count = 0;
    BAD_IS(GLBK_ERR_LIMIT, r.frame_count, UINT32_MAX, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.maps, NULL, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.maps, &no_maps, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.ask, COHSM_LIGHT_COUNT, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.kind, LSAMP_LIGHT_COUNT, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.kind, LSAMP_LIGHT_CALLBACK, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.sample_count, 0, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.sample_count, 65537, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(use.start, s.lights.patterns_at, glbk_csm_render(gl, &r, &seen, &f));
    DESC_BAD(s.lights.lobe_count, 1, glbk_csm_render(gl, &r, &seen, &f));   /* the light would begin there */
    BAD_IS(GLBK_ERR_MISMATCH, r.patterns, 1, glbk_csm_render(gl, &r, &seen, &f));    /* samples are the length */

    assert_glbk(t, glbk_csm_resolve(gl, &r, &seen, &pass, NULL));
    REFUSED(glbk_csm_resolve(NULL, &r, &seen, &pass, NULL));
    REFUSED(glbk_csm_resolve(gl, NULL, &seen, &pass, NULL));
    REFUSED(glbk_csm_resolve(gl, &none, &seen, &pass, NULL));
    REFUSED(glbk_csm_resolve(gl, &r, &seen, NULL, NULL));
    DESC_BAD(pass.depth, GLBK_DEPTH_COUNT, glbk_csm_resolve(gl, &r, &seen, &pass, NULL));
    assert_glbk(t, glbk_csm_read(gl, &r, rgba));
    REFUSED(glbk_csm_read(NULL, &r, rgba));
    REFUSED(glbk_csm_read(gl, NULL, rgba));
    REFUSED(glbk_csm_read(gl, &none, rgba));
    REFUSED(glbk_csm_read(gl, &r, NULL));
    glbk_csm_reset(NULL);
    glbk_csm_reset(&r);
    ERROR_IS(GLBK_ERR_ORDER, glbk_csm_read(gl, &r, rgba));      /* no frame yet */
    f.use_count = 0;
    assert_glbk(t, glbk_csm_render(gl, &r, &seen, &f));                        /* a frame without light is black */
    rgba[5] = 1;
    assert_glbk(t, glbk_csm_read(gl, &r, rgba));
    assert_float_equal(rgba[5], 0, 0);
    glbk_csm_renderer_free(gl, NULL);
    glbk_csm_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &seen);
    glbk_gbuffer_free(gl, &wrong);
    gl_canvas_free(t, &screen);
    csm_stage_free(t, &s);
}

static void flat_view(void *user, uint32_t index, cohsm_view *out)
{
    (void)user, (void)index;
    memset(out, 0, sizeof *out);
    memcpy(out->matrix, unit, sizeof unit);
    out->depth_scale = 1;
}

static void draw_nothing(void *user, glbk_context *ctx) { (void)user, (void)ctx; }

static void csm_builders_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    cohsm_desc maps;
    const glbk_csm_builder_desc defaults = { NULL, flat_view, draw_nothing, NULL, { 0, 0, 0, 0, NULL, NULL } };
    glbk_csm_builder_desc d = { &maps, flat_view, draw_nothing, NULL, { 0, 0, 0, 0, NULL, NULL } };
    glbk_csm_builder b, none;

    memset(&none, 0, sizeof none);
    memset(&maps, 0, sizeof maps);
    maps.map_side = 4;
    maps.layers = COHSM_LAYERS_Z1Z3_FAR;
    REFUSED(glbk_csm_builder_create(NULL, &d, &b));
    REFUSED(glbk_csm_builder_create(gl, &d, NULL));
    MAKES(b, glbk_csm_builder_create(gl, NULL, &b));
    DESC_WRONG(b, maps.map_side, 3, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, maps.map_side, 1025, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, maps.depth_bits, 3, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, maps.depth_bits, 9, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, maps.open_thickness, -1, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, maps.open_thickness, INFINITY, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, d.view_fn, NULL, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, d.draw_fn, NULL, glbk_csm_builder_create(gl, &d, &b));
    DESC_WRONG(b, maps.layers, COHSM_LAYERS_Z1Z3_SPHERE, glbk_csm_builder_create(gl, &d, &b));
    assert_non_null(strstr(t->log, "COHSM_LAYERS_Z1Z3_SPHERE"));
    DESC_WRONG(b, maps.layers, COHSM_LAYERS_COUNT, glbk_csm_builder_create(gl, &d, &b));
    assert_glbk(t, glbk_csm_builder_create(gl, &defaults, &b));
    assert_int_equal(b.map_side, 128);
    glbk_csm_builder_free(gl, &b);
    assert_glbk(t, glbk_csm_builder_create(gl, &d, &b));
    IS_EARLY(glbk_csm_builder_end(gl, &b));                              /* no view yet */
    IS_EARLY(glbk_csm_builder_compress(gl, &b));                         /* nothing drawn */
    assert_glbk(t, glbk_csm_builder_draw(gl, &b, 0, 3));
    REFUSED(glbk_csm_builder_draw(NULL, &b, 0, 3));
    REFUSED(glbk_csm_builder_draw(gl, NULL, 0, 3));
    REFUSED(glbk_csm_builder_draw(gl, &none, 0, 3));
    REFUSED(glbk_csm_builder_draw(gl, &b, 0, 0));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_csm_builder_draw(gl, &b, 0, b.batch + 1));
    REFUSED(glbk_csm_builder_compress(NULL, &b));
    REFUSED(glbk_csm_builder_compress(gl, NULL));
    REFUSED(glbk_csm_builder_compress(gl, &none));
    REFUSED(glbk_csm_builder_end(gl, &none));
    BAD_IS(GLBK_ERR_ORDER, b.drawn_from, 1, glbk_csm_builder_compress(gl, &b));   /* a view would be left out */
    {
        uint32_t keep = b.drawn_from;
        b.drawn_from = 65534;
        BAD_IS(GLBK_ERR_ORDER, b.next_view, 65534, glbk_csm_builder_compress(gl, &b));    /* over csm.h's lists */
        b.drawn_from = keep;
    }
    assert_glbk(t, glbk_csm_builder_compress(gl, &b));
    IS_EARLY(glbk_csm_builder_compress(gl, &b));                         /* the same views again */
    REFUSED(glbk_csm_builder_end(NULL, &b));
    REFUSED(glbk_csm_builder_end(gl, NULL));
    glbk_csm_builder_free(gl, NULL);
    glbk_csm_builder_free(gl, &b);
}

/* ---- envsh ---- */

static glbk_result cast_nothing(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    (void)user, (void)ctx, (void)maps, (void)instances;
    return GLBK_OK;
}

/* The words of a light that hits straight down; what is not in the list of envshadow/gl_twin_test's views is zero. */
static void envsh_maps_and_frames_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static float rgba[4 * SIDE * SIDE];
    glbk_context *gl = &t->gl;
    gl_canvas screen = gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 0);
    envsh_maps_desc maps = { .map_side = 16, .guard = 2 };
    glbk_envsh_maps_desc d = { 2, &maps, { 0, 0, 0, 0, NULL, NULL } };
    envsh_query q = { ENVSH_FILTER_PENUMBRA, 16, 4, 1, 1, 0, 0 };
    glbk_envsh_maps m, none = { 0 };
    glbk_envsh_renderer r, no_r = { 0 };
    glbk_gbuffer_desc size = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer seen, narrow, no_seen = { 0 };
    glbk_envsh_frame f = { NULL, 0, cast_nothing, NULL, NULL };
    glbk_pass pass = { 0 };
    static const envsh_view three[3];

    pass.target = &screen.target;
    REFUSED(glbk_envsh_maps_create(NULL, &d, &m));
    REFUSED(glbk_envsh_maps_create(gl, &d, NULL));
    MAKES(m, glbk_envsh_maps_create(gl, NULL, &m));
    DESC_WRONG(m, d.capacity, 0, glbk_envsh_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.capacity, ENVSH_MAX_LIGHTS + 1, glbk_envsh_maps_create(gl, &d, &m));
    DESC_WRONG(m, maps.map_side, 15, glbk_envsh_maps_create(gl, &d, &m));
    DESC_WRONG(m, maps.map_side, 4097, glbk_envsh_maps_create(gl, &d, &m));
    DESC_WRONG(m, maps.guard, 5, glbk_envsh_maps_create(gl, &d, &m));
    {
        uint32_t most = gl->max_layers, side = gl->max_side;
        d.capacity = 512;
        maps.map_side = 1024;
        gl->max_side = 1024;                    /* a page for each tile */
        gl->max_layers = 256;
        ERROR_IS(GLBK_ERR_LIMIT, glbk_envsh_maps_create(gl, &d, &m));
        gl->max_layers = 2048;
        d.capacity = 1025;
        ERROR_IS(GLBK_ERR_LIMIT, glbk_envsh_maps_create(gl, &d, &m));
        gl->max_side = 512;                     /* none for any */
        ERROR_IS(GLBK_ERR_LIMIT, glbk_envsh_maps_create(gl, &d, &m));
        gl->max_side = side;
        gl->max_layers = most;
        d.capacity = 2;
        maps.map_side = 16;
    }
    assert_glbk(t, glbk_envsh_maps_create(gl, &d, &m));
    assert_glbk(t, glbk_envsh_maps_render(gl, &m, NULL, 0, cast_nothing, NULL));
    REFUSED(glbk_envsh_maps_render(NULL, &m, NULL, 0, cast_nothing, NULL));
    REFUSED(glbk_envsh_maps_render(gl, NULL, NULL, 0, cast_nothing, NULL));
    REFUSED(glbk_envsh_maps_render(gl, &none, NULL, 0, cast_nothing, NULL));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_envsh_maps_render(gl, &m, three, 3, cast_nothing, NULL));
    REFUSED(glbk_envsh_maps_render(gl, &m, NULL, 1, cast_nothing, NULL));
    REFUSED(glbk_envsh_maps_render(gl, &m, NULL, 0, NULL, NULL));
    REFUSED(glbk_envsh_cast(NULL, &m, NULL));
    REFUSED(glbk_envsh_cast(gl, NULL, NULL));
    REFUSED(glbk_envsh_cast(gl, &none, NULL));

    assert_glbk(t, glbk_envsh_bind(gl, &m, &q, NULL));
    REFUSED(glbk_envsh_bind(NULL, &m, &q, NULL));
    REFUSED(glbk_envsh_bind(gl, NULL, &q, NULL));
    REFUSED(glbk_envsh_bind(gl, &none, &q, NULL));
    assert_glbk(t, glbk_envsh_bind(gl, &m, NULL, NULL));     /* all defaults */
    DESC_BAD(q.filter, ENVSH_FILTER_COUNT, glbk_envsh_bind(gl, &m, &q, NULL));
    DESC_BAD(q.bias, 2e6f, glbk_envsh_bind(gl, &m, &q, NULL));
    DESC_BAD(q.radius, 65, glbk_envsh_bind(gl, &m, &q, NULL));
    DESC_BAD(q.tap_count, ENVSH_MAX_TAPS + 1, glbk_envsh_bind(gl, &m, &q, NULL));
    DESC_BAD(q.extent_scale, 2e6f, glbk_envsh_bind(gl, &m, &q, NULL));
    q.filter = ENVSH_FILTER_PCF;
    DESC_BAD(q.radius, 33, glbk_envsh_bind(gl, &m, &q, NULL));
    q.filter = ENVSH_FILTER_SMOOTH;
    q.tap_count = 0;                                 /* not asked for */
    assert_glbk(t, glbk_envsh_bind(gl, &m, &q, NULL));
    DESC_BAD(q.radius, 0.25f, glbk_envsh_bind(gl, &m, &q, NULL));
    DESC_BAD(q.radius, 9, glbk_envsh_bind(gl, &m, &q, NULL));
    q.filter = ENVSH_FILTER_PLAIN;
    q.radius = -1;
    assert_glbk(t, glbk_envsh_bind(gl, &m, &q, NULL));

    REFUSED(glbk_envsh_renderer_create(NULL, &(glbk_envsh_renderer_desc){ SIDE, SIDE }, &r));
    REFUSED(glbk_envsh_renderer_create(gl, &(glbk_envsh_renderer_desc){ SIDE, SIDE }, NULL));
    MAKES(r, glbk_envsh_renderer_create(gl, NULL, &r));
    MAKES_IS(GLBK_ERR_DESC, r, glbk_envsh_renderer_create(gl, &(glbk_envsh_renderer_desc){ 0, SIDE }, &r));
    MAKES_IS(GLBK_ERR_DESC, r, glbk_envsh_renderer_create(gl, &(glbk_envsh_renderer_desc){ SIDE, 0 }, &r));
    assert_glbk(t, glbk_envsh_renderer_create(gl, &(glbk_envsh_renderer_desc){ SIDE, SIDE }, &r));
    RESIZES(glbk_envsh_renderer_resize, r, (glbk_envsh_renderer){ .width = 0 });
    assert_glbk(t, glbk_envsh_renderer_resize(gl, &r, SIDE, SIDE));
    assert_glbk(t, glbk_gbuffer_create(gl, &size, &seen));
    size.width = SIDE - 1;
    assert_glbk(t, glbk_gbuffer_create(gl, &size, &narrow));
    assert_glbk(t, glbk_envsh_shade(gl, &r, &seen, &m, &q, 0));
    assert_glbk(t, glbk_envsh_shade(gl, &r, &seen, &m, NULL, 0));
    REFUSED(glbk_envsh_shade(NULL, &r, &seen, &m, &q, 0));
    REFUSED(glbk_envsh_shade(gl, NULL, &seen, &m, &q, 0));
    REFUSED(glbk_envsh_shade(gl, &no_r, &seen, &m, &q, 0));
    REFUSED(glbk_envsh_shade(gl, &r, NULL, &m, &q, 0));
    REFUSED(glbk_envsh_shade(gl, &r, &no_seen, &m, &q, 0));
    REFUSED(glbk_envsh_shade(gl, &r, &seen, NULL, &q, 0));
    REFUSED(glbk_envsh_shade(gl, &r, &seen, &none, &q, 0));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_envsh_shade(gl, &r, &narrow, &m, &q, 0));
    assert_glbk(t, glbk_envsh_illuminate(gl, &r, &seen, &m, &f));
    REFUSED(glbk_envsh_illuminate(NULL, &r, &seen, &m, &f));
    REFUSED(glbk_envsh_illuminate(gl, NULL, &seen, &m, &f));
    REFUSED(glbk_envsh_illuminate(gl, &r, NULL, &m, &f));
    REFUSED(glbk_envsh_illuminate(gl, &r, &seen, NULL, &f));
    REFUSED(glbk_envsh_illuminate(gl, &r, &seen, &none, &f));
    REFUSED(glbk_envsh_illuminate(gl, &r, &seen, &m, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_envsh_illuminate(gl, &r, &narrow, &m, &f));
    BAD(f.view_count, 1, glbk_envsh_illuminate(gl, &r, &seen, &m, &f));
    BAD(f.draw_fn, NULL, glbk_envsh_illuminate(gl, &r, &seen, &m, &f));
    assert_glbk(t, glbk_envsh_resolve(gl, &r, &seen, &pass, NULL));
    REFUSED(glbk_envsh_resolve(NULL, &r, &seen, &pass, NULL));
    REFUSED(glbk_envsh_resolve(gl, NULL, &seen, &pass, NULL));
    REFUSED(glbk_envsh_resolve(gl, &no_r, &seen, &pass, NULL));
    REFUSED(glbk_envsh_resolve(gl, &r, NULL, &pass, NULL));
    REFUSED(glbk_envsh_resolve(gl, &r, &seen, NULL, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_envsh_resolve(gl, &r, &narrow, &pass, NULL));
    DESC_BAD(pass.blend, GLBK_BLEND_COUNT, glbk_envsh_resolve(gl, &r, &seen, &pass, NULL));
    rgba[5] = 1;
    assert_glbk(t, glbk_envsh_read(gl, &r, rgba));
    assert_float_equal(rgba[5], 0, 0);          /* no light yet */
    REFUSED(glbk_envsh_read(NULL, &r, rgba));
    REFUSED(glbk_envsh_read(gl, NULL, rgba));
    REFUSED(glbk_envsh_read(gl, &no_r, rgba));
    REFUSED(glbk_envsh_read(gl, &r, NULL));
    glbk_envsh_renderer_free(gl, NULL);
    glbk_envsh_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &seen);
    glbk_gbuffer_free(gl, &narrow);
    glbk_envsh_maps_free(gl, NULL);
    glbk_envsh_maps_free(gl, &m);
    gl_canvas_free(t, &screen);
}

/* ---- rsm ---- */

static void rsm_maps_refuse_bad_lights(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    static rsm_texel texels[4 * 4];
    rsm_light l = { RSM_LIGHT_SPOT, { 0, 0, 0 }, { 0, 0, -1 }, { 0, 1, 0 }, { 1, 1, 1 }, 1, 0.5f, 0.1f, 10 };
    glbk_rsm_map m, none = { 0 };
    int i;

    REFUSED(glbk_rsm_map_create(NULL, &l, 4, &m));
    REFUSED(glbk_rsm_map_create(gl, &l, 4, NULL));
    MAKES(m, glbk_rsm_map_create(gl, NULL, 4, &m));
    MAKES(m, glbk_rsm_map_create(gl, &l, 3, &m));
    MAKES(m, glbk_rsm_map_create(gl, &l, 4097, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.kind, RSM_LIGHT_COUNT, glbk_rsm_map_create(gl, &l, 4, &m));
    for (i = 0; i < 3; i++) {
        WRONG_IS(GLBK_ERR_DESC, m, l.position[i], 2e9f, glbk_rsm_map_create(gl, &l, 4, &m));
        WRONG_IS(GLBK_ERR_DESC, m, l.up[i], NAN, glbk_rsm_map_create(gl, &l, 4, &m));
        WRONG_IS(GLBK_ERR_DESC, m, l.value[i], -1, glbk_rsm_map_create(gl, &l, 4, &m));
        WRONG_IS(GLBK_ERR_DESC, m, l.value[i], 2e12f, glbk_rsm_map_create(gl, &l, 4, &m));
    }
    WRONG_IS(GLBK_ERR_DESC, m, l.direction[2], 0, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.cone_half_angle, 0, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.cone_half_angle, 3.15f, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.near_depth, 10, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.near_depth, -2e9f, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.near_depth, -1, glbk_rsm_map_create(gl, &l, 4, &m));        /* a sun may */
    WRONG_IS(GLBK_ERR_DESC, m, l.far_depth, 2e9f, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.far_depth, 0, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.near_depth, 0, glbk_rsm_map_create(gl, &l, 4, &m));
    l.kind = RSM_LIGHT_SQUARE_SPOT;
    assert_glbk(t, glbk_rsm_map_create(gl, &l, 4, &m));
    glbk_rsm_map_free(gl, &m);
    WRONG_IS(GLBK_ERR_DESC, m, l.cone_half_angle, 0, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.cone_half_angle, 1.05f, glbk_rsm_map_create(gl, &l, 4, &m));
    l.kind = RSM_LIGHT_SUN;
    WRONG_IS(GLBK_ERR_DESC, m, l.radius, 0, glbk_rsm_map_create(gl, &l, 4, &m));
    WRONG_IS(GLBK_ERR_DESC, m, l.radius, 2e9f, glbk_rsm_map_create(gl, &l, 4, &m));
    l.kind = RSM_LIGHT_DEFAULT;                                          /* a sun, with its depths by its radius */
    l.near_depth = l.far_depth = 0;
    l.radius = 3;
    assert_glbk(t, glbk_rsm_map_create(gl, &l, 0, &m));
    assert_int_equal(m.side, 512);
    assert_int_equal(m.light.kind, RSM_LIGHT_SUN);
    assert_float_equal(m.light.near_depth, -3, 0);
    assert_float_equal(m.light.far_depth, 3, 0);
    glbk_rsm_map_free(gl, &m);
    l.kind = RSM_LIGHT_POINT;
    assert_glbk(t, glbk_rsm_map_create(gl, &l, 0, &m));
    assert_int_equal(m.side, 256);
    assert_int_equal(m.face_count, 6);
    assert_float_equal(m.light.near_depth, 1e-3f, 0);
    glbk_rsm_map_free(gl, &m);
    l.kind = RSM_LIGHT_SPOT;

    assert_glbk(t, glbk_rsm_map_create(gl, &l, 4, &m));
    assert_glbk(t, glbk_rsm_map_place(gl, &m, &l));
    REFUSED(glbk_rsm_map_place(NULL, &m, &l));
    REFUSED(glbk_rsm_map_place(gl, NULL, &l));
    REFUSED(glbk_rsm_map_place(gl, &none, &l));
    REFUSED(glbk_rsm_map_place(gl, &m, NULL));
    BAD_IS(GLBK_ERR_DESC, l.cone_half_angle, 0, glbk_rsm_map_place(gl, &m, &l));
    BAD_IS(GLBK_ERR_MISMATCH, l.cone_half_angle, 1.5f, glbk_rsm_map_place(gl, &m, &l));               /* six faces */
    assert_glbk(t, glbk_rsm_map_upload(gl, &m, texels));
    REFUSED(glbk_rsm_map_upload(NULL, &m, texels));
    REFUSED(glbk_rsm_map_upload(gl, NULL, texels));
    REFUSED(glbk_rsm_map_upload(gl, &none, texels));
    REFUSED(glbk_rsm_map_upload(gl, &m, NULL));
    assert_glbk(t, glbk_rsm_map_read(gl, &m, 0, texels));
    REFUSED(glbk_rsm_map_read(NULL, &m, 0, texels));
    REFUSED(glbk_rsm_map_read(gl, NULL, 0, texels));
    REFUSED(glbk_rsm_map_read(gl, &none, 0, texels));
    REFUSED(glbk_rsm_map_read(gl, &m, 1, texels));
    REFUSED(glbk_rsm_map_read(gl, &m, 0, NULL));
    glbk_rsm_map_free(gl, NULL);
    glbk_rsm_map_free(gl, &m);
}

static void draw_no_scene(void *user, glbk_context *ctx, glbk_rsm_renderer *r) { (void)user, (void)ctx, (void)r; }

static void rsm_renderers_and_tables_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static const float floats[64];
    glbk_context *gl = &t->gl;
    rsm_light l = { RSM_LIGHT_SPOT, { 0, 0, 0 }, { 0, 0, -1 }, { 0, 1, 0 }, { 1, 1, 1 }, 1, 0.5f, 0.1f, 10 };
    static const rsm_material materials[2], shining = { { 2, 0, 0 }, 1 };
    static const float two[4] = { 0, 0, 2, 0 };
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 1, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    rsm_gather_desc tables;
    glbk_rsm_renderer r, none = { 0 };
    glbk_rsm_map m, no_map = { 0 };
    glbk_surface surface;

    REFUSED(glbk_rsm_renderer_create(NULL, &d, &r));
    REFUSED(glbk_rsm_renderer_create(gl, &d, NULL));
    MAKES(r, glbk_rsm_renderer_create(gl, NULL, &r));
    WRONG_IS(GLBK_ERR_DESC, r, d.width, 0, glbk_rsm_renderer_create(gl, &d, &r));
    WRONG_IS(GLBK_ERR_DESC, r, d.height, 0, glbk_rsm_renderer_create(gl, &d, &r));
    WRONG_IS(GLBK_ERR_LIMIT, r, d.height, gl->max_side + 1, glbk_rsm_renderer_create(gl, &d, &r));
    WRONG_IS(GLBK_ERR_DESC, r, d.lights_per_pass, 32769, glbk_rsm_renderer_create(gl, &d, &r));
    assert_glbk(t, glbk_rsm_renderer_create(gl, &d, &r));
    RESIZES(glbk_rsm_renderer_resize, r, (glbk_rsm_renderer){ .width = 0 });
    assert_glbk(t, glbk_rsm_renderer_resize(gl, &r, SIDE, SIDE));
    memset(&surface, 0, sizeof surface);
    memset(&tables, 0, sizeof tables);
    tables.pattern = RSM_PATTERN_POISSON;
    tables.sample_count = 15;
    tables.interleave = 2;
    tables.noise = floats;
    tables.noise_side = 2;
    tables.materials = materials;
    tables.material_count = 2;
    assert_int_equal(glbk_rsm_point_count(&tables), 16);        /* sets of equal size */
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    REFUSED(glbk_rsm_tables_upload(NULL, &r, &tables, floats));
    REFUSED(glbk_rsm_tables_upload(gl, NULL, &tables, floats));
    REFUSED(glbk_rsm_tables_upload(gl, &none, &tables, floats));
    REFUSED(glbk_rsm_tables_upload(gl, &r, &tables, NULL));
    REFUSED(glbk_rsm_tables_upload(gl, &r, NULL, floats));
    BAD(tables.sample_count, 0, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_DESC, tables.noise_side, 0, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_INPUT, tables.noise, two, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_DESC, tables.materials, NULL, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_INPUT, tables.materials, &shining, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_DESC, tables.sample_count, 4097, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_LIMIT, tables.noise_side, 1025, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    BAD_IS(GLBK_ERR_LIMIT, tables.material_count, 1025, glbk_rsm_tables_upload(gl, &r, &tables, floats));
    assert_int_equal(r.point_count, 16);        /* a refused upload leaves the tables */
    assert_int_equal(r.noise_side, 2);

    assert_glbk(t, glbk_rsm_map_create(gl, &l, 4, &m));
    assert_glbk(t, glbk_rsm_map_draw(gl, &r, &m, draw_no_scene, NULL));
    REFUSED(glbk_rsm_map_draw(NULL, &r, &m, draw_no_scene, NULL));
    REFUSED(glbk_rsm_map_draw(gl, NULL, &m, draw_no_scene, NULL));
    REFUSED(glbk_rsm_map_draw(gl, &none, &m, draw_no_scene, NULL));
    REFUSED(glbk_rsm_map_draw(gl, &r, NULL, draw_no_scene, NULL));
    REFUSED(glbk_rsm_map_draw(gl, &r, &no_map, draw_no_scene, NULL));
    REFUSED(glbk_rsm_map_draw(gl, &r, &m, NULL, NULL));
    ERROR_IS(GLBK_ERR_ORDER, glbk_rsm_object(gl, &r, &surface, 0));        /* outside a glbk_rsm_draw_fn */
    r.drawing = 1;
    assert_glbk(t, glbk_rsm_object(gl, &r, &surface, 0));
    REFUSED(glbk_rsm_object(NULL, &r, &surface, 0));
    REFUSED(glbk_rsm_object(gl, NULL, &surface, 0));
    REFUSED(glbk_rsm_object(gl, &r, NULL, 0));
    r.drawing = 0;
    glbk_rsm_map_free(gl, &m);
    glbk_rsm_renderer_free(gl, NULL);
    glbk_rsm_renderer_free(gl, &r);
}

static void rsm_passes_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static const float points[3 * 16];
    static const rsm_material lobe;
    static float rgba[4 * SIDE * SIDE];
    glbk_context *gl = &t->gl;
    gl_canvas screen = gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 0);
    rsm_light l = { RSM_LIGHT_SPOT, { 0, 0, 0 }, { 0, 0, -1 }, { 0, 1, 0 }, { 1, 1, 1 }, 1, 0.5f, 0.1f, 10 };
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_rsm_renderer_desc plain = { SIDE, SIDE, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_rsm_renderer r, none = { 0 }, bare;
    glbk_rsm_map m, no_map = { 0 }, *maps[1] = { &m }, *bad[1] = { NULL }, *unmade[1] = { &no_map };
    const glbk_rsm_map *seen[1] = { &m }, *nothing[1] = { NULL }, *unseen[1] = { &no_map };
    const glbk_gbuffer_desc size = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_gbuffer_desc half = { SIDE, SIDE / 2, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer sight, small, blind = { 0 };
    rsm_direct_desc direct;
    rsm_gather_desc g;
    rsm_interpolation grid;
    gifilt_frame filter;
    glbk_texture no_motion = { 0 };
    glbk_pass pass = { 0 };
    uint8_t mask;
    float matrix[16];

    pass.target = &screen.target;
    memcpy(matrix, unit, sizeof unit);
    memset(&direct, 0, sizeof direct);
    memset(&g, 0, sizeof g);
    memset(&grid, 0, sizeof grid);
    memset(&filter, 0, sizeof filter);
    g.pattern = RSM_PATTERN_POISSON;
    g.sample_count = 16;
    g.r_max = 1;
    assert_glbk(t, glbk_gbuffer_create(gl, &size, &sight));
    assert_glbk(t, glbk_gbuffer_create(gl, &half, &small));
    assert_glbk(t, glbk_rsm_renderer_create(gl, &plain, &bare));
    assert_glbk(t, glbk_rsm_renderer_create(gl, &d, &r));
    assert_glbk(t, glbk_rsm_map_create(gl, &l, 4, &m));
    assert_glbk(t, glbk_rsm_map_draw(gl, &r, &m, draw_no_scene, NULL));
    ERROR_IS(GLBK_ERR_ORDER, glbk_rsm_read(gl, &r, 0, rgba));   /* neither light is there yet */
    ERROR_IS(GLBK_ERR_ORDER, glbk_rsm_read(gl, &r, 1, rgba));
    ERROR_IS(GLBK_ERR_ORDER, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    assert_glbk(t, glbk_rsm_resolve(gl, &r, &sight, &pass, NULL, 1, 1));

    assert_glbk(t, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    REFUSED(glbk_rsm_direct(NULL, &r, &sight, seen, 1, &direct));
    REFUSED(glbk_rsm_direct(gl, NULL, &sight, seen, 1, &direct));
    REFUSED(glbk_rsm_direct(gl, &none, &sight, seen, 1, &direct));
    REFUSED(glbk_rsm_direct(gl, &r, &sight, NULL, 1, &direct));
    REFUSED(glbk_rsm_direct(gl, &r, &sight, seen, 0, &direct));
    REFUSED(glbk_rsm_direct(gl, &r, &sight, nothing, 1, &direct));
    REFUSED(glbk_rsm_direct(gl, &r, &sight, unseen, 1, &direct));
    assert_glbk(t, glbk_rsm_direct(gl, &r, &sight, seen, 1, NULL));
    BAD_IS(GLBK_ERR_DESC, direct.tap_side, 16, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    BAD_IS(GLBK_ERR_DESC, direct.bias, -2e6f, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    BAD_IS(GLBK_ERR_DESC, direct.bias, 2e6f, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    BAD_IS(GLBK_ERR_DESC, direct.slope_bias, -2e6f, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    BAD_IS(GLBK_ERR_DESC, direct.slope_bias, NAN, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    BAD_IS(GLBK_ERR_DESC, direct.add, 1, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    BAD_IS(GLBK_ERR_DESC, direct.system.user, &r, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));
    assert_non_null(strstr(t->log, "glbk_rsm_direct: desc.system"));
    REFUSED(glbk_rsm_direct(gl, &r, NULL, seen, 1, &direct));
    REFUSED(glbk_rsm_direct(gl, &r, &blind, seen, 1, &direct));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_direct(gl, &r, &small, seen, 1, &direct));
    direct.tap_side = 3;
    assert_glbk(t, glbk_rsm_direct(gl, &r, &sight, seen, 1, &direct));

    BAD_IS(GLBK_ERR_MISMATCH, g.seed, 0, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g)); /* no points */
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &g, points));
    assert_glbk(t, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    REFUSED(glbk_rsm_gather(NULL, &r, &sight, maps, 1, &g));
    REFUSED(glbk_rsm_gather(gl, NULL, &sight, maps, 1, &g));
    REFUSED(glbk_rsm_gather(gl, &none, &sight, maps, 1, &g));
    REFUSED(glbk_rsm_gather(gl, &r, &sight, NULL, 1, &g));
    REFUSED(glbk_rsm_gather(gl, &r, &sight, maps, 0, &g));
    REFUSED(glbk_rsm_gather(gl, &r, &sight, bad, 1, &g));
    REFUSED(glbk_rsm_gather(gl, &r, &sight, unmade, 1, &g));
    assert_glbk(t, glbk_rsm_gather(gl, &r, &sight, maps, 1, NULL));      /* every texel */
    assert_glbk(t, glbk_rsm_gather(gl, &r, NULL, maps, 1, NULL));       /* no pixels: the list alone */
    ERROR_IS(GLBK_ERR_ORDER, glbk_rsm_read(gl, &r, 1, rgba));
    REFUSED(glbk_rsm_gather(gl, &r, &blind, maps, 1, NULL));
    REFUSED(glbk_rsm_interpolate(gl, &r, NULL, maps, 1, NULL, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_gather(gl, &r, &small, maps, 1, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_interpolate(gl, &r, &small, maps, 1, NULL, NULL));
    assert_glbk(t, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, NULL, NULL));
    BAD_IS(GLBK_ERR_DESC, g.pattern, RSM_PATTERN_COUNT, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.sample_count, (1u << 20) + 1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.sample_count, 4097, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.interleave, 16, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.interleave, 3, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.r_max, -1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.r_max, 2e3f, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.r_min, -1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.r_min, 1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.offset, -1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.offset, 2e9f, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.clamp, -1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.clamp, 2e18f, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.near_limit, -1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.near_limit, 2e6f, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.near_field, -1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.near_field, 33, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.material_count, 1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.noise, points, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.add, 1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    BAD_IS(GLBK_ERR_DESC, g.system.user, &r, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    assert_non_null(strstr(t->log, "glbk_rsm_gather: desc.system"));
    BAD_IS(GLBK_ERR_MISMATCH, g.pattern, RSM_PATTERN_LOG_RADIAL, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    assert_non_null(strstr(t->log, "glbk_rsm_gather: desc.pattern"));
    BAD_IS(GLBK_ERR_MISMATCH, g.sample_count, 12, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    assert_non_null(strstr(t->log, "glbk_rsm_gather: desc.sample_count"));
    BAD_IS(GLBK_ERR_MISMATCH, g.interleave, 2, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    assert_non_null(strstr(t->log, "glbk_rsm_gather: desc.interleave"));
    BAD_IS(GLBK_ERR_MISMATCH, g.seed, 1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    assert_non_null(strstr(t->log, "glbk_rsm_gather: desc.seed"));
    g.material_count = 1;
    BAD_IS(GLBK_ERR_MISMATCH, g.materials, &lobe, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    assert_non_null(strstr(t->log, "glbk_rsm_gather: desc.material_count"));
    g.material_count = 0;
    g.noise_side = 2;
    BAD_IS(GLBK_ERR_MISMATCH, g.noise, points, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    g.noise_side = 0;
    g.pattern = RSM_PATTERN_EQUATION3;
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &g, points));
    BAD_IS(GLBK_ERR_MISMATCH, g.paper_weights, 1, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    g.pattern = RSM_PATTERN_LOG_RADIAL;
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &g, points));
    BAD_IS(GLBK_ERR_MISMATCH, g.r_min, 0.5f, glbk_rsm_gather(gl, &r, &sight, maps, 1, &g));
    g.r_min = 1.0f / 32.0f;                                             /* which 0 says */

    assert_glbk(t, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    REFUSED(glbk_rsm_interpolate(NULL, &r, &sight, maps, 1, &g, &grid));
    REFUSED(glbk_rsm_interpolate(gl, NULL, &sight, maps, 1, &g, &grid));
    REFUSED(glbk_rsm_interpolate(gl, &r, &sight, NULL, 1, &g, &grid));
    assert_glbk(t, glbk_rsm_tables_upload(gl, &bare, &g, points));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_interpolate(gl, &bare, &sight, maps, 1, &g, &grid));  /* no memory */
    g.noise = points;
    g.noise_side = 1;
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &g, points));
    ERROR_IS(GLBK_ERR_DESC, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    g.noise = NULL;
    g.noise_side = 0;
    g.interleave = 2;
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &g, points));
    ERROR_IS(GLBK_ERR_DESC, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    g.interleave = 0;
    assert_glbk(t, glbk_rsm_tables_upload(gl, &r, &g, points));
    BAD_IS(GLBK_ERR_DESC, grid.step, 1, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.step, 128, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.step, 12, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.level_count, 7, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.normal_cosine, 1.5f, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.plane_slope, -1, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.plane_slope, 2e6f, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.distance, -1, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.distance, 2e9f, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.contrast, 2e6f, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.light_share, -2e6f, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    BAD_IS(GLBK_ERR_DESC, grid.mask, &mask, glbk_rsm_interpolate(gl, &r, &sight, maps, 1, &g, &grid));
    assert_non_null(strstr(t->log, "glbk_rsm_interpolate: interpolation.mask"));

    REFUSED(glbk_rsm_denoise(NULL, &r, &sight, &filter, NULL));
    REFUSED(glbk_rsm_denoise(gl, NULL, &sight, &filter, NULL));
    REFUSED(glbk_rsm_denoise(gl, &r, &sight, &filter, &no_motion));
    REFUSED(glbk_rsm_denoise(gl, &r, NULL, &filter, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_denoise(gl, &r, &small, &filter, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_denoise(gl, &bare, &sight, &filter, NULL));    /* no memory for it */
    BAD_IS(GLBK_ERR_DESC, filter.rows, GIFILT_ROWS_COUNT, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.passes, 7, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.history, 1001, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.normal_cosine, -0.1f, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.normal_cosine, 1, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.plane_slope, -1, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.plane_slope, 2e6f, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    BAD_IS(GLBK_ERR_DESC, filter.motion, points, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    assert_non_null(strstr(t->log, "glbk_rsm_denoise: frame.motion"));
    filter.world_to_clip = matrix;
    BAD_IS(GLBK_ERR_DESC, matrix[15], INFINITY, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    assert_glbk(t, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));
    ERROR_IS(GLBK_ERR_ORDER, glbk_rsm_denoise(gl, &r, &sight, &filter, NULL));  /* twice */

    assert_glbk(t, glbk_rsm_resolve(gl, &r, &sight, &pass, NULL, 1, 1));
    REFUSED(glbk_rsm_resolve(NULL, &r, &sight, &pass, NULL, 1, 1));
    REFUSED(glbk_rsm_resolve(gl, NULL, &sight, &pass, NULL, 1, 1));
    REFUSED(glbk_rsm_resolve(gl, &none, &sight, &pass, NULL, 1, 1));
    REFUSED(glbk_rsm_resolve(gl, &r, &sight, NULL, NULL, 1, 1));
    REFUSED(glbk_rsm_resolve(gl, &r, NULL, &pass, NULL, 1, 1));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_rsm_resolve(gl, &r, &small, &pass, NULL, 1, 1));
    assert_glbk(t, glbk_rsm_read(gl, &r, 0, rgba));
    assert_glbk(t, glbk_rsm_read(gl, &r, 1, rgba));
    REFUSED(glbk_rsm_read(NULL, &r, 0, rgba));
    REFUSED(glbk_rsm_read(gl, NULL, 0, rgba));
    REFUSED(glbk_rsm_read(gl, &r, 0, NULL));
    glbk_rsm_bind(NULL, &r, &m, NULL);
    glbk_rsm_bind(gl, NULL, NULL, NULL);
    glbk_rsm_reset(NULL);
    glbk_rsm_map_free(gl, &m);
    glbk_rsm_renderer_free(gl, &r);
    glbk_rsm_renderer_free(gl, &bare);
    glbk_gbuffer_free(gl, &sight);
    glbk_gbuffer_free(gl, &small);
    gl_canvas_free(t, &screen);
}

/* ---- ism ---- */

static const float ism_corners[12] = { -1, 1, -1, 1, 1, -1, -1, 1, 1, 1, 1, 1 };
static const uint32_t ism_indices[6] = { 0, 1, 2, 1, 3, 2 };

/* One VPL of eight by eight texels and eight surfels, one near point. */
static ism_desc ism_sizes(void)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = d.lazy_frames = 1;
    d.surfel_count = d.tile_side = 8;
    d.near_point_count = 1;
    d.window_rim = 2;
    return d;
}

/* The ranges are those of ism_create; none and zero, the defaults, are taken. */
static void ism_maps_refuse_bad_descs(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    ism_desc d = ism_sizes();
    glbk_ism_maps m;
    REFUSED(glbk_ism_maps_create(NULL, &d, &m));
    REFUSED(glbk_ism_maps_create(gl, &d, NULL));
    DESC_WRONG(m, d.vpl_count, 16385, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.surfel_count, 7, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.surfel_count, 65537, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.projection, ISM_PROJECTION_COUNT, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.lazy_frames, 65, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.tile_side, 4, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.tile_side, 512, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.tile_side, 24, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.splat_scale, -1, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.splat_scale, 17, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.splat_scale, NAN, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.near_point_count, 65, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.window_rim, 1, glbk_ism_maps_create(gl, &d, &m));
    DESC_WRONG(m, d.window_rim, 5, glbk_ism_maps_create(gl, &d, &m));       /* more than half of eight texels */
    {
        uint32_t side = gl->max_side;
        gl->max_side = 4;
        MAKES_IS(GLBK_ERR_LIMIT, m, glbk_ism_maps_create(gl, &d, &m));
        gl->max_side = side;
    }
    d.near_point_count = d.window_rim = -1;
    assert_glbk(t, glbk_ism_maps_create(gl, &d, &m));
    assert_true(m.desc.near_point_count == 0 && m.desc.window_rim == 0);
    glbk_ism_maps_free(gl, NULL);
    glbk_ism_maps_free(gl, &m);
}

static void ism_meshes_and_surfels_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static const ism_surfel surfels[8];
    glbk_context *gl = &t->gl;
    const ism_desc d = ism_sizes();
    ism_mesh mesh = { ism_corners, 4, 12, ism_indices, 6, NULL, NULL, NULL, NULL, NULL };
    glbk_ism_maps m, none;
    memset(&none, 0, sizeof none);
    assert_glbk(t, glbk_ism_maps_create(gl, &d, &m));
    ERROR_IS(GLBK_ERR_ORDER, glbk_ism_mesh_move(gl, &m, ism_corners, 0));       /* of what? */
    assert_glbk(t, glbk_ism_mesh_upload(gl, &m, &mesh));
    REFUSED(glbk_ism_mesh_upload(NULL, &m, &mesh));
    REFUSED(glbk_ism_mesh_upload(gl, NULL, &mesh));
    REFUSED(glbk_ism_mesh_upload(gl, &none, &mesh));
    BAD(mesh.vertex_stride, 8, glbk_ism_mesh_upload(gl, &m, &mesh));
    BAD(mesh.vertex_stride, 14, glbk_ism_mesh_upload(gl, &m, &mesh));
    BAD(mesh.index_count, 5, glbk_ism_mesh_upload(gl, &m, &mesh));
    BAD(mesh.positions, NULL, glbk_ism_mesh_upload(gl, &m, &mesh));
    BAD_IS(GLBK_ERR_INPUT, mesh.vertex_count, 3, glbk_ism_mesh_upload(gl, &m, &mesh));  /* an index beyond it */
    BAD(mesh.indices, NULL, glbk_ism_mesh_upload(gl, &m, &mesh));       /* four corners are no triangles */
    {
        static const uint16_t both[6] = { 0, 1, 2, 1, 3, 2 };
        BAD(mesh.indices16, both, glbk_ism_mesh_upload(gl, &m, &mesh));
    }
    BAD_IS(GLBK_ERR_LIMIT, mesh.index_count, 3 * (size_t)0x40000000, glbk_ism_mesh_upload(gl, &m, &mesh));
    BAD_IS(GLBK_ERR_LIMIT, mesh.vertex_count, 0x80000000u, glbk_ism_mesh_upload(gl, &m, &mesh));
    assert_glbk(t, glbk_ism_mesh_move(gl, &m, ism_corners, 0));
    REFUSED(glbk_ism_mesh_move(NULL, &m, ism_corners, 0));
    REFUSED(glbk_ism_mesh_move(gl, NULL, ism_corners, 0));
    REFUSED(glbk_ism_mesh_move(gl, &none, ism_corners, 0));
    REFUSED(glbk_ism_mesh_move(gl, &m, NULL, 0));
    REFUSED(glbk_ism_mesh_move(gl, &m, ism_corners, 8));
    ERROR_IS(GLBK_ERR_ORDER, glbk_ism_draw(gl, &m, 0));         /* no surfels yet */
    assert_glbk(t, glbk_ism_surfels_upload(gl, &m, 0, surfels, 8));
    REFUSED(glbk_ism_surfels_upload(NULL, &m, 0, surfels, 8));
    REFUSED(glbk_ism_surfels_upload(gl, NULL, 0, surfels, 8));
    REFUSED(glbk_ism_surfels_upload(gl, &none, 0, surfels, 8));
    REFUSED(glbk_ism_surfels_upload(gl, &m, 0, NULL, 8));
    REFUSED(glbk_ism_surfels_upload(gl, &m, 1, surfels, 8));
    assert_glbk(t, glbk_ism_draw(gl, &m, 0));
    glbk_ism_maps_free(gl, &m);
}

static void ism_vpls_and_near_points_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const ism_desc d = ism_sizes();
    const glbk_result bad = GLBK_ERR_INPUT;
    ism_vpl v = { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 1, 1 }, { 0, -1, 0 }, 1, 0, 0.1f, 1, 0, 0, 0, 0, 0 };
    ism_near_point p = { { 0, 2, 0 }, 0.1f, { 0, -1, 0 }, 1, { 1, 1, 1 }, 0 };
    ism_info info;
    glbk_ism_maps m, none;
    int k;
    memset(&none, 0, sizeof none);
    memset(&info, 0, sizeof info);
    info.center[1] = 1;
    info.radius = 2;
    assert_glbk(t, glbk_ism_maps_create(gl, &d, &m));
    assert_glbk(t, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    REFUSED(glbk_ism_vpls_upload(NULL, &m, &v, 1, &info));
    REFUSED(glbk_ism_vpls_upload(gl, NULL, &v, 1, &info));
    REFUSED(glbk_ism_vpls_upload(gl, &none, &v, 1, &info));
    REFUSED(glbk_ism_vpls_upload(gl, &m, NULL, 1, &info));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_ism_vpls_upload(gl, &m, &v, 2, &info));
    REFUSED(glbk_ism_vpls_upload(gl, &m, &v, 1, NULL));
    BAD_IS(bad, info.radius, 0, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));     /* directional: of what size? */
    BAD_IS(bad, info.radius, -1, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, info.radius, INFINITY, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    for (k = 0; k < 3; k++) BAD_IS(bad, info.center[k], NAN, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    for (k = 0; k < 3; k++) {
        BAD_IS(bad, v.position[k], NAN, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
        BAD_IS(bad, v.normal[k], NAN, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
        BAD_IS(bad, v.flux[k], INFINITY, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
        BAD_IS(bad, v.flux[k], -1, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
        BAD_IS(bad, v.axis[k], NAN, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    }
    BAD_IS(bad, v.normal[1], -1.1f, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));        /* not unit */
    BAD_IS(bad, v.axis[1], 0, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.exponent, -1, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.exponent, 2e5f, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.edge, -0.5f, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.edge, INFINITY, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.reach, -0.5f, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.reach, NAN, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.window, 1u << 24, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    /* nothing is left of a side */
    BAD_IS(bad, v.window, 32u | 32u << 12, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    BAD_IS(bad, v.window, 63u << 6 | 1u << 18, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    assert_non_null(strstr(t->log, "vpls[0].window"));
    assert_glbk(t, glbk_ism_near_points_upload(gl, &m, &p, 1));
    REFUSED(glbk_ism_near_points_upload(NULL, &m, &p, 1));
    REFUSED(glbk_ism_near_points_upload(gl, NULL, &p, 1));
    REFUSED(glbk_ism_near_points_upload(gl, &none, &p, 1));
    REFUSED(glbk_ism_near_points_upload(gl, &m, NULL, 1));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_ism_near_points_upload(gl, &m, &p, 2));       /* one VPL has one */
    for (k = 0; k < 3; k++) {
        BAD_IS(bad, p.position[k], NAN, glbk_ism_near_points_upload(gl, &m, &p, 1));
        BAD_IS(bad, p.normal[k], NAN, glbk_ism_near_points_upload(gl, &m, &p, 1));
        BAD_IS(bad, p.flux[k], NAN, glbk_ism_near_points_upload(gl, &m, &p, 1));
    }
    BAD_IS(bad, p.edge, NAN, glbk_ism_near_points_upload(gl, &m, &p, 1));
    BAD_IS(bad, p.edge, -1, glbk_ism_near_points_upload(gl, &m, &p, 1));
    BAD_IS(bad, p.reach, NAN, glbk_ism_near_points_upload(gl, &m, &p, 1));
    BAD_IS(bad, p.reach, -1, glbk_ism_near_points_upload(gl, &m, &p, 1));
    BAD_IS(bad, p.vpl, NAN, glbk_ism_near_points_upload(gl, &m, &p, 1));
    BAD_IS(bad, p.vpl, 1, glbk_ism_near_points_upload(gl, &m, &p, 1));  /* there is one VPL */
    BAD_IS(bad, p.vpl, -1, glbk_ism_near_points_upload(gl, &m, &p, 1));
    assert_glbk(t, glbk_ism_near_points_upload(gl, &m, NULL, 0));
    glbk_ism_maps_free(gl, &m);
}

/* The visibility that ism_shading may have of the CPU. */
static void ism_sees_nothing(void *user, const float position[3], const float geometric_normal[3],
                             const uint32_t *numbers, size_t count, float *visible)
{
    (void)user;
    (void)position;
    (void)geometric_normal;
    (void)numbers;
    memset(visible, 0, count * sizeof *visible);
}

static void ism_settings(glbk_context *gl, glbk_ism_renderer *r, const glbk_gbuffer *seen, const glbk_ism_maps *m)
{
    const glbk_result bad = GLBK_ERR_DESC;
    ism_shading s;
    memset(&s, 0, sizeof s);
    s.interleave = 2;
    BAD_IS(bad, s.near_mode, ISM_NEAR_COUNT, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.interleave, 16, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.interleave, 3, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.bias, 1, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.bias, NAN, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.clamp, -1, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.clamp, INFINITY, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.visible_fn, ism_sees_nothing, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.near_visible_fn, ism_sees_nothing, glbk_ism_shade(gl, r, seen, m, &s, 0));
    BAD_IS(bad, s.bias, 1, glbk_ism_bind(gl, m, &s, NULL));
}

static void ism_passes_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static float rgba[4 * SIDE * SIDE];
    glbk_context *gl = &t->gl;
    const glbk_gbuffer_desc size = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_gbuffer_desc half = { SIDE, SIDE / 2, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const ism_vpl v = { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 1, 1 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 0, 0 };
    const ism_desc d = ism_sizes();
    ism_info info;
    glbk_ism_maps m, none;
    glbk_ism_renderer r, no_r;
    glbk_gbuffer seen, small, nothing;
    ism_shading open;
    glbk_pass screen;

    memset(&screen, 0, sizeof screen);
    memset(&info, 0, sizeof info);
    memset(&none, 0, sizeof none);
    memset(&no_r, 0, sizeof no_r);
    memset(&nothing, 0, sizeof nothing);
    memset(&open, 0, sizeof open);
    open.no_maps = 1;
    REFUSED(glbk_ism_renderer_create(NULL, &(glbk_ism_renderer_desc){ SIDE, SIDE }, &r));
    REFUSED(glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, NULL));
    MAKES(r, glbk_ism_renderer_create(gl, NULL, &r));
    MAKES_IS(GLBK_ERR_DESC, r, glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ 0, SIDE }, &r));
    MAKES_IS(GLBK_ERR_DESC, r, glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, 0 }, &r));
    MAKES_IS(GLBK_ERR_LIMIT, r, glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, gl->max_side + 1 }, &r));
    assert_glbk(t, glbk_ism_maps_create(gl, &d, &m));
    assert_glbk(t, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    assert_glbk(t, glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, &r));
    RESIZES(glbk_ism_renderer_resize, r, (glbk_ism_renderer){ .width = 0 });
    assert_glbk(t, glbk_ism_renderer_resize(gl, &r, SIDE, SIDE));
    assert_glbk(t, glbk_gbuffer_create(gl, &size, &seen));
    assert_glbk(t, glbk_gbuffer_create(gl, &half, &small));
    ERROR_IS(GLBK_ERR_ORDER, glbk_ism_shade(gl, &r, &seen, &m, NULL, 0));       /* the maps hold nothing yet */
    assert_glbk(t, glbk_ism_shade(gl, &r, &seen, &m, &open, 0));
    assert_glbk(t, glbk_ism_draw(gl, &m, 0));
    REFUSED(glbk_ism_draw(NULL, &m, 0));
    REFUSED(glbk_ism_draw(gl, NULL, 0));
    REFUSED(glbk_ism_draw(gl, &none, 0));
    assert_true(m.side == 8);
    REFUSED(glbk_ism_bind(NULL, &m, NULL, NULL));
    REFUSED(glbk_ism_bind(gl, NULL, NULL, NULL));
    REFUSED(glbk_ism_bind(gl, &none, NULL, NULL));
    assert_glbk(t, glbk_ism_shade(gl, &r, &seen, &m, NULL, 0));
    REFUSED(glbk_ism_shade(NULL, &r, &seen, &m, NULL, 0));
    REFUSED(glbk_ism_shade(gl, NULL, &seen, &m, NULL, 0));
    REFUSED(glbk_ism_shade(gl, &no_r, &seen, &m, NULL, 0));
    REFUSED(glbk_ism_shade(gl, &r, NULL, &m, NULL, 0));
    REFUSED(glbk_ism_shade(gl, &r, &nothing, &m, NULL, 0));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_ism_shade(gl, &r, &small, &m, NULL, 0));
    REFUSED(glbk_ism_shade(gl, &r, &seen, NULL, NULL, 0));
    REFUSED(glbk_ism_shade(gl, &r, &seen, &none, NULL, 0));
    ism_settings(gl, &r, &seen, &m);
    REFUSED(glbk_ism_resolve(NULL, &r, &seen, &screen, NULL));
    REFUSED(glbk_ism_resolve(gl, NULL, &seen, &screen, NULL));
    REFUSED(glbk_ism_resolve(gl, &no_r, &seen, &screen, NULL));
    REFUSED(glbk_ism_resolve(gl, &r, NULL, &screen, NULL));
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_ism_resolve(gl, &r, &small, &screen, NULL));
    REFUSED(glbk_ism_resolve(gl, &r, &seen, NULL, NULL));
    assert_glbk(t, glbk_ism_read(gl, &r, rgba));
    REFUSED(glbk_ism_read(NULL, &r, rgba));
    REFUSED(glbk_ism_read(gl, NULL, rgba));
    REFUSED(glbk_ism_read(gl, &no_r, rgba));
    REFUSED(glbk_ism_read(gl, &r, NULL));
    glbk_ism_renderer_free(gl, NULL);
    glbk_ism_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &seen);
    glbk_gbuffer_free(gl, &small);
    glbk_ism_maps_free(gl, &m);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(textures_and_tables_refuse_bad_arguments),
        gl_unit_test(buffers_and_targets_refuse_bad_arguments),
        gl_unit_test(passes_and_bindings_refuse_bad_arguments),
        gl_unit_test(csm_blocks_and_instances_refuse_bad_arguments), gl_unit_test(csm_askers_refuse_bad_arguments),
        gl_unit_test(csm_lights_refuse_bad_descs), gl_unit_test(csm_light_tables_refuse_bad_arguments),
        gl_unit_test(csm_frames_refuse_bad_arguments), gl_unit_test(csm_builders_refuse_bad_arguments),
        gl_unit_test(envsh_maps_and_frames_refuse_bad_arguments), gl_unit_test(rsm_maps_refuse_bad_lights),
        gl_unit_test(rsm_renderers_and_tables_refuse_bad_arguments), gl_unit_test(rsm_passes_refuse_bad_arguments),
        gl_unit_test(ism_maps_refuse_bad_descs), gl_unit_test(ism_meshes_and_surfels_refuse_bad_arguments),
        gl_unit_test(ism_vpls_and_near_points_refuse_bad_arguments), gl_unit_test(ism_passes_refuse_bad_arguments)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
