/* hdr_check.c - walks through a Radiance .hdr file before stb reads it, which goes on for ever where the file ends
   inside a row of run lengths, and keeps what the file's first line asks for. */
#include "internal.h"
#include <stdlib.h>
#include <string.h>

enum { TEXEL_BYTES = 40 };      /* 12 while it is read and kept, and what a technique takes to make lights of it */

typedef struct hdr { const uint8_t *at, *end; } hdr;

/* Returns the length of the line that begins at `at`, without its end, and moves `at` behind it. */
static size_t next_line(hdr *h)
{
    const uint8_t *from = h->at, *end = memchr(from, '\n', (size_t)(h->end - from));
    h->at = end ? end + 1 : h->end;
    return (size_t)((end ? end : h->end) - from);
}

/* Moves behind the header. Returns 0, or -1 where no line with the size of the picture follows it. */
static int find_pixels(hdr *h, unsigned *width, unsigned *height)
{
    char line[64] = "";
    const uint8_t *from;
    size_t length;
    while (h->at < h->end && next_line(h) > 0)
        continue;
    from = h->at;
    length = next_line(h);
    memcpy(line, from, length < sizeof line - 1 ? length : sizeof line - 1);
    return sscanf(line, "-Y %9u +X %9u", height, width) == 2 && *width && *height ? 0 : -1;
}

/* Moves behind one channel of a row of `width` run lengths. */
static int skip_runs(hdr *h, unsigned width)
{
    unsigned left = width;
    while (left) {
        unsigned count, bytes;
        if (h->at == h->end) return -1;
        count = *h->at++;
        bytes = count > 128 ? 1 : count;
        count = count > 128 ? count - 128 : count;
        if (!count || count > left || bytes > (size_t)(h->end - h->at)) return -1;
        h->at += bytes;
        left -= count;
    }
    return 0;
}

/* Returns 0 where the file has all rows: pixels of 4 bytes, or rows that begin with 2, 2 and their width. */
static int has_rows(hdr *h, unsigned width, unsigned height)
{
    for (unsigned y = 0; y < height; y++) {
        size_t left = (size_t)(h->end - h->at);
        if (y == 0 && (width < 8 || width >= 32768 || left < 4 || h->at[0] != 2 || h->at[1] != 2 || h->at[2] & 128))
            return (double)left < 4.0 * width * height ? -1 : 0;
        if (left < 4 || h->at[0] != 2 || h->at[1] != 2 || (h->at[2] << 8 | h->at[3]) != (int)width) return -1;
        h->at += 4;
        for (int channel = 0; channel < 4; channel++)
            if (skip_runs(h, width) != 0) return -1;
    }
    return 0;
}

int ex_hdr_check(const char *path, char *error)
{
    size_t size;
    unsigned width, height;
    uint8_t *data = (uint8_t *)ex_file_read(path, &size, error);
    hdr h;
    int result = 0;
    if (!data) return -1;
    h.at = data;
    h.end = data + size;
    if (size < 10 || (memcmp(data, "#?RADIANCE", 10) != 0 && memcmp(data, "#?RGBE", 6) != 0))
        result = ex_fail(error, "%s: not a Radiance .hdr picture", path);
    else if (find_pixels(&h, &width, &height) != 0)
        result = ex_fail(error, "%s: no line -Y HEIGHT +X WIDTH after its header", path);
    else if ((double)TEXEL_BYTES * width * height > (double)ex_memory_limit)
        result = ex_fail(error, "%s: a sky of %u x %u texels takes %.0f MB, more than %.0f: --limit-memory", path,
                         width, height, 1e-6 * TEXEL_BYTES * width * height, (double)ex_memory_limit * 1e-6);
    else if (has_rows(&h, width, height) != 0)
        result = ex_fail(error, "%s: a row of its pixels is damaged or missing", path);
    free(data);
    return result;
}
