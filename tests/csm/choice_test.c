/* choice_test - a build that is left to choose takes the order and the orientation that trials by the public API find:
   built at a quarter and an eighth of each side with half the pixels, the fewest segments when continued by their
   growth. Drawing the views of both orders once changes nothing, nor does the memory that this takes. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"
#include "making.h"

static double segments_of(const cohsm_desc *desc, const model *m, uint32_t shrink)
{
    cohsm_desc d = *desc;
    cohsm_mesh mesh = mesh_of(m);
    cohsm_maps *maps = NULL;
    cohsm_stats stats;
    int k;
    for (k = 0; k < 3; k++) d.domain.side[k] = (desc->domain.side[k] + shrink - 1) / shrink;
    d.map_side = desc->map_side / 2 < 8 ? 8 : desc->map_side / 2;
    d.pixel_begin = d.pixel_end = 0;
    assert_int_equal(cohsm_build(&d, &mesh, &maps, &stats), COHSM_OK);
    cohsm_free(maps);
    return (double)stats.segments;
}

/* Sets order and orientation as the trials say. */
static void choose(cohsm_desc *d, const model *m, int directions)
{
    static const cohsm_order orders[2] = { COHSM_ORDER_HILBERT, COHSM_ORDER_ZIGZAG_THETA };
    static const cohsm_orientation ways[2] = { COHSM_ORIENTATION_POLAR, COHSM_ORIENTATION_TWO_POLES };
    const uint32_t shrink = d->domain.side[0] >= 32 ? 4 : d->domain.side[0] >= 16 ? 2 : 1;
    cohsm_desc best = *d;
    double least = 0;
    int o, w;
    for (o = 0; o < (d->order == COHSM_ORDER_DEFAULT ? 2 : 1); o++)
        for (w = 0; w < (directions && d->orientation == COHSM_ORIENTATION_DEFAULT ? 2 : 1); w++) {
            cohsm_desc one = *d;
            double n, growth = 1;
            uint32_t k;
            if (d->order == COHSM_ORDER_DEFAULT) one.order = orders[o];
            if (d->orientation == COHSM_ORIENTATION_DEFAULT) one.orientation = ways[w];
            n = segments_of(&one, m, shrink);
            if (shrink > 1) growth = n / segments_of(&one, m, 2 * shrink);
            for (k = shrink; k > 1; k /= 2) n *= growth;
            if (least > 0 && n >= least) continue;
            least = n;
            best = one;
        }
    *d = best;
}

/* Builds left to choose and built as the trials say; returns which of the four was taken. */
static int same_choice(const cohsm_desc *desc, const model *m, int directions)
{
    cohsm_desc d = *desc;
    cohsm_maps *free_choice = build(desc, m), *told;
    cohsm_info info;
    size_t x = 0, y = 0;
    const void *a = cohsm_data(free_choice, &x), *b;
    choose(&d, m, directions);
    told = build(&d, m);
    b = cohsm_data(told, &y);
    cohsm_get_info(free_choice, &info);
    assert_int_equal(info.order, d.order);
    assert_int_equal(x, y);
    assert_memory_equal(a, b, x);
    cohsm_free(free_choice);
    cohsm_free(told);
    return 2 * (info.order == COHSM_ORDER_ZIGZAG_THETA) + (info.orientation == COHSM_ORIENTATION_TWO_POLES);
}

static void a_build_takes_what_trials_by_hand_find(void **state)
{
    static const uint32_t sides[5] = { 7, 16, 21, 32, 37 };
    model shapes[3];
    unsigned taken = 0;
    int i, layers;
    (void)state;
    shapes[0] = model_torus(24, 12, 0.7, 0.25);
    shapes[1] = model_soup(60, 0.3, 4);
    shapes[2] = model_sphere(16, 9, 0.3);
    for (i = 0; i < 15; i++)
        for (layers = 0; layers < (i % 5 < 2 ? 3 : 1); layers++) {
            cohsm_desc d = desc_of(i % 2 ? COHSM_DOMAIN_OCTAHEDRAL : COHSM_DOMAIN_LATLONG, sides[i % 5], 24);
            d.layers = (cohsm_layers)(1 + layers);
            d.order = i == 6 ? COHSM_ORDER_ZIGZAG : COHSM_ORDER_DEFAULT;
            d.orientation = i == 7 ? COHSM_ORIENTATION_TWO_POLES : COHSM_ORIENTATION_DEFAULT;
            if (i == 8) {               /* a shard chooses as the whole does */
                d.pixel_begin = 100;
                d.pixel_end = 300;
            }
            taken |= 1u << same_choice(&d, &shapes[i / 5], 1);
        }
    assert_int_equal(taken, 15);
    for (i = 0; i < 3; i++) model_free(&shapes[i]);
}

/* Cube maps have six views a cell, and no orientation. */
static void cube_maps_choose_an_order(void **state)
{
    model soup = model_soup(60, 0.3, 5);
    unsigned taken = 0;
    int i;
    (void)state;
    for (i = 0; i < 3; i++) {
        cohsm_desc d = desc_of(COHSM_DOMAIN_RECTANGLE, 16, 16);
        d.domain.side[1] = i == 1 ? 5 : 16;
        d.layers = (cohsm_layers)(1 + i);
        place_domain(&d, -1, 1.75f, -1, 2);
        taken |= 1u << same_choice(&d, &soup, 0);
    }
    assert_true(taken != 0 && taken < 8);
    model_free(&soup);
}

/* A shelf holds the views of a trial if they take at most 32 MB. */
static void large_trials_keep_no_views(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 32, 64);
    (void)state;
    d.layers = COHSM_LAYERS_Z1Z2;
    d.domain.side[2] = 1;
    assert_int_equal(cohsm__shelf_depths(&d), 32 * 32 * 64 * 64 * 2);
    d.layers = COHSM_LAYERS_Z1Z3_FAR;
    assert_int_equal(cohsm__shelf_depths(&d), 32 * 32 * 64 * 64 * 4);
    d.map_side = 65;
    assert_int_equal(cohsm__shelf_depths(&d), 0);
    d.domain.side[0] = d.domain.side[1] = 4096;
    d.map_side = 1024;
    assert_int_equal(cohsm__shelf_depths(&d), 0);
}

static void equal_trials_take_the_first(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 32, 64);
    cohsm__choice choice;
    int i;
    (void)state;
    memset(&choice, 0, sizeof choice);
    choice.orders = choice.orientations = 2;
    choice.order[0] = COHSM_ORDER_HILBERT;
    choice.order[1] = COHSM_ORDER_ZIGZAG_THETA;
    choice.orientation[0] = COHSM_ORIENTATION_POLAR;
    choice.orientation[1] = COHSM_ORIENTATION_TWO_POLES;
    for (i = 0; i < 8; i++) choice.segments[i >> 2][i >> 1 & 1][i & 1] = i & 1 ? 500 : 1000;
    cohsm__take_best(&d, &choice, 4);
    assert_int_equal(d.order, COHSM_ORDER_HILBERT);
    assert_int_equal(d.orientation, COHSM_ORIENTATION_POLAR);
    choice.segments[1][0][0] = 999;
    cohsm__take_best(&d, &choice, 4);
    assert_int_equal(d.order, COHSM_ORDER_ZIGZAG_THETA);
    assert_int_equal(d.orientation, COHSM_ORIENTATION_POLAR);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_build_takes_what_trials_by_hand_find),
        cmocka_unit_test(cube_maps_choose_an_order),
        cmocka_unit_test(large_trials_keep_no_views),
        cmocka_unit_test(equal_trials_take_the_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
