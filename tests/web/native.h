/* native.h - a GL context of this machine as a page's, for the native twins of the pages: as in a browser without
   compute shaders, and a target in place of the window. */
#ifndef TESTS_WEB_NATIVE_H
#define TESTS_WEB_NATIVE_H

#include "gl_context.h"
#include "../../web/stage.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int native_open(glbk_context *gl, char *error)
{
    static const ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    ex_gl *context = ex_gl_create(&options, error);
    glbk_desc desc = { 0 };
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = context;
    desc.system.log = ex_gl_log;
    desc.core_only = 1;
    if (!context || glbk_init(gl, &desc) != GLBK_OK) return -1;
    error[0] = 0;                       /* of a version that this machine does not have */
    return 0;
}

/* The page draws to the window; here the framebuffer that is bound is a target's. */
static int native_window(glbk_context *gl, pg_stage *stage, glbk_texture *texture, glbk_target *target)
{
    const glbk_texture_desc desc = { GLBK_FORMAT_RGBA8,     stage->width, stage->height, 0, 0,
                                     GLBK_SAMPLING_DEFAULT, 0,            NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    to.color[0] = texture;
    if (glbk_texture_create(gl, &desc, texture) != GLBK_OK || glbk_target_create(gl, &to, target) != GLBK_OK) return -1;
    stage->window = target->name;
    return 0;
}

static int native_save(const pg_stage *stage, const glbk_target *target, const char *path, char *error)
{
    const uint32_t width = stage->width, height = stage->height;
    float *rgba = malloc(4 * (size_t)width * height * sizeof *rgba);
    unsigned char *rgb = malloc(3 * (size_t)width * height);
    int result = -1;
    if (rgba && rgb && glbk_target_read(stage->gl, target, 0, 0, 0, width, height, rgba) == GLBK_OK) {
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = 0; x < 3 * width; x++)
                rgb[3 * (size_t)width * (height - 1 - y) + x] =
                    (unsigned char)(rgba[4 * ((size_t)y * width + x / 3) + x % 3] * 255 + 0.5f);
        result = ex_png_write(path, width, height, rgb, error);
    }
    free(rgba);
    free(rgb);
    return result;
}

#endif
