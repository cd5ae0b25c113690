/* 01e_csm_streaming.c - a walk past 200 objects, of whose coherent shadow maps a quarter fits into memory.

   cc -O2 01e_csm_streaming.c -lm -o streaming && ./streaming objects.csms

   200 rocks stand along a road; their maps lie in one file, which the system maps into memory where it can and the
   program reads piece by piece elsewhere. A stretch of ground moves along the road with us, and the low sun throws the
   rocks' shadows onto it. The stream loads the rocks that the stretch needs and lets those go that were not needed for
   the longest time. Every answer is compared with that of all rocks in memory. */
#if !defined(_WIN32)
#define _DEFAULT_SOURCE
#define _DARWIN_C_SOURCE
#endif
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#define MAPPED 1
#else
#define MAPPED 0
#endif

enum { ROCKS = 200, RINGS = 12, SIDES = 16, CORNERS = RINGS * SIDES, POINTS = 4096, STEPS = 120 };

/* Each rock's maps begin at a page, so that its pages can be given back alone. */
enum { PAGE = 65536 };

/* ---- the rocks ---- */

static cohsm_maps *make_rock(uint32_t number)
{
    static float corners[3 * CORNERS];
    static uint32_t triangles[6 * RINGS * SIDES];
    cohsm_mesh mesh;
    cohsm_desc desc;
    cohsm_maps *maps = NULL;
    uint32_t ring, side, count = 0;

    for (ring = 0; ring < RINGS; ring++)
        for (side = 0; side < SIDES; side++) {
            const float a = 6.2831853f * (float)side / SIDES, b = 3.14159265f * ((float)ring + 0.5f) / RINGS;
            const float bump = sinf(3.0f * a + (float)number) * sinf(2.0f * b + 0.7f * (float)number);
            const float r = (1.0f + 0.25f * bump) * (0.6f + 0.4f * sinf(1.3f * (float)number));
            float *p = corners + 3 * (ring * SIDES + side);
            p[0] = r * sinf(b) * cosf(a);
            p[1] = 1.5f * r * cosf(b);
            p[2] = r * sinf(b) * sinf(a);
            if (ring + 1 < RINGS) {
                const uint32_t next = (side + 1) % SIDES, here = ring * SIDES;
                triangles[count++] = here + side, triangles[count++] = here + next;
                triangles[count++] = here + SIDES + side, triangles[count++] = here + next;
                triangles[count++] = here + SIDES + next, triangles[count++] = here + SIDES + side;
            }
        }
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = CORNERS;
    mesh.indices = triangles;
    mesh.index_count = count;
    memset(&desc, 0, sizeof desc);
    desc.domain.side[0] = desc.domain.side[1] = 16;         /* small, so that the example is quick */
    desc.map_side = 32;
    desc.order = COHSM_ORDER_HILBERT;
    desc.orientation = COHSM_ORIENTATION_POLAR;
    return cohsm_build(&desc, &mesh, &maps, NULL) == COHSM_OK ? maps : NULL;
}

/* ---- their file ---- */

typedef struct archive {
    long   at[ROCKS];                   /* where each rock's maps begin */
    size_t bytes[ROCKS], length;
    FILE  *file;                        /* read piece by piece, */
    char  *mapped;                      /* or mapped as a whole */
    unsigned loads;
} archive;

static int write_rock(archive *a, FILE *f, uint32_t number, const cohsm_maps *maps)
{
    static const char nothing[PAGE];
    size_t gap;
    void *bytes;
    cohsm_info info;
    int good;

    cohsm_get_info(maps, &info);
    bytes = malloc(info.bytes);
    if (!bytes) return 0;
    a->at[number] = (long)a->length;
    a->bytes[number] = info.bytes;
    gap = (PAGE - info.bytes % PAGE) % PAGE;
    good = cohsm_write(maps, bytes, info.bytes) == COHSM_OK && fwrite(bytes, 1, info.bytes, f) == info.bytes &&
           fwrite(nothing, 1, gap, f) == gap;
    a->length += info.bytes + gap;
    free(bytes);
    return good;
}

static int open_archive(archive *a, const char *path)
{
#if MAPPED
    const int file = open(path, O_RDONLY);
    void *mapped = file < 0 ? MAP_FAILED : mmap(NULL, a->length, PROT_READ, MAP_PRIVATE, file, 0);
    if (file >= 0) close(file);
    if (mapped == MAP_FAILED) return 0;
    a->mapped = (char *)mapped;
    return 1;
#else
    a->file = fopen(path, "rb");
    return a->file != NULL;
#endif
}

static int load_rock(void *user, uint32_t number, const void **data, size_t *bytes)
{
    archive *a = (archive *)user;
    void *read;

    a->loads++;
    *bytes = a->bytes[number];
    if (a->mapped) {
        *data = a->mapped + a->at[number];
        return 0;
    }
    read = malloc(*bytes);
    if (!read || fseek(a->file, a->at[number], SEEK_SET) || fread(read, 1, *bytes, a->file) != *bytes) {
        free(read);
        return 1;
    }
    *data = read;
    return 0;
}

/* The system may take the pages of a mapped rock back; what was read is freed. */
static void unload_rock(void *user, uint32_t number, const void *data, size_t bytes)
{
    archive *a = (archive *)user;
#if MAPPED
    (void)data;
    (void)madvise(a->mapped + a->at[number], bytes, MADV_DONTNEED);
#else
    (void)a;
    (void)number;
    (void)bytes;
    free((void *)(uintptr_t)data);
#endif
}

/* ---- the walk ---- */

static void say(void *user, const char *message) { fprintf((FILE *)user, "%s\n", message); }

static void place_rock(uint32_t number, float *transform)
{
    static const float identity[16] = { 1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1 };
    memcpy(transform, identity, sizeof identity);
    transform[12] = 3.0f * (float)(number / 2);
    transform[14] = number % 2 ? 3.0f : -3.0f;
}

/* Points of the ground within 10 units of where we stand. */
static void make_points(int step, float *points)
{
    int i;
    for (i = 0; i < POINTS; i++) {
        points[3 * i] = 300.0f * (float)step / STEPS + 20.0f * ((float)(i % 64) / 63.0f - 0.5f);
        points[3 * i + 1] = -1.0f;
        points[3 * i + 2] = 16.0f * ((float)(i / 64) / 63.0f - 0.5f);
    }
}

static cohsm_instance all[ROCKS];
static cohsm_stream_instance rocks[ROCKS];

/* Makes the rocks' file. */
static int make_rocks(archive *a, const char *path)
{
    FILE *f = fopen(path, "wb");
    uint32_t i;
    int good = f != NULL;
    for (i = 0; i < ROCKS && good; i++) {
        cohsm_maps *maps = make_rock(i);
        good = maps && write_rock(a, f, i, maps);
        cohsm_free(maps);
    }
    return good && fclose(f) == 0 && open_archive(a, path);
}

/* Opens all rocks at once, to compare with: a mapped file is read where it lies. Returns the bytes that copies of all
   would take in memory, which the headers of their files say; 0: they cannot be opened. */
static size_t open_rocks(archive *a)
{
    cohsm_open_desc desc;
    size_t whole = 0, bytes;
    const void *data;
    uint32_t i;
    memset(&desc, 0, sizeof desc);
    desc.in_place = MAPPED;
    for (i = 0; i < ROCKS; i++) {
        cohsm_maps *maps = NULL;
        cohsm_info of;
        if (load_rock(a, i, &data, &bytes) || cohsm_file_info(data, bytes, NULL, &of) != COHSM_OK ||
            cohsm_open_file(&desc, data, bytes, &maps) != COHSM_OK)
            return 0;
        if (!MAPPED) unload_rock(a, i, data, bytes);
        whole += of.memory_bytes;
        all[i].maps = maps;
        rocks[i].object = i;
        place_rock(i, all[i].transform);
        place_rock(i, rocks[i].transform);
    }
    return whole;
}

static void free_rocks(archive *a, const char *path)
{
    uint32_t i;
    for (i = 0; i < ROCKS; i++) cohsm_free((cohsm_maps *)(uintptr_t)all[i].maps);
#if MAPPED
    munmap(a->mapped, a->length);
#else
    fclose(a->file);
#endif
    remove(path);
}

/* The way of the sun's light to where we stand on the road: does the rock at hand lie in it? The rock is held while it
   is asked, so that it cannot leave. -1: it could not be had. */
static int is_in_shadow(cohsm_stream *stream, int step, const float *sun)
{
    const float here = 300.0f * (float)step / STEPS;
    const uint32_t rock = 2 * (uint32_t)(here / 3.0f + 0.5f) % ROCKS + 1;       /* on the side of the sun */
    float point[3], visible = 1;
    const cohsm_maps *maps;
    cohsm_query query;
    cohsm_result result;
    memset(&query, 0, sizeof query);
    point[0] = here - rocks[rock].transform[12];                                /* in the rock's own space */
    point[1] = -1.0f;
    point[2] = 1.8f - rocks[rock].transform[14];
    query.count = 1;
    query.positions = point;
    query.lights = sun;
    if (cohsm_stream_use(stream, rock, &maps) != COHSM_OK) return -1;
    result = cohsm_visible(maps, &query, &visible, NULL);
    cohsm_stream_end(stream, rock);
    return result == COHSM_OK ? visible < 0.5f : -1;
}

/* Walks along the road. Writes which share of the ground was dark, and at how many steps we were; returns at how many
   steps the stream's answers were not those of all rocks in memory, or -1. */
static int walk(cohsm_stream *stream, double *dark, int *cool)
{
    static float points[3 * POINTS], streamed[POINTS], in_memory[POINTS];
    static const float sun[3] = { 0.5f, 0.6f, 0.4f };
    cohsm_query query;
    int step, k, wrong = 0;

    memset(&query, 0, sizeof query);
    query.count = POINTS;
    query.positions = points;
    query.lights = sun;
    query.one_light = 1;
    for (step = 0; step < STEPS; step++) {
        make_points(step, points);
        if (cohsm_stream_visible_scene(stream, rocks, ROCKS, &query, streamed, NULL) != COHSM_OK ||
            cohsm_visible_scene(all, ROCKS, &query, in_memory, NULL) != COHSM_OK)
            return -1;
        wrong += memcmp(streamed, in_memory, sizeof streamed) != 0;
        for (k = 0; k < POINTS; k++) *dark += (1.0 - (double)streamed[k]) / ((double)STEPS * POINTS);
        k = is_in_shadow(stream, step, sun);
        if (k < 0) return -1;
        *cool += k;
    }
    return wrong;
}

int main(int count, char **arguments)
{
    static archive a;
    const char *path = count > 1 ? arguments[1] : "objects.csms";
    const size_t whole = make_rocks(&a, path) ? open_rocks(&a) : 0;
    cohsm_stream_desc desc;
    cohsm_stream_stats info;
    cohsm_stream *stream = NULL;
    double dark = 0;
    int wrong, cool = 0;

    if (!whole) return fprintf(stderr, "cannot make %s\n", path), 1;
    memset(&desc, 0, sizeof desc);
    desc.system.log = say;
    desc.system.user = stderr;
    desc.object_count = ROCKS;
    desc.budget_bytes = whole / 4;
    desc.in_place = MAPPED;
    desc.load_fn = load_rock;
    desc.unload_fn = unload_rock;
    desc.user = &a;
    if (cohsm_stream_create(&desc, &stream) != COHSM_OK) return 1;
    wrong = walk(stream, &dark, &cool);
    cohsm_stream_get_stats(stream, &info);
    printf("%d rocks, %.1f MB; in memory at most %.1f MB, %s\n", ROCKS, (double)whole / 1e6,
           (double)info.peak_bytes / 1e6, MAPPED ? "mapped" : "read");
    printf("%d steps: %lu questions to rocks found %lu in memory, %lu were loaded, %lu left\n", STEPS,
           (unsigned long)(info.hits + info.loads), (unsigned long)info.hits, (unsigned long)info.loads,
           (unsigned long)info.evictions);
    printf("%.1f %% of the ground is dark, and we were at %d steps; %d steps differ from all rocks in memory\n",
           100.0 * dark, cool, wrong);
    cohsm_stream_free(stream);
    free_rocks(&a, path);
    return wrong != 0 || info.peak_bytes > whole / 4;
}
