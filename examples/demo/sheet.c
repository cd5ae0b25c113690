/* sheet.c - PNG of every picture at the exposure of its group, and all of them small on one sheet. */
#include "gallery.h"

#include <stdlib.h>
#include <string.h>

/* Three quarters of a thousand pixels wide: on a phone's screen letters and pictures can still be told apart. */
enum { COLUMNS = 4, CAPTION = 22, MARGIN = 4, THUMB = 184, LETTER = 2 };

typedef struct sheet {
    uint32_t thumb_width, thumb_height, width, height;
    uint32_t used;              /* places: row by row */
    uint8_t *rgb;
} sheet;

static int load(const gallery *g, const char *stem, ex_image *image, char *error)
{
    char path[400];
    snprintf(path, sizeof path, "%s/%s.pfm", g->folder, stem);
    return ex_image_read_pfm(image, path, error);
}

static int convert(gallery *g, const char *stem, float ev, char *error)
{
    char path[400];
    ex_image image;
    int result = load(g, stem, &image, error);
    if (result == 0) {
        g->width = image.width;
        g->height = image.height;
        snprintf(path, sizeof path, "%s/%s.png", g->folder, stem);
        result = ex_image_write(&image, path, ev, error);
        ex_image_free(&image);
    }
    return result;
}

int gal_pictures(gallery *g, char *error)
{
    for (uint32_t i = 0; i < g->group_count; i++) {
        const gal_group *group = &g->groups[i];
        if (*group->reference && convert(g, group->reference, group->ev, error) != 0) return -1;
        for (uint32_t k = 0; k < group->row_count; k++)
            if (convert(g, group->rows[k].stem, group->ev, error) != 0) return -1;
    }
    return 0;
}

/* ---- the sheet ---- */

static uint8_t srgb(float x)
{
    x = ex_clamp(x, 0, 1);
    return (uint8_t)(255 * (x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f) + 0.5f);
}

/* Letters of 5 x 7 dots, each dot LETTER pixels a side. */
static void write_caption(sheet *s, uint32_t x, uint32_t y, const char *text)
{
    for (uint32_t end = x + s->thumb_width; *text && x + 5 * LETTER <= end; text++, x += 6 * LETTER) {
        const char *glyph = ex_glyph(*text);
        for (uint32_t i = 0; i < 35 * LETTER * LETTER; i++) {
            uint32_t u = i % (5 * LETTER), v = i / (5 * LETTER);
            if (glyph[v / LETTER * 5 + u / LETTER] == '#')
                memset(s->rgb + 3 * ((size_t)(y + v) * s->width + x + u), 60, 3);
        }
    }
}

/* Means of the pixels under each small one. */
static void shrink(sheet *s, uint32_t left, uint32_t top, const ex_image *image, float gain)
{
    for (uint32_t y = 0; y < s->thumb_height; y++)
        for (uint32_t x = 0; x < s->thumb_width; x++) {
            uint32_t x0 = x * image->width / s->thumb_width, x1 = (x + 1) * image->width / s->thumb_width;
            uint32_t y0 = y * image->height / s->thumb_height, y1 = (y + 1) * image->height / s->thumb_height;
            uint8_t *to = s->rgb + 3 * ((size_t)(top + y) * s->width + left + x);
            for (size_t k = 0; k < 3; k++) {
                float sum = 0;
                for (size_t v = y0; v < y1; v++)
                    for (size_t u = x0; u < x1; u++) {
                        float value = gain * image->rgb[3 * (v * image->width + u) + k];
                        sum += value < 1 ? value : 1;   /* clamped as in the large picture; a NaN is white */
                    }
                to[k] = srgb(sum / (float)((x1 - x0) * (y1 - y0)));
            }
        }
}

static int add(gallery *g, sheet *s, const gal_group *group, const char *stem, const char *caption, char *error)
{
    ex_image image;
    uint32_t left = MARGIN + s->used % COLUMNS * (s->thumb_width + MARGIN);
    uint32_t top = MARGIN + s->used / COLUMNS * (s->thumb_height + CAPTION);
    s->used++;
    if (!s->rgb) return 0;                      /* only counted */
    if (load(g, stem, &image, error) != 0) return -1;
    shrink(s, left, top, &image, exp2f(group->ev));
    ex_image_free(&image);
    write_caption(s, left, top + s->thumb_height + 3, caption);
    return 0;
}

/* What OpenGL drew looks the same and is left to the page. */
static uint32_t count_pictures(const gal_group *group)
{
    uint32_t count = *group->reference != 0;
    for (uint32_t k = 0; k < group->row_count; k++) count += strcmp(group->rows[k].backend, "cpu") == 0;
    return count;
}

/* The scene's name stands under its first picture; a group that does not fit begins a new row. */
static int fill(gallery *g, sheet *s, char *error)
{
    s->used = 0;
    for (uint32_t i = 0; i < g->group_count; i++) {
        const gal_group *group = &g->groups[i];
        uint32_t column = s->used % COLUMNS, count = count_pictures(group);
        char name[80];
        int first = 1;
        if (column && column + count > COLUMNS) s->used += COLUMNS - column;
        snprintf(name, sizeof name, "%s%s", group->scene, strcmp(group->kind, "bounced") == 0 ? " bounced" : "");
        if (*group->reference) {
            if (add(g, s, group, group->reference, name, error) != 0) return -1;
            first = 0;
        }
        for (uint32_t k = 0; k < group->row_count; k++) {
            const gal_row *row = &group->rows[k];
            char caption[120];
            if (strcmp(row->backend, "cpu") != 0) continue;
            snprintf(caption, sizeof caption, "%s%s%s", first ? name : "", first ? ": " : "", row->technique);
            if (add(g, s, group, row->stem, caption, error) != 0) return -1;
            first = 0;
        }
    }
    return 0;
}

int gal_sheet(gallery *g, char *error)
{
    char path[400];
    sheet s;
    int result;
    if (g->width == 0) return 0;
    memset(&s, 0, sizeof s);
    s.thumb_width = g->width < THUMB ? g->width : THUMB;
    s.thumb_height = s.thumb_width * g->height / g->width;
    if (s.thumb_height == 0 || fill(g, &s, error) != 0) return 0;
    s.width = MARGIN + COLUMNS * (s.thumb_width + MARGIN);
    s.height = MARGIN + (s.used + COLUMNS - 1) / COLUMNS * (s.thumb_height + CAPTION);
    s.rgb = (uint8_t *)malloc((size_t)s.width * s.height * 3);
    if (!s.rgb) return ex_fail(error, "out of memory");
    memset(s.rgb, 255, (size_t)s.width * s.height * 3);         /* as the page it stands on */
    snprintf(path, sizeof path, "%s/contact.png", g->folder);
    result = fill(g, &s, error);
    if (result == 0) result = ex_png_write(path, s.width, s.height, s.rgb, error);
    free(s.rgb);
    return result;
}
