/* args.c - see args.h */
#include "args.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static int fail(char *error, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(error, EX_ERROR_SIZE, format, list);
    va_end(list);
    return -1;
}

/* ---- numbers ---- */

/* "1,2,3" as up to `room` finite numbers; -1: not such a list. */
static int parse_list(const char *text, double *out, int room)
{
    int count = 0;
    for (;;) {
        char item[64];
        size_t length = strcspn(text, ",");
        if (count == room || length >= sizeof item)
            return -1;
        memcpy(item, text, length);
        item[length] = 0;
        if (rd_parse_number(item, &out[count++]) != 0)
            return -1;
        text += length;
        if (!*text++)
            return count;
    }
}

/* Whether all numbers of a list are small enough for what floats make of them: areas, squares of distances. */
static int are_moderate(const double *numbers, int count)
{
    while (count > 0 && fabs(numbers[count - 1]) <= 1e9)
        count--;
    return count == 0;
}

/* Decimal digits only. */
static int parse_count(const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
    uint64_t value = 0;
    if (!*text || strlen(text) > 18 || text[strspn(text, "0123456789")])
        return -1;
    for (; *text; text++)
        value = 10 * value + (uint64_t)(*text - '0');
    *out = value;
    return value < low || value > high ? -1 : 0;
}

/* ---- lights ---- */

static void copy3(float *to, const double *from)
{
    for (int k = 0; k < 3; k++)
        to[k] = (float)from[k];
}

static double length3(const double *a)
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

static int copy_unit(float *to, const double *from)
{
    double length = length3(from);
    for (int k = 0; k < 3; k++)
        to[k] = (float)(from[k] / length);
    return length > 0 ? 0 : -1;
}

/* How each kind is written; `numbers` are those before the optional value of one or three. */
static const struct { const char *name, *form; int numbers; ex_light_kind kind; } kinds[] = {
    { "sun", "sun:dx,dy,dz[,E]", 3, EX_LIGHT_SUN },
    { "spot", "spot:px,py,pz,dx,dy,dz,degrees[,I]", 7, EX_LIGHT_SPOT },
    { "point", "point:px,py,pz[,I]", 3, EX_LIGHT_POINT },
    { "sphere", "sphere:px,py,pz,radius[,L]", 4, EX_LIGHT_SPHERE },
    { "rect", "rect:px,py,pz,ux,uy,uz,vx,vy,vz[,L]", 9, EX_LIGHT_RECT },
    { "disc", "disc:px,py,pz,nx,ny,nz,radius[,L]", 7, EX_LIGHT_DISC },
    { "line", "line:px,py,pz,qx,qy,qz,radius[,L]", 7, EX_LIGHT_LINE },
};

/* Shape from the numbers of its kind; returns what is wrong with them, or NULL. */
static const char *set_shape(ex_light *light, const double *n)
{
    const double pi = 3.14159265358979323846;
    double axis[3];
    switch (light->kind) {
    case EX_LIGHT_SUN:
        return copy_unit(light->direction, n) ? "the direction is zero" : NULL;
    case EX_LIGHT_SPOT:
        copy3(light->position, n);
        light->cos_half_angle = (float)cos(n[6] / 360 * pi);
        if (!(n[6] > 0 && n[6] <= 360))
            return "the apex angle must be above 0 and at most 360 degrees";
        return copy_unit(light->direction, n + 3) ? "the direction is zero" : NULL;
    case EX_LIGHT_POINT:
        copy3(light->position, n);
        return NULL;
    case EX_LIGHT_SPHERE:
        copy3(light->position, n);
        light->radius = (float)n[3];
        return light->radius > 0 ? NULL : "the radius must be positive";
    case EX_LIGHT_RECT:
        copy3(light->position, n);
        copy3(light->u, n + 3);
        copy3(light->v, n + 6);
        axis[0] = n[4] * n[8] - n[5] * n[7];
        axis[1] = n[5] * n[6] - n[3] * n[8];
        axis[2] = n[3] * n[7] - n[4] * n[6];
        return copy_unit(light->direction, axis) ? "the rectangle has no area" : NULL;
    case EX_LIGHT_DISC:
        copy3(light->position, n);
        light->radius = (float)n[6];
        if (copy_unit(light->direction, n + 3))
            return "the normal is zero";
        return light->radius > 0 ? NULL : "the radius must be positive";
    case EX_LIGHT_LINE:
        copy3(light->position, n);
        light->radius = (float)n[6];
        for (int k = 0; k < 3; k++)
            axis[k] = n[3 + k] - n[k];
        copy3(light->u, axis);
        if (!(length3(axis) > 0))
            return "the line has no length";
        return light->radius > 0 ? NULL : "the radius must be positive";
    }
    return "unknown kind";
}

static float default_value(ex_light_kind kind)
{
    return kind == EX_LIGHT_SUN ? 3.14159265f : 1.0f;
}

int rd_light_parse(rd_light_arg *out, const char *text, char *error)
{
    const size_t kind_count = sizeof kinds / sizeof kinds[0];
    const char *colon = strchr(text, ':'), *problem;
    size_t i = 0;
    double n[16];
    int count, extra;
    memset(out, 0, sizeof *out);
    while (i < kind_count && !(colon && strlen(kinds[i].name) == (size_t)(colon - text) &&
                               memcmp(kinds[i].name, text, (size_t)(colon - text)) == 0))
        i++;
    if (i == kind_count)
        return fail(error, "--light %.80s: not one of sun, spot, point, sphere, rect, disc, line", text);
    count = parse_list(colon + 1, n, 16);
    extra = count - kinds[i].numbers;
    if (count < 0 || (extra != 0 && extra != 1 && extra != 3))
        return fail(error, "--light %.80s: expected %s", text, kinds[i].form);
    if (!are_moderate(n, kinds[i].numbers))
        return fail(error, "--light %.80s: its numbers must be -1e9 to 1e9", text);
    out->light.kind = kinds[i].kind;
    problem = set_shape(&out->light, n);
    if (problem)
        return fail(error, "--light %.80s: %s", text, problem);
    out->has_value = extra > 0 || (kinds[i].kind != EX_LIGHT_SPOT && kinds[i].kind != EX_LIGHT_POINT);
    for (int k = 0; k < 3; k++) {
        const double *given = n + kinds[i].numbers + (extra == 3 ? k : 0);
        if (extra && !(*given >= 0 && *given <= 1e12))      /* what comes of it must stay a float */
            return fail(error, "--light %.80s: the value must be 0 to 1e12, not negative", text);
        out->light.value[k] = extra ? (float)*given : default_value(out->light.kind);
    }
    return 0;
}

/* ---- options ---- */

static int set_technique(rd_args *args, const char *value, char *error)
{
    args->technique = rd_technique_find(value);
    return args->technique ? 0 : fail(error, "--technique %.40s: unknown (see render --list)", value);
}

static int set_backend(rd_args *args, const char *value, char *error)
{
    args->use_gl = strcmp(value, "gl") == 0;
    return args->use_gl || strcmp(value, "cpu") == 0 ? 0 : fail(error, "--backend %.40s: must be cpu or gl", value);
}

static int has_suffix(const char *text, const char *suffix)
{
    size_t a = strlen(text), b = strlen(suffix);
    return a > b && strcmp(text + a - b, suffix) == 0;
}

static int is_in(const char *const *names, const char *name)
{
    while (*names && strcmp(*names, name) != 0)
        names++;
    return *names != NULL;
}

static int set_scene(rd_args *args, const char *value, char *error)
{
    args->scene = value;
    if (strncmp(value, "builtin:", 8) == 0)
        return is_in(ex_scene_names(), value + 8) ? 0
                   : fail(error, "--scene %.80s: unknown (see render --list)", value);
    if (has_suffix(value, ".glb") || has_suffix(value, ".gltf"))
        return 0;
    return fail(error, "--scene %.80s: must be builtin:NAME, FILE.glb or FILE.gltf", value);
}

/* FILE or FILE@x,y,z; the last @ counts, unless the value ends as a file: folders may have an @ in their names. */
static int set_figure(rd_args *args, const char *value, char *error)
{
    const char *at = has_suffix(value, ".glb") || has_suffix(value, ".gltf") ? NULL : strrchr(value, '@');
    double n[3] = { 0, 0, 0 };
    size_t length = at ? (size_t)(at - value) : strlen(value);
    if (at && (parse_list(at + 1, n, 3) != 3 || !are_moderate(n, 3)))
        return fail(error, "--figure %.80s: behind @ three numbers are expected, -1e9 to 1e9", value);
    if (length >= sizeof args->figure)
        return fail(error, "--figure %.80s: the name is too long", value);
    memcpy(args->figure, value, length);
    args->figure[length] = 0;
    copy3(args->figure_at, n);
    if (has_suffix(args->figure, ".glb") || has_suffix(args->figure, ".gltf"))
        return 0;
    return fail(error, "--figure %.80s: must be FILE.glb or FILE.gltf, and may have @x,y,z behind it", value);
}

static int set_env(rd_args *args, const char *value, char *error)
{
    args->env = value;
    if (strncmp(value, "builtin:", 8) == 0)
        return is_in(ex_sky_names(), value + 8) ? 0 : fail(error, "--env %.80s: unknown (see render --list)", value);
    return has_suffix(value, ".hdr") ? 0 : fail(error, "--env %.80s: must be builtin:NAME or FILE.hdr", value);
}

static int set_light(rd_args *args, const char *value, char *error)
{
    rd_light_arg *grown = realloc(args->lights, (args->light_count + (size_t)1) * sizeof *grown);
    if (!grown)
        return fail(error, "out of memory");
    args->lights = grown;
    return rd_light_parse(&args->lights[args->light_count++], value, error);
}

static int set_baked(rd_args *args, const char *value, char *error)
{
    if (args->baked_count == RD_MOST_BAKED)
        return fail(error, "--baked %.80s: too many files", value);
    args->baked[args->baked_count++] = value;
    return 0;
}

static int set_camera(rd_args *args, const char *value, char *error)
{
    ex_camera *camera = &args->camera;
    double n[7], view[3], length;
    if (parse_list(value, n, 7) != 7)
        return fail(error, "--camera %.80s: expected px,py,pz,tx,ty,tz,fovy_degrees", value);
    if (!are_moderate(n, 6))
        return fail(error, "--camera %.80s: its numbers must be -1e9 to 1e9", value);
    for (int k = 0; k < 3; k++)
        view[k] = n[3 + k] - n[k];
    length = length3(view);
    if (!(length > 0))
        return fail(error, "--camera %.80s: position and target are the same", value);
    if (!(n[6] > 0 && n[6] < 180))
        return fail(error, "--camera %.80s: fovy must lie between 0 and 180 degrees", value);
    copy3(camera->eye, n);
    copy3(camera->target, n + 3);
    camera->fovy = (float)(n[6] / 180 * 3.14159265358979323846);
    memset(camera->up, 0, sizeof camera->up);
    if (fabs(view[1]) < 0.9999 * length)
        camera->up[1] = 1;
    else
        camera->up[2] = view[1] < 0 ? -1.0f : 1.0f;        /* straight down: -Z is up, as on a map */
    args->has_camera = 1;
    return 0;
}

static int set_size(rd_args *args, const char *value, char *error)
{
    char text[24];
    char *x;
    uint64_t width, height;
    snprintf(text, sizeof text, "%s", value);
    x = strchr(text, 'x');
    if (x)
        *x = 0;
    if (!x || strlen(value) >= sizeof text || parse_count(text, 1, 16384, &width) ||
        parse_count(x + 1, 1, 16384, &height))
        return fail(error, "--size %.40s: expected WIDTHxHEIGHT, each from 1 to 16384", value);
    args->width = (uint32_t)width;
    args->height = (uint32_t)height;
    return 0;
}

static int set_number(const char *option, const char *value, uint64_t low, uint64_t high, uint64_t *out, char *error)
{
    if (parse_count(value, low, high, out) == 0)
        return 0;
    return fail(error, "%s %.40s: must be an integer from %llu to %llu", option, value, (unsigned long long)low,
                (unsigned long long)high);
}

static int set_frames(rd_args *args, const char *value, char *error)
{
    uint64_t n = 1;
    int result = set_number("--frames", value, 1, 1000000, &n, error);
    args->frames = (uint32_t)n;
    return result;
}

static int set_time(rd_args *args, const char *value, char *error)
{
    double time = 0;
    if (rd_parse_number(value, &time) != 0 || !(time >= 0 && time <= 3600))
        return fail(error, "--time %.40s: must be a number of seconds from 0 to 3600", value);
    args->time = (float)time;
    return 0;
}

static int set_seed(rd_args *args, const char *value, char *error)
{
    uint64_t n = 0;
    int result = set_number("--seed", value, 0, UINT32_MAX, &n, error);
    args->seed = (uint32_t)n;
    return result;
}

static int set_threads(rd_args *args, const char *value, char *error)
{
    uint64_t n = 0;
    int result = set_number("--threads", value, 0, 256, &n, error);
    args->threads = (int)n;
    return result;
}

static int set_limit_memory(rd_args *args, const char *value, char *error)
{
    uint64_t n = 0;
    int result = set_number("--limit-memory", value, 1, 1000000, &n, error);
    (void)args;
    ex_memory_limit = (size_t)n * 1000000;
    return result;
}

static int set_out(rd_args *args, const char *value, char *error)
{
    args->out = value;
    return has_suffix(value, ".png") || has_suffix(value, ".pfm") ? 0
               : fail(error, "--out %.80s: must end in .png or .pfm", value);
}

static int set_kept(rd_args *args, const char *value, char *error)
{
    args->kept = value;
    return *value ? 0 : fail(error, "--kept: the name is empty");
}

static int set_json(rd_args *args, const char *value, char *error)
{
    args->json = value;
    return *value ? 0 : fail(error, "--json: the name is empty");
}

/* --samples and --set depend on the technique, which may stand behind them: they are read in a second pass. */
static int keep_for_later(rd_args *args, const char *value, char *error)
{
    (void)args, (void)value, (void)error;
    return 0;
}

static const struct { const char *name; int (*set)(rd_args *args, const char *value, char *error); } options[] = {
    { "--technique", set_technique }, { "--backend", set_backend }, { "--scene", set_scene }, { "--env", set_env },
    { "--figure", set_figure },
    { "--light", set_light }, { "--baked", set_baked }, { "--camera", set_camera }, { "--size", set_size },
    { "--samples", keep_for_later }, { "--frames", set_frames }, { "--time", set_time }, { "--seed", set_seed },
    { "--threads", set_threads },
    { "--set", keep_for_later }, { "--out", set_out }, { "--json", set_json }, { "--kept", set_kept },
    { "--limit-memory", set_limit_memory },
};

static int apply(rd_args *args, const char *option, const char *value, char *error)
{
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        if (strcmp(option, options[i].name) == 0)
            return value ? options[i].set(args, value, error) : fail(error, "%s: its value is missing", option);
    return fail(error, "%.80s: unknown option (see render --help)", option);
}

/* What depends on the technique. One that this build lacks has no table of keys to check against. */
static int apply_technique(rd_args *args, int count, char **values, char *error)
{
    const rd_technique *technique = args->technique;
    args->settings.common = rd_common_keys;
    args->settings.listed = "render --list";
    args->settings.own = technique->keys;
    args->samples = technique->samples;
    if (technique->missing)
        return 0;
    if (args->baked_count && !technique->accepts_baked)
        return fail(error, "--baked: %s reads no baked file", technique->name);
    for (int i = 1; i + 1 < count; i += 2) {
        uint64_t samples = 0;
        if (strcmp(values[i], "--set") == 0 && rd_settings_add(&args->settings, values[i + 1], error) != 0)
            return -1;
        if (strcmp(values[i], "--samples") != 0)
            continue;
        if (!technique->most_samples)
            return fail(error, "--samples: %s takes none", technique->name);
        if (set_number("--samples", values[i + 1], technique->least_samples, technique->most_samples, &samples, error))
            return -1;
        args->samples = (uint32_t)samples;
    }
    return 0;
}

int rd_args_parse(rd_args *args, int count, char **values, char *error)
{
    memset(args, 0, sizeof *args);
    if (count > 1 && strcmp(values[count - 1], "--hash") == 0) {    /* the one option without a value stands last */
        args->hash = 1;
        count--;
    }
    args->width = 640;
    args->height = 360;
    args->frames = 1;
    for (int i = 1; i < count; i += 2)
        if (apply(args, values[i], i + 1 < count ? values[i + 1] : NULL, error) != 0)
            return -1;
    if (!args->technique)
        return fail(error, "--technique is missing (see render --help)");
    if (!args->scene)
        return fail(error, "--scene is missing (see render --help)");
    if (!args->out && !args->hash)
        return fail(error, "--out is missing (see render --help)");
    if (args->kept && strcmp(args->technique->name, "reference") != 0)
        return fail(error, "--kept: pictures are kept of technique reference alone");
    return apply_technique(args, count, values, error);
}

void rd_args_free(rd_args *args)
{
    free(args->lights);
    args->lights = NULL;
    args->light_count = 0;
}
