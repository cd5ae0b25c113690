/* bones_test - articulated figures: bones are entities, which hide themselves from their own points by their
   self-visibility, and the others by their fields. Closed forms of balls first, then rays: joints of capsules, whose
   bounding spheres overlap, and a part that turns. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

enum { BANDS = 4, COEFS = BANDS * BANDS, CHAIN = 6, MOST = 400 };

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

static const double limb_radius = 0.16;         /* of a capsule from the joint at the origin to (0, -1, 0) */
static sfield_field *ball, *limb;

/* A closed capsule, round at both ends. */
static model model_limb(void)
{
    model m = model_sphere(24, 24, limb_radius);
    size_t i;
    for (i = 0; i < m.vertices; i++)
        if (m.p[3 * i + 1] < 0) m.p[3 * i + 1] -= 1;
    return m;
}

static int make_fields(void **state)
{
    sfield_desc d;
    model m = model_limb();
    sfield_mesh mesh = mesh_of(&m);
    (void)state;
    memset(&d, 0, sizeof d);
    d.position_side = 12;
    assert_int_equal(sfield_build(&d, &mesh, &limb, NULL), SFIELD_OK);
    model_free(&m);
    m = model_sphere(48, 24, 1);
    mesh = mesh_of(&m);
    d.position_side = 0;
    assert_int_equal(sfield_build(&d, &mesh, &ball, NULL), SFIELD_OK);
    model_free(&m);
    return 0;
}

static int free_fields(void **state)
{
    (void)state;
    sfield_free(ball);
    sfield_free(limb);
    return 0;
}

/* A scene of entities under a sky of radiance 1. */
static sfield_scene *scene_of(const sfield_entity *entities, size_t count)
{
    static const float one[3] = { 1, 1, 1 };
    sfield_scene *s = NULL;
    assert_int_equal(sfield_scene_create(NULL, &s), SFIELD_OK);
    assert_int_equal(sfield_scene_entities(s, entities, count), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(s, one, 1, 1, NULL), SFIELD_OK);
    return s;
}

static sfield_entity ball_at(double x, double y, double z)
{
    sfield_entity e = upright;
    e.occlusion = ball;
    e.transform[12] = (float)x;
    e.transform[13] = (float)y;
    e.transform[14] = (float)z;
    return e;
}

/* ---- chains of balls: what a ball hides is a cone ---- */

/* Visibility beside a unit ball with its middle at `to`: 1 less a cap, whose coefficients in its own frame are
   integrals of Legendre polynomials. */
static void visibility_of_cone(const double *to, float *out)
{
    double d = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]), c = sqrt(1 - 1 / (d * d)), p[BANDS + 2];
    double axis[3] = { to[0] / d, to[1] / d, to[2] / d }, y[COEFS];
    int l, m;
    p[0] = 1;
    p[1] = c;
    for (l = 1; l <= BANDS; l++) p[l + 1] = ((2 * l + 1) * c * p[l] - l * p[l - 1]) / (l + 1);
    sfield_sh_basis(BANDS, axis, y);
    for (l = 0; l < BANDS; l++) {
        double k = l ? 2 * PI / (2 * l + 1) * (p[l - 1] - p[l + 1]) : 2 * PI * (1 - c);
        for (m = -l; m <= l; m++) out[l * l + l + m] = (float)((l ? 0 : sqrt(4 * PI)) - k * y[l * l + l + m]);
    }
}

/* Of a surface that faces the middle of both from far below each hides cos / d^2. */
static void below_two_bones_each_hides_its_own(sfield_scene *s)
{
    static const float below[3] = { 0, -3, 0 }, up[3] = { 0, 1, 0 };
    const double d2 = 2.2 * 2.2 + 9, truth = 1 - 2 * 3 / sqrt(d2) / d2;
    sfield_points set = *AT(below, up, 1);
    float lit;
    set.ambient = &lit;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    printf("below two balls: %.4f, should be %.4f\n", (double)lit, truth);
    assert_true(fabs((double)lit - truth) < 0.01);      /* one alone: 0.942 */
}

/* Under a sky of 1 what arrives is the visibility itself: the product of the cones of both, on four bands. */
static void between_two_bones_the_cones_are_multiplied(void **state)
{
    static const float places[4][3] = { { 0, 1.6f, 0 }, { 0.9f, 1.3f, 0.4f }, { -2, 1.2f, -1.1f }, { 0.2f, 0, 2.2f } };
    static const float up[3] = { 0, 1, 0 };
    sfield_entity chain[2];
    sfield_algebra *algebra;
    sfield_scene *s;
    double worst = 0, alone = 0;
    int i, k;
    (void)state;
    chain[0] = ball_at(-2.2, 0, 0);
    chain[1] = ball_at(2.2, 0, 0);
    s = scene_of(chain, 2);
    assert_int_equal(sfield_algebra_create(BANDS, NULL, &algebra), SFIELD_OK);
    for (i = 0; i < 4; i++) {
        double to[2][3];
        float a[COEFS], b[COEFS], truth[COEFS], coefs[3 * COEFS];
        for (k = 0; k < 3; k++) {
            to[0][k] = (double)(chain[0].transform[12 + k] - places[i][k]);
            to[1][k] = (double)(chain[1].transform[12 + k] - places[i][k]);
        }
        visibility_of_cone(to[0], a);
        visibility_of_cone(to[1], b);
        sfield_sh_product(algebra, 1, a, b, truth, 1);
        assert_int_equal(sfield_incident(s, AT(places[i], up, 1), coefs), SFIELD_OK);
        for (k = 0; k < COEFS; k++) {
            worst = fmax(worst, fabs((double)(coefs[k] - truth[k])));
            alone = fmax(alone, fabs((double)(a[k] - truth[k])));
        }
    }
    printf("between two balls: coefficients off by %.4f at most, of one ball alone by %.3f\n", worst, alone);
    assert_true(worst < 0.03);                  /* of 3.5; shells between shells: 0.02 of a ball's own (T72) */
    assert_true(alone > 0.3);
    below_two_bones_each_hides_its_own(s);
    sfield_algebra_free(algebra);
    sfield_scene_free(s);
}

/* A point on a ball sees a disjoint ball at distance d: 1 / d^2 of its light is hidden where it faces the middle. */
static void a_bone_does_not_hide_its_own_points(void **state)
{
    static const float place[3] = { 1, 0, 0 }, normal[3] = { 1, 0, 0 };
    sfield_entity chain[2];
    sfield_points set = *AT(place, normal, 1);
    sfield_scene *s;
    float lit, own;
    (void)state;
    chain[0] = ball_at(3, -1, 2);               /* points move with their bone */
    chain[1] = ball_at(7, -1, 2);
    s = scene_of(chain, 2);
    set.ambient = &lit;
    set.entity = 1;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    chain[1] = ball_at(300, 0, 0);
    assert_int_equal(sfield_scene_entities(s, chain, 2), SFIELD_OK);
    set.ambient = &own;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    printf("on a ball: %.4f before the next one, 8/9 = 0.8889; %.4f alone\n", (double)lit, (double)own);
    assert_true(fabs((double)lit - 8 / 9.0) < 0.01);
    assert_true(fabs((double)own - 1) < 1e-3);
    sfield_scene_free(s);
}

/* Points of each bone of a chain, as entity of that bone: as in a scene without that bone, where they stand in the
   world. With the bone, and not on it, they are darker. */
static void an_entity_leaves_out_itself_alone(void **state)
{
    sfield_entity chain[CHAIN], others[CHAIN];
    uint64_t seed = 5;
    int bone, i, k, l;
    (void)state;
    for (bone = 0; bone < CHAIN; bone++) {
        chain[bone] = upright;
        chain[bone].occlusion = bone & 1 ? limb : ball;
        matrix_of(chain[bone].transform, rnd(&seed), rnd(&seed), rnd(&seed), 6 * rnd(&seed), 0.5 + 0.3 * rnd(&seed),
                  1.3 * bone, rnd(&seed), rnd(&seed));
    }
    for (bone = 0; bone < CHAIN; bone++) {
        float local[3 * 40], normals[3 * 40], world[3 * 40], turned[3 * 40], as[40], without[40], with[40];
        const float *m = chain[bone].transform;
        double scale = sqrt((double)(m[0] * m[0] + m[1] * m[1] + m[2] * m[2])), off = 0, darker = 0;
        sfield_points set;
        sfield_scene *s;
        for (i = 0; i < 40; i++) {
            double n[3];
            rnd_direction(&seed, n);
            for (k = 0; k < 3; k++) local[3 * i + k] = (float)(1.02 * n[k]);
            rnd_direction(&seed, n);            /* which may look at its own bone, too */
            for (k = 0; k < 3; k++) normals[3 * i + k] = (float)n[k];
            for (k = 0; k < 3; k++) {
                world[3 * i + k] = m[12 + k];
                turned[3 * i + k] = 0;
                for (l = 0; l < 3; l++) {
                    world[3 * i + k] += m[4 * l + k] * local[3 * i + l];
                    turned[3 * i + k] += m[4 * l + k] * normals[3 * i + l] / (float)scale;
                }
            }
        }
        s = scene_of(chain, CHAIN);
        set = *AT(local, normals, 40);
        set.entity = (uint32_t)bone + 1;
        set.ambient = as;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        set = *AT(world, turned, 40);
        set.ambient = with;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        for (i = k = 0; i < CHAIN; i++)
            if (i != bone) others[k++] = chain[i];
        assert_int_equal(sfield_scene_entities(s, others, CHAIN - 1), SFIELD_OK);
        set.ambient = without;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        for (i = 0; i < 40; i++) {
            off = fmax(off, fabs((double)(as[i] - without[i])));
            darker = fmax(darker, fabs((double)(as[i] - with[i])));
        }
        assert_true(off < 1e-4);
        assert_true(darker > 0.02);
        sfield_scene_free(s);
    }
}

/* ---- self-visibility that turns with its bone ---- */

/* A shelf over a table, open to +x: a part that hides half the sky from its own points. */
static model model_shelf(void)
{
    model table = model_box(1, 0.05, 1), wall = model_box(0.05, 0.6, 1);
    model m = model_alloc(table.vertices + wall.vertices, (table.indices + wall.indices) / 3);
    size_t i;
    memcpy(m.p, table.p, 3 * table.vertices * sizeof *m.p);
    memcpy(m.i, table.i, table.indices * sizeof *m.i);
    for (i = 0; i < wall.vertices; i++) {
        m.p[3 * (table.vertices + i)] = wall.p[3 * i] - 0.8f;
        m.p[3 * (table.vertices + i) + 1] = wall.p[3 * i + 1] + 0.7f;
        m.p[3 * (table.vertices + i) + 2] = wall.p[3 * i + 2];
    }
    for (i = 0; i < wall.indices; i++) m.i[table.indices + i] = wall.i[i] + (uint32_t)table.vertices;
    model_free(&table);
    model_free(&wall);
    return m;
}

/* Points of the shelf's table under a sky that is bright on one side, in the world. */
static void light_shelf(const float *transform, const sfield_field *self, const float *positions, const float *normals,
                        float *rgb)
{
    static const float sky[4 * 3] = { 2, 2, 2, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 2, 2, 2 };    /* bright to -x */
    sfield_entity bones[2];
    sfield_points set;
    sfield_scene *s;
    bones[0] = ball_at(500, 0, 0);              /* far away, and not turned */
    bones[1] = ball_at(0, 0, 0);                /* hides nothing of its own points */
    memcpy(bones[1].transform, transform, sizeof bones[1].transform);
    s = scene_of(bones, 2);
    assert_int_equal(sfield_scene_environment(s, sky, 4, 1, NULL), SFIELD_OK);
    set = *AT(positions, normals, 16);
    set.entity = 2;
    set.self = self;
    set.rgb = rgb;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    sfield_scene_free(s);
}

static void self_visibility_turns_with_its_bone(void **state)
{
    model m = model_shelf();
    sfield_mesh mesh = mesh_of(&m);
    float p[3 * 16], n[3 * 16] = { 0 }, matrix[16], rgb[48], baked[48], still[48];
    sfield_field *self, *turned;
    double off = 0, mean = 0, moved = 0;
    size_t i, v;
    int k, l;
    (void)state;
    for (i = 0; i < 16; i++) {
        p[3 * i] = -0.7f + 0.09f * (float)i;
        p[3 * i + 1] = 0.05f;
        p[3 * i + 2] = 0.3f;
        n[3 * i + 1] = 1;
    }
    assert_int_equal(sfield_build_self(NULL, &mesh, AT(p, n, 16), 1e-3f, &self, NULL), SFIELD_OK);
    light_shelf(upright.transform, self, p, n, still);
    matrix_of(matrix, 0.2, 1, 0.3, 2.4, 1, 0, 0, 0);
    light_shelf(matrix, self, p, n, rgb);
    /* the same by force: mesh and points turned before, and the bone left as it is */
    for (v = 0; v < m.vertices; v++) {
        float q[3];
        memcpy(q, m.p + 3 * v, sizeof q);
        for (k = 0; k < 3; k++)
            for (m.p[3 * v + (size_t)k] = 0, l = 0; l < 3; l++) m.p[3 * v + (size_t)k] += matrix[4 * l + k] * q[l];
    }
    for (i = 0; i < 16; i++) {
        float q[3];
        memcpy(q, p + 3 * i, sizeof q);
        for (k = 0; k < 3; k++) {
            n[3 * i + (size_t)k] = matrix[4 + k];
            for (p[3 * i + (size_t)k] = 0, l = 0; l < 3; l++) p[3 * i + (size_t)k] += matrix[4 * l + k] * q[l];
        }
    }
    assert_int_equal(sfield_build_self(NULL, &mesh, AT(p, n, 16), 1e-3f, &turned, NULL), SFIELD_OK);
    light_shelf(upright.transform, turned, p, n, baked);
    for (i = 0; i < 16; i++) {
        off = fmax(off, fabs((double)(rgb[3 * i] - baked[3 * i])));
        moved = fmax(moved, fabs((double)(rgb[3 * i] - still[3 * i])));
        mean += (double)baked[3 * i] / 16;
    }
    printf("a shelf that turns: off by %.4f of %.3f from one that was turned before; turning changes %.3f\n", off, mean,
           moved);
    assert_true(off < 0.03 * mean + 0.005);
    assert_true(moved > 0.2);
    sfield_free(self);
    sfield_free(turned);
    model_free(&m);
}

/* ---- joints ---- */

/* How far p is off a capsule from a to b. */
static double off_limb(const double *a, const double *b, const double *p)
{
    double along = 0, length = 0, sum = 0;
    int k;
    for (k = 0; k < 3; k++) {
        along += (p[k] - a[k]) * (b[k] - a[k]);
        length += (b[k] - a[k]) * (b[k] - a[k]);
    }
    along = fmin(fmax(along / length, 0), 1);
    for (k = 0; k < 3; k++) {
        double d = p[k] - a[k] - along * (b[k] - a[k]);
        sum += d * d;
    }
    return sqrt(sum) - limb_radius;
}

/* The cosine-weighted share of directions about n that a capsule leaves open, by steps as long as nothing is near. */
static double open_beside(const double *a, const double *b, const double *p, const double *n)
{
    enum { RAYS = 512 };
    uint64_t seed = 3;
    int i, k, lit = 0;
    for (i = 0; i < RAYS; i++) {
        double d[3], at[3], length = 0, way = 0, step = 1;
        rnd_direction(&seed, d);
        for (k = 0; k < 3; k++) length += (d[k] + n[k]) * (d[k] + n[k]);
        for (k = 0; k < 3; k++) d[k] = (d[k] + n[k]) / sqrt(length);     /* by the cosine */
        memcpy(at, p, sizeof at);
        for (; way < 6 && step > 1e-4; way += step) {
            step = off_limb(a, b, at);
            for (k = 0; k < 3; k++) at[k] += step * d[k];
        }
        lit += step > 1e-4;
    }
    return (double)lit / RAYS;
}

/* A lower arm on an upper arm, bent by an angle: its points lie in the upper arm's bounding sphere, next to it. */
static void points_at_a_joint_are_neither_black_nor_lit_through(double angle)
{
    static float places[3 * MOST], normals[3 * MOST], ambient[MOST];
    static const double joint[3] = { 0, 0, 0 }, end[3] = { 0, -1, 0 };
    const double way[3] = { sin(angle), -cos(angle), 0 };
    sfield_entity upper = upright, lower = upright;
    sfield_entity arm[2];
    sfield_points set;
    sfield_scene *s;
    double square = 0, worst = 0, bias = 0;
    uint64_t seed = 11;
    int count = 0, i, k;
    upper.occlusion = lower.occlusion = limb;
    matrix_of(lower.transform, 0, 0, 1, angle, 1, 0, 0, 0);
    while (count < MOST) {
        double n[3], p[3], to[3] = { rnd(&seed), 0, 0 };
        rnd_direction(&seed, n);
        to[1] = n[0] * way[0] + n[1] * way[1];
        for (k = 0; k < 3; k++) n[k] -= to[1] * way[k];
        to[2] = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (k = 0; k < 3; k++) {
            n[k] /= to[2];
            p[k] = to[0] * way[k] + limb_radius * n[k];
        }
        if (off_limb(joint, end, p) < 0.004) continue;          /* in the upper arm nobody sees it */
        for (k = 0; k < 3; k++) {
            normals[3 * count + k] = (float)n[k];
            places[3 * count + k] = (float)p[k];
        }
        count++;
    }
    arm[0] = upper;
    arm[1] = lower;
    s = scene_of(arm, 2);
    for (i = 0; i < count; i++) {               /* into the space of the lower arm, which is turned about z */
        float *q = places + 3 * i, *n = normals + 3 * i, x = q[0], y = n[0];
        const float c = (float)cos(angle), sn = (float)sin(angle);
        q[0] = c * x + sn * q[1];
        q[1] = c * q[1] - sn * x;
        n[0] = c * y + sn * n[1];
        n[1] = c * n[1] - sn * y;
    }
    set = *AT(places, normals, (size_t)count);
    set.entity = 2;
    set.ambient = ambient;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    for (i = 0; i < count; i++) {
        const float *q = places + 3 * i, *m = normals + 3 * i;
        const double c = cos(angle), sn = sin(angle);
        double p[3] = { c * (double)q[0] - sn * (double)q[1], sn * (double)q[0] + c * (double)q[1], (double)q[2] };
        double n[3] = { c * (double)m[0] - sn * (double)m[1], sn * (double)m[0] + c * (double)m[1], (double)m[2] };
        double off = (double)ambient[i] - open_beside(joint, end, p, n);
        square += off * off / count;
        bias += off / count;
        worst = fmax(worst, fabs(off));
    }
    printf("a joint bent by %.0f degrees: rmse %.3f, bias %.3f, worst %.2f\n", angle * 180 / PI, sqrt(square), bias,
           worst);
    assert_true(sqrt(square) < 0.03);
    assert_true(fabs(bias) < 0.02);
    assert_true(worst < 0.2);
    sfield_scene_free(s);
}

static void joints_are_shaded_at_any_angle(void **state)
{
    (void)state;
    points_at_a_joint_are_neither_black_nor_lit_through(2.6);
    points_at_a_joint_are_neither_black_nor_lit_through(1.57);
    points_at_a_joint_are_neither_black_nor_lit_through(0.7);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(between_two_bones_the_cones_are_multiplied),
                                        cmocka_unit_test(a_bone_does_not_hide_its_own_points),
                                        cmocka_unit_test(an_entity_leaves_out_itself_alone),
                                        cmocka_unit_test(self_visibility_turns_with_its_bone),
                                        cmocka_unit_test(joints_are_shaded_at_any_angle) };
    return cmocka_run_group_tests(tests, make_fields, free_fields);
}
