/* making.h - maps of a model, queries, placed instances and clouds of these in one call each. Include csm.h, cmocka.h
   and csm/util.h before. */
#ifndef CSM_MAKING_H
#define CSM_MAKING_H

UNUSED_OK cohsm_maps *build(const cohsm_desc *d, const model *m)
{
    cohsm_mesh mesh = mesh_of(m);
    cohsm_maps *maps = NULL;
    assert_int_equal(cohsm_build(d, &mesh, &maps, NULL), COHSM_OK);
    return maps;
}

UNUSED_OK cohsm_query query_of(const float *points, size_t count, const void *lights, cohsm_light_kind light,
                            cohsm_filter filter)
{
    cohsm_query q = { 0 };
    q.positions = points;
    q.count = count;
    q.lights = lights;
    q.light_kind = light;
    q.filter = filter;
    return q;
}

UNUSED_OK void identity(float *m)
{
    memset(m, 0, 64);
    m[0] = m[5] = m[10] = m[15] = 1;
}

/* Rotation about a random axis, scale, translation. */
UNUSED_OK void placed(float *m, uint64_t *seed, double scale)
{
    float axis[3];
    double a = rnd_in(seed, 0, 2 * PI), c = cos(a), s = sin(a), x, y, z;
    rnd_direction(seed, axis);
    x = (double)axis[0];
    y = (double)axis[1];
    z = (double)axis[2];
    identity(m);
    m[0] = (float)(scale * (c + x * x * (1 - c)));
    m[1] = (float)(scale * (y * x * (1 - c) + z * s));
    m[2] = (float)(scale * (z * x * (1 - c) - y * s));
    m[4] = (float)(scale * (x * y * (1 - c) - z * s));
    m[5] = (float)(scale * (c + y * y * (1 - c)));
    m[6] = (float)(scale * (z * y * (1 - c) + x * s));
    m[8] = (float)(scale * (x * z * (1 - c) + y * s));
    m[9] = (float)(scale * (y * z * (1 - c) - x * s));
    m[10] = (float)(scale * (c + z * z * (1 - c)));
    m[12] = (float)rnd_in(seed, -5, 5);
    m[13] = (float)rnd_in(seed, -5, 5);
    m[14] = (float)rnd_in(seed, -5, 5);
}

/* Maps of six kinds: fine and coarse directions, an octahedron of them, cells too wide to be tested by spheres, maps
   that are for their own points alone, and four texels for many directions. */
enum { KINDS = 6 };

UNUSED_OK void build_kinds(cohsm_maps *maps[KINDS])
{
    static const uint32_t sides[KINDS][2] = { { 24, 12 }, { 9, 5 }, { 12, 12 }, { 3, 2 }, { 16, 8 }, { 96, 48 } };
    static const uint32_t texels[KINDS] = { 32, 16, 24, 16, 16, 4 };
    int i;
    for (i = 0; i < KINDS; i++) {
        model m = i % 2 ? model_cube(0.6, 1) : model_sphere(14, 9, 0.3);
        cohsm_desc d = desc_of(i == 2 ? COHSM_DOMAIN_OCTAHEDRAL : COHSM_DOMAIN_LATLONG, sides[i][0], texels[i]);
        d.domain.side[1] = sides[i][1];
        d.self_only = i == 4;
        maps[i] = build(&d, &m);
        model_free(&m);
    }
}

/* Instances of these maps in a cloud `wide` across around `middle`, of sizes from a quarter to four. */
UNUSED_OK void place_instances(cohsm_instance *instances, int count, cohsm_maps *const maps[KINDS], uint64_t *seed,
                               double wide, double middle)
{
    int i, c;
    for (i = 0; i < count; i++) {
        instances[i].maps = maps[i % KINDS];
        placed(instances[i].transform, seed, exp(rnd_in(seed, -1.4, 1.4)));
        for (c = 12; c < 15; c++) instances[i].transform[c] = (float)(middle + rnd_in(seed, -wide, wide));
    }
}

#endif
