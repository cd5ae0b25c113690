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

/* Says whether key=value is a setting of every technique. */
static int is_common(const char *change)
{
    for (const rd_key *key = rd_common_keys; key->name; key++) {
        size_t length = strlen(key->name);
        if (strncmp(change, key->name, length) == 0 && change[length] == '=')
            return 1;
    }
    return 0;
}

/* The reference has the technique's part of the light: its bounces (shadowfield: bounce=1), or none. */
static int reference_settings(const vw_show *s, char text[2][32])
{
    const rd_key *key;
    int count = 0, bounces = s->technique == &rd_rsm;
    for (int i = 0; (key = vw_show_key(s, i)) != NULL; i++) {
        if (strcmp(key->name, "bounces") == 0 || strcmp(key->name, "bounce") == 0)
            bounces = atoi(vw_show_value(s, key));
        if (strcmp(key->name, "only") == 0)
            snprintf(text[count++], 32, "only=%.20s", vw_show_value(s, key));
    }
    snprintf(text[count++], 32, "bounces=%d", bounces);
    return count;
}

/* Arguments of render for a technique, or for the reference of what is shown. The preview needs lights and a camera as
   well: any technique stands in for it. */
static int parse(vw_show *s, const rd_technique *wanted, rd_args *args)
{
    const rd_technique *technique = wanted ? wanted : &rd_csm;
    const int is_reference = wanted == &rd_reference && s->technique != wanted;
    char size[32], samples[16], own[2][32];
    char *values[24 + 2 * VW_MAX_CHANGES];
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
    if (wanted && technique->most_samples) {
        snprintf(samples, sizeof samples, "%u", is_reference ? 1u : (unsigned)samples_of(s));
        PUT("--samples");
        PUT(samples);
    }
    for (int i = 0; i < s->change_count; i++)
        if (!is_reference || is_common(s->changes[i])) {
            PUT("--set");
            PUT(s->changes[i]);
        }
    for (int i = is_reference ? reference_settings(s, own) : 0; i--;) {
        PUT("--set");
        PUT(own[i]);
    }
#undef PUT
    rd_args_free(args);
    return rd_args_parse(args, count, values, s->error);
}

/* ---- steps ---- */

static void close_side(vw_side *side)
{
    if (side->is_open && side->args.technique->close)
        side->args.technique->close(side->state);
    side->state = NULL;
    side->is_open = 0;
}

static void fill_job(vw_show *s, vw_side *side)
{
    rd_job *job = &side->job;
    *job = s->job;
    job->scene = &s->loaded;
    job->gbuffer = &s->gbuffer;
    job->settings = &side->args.settings;
    job->baked = NULL;
    job->aa = 1;
    job->samples = side->args.samples;
    job->frames = VW_MAX_FRAMES;
    job->gl = s->use_gl && rd_technique_has_gl(side->args.technique) ? s->gl : NULL;
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
    for (int i = 0; i < VW_SIDES; i++)
        close_side(&s->side[i]);
    memset(&fresh, 0, sizeof fresh);
    if (parse(s, s->technique, &s->args) != 0 ||
        rd_setup(&fresh, &job, &emitters, &s->args, (float)time / 30.0f, s->error) != 0)
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
    s->new_technique = s->new_reference = s->new_view = 1;
    return 0;
}

static int open_side(vw_show *s, vw_side *side, const rd_technique *technique)
{
    double start = ex_seconds();
    close_side(side);
    side->frames = 0;
    side->spent = 0;
    if (!technique)
        return 0;
    if (parse(s, technique, &side->args) != 0)
        return -1;
    if (!s->job.pool)
        s->job.pool = ex_pool_create(0);
    if (!s->job.pool)
        return fail(s, "out of memory");
    s->job.threads = ex_pool_threads(s->job.pool);
    fill_job(s, side);
    if (technique->open(&side->state, &side->job, s->error) != 0)
        return -1;
    side->is_open = 1;
    side->open_ms = 1000 * (ex_seconds() - start);
    return 0;
}

static int open_technique(vw_show *s) { return open_side(s, &s->side[VW_TECHNIQUE], s->technique); }

static int open_reference(vw_show *s)
{
    const int is_wanted = s->compares && s->technique && s->technique != &rd_reference;
    return open_side(s, &s->side[VW_REFERENCE], is_wanted ? &rd_reference : NULL);
}

static int look(vw_show *s)
{
    double start = ex_seconds();
    s->loaded.camera = s->home_camera;
    if (memcmp(&s->orbit, &s->home, sizeof s->orbit) != 0)
        vw_orbit_to(&s->orbit, &s->loaded.camera);
    for (int i = 0; i < VW_SIDES; i++)
        s->side[i].frames = 0, s->side[i].spent = 0;
    if (!s->technique)
        return 0;
    ex_gbuffer_free(&s->gbuffer);
    if (ex_gbuffer_render(&s->gbuffer, &s->loaded, s->width, s->height, 1, 0, s->error) != 0)
        return -1;
    for (int i = 0; i < VW_SIDES; i++) {
        vw_side *side = &s->side[i];
        if (side->frame.width == s->width && side->frame.height == s->height)
            continue;
        ex_image_free(&side->frame);
        ex_image_free(&side->picture);
        if (ex_image_alloc(&side->frame, s->width, s->height) != 0 ||
            ex_image_alloc(&side->picture, s->width, s->height) != 0)
            return fail(s, "out of memory");
    }
    s->gbuffer_ms = 1000 * (ex_seconds() - start);
    return 0;
}

static int next_frame(vw_show *s, vw_side *side)
{
    size_t values = 3 * (size_t)s->width * s->height;
    double start = ex_seconds();
    if (side->frames == 0)
        memset(side->picture.rgb, 0, values * sizeof *side->picture.rgb);
    side->job.frame = side->job.seed = side->frames;
    memset(side->frame.rgb, 0, values * sizeof *side->frame.rgb);
    if (side->args.technique->frame(side->state, &side->job, &side->frame, s->error) != 0)
        return -1;
    side->frames++;
    for (size_t i = 0; i < values; i++)
        side->picture.rgb[i] += (side->frame.rgb[i] - side->picture.rgb[i]) / (float)side->frames;
    side->frame_ms = 1000 * (ex_seconds() - start);
    side->spent += ex_seconds() - start;
    return 0;
}

/* One side follows the time. */
static int follow(vw_show *s, int i)
{
    vw_side *side = &s->side[i];
    if (side->is_open && side->args.technique->update) {
        fill_job(s, side);
        if (side->args.technique->update(side->state, &side->job, s->error) == 0)
            return next_frame(s, side);
        close_side(side);
        return -1;
    }
    if ((i == VW_TECHNIQUE ? open_technique(s) : open_reference(s)) != 0)
        return -1;
    return side->is_open ? next_frame(s, side) : 0;
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
    return follow(s, VW_TECHNIQUE) != 0 || (s->compares && follow(s, VW_REFERENCE) != 0) ? -1 : 0;
}

static int goes_on(const vw_side *side)
{
    return side->is_open && side->frames < (side->args.technique->averages ? (uint32_t)VW_MAX_FRAMES : 1u);
}

/* Whose frame is next: both sides take the same time, the technique's first; NULL where all is done. */
static vw_side *next_side(vw_show *s)
{
    vw_side *technique = &s->side[VW_TECHNIQUE], *reference = &s->side[VW_REFERENCE];
    if (goes_on(reference) && (!goes_on(technique) || (technique->frames && reference->spent < technique->spent)))
        return reference;
    return goes_on(technique) ? technique : NULL;
}

/* One wish is fulfilled a step. A wish that fails is forgotten: the error stands until the next one. */
int vw_show_step(vw_show *s)
{
    /* Techniques are opened with the G-buffer that they will shade, as in render: they take its size. */
    int *wishes[] = { &s->new_scene, &s->new_view, &s->new_technique, &s->new_reference };
    int (*const steps[])(vw_show *) = { load, look, open_technique, open_reference };
    vw_side *side;
    for (int i = 0; i < 4; i++) {
        if (!*wishes[i])
            continue;
        *wishes[i] = 0;
        s->error[0] = 0;
        s->moves = 0;
        if (steps[i](s) != 0)
            s->new_scene = s->new_technique = s->new_reference = s->new_view = 0;
        return 1;
    }
    if (s->plays && s->loaded.animated && !s->error[0] && (!s->technique || s->side[VW_TECHNIQUE].frames)) {
        s->plays = move_on(s) == 0;
        return 1;
    }
    side = s->error[0] || !s->technique ? NULL : next_side(s);
    if (side)
        next_frame(s, side);
    return side != NULL;
}

int vw_show_error(const vw_show *s, double *relative_rmse, double *mean_ratio)
{
    const vw_side *a = &s->side[VW_TECHNIQUE], *b = &s->side[VW_REFERENCE];
    size_t values = 3 * (size_t)a->picture.width * a->picture.height;
    double squares = 0, sum[2] = { 0, 0 };
    if (!s->technique || !a->frames || !b->frames || !b->is_open)
        return 0;
    for (size_t i = 0; i < values; i++) {
        const double x = (double)a->picture.rgb[i], y = (double)b->picture.rgb[i];
        squares += (x - y) * (x - y);
        sum[0] += x;
        sum[1] += y;
    }
    if (!(sum[1] > 0))
        return 0;
    *relative_rmse = sqrt(squares / (double)values) / (sum[1] / (double)values);
    *mean_ratio = sum[0] / sum[1];
    return 1;
}

int vw_show_will_build(const vw_show *s)
{
    return s->new_scene || (s->technique && (s->new_technique || (s->new_reference && s->compares)));
}

void vw_show_free(vw_show *s)
{
    for (int i = 0; i < VW_SIDES; i++) {
        vw_side *side = &s->side[i];
        close_side(side);
        ex_image_free(&side->frame);
        ex_image_free(&side->picture);
        rd_args_free(&side->args);
    }
    ex_pool_free(s->job.pool);
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
    int at = find_change(s, key->name);
    if (at == VW_MAX_CHANGES)
        return;
    if (key->kind == RD_WORD)
        next_word(key->words, vw_show_value(s, key), direction, value, sizeof value);
    else
        next_number(key, vw_show_value(s, key), direction, value, sizeof value);
    snprintf(s->changes[at], sizeof s->changes[at], "%s=%s", key->name, value);
    s->change_count += at == s->change_count;
    if (is_common(s->changes[at]))
        s->new_scene = s->keeps_orbit = 1;
    else
        s->new_technique = s->new_reference = 1;
}
