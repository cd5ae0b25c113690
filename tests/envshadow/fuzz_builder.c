/* fuzz_builder - libFuzzer target: bytes choose a sky, a mesh and a query; shading must be finite and not brighter than
   all lights together. The last bytes choose odd services (kit/odd.h), by which the same is drawn and shaded. */

#define ENVLT_STATIC
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
#define ENVSH_STATIC
#define ENVSHADOW_IMPLEMENTATION
#include "envshadow.h"
#include "util.h"
#include "input.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void take_map(input *in, sky *s)
{
    uint32_t kind = take(in);
    for (size_t t = 0; t < 3 * s->texels; t++) {
        float f = take_float(in);
        s->rgb[t] = kind & 1 ? f : f * f * (float)(take(in) & 1 ? 1 : 1000);
    }
}

typedef struct asked {          /* what is drawn, and asked of it */
    envsh_maps_desc    maps;
    uint32_t           capacity, count;
    const envlt_light *lights;
    const envsh_mesh  *mesh;
    const envsh_query *query;
    envsh_points       points;
} asked;

/* Draws one frame and shades it; what was cancelled while drawing begins anew. Returns whether `out` was written. */
static int shade_by(odd *o, const asked *a, float *out)
{
    envsh_maps *maps;
    envsh_result result;
    uint32_t before;
    int good = 0;
    ODD_TRY(o, result, envsh_maps_create(&a->maps, a->capacity, &maps));
    odd_keep_result(o, (int)result);
    if (result != ENVSH_OK) return 0;
    do {
        ODD_TRY(o, result, envsh_maps_begin(maps, AS_LIGHTS(a->lights, a->count), envsh_bounds_of(a->mesh, 1, NULL)));
        before = o->failures;
        if (result != ENVSH_OK) break;
        odd_before(o);
        result = envsh_maps_draw(maps, a->mesh, NULL);
        (void)odd_after_any(o, (int)result);
    } while (o->failures > before);
    odd_keep_result(o, (int)result);
    ODD_TRY(o, result, envsh_maps_end(maps));
    odd_keep_result(o, (int)result);
    if (result == ENVSH_OK) {
        ODD_TRY(o, result, envsh_shade(maps, a->query, &a->points, out));
        odd_keep_result(o, (int)result);
        good = result == ENVSH_OK;
        if (good) odd_keep(o, out, 24 * sizeof *out);
    }
    envsh_maps_free(maps);
    return good;
}

static void shade(input *in, const envlt_lights *l, odd *o)
{
    float p[3 * 30], points[3 * 8], normals[3 * 8], out[3 * 8], most = 0;
    uint32_t indices[30], count;
    const envlt_light *list = envlt_get_lights(l, &count);
    envlt_light moved[64];
    envsh_maps_desc d;
    envsh_query q = { 0 };
    envsh_points r = { 0 };
    envsh_mesh mesh = { p, 30, 0, indices, 30, NULL, NULL, NULL };
    uint64_t seed = take(in);
    asked a;
    odd none;
    memset(&d, 0, sizeof d);
    d.map_side = 16 + take(in) % 20;
    d.rgba = (int)(take(in) & 1);
    d.max_side = d.map_side + take(in);
    for (int i = 0; i < 90; i++) p[i] = take_float(in);
    for (int i = 0; i < 30; i++) indices[i] = take(in) % 31;
    if (envlt_jitter(l, take(in), 1, moved) == ENVLT_OK) list = moved;
    for (uint32_t i = 0; i < count; i++) most += list[i].irradiance[1];
    for (int i = 0; i < 24; i++) points[i] = take_float(in);
    for (size_t i = 0; i < 8; i++) {
        double n[3];
        rnd_direction(&seed, n);
        for (size_t c = 0; c < 3; c++) normals[3 * i + c] = (float)n[c];
    }
    r.positions = points;
    r.normals = normals;
    r.count = 8;
    q.filter = (envsh_filter)(take(in) % (ENVSH_FILTER_COUNT + 1));
    q.tap_count = take(in) % 70;
    q.radius = 8 * take_float(in);
    q.bias = take_float(in);
    q.extent_scale = take_float(in);
    a.maps = d;
    a.capacity = 1 + take(in) % 64;
    a.count = count;
    a.lights = list;
    a.mesh = &mesh;
    a.query = &q;
    a.points = r;
    odd_take(&none, NULL, 0);
    if (shade_by(&none, &a, out))
        for (int i = 0; i < 24; i++)
            if (!envsh__finite(out[i]) || out[i] < 0 || (i % 3 == 1 && out[i] > 1.001f * most)) abort();
    ODD_SYSTEM(&a.maps.system, o);
    shade_by(o, &a, out);
    if (o->hash != none.hash) ODD_ABORT("odd services change the light");
    odd_done(o);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    envlt_desc d;
    envlt_lights *l;
    uint32_t cube;
    sky s;
    odd o;

    odd_take(&o, data, size);
    in = input_of(data, size);
    cube = take(&in) & 1;
    s = sky_alloc(cube ? ENVLT_PROJECTION_CUBE : ENVLT_PROJECTION_LATLONG, 1 + take(&in) % 12, 1);
    if (!cube) {
        uint32_t wide = s.map.width;
        sky_free(&s);
        s = sky_alloc(ENVLT_PROJECTION_LATLONG, wide, 1 + take(&in) % 12);
    } else {
        uint32_t side = 1 + s.map.width % 6;
        sky_free(&s);
        s = sky_alloc(ENVLT_PROJECTION_CUBE, side, side);
    }
    d = desc_of((envlt_method)(take(&in) % (ENVLT_METHOD_COUNT + 1)), take(&in) % 65);
    d.hemisphere = (int)(take(&in) & 1);
    d.split_sun = (int)(take(&in) & 1);
    if (!d.light_count) d.light_count = 1;
    take_map(&in, &s);
    if (envlt_create(&d, &s.map, &l, NULL) == ENVLT_OK) {
        shade(&in, l, &o);
        envlt_free(l);
    }
    sky_free(&s);
    return 0;
}
