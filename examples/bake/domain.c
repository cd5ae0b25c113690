/* domain.c - bake csm --domain: where maps look from. */
#include "csm.h"
#include "lightsampling.h"
#include "bake.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* In the order of cohsm_domain_kind; the last is a TABLE of places on what shines. */
static const struct { const char *name; cohsm_domain_kind kind; int numbers, file, sides; } domains[] = {
    { "latlong", COHSM_DOMAIN_LATLONG, 0, 0, 2 },     { "octahedral", COHSM_DOMAIN_OCTAHEDRAL, 0, 0, 2 },
    { "line", COHSM_DOMAIN_LINE, 6, 0, 1 },           { "rectangle", COHSM_DOMAIN_RECTANGLE, 9, 0, 2 },
    { "disc", COHSM_DOMAIN_DISC, 9, 0, 2 },           { "sphere", COHSM_DOMAIN_SPHERE, 4, 0, 2 },
    { "volume", COHSM_DOMAIN_VOLUME, 12, 0, 3 },      { "table", COHSM_DOMAIN_TABLE, 0, 1, 3 },
    { "list", COHSM_DOMAIN_LIST, 0, 1, 0 },           { "emissive", COHSM_DOMAIN_TABLE, 0, 0, 0 } };

enum { DOMAINS = sizeof domains / sizeof *domains, EMISSIVE = DOMAINS - 1, MOST_LOCATIONS = 1 << 24 };

const char *bk_domain_name(int kind)
{
    for (int i = 0; i < DOMAINS; i++)
        if ((int)domains[i].kind == kind)
            return domains[i].name;
    return "unknown";
}

int bk_domain_parse(bk_domain *out, const char *text, char *error)
{
    const size_t length = strcspn(text, ":");
    const char *at = text + length;
    int found = 0, count = 0;
    while (found < DOMAINS && (strlen(domains[found].name) != length || memcmp(domains[found].name, text, length)))
        found++;
    if (found == DOMAINS)
        return bk_fail(error, "--domain latlong|octahedral|line|rectangle|disc|sphere|volume|table|list|emissive: ",
                       text);
    memset(out, 0, sizeof *out);
    out->text = text;
    out->number = found;
    if (domains[found].file) {
        out->path = *at ? at + 1 : at;
        return *out->path ? 0 : bk_fail(error, "--domain: a file is missing: ", text);
    }
    while (count < domains[found].numbers && *at == (count ? ',' : ':')) {
        char word[40];
        double value;
        snprintf(word, sizeof word, "%.*s", (int)strcspn(at + 1, ","), at + 1);
        if (rd_parse_number(word, &value) != 0 || !(fabs(value) <= 1e9))
            break;
        out->numbers[count++] = (float)value;
        at += 1 + strcspn(at + 1, ",");
    }
    if (count == domains[found].numbers && !*at)
        return 0;
    snprintf(error, EX_ERROR_SIZE, "--domain %s takes %d numbers: %.120s", domains[found].name, domains[found].numbers,
             text);
    return -1;
}

/* Lines of x y z w; what # begins is no line. */
static int read_locations(bk_domain *d, char *error)
{
    void *data;
    size_t size, room = 0;
    int line = 0, result = bk_read(d->path, &data, &size, error);
    char *text = result == 0 ? realloc(data, size + 1) : NULL;
    if (result != 0)
        return -1;
    if (!text) {
        free(data);
        return bk_fail(error, "out of memory", "");
    }
    text[size] = 0;
    for (char *at = text, *next; result == 0 && *at; at = next) {
        float p[4];
        char *end = at + strcspn(at, "\n"), rest = 0;
        next = *end ? end + 1 : end;
        *end = 0;
        line++;
        if (*at == '#' || !at[strspn(at, " \t\r")])
            continue;
        if (sscanf(at, "%40f %40f %40f %40f %c", &p[0], &p[1], &p[2], &p[3], &rest) != 4) {
            snprintf(error, EX_ERROR_SIZE, "%.120s, line %d: not four numbers x y z w: %.40s", d->path, line, at);
            result = -1;
        } else if (d->count == room) {
            float *grown = d->count < MOST_LOCATIONS ? realloc(d->locations, 16 * (room = 2 * room + 64)) : NULL;
            if (!grown)
                result = bk_fail(error, "too many places: ", d->path);
            else d->locations = grown;
        }
        if (result == 0)
            memcpy(d->locations + 4 * d->count++, p, sizeof p);
    }
    free(text);
    return result == 0 && !d->count ? bk_fail(error, "no places: ", d->path) : result;
}

/* The corners of all triangles that shine, for free(), as one mesh; NULL: none, or out of memory. */
static uint32_t *shining(const bk_mesh *mesh, size_t *count)
{
    uint32_t *indices = mesh->radiance ? malloc((3 * mesh->lit_count + 1) * sizeof *indices) : NULL;
    *count = 0;
    for (size_t t = 0; t < mesh->lit_count && indices; t++) {
        const float *e = mesh->radiance + 3 * t;
        if (e[0] > 0 || e[1] > 0 || e[2] > 0)
            memcpy(indices + 3 * (*count)++, mesh->lit + 3 * t, 3 * sizeof *indices);
    }
    return indices;
}

/* Half the diagonal of the box about a mesh. */
static float size_of(const bk_mesh *mesh)
{
    float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, high[3] = { -HUGE_VALF, -HUGE_VALF, -HUGE_VALF }, size = 0;
    for (size_t i = 0; i < 3 * mesh->vertices; i++) {
        low[i % 3] = fminf(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], mesh->positions[i]);
    }
    for (int k = 0; k < 3; k++)
        size += 0.25f * (high[k] - low[k]) * (high[k] - low[k]);
    return sqrtf(size);
}

/* The places that lightsampling.h gives a mesh light of the triangles that shine, each for the same area, so that its
   samples' coordinates ask for them; as far above the surface as 1e-4 of the mesh's size, or it would hide itself. */
static int place_on_emissive(bk_domain *d, const bk_mesh *mesh, uint32_t count, char *error)
{
    size_t triangles, bytes = 0;
    uint32_t *indices = shining(mesh, &triangles);
    lsamp_mesh lit;
    lsamp_light_desc desc;
    lsamp_light *light;
    lsamp_domain domain;
    void *memory = NULL;
    memset(&lit, 0, sizeof lit);
    memset(&desc, 0, sizeof desc);
    lit.positions = mesh->positions;
    lit.vertex_count = mesh->vertices;
    lit.indices = indices;
    lit.index_count = 3 * triangles;
    desc.kind = LSAMP_LIGHT_MESH;
    desc.mesh = &lit;
    desc.place_count = count;
    desc.radius = 1e-4f * size_of(mesh);
    desc.radiance[0] = desc.radiance[1] = desc.radiance[2] = 1;
    if (triangles) {
        bytes = lsamp_light_bytes(&desc);
        memory = bytes ? malloc(bytes) : NULL;
    }
    if (memory && lsamp_light_init(&desc, memory, bytes, &light, NULL) == LSAMP_OK &&
        lsamp_light_domain(light, &domain) == LSAMP_OK) {
        d->locations = malloc(16 * domain.location_count);
        if (d->locations)
            memcpy(d->locations, domain.locations, 16 * domain.location_count);
        d->count = d->locations ? domain.location_count : 0;
    }
    free(memory);
    free(indices);
    return d->count ? 0 : bk_fail(error, triangles ? "--domain emissive: out of memory, or nothing of any area shines"
                                                   : "--domain emissive: nothing shines there", "");
}

void bk_domain_sides(const bk_domain *d, const rd_settings *settings, uint32_t side[3])
{
    static const char *const keys[3] = { "side", "side_v", "side_w" };
    for (int k = 0; k < 3; k++) {
        const int own = rd_setting_integer(settings, keys[k]);
        side[k] = k < domains[d->number].sides ? (uint32_t)(own ? own : rd_setting_integer(settings, "side")) : 1;
    }
    if (d->number == EMISSIVE)
        side[0] = (uint32_t)rd_setting_integer(settings, "side") * (uint32_t)rd_setting_integer(settings, "side");
    else if (domains[d->number].kind == COHSM_DOMAIN_TABLE)  /* those that are not given are 1 there */
        for (int k = 1; k < 3; k++)
            side[k] = rd_setting_integer(settings, keys[k]) ? side[k] : 1;
}

int bk_domain_load(bk_domain *d, const bk_mesh *mesh, const rd_settings *settings, char *error)
{
    uint32_t side[3];
    bk_domain_sides(d, settings, side);
    if (domains[d->number].file)
        return read_locations(d, error);
    return d->number == EMISSIVE ? place_on_emissive(d, mesh, side[0], error) : 0;
}

void bk_domain_fill(const bk_domain *d, const rd_settings *settings, cohsm_domain *out)
{
    float *const to[4] = { out->origin, out->u, out->v, out->w };
    bk_domain_sides(d, settings, out->side);
    out->kind = domains[d->number].kind;
    if (out->kind == COHSM_DOMAIN_SPHERE) {
        memcpy(out->origin, d->numbers, 12);
        out->u[0] = d->numbers[3];
    } else
        for (int k = 0; k < domains[d->number].numbers / 3; k++)
            memcpy(to[k], d->numbers + 3 * k, 12);
    out->locations = d->locations;
    out->location_count = d->count;
}
