/* show.c - see viewer.h. What `render` does once, here again and again, in steps that the window survives. */
#include "viewer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- wanted settings as arguments of render ---- */

static uint32_t samples_of(const vw_show *s)
{
    const rd_technique *t = s->technique;
    uint32_t samples = s->samples ? s->samples : t->samples / 16;
    samples = samples < t->least_samples ? t->least_samples : samples;
    return samples > t->most_samples ? t->most_samples : samples;
}

/* The preview needs lights and a camera as well: any technique stands in for it. */
static int parse(vw_show *s)
{
    const rd_technique *technique = s->technique ? s->technique : &rd_csm;
    char size[32], samples[16];
    char *values[16 + 2 * VW_MAX_CHANGES];
    union { const char *in; char *out; } text;
    int count = 1;
    const char *fixed[] = { "--technique", technique->name, "--scene", s->scene, "--out", "x.png", "--size", size };
    snprintf(size, sizeof size, "%ux%u", (unsigned)s->width, (unsigned)s->height);
    values[0] = NULL;
#define PUT(word) (text.in = (word), values[count++] = text.out)
    for (size_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++)
        PUT(fixed[i]);
    if (s->sky[0]) {
        PUT("--env");
        PUT(s->sky);
    }
    if (s->figure) {
        PUT("--figure");
        PUT(s->figure);
    }
    if (s->technique && technique->most_samples) {
        snprintf(samples, sizeof samples, "%u", (unsigned)samples_of(s));
        PUT("--samples");
        PUT(samples);
    }
    for (int i = 0; i < s->change_count; i++) {
        PUT("--set");
        PUT(s->changes[i]);
    }
#undef PUT
    rd_args_free(&s->args);
    return rd_args_parse(&s->args, count, values, s->error);
}

/* ---- steps ---- */

static void close_technique(vw_show *s)
{
    if (s->is_open && s->args.technique->close)
        s->args.technique->close(s->state);
    s->state = NULL;
    s->is_open = 0;
}

static void fill_job(vw_show *s)
{
    rd_job *job = &s->job;
    job->scene = &s->loaded;
    job->gbuffer = &s->gbuffer;
    job->settings = &s->args.settings;
    job->baked = NULL;
    job->aa = 1;
    job->samples = s->args.samples;
    job->frames = VW_MAX_FRAMES;
    job->gl = s->use_gl && rd_technique_has_gl(s->args.technique) ? s->gl : NULL;
}

static int fail(vw_show *s, const char *text)
{
    snprintf(s->error, sizeof s->error, "%s", text);
    return -1;
}

/* A file that cannot be read: the next wish asks for the last scene and sky that could be. */
static int take_back(vw_show *s)
{
    if (s->loads) {
        memcpy(s->scene, s->loaded_scene, sizeof s->scene);
        memcpy(s->sky, s->loaded_sky, sizeof s->sky);
    }
    return -1;
}

static int load(vw_show *s)
{
    ex_scene fresh;
    rd_emitter *emitters = NULL;
    rd_job job = s->job;
    uint32_t time = s->keeps_orbit ? s->time : 0;
    close_technique(s);
    memset(&fresh, 0, sizeof fresh);
    if (parse(s) != 0 || rd_setup(&fresh, &job, &emitters, &s->args, (float)time / 30.0f, s->error) != 0)
        return take_back(s);
    s->time = time;
    memcpy(s->loaded_scene, s->scene, sizeof s->scene);
    memcpy(s->loaded_sky, s->sky, sizeof s->sky);
    ex_scene_free(&s->loaded);
    free(s->emitters);
    s->loaded = fresh;
    s->emitters = emitters;
    s->job = job;
    s->loads++;
    s->home_camera = s->loaded.camera;
    vw_orbit_from(&s->home, &s->home_camera);
    if (!s->keeps_orbit)
        s->orbit = s->home;
    s->keeps_orbit = 0;
    s->new_technique = s->new_view = 1;
    return 0;
}

static int open_technique(vw_show *s)
{
    double start = ex_seconds();
    close_technique(s);
    if (parse(s) != 0)
        return -1;
    s->frames = 0;
    if (!s->technique)
        return 0;
    if (!s->job.pool)
        s->job.pool = ex_pool_create(0);
    if (!s->job.pool)
        return fail(s, "out of memory");
    s->job.threads = ex_pool_threads(s->job.pool);
    fill_job(s);
    if (s->technique->open(&s->state, &s->job, s->error) != 0)
        return -1;
    s->is_open = 1;
    s->open_ms = 1000 * (ex_seconds() - start);
    return 0;
}

static int look(vw_show *s)
{
    double start = ex_seconds();
    s->loaded.camera = s->home_camera;
    if (memcmp(&s->orbit, &s->home, sizeof s->orbit) != 0)
        vw_orbit_to(&s->orbit, &s->loaded.camera);
    s->frames = 0;
    if (!s->technique)
        return 0;
    ex_gbuffer_free(&s->gbuffer);
    if (ex_gbuffer_render(&s->gbuffer, &s->loaded, s->width, s->height, 1, 0, s->error) != 0)
        return -1;
    if (s->frame.width != s->width || s->frame.height != s->height) {
        ex_image_free(&s->frame);
        ex_image_free(&s->picture);
        if (ex_image_alloc(&s->frame, s->width, s->height) != 0 ||
            ex_image_alloc(&s->picture, s->width, s->height) != 0)
            return fail(s, "out of memory");
    }
    s->gbuffer_ms = 1000 * (ex_seconds() - start);
    return 0;
}

static int next_frame(vw_show *s)
{
    size_t values = 3 * (size_t)s->width * s->height;
    double start = ex_seconds();
    s->job.frame = s->job.seed = s->frames;
    memset(s->frame.rgb, 0, values * sizeof *s->frame.rgb);
    if (s->technique->frame(s->state, &s->job, &s->frame, s->error) != 0)
        return -1;
    s->frames++;
    for (size_t i = 0; i < values; i++)
        s->picture.rgb[i] += (s->frame.rgb[i] - s->picture.rgb[i]) / (float)s->frames;
    s->frame_ms = 1000 * (ex_seconds() - start);
    return 0;
}

/* The next thirtieth of a second: what render does between two frames, and the frame. */
static int move_on(vw_show *s)
{
    int deforms = 0;
    if (ex_seconds() - s->moved < 1.0 / 30)
        return 0;
    s->moved = ex_seconds();
    if (rd_move(&s->loaded, &s->job, &s->emitters, (float)(s->time + 1) / 30.0f, s->error) != 0)
        return -1;
    s->time++;
    s->moves++;
    for (uint32_t i = 0; i < s->loaded.mesh_count; i++)
        deforms |= s->loaded.meshes[i].deforms;
    s->loads += (unsigned)deforms;     /* other vertices for the preview */
    if (look(s) != 0 || !s->technique)
        return s->error[0] ? -1 : 0;
    if (!s->technique->update) {
        if (open_technique(s) != 0)
            return -1;
    } else if (s->technique->update(s->state, &s->job, s->error) != 0) {
        close_technique(s);
        return -1;
    }
    memset(s->picture.rgb, 0, 3 * (size_t)s->width * s->height * sizeof *s->picture.rgb);
    return next_frame(s);
}

/* One wish is fulfilled a step. A wish that fails is forgotten: the error stands until the next one. */
int vw_show_step(vw_show *s)
{
    int *wishes[] = { &s->new_scene, &s->new_technique, &s->new_view };
    int (*const steps[])(vw_show *) = { load, open_technique, look };
    for (int i = 0; i < 3; i++) {
        if (!*wishes[i])
            continue;
        *wishes[i] = 0;
        s->error[0] = 0;
        s->moves = 0;
        if (steps[i](s) != 0)
            s->new_scene = s->new_technique = s->new_view = 0;
        return 1;
    }
    if (s->plays && s->loaded.animated && !s->error[0] && (!s->technique || s->frames)) {
        s->plays = move_on(s) == 0;
        return 1;
    }
    if (s->error[0] || !s->technique || s->frames >= (s->technique->averages ? (uint32_t)VW_MAX_FRAMES : 1u))
        return 0;
    if (!s->is_open)
        return 0;
    if (s->frames == 0)
        memset(s->picture.rgb, 0, 3 * (size_t)s->width * s->height * sizeof *s->picture.rgb);
    next_frame(s);
    return 1;
}

int vw_show_will_build(const vw_show *s) { return s->new_scene || (s->new_technique && s->technique); }

void vw_show_free(vw_show *s)
{
    close_technique(s);
    ex_pool_free(s->job.pool);
    ex_image_free(&s->frame);
    ex_image_free(&s->picture);
    ex_gbuffer_free(&s->gbuffer);
    ex_scene_free(&s->loaded);
    free(s->emitters);
    rd_args_free(&s->args);
    memset(s, 0, sizeof *s);
}

/* ---- keys ---- */

/* Keys that concern the written picture are the viewer's own business. */
static int is_shown(const rd_key *key)
{
    static const char *const hidden[] = { "ev", "background", "emission", "aa", "compute" };
    for (size_t i = 0; i < sizeof hidden / sizeof hidden[0]; i++)
        if (strcmp(hidden[i], key->name) == 0)
            return 0;
    return 1;
}

const rd_key *vw_show_key(const vw_show *s, int index)
{
    const rd_key *tables[2] = { NULL, rd_common_keys };
    if (!s->technique)
        return NULL;
    tables[0] = s->technique->keys;
    for (int i = 0; i < 2; i++)
        for (const rd_key *key = tables[i]; key && key->name; key++)
            if ((i == 0 || is_shown(key)) && index-- == 0)
                return key;
    return NULL;
}

static int find_change(const vw_show *s, const char *name)
{
    size_t length = strlen(name);
    int i = 0;
    while (i < s->change_count && !(strncmp(s->changes[i], name, length) == 0 && s->changes[i][length] == '='))
        i++;
    return i;
}

const char *vw_show_value(const vw_show *s, const rd_key *key)
{
    int i = find_change(s, key->name);
    return i < s->change_count ? s->changes[i] + strlen(key->name) + 1 : key->standard;
}

/* The word before or behind value in "a|b|c", round the ends. */
static void next_word(const char *words, const char *value, int direction, char *out, size_t size)
{
    char list[16][32];
    int count = 0, at = 0;
    while (*words && count < 16) {
        size_t length = strcspn(words, "|");
        snprintf(list[count], sizeof list[count], "%.*s", (int)length, words);
        if (strcmp(list[count], value) == 0)
            at = count;
        count++;
        words += length + (words[length] == '|');
    }
    snprintf(out, size, "%s", list[(at + direction + count) % count]);
}

/* Doubles or halves; small integers by one; from a word to the middle of the range. */
static void next_number(const rd_key *key, const char *value, int direction, char *out, size_t size)
{
    double n, low = key->low, high = key->high;
    if (rd_parse_number(value, &n) != 0)
        n = low > 0 ? sqrt(low * high) : 1;
    else if (key->kind == RD_INTEGER)
        n = direction > 0 ? (n < 4 ? n + 1 : 2 * n) : n <= 4 ? n - 1 : n / 2;
    else if (key->low < -100)           /* an angle */
        n += 15 * direction;
    else
        n = n == 0 ? 0.25 * direction : direction > 0 ? n * 2 : n <= 0.25 ? 0 : n / 2;
    n = n < low ? low : n > high ? high : n;
    if (key->kind == RD_INTEGER)
        snprintf(out, size, "%.0f", floor(n));
    else
        snprintf(out, size, "%g", n);
}

void vw_show_change(vw_show *s, const rd_key *key, int direction)
{
    char value[64];
    int at = find_change(s, key->name), is_common = 0;
    if (at == VW_MAX_CHANGES)
        return;
    if (key->kind == RD_WORD)
        next_word(key->words, vw_show_value(s, key), direction, value, sizeof value);
    else
        next_number(key, vw_show_value(s, key), direction, value, sizeof value);
    snprintf(s->changes[at], sizeof s->changes[at], "%s=%s", key->name, value);
    s->change_count += at == s->change_count;
    for (const rd_key *k = rd_common_keys; k->name; k++)
        is_common = is_common || k == key;
    if (is_common)
        s->new_scene = s->keeps_orbit = 1;
    else
        s->new_technique = 1;
}
