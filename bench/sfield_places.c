/* sfield_places.c - the error of interpolation at equal memory: shells as the paper spaces them, as the default does,
   and placed by measured error; and what sfield_place chooses for bounds. Visibility of a real model
   from 1.1 to 8 r, in harmonics, beside what is seen at 640 places that nobody measured. RMS over all directions. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RADII = 32, AROUND = 20, PLACES = RADII * AROUND, SIDE = 16, CELLS = 6 * SIDE * SIDE };

typedef struct truth { float place[3 * PLACES], seen[16 * PLACES]; } truth;

static sfield_desc desc_of(const bn_options *options)
{
    sfield_desc d = bn_sfield_desc(options);
    d.inner = 1.1f;
    d.outer = 8;
    return d;
}

/* Looks from places all round the mesh: wavelets keep what points see, texel by texel. */
static int look(const bn_options *options, const sfield_mesh *mesh, truth *t)
{
    static float up[3 * PLACES], texels[CELLS];
    sfield_desc d = bn_sfield_desc(options);
    sfield_field *field = NULL;
    sfield_info info;
    uint64_t seed = 5;
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = SIDE;
    d.keep = 1;
    d.shell_count = d.position_side = 2;
    if (sfield_build(&d, mesh, &field, NULL) != SFIELD_OK)
        return -1;
    sfield_get_info(field, &info);
    sfield_free(field);
    field = NULL;
    for (int i = 0; i < PLACES; i++) {
        const double r = 1.1 * pow(8 / 1.1, (i / AROUND + 0.5) / RADII), z = 2 * bn_random(&seed) / 4294967296.0 - 1;
        const double phi = 6.283185307 * bn_random(&seed) / 4294967296.0, s = sqrt(1 - z * z);
        const double dir[3] = { s * cos(phi), s * sin(phi), z };
        for (int k = 0; k < 3; k++)
            t->place[3 * i + k] = info.center[k] + (float)(r * dir[k]) * info.radius;
        up[3 * i + 1] = 1;
    }
    if (sfield_build_self(&d, mesh, &(const sfield_points){ .count = PLACES, .positions = t->place, .normals = up },
                          0, &field, NULL) != SFIELD_OK)
        return -1;
    for (size_t i = 0; i < PLACES; i++) {
        sfield_self(field, i, 1, texels);
        for (int k = 0; k < CELLS; k++)
            texels[k] = 1 - texels[k];
        sfield_sh_project(4, SIDE, texels, 1, t->seen + 16 * i);
    }
    sfield_free(field);
    return 0;
}

typedef struct choice { const char *shells; double bound, measured, seconds; } choice;

static int report(const bn_options *options, const char *name, const choice *c, const sfield_desc *d,
                  const sfield_mesh *mesh, const truth *t)
{
    static float v[16 * PLACES];
    sfield_field *field = NULL;
    double worst = 0, all = 0;
    if (sfield_build(d, mesh, &field, NULL) != SFIELD_OK || sfield_query(field, PLACES, t->place, 0, v) != SFIELD_OK) {
        sfield_free(field);
        return bn_failed("sfield_places", "a field");
    }
    for (int i = 0; i < RADII; i++) {
        double sum = 0;
        for (int j = 16 * AROUND * i; j < 16 * AROUND * (i + 1); j++)
            sum += ((double)v[j] - (double)t->seen[j]) * ((double)v[j] - (double)t->seen[j]);
        sum /= 12.566370614 * AROUND;
        all += sum / RADII;
        worst = sum > worst ? sum : worst;
    }
    bn_begin(options, "sfield_places", options->threads, bn_sfield_simd());
    bn_text("object", name);
    bn_text("shells", c->shells);
    bn_number("bound", c->bound);
    bn_integer("shell_count", d->shell_count);
    bn_integer("position_side", d->position_side);
    bn_integer("bytes", sfield_bytes(field));
    bn_number("place_seconds", c->seconds);
    bn_number("measured", c->measured);
    bn_number("rms", sqrt(all));
    bn_number("rms_at_worst_radius", sqrt(worst));
    bn_end(options);
    sfield_free(field);
    return 0;
}

/* bound 0: so many shells, as good as they can be. */
static int placed(const bn_options *options, const char *name, float bound, uint32_t shells, const sfield_mesh *mesh,
                  const truth *t)
{
    sfield_desc d = desc_of(options);
    sfield_placement p;
    choice c = { "placed", (double)bound, 0, ex_seconds() };
    d.shell_count = shells;
    d.position_side = shells ? 24 : 0;
    if (sfield_place(&d, mesh, NULL, bound, &p) != SFIELD_OK)
        return bn_failed("sfield_places", "sfield_place");
    c.seconds = ex_seconds() - c.seconds;
    c.measured = (double)(p.between + p.across);
    d.shell_count = p.shell_count;
    d.radii = p.radii;
    d.position_side = p.position_side;
    return report(options, name, &c, &d, mesh, t);
}

static int measure(const bn_options *options, const char *scene)
{
    static const float bounds[2] = { 0.1f, 0.05f };
    static const choice paper = { "paper", 0, 0, 0 }, even = { "default", 0, 0, 0 };
    static truth t;
    bn_model model;
    sfield_mesh mesh;
    int result;
    if (bn_model_load(&model, scene) != 0)
        return -1;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = model.positions;
    mesh.vertex_count = model.vertices;
    mesh.indices = model.indices;
    mesh.index_count = 3 * model.triangles;
    result = look(options, &mesh, &t) != 0 ? bn_failed("sfield_places", "views") : 0;
    for (uint32_t shells = 6; shells <= 12 && result == 0; shells *= 2) {
        sfield_desc d = desc_of(options);
        d.shell_count = shells;
        d.position_side = 24;
        d.spacing = SFIELD_SPACING_UNIFORM;
        result = report(options, model.name, &paper, &d, &mesh, &t);
        d.spacing = SFIELD_SPACING_GEOMETRIC;
        result = result == 0 ? report(options, model.name, &even, &d, &mesh, &t) : result;
        result = result == 0 ? placed(options, model.name, 0, shells, &mesh, &t) : result;
    }
    for (int i = 0; i < 2 && result == 0; i++)
        result = placed(options, model.name, bounds[i], 0, &mesh, &t);
    bn_model_free(&model);
    return result;
}

int bn_sfield_places(const bn_options *options)
{
    char path[1024];
    const char *scene = options->model ? options->model : bn_asset(options, "teapot.glb", NULL, path);
    return measure(options, scene ? scene : "builtin:knot");
}
