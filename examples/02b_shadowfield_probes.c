/* 02b_shadowfield_probes.c - what a renderer does with shadowfield.h beside vertices: light probes, occluders that are
   no meshes, harmonics and wavelets of its own.

   cc -O2 02b_shadowfield_probes.c -lm -o probes && ./probes

   A ball that this program traces itself hides a part of a sky. Probes around it keep the light from all directions,
   from which any surface can be lit; a floor is shaded at few points and interpolated; and three shadows are multiplied
   in four ways, which say how much harmonics of few bands lose. */
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BANDS = 4, COEFS = BANDS * BANDS, PROBES = 3, GRID = 24, SIDE = 16, TEXELS = 6 * SIDE * SIDE };

/* Does a ray from a point hit the ball of radius 1 about the origin? Alpha 1 or 0. */
static void ball(void *user, float time, const float position[3], const float direction[3], float rgb[3])
{
    float along = 0, size2 = 0;
    (void)user;
    (void)time;
    for (int k = 0; k < 3; k++) {
        along += position[k] * direction[k];
        size2 += position[k] * position[k];
    }
    rgb[0] = size2 < 1 || (along < 0 && size2 - along * along < 1) ? 1.0f : 0.0f;
}

/* A field of the ball, and a scene with it under a sky that is bright above and dim below. */
static int make_scene(sfield_field **field, sfield_scene **scene)
{
    static const float sky[2 * 3] = { 1, 1, 1.2f, 0.2f, 0.2f, 0.2f };     /* two rows: the upper half, the lower */
    sfield_entity entity;
    sfield_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(&entity, 0, sizeof entity);
    desc.radius = 1;
    desc.shell_count = desc.position_side = 8;
    if (sfield_build_callback(&desc, ball, NULL, field, NULL) != SFIELD_OK) return -1;
    entity.occlusion = *field;
    return sfield_scene_create(NULL, scene) == SFIELD_OK && sfield_scene_entities(*scene, &entity, 1) == SFIELD_OK &&
           sfield_scene_environment(*scene, sky, 1, 2, NULL) == SFIELD_OK ? 0 : -1;
}

/* Irradiance on a surface: windowed, so that it is nowhere negative, and convolved with the cosine. */
static float irradiance_of(const float *light, const double normal[3])
{
    float window[SFIELD_MAX_BANDS], cosine[SFIELD_MAX_BANDS], sum = 0;
    double basis[COEFS];
    sfield_sh_window(BANDS, sfield_sh_window_fit(BANDS, light, 0), window);
    sfield_sh_cosine(BANDS, cosine);
    sfield_sh_basis(BANDS, normal, basis);
    for (int l = 0, k = 0; l < BANDS; l++)
        for (; k < (l + 1) * (l + 1); k++) sum += window[l] * cosine[l] * light[k] * (float)basis[k];
    return sum;
}

/* Probes below, above and within the ball; those that see nothing are left out. */
static int light_probes(const sfield_field *field, sfield_scene *scene)
{
    static const float places[3 * PROBES] = { 0, -1.5f, 0, 0, 1.5f, 0, 0.1f, 0, 0 };
    static const float ups[3 * PROBES] = { 0, 1, 0, 0, 1, 0, 0, 1, 0 };
    static const double up[3] = { 0, 1, 0 };
    static float light[PROBES * 3 * COEFS];
    float open[PROBES], red[PROBES];
    sfield_points probes;
    memset(&probes, 0, sizeof probes);
    probes.count = PROBES;
    probes.positions = places;
    probes.normals = ups;
    if (sfield_ambient(field, PROBES, places, open) != SFIELD_OK ||
        sfield_incident(scene, &probes, light) != SFIELD_OK)
        return -1;
    for (int i = 0; i < PROBES; i++) {
        red[i] = irradiance_of(light + i * 3 * COEFS, up);
        printf("probe %d: %.0f %% of all directions open, %.2f W/m^2 from above%s\n", i, 100 * (double)open[i],
               (double)red[i], open[i] < 0.05f ? " (within the ball: left out)" : "");
    }
    return open[0] > 0.5f && open[2] < 0.05f && red[0] < 0.8f * red[1] ? 0 : -1;
}

/* A floor below the ball: one point in each square of 0.5 is shaded, the others take what these get. */
static int light_floor(sfield_scene *scene)
{
    enum { POINTS = GRID * GRID };
    static float places[3 * POINTS], normals[3 * POINTS];
    static float all[3 * POINTS], few[3 * POINTS], spread[3 * POINTS];
    static float few_places[3 * POINTS], weights[3 * POINTS];
    static uint32_t chosen[POINTS], sources[3 * POINTS];
    float worst = 0;
    size_t count = 0;
    sfield_points whole, some;
    for (int i = 0; i < POINTS; i++) {
        places[3 * i] = 4.0f * (float)(i % GRID) / GRID - 2;
        places[3 * i + 1] = -1.2f;
        places[3 * i + 2] = 4.0f * (float)(i / GRID) / GRID - 2;
        normals[3 * i + 1] = 1;
    }
    memset(&whole, 0, sizeof whole);
    whole.count = POINTS;
    whole.positions = places;
    whole.normals = normals;
    whole.rgb = all;
    if (sfield_sparse(&whole, 0.5f, NULL, chosen, &count, sources, weights) != SFIELD_OK) return -1;
    for (size_t i = 0; i < count; i++) memcpy(few_places + 3 * i, places + 3 * chosen[i], 3 * sizeof *places);
    some = whole;
    some.count = count;
    some.positions = few_places;
    some.rgb = few;
    if (sfield_shade(scene, &whole, 1, NULL) != SFIELD_OK || sfield_shade(scene, &some, 1, NULL) != SFIELD_OK ||
        sfield_spread(POINTS, sources, weights, count, few, spread) != SFIELD_OK)
        return -1;
    for (int i = 0; i < 3 * POINTS; i++) worst = fmaxf(worst, fabsf(all[i] - spread[i]));
    printf("floor: %u of %d points shaded, the others off by %.3f at most\n", (unsigned)count, POINTS, (double)worst);
    return worst < 0.2f ? 0 : -1;
}

/* Visibility beside three half spaces, as texels and as harmonics. */
static void project_walls(float texels[3][TEXELS], float coefs[3][COEFS])
{
    static const float away[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0.6f, 0, 0.8f } };
    for (int w = 0; w < 3; w++) {
        for (uint32_t i = 0; i < TEXELS; i++) {
            float d[3];
            sfield_cube_texel(SIDE, i, d);
            texels[w][i] = away[w][0] * d[0] + away[w][1] * d[1] + away[w][2] * d[2] > -0.3f ? 1.0f : 0.0f;
        }
        sfield_sh_project(BANDS, SIDE, texels[w], 1, coefs[w]);
    }
}

/* What a renderer on a GPU does, with tables that are uploaded once: the integrals of the basis over each texel project
   a cube, and a list of terms multiplies two functions. Returns the largest difference from the library's own. */
static float by_tables(const sfield_algebra *algebra, const float *texels, const float *a, const float *b)
{
    static uint32_t terms[256];
    static float factors[256], row[COEFS];
    float projected[COEFS] = { 0 }, product[COEFS] = { 0 }, own[COEFS], worst = 0;
    const size_t count = sfield_sh_terms(algebra, NULL, NULL);
    if (count > sizeof factors / sizeof *factors) return 1;
    for (uint32_t texel = 0; texel < TEXELS; texel++) {
        sfield_cube_basis(BANDS, SIDE, texel, row);
        for (int k = 0; k < COEFS; k++) projected[k] += texels[texel] * row[k];
    }
    sfield_sh_terms(algebra, terms, factors);
    for (int k = 0; k < COEFS; k++) {
        if (k) product[k] = 0.282094792f * (a[0] * b[k] + a[k] * b[0]);
        product[0] += 0.282094792f * a[k] * b[k];
    }
    for (size_t t = 0; t < count; t++) {
        const uint32_t i = terms[t] & 255, j = terms[t] >> 8 & 255, k = terms[t] >> 16;
        product[k] += factors[t] * (i == j ? a[i] * b[i] : a[i] * b[j] + a[j] * b[i]);
    }
    sfield_sh_product(algebra, 1, a, b, own, 1);
    for (int k = 0; k < COEFS; k++) {
        worst = fmaxf(worst, fabsf(product[k] - own[k]));
        worst = fmaxf(worst, fabsf(projected[k] - a[k]));
    }
    return worst;
}

/* Looks up which of two suns is seen beside the walls: what stands in the texels that they fall into. */
static int see_suns(const float *visible)
{
    static const float suns[2][3] = { { 2, 3, 1 }, { 1, -1, 0.5f } };
    const float first = visible[sfield_cube_find(SIDE, suns[0])], second = visible[sfield_cube_find(SIDE, suns[1])];
    printf("of a sun above them %.2f is seen, of one below %.2f\n", (double)first, (double)second);
    return fabsf(first - 1) < 1e-4f && fabsf(second) < 1e-4f;
}

/* Prints what is left of all directions, by four ways to multiply. */
static int multiply_walls(void)
{
    static float texels[3][TEXELS], wavelets[3][TEXELS], product[TEXELS], coefs[3][COEFS];
    float chain[COEFS], logs[COEFS] = { 0 }, one[COEFS];
    float exact = 0, haar = 0, rest = 0, off;
    float direction[3];
    const float share = 0.282094792f;           /* first coefficient to share of the sphere */
    double unprojected[COEFS];
    sfield_algebra *algebra;
    project_walls(texels, coefs);
    for (uint32_t i = 0; i < TEXELS; i++)
        exact += sfield_cube_texel(SIDE, i, direction) * texels[0][i] * texels[1][i] * texels[2][i] / 12.5663706f;
    if (sfield_algebra_create(BANDS, NULL, &algebra) != SFIELD_OK) return -1;
    off = by_tables(algebra, texels[0], coefs[0], coefs[1]);
    sfield_sh_product(algebra, 1, coefs[0], coefs[1], chain, 1);
    sfield_sh_dot(BANDS, 1, chain, coefs[2], &rest, 1);     /* of the last product the integral is enough */
    for (int w = 0; w < 3; w++) {
        sfield_sh_log(algebra, coefs[w], one);
        for (int k = 0; k < COEFS; k++) logs[k] += one[k];
        sfield_haar_forward(SIDE, texels[w], wavelets[w]);
    }
    sfield_sh_exp(algebra, 1, logs, logs, 1);
    sfield_sh_product_n(BANDS, 3, coefs[0], NULL, unprojected);
    sfield_haar_product(SIDE, wavelets[0], wavelets[1], product);
    sfield_haar_product(SIDE, product, wavelets[2], texels[0]);
    sfield_haar_inverse(SIDE, texels[0], product);
    for (uint32_t i = 0; i < TEXELS; i++) haar += sfield_cube_texel(SIDE, i, direction) * product[i] / 12.5663706f;
    sfield_algebra_free(algebra);
    printf("three walls leave %.4f of all directions: wavelets %.4f; harmonics of %d bands %.4f by products of two,\n"
           "%.4f by one product of three, %.4f by logarithms\n", (double)exact, (double)haar, BANDS,
           (double)(share * share * rest), (double)share * unprojected[0], (double)(share * logs[0]));
    printf("by tables as a GPU has them: off by %.1e at most\n", (double)off);
    return off < 1e-4f && fabsf(haar - exact) < 1e-4f && fabsf(share * share * rest - exact) < 0.05f &&
           see_suns(product) ? 0 : -1;
}

/* Light of a probe in the space of an object that is turned: one matrix, any number of vectors. */
static int turn_light(void)
{
    static const float quarter[16] = { 0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1 };   /* z to x, about y */
    static const double z[3] = { 0, 0, 1 }, x[3] = { 1, 0, 0 };
    float light[COEFS] = { 1, 0.2f, 0.5f, 0.1f }, turned[COEFS];
    sfield_rotation rotation;
    sfield_algebra *algebra;
    float before, after;
    if (sfield_algebra_create(BANDS, NULL, &algebra) != SFIELD_OK) return -1;
    sfield_sh_rotation(algebra, quarter, &rotation);
    sfield_sh_rotate(&rotation, 1, light, turned, 1);
    sfield_algebra_free(algebra);
    before = irradiance_of(light, z);
    after = irradiance_of(turned, x);
    printf("light from z %.4f, once turned from x %.4f\n", (double)before, (double)after);
    return fabsf(before - after) < 1e-4f ? 0 : -1;
}

int main(void)
{
    sfield_field *field = NULL;
    sfield_scene *scene = NULL;
    int bad = make_scene(&field, &scene) != 0 || light_probes(field, scene) != 0 || light_floor(scene) != 0;
    bad = multiply_walls() != 0 || turn_light() != 0 || bad;
    sfield_scene_free(scene);
    sfield_free(field);
    if (bad) printf("something is not as it should be\n");
    return bad;
}
