/* placement_test - sample points by measured error: row placement of docs/conformance.md. The bound is kept at places
   that were not measured; at equal memory placed shells beat the paper's and the default's. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

enum { RADII = 25, AROUND = 24, SIDE = 16, CELLS = 6 * SIDE * SIDE, PLACES = RADII * AROUND };

static float place[3 * PLACES], truth[(size_t)PLACES * CELLS];       /* truth: visibility, of texels */
static double radii[RADII];

/* Looks from places all round a box, 1.1 to 8 r away: wavelets keep what points see, texel by texel. */
static int look(void **state)
{
    model m = model_box(1, 0.4, 0.6);
    sfield_mesh mesh = mesh_of(&m);
    static float up[3 * PLACES];
    sfield_desc d;
    sfield_field *seen;
    sfield_info info;
    uint64_t seed = 12;
    int i, j, k;
    (void)state;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = SIDE;
    d.keep = 1;
    for (i = 0; i < RADII; i++) {
        radii[i] = 1.1 * pow(8 / 1.1, (i + 0.5) / RADII);
        for (j = 0; j < AROUND; j++) {
            double dir[3];
            rnd_direction(&seed, dir);
            up[3 * (i * AROUND + j)] = 1;
            for (k = 0; k < 3; k++)
                place[3 * (i * AROUND + j) + k] = (float)(dir[k] * radii[i] * sqrt(1 + 0.16 + 0.36));
        }
    }
    assert_int_equal(sfield_build_self(&d, &mesh, AT(place, up, PLACES), 0, &seen, NULL), SFIELD_OK);
    assert_int_equal(sfield_self(seen, 0, PLACES, truth), SFIELD_OK);
    sfield_get_info(seen, &info);
    assert_true(fabs((double)info.radius - sqrt(1.52)) < 1e-3);
    for (i = 0; i < PLACES * CELLS; i++) truth[i] = 1 - truth[i];
    sfield_free(seen);
    model_free(&m);
    return 0;
}

/* The error of a field at each radius: RMS of visibility over directions and places; returns the greatest. */
static double error_of(const sfield_field *f, int haar)
{
    static float texels[CELLS], v[16], exact[16];
    double worst = 0;
    int i, j, k;
    for (i = 0; i < RADII; i++) {
        double sum = 0;
        for (j = 0; j < AROUND; j++) {
            const size_t at = (size_t)(i * AROUND + j);
            if (haar) {
                float dir[3];
                assert_int_equal(sfield_query(f, 1, place + 3 * at, 0, texels), SFIELD_OK);
                for (k = 0; k < CELLS; k++)
                    sum += pow((double)texels[k] - (double)truth[at * CELLS + (size_t)k], 2) *
                           (double)sfield_cube_texel(SIDE, (uint32_t)k, dir);
                continue;
            }
            sfield_sh_project(4, SIDE, truth + at * CELLS, 1, exact);
            assert_int_equal(sfield_query(f, 1, place + 3 * at, 0, v), SFIELD_OK);
            for (k = 0; k < 16; k++) sum += pow((double)v[k] - (double)exact[k], 2);
        }
        worst = fmax(worst, sqrt(sum / (4 * PI * AROUND)));
    }
    return worst;
}

static sfield_desc desc_of(int haar)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.basis = haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    d.cube_side = SIDE;
    d.keep = 1;
    d.inner = 1.1f;
    d.outer = 8;
    return d;
}

/* Builds with a placement's points; opens the file again, as any program does. */
static sfield_field *build(sfield_desc *d, const sfield_placement *p)
{
    model m = model_box(1, 0.4, 0.6);
    sfield_mesh mesh = mesh_of(&m);
    sfield_field *f = NULL, *copy = NULL;
    void *file;
    if (p) {
        d->shell_count = p->shell_count;
        d->radii = p->radii;
        d->position_side = p->position_side;
    }
    assert_int_equal(sfield_build(d, &mesh, &f, NULL), SFIELD_OK);
    file = malloc(sfield_bytes(f));
    assert_non_null(file);
    assert_int_equal(sfield_write(f, file, sfield_bytes(f)), SFIELD_OK);
    assert_int_equal(sfield_open(file, sfield_bytes(f), NULL, &copy), SFIELD_OK);
    free(file);
    sfield_free(f);
    model_free(&m);
    return copy;
}

static sfield_placement placed(const sfield_desc *d, float bound)
{
    model m = model_box(1, 0.4, 0.6);
    sfield_mesh mesh = mesh_of(&m);
    sfield_placement p;
    memset(&p, 0, sizeof p);
    assert_int_equal(sfield_place(d, &mesh, NULL, bound, &p), SFIELD_OK);
    model_free(&m);
    return p;
}

static void a_bound_is_kept_between_the_places_that_were_measured(void **state)
{
    static const float bounds[2] = { 0.03f, 0.15f };
    static const char *const names[2] = { "error of a box's field placed for 0.03, harmonics",
                                          "placed for 0.15, wavelets of 16 x 16 texels" };
    int haar;
    (void)state;
    for (haar = 0; haar < 2; haar++) {
        sfield_desc d = desc_of(haar);
        const sfield_placement p = placed(&d, bounds[haar]), loose = placed(&d, 2 * bounds[haar]);
        sfield_field *f = build(&d, &p);
        uint32_t i;
        print_message("%u shells of %u x %u, errors %.4f and %.4f; twice the bound: %u of %u\n", p.shell_count,
                      p.position_side, p.position_side, (double)p.between, (double)p.across, loose.shell_count,
                      loose.position_side);
        assert_true(p.between <= 0.5f * bounds[haar] && p.across <= 0.5f * bounds[haar]);
        assert_true(loose.shell_count < p.shell_count && loose.position_side <= p.position_side);
        assert_true(p.radii[0] == 1.1f && p.radii[p.shell_count - 1] == 8);
        for (i = 1; i < p.shell_count; i++) assert_true(p.radii[i] > p.radii[i - 1]);
        CONFORM_MAX("placement", names[haar], (double)bounds[haar], error_of(f, haar));
        sfield_free(f);
    }
}

/* Six shells of the paper, of the default, and placed: the same points a shell, and the same bytes. */
static void placed_shells_err_less_than_the_papers_at_equal_memory(void **state)
{
    sfield_desc d = desc_of(0);
    sfield_placement p;
    double error[3];
    size_t bytes[3];
    int i;
    (void)state;
    d.shell_count = 6;
    d.position_side = 24;
    p = placed(&d, 0);
    for (i = 0; i < 3; i++) {
        sfield_desc own = d;
        sfield_field *f;
        own.spacing = i == 0 ? SFIELD_SPACING_UNIFORM : SFIELD_SPACING_GEOMETRIC;
        f = build(&own, i == 2 ? &p : NULL);
        error[i] = error_of(f, 0);
        bytes[i] = sfield_bytes(f);
        sfield_free(f);
    }
    CONFORM_NOTE("placement", "the same by 6 shells as the paper spaces them", error[0]);
    CONFORM_NOTE("placement", "by 6 shells of the default", error[1]);
    CONFORM_MAX("placement", "by 6 placed shells", error[1], error[2]);
    assert_true(bytes[0] == bytes[1] && bytes[1] == bytes[2] && error[2] < 0.75 * error[0]);
}

/* A lamp is placed, too: by the light that is there. A light that is off asks for nothing. */
static void emitters_are_placed_by_the_light_that_they_have(void **state)
{
    sfield_desc d;
    sfield_emitter e;
    sfield_placement p, dark;
    sfield_field *f;
    float at[3] = { 0, 0.9f, 0 }, c[48];
    (void)state;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    memset(&p, 0, sizeof p);
    e.radius = 0.3f;
    d.inner = 1.1f;
    assert_int_equal(sfield_place(&d, NULL, &e, 0.1f, &dark), SFIELD_OK);
    assert_true(dark.shell_count == 2 && dark.position_side == 4 && dark.between == 0 && dark.across == 0);
    e.radiance[0] = e.radiance[1] = e.radiance[2] = 1;
    assert_int_equal(sfield_place(&d, NULL, &e, 0.1f, &p), SFIELD_OK);
    assert_true(p.shell_count > 2 && p.between <= 0.05f && p.across <= 0.05f);
    d.shell_count = p.shell_count;
    d.radii = p.radii;
    d.position_side = p.position_side;
    assert_int_equal(sfield_build_emitter(&d, &e, &f, NULL), SFIELD_OK);
    sfield_query(f, 1, at, 0, c);                                     /* a cap of sin 1 / 3 */
    assert_true(fabs((double)c[0] / (sqrt(PI) * (1 - sqrt(8.0) / 3)) - 1) < 0.1);
    sfield_free(f);
}

/* Two shells are the first and the last, even where the paper's spacing errs by ten times the light between them. */
static void two_shells_of_a_source_end_at_the_outer_radius(void **state)
{
    sfield_desc d;
    sfield_emitter e;
    sfield_placement p;
    (void)state;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    memset(&p, 0, sizeof p);
    e.radius = 1;
    e.radiance[0] = 1;
    d.spacing = SFIELD_SPACING_UNIFORM;
    d.shell_count = 2;
    d.position_side = 4;
    d.outer = 100;
    assert_int_equal(sfield_place(&d, NULL, &e, 0, &p), SFIELD_OK);
    print_message("two uniform shells of a ball that shines err by %.1f\n", (double)p.between);
    assert_true(p.shell_count == 2 && p.radii[0] == 0.2f && p.radii[1] == 100 && p.between > 4);
}

static char said[256];
static int calls;
static void listen(void *user, const char *message)
{
    (void)user;
    snprintf(said, sizeof said, "%s", message);
}
static int stop(void *user, float fraction)
{
    (void)user, (void)fraction;
    return calls-- == 0;
}

static void bad_placements_are_refused(void **state)
{
    static const float falling[3] = { 1, 0.9f, 8 };
    model m = model_box(1, 0.4, 0.6);
    sfield_mesh mesh = mesh_of(&m);
    counting c = { 0, 0, 0, 0, 0 };
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_emitter e;
    sfield_placement p;
    sfield_field *f = NULL;
    sfield_result result = SFIELD_ERR_ALLOC;
    size_t fail;
    (void)state;
    memset(&e, 0, sizeof e);
    e.radius = 1;
    memset(&p, 7, sizeof p);
    d.system.log = listen;
    assert_int_equal(sfield_place(&d, NULL, NULL, 0, &p), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_place(&d, &mesh, &e, 0, &p), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_place(&d, &mesh, NULL, 0, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_place(&d, &mesh, NULL, -1, &p), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_place(&d, &mesh, NULL, NAN, &p), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_place(&d, &mesh, NULL, 1e-4f, &p), SFIELD_ERR_LIMIT);       /* of 4 shells */
    assert_non_null(strstr(said, "bound"));
    d.shell_count = 0;
    assert_int_equal(sfield_place(&d, &mesh, NULL, 0.03f, &p), SFIELD_ERR_LIMIT);       /* of 4 x 4 points */
    assert_non_null(strstr(said, "position_side"));
    for (calls = 0; calls < 3;) {
        const int before = calls;
        d.system.progress = stop;
        assert_int_equal(sfield_place(&d, &mesh, NULL, 0.9f, &p), SFIELD_ERR_CANCELLED);
        calls = before + 1;
    }
    d.system.progress = NULL;
    d.radii = falling;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC);
    assert_non_null(strstr(said, "shell_count"));
    d.shell_count = 3;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC);
    assert_non_null(strstr(said, "desc.radii[1]"));
    d.radii = NULL;
    d.system.allocator = counting_allocator(&c);
    for (fail = 1; result != SFIELD_OK; fail++) {
        assert_true(fail < 40);
        c.calls = 0;
        c.fail_at = fail;
        result = sfield_place(&d, &mesh, NULL, 0, &p);
        assert_true(c.now == 0 && (result == SFIELD_OK || result == SFIELD_ERR_ALLOC));
    }
    assert_true(fail > 6 && p.shell_count == 3);
    assert_null(f);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bound_is_kept_between_the_places_that_were_measured),
        cmocka_unit_test(placed_shells_err_less_than_the_papers_at_equal_memory),
        cmocka_unit_test(emitters_are_placed_by_the_light_that_they_have),
        cmocka_unit_test(two_shells_of_a_source_end_at_the_outer_radius),
        cmocka_unit_test(bad_placements_are_refused),
    };
    return cmocka_run_group_tests(tests, look, NULL);
}
