/* viewport_test - where the resolves of csm, envsh, rsm and ism put their pictures: texel by pixel from the viewport's
   corner on, in a target larger than the picture, beyond its sides, cut off; a viewport larger than the picture is
   refused. The light is written into the renderers as it stands there. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"

#include "gl_test.h"

enum { WIDE = 11, HIGH = 7, TEXELS = WIDE * HIGH, ROOM_WIDE = 2 * WIDE + 5, ROOM_HIGH = HIGH + 9 };

/* 255ths of what is drawn, another for each texel and channel. */
static int level(int x, int y, int channel) { return 3 * (WIDE * y + x) + channel + 1; }

/* Light that comes out as those levels, divided by `factor`. */
static const float *light_of(double factor)
{
    static float light[TEXELS][4];
    int i, k;
    for (i = 0; i < TEXELS; i++)
        for (k = 0; k < 4; k++) light[i][k] = k < 3 ? (float)(level(i % WIDE, i / WIDE, k) / (255 * factor)) : 0.0f;
    return light[0];
}

typedef glbk_result (*resolver)(glbk_context *gl, void *renderer, const glbk_pass *pass);

/* Into a white target; bound: by the framebuffer that is bound. */
static void check_view(gl_test *t, resolver resolve, void *renderer, const gl_canvas *room, const int32_t *view,
                       int bound)
{
    static const float white[4] = { 1, 1, 1, 1 };
    static float seen[ROOM_WIDE * ROOM_HIGH][4];
    glbk_pass pass;
    int x, y, k;
    memset(&pass, 0, sizeof pass);
    pass.target = &room->target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, NULL));
    glbk_clear(&t->gl, &room->target, 0, white);
    memcpy(pass.viewport, view, sizeof pass.viewport);
    if (bound) pass.target = NULL;
    assert_glbk(t, resolve(&t->gl, renderer, &pass));
    assert_glbk(t, glbk_target_read(&t->gl, &room->target, 0, 0, 0, ROOM_WIDE, ROOM_HIGH, seen[0]));
    for (y = 0; y < ROOM_HIGH; y++)
        for (x = 0; x < ROOM_WIDE; x++) {
            const int px = x - view[0], py = y - view[1];
            const int inside = px >= 0 && py >= 0 && px < view[2] && py < view[3];
            for (k = 0; k < 3; k++)
                assert_float_equal(255 * seen[y * ROOM_WIDE + x][k], (float)(inside ? level(px, py, k) : 255), 0.25);
        }
}

static void refused(gl_test *t, resolver resolve, void *renderer, const glbk_target *target, int32_t width,
                    int32_t height)
{
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.viewport[2] = width;
    pass.viewport[3] = height;
    t->log[0] = 0;
    assert_int_equal(resolve(&t->gl, renderer, &pass), GLBK_ERR_DESC);
    assert_non_null(strstr(t->log, width > WIDE || !width ? "the width that pass draws to is"
                                                          : "the height that pass draws to is 8; it must be 0..7"));
}

static void check_views(gl_test *t, resolver resolve, void *renderer)
{
    static const int32_t views[][4] = {
        { 0, 0, WIDE, HIGH },   { WIDE + 3, 0, WIDE, HIGH },                      { 0, 6, WIDE, HIGH },
        { -4, -2, WIDE, HIGH }, { ROOM_WIDE - 5, ROOM_HIGH - 3, WIDE, HIGH },     { WIDE + 3, 6, WIDE, HIGH },
        { 9, 4, 1, 1 },         { 2, 3, WIDE - 4, HIGH - 2 }
    };
    gl_canvas room = gl_canvas_make(t, GLBK_FORMAT_RGBA8, ROOM_WIDE, ROOM_HIGH, 0);
    size_t i;
    for (i = 0; i < 2 * sizeof views / sizeof views[0]; i++)
        check_view(t, resolve, renderer, &room, views[i / 2], i % 2 != 0);
    refused(t, resolve, renderer, &room.target, WIDE + 1, HIGH);
    refused(t, resolve, renderer, &room.target, WIDE, HIGH + 1);
    refused(t, resolve, renderer, &room.target, 0, 0);                  /* the whole target */
    refused(t, resolve, renderer, NULL, WIDE, HIGH + 1);
    gl_canvas_free(t, &room);
}

static void put(gl_test *t, const glbk_texture *texture, double factor)
{
    assert_glbk(t, glbk_texture_update(&t->gl, texture, &(glbk_box){ 0, 0, 0, 0, WIDE, HIGH, 1 }, light_of(factor)));
}

static glbk_result resolve_csm(glbk_context *gl, void *renderer, const glbk_pass *pass)
{
    return glbk_csm_resolve(gl, (glbk_csm_renderer *)renderer, NULL, pass, NULL);
}

static void csm_resolves_into_any_view(void **state)
{
    GL_TEST(t, state)
    glbk_csm_renderer_desc desc = { WIDE, HIGH, 0, 0, NULL };
    glbk_csm_renderer r;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r));
    put(t, &r.sums[r.now], 0.5);
    r.frame_count = 2;
    r.passes = 1;
    check_views(t, resolve_csm, &r);
    glbk_csm_renderer_free(&t->gl, &r);
}

typedef struct lit_view { glbk_gbuffer seen; glbk_envsh_renderer r; } lit_view;

static glbk_result resolve_envsh(glbk_context *gl, void *renderer, const glbk_pass *pass)
{
    const lit_view *v = (const lit_view *)renderer;
    glbk_envsh_renderer r = v->r;
    return glbk_envsh_resolve(gl, &r, &v->seen, pass, NULL);
}

static void envsh_resolves_into_any_view(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel pixels[TEXELS];
    glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    lit_view v;
    int i, k;
    for (i = 0; i < TEXELS; i++) {
        pixels[i].normal[2] = 1;
        for (k = 0; k < 3; k++) pixels[i].material.diffuse[k] = 0.5f;
    }
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &v.seen));
    assert_glbk(t, glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ WIDE, HIGH }, &v.r));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &v.seen, 0, HIGH, pixels));
    put(t, &v.r.sums[v.r.now], 0.5 * 0.318309886);
    v.r.begun = 1;
    check_views(t, resolve_envsh, &v);
    glbk_gbuffer_free(&t->gl, &v.seen);
    glbk_envsh_renderer_free(&t->gl, &v.r);
}

static glbk_gbuffer seen;       /* by the renderers of rsm and ism */

static glbk_result resolve_rsm(glbk_context *gl, void *renderer, const glbk_pass *pass)
{
    return glbk_rsm_resolve(gl, (glbk_rsm_renderer *)renderer, &seen, pass, NULL, 1, 1);
}

static void rsm_resolves_into_any_view(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel pixels[TEXELS];
    const glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_rsm_renderer_desc desc = { WIDE, HIGH, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_rsm_renderer r;
    int i, k;
    for (i = 0; i < TEXELS; i++)
        for (k = 0; k < 3; k++) pixels[i].normal[2] = 1, pixels[i].material.diffuse[k] = 0.5f;
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &desc, &r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &seen, 0, HIGH, pixels));
    put(t, &r.sums[0], 2 * 0.5 * 0.318309886);          /* both lights are the same picture */
    r.direct = r.bounce = 0;
    check_views(t, resolve_rsm, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_rsm_renderer_free(&t->gl, &r);
}

static glbk_result resolve_ism(glbk_context *gl, void *renderer, const glbk_pass *pass)
{
    return glbk_ism_resolve(gl, (glbk_ism_renderer *)renderer, &seen, pass, NULL);
}

static void ism_resolves_into_any_view(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel pixels[TEXELS];
    const glbk_gbuffer_desc size = { WIDE, HIGH, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_ism_renderer r;
    int i, k;
    for (i = 0; i < TEXELS; i++)
        for (k = 0; k < 3; k++) pixels[i].normal[2] = 1, pixels[i].material.diffuse[k] = 0.5f;
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ WIDE, HIGH }, &r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &seen, 0, HIGH, pixels));
    put(t, &r.result, 0.5 * 0.318309886);
    check_views(t, resolve_ism, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_ism_renderer_free(&t->gl, &r);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(csm_resolves_into_any_view), gl_unit_test(envsh_resolves_into_any_view),
        gl_unit_test(rsm_resolves_into_any_view), gl_unit_test(ism_resolves_into_any_view)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL);
}
