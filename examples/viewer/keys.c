/* keys.c - what keys and dropped files do, and the panel that shows it. */
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "viewer.h"

#include <stdio.h>
#include <string.h>

/* ---- walking through lists of names ---- */

static void step_name(const char *const *names, char *text, size_t size, int direction, int may_be_empty)
{
    int count = 0, at = -1;
    for (; names[count]; count++)
        if (strncmp(text, "builtin:", 8) == 0 && strcmp(text + 8, names[count]) == 0)
            at = count;
    if (may_be_empty) {                /* "" stands before the first */
        at = (at + 1 + direction + count + 1) % (count + 1) - 1;
        if (at < 0) {
            text[0] = 0;
            return;
        }
    } else {
        at = at < 0 ? 0 : (at + direction + count) % count;
    }
    snprintf(text, size, "builtin:%s", names[at]);
}

/* Finer maps than these are no pleasure to wait for; the panel raises them. */
static void start_coarse(vw_show *s)
{
    static const char *const start[][2] = {
        { "csm", "side=64" }, { "csm", "map_side=64" }, { "csm", "order=hilbert" },
        { "shadowfield", "position_side=6" }, { "shadowfield", "source_position_side=4" },
        { "shadowfield", "source_shell_count=8" }, { "shadowfield", "point_spacing=0.05" }
    };
    s->change_count = 0;               /* another technique has other keys */
    for (size_t i = 0; s->technique && i < sizeof start / sizeof start[0]; i++)
        if (strcmp(start[i][0], s->technique->name) == 0)
            strcpy(s->changes[s->change_count++], start[i][1]);
}

void vw_choose(vw_show *s, const rd_technique *technique)
{
    s->technique = technique;
    start_coarse(s);
    s->samples = 0;
    s->new_scene = s->keeps_orbit = 1; /* and perhaps another light where nothing is given */
}

/* The preview, then every technique that this build has. */
static void step_technique(vw_show *s, int direction)
{
    const rd_technique *const *all = rd_techniques();
    int count = 0, at = 0;
    const rd_technique *present[16] = { NULL };
    for (count = 1; *all && count < 16; all++)
        if (!(*all)->missing) {
            if (*all == s->technique)
                at = count;
            present[count++] = *all;
        }
    vw_choose(s, present[(at + direction + count) % count]);
}

static void compare(viewer *v)
{
    vw_show *s = &v->show;
    if (rd_reference.missing) {
        snprintf(v->message, sizeof v->message, "the reference %s", rd_reference.missing);
        return;
    }
    s->compares = !s->compares;
    s->new_reference = 1;
    if (s->compares && !s->technique)
        snprintf(v->message, sizeof v->message, "T: a technique to compare");
}

static void step_samples(vw_show *s, int direction)
{
    const rd_technique *t = s->technique;
    uint32_t n;
    if (!t || !t->most_samples)
        return;
    n = s->samples ? s->samples : t->samples / 16;
    n = direction > 0 ? (n ? 2 * n : 1) : n / 2;
    n = n < 1 ? 1 : n;
    n = n < t->least_samples ? t->least_samples : n;
    s->samples = n > t->most_samples ? t->most_samples : n;
    s->new_technique = s->new_view = 1;
}

static void change_row(viewer *v, int direction)
{
    vw_show *s = &v->show;
    const rd_key *key;
    switch (v->selected) {
    case VW_ROW_TECHNIQUE:
        step_technique(s, direction);
        return;
    case VW_ROW_SCENE:
        step_name(ex_scene_names(), s->scene, sizeof s->scene, direction, 0);
        s->new_scene = 1;
        return;
    case VW_ROW_SKY:
        step_name(ex_sky_names(), s->sky, sizeof s->sky, direction, 1);
        s->new_scene = s->keeps_orbit = 1;
        return;
    case VW_ROW_SAMPLES:
        step_samples(s, direction);
        return;
    case VW_ROW_EXPOSURE:
        v->ev += 0.25f * (float)direction;
        return;
    default:
        key = vw_show_key(s, v->selected - VW_ROW_KEYS);
        if (key)
            vw_show_change(s, key, direction);
    }
}

static int row_count(const viewer *v)
{
    int count = 0;
    while (vw_show_key(&v->show, count))
        count++;
    return VW_ROW_KEYS + count;
}

/* ---- keys ---- */

void vw_key(viewer *v, int key, int is_shifted)
{
    int rows;
    v->is_dirty = 1;
    v->message[0] = 0;
    switch (key) {
    case GLFW_KEY_UP: v->selected--; break;
    case GLFW_KEY_DOWN: v->selected++; break;
    case GLFW_KEY_LEFT: change_row(v, -1); break;
    case GLFW_KEY_RIGHT: change_row(v, 1); break;
    case GLFW_KEY_T: step_technique(&v->show, is_shifted ? -1 : 1); break;
    case GLFW_KEY_H: v->has_help = !v->has_help; break;
    case GLFW_KEY_P: v->has_panel = !v->has_panel; break;
    case GLFW_KEY_S: v->wants_shot = 1; break;
    case GLFW_KEY_F: v->wants_pfm = 1; break;
    case GLFW_KEY_C: compare(v); break;
    case GLFW_KEY_G:
        v->show.use_gl = !v->show.use_gl;
        v->show.new_technique = v->show.new_view = 1;
        break;
    case GLFW_KEY_SPACE:
        v->show.plays = !v->show.plays && v->show.loaded.animated;
        if (!v->show.loaded.animated)
            snprintf(v->message, sizeof v->message, "nothing moves in this scene");
        break;
    case GLFW_KEY_R:
        v->show.orbit = v->show.home;
        v->show.new_view = 1;
        break;
    case GLFW_KEY_ESCAPE:
    case GLFW_KEY_Q: v->wants_end = 1; break;
    default: break;
    }
    rows = row_count(v);
    v->selected = (v->selected + rows) % rows;
}

static int ends_in(const char *text, const char *suffix)
{
    size_t a = strlen(text), b = strlen(suffix);
    return a > b && strcmp(text + a - b, suffix) == 0;
}

void vw_drop(viewer *v, const char *path)
{
    vw_show *s = &v->show;
    v->is_dirty = 1;
    if (strlen(path) >= sizeof s->scene) {
        snprintf(v->message, sizeof v->message, "the path is too long");
    } else if (ends_in(path, ".glb") || ends_in(path, ".gltf")) {
        strcpy(s->scene, path);
        s->new_scene = 1;
    } else if (ends_in(path, ".hdr")) {
        strcpy(s->sky, path);
        s->new_scene = s->keeps_orbit = 1;
    } else {
        snprintf(v->message, sizeof v->message, "drop a .glb, a .gltf or a .hdr");
    }
}

/* ---- the panel ---- */

static const char *short_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static uint32_t put_help(vw_panel *panel, uint32_t y)
{
    static const char *const lines[] = {
        "left button    turn", "right button   move", "wheel          zoom", "up, down       choose a row",
        "left, right    change it", "T              next technique (shift: previous)",
        "C              beside the path tracer; drag the line",
        "G              backend cpu or gl", "S              screenshot", "F              radiance as .pfm",
        "P              this panel", "H              help",
        "space          let time pass, or stop it",
        "R              reset the camera", "Q              quit", "drop .glb, .gltf, .hdr files on the window"
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        y = vw_panel_text(panel, 8, y, lines[i], 0);
    return y;
}

/* The rows that fit above `bottom`, the selected one among them. */
static uint32_t put_rows(viewer *v, uint32_t y, uint32_t bottom)
{
    const vw_show *s = &v->show;
    const rd_technique *t = s->technique;
    const int fit = bottom > y + VW_LINE_HEIGHT ? (int)((bottom - y) / VW_LINE_HEIGHT) : 1;
    const int first = v->selected < fit ? 0 : v->selected - fit + 1;
    char text[200];
    const rd_key *key;
#define ROW(row, ...) (snprintf(text, sizeof text, __VA_ARGS__), y = (row) < first || (row) >= first + fit ? y : \
                       vw_panel_text(&v->panel, 8, y, text, v->selected == (row)))
    ROW(VW_ROW_TECHNIQUE, "technique  %s%s", t ? t->name : "preview",
        t && s->use_gl && rd_technique_has_gl(t) ? " on gl" : "");
    ROW(VW_ROW_SCENE, "scene      %.40s", short_name(s->scene));
    ROW(VW_ROW_SKY, "sky        %.40s", s->sky[0] ? short_name(s->sky) : "the scene's own light");
    if (t && t->most_samples && s->side[VW_TECHNIQUE].args.technique == t)
        ROW(VW_ROW_SAMPLES, "samples    %u a frame", (unsigned)s->side[VW_TECHNIQUE].args.samples);
    else
        ROW(VW_ROW_SAMPLES, "samples    none");
    ROW(VW_ROW_EXPOSURE, "exposure   %+.2f", (double)(v->ev + v->ev_automatic));
    for (int i = 0; (key = vw_show_key(s, i)) != NULL; i++)
        ROW(VW_ROW_KEYS + i, "%-10s %.30s", key->name, vw_show_value(s, key));
#undef ROW
    return y;
}

/* Times of both sides, and how far they are apart. */
static void put_figures(viewer *v, uint32_t y)
{
    const vw_show *s = &v->show;
    const vw_side *technique = &s->side[VW_TECHNIQUE], *reference = &s->side[VW_REFERENCE];
    double error, mean;
    char text[200];
    if (s->technique && technique->frames) {
        snprintf(text, sizeof text, "build %.0f ms, g-buffer %.0f ms, frame %.0f ms, %u frames", technique->open_ms,
                 s->gbuffer_ms, technique->frame_ms, (unsigned)technique->frames);
        y = vw_panel_text(&v->panel, 8, y, text, 0);
    }
    if (vw_show_error(s, &error, &mean)) {
        snprintf(text, sizeof text, "right of the line: %u paths a pixel in %.1f s", (unsigned)reference->frames,
                 reference->spent);
        y = vw_panel_text(&v->panel, 8, y, text, 0);
        snprintf(text, sizeof text, "relative rmse %.3f, mean %.3f of it", error, mean);
        y = vw_panel_text(&v->panel, 8, y, text, 0);
    }
    if (!v->has_help)
        vw_panel_text(&v->panel, 8, y, "H: help, P: without text", 0);
}

void vw_lines(viewer *v)
{
    enum { FIGURES = 4, SAID = 2 };    /* lines at the bottom, and above them what is going on or wrong */
    const vw_show *s = &v->show;
    const uint32_t height = s->height, own = FIGURES * VW_LINE_HEIGHT + 8, said = SAID * VW_LINE_HEIGHT;
    const uint32_t bottom = height > 2 * (own + said) ? height - own : height;
    uint32_t y = 8;
    vw_panel_clear(&v->panel);
    if (v->has_panel) {
        y = put_rows(v, y, v->has_help ? height / 3 : bottom - said) + 8;
        put_figures(v, bottom < height ? bottom : y);
    }
    if (v->has_help)
        y = put_help(&v->panel, y + 8);
    if (vw_show_will_build(s))
        y = vw_panel_text(&v->panel, 8, y + 8, "building ...", 1);
    if (s->error[0])
        y = vw_panel_text(&v->panel, 8, y + 8, s->error, 1);
    if (v->message[0])
        vw_panel_text(&v->panel, 8, y + 8, v->message, 0);
}
