/* sky.c - latitude-longitude radiance maps: built by code, loaded from .hdr, looked up.
   Row 0 is +Y, v = acos(y) / pi, u = 0.5 + atan2(z, x) / (2 pi): the centre of the picture looks along +X. A rotation
   turns the map about +Y by the right-hand rule, so that a lookup turns the direction back. */
#include "internal.h"
#include <stdlib.h>
#include <string.h>

enum { SKY_WIDTH = 512, SKY_HEIGHT = 256 };

typedef v3 (*sky_fn)(v3 direction);

static v3 mix3(v3 a, v3 b, float t) { return v3_add(v3_scale(a, 1 - t), v3_scale(b, t)); }

/* What a diffuse ground below shows: constant, meeting the sky over two degrees. */
static v3 with_ground(v3 sky, v3 ground, float y) { return mix3(ground, sky, ex_smooth(-0.035f, 0, y)); }

/* A clear day: about 1 W/m^2 of sky on the ground and, facing it, 3 W/m^2 from the sun, whose disc is softened to some
   5 degrees across so that maps of moderate resolution sample it well. */
static v3 clear_sky(v3 d)
{
    const v3 sun = {-0.5868f, 0.6428f, 0.4924f};            /* azimuth -50 degrees from +Z towards +X, elevation 40 */
    float up = d.y > 0 ? d.y : 0, cosine = ex_clamp(v3_dot(d, sun), -1, 1), angle = acosf(cosine) * 180 / EX_PI;
    v3 zenith = v3_make(0.15f, 0.22f, 0.35f), horizon = v3_make(0.48f, 0.53f, 0.57f);
    v3 sky = mix3(horizon, zenith, powf(up, 0.45f));
    sky = v3_mad(sky, v3_make(1.0f, 0.85f, 0.62f), 0.4f * expf(-angle / 12));           /* haze round the sun */
    sky = with_ground(sky, v3_make(0.20f, 0.18f, 0.15f), d.y);
    return v3_mad(sky, v3_make(1.0f, 0.93f, 0.80f), 400 * (1 - ex_smooth(1.5f, 4, angle)));
}

/* CIE standard overcast sky, zenith radiance 1: irradiance 7 pi / 9 on the ground, which has albedo 0.2. */
static v3 overcast_sky(v3 d)
{
    float sky = (1 + 2 * (d.y > 0 ? d.y : 0)) / 3, ground = 0.2f * 7 / 9;
    return d.y >= 0 ? v3_make(sky, sky, sky) : v3_make(ground, ground, ground);
}

typedef struct soft_box { float azimuth, elevation, half_width, half_height; v3 radiance; } soft_box;

/* A dark room with a warm key light, a cool fill, an overhead panel and a narrow strip behind. Degrees; azimuth from
   +Z towards +X as for the default camera at 30. */
static v3 studio_sky(v3 d)
{
    static const soft_box boxes[] = {
        {-25, 38, 17, 15, {9.0f, 8.0f, 6.6f}},
        {100, 22, 22, 20, {1.5f, 1.8f, 2.3f}},
        {200, 30, 5, 26, {7.5f, 7.8f, 8.4f}}};
    const float soft = 1.5f;
    float elevation = asinf(ex_clamp(d.y, -1, 1)) * 180 / EX_PI, azimuth = atan2f(d.x, d.z) * 180 / EX_PI;
    float floor_or_wall = 0.02f + 0.03f * ex_smooth(-0.6f, 0.3f, d.y);
    v3 sum = v3_make(floor_or_wall, floor_or_wall, floor_or_wall);
    for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++) {
        const soft_box *b = &boxes[i];
        float across = fabsf(remainderf(azimuth - b->azimuth, 360)), along = fabsf(elevation - b->elevation);
        float inside = (1 - ex_smooth(b->half_width - soft, b->half_width + soft, across)) *
                       (1 - ex_smooth(b->half_height - soft, b->half_height + soft, along));
        sum = v3_mad(sum, b->radiance, inside);
    }
    float overhead = 1 - ex_smooth(17, 20, 90 - elevation);
    return v3_mad(sum, v3_make(4.0f, 4.0f, 4.0f), overhead);
}

static v3 uniform_sky(v3 d)
{
    (void)d;                             /* the same everywhere: that is its use */
    return v3_make(1, 1, 1);
}

static const char *const sky_names[] = {"sky", "overcast", "studio", "uniform", NULL};
static const sky_fn sky_functions[] = {clear_sky, overcast_sky, studio_sky, uniform_sky};

const char *const *ex_sky_names(void) { return sky_names; }

void ex_sky_texel_direction(uint32_t width, uint32_t height, float x, float y, float direction[3])
{
    float theta = EX_PI * y / (float)height, phi = 2 * EX_PI * (x / (float)width - 0.5f);
    direction[0] = sinf(theta) * cosf(phi);
    direction[1] = cosf(theta);
    direction[2] = sinf(theta) * sinf(phi);
}

int ex_sky_builtin(ex_sky *sky, const char *name, char *error)
{
    memset(sky, 0, sizeof *sky);
    sky_fn fn = NULL;
    for (int i = 0; sky_names[i]; i++)
        if (strcmp(name, sky_names[i]) == 0) fn = sky_functions[i];
    if (!fn) return ex_fail(error, "no built-in sky is called '%s'", name);
    sky->rgb = (float *)malloc((size_t)3 * SKY_WIDTH * SKY_HEIGHT * sizeof(float));
    if (!sky->rgb) return ex_fail(error, "sky %s: out of memory", name);
    sky->width = SKY_WIDTH;
    sky->height = SKY_HEIGHT;
    for (uint32_t y = 0; y < SKY_HEIGHT; y++)
        for (uint32_t x = 0; x < SKY_WIDTH; x++) {
            float d[3];
            ex_sky_texel_direction(SKY_WIDTH, SKY_HEIGHT, (float)x + 0.5f, (float)y + 0.5f, d);
            v3_store(sky->rgb + 3 * ((size_t)y * SKY_WIDTH + x), fn(v3_load(d)));
        }
    return 0;
}

/* Bad texels of real captures (NaN, infinite, negative) become black; radiance above 1e6 is cut. */
int ex_sky_load(ex_sky *sky, const char *path, char *error)
{
    memset(sky, 0, sizeof *sky);
    if (ex_stb_read_hdr(path, &sky->width, &sky->height, &sky->rgb, error) != 0) {
        memset(sky, 0, sizeof *sky);
        return -1;
    }
    size_t count = 3 * (size_t)sky->width * sky->height;
    for (size_t i = 0; i < count; i++) {
        float value = sky->rgb[i];
        if (!(value >= 0) || !isfinite(value)) value = 0;
        sky->rgb[i] = value < 1e6f ? value : 1e6f;
    }
    return 0;
}

void ex_sky_free(ex_sky *sky)
{
    free(sky->rgb);
    memset(sky, 0, sizeof *sky);
}

void ex_sky_radiance(const ex_sky *sky, const float direction[3], float rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (sky->width == 0 || sky->height == 0) return;
    /* Turning the sky by +a about +Y lowers atan2(z, x) of what it shows by a. */
    float w = (float)sky->width, h = (float)sky->height;
    float u = 0.5f + (atan2f(direction[2], direction[0]) + sky->rotation) / (2 * EX_PI);
    float x = (u - floorf(u)) * w - 0.5f;
    float y = ex_clamp(acosf(ex_clamp(direction[1], -1, 1)) / EX_PI * h - 0.5f, 0, h - 1);
    float x_floor = floorf(x), y_floor = floorf(y), fx = x - x_floor, fy = y - y_floor;
    uint32_t x0 = (uint32_t)((int64_t)x_floor + (int64_t)sky->width) % sky->width, x1 = (x0 + 1) % sky->width;
    uint32_t y0 = (uint32_t)y_floor, y1 = y0 + 1 < sky->height ? y0 + 1 : y0;
    const float *top = sky->rgb + 3 * (size_t)y0 * sky->width, *bottom = sky->rgb + 3 * (size_t)y1 * sky->width;
    for (size_t k = 0; k < 3; k++)
        rgb[k] = ex_mix(ex_mix(top[3 * (size_t)x0 + k], top[3 * (size_t)x1 + k], fx),
                        ex_mix(bottom[3 * (size_t)x0 + k], bottom[3 * (size_t)x1 + k], fx), fy);
}
