/* domain.c - bake csm --domain: where maps look from. */
#include "csm.h"
#include "bake.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* In the order of cohsm_domain_kind; the last is a LIST of places on what shines. */
static const struct { const char *name; cohsm_domain_kind kind; int numbers, file, sides; } domains[] = {
    { "latlong", COHSM_DOMAIN_LATLONG, 0, 0, 2 },     { "octahedral", COHSM_DOMAIN_OCTAHEDRAL, 0, 0, 2 },
    { "line", COHSM_DOMAIN_LINE, 6, 0, 1 },           { "rectangle", COHSM_DOMAIN_RECTANGLE, 9, 0, 2 },
    { "disc", COHSM_DOMAIN_DISC, 9, 0, 2 },           { "sphere", COHSM_DOMAIN_SPHERE, 4, 0, 2 },
    { "volume", COHSM_DOMAIN_VOLUME, 12, 0, 3 },      { "table", COHSM_DOMAIN_TABLE, 0, 1, 3 },
    { "list", COHSM_DOMAIN_LIST, 0, 1, 0 },           { "emissive", COHSM_DOMAIN_LIST, 0, 0, 0 } };

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

/* Corners and normal of a shining triangle; returns twice its area, 0 where it does not shine. */
static float corners_of(const bk_mesh *mesh, size_t t, const float *corner[3], float *normal)
{
    const float *e = mesh->radiance + 3 * t;
    float length;
    for (int k = 0; k < 3; k++)
        corner[k] = mesh->positions + 3 * (size_t)mesh->lit[3 * t + (size_t)k];
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        normal[k] = (corner[1][i] - corner[0][i]) * (corner[2][j] - corner[0][j]) -
                    (corner[1][j] - corner[0][j]) * (corner[2][i] - corner[0][i]);
    }
    length = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int k = 0; k < 3; k++)
        normal[k] /= length > 0 ? length : 1;
    return e[0] > 0 || e[1] > 0 || e[2] > 0 ? length : 0;
}

/* count places, each for the same area of what shines, in the order of its triangles; as far above them as 1e-4 of the
   mesh's size, so that they do not hide themselves. */
static int place_on_emissive(bk_domain *d, const bk_mesh *mesh, size_t count, char *error)
{
    float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, high[3] = { -HUGE_VALF, -HUGE_VALF, -HUGE_VALF }, size = 0;
    const float *corner[3];
    float normal[3];
    double all = 0, sum = 0;
    if (!mesh->radiance)
        return bk_fail(error, "--domain emissive: nothing shines there", "");
    d->locations = calloc(count, 16);
    if (!d->locations)
        return bk_fail(error, "out of memory", "");
    for (size_t i = 0; i < 3 * mesh->vertices; i++) {
        low[i % 3] = fminf(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], mesh->positions[i]);
    }
    for (int k = 0; k < 3; k++)
        size += 0.25f * (high[k] - low[k]) * (high[k] - low[k]);
    for (size_t t = 0; t < mesh->lit_count; t++)
        all += (double)corners_of(mesh, t, corner, normal);
    for (size_t t = 0; t < mesh->lit_count && d->count < count; t++) {
        const double area = (double)corners_of(mesh, t, corner, normal);
        for (; d->count < count && ((double)d->count + 0.5) / (double)count * all < sum + area; d->count++) {
            const double n = (double)d->count, a = 1 - sqrt(fmod(0.5 + 0.7548776662466927 * n, 1));
            const double b = (1 - a) * fmod(0.5 + 0.5698402909980532 * n, 1);
            float *to = d->locations + 4 * d->count;
            for (int k = 0; k < 3; k++)
                to[k] = (float)((double)corner[0][k] + a * (double)(corner[1][k] - corner[0][k]) +
                                b * (double)(corner[2][k] - corner[0][k])) + 1e-4f * sqrtf(size) * normal[k];
            to[3] = 1;
        }
        sum += area;
    }
    return d->count == count ? 0 : bk_fail(error, "--domain emissive: nothing shines there", "");
}

void bk_domain_sides(const bk_domain *d, const rd_settings *settings, uint32_t side[3])
{
    static const char *const keys[3] = { "side", "side_v", "side_w" };
    for (int k = 0; k < 3; k++) {
        const int own = rd_setting_integer(settings, keys[k]);
        side[k] = k < domains[d->number].sides ? (uint32_t)(own ? own : rd_setting_integer(settings, "side")) : 1;
    }
    if (domains[d->number].kind == COHSM_DOMAIN_TABLE)       /* those that are not given are 1 there */
        for (int k = 1; k < 3; k++)
            side[k] = rd_setting_integer(settings, keys[k]) ? side[k] : 1;
}

int bk_domain_load(bk_domain *d, const bk_mesh *mesh, const rd_settings *settings, char *error)
{
    const double side = rd_setting_number(settings, "side");
    if (domains[d->number].file)
        return read_locations(d, error);
    return d->number == EMISSIVE ? place_on_emissive(d, mesh, (size_t)(side * side), error) : 0;
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
