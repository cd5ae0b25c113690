/* main.c - gallery FOLDER: see gallery.h. */
#include "gallery.h"

#include <stdlib.h>
#include <string.h>

extern const char dapple_commit[];

/* ---- files in the folder ---- */

static char *read_text(const gallery *g, const char *stem, const char *suffix)
{
    char path[400], *text;
    FILE *file;
    size_t size;
    snprintf(path, sizeof path, "%s/%s%s", g->folder, stem, suffix);
    file = fopen(path, "rb");
    text = (char *)calloc(1, 16384);
    size = file && text ? fread(text, 1, 16383, file) : 0;
    if (file) fclose(file);
    if (size) return text;
    free(text);
    return NULL;
}

/* "name": number, in the one line of JSON that render and compare write; else NaN. */
static double number_in(const char *json, const char *name)
{
    char key[60], *end;
    const char *at;
    double value;
    snprintf(key, sizeof key, "\"%s\": ", name);
    at = json ? strstr(json, key) : NULL;
    if (!at) return (double)NAN;
    at += strlen(key);
    value = strtod(at, &end);
    return end == at ? (double)NAN : value;
}

static void text_in(const char *json, const char *name, char *out, size_t size)
{
    char key[60];
    const char *at, *end;
    snprintf(key, sizeof key, "\"%s\": \"", name);
    at = json ? strstr(json, key) : NULL;
    end = at ? strchr(at + strlen(key), '"') : NULL;
    if (end) snprintf(out, size, "%.*s", (int)(end - at - (long)strlen(key)), at + strlen(key));
}

static int read_row(gallery *g, gal_group *group, gal_row *row)
{
    char *json = read_text(g, row->stem, ".json"), *compared = read_text(g, row->stem, "-compare.json");
    int is_first = group->row_count == 1 && !*group->reference;
    row->precompute_ms = number_in(json, "precompute_ms");
    row->frame_ms = number_in(json, "frame_ms");
    row->memory_bytes = number_in(json, "memory_bytes");
    row->error = number_in(compared, "relative_rmse");
    row->ssim = number_in(compared, "ssim");
    row->mean_ratio = number_in(compared, "mean_ratio");
    group->triangles = number_in(json, "triangles");
    text_in(json, "gl_renderer", g->gl_renderer, sizeof g->gl_renderer);
    if (is_first && json) group->ev = (float)number_in(json, "ev");
    free(json);
    free(compared);
    return json ? 0 : -1;
}

static void read_reference(gallery *g, gal_group *group)
{
    char *json = *group->reference ? read_text(g, group->reference, ".json") : NULL;
    group->reference_ms = number_in(json, "frame_ms");
    group->noise = number_in(json, "noise");
    group->kept_ms = number_in(json, "kept_ms");
    group->samples = number_in(json, "samples");
    if (json) group->ev = (float)number_in(json, "ev");
    else group->reference[0] = 0;
    free(json);
}

/* ---- the list ---- */

#define COPY(to, from) snprintf(to, sizeof(to), "%s", from)

static int read_line(gallery *g, char *line, char *error)
{
    const char *field[5] = { "", "", "", "", "" };
    gal_group *group;
    gal_row *row;
    line[strcspn(line, "\r\n")] = 0;
    for (int i = 0; i < 5 && line; i++) {
        char *tab = strchr(line, '\t');
        field[i] = line;
        if (tab) *tab = 0;
        line = tab ? tab + 1 : NULL;
    }
    if (strcmp(field[0], "left") == 0) {
        size_t used = strlen(g->left_out);
        snprintf(g->left_out + used, sizeof g->left_out - used, "%s%s", used ? "; " : "", field[1]);
    } else if (strcmp(field[0], "run") == 0) {
        COPY(g->run, field[1]);
    } else if (strcmp(field[0], "best") == 0) {
        COPY(g->best, field[1]);
    } else if (strcmp(field[0], "scenes") == 0) {
        g->scenes = (uint32_t)strtoul(field[1], NULL, 10);
        g->done = (uint32_t)strtoul(field[2], NULL, 10);
    } else if (strcmp(field[0], "group") == 0) {
        if (ex_grow(&g->groups, &g->group_count, sizeof *g->groups) != 0) return ex_fail(error, "out of memory");
        group = &g->groups[g->group_count - 1];
        COPY(group->scene, field[1]);
        COPY(group->kind, field[2]);
        COPY(group->title, field[3]);
        COPY(group->reference, field[4]);
        read_reference(g, group);
    } else if (strcmp(field[0], "row") == 0 && g->group_count) {
        group = &g->groups[g->group_count - 1];
        if (ex_grow(&group->rows, &group->row_count, sizeof *group->rows) != 0) return ex_fail(error, "out of memory");
        row = &group->rows[group->row_count - 1];
        COPY(row->technique, field[1]);
        COPY(row->backend, field[2]);
        COPY(row->label, field[3]);
        COPY(row->stem, field[4]);
        if (read_row(g, group, row) != 0) return ex_fail(error, "%s/%s.json: cannot read", g->folder, row->stem);
    }
    return 0;
}

/* What the times belong to. */
static void find_machine(gallery *g)
{
    char line[300], cpu[200] = "unknown processor";
    FILE *file = fopen("/proc/cpuinfo", "r");
    ex_pool *pool = ex_pool_create(0);
    while (file && fgets(line, sizeof line, file))
        if (strncmp(line, "model name", 10) == 0 && strchr(line, ':')) {
            line[strcspn(line, "\n")] = 0;
            COPY(cpu, strchr(line, ':') + 2);
            break;
        }
    if (file) fclose(file);
    snprintf(g->machine, sizeof g->machine, "%s, %d threads%s%s; commit %s", cpu, pool ? ex_pool_threads(pool) : 1,
             *g->gl_renderer ? "; OpenGL: " : "", g->gl_renderer, dapple_commit);
    ex_pool_free(pool);
}

int gal_read(gallery *g, const char *folder, char *error)
{
    char line[1200];
    int result = 0;
    FILE *file;
    memset(g, 0, sizeof *g);
    g->folder = folder;
    snprintf(line, sizeof line, "%s/gallery.tsv", folder);
    file = fopen(line, "r");
    if (!file) return ex_fail(error, "%s: cannot open", line);
    while (result == 0 && fgets(line, sizeof line, file)) result = read_line(g, line, error);
    fclose(file);
    if (result == 0) find_machine(g);
    return result;
}

void gal_free(gallery *g)
{
    for (uint32_t i = 0; i < g->group_count; i++) free(g->groups[i].rows);
    free(g->groups);
    memset(g, 0, sizeof *g);
}

extern const char dapple_version[];        /* of CHANGELOG.md, by the Makefile */

int main(int count, char **values)
{
    char error[EX_ERROR_SIZE] = "";
    gallery g;
    int result;
    if (count == 2 && strcmp(values[1], "--version") == 0)
        return printf("gallery %s\n", dapple_version), 0;
    if (count == 2 && strcmp(values[1], "--help") == 0)
        return puts("usage: gallery FOLDER\n"
                    "       gallery --help | --version\n"
                    "Makes the pages and the contact sheet of make demo from FOLDER/gallery.tsv and the pictures there."), 0;
    if (count != 2) {
        fprintf(stderr, "gallery: usage: gallery FOLDER\n");
        return 2;
    }
    result = gal_read(&g, values[1], error);
    if (result == 0) result = gal_pictures(&g, error);
    if (result == 0) result = gal_sheet(&g, error);
    if (result == 0) result = gal_index(&g, error);
    if (result == 0) result = gal_which(&g, error);
    if (result != 0) fprintf(stderr, "gallery: %s\n", error);
    gal_free(&g);
    return result != 0;
}
