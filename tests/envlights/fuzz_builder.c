/* fuzz_builder - libFuzzer target: bytes choose a desc, a map and a video of it; lights must be finite and hold the
   map's energy, wherever jitter moves them. The last bytes choose odd services (kit/odd.h), by which the same
   is made. */

#define ENVLT_STATIC
#define ENVLIGHTS_IMPLEMENTATION
#include "envlights.h"
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

static void check_lights(const envlt_lights *l, const sky *s, int hemisphere)
{
    uint32_t count;
    const envlt_light *list = envlt_get_lights(l, &count);
    size_t texels;
    const uint32_t *strata = envlt_strata(l, &texels);
    double sum = 0, exact = 0, omega = 0;
    if (texels != s->texels) abort();
    for (uint32_t i = 0; i < count; i++) {
        if (!light_is_finite(&list[i])) abort();
        sum += (double)list[i].irradiance[0];
        omega += (double)list[i].solid_angle;
    }
    for (size_t t = 0; t < texels; t++) {
        double d[3], o;
        float f = s->rgb[3 * t];
        if (strata[t] != ENVLT_NO_LIGHT && strata[t] >= count) abort();
        sky_texel(s, t, d, &o);
        if (f > 0 && f <= 1e30f) exact += o * (double)f;
    }
    if (!hemisphere && fabs(sum - exact) > 1e-5 * exact + 1e-37) abort();      /* denormal floats round */
    if (count && fabs(omega - (hemisphere ? 2 : 4) * PI) > 1e-4) abort();
}

static void jitter(input *in, const envlt_lights *l)
{
    envlt_light moved[64];
    uint32_t count;
    envlt_get_lights(l, &count);
    if (envlt_jitter(l, take(in), 1, moved) != ENVLT_OK) abort();
    for (uint32_t i = 0; i < count; i++)
        if (!light_is_finite(&moved[i])) abort();
}

static void same_lights(const envlt_lights *a, const envlt_lights *b)
{
    uint32_t count, other;
    size_t texels, texels_of_b;
    const envlt_light *list = envlt_get_lights(a, &count), *list_of_b = envlt_get_lights(b, &other);
    const uint32_t *strata = envlt_strata(a, &texels), *strata_of_b = envlt_strata(b, &texels_of_b);
    if (count != other || texels != texels_of_b) abort();
    odd_equal(list, list_of_b, count * sizeof *list);
    odd_equal(strata, strata_of_b, texels * sizeof *strata);
}

/* The lights of the first frame by odd services, or NULL where there are none. */
static envlt_lights *create_oddly(odd *o, const envlt_desc *d, const envlt_map *map, envlt_result calm)
{
    envlt_desc mine = *d;
    envlt_lights *lights = NULL;
    ODD_SYSTEM(&mine.system, o);
    ODDLY(o, calm, envlt_create(&mine, map, &lights, NULL));
    return calm == ENVLT_OK ? lights : NULL;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    envlt_lights *mine;
    envlt_result result;
    odd o;
    envlt_desc d;
    envlt_lights *l;
    uint32_t cube, frames, step;
    sky s;

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
    odd_take(&o, data, size);
    result = envlt_create(&d, &s.map, &l, NULL);
    mine = create_oddly(&o, &d, &s.map, result);
    if (result == ENVLT_OK) {
        check_lights(l, &s, d.hemisphere);
        same_lights(l, mine);
        jitter(&in, l);
        for (frames = take(&in) % 4; frames > 0; frames--) {
            take_map(&in, &s);
            step = take(&in) % 65;
            result = envlt_follow(l, &s.map, step, NULL);
            ODDLY(&o, result, envlt_follow(mine, &s.map, step, NULL));
            if (result == ENVLT_OK) check_lights(l, &s, d.hemisphere);
            same_lights(l, mine);
        }
        envlt_free(mine);
        envlt_free(l);
    }
    odd_done(&o);
    sky_free(&s);
    return 0;
}
