/* picture_test - what the picture passes of csm, envsh, rsm and ism do beside their colours: keep what lies where
   nothing is seen, test and write depths, blend. The G-buffers are uploaded, the light is written into the renderers
   as it stands there. */
#define _POSIX_C_SOURCE 200809L
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

enum { WIDE = 6, HIGH = 4, TEXELS = WIDE * HIGH, LEFT = 2, BELOW = 1, ROOM_WIDE = WIDE + 3, ROOM_HIGH = HIGH + 2 };

static const float light = 0.5f, behind = 0.25f;        /* what comes out of every technique; what is in the target */

/* In every third pixel nothing is seen; the others stand at clip depths from -0.8 to 0.8. */
static int is_seen(int i) { return i % 3 != 1; }
static float clip_depth(int i) { return -0.8f + 1.6f * (float)i / (TEXELS - 1); }

/* A place that this camera sees at that depth: w is not 1. */
static const float world_to_clip[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.02020202f, -1, 0, 0, -0.202020202f, 0 };
static float place_z(int i) { return 0.202020202f / (clip_depth(i) - 1.02020202f); }

typedef struct techniques {
    glbk_csm_renderer   csm;
    glbk_gbuffer        seen, csm_seen;
    glbk_envsh_renderer envsh;
    glbk_rsm_renderer   rsm;
    glbk_gbuffer        seen_by_rsm;
    glbk_ism_renderer   ism;
    glbk_texture        color, depth;
    glbk_target         room;
    glbk_program        show_depth;
    gl_canvas           depths;         /* what the depth buffer holds, as colours */
} techniques;

static void put_light(gl_test *t, const glbk_texture *texture, float value)
{
    static float rgba[TEXELS][4];
    int i, k;
    for (i = 0; i < TEXELS; i++)
        for (k = 0; k < 4; k++) rgba[i][k] = value;
    assert_glbk(t, glbk_texture_update(&t->gl, texture, &(glbk_box){ 0, 0, 0, 0, WIDE, HIGH, 1 }, rgba));
}

static void make_csm(gl_test *t, glbk_csm_renderer *r, glbk_gbuffer *seen)
{
    static glbk_pixel pixels[TEXELS];
    const glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_csm_renderer_desc desc = { WIDE, HIGH, 0, 0, NULL };
    int i;
    for (i = 0; i < TEXELS; i++) {
        memset(&pixels[i], 0, sizeof pixels[i]);
        if (!is_seen(i)) continue;
        pixels[i].normal[2] = pixels[i].geometric_normal[2] = 1;
        pixels[i].position[2] = place_z(i);
    }
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, seen, 0, HIGH, pixels));
    put_light(t, &r->sums[r->now], light);
    r->frame_count = r->passes = 1;
}

static void make_envsh(gl_test *t, glbk_gbuffer *seen, glbk_envsh_renderer *r)
{
    static glbk_pixel pixels[TEXELS];
    glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    int i, k;
    for (i = 0; i < TEXELS; i++) {
        memset(&pixels[i], 0, sizeof pixels[i]);
        for (k = 0; k < 3; k++) pixels[i].material.diffuse[k] = 0.5f;
        pixels[i].normal[2] = is_seen(i) ? 1.0f : 0.0f;
        pixels[i].position[2] = place_z(i);
    }
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, seen));
    assert_glbk(t, glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ WIDE, HIGH }, r));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, seen, 0, HIGH, pixels));
    put_light(t, &r->sums[r->now], light / (0.5f * 0.318309886f));
    r->begun = 1;
}

static void make_rsm(gl_test *t, glbk_rsm_renderer *r, glbk_gbuffer *seen)
{
    static glbk_pixel pixels[TEXELS];
    const glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_rsm_renderer_desc desc = { WIDE, HIGH, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    int i, k;
    for (i = 0; i < TEXELS; i++) {
        memset(&pixels[i], 0, sizeof pixels[i]);
        for (k = 0; k < 3; k++) pixels[i].material.diffuse[k] = 0.5f;
        pixels[i].normal[2] = is_seen(i) ? 1.0f : 0.0f;
        pixels[i].position[2] = place_z(i);
    }
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &desc, r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, seen, 0, HIGH, pixels));
    put_light(t, &r->sums[0], light / (0.5f * 0.318309886f));
    r->direct = 0;
}

/* It lights the G-buffer of envsh. */
static void make_ism(gl_test *t, glbk_ism_renderer *r)
{
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ WIDE, HIGH }, r));
    put_light(t, &r->result, light / (0.5f * 0.318309886f));
}

enum { CSM, ENVSH, RSM, ISM, COUNT };
static const char *const names[COUNT] = { "csm", "envsh", "rsm", "ism" };

static glbk_result resolve(gl_test *t, techniques *x, int which, const glbk_pass *pass, const glbk_picture *picture)
{
    switch (which) {
    case CSM: return glbk_csm_resolve(&t->gl, &x->csm, &x->csm_seen, pass, picture);
    case ENVSH: return glbk_envsh_resolve(&t->gl, &x->envsh, &x->seen, pass, picture);
    case RSM: return glbk_rsm_resolve(&t->gl, &x->rsm, &x->seen_by_rsm, pass, picture, 1, 0);
    default: return glbk_ism_resolve(&t->gl, &x->ism, &x->seen, pass, picture);
    }
}

static void make(gl_test *t, techniques *x)
{
    glbk_texture_desc d;
    glbk_target_desc to;
    glbk_source source;
    memset(x, 0, sizeof *x);
    memset(&d, 0, sizeof d);
    memset(&to, 0, sizeof to);
    memset(&source, 0, sizeof source);
    make_csm(t, &x->csm, &x->csm_seen);
    make_envsh(t, &x->seen, &x->envsh);
    make_rsm(t, &x->rsm, &x->seen_by_rsm);
    make_ism(t, &x->ism);
    d.width = ROOM_WIDE;
    d.height = ROOM_HIGH;
    d.format = GLBK_FORMAT_RGBA8;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &x->color));
    d.format = GLBK_FORMAT_DEPTH32F;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &x->depth));
    to.color[0] = &x->color;
    to.depth = &x->depth;
    assert_glbk(t, glbk_target_create(&t->gl, &to, &x->room));
    x->depths = gl_canvas_make(t, GLBK_FORMAT_COLOR, ROOM_WIDE, ROOM_HIGH, 0);
    source.fragment = "uniform sampler2D glbk_user0;\nlayout(location = 0) out glbk_color color;\n"
                      "void main() { color = glbk_pack(texelFetch(glbk_user0, ivec2(gl_FragCoord.xy), 0)); }\n";
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &x->show_depth));
}

static void destroy(gl_test *t, techniques *x)
{
    glbk_csm_renderer_free(&t->gl, &x->csm);
    glbk_gbuffer_free(&t->gl, &x->csm_seen);
    glbk_envsh_renderer_free(&t->gl, &x->envsh);
    glbk_gbuffer_free(&t->gl, &x->seen);
    glbk_rsm_renderer_free(&t->gl, &x->rsm);
    glbk_gbuffer_free(&t->gl, &x->seen_by_rsm);
    glbk_ism_renderer_free(&t->gl, &x->ism);
    glbk_target_free(&t->gl, &x->room);
    glbk_texture_free(&t->gl, &x->color);
    glbk_texture_free(&t->gl, &x->depth);
    glbk_program_free(&t->gl, &x->show_depth);
    gl_canvas_free(t, &x->depths);
}

typedef struct seen { float color[ROOM_WIDE * ROOM_HIGH][4], depth[ROOM_WIDE * ROOM_HIGH][4]; } seen;

/* The picture of one technique over a target that holds `behind` and a depth. */
static void draw(gl_test *t, techniques *x, int which, glbk_pass pass, float depth, const glbk_picture *picture,
                 seen *out)
{
    const float color[4] = { behind, behind, behind, 1 };
    glbk_pass to;
    memset(&to, 0, sizeof to);
    to.target = &x->room;
    to.depth = GLBK_DEPTH_LESS;
    assert_glbk(t, glbk_begin(&t->gl, &to, NULL));
    glbk_clear(&t->gl, &x->room, 0, color);
    glbk_clear_depth(&t->gl, depth);
    pass.target = &x->room;
    pass.viewport[0] = LEFT;
    pass.viewport[1] = BELOW;
    pass.viewport[2] = WIDE;
    pass.viewport[3] = HIGH;
    assert_glbk(t, resolve(t, x, which, &pass, picture));
    memset(&to, 0, sizeof to);
    to.target = &x->depths.target;
    assert_glbk(t, glbk_begin(&t->gl, &to, &x->show_depth));
    glbk_bind_texture(&t->gl, GLBK_SLOT_glbk_user0, &x->depth);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &x->room, 0, 0, 0, ROOM_WIDE, ROOM_HIGH, out->color));
    assert_glbk(t, glbk_target_read(&t->gl, &x->depths.target, 0, 0, 0, ROOM_WIDE, ROOM_HIGH, out->depth));
}

/* Of each pixel of the target: the texel of the picture that falls on it, or -1. */
static int texel_at(int i)
{
    const int at = i % ROOM_WIDE - LEFT, up = i / ROOM_WIDE - BELOW;
    return at >= 0 && at < WIDE && up >= 0 && up < HIGH ? up * WIDE + at : -1;
}

/* The colour of a texel: the G-buffer holds no albedo where nothing is seen; csm's sums are radiances. */
static float shown(int which, int texel)
{
    return which != CSM && !is_seen(texel) ? 0.0f : light;
}

static void check(int which, int i, const seen *s, float color, float depth)
{
    if (fabs((double)s->color[i][0] - (double)color) > 0.005 || fabs((double)s->depth[i][0] - (double)depth) > 1e-5)
        fail_msg("%s, pixel %d %d: colour %f instead of %f, depth %f instead of %f", names[which], i % ROOM_WIDE,
                 i / ROOM_WIDE, (double)s->color[i][0], (double)color, (double)s->depth[i][0], (double)depth);
}

static void what_lies_where_nothing_is_seen_stays(void **state)
{
    GL_TEST(t, state)
    static techniques x;
    static seen s;
    glbk_picture picture;
    glbk_pass pass;
    int which, i, texel;
    make(t, &x);
    memset(&pass, 0, sizeof pass);
    memset(&picture, 0, sizeof picture);
    for (which = 0; which < COUNT; which++) {
        picture.keep_empty = 0;
        draw(t, &x, which, pass, 0.75f, &picture, &s);
        for (i = 0; i < ROOM_WIDE * ROOM_HIGH; i++)
            check(which, i, &s, texel_at(i) < 0 ? behind : shown(which, texel_at(i)), 0.75f);
        picture.keep_empty = 1;
        draw(t, &x, which, pass, 0.75f, &picture, &s);
        for (i = 0; i < ROOM_WIDE * ROOM_HIGH; i++) {
            texel = texel_at(i);
            check(which, i, &s, texel >= 0 && is_seen(texel) ? light : behind, 0.75f);
        }
    }
    destroy(t, &x);
}

static void depths_are_those_of_what_is_seen(void **state)
{
    GL_TEST(t, state)
    static techniques x;
    static seen s;
    glbk_picture picture;
    glbk_pass pass;
    int which, i;
    make(t, &x);
    memset(&pass, 0, sizeof pass);
    memset(&picture, 0, sizeof picture);
    picture.world_to_clip = world_to_clip;
    pass.depth = GLBK_DEPTH_LESS;
    for (which = 0; which < COUNT; which++)
        for (picture.keep_empty = 0; picture.keep_empty < 2; picture.keep_empty++) {
            draw(t, &x, which, pass, 0.6f, &picture, &s);
            for (i = 0; i < ROOM_WIDE * ROOM_HIGH; i++) {
                const int texel = texel_at(i), is = texel >= 0 && is_seen(texel);
                const float depth = is ? 0.5f * clip_depth(texel) + 0.5f : 1.0f;
                check(which, i, &s, depth < 0.6f ? light : behind, depth < 0.6f ? depth : 0.6f);
            }
            pass.depth = GLBK_DEPTH_GREATER;        /* what is not seen is as far as can be, and over what is there */
            draw(t, &x, which, pass, 0.6f, &picture, &s);
            for (i = 0; i < ROOM_WIDE * ROOM_HIGH; i++) {
                const int texel = texel_at(i), is = texel >= 0 && (is_seen(texel) || !picture.keep_empty);
                const float depth = !is ? 0.0f : is_seen(texel) ? 0.5f * clip_depth(texel) + 0.5f : 1.0f;
                check(which, i, &s, depth > 0.6f ? shown(which, texel) : behind, depth > 0.6f ? depth : 0.6f);
            }
            pass.depth = GLBK_DEPTH_LESS;
        }
    destroy(t, &x);
}

static void pictures_blend_as_the_pass_says(void **state)
{
    GL_TEST(t, state)
    static techniques x;
    static seen s;
    glbk_picture picture;
    glbk_pass pass;
    int which, i;
    make(t, &x);
    memset(&pass, 0, sizeof pass);
    memset(&picture, 0, sizeof picture);
    picture.keep_empty = 1;
    for (which = 0; which < COUNT; which++) {
        pass.blend = GLBK_BLEND_ADD;
        draw(t, &x, which, pass, 0.75f, &picture, &s);
        for (i = 0; i < ROOM_WIDE * ROOM_HIGH; i++) {
            const int texel = texel_at(i);
            check(which, i, &s, texel >= 0 && is_seen(texel) ? behind + light : behind, 0.75f);
        }
        pass.blend = GLBK_BLEND_MIN;
        draw(t, &x, which, pass, 0.75f, &picture, &s);
        for (i = 0; i < ROOM_WIDE * ROOM_HIGH; i++) check(which, i, &s, behind, 0.75f);
    }
    destroy(t, &x);
}

/* Without a G-buffer nobody knows what is seen. */
static void csm_without_gbuffer_cannot_keep(void **state)
{
    GL_TEST(t, state)
    glbk_csm_renderer_desc desc = { WIDE, HIGH, 0, 0, NULL };
    gl_canvas room = gl_canvas_make(t, GLBK_FORMAT_RGBA8, WIDE, HIGH, 0);
    glbk_picture picture;
    glbk_csm_renderer r;
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    memset(&picture, 0, sizeof picture);
    pass.target = &room.target;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r));
    assert_glbk(t, glbk_csm_resolve(&t->gl, &r, NULL, &pass, &picture));
    picture.keep_empty = 1;
    assert_int_equal(glbk_csm_resolve(&t->gl, &r, NULL, &pass, &picture), GLBK_ERR_ARGUMENT);
    assert_non_null(strstr(t->log, "glbk_csm_resolve: gbuffer is NULL, but picture asks what is seen"));
    picture.keep_empty = 0;
    picture.world_to_clip = world_to_clip;
    assert_int_equal(glbk_csm_resolve(&t->gl, &r, NULL, &pass, &picture), GLBK_ERR_ARGUMENT);
    glbk_csm_renderer_free(&t->gl, &r);
    gl_canvas_free(t, &room);
}

/* Who draws on after a technique's passes without binding a framebuffer draws into the technique's: with desc.check
   that is said by the next resolve to what is bound, and by glbk_check at the end of the frame. */
static void a_framebuffer_that_stays_bound_is_an_error(void **state)
{
    GL_TEST(t, state)
    static const float eye[3] = { 0, 0, 1 };
    const glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_csm_renderer_desc desc = { WIDE, HIGH, 0, 0, NULL };
    glbk_gbuffer drawn;
    gl_canvas room = gl_canvas_make(t, GLBK_FORMAT_RGBA8, WIDE, HIGH, 0);
    glbk_csm_renderer r;
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.viewport[2] = WIDE;
    pass.viewport[3] = HIGH;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &drawn));
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &drawn, world_to_clip, eye));
    assert_glbk(t, glbk_check(&t->gl));                     /* nobody asked */
    t->gl.check = 1;
    assert_int_equal(glbk_check(&t->gl), GLBK_ERR_ORDER);
    assert_string_equal(t->log, "glbk_check: a technique's framebuffer is still bound: after its passes bind your own");
    t->log[0] = 0;
    assert_int_equal(glbk_csm_resolve(&t->gl, &r, NULL, &pass, NULL), GLBK_ERR_ORDER);
    assert_non_null(strstr(t->log, "a technique's framebuffer is still bound"));
    t->gl.gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, room.target.name);
    assert_glbk(t, glbk_csm_resolve(&t->gl, &r, NULL, &pass, NULL));
    assert_glbk(t, glbk_check(&t->gl));
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &drawn, world_to_clip, eye));
    pass.target = &room.target;
    assert_glbk(t, glbk_csm_resolve(&t->gl, &r, NULL, &pass, NULL));
    assert_glbk(t, glbk_check(&t->gl));                     /* a target of the user's is bound, as he said */
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &drawn, world_to_clip, eye));
    glbk_gbuffer_free(&t->gl, &drawn);                       /* which unbinds it */
    glbk_csm_renderer_free(&t->gl, &r);
    assert_glbk(t, glbk_check(&t->gl));
    t->gl.check = 0;
    gl_canvas_free(t, &room);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(what_lies_where_nothing_is_seen_stays), gl_unit_test(depths_are_those_of_what_is_seen),
        gl_unit_test(pictures_blend_as_the_pass_says),       gl_unit_test(csm_without_gbuffer_cannot_keep),
        gl_unit_test(a_framebuffer_that_stays_bound_is_an_error)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
