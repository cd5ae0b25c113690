/* panel.c - see viewer.h */
#include "viewer.h"

#include <stdlib.h>
#include <string.h>

enum { SCALE = 2, STEP = (VW_GLYPH_WIDTH + 1) * SCALE };

int vw_panel_size(vw_panel *panel, uint32_t width, uint32_t height)
{
    unsigned char *grown;
    if (panel->width == width && panel->height == height)
        return 0;
    grown = realloc(panel->rgba, 4 * (size_t)width * height);
    if (!grown)
        return -1;
    panel->rgba = grown;
    panel->width = width;
    panel->height = height;
    return 0;
}

void vw_panel_clear(vw_panel *panel) { memset(panel->rgba, 0, 4 * (size_t)panel->width * panel->height); }

static void fill(vw_panel *panel, uint32_t x, uint32_t y, uint32_t width, uint32_t height, const unsigned char rgba[4])
{
    for (uint32_t j = y; j < y + height && j < panel->height; j++)
        for (uint32_t i = x; i < x + width && i < panel->width; i++)
            memcpy(panel->rgba + 4 * ((size_t)j * panel->width + i), rgba, 4);
}

uint32_t vw_panel_text(vw_panel *panel, uint32_t x, uint32_t y, const char *text, int is_selected)
{
    static const unsigned char strip[2][4] = { { 0, 0, 0, 150 }, { 40, 80, 160, 220 } },
                               ink[4] = { 255, 255, 255, 255 };
    uint32_t length = (uint32_t)strlen(text);
    fill(panel, x, y, length * STEP + 2 * SCALE, VW_LINE_HEIGHT, strip[is_selected != 0]);
    for (uint32_t c = 0; c < length; c++) {
        const char *glyph = ex_glyph(text[c]);
        for (uint32_t i = 0; i < VW_GLYPH_WIDTH * VW_GLYPH_HEIGHT; i++)
            if (glyph[i] == '#')
                fill(panel, x + 2 * SCALE + c * STEP + i % VW_GLYPH_WIDTH * SCALE,
                     y + SCALE + i / VW_GLYPH_WIDTH * SCALE, SCALE, SCALE, ink);
    }
    return y + VW_LINE_HEIGHT;
}
