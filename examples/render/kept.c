/* kept.c - see kept.h */
#include "kept.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the hash: FNV-1a of a text ---- */

static uint64_t add_text(uint64_t hash, const char *text)
{
    do
        hash = (hash ^ (unsigned char)*text) * 1099511628211u;
    while (*text++);
    return hash;
}

static uint64_t add_integer(uint64_t hash, long long value)
{
    char text[32];
    snprintf(text, sizeof text, "%lld", value);
    return add_text(hash, text);
}

/* In thousandths of `whole`: what is nothing but rounding is 0. */
static uint64_t add_shares(uint64_t hash, const double *values, size_t count, double whole)
{
    for (size_t i = 0; i < count; i++) {
        double share = whole > 0 ? 1000 * values[i] / whole : 0;
        hash = add_integer(hash, fabs(share) < 1e15 ? (long long)floor(share + 0.5) : 0);
    }
    return hash;
}

static uint64_t add_size(uint64_t hash, double value)      /* by three digits */
{
    char text[40];
    snprintf(text, sizeof text, "%.2e", value);
    return add_text(hash, text);
}

static uint64_t add_floats(uint64_t hash, const float *values, size_t count, double whole)
{
    for (size_t i = 0; i < count; i++) {
        double value = (double)values[i];
        hash = add_shares(hash, &value, 1, whole);
    }
    return hash;
}

static uint64_t add_color(uint64_t hash, const float color[3])
{
    double most = fmax(fmax((double)color[0], (double)color[1]), (double)color[2]);
    return add_floats(add_size(hash, most), color, 3, most);
}

/* Sums over a scene's triangles, each weighted by its area. */
typedef struct sums {
    double area, places[3], squares[3], normals[3], colors[3], emissions[3], gloss[3];
    double radius;
} sums;

static void add_triangle(sums *s, double corners[3][3], const ex_material *m)
{
    double a[3], b[3], n[3], area;
    for (int k = 0; k < 3; k++) {
        a[k] = corners[1][k] - corners[0][k];
        b[k] = corners[2][k] - corners[0][k];
    }
    for (int k = 0; k < 3; k++)
        n[k] = 0.5 * (a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
    area = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    s->area += area;
    for (int k = 0; k < 3; k++) {
        double middle = (corners[0][k] + corners[1][k] + corners[2][k]) / 3;
        s->places[k] += area * middle;
        s->squares[k] += area * middle * middle;
        s->normals[k] += n[k] * (middle + s->radius);      /* n alone adds up to 0 on what is closed */
        s->colors[k] += area * (double)m->base_color[k];
        s->emissions[k] += area * (double)m->emission[k];
    }
    s->gloss[0] += area * (double)m->roughness;
    s->gloss[1] += area * (double)m->metallic;
    s->gloss[2] += area * (double)m->alpha_cutoff;
}

static void add_object(sums *s, const ex_scene *scene, const ex_object *object)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    const float *to = object->transform;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        double corners[3][3];
        for (size_t c = 0; c < 3; c++) {
            const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)t + c];
            for (int k = 0; k < 3; k++)
                corners[c][k] = (double)to[k] * (double)p[0] + (double)to[4 + k] * (double)p[1] +
                                (double)to[8 + k] * (double)p[2] + (double)to[12 + k];
        }
        add_triangle(s, corners, &scene->materials[ex_object_material(scene, object, t)]);
    }
}

static uint64_t add_triangles(uint64_t hash, const ex_scene *scene, double radius)
{
    double emission = 0;
    sums s;
    memset(&s, 0, sizeof s);
    s.radius = radius;
    hash = add_integer(hash, (long long)ex_scene_triangles(scene));
    for (uint32_t i = 0; i < scene->object_count; i++)
        add_object(&s, scene, &scene->objects[i]);
    for (int k = 0; k < 3; k++)
        emission += s.emissions[k];
    hash = add_size(add_size(hash, s.area), emission);
    hash = add_shares(hash, s.places, 3, s.area * radius);
    hash = add_shares(hash, s.squares, 3, s.area * radius * radius);
    hash = add_shares(hash, s.normals, 3, s.area * radius);
    hash = add_shares(hash, s.colors, 3, s.area);
    hash = add_shares(hash, s.emissions, 3, emission);
    hash = add_shares(hash, s.gloss, 3, s.area);
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        const ex_texture *texture = &scene->textures[i];
        size_t texels = (size_t)texture->width * texture->height;
        double means[4] = { 0, 0, 0, 0 };
        for (size_t j = 0; j < 4 * texels; j++)
            means[j % 4] += texture->rgba[j];
        hash = add_integer(add_integer(hash, texture->width), texture->height);
        hash = add_shares(hash, means, 4, 255.0 * (double)texels);
    }
    return hash;
}

static uint64_t add_lights(uint64_t hash, const ex_scene *scene, double radius)
{
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const ex_light *light = &scene->lights[i];
        hash = add_integer(hash, light->kind);
        hash = add_floats(hash, light->position, 3, radius);
        hash = add_floats(hash, light->direction, 3, 1);
        hash = add_floats(hash, light->u, 3, radius);
        hash = add_floats(hash, light->v, 3, radius);
        hash = add_floats(hash, &light->radius, 1, radius);
        hash = add_floats(hash, &light->cos_half_angle, 1, 1);
        hash = add_color(hash, light->value);
    }
    return hash;
}

/* In 8 x 16 blocks, of each the share of the sum. */
static uint64_t add_sky(uint64_t hash, const ex_sky *sky)
{
    double blocks[3 * 8 * 16] = { 0 }, sum = 0;
    for (size_t y = 0; y < sky->height; y++)
        for (size_t x = 0; x < sky->width; x++)
            for (size_t k = 0; k < 3; k++) {
                double value = (double)sky->rgb[3 * (y * sky->width + x) + k];
                blocks[3 * (y * 8 / sky->height * 16 + x * 16 / sky->width) + k] += value;
                sum += value;
            }
    hash = add_size(add_integer(add_integer(hash, sky->width), sky->height), sum);
    return add_shares(add_floats(hash, &sky->rotation, 1, 1), blocks, sizeof blocks / sizeof *blocks, sum);
}

static uint64_t add_settings(uint64_t hash, const rd_settings *settings)
{
    static const char *const unseen[] = { "ev", "compute", "warm_up" };
    const rd_key *const tables[] = { settings->common, settings->own };
    for (size_t i = 0; i < 2; i++)
        for (const rd_key *key = tables[i]; key && key->name; key++) {
            size_t j = 0;
            while (j < sizeof unseen / sizeof *unseen && strcmp(unseen[j], key->name) != 0)
                j++;
            if (j == sizeof unseen / sizeof *unseen)
                hash = add_text(add_text(hash, key->name), rd_setting_text(settings, key->name));
        }
    return hash;
}

uint64_t rd_picture_hash(const rd_args *args, const rd_job *job)
{
    const ex_scene *scene = job->scene;
    const ex_camera *camera = &scene->camera;
    double radius = (double)job->radius;
    uint64_t hash = add_text(14695981039346656037u, args->technique->name);
    hash = add_integer(add_integer(hash, args->width), args->height);
    hash = add_settings(hash, &args->settings);
    hash = add_triangles(hash, scene, radius);
    hash = add_lights(hash, scene, radius);
    hash = add_sky(hash, &scene->sky);
    hash = add_floats(add_floats(hash, camera->eye, 3, radius), camera->target, 3, radius);
    return add_floats(add_floats(hash, camera->up, 3, 1), &camera->fovy, 1, 1);
}

/* ---- the folder ---- */

#if defined DAPPLE_HAVE_STB && DAPPLE_HAVE_STB
/* Whether a line of the list is of this hash; then name and figures are its own. */
static int is_line_of(const char *line, uint64_t hash, char name[64], rd_kept *kept)
{
    uint64_t own = 0;
    return sscanf(line, "%16" SCNx64 "\t%63[a-z0-9_-]\t%" SCNu64 "\t%lf\t%lf", &own, name, &kept->samples, &kept->noise,
                  &kept->milliseconds) == 5 && own == hash;
}

int rd_kept_read(rd_kept *kept, const char *folder, uint64_t hash, uint32_t width, uint32_t height, char *error)
{
    char path[512], line[1024], name[64] = "";
    int found = 0;
    FILE *file;
    memset(kept, 0, sizeof *kept);
    snprintf(path, sizeof path, "%.400s/list.tsv", folder);
    file = fopen(path, "r");
    if (!file) {
        snprintf(error, EX_ERROR_SIZE, "--kept: %.200s: cannot open", path);
        return -1;
    }
    while (!found && fgets(line, sizeof line, file))
        found = is_line_of(line, hash, name, kept);
    fclose(file);
    if (!found)
        return 0;
    snprintf(path, sizeof path, "%.400s/%s.half.png", folder, name);
    if (ex_image_read_half(&kept->picture, path, error) != 0)
        return -1;
    if (kept->picture.width == width && kept->picture.height == height)
        return 0;
    ex_image_free(&kept->picture);
    snprintf(error, EX_ERROR_SIZE, "--kept: %.160s: has not the %u x %u pixels of its hash", path, (unsigned)width,
             (unsigned)height);
    return -1;
}
#else
int rd_kept_read(rd_kept *kept, const char *folder, uint64_t hash, uint32_t width, uint32_t height, char *error)
{
    (void)folder, (void)hash, (void)width, (void)height, (void)error;
    memset(kept, 0, sizeof *kept);
    return 0;
}
#endif
