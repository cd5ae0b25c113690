/* main.c - the program `viewer`: scenes under the techniques of `render`, in a window. */
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "../common/internal.h"
#include "viewer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char dapple_version[];        /* of CHANGELOG.md, by the Makefile */

typedef struct program {
    viewer        v;
    ex_gl        *context;
    glbk_context  gl;
    vw_draw      *draw;
    GLFWwindow   *window;
    double        x, y, last_move;     /* of the mouse; seconds */
    int           was_turned, drags_line;
} program;

/* ---- what the window tells ---- */

static void on_key(GLFWwindow *window, int key, int code, int action, int mods)
{
    program *p = glfwGetWindowUserPointer(window);
    (void)code;
    if (action != GLFW_RELEASE)
        vw_key(&p->v, key, (mods & GLFW_MOD_SHIFT) != 0);
}

/* Is the mouse at the line between technique and reference? */
static int is_at_line(const program *p)
{
    const vw_show *s = &p->v.show;
    int width, height;
    glfwGetWindowSize(p->window, &width, &height);     /* the mouse's pixels, which may be larger than the picture's */
    return s->compares && s->side[VW_REFERENCE].frames && fabs(p->x - (double)p->v.split * width) < 8;
}

static void on_button(GLFWwindow *window, int button, int action, int mods)
{
    program *p = glfwGetWindowUserPointer(window);
    (void)mods;
    if (button == GLFW_MOUSE_BUTTON_LEFT)
        p->drags_line = action == GLFW_PRESS && is_at_line(p);
}

static void turned(program *p)
{
    p->v.show.new_view = 1;
    p->v.is_dirty = p->was_turned = 1;
    p->last_move = ex_seconds();
}

static void on_move(GLFWwindow *window, double x, double y)
{
    program *p = glfwGetWindowUserPointer(window);
    float dx = (float)(x - p->x), dy = (float)(y - p->y), height = (float)p->v.show.height;
    int left = glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
    p->x = x;
    p->y = y;
    if (p->drags_line) {
        int width, rows;
        glfwGetWindowSize(window, &width, &rows);
        p->v.split = fminf(fmaxf((float)(x / width), 0), 1);
        p->v.is_dirty = 1;
        return;
    }
    if (left)
        vw_orbit_turn(&p->v.show.orbit, 4 * dx / height, 4 * dy / height);
    else if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS)
        vw_orbit_move(&p->v.show.orbit, dx / height, dy / height);
    else
        return;
    turned(p);
}

static void on_scroll(GLFWwindow *window, double x, double y)
{
    program *p = glfwGetWindowUserPointer(window);
    (void)x;
    vw_orbit_zoom(&p->v.show.orbit, (float)y);
    turned(p);
}

static void on_drop(GLFWwindow *window, int count, const char **paths)
{
    program *p = glfwGetWindowUserPointer(window);
    for (int i = 0; i < count; i++)
        vw_drop(&p->v, paths[i]);
}

static void on_size(GLFWwindow *window, int width, int height)
{
    program *p = glfwGetWindowUserPointer(window);
    if (width < 1 || height < 1)       /* an icon */
        return;
    p->v.show.width = (uint32_t)width;
    p->v.show.height = (uint32_t)height;
    p->v.show.new_technique = p->v.show.new_reference = p->v.show.new_view = p->v.is_dirty = 1;
}

static void on_refresh(GLFWwindow *window) { ((program *)glfwGetWindowUserPointer(window))->v.is_dirty = 1; }

/* ---- frames ---- */

/* While the mouse moves, and where there is no picture yet, the preview is shown. */
static void draw(program *p)
{
    vw_show *s = &p->v.show;
    const vw_side *side = &s->side[VW_TECHNIQUE];
    int has_picture = s->technique && side->frames && !s->new_view && side->picture.width == s->width &&
                      side->picture.height == s->height;
    if (has_picture && side->frames == 1 && s->moves == 0)      /* a film keeps its exposure */
        p->v.ev_automatic = ex_image_auto_ev(&side->picture);
    if (has_picture)
        vw_draw_picture(p->draw, s, exp2f(p->v.ev + p->v.ev_automatic), p->v.split);
    else
        vw_draw_preview(p->draw, s);
    if (vw_panel_size(&p->v.panel, s->width, s->height) == 0) {
        vw_lines(&p->v);
        vw_draw_panel(p->draw, &p->v.panel);
    }
}

static void shoot(program *p)
{
    vw_show *s = &p->v.show;
    char name[64], error[EX_ERROR_SIZE] = "out of memory";
    unsigned char *rgb;
    double rmse, mean;
    int result = -1;
    snprintf(name, sizeof name, "viewer-%03d.%s", p->v.shots + 1, p->v.wants_pfm ? "pfm" : "png");
    if (p->v.wants_pfm) {
        if (s->side[VW_TECHNIQUE].frames)
            result = ex_image_write(&s->side[VW_TECHNIQUE].picture, name, 0, error);
        else
            snprintf(error, sizeof error, "there is no picture of a technique yet");
    } else {
        rgb = vw_draw_read(p->draw, s->width, s->height);
        if (rgb)
            result = ex_png_write(name, s->width, s->height, rgb, error);
        free(rgb);
    }
    p->v.shots += result == 0;
    if (result == 0 && vw_show_error(s, &rmse, &mean))
        snprintf(p->v.message, sizeof p->v.message, "%s, %u frames, relative rmse %.4f, mean %.4f of %u paths", name,
                 (unsigned)s->side[VW_TECHNIQUE].frames, rmse, mean, (unsigned)s->side[VW_REFERENCE].frames);
    else if (result == 0)
        snprintf(p->v.message, sizeof p->v.message, "%s, %u frames", name, (unsigned)s->side[VW_TECHNIQUE].frames);
    else
        snprintf(p->v.message, sizeof p->v.message, "%s", error);
    printf("%s\n", p->v.message);
    fflush(stdout);
    p->v.wants_shot = p->v.wants_pfm = 0;
    p->v.is_dirty = 1;
}

static void run(program *p)
{
    viewer *v = &p->v;
    while (!glfwWindowShouldClose(p->window) && !v->wants_end) {
        int moves, worked = 0;
        glfwPollEvents();
        moves = p->was_turned && ex_seconds() - p->last_move < 0.2;
        if (moves || vw_show_will_build(&v->show)) {   /* the user sees what is coming before it takes its time */
            draw(p);
            glfwSwapBuffers(p->window);
        }
        if (!moves)
            worked = vw_show_step(&v->show);
        if (worked || v->is_dirty || v->wants_shot || v->wants_pfm) {
            v->is_dirty = 0;
            draw(p);
            if (v->wants_shot || v->wants_pfm)
                shoot(p);
            glfwSwapBuffers(p->window);
        } else if (!moves) {
            glfwWaitEventsTimeout(0.1);
        }
    }
}

/* ---- start and end ---- */

static int start(program *p, int width, int height, char *error)
{
    ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, width, height, 0, 0, "Dapple" };
    glbk_desc desc;
    glbk_result result;
    p->context = ex_gl_create_window(&options, error);
    if (!p->context)
        return -1;
    p->window = ex_gl_window(p->context);
    memset(&desc, 0, sizeof desc);
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = p->context;
    desc.system.log = ex_gl_log;
    result = glbk_init(&p->gl, &desc);
    if (result != GLBK_OK) {
        snprintf(error, EX_ERROR_SIZE, "OpenGL: %s", glbk_result_text(result));
        return -1;
    }
    p->draw = vw_draw_create(&p->gl, error);
    if (!p->draw)
        return -1;
    p->v.show.gl = &p->gl;
    glfwSetWindowUserPointer(p->window, p);
    glfwSetKeyCallback(p->window, on_key);
    glfwSetCursorPosCallback(p->window, on_move);
    glfwSetMouseButtonCallback(p->window, on_button);
    glfwSetScrollCallback(p->window, on_scroll);
    glfwSetDropCallback(p->window, on_drop);
    glfwSetFramebufferSizeCallback(p->window, on_size);
    glfwSetWindowRefreshCallback(p->window, on_refresh);
    glfwSwapInterval(1);
    glfwGetCursorPos(p->window, &p->x, &p->y);
    glfwGetFramebufferSize(p->window, &width, &height);
    on_size(p->window, width, height);
    return 0;
}

int main(int count, char **values)
{
    static program p;
    const char *scene = NULL;
    char error[EX_ERROR_SIZE] = "";
    int status = 1, width = 960, height = 600, at = 1;
    if (count == 2 && strcmp(values[1], "--version") == 0)
        return printf("viewer %s\n", dapple_version), 0;
    if (count > 2 && strcmp(values[1], "--size") == 0 && sscanf(values[2], "%dx%d", &width, &height) == 2)
        at = 3;
    if (at + 1 < count && strcmp(values[at], "--figure") == 0) {
        p.v.show.figure = values[at + 1];
        at += 2;
    }
    if (at < count)
        scene = values[at++];
    if (at < count || (scene && (scene[0] == '-' || strlen(scene) >= sizeof p.v.show.scene)) || width < 16 ||
        height < 16) {
        int asked = count == 2 && scene && strcmp(scene, "--help") == 0;
        fputs("usage: viewer [--size WxH] [--figure FILE[@x,y,z]] [FILE.glb | FILE.gltf | builtin:NAME]"
              " | --help | --version      H in the window lists the keys\n",
              asked ? stdout : stderr);
        return asked ? 0 : 2;
    }
    if (scene) {
        strcpy(p.v.show.scene, scene);
    } else {                           /* something to look at: sun that bounces, beside the path tracer */
        strcpy(p.v.show.scene, "builtin:atrium");
        vw_choose(&p.v.show, &rd_ism);
        p.v.show.compares = !rd_reference.missing;
    }
    p.v.show.keeps_orbit = 0;
    p.v.show.new_scene = 1;
    p.v.split = 0.75f;
    p.v.has_panel = 1;
    if (start(&p, width, height, error) == 0) {
        run(&p);
        status = 0;
    } else {
        ex_complain("viewer", error);
    }
    vw_show_free(&p.v.show);           /* techniques may hold GL objects */
    vw_draw_free(p.draw);
    glbk_free(&p.gl);
    ex_gl_free(p.context);
    free(p.v.panel.rgba);
    return status;
}
