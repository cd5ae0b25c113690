/* envsh_builder - libFuzzer target: bytes choose a desc, a map, a video of it and a mesh; lights must be finite and
   hold the map's energy, shading must be finite and not brighter than all lights together. */

#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"
#include "unit/envsh_util.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct input { const uint8_t *data; size_t size, at; } input;

static uint32_t take(input *in) { return in->at < in->size ? in->data[in->at++] : 0u; }

/* Mostly in -1..1, seldom any bits at all. */
static float take_float(input *in)
{
    uint32_t a = take(in), b = take(in);
    if (a == 255) {
        uint32_t bits = b << 24 | take(in) << 16 | take(in) << 8 | take(in);
        float f;
        memcpy(&f, &bits, sizeof f);
        return f;
    }
    return (float)((int)(a << 8 | b) - 32640) / 32640.0f;
}

static void take_map(input *in, sky *s)
{
    uint32_t kind = take(in);
    for (size_t t = 0; t < 3 * s->texels; t++) {
        float f = take_float(in);
        s->rgb[t] = kind & 1 ? f : f * f * (float)(take(in) & 1 ? 1 : 1000);
    }
}

static void check_lights(const envsh_lights *l, const sky *s, int hemisphere)
{
    uint32_t count;
    const envsh_light *list = envsh_lights_get(l, &count);
    size_t texels;
    const uint32_t *strata = envsh_lights_strata(l, &texels);
    double sum = 0, exact = 0, omega = 0;
    if (texels != s->texels) abort();
    for (uint32_t i = 0; i < count; i++) {
        if (!envsh__light_finite(&list[i])) abort();
        sum += (double)list[i].irradiance[0];
        omega += (double)list[i].solid_angle;
    }
    for (size_t t = 0; t < texels; t++) {
        double d[3], o;
        float f = s->rgb[3 * t];
        if (strata[t] != ENVSH_NO_LIGHT && strata[t] >= count) abort();
        sky_texel(s, t, d, &o);
        if (f > 0 && f <= 1e30f) exact += o * (double)f;
    }
    if (!hemisphere && fabs(sum - exact) > 1e-5 * exact + 1e-37) abort();      /* denormal floats round */
    if (count && fabs(omega - (hemisphere ? 2 : 4) * PI) > 1e-4) abort();
}

static void shade(input *in, const envsh_lights *l)
{
    float p[3 * 30], points[3 * 8], normals[3 * 8], out[3 * 8], most = 0;
    uint32_t indices[30], count;
    const envsh_light *list = envsh_lights_get(l, &count);
    envsh_light moved[64];
    envsh_maps_desc d;
    envsh_query q = envsh_query_default();
    envsh_mesh mesh = { p, 30, 0, indices, 30 };
    envsh_maps *maps;
    uint64_t seed = take(in);
    memset(&d, 0, sizeof d);
    d.map_size = 16 + take(in) % 20;
    d.rgba = (int)(take(in) & 1);
    d.max_side = d.map_size + take(in);
    for (int i = 0; i < 90; i++) p[i] = take_float(in);
    for (int i = 0; i < 30; i++) indices[i] = take(in) % 31;
    if (envsh_lights_jitter(l, take(in), 1, moved) == ENVSH_OK) list = moved;
    for (uint32_t i = 0; i < count; i++) most += list[i].irradiance[1];
    for (int i = 0; i < 24; i++) points[i] = take_float(in);
    for (size_t i = 0; i < 8; i++) {
        double n[3];
        rnd_direction(&seed, n);
        for (size_t c = 0; c < 3; c++) normals[3 * i + c] = (float)n[c];
    }
    q.points = points;
    q.normals = normals;
    q.count = 8;
    q.filter = (envsh_filter)(take(in) % (ENVSH_FILTER_COUNT + 1));
    q.taps = take(in) % 70;
    q.radius = 8 * take_float(in);
    q.bias = take_float(in);
    q.extent_scale = take_float(in);
    if (envsh_maps_create(&d, 1 + take(in) % 64, &maps) != ENVSH_OK) return;
    if (envsh_maps_begin(maps, list, count, envsh_bounds_of(&mesh, 1, NULL)) == ENVSH_OK) {
        envsh_maps_draw(maps, &mesh, NULL);
        envsh_maps_end(maps);
        if (envsh_shade(maps, &q, out) == ENVSH_OK)
            for (int i = 0; i < 24; i++)
                if (!envsh__finite(out[i]) || out[i] < 0 || (i % 3 == 1 && out[i] > 1.001f * most)) abort();
    }
    envsh_maps_free(maps);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    envsh_desc d;
    envsh_lights *l;
    uint32_t cube, frames;
    sky s;

    in.data = data;
    in.size = size;
    in.at = 0;
    cube = take(&in) & 1;
    s = sky_alloc(cube ? ENVSH_MAP_CUBE : ENVSH_MAP_LATLONG, 1 + take(&in) % 12, 1);
    if (!cube) {
        uint32_t wide = s.map.width;
        sky_free(&s);
        s = sky_alloc(ENVSH_MAP_LATLONG, wide, 1 + take(&in) % 12);
    } else {
        uint32_t side = 1 + s.map.width % 6;
        sky_free(&s);
        s = sky_alloc(ENVSH_MAP_CUBE, side, side);
    }
    d = desc_of((envsh_method)(take(&in) % (ENVSH_METHOD_COUNT + 1)), take(&in) % 65);
    d.hemisphere = (int)(take(&in) & 1);
    d.split_sun = (int)(take(&in) & 1);
    if (!d.light_count) d.light_count = 1;
    take_map(&in, &s);
    if (envsh_lights_build(&d, &s.map, &l, NULL) == ENVSH_OK) {
        check_lights(l, &s, d.hemisphere);
        shade(&in, l);
        for (frames = take(&in) % 4; frames > 0; frames--) {
            take_map(&in, &s);
            if (envsh_lights_follow(l, &s.map, take(&in) % 65, NULL) == ENVSH_OK) check_lights(l, &s, d.hemisphere);
        }
        envsh_lights_free(l);
    }
    sky_free(&s);
    return 0;
}
