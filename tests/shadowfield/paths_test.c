/* paths_test - what shadowfield.h computes in more than one way: with the vectors of each machine and with none,
   and with the samples that neighbours share as with each point's own. The results are the same. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

static sfield_field *box_field(const sfield_desc *d)
{
    model m = model_box(0.5, 0.3, 0.4);
    sfield_mesh mesh = mesh_of(&m);
    sfield_field *f = NULL;
    assert_int_equal(sfield_build(d, &mesh, &f, NULL), SFIELD_OK);
    model_free(&m);
    return f;
}

/* Two frames, each triangle of another colour: no channel is a multiple of another. */
static sfield_field *glow_field(const sfield_desc *from)
{
    model m = model_box(0.1, 0.2, 0.1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = *from;
    sfield_field *f = NULL;
    float radiance[2 * 12 * 3];
    uint64_t seed = 3;
    int i;
    for (i = 0; i < 72; i++) radiance[i] = rnd_in(&seed, 0, 9);
    d.frame_count = 2;
    d.frames_per_second = 1;
    d.logarithm = 0;
    assert_int_equal(sfield_build_emissive(&d, &mesh, radiance, &f, NULL), SFIELD_OK);
    model_free(&m);
    return f;
}

static sfield_field *lamp_field(const sfield_desc *from)
{
    sfield_desc d = *from;
    sfield_emitter e;
    sfield_field *f = NULL;
    memset(&e, 0, sizeof e);
    e.radius = 0.2f;
    e.radiance[0] = 20;
    e.radiance[1] = 10;
    d.logarithm = 0;
    assert_int_equal(sfield_build_emitter(&d, &e, &f, NULL), SFIELD_OK);
    return f;
}

/* Planes of 16 points in a box about a place. */
static void cluster(uint64_t *seed, float spread, float *p)
{
    float at[3];
    uint32_t k, l;
    for (k = 0; k < 3; k++) at[k] = rnd_in(seed, -4, 4);
    for (k = 0; k < 3; k++)
        for (l = 0; l < 16; l++) p[16 * k + l] = at[k] + rnd_in(seed, -1, 1) * spread;
}

/* One by one what lies at 16 places: of channel c, n coefficients times factor, in planes. */
static void one_by_one(const sfield_field *f, const sfield__place *at, uint32_t lanes, const float *factor, uint32_t c,
                       uint32_t n, float *planes, int simd)
{
    float row[3 * SFIELD_MAX_COEFS + 8];
    uint32_t k, l;
    for (l = 0; l < 16; l++) {
        const sfield__between b = sfield__find_between(at, (int)l, factor[l]);
        sfield__mix_samples(f, &b, f->h.stride, row, simd);
        for (k = 0; k < n; k++) planes[16 * k + l] = lanes >> l & 1 ? row[c * n + k] : 0;
    }
}

/* Equal numbers; a zero may have either sign. */
static void same_bits(const float *a, const float *b, size_t n)
{
    size_t i;
    for (i = 0; i < n; i++)
        if (!(a[i] == b[i])) fail_msg("%zu: %.9g is not %.9g", i, (double)a[i], (double)b[i]);
}

static void shared_samples_give_the_bits_of_single_ones(void **state)
{
    static const float spreads[] = { 0.02f, 0.3f, 3 };
    uint64_t seed = 11;
    uint32_t bands, i, l, shared = 0, single = 0;
    int simd;
    (void)state;
    for (bands = 2; bands <= 8; bands += 2) {
        sfield_desc d = small_desc(SFIELD_BASIS_SH);
        sfield_field *f;
        d.bands = bands;
        f = box_field(&d);
        for (simd = 0; simd <= sfield__simd_level(); simd++)
            for (i = 0; i < 60; i++) {
                float p[48], factor[16], rows[16 * 64], planes[16 * 64], expected[16 * 64];
                uint32_t lanes = i % 4 ? rnd_below(&seed, 65535) + 1 : 65535, group[16];
                sfield__place at;
                cluster(&seed, spreads[i % 3], p);
                for (l = 0; l < 16; l++) factor[l] = rnd_in(&seed, 0, 1);
                sfield__locate16(f, p, &at, simd);
                memset(planes, 99, sizeof planes);
                sfield__fetch_lanes(f, &at, lanes, factor, rows, planes, simd);
                one_by_one(f, &at, lanes, factor, 0, f->planes, expected, simd);
                same_bits(planes, expected, 16 * f->planes);
                if (sfield__group_lanes(&at, lanes, group, simd)) shared++;
                else single++;
            }
        sfield_free(f);
    }
    assert_true(shared > 30 && single > 30);            /* of 240 for each kind of vectors */
}

/* The dot product that a source's light is: sums of every eighth product, then of those as vectors' halves add them. */
static void shared_sources_give_the_bits_of_single_ones(void **state)
{
    uint64_t seed = 12;
    uint32_t bands, i, k, l, c;
    int simd;
    (void)state;
    for (bands = 4; bands <= 8; bands += 4) {
        sfield_desc d = small_desc(SFIELD_BASIS_SH);
        sfield_field *f;
        uint32_t n = bands * bands;
        d.bands = bands;
        f = glow_field(&d);
        assert_true(f->tone == 3);
        for (simd = 0; simd <= sfield__simd_level(); simd++)
            for (i = 0; i < 20; i++) {
                float p[48], own[16], chain[16 * 64], planes[16 * 64], sum[16] = { 0 }, alone[16] = { 0 };
                float room[32 * 64];
                sfield__place at;
                sfield__eight e;
                cluster(&seed, 0.01f, p);
                for (k = 0; k < 16 * n; k++) chain[k] = rnd_in(&seed, -1, 1);
                sfield__locate16(f, p, &at, simd);
                for (l = 0; l < 16; l++) own[l] = at.base[l] == at.base[0] ? 0.75f : 0.0f;
                c = i % 3;
                sfield__load_eight(f, (size_t)at.base[0], (size_t)at.shell[0], c * n, n, &e, simd);
                sfield__dot_eight(&e, &at, own, chain, sum, simd);
                one_by_one(f, &at, 65535, own, c, n, planes, simd);
                sfield__dot_single(f, &at, 0, own, c * n, n, chain, room, alone, simd);
                for (l = 0; l < 16; l++) {
                    float exact = 0;
                    for (k = 0; k < n; k++) exact += planes[16 * k + l] * chain[16 * k + l];
                    if (own[l] > 0) same_bits(&sum[l], &alone[l], 1);
                    if (own[l] > 0) assert_true(fabsf(sum[l] - exact) <= 1e-5f * (1 + fabsf(exact)));
                    else assert_true(sum[l] == 0);
                }
            }
        sfield_free(f);
    }
}

/* ---- whole scenes ---- */

enum { POINTS = 43, SETS = 2, ENTITIES = 6, FRAMES = 3, FLOATS = SETS * POINTS * 7 };

typedef struct stage {
    sfield_field *box, *glow, *lamp, *self;
    float         p[3 * POINTS], n[3 * POINTS], view[3 * POINTS], exponent[POINTS];
    sfield_field *own[POINTS];      /* self, each point's: NULL, or they are shaded each by itself */
    const uint8_t *in_view;
} stage;

static void open_stage(stage *s, const sfield_desc *d)
{
    model m = model_box(0.5, 0.3, 0.4);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc own = *d;
    uint64_t seed = 5;
    int i;
    own.logarithm = 0;
    s->box = box_field(d);
    s->glow = glow_field(d);
    s->lamp = lamp_field(d);
    for (i = 0; i < POINTS; i++) {              /* on top of the box */
        double v[3];
        s->p[3 * i] = -0.5f + (float)i / POINTS;
        s->p[3 * i + 1] = 0.3f;
        s->p[3 * i + 2] = rnd_in(&seed, -0.4, 0.4);
        s->n[3 * i] = s->n[3 * i + 2] = 0;
        s->n[3 * i + 1] = 1;
        rnd_direction(&seed, v);
        s->view[3 * i] = (float)v[0];
        s->view[3 * i + 1] = fabsf((float)v[1]);
        s->view[3 * i + 2] = (float)v[2];
        s->exponent[i] = rnd_in(&seed, 0.5, 2000);
    }
    assert_int_equal(sfield_build_self(&own, &mesh, AT(s->p, s->n, POINTS), 1e-3f, &s->self, NULL), SFIELD_OK);
    memset(s->own, 0, sizeof s->own);
    s->in_view = NULL;
    model_free(&m);
}

static void part_points(stage *s, const sfield_desc *d)
{
    model m = model_box(0.5, 0.3, 0.4);
    sfield_mesh mesh = mesh_of(&m);
    int i;
    for (i = 0; i < POINTS; i++)
        assert_int_equal(sfield_build_self(d, &mesh, AT(s->p + 3 * i, s->n + 3 * i, 1),
                                           1e-3f, &s->own[i], NULL),
                         SFIELD_OK);
    model_free(&m);
}

static void close_stage(stage *s)
{
    int i;
    for (i = 0; i < POINTS; i++) sfield_free(s->own[i]);
    sfield_free(s->box);
    sfield_free(s->glow);
    sfield_free(s->lamp);
    sfield_free(s->self);
}

static void put(sfield_entity *e, int turned, double angle, double x, double y, double z)
{
    *e = upright;
    matrix_of(e->transform, 0.3, 1, -0.2, turned ? angle : 0, 1.25, x, y, z);
}

/* All sets, or each point as a set. */
static void shade_sets(const stage *s, sfield_scene *scene, const sfield_points *set)
{
    int i, k;
    if (!s->own[0]) {
        assert_int_equal(sfield_shade(scene, set, SETS, NULL), SFIELD_OK);
        return;
    }
    for (k = 0; k < SETS; k++)
        for (i = 0; i < POINTS; i++) {
            sfield_points one = set[k];
            one.count = 1;
            one.positions += 3 * i;
            one.normals += 3 * i;
            one.self = one.self ? s->own[i] : NULL;
            one.in_view = one.in_view ? one.in_view + i : NULL;
            one.rgb += 3 * i;
            one.ambient += i;
            assert_int_equal(sfield_shade(scene, &one, 1, NULL), SFIELD_OK);
        }
}

/* Three frames: all, a lamp that moved, the same again. What each shows, one after the other. */
static void shade_frames(const stage *s, const sfield_scene_desc *sd, int simd, int turned, uint32_t cached, float *out)
{
    static const float sky[4 * 2 * 3] = { 1, 2, 3, 0, 1, 0, 4, 0, 2, 1, 1, 1, 0, 0, 3, 2, 2, 0, 1, 5, 0, 0, 0, 1 };
    static const float sun[3] = { 0.6f, 0.8f, 0 }, strength[3] = { 2, 1, 3 };
    sfield_entity e[ENTITIES];
    sfield_points set[SETS];
    sfield_scene *scene;
    int i, k, frame;
    assert_int_equal(sfield_scene_create(sd, &scene), SFIELD_OK);
    scene->simd = simd;
    if (scene->algebra) scene->algebra->simd = simd;
    assert_int_equal(sfield_scene_environment(scene, sky, 4, 2, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_sun(scene, sun, strength), SFIELD_OK);
    put(&e[0], turned, 0.7, 0, 0, 0);
    put(&e[1], turned, 1.9, 1.2, 1.1, 0.3);
    put(&e[2], 0, 0, -0.8, 1.4, -0.2);
    put(&e[3], 0, 0, 1.5, 2.4, 0.3);
    put(&e[4], turned, 2.2, -1.5, 2, 0.4);
    put(&e[5], turned, 2.2, -0.4, 3, -1.4);
    e[0].occlusion = e[1].occlusion = e[2].occlusion = s->box;
    e[3].source = s->lamp;
    e[4].source = e[5].source = s->glow;
    e[5].time = 0.31f;
    memset(set, 0, sizeof set);
    for (i = 0; i < SETS; i++) {
        sfield_points *q = &set[i];
        q->count = POINTS;
        q->positions = s->p;
        q->normals = s->n;
        q->entity = i ? 1 : 0;
        q->self = i ? s->self : NULL;
        q->in_view = s->in_view;
        if (cached) assert_int_equal(sfield_cache_create(scene, POINTS, cached, &q->cache), SFIELD_OK);
    }
    memset(out, 0, FRAMES * FLOATS * sizeof *out);
    for (frame = 0; frame < FRAMES; frame++) {
        for (i = 0; i < SETS; i++) {
            float *to = out + (frame * SETS + i) * POINTS * 7;
            set[i].rgb = to;
            set[i].ambient = to + 3 * POINTS;
            if (!scene->algebra || cached) continue;
            set[i].gloss = to + 4 * POINTS;
            set[i].to_eye = s->view;
            set[i].exponents = s->exponent;
        }
        if (frame == 1) e[3].transform[12] -= 0.4f;
        assert_int_equal(sfield_scene_entities(scene, e, ENTITIES), SFIELD_OK);
        shade_sets(s, scene, set);
    }
    for (k = 0; k < SETS; k++) sfield_cache_free(set[k].cache);
    sfield_scene_free(scene);
}

/* The largest difference by the largest value. */
static double apart(const float *a, const float *b, size_t n)
{
    double most = 0, worst = 0;
    size_t i;
    for (i = 0; i < n; i++) {
        most = fmax(most, fabs((double)b[i]));
        worst = fmax(worst, fabs((double)a[i] - (double)b[i]));
        assert_true(sfield__finite(a[i]));
    }
    assert_true(most > 0.1);
    return worst / most;
}

static void all_ways(const sfield_desc *d, sfield_product_mode product, int turned, const char *what)
{
    static float plain[FRAMES * FLOATS], other[FRAMES * FLOATS];
    sfield_scene_desc sd;
    static const uint32_t caches[] = { 0, 1, 4 };      /* one has not room for all lights: the rest is shaded anew */
    uint32_t cached;
    double off;
    stage s;
    int simd, i, way;
    open_stage(&s, d);
    memset(&sd, 0, sizeof sd);
    sd.basis = d->basis;
    sd.bands = d->bands;
    sd.cube_side = d->cube_side;
    sd.product = product;
    for (way = 0; way < 3; way++) {
        cached = caches[way];
        shade_frames(&s, &sd, 0, turned, cached, plain);
        for (simd = 1; simd <= sfield__simd_level(); simd++) {
            shade_frames(&s, &sd, simd, turned, cached, other);
            off = apart(other, plain, FRAMES * FLOATS);
            printf("%s, caches of %u lights, simd %d: %.1e\n", what, cached, simd, off);
            assert_true(off <= (cached ? 2e-4 : 1e-5));
        }
        if (!cached || d->basis == SFIELD_BASIS_HAAR) continue;     /* whose caches keep few wavelets */
        shade_frames(&s, &sd, sfield__simd_level(), turned, 0, other);
        for (i = 0; i < FRAMES * SETS; i++)
            assert_true(apart(plain + i * POINTS * 7, other + i * POINTS * 7, 4 * POINTS) <= 1e-3);
    }
    close_stage(&s);
}

static void harmonics_are_the_same_by_all_vectors(void **state)
{
    static const uint32_t bands[] = { 1, 3, 4, 8 };
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    int i;
    (void)state;
    for (i = 0; i < 4; i++) {
        char what[32];
        d.bands = bands[i];
        snprintf(what, sizeof what, "%u bands", bands[i]);
        all_ways(&d, SFIELD_PRODUCT_TRIPLE, i != 1, what);
    }
    d.bands = 4;
    d.logarithm = 1;
    all_ways(&d, SFIELD_PRODUCT_EXP, 1, "logarithms");
}

static void wavelets_are_the_same_by_all_vectors(void **state)
{
    sfield_desc d = small_desc(SFIELD_BASIS_HAAR);
    (void)state;
    all_ways(&d, SFIELD_PRODUCT_TEXELS, 1, "texels");
    all_ways(&d, SFIELD_PRODUCT_TEXELS, 0, "texels, nothing turned");
    all_ways(&d, SFIELD_PRODUCT_SPARSE, 0, "sparse");
}

/* Points all about a video, so that hardly two share samples: the cosine's coefficients times the field's then. */
/* Points in wavelets, sixteen at a time, as each by itself; with cubes smaller and larger than a block of 64 texels,
   points that are left out, above a box and among others in several orders. */
static void bundles_are_as_single_points(void **state)
{
    static const uint32_t sides[] = { 4, 8, 16, 64 };
    static float together[FRAMES * FLOATS], single[FRAMES * FLOATS];
    uint8_t visible[POINTS];
    sfield_scene_desc sd;
    int i, k, simd, masked;
    (void)state;
    for (i = 0; i < POINTS; i++) visible[i] = (uint8_t)(i % 5 != 3 && (i < 16 || i > 29));
    for (i = 0; i < 4; i++) {
        sfield_desc d = small_desc(SFIELD_BASIS_HAAR);
        stage s;
        d.cube_side = sides[i];
        d.keep = i == 3 ? 0.02f : 0.3f;
        open_stage(&s, &d);
        memset(&sd, 0, sizeof sd);
        sd.basis = SFIELD_BASIS_HAAR;
        sd.cube_side = sides[i];
        for (masked = 0; masked < 2; masked++) {
            s.in_view = masked ? visible : NULL;
            for (simd = 0; simd <= sfield__simd_level(); simd++) {
                double off;
                shade_frames(&s, &sd, simd, 0, 0, together);
                part_points(&s, &d);
                shade_frames(&s, &sd, simd, 0, 0, single);
                for (k = 0; k < POINTS; k++) {
                    sfield_free(s.own[k]);
                    s.own[k] = NULL;
                }
                off = apart(together, single, FRAMES * FLOATS);
                printf("cubes of %u, simd %d: %.1e\n", (unsigned)sides[i], simd, off);
                assert_true(off > 0 && off <= 3e-6);             /* the sums are added up in another order */
            }
        }
        close_stage(&s);
    }
}

/* Points all round a lamp of several frames, or so close together that they share the samples of its field: their light
   is the dot product with what sfield_query mixes from the frames before and after. */
static void see_a_video(int together)
{
    enum { N = 35 };
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_scene_desc sd;
    sfield_entity e = upright;
    sfield_points set;
    sfield_scene *s;
    sfield_field *f;
    float p[3 * N], n[3 * N], rgb[3 * N], coefs[3 * 16], bands[SFIELD_MAX_BANDS];
    uint64_t seed = 31;
    int simd, i, k, c;
    d.bands = 4;
    f = glow_field(&d);
    memset(&sd, 0, sizeof sd);
    for (i = 0; i < N; i++) {
        double v[3];
        rnd_direction(&seed, v);
        for (k = 0; k < 3; k++) {
            p[3 * i + k] = (float)(together ? (k == 1 ? 2.0 : 0.7) + 1e-3 * v[k] : v[k] * (1 + 0.1 * i));
            n[3 * i + k] = (float)-v[k];
        }
    }
    memset(&set, 0, sizeof set);
    set.count = N;
    set.positions = p;
    set.normals = n;
    set.entity = 0;
    set.rgb = rgb;
    e.source = f;
    e.time = 0.31f;
    e.tint[1] = 0.5f;
    sfield_sh_cosine(4, bands);
    for (simd = 0; simd <= sfield__simd_level(); simd++) {
        assert_int_equal(sfield_scene_create(&sd, &s), SFIELD_OK);
        s->simd = s->algebra->simd = simd;
        assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        for (i = 0; i < N; i++) {
            double y[16], dir[3];
            for (k = 0; k < 3; k++) dir[k] = (double)n[3 * i + k];
            sfield_sh_basis(4, dir, y);
            assert_int_equal(sfield_query(f, 1, p + 3 * i, e.time, coefs), SFIELD_OK);
            for (c = 0; c < 3; c++) {
                double sum = 0;
                for (k = 0; k < 16; k++)
                    sum += (double)coefs[16 * c + k] * y[k] * (double)bands[k < 1 ? 0 : k < 4 ? 1 : k < 9 ? 2 : 3];
                sum *= (double)e.tint[c] / PI;
                if (!(fabs(sum - (double)rgb[3 * i + c]) <= 1e-5 * (1 + fabs(sum))))
                    fail_msg("simd %d, point %d: %g, not %g", simd, i, (double)rgb[3 * i + c], sum);
            }
        }
        sfield_scene_free(s);
    }
    sfield_free(f);
}

static void a_video_seen_from_all_sides_is_that_of_its_field(void **state)
{
    (void)state;
    see_a_video(0);
}

static void a_video_seen_from_one_place_is_that_of_its_field(void **state)
{
    (void)state;
    see_a_video(1);
}

/* Suns taken away and set anew, and a sky that turns, are what setting all of it anew is, bit by bit. */
static void a_sun_moves_and_the_sky_stays(void **state)
{
    static const float a[3] = { 0, 1, 0 }, b[3] = { 0.6f, 0, 0.8f }, white[3] = { 3, 2, 1 };
    float sky[8 * 4 * 3], turn_1[16], turn_2[16];
    uint64_t seed = 21;
    int basis, i;
    (void)state;
    for (i = 0; i < 96; i++) sky[i] = rnd_in(&seed, 0, 5);
    matrix_of(turn_1, 0, 1, 0, 0.4, 1, 0, 0, 0);
    matrix_of(turn_2, 1, 1, 0.3, 2.4, 1, 0, 0, 0);
    for (basis = SFIELD_BASIS_SH; basis <= SFIELD_BASIS_HAAR; basis++) {
        sfield_scene_desc d;
        sfield_scene *moved, *anew;
        size_t size;
        memset(&d, 0, sizeof d);
        d.basis = (sfield_basis)basis;
        d.cube_side = 8;
        assert_int_equal(sfield_scene_create(&d, &moved), SFIELD_OK);
        assert_int_equal(sfield_scene_create(&d, &anew), SFIELD_OK);
        size = 3 * moved->planes * (basis == SFIELD_BASIS_HAAR ? 2 : 1) * sizeof(float);
        sfield_scene_environment(moved, sky, 8, 4, turn_1);
        sfield_scene_sun(moved, a, white);
        assert_int_equal(sfield_scene_sun(moved, NULL, NULL), SFIELD_OK);
        sfield_scene_environment(anew, sky, 8, 4, turn_1);
        assert_memory_equal(moved->sky_now, anew->sky_now, size);
        sfield_scene_sun(moved, b, white);
        sfield_scene_turn(moved, turn_2);
        sfield_scene_environment(anew, sky, 8, 4, turn_2);
        sfield_scene_sun(anew, b, white);
        assert_memory_equal(moved->sky_now, anew->sky_now, size);
        sfield_scene_environment(moved, NULL, 0, 0, NULL);           /* no sky: suns alone */
        sfield_scene_sun(moved, a, white);
        sfield_scene_sun(moved, NULL, NULL);
        for (i = 0; i < 3 * (int)moved->planes; i++) assert_true(moved->sky_now[i] == 0);
        assert_false(moved->has_sun);
        sfield_scene_free(moved);
        sfield_scene_free(anew);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shared_samples_give_the_bits_of_single_ones),
        cmocka_unit_test(shared_sources_give_the_bits_of_single_ones),
        cmocka_unit_test(harmonics_are_the_same_by_all_vectors),
        cmocka_unit_test(wavelets_are_the_same_by_all_vectors),
        cmocka_unit_test(bundles_are_as_single_points),
        cmocka_unit_test(a_video_seen_from_all_sides_is_that_of_its_field),
        cmocka_unit_test(a_video_seen_from_one_place_is_that_of_its_field),
        cmocka_unit_test(a_sun_moves_and_the_sky_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
