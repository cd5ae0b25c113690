/* shadowfield.c - bake's technique shadowfield: what an object hides, or what it shines, whose units are shells; or
   what it hides from its own points, which is one unit. */
#include "shadowfield.h"
#include "bake.h"
#include "../render/shadowfield_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const kinds[] = { "none", "occlusion", "source", "self" };

static const rd_key keys[] = {
    { "kind", RD_WORD, "occlusion|source|self|lamp|sky", 0, 0, "occlusion",
      "what the object hides, what its emissive triangles shine, or what it hides from its own points; or what a lamp "
      "shines, given in place of SCENE as render's --light, or a sky, given as render's --env" },
    { "frames", RD_INTEGER, NULL, 1, 256, "1", "kind=source: pictures of an animated scene, a built-in one" },
    { "fps", RD_NUMBER, NULL, 1e-6, 1e6, "30", "of these, a second" },
    { "loop", RD_WORD, "0|1", 0, 0, "0", "1: after the last picture comes the first; 0: the last one stays" },
    { "lamp_radius", RD_NUMBER, NULL, 0, 1e9, "0", "kind=lamp: of a point or spot" },
    { "point_spacing", RD_NUMBER, NULL, 0, 1, "0", "kind=self: that of render; 0: the vertices, in their order" },
    { "basis", RD_WORD, "sh|haar", 0, 0, "sh", "spherical harmonics or Haar wavelets" },
    { "bands", RD_INTEGER, NULL, 1, 8, "4", "of harmonics" },
    { "shell_count", RD_INTEGER, "0", 2, 64, "0", "of a field; 0: 16, with wavelets 32" },
    { "position_side", RD_INTEGER, "0", 2, 64, "0", "points a side of a shell's face; 0: 16, with wavelets 32" },
    { "cube_side", RD_WORD, "0|4|8|16|32|64", 0, 0, "0", "texels a side of a cube's face; 0: 16, with wavelets 32" },
    { "spacing", RD_WORD, "geometric|uniform|placed", 0, 0, "geometric",
      "of the shells; placed: by measured error, of kind=occlusion and lamp" },
    { "inner", RD_NUMBER, NULL, 0, 1000, "0", "first shell, in radii; 0: 0.2" },
    { "outer", RD_NUMBER, NULL, 0, 1000, "0", "last shell, in radii; 0: 8, with wavelets 20" },
    { "keep", RD_NUMBER, NULL, 0, 1, "0", "wavelets: share of a cube's coefficients; 0: 0.01, of kind=self 0.06" },
    { "window", RD_NUMBER, NULL, 0, 1e6, "0", "harmonics: strength of the window against ringing" },
    { "logarithm", RD_WORD, "0|1", 0, 0, "0", "1: log visibility, for the product by exponentials" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

static int failed(const char *what, sfield_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield: %s: %s", what, sfield_result_text(result));
    return -1;
}

/* For calls that build nothing: this thread alone, with progress under a label. */
static sfield_system services(char *label)
{
    sfield_system system;
    memset(&system, 0, sizeof system);
    system.progress = ex_progress;
    system.user = label;
    return system;
}

static sfield_desc desc_of(const rd_settings *settings, ex_pool *pool)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.basis = rd_setting_is(settings, "basis", "haar") ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    d.bands = (uint32_t)rd_setting_integer(settings, "bands");
    d.shell_count = (uint32_t)rd_setting_integer(settings, "shell_count");
    d.position_side = (uint32_t)rd_setting_integer(settings, "position_side");
    d.cube_side = (uint32_t)rd_setting_integer(settings, "cube_side");
    d.spacing = rd_setting_is(settings, "spacing", "uniform") ? SFIELD_SPACING_UNIFORM : SFIELD_SPACING_GEOMETRIC;
    d.inner = (float)rd_setting_number(settings, "inner");
    d.outer = (float)rd_setting_number(settings, "outer");
    d.keep = (float)rd_setting_number(settings, "keep");
    d.window = (float)rd_setting_number(settings, "window");
    d.logarithm = rd_setting_is(settings, "logarithm", "1");
    if (rd_setting_is(settings, "kind", "source")) {
        d.frame_count = (uint32_t)rd_setting_integer(settings, "frames");
        d.frames_per_second = (float)rd_setting_number(settings, "fps");
        d.loop = rd_setting_is(settings, "loop", "1");
    }
    if (!(d.keep > 0) && rd_setting_is(settings, "kind", "self"))
        d.keep = 0.06f;                         /* one cube a point, not thousands an object */
    ex_pool_label(pool, "shadow field");
    d.system.parallel_for = ex_pool_run;
    d.system.progress = ex_pool_progress;
    d.system.log = ex_pool_log;
    d.system.user = pool;
    return d;
}

static uint32_t shells_of(const sfield_desc *d)
{
    return d->shell_count ? d->shell_count : d->basis == SFIELD_BASIS_HAAR ? 32 : 16;
}

static uint32_t units_of(const rd_settings *settings)
{
    const sfield_desc d = desc_of(settings, NULL);
    return rd_setting_is(settings, "kind", "self") ? 1 : shells_of(&d) * (d.frame_count ? d.frame_count : 1);
}

static int plan_lamp(const rd_settings *settings, const bk_mesh *mesh, char *error)
{
    sfield_emitter e;
    if (!rd_setting_is(settings, "kind", "lamp") || !mesh->lamp_text) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: kind=lamp and a lamp, such as sphere:0,0,0,0.5, go together");
    } else if (sf_emitter_of(&mesh->lamp, (float)rd_setting_number(settings, "lamp_radius"), &e) != 0 ||
               (e.kind != SFIELD_EMITTER_RECTANGLE && !(e.radius > 0))) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: %.100s: give a point or spot a lamp_radius", mesh->lamp_text);
    } else if (rd_setting_is(settings, "logarithm", "1")) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: logarithm=1 is of occlusion fields");
    } else
        return 0;
    return -1;
}

/* About 10 ns a triangle and 0.2 ms of texels for each view. */
static int plan(const rd_settings *settings, const bk_mesh *mesh, uint32_t *units, double *seconds, char *error)
{
    sfield_desc d = desc_of(settings, NULL);
    uint32_t side = d.position_side ? d.position_side : d.basis == SFIELD_BASIS_HAAR ? 32 : 16;
    *units = units_of(settings);
    *seconds = *units * 6.0 * side * side * (10e-9 * (double)mesh->triangles + 2e-4);
    if (rd_setting_integer(settings, "frames") > 1 && !rd_setting_is(settings, "kind", "source")) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: frames are of kind=source");
        return -1;
    }
    if (rd_setting_is(settings, "spacing", "placed") && !rd_setting_is(settings, "kind", "occlusion") &&
        !rd_setting_is(settings, "kind", "lamp")) {
        snprintf(error, EX_ERROR_SIZE, "shadowfield: spacing=placed is of kind=occlusion and kind=lamp");
        return -1;
    }
    if (rd_setting_is(settings, "kind", "lamp") || mesh->lamp_text)
        return plan_lamp(settings, mesh, error);
    if (rd_setting_is(settings, "kind", "self")) {
        *seconds = 0;                           /* in one part */
        if (d.logarithm)
            snprintf(error, EX_ERROR_SIZE, "shadowfield: logarithm=1 is of occlusion fields");
        return d.logarithm ? -1 : 0;
    }
    if (!rd_setting_is(settings, "kind", "source"))
        return 0;
    if (rd_setting_integer(settings, "frames") > 1 && !d.logarithm)
        return 0;                               /* its first picture may be dark */
    if (!mesh->radiance || d.logarithm)
        snprintf(error, EX_ERROR_SIZE, "shadowfield: %s",
                 mesh->radiance ? "logarithm=1 is of occlusion fields" : "kind=source: nothing shines there");
    return mesh->radiance && !d.logarithm ? 0 : -1;
}

static void weigh(const rd_settings *settings, const bk_mesh *mesh, bk_work *work)
{
    (void)settings;
    (void)mesh;
    for (uint32_t u = 0; u < work->units; u++)
        work->unit[u] = 1;
}

static int bytes_of(sfield_field *field, void **data, size_t *size, char *error)
{
    *size = sfield_bytes(field);
    *data = malloc(*size);
    if (*data)
        sfield_write(field, *data, *size);
    sfield_free(field);
    return *data ? 0 : failed("memory", SFIELD_ERR_ALLOC, error);
}

static sfield_result build_self(const rd_settings *settings, const bk_mesh *mesh, const sfield_desc *d,
                                sfield_field **field, char *error)
{
    const sfield_mesh m = { mesh->positions, mesh->vertices, 0, mesh->indices, 3 * mesh->triangles, NULL, NULL, NULL };
    sfield_result result;
    bk_points p;
    if (bk_points_of(&p, mesh, (float)rd_setting_number(settings, "point_spacing"), error) != 0)
        return SFIELD_ERR_ALLOC;
    result = sfield_build_self(d, &m, &(const sfield_points){ .count = p.count, .positions = p.positions,
                                                             .normals = p.normals },
                               p.offset, field, NULL);
    bk_points_free(&p);
    return result;
}

static int build_film(const bk_mesh *mesh, const sfield_desc *d, sfield_field **field, sfield_result *result,
                      char *error)
{
    sfield_mesh lit;
    bk_mesh film;
    if (bk_film(&film, mesh, d->frame_count, (double)d->frames_per_second, error) != 0)
        return -1;
    memset(&lit, 0, sizeof lit);
    lit.positions = film.positions;
    lit.vertex_count = film.vertices;
    lit.indices = film.lit;
    lit.index_count = 3 * film.lit_count;
    *result = sfield_build_emissive(d, &lit, film.radiance, field, NULL);
    bk_object_free(&film);
    return 0;
}

static int bake(const rd_settings *settings, const bk_mesh *mesh, uint32_t from, uint32_t to, ex_pool *pool,
                void **data, size_t *size, char *error)
{
    sfield_desc d = desc_of(settings, pool);
    const sfield_mesh m = { mesh->positions, mesh->vertices, 0, mesh->indices, 3 * mesh->triangles, NULL, NULL, NULL };
    const sfield_mesh lit = { mesh->positions, mesh->vertices, 0, mesh->lit, 3 * mesh->lit_count, NULL, NULL, NULL };
    const int shines = rd_setting_is(settings, "kind", "lamp");
    sfield_placement places;
    sfield_emitter lamp;
    sfield_field *field;
    sfield_result result;
    if (shines)
        (void)sf_emitter_of(&mesh->lamp, (float)rd_setting_number(settings, "lamp_radius"), &lamp);
    if (rd_setting_is(settings, "spacing", "placed")) {
        result = sfield_place(&d, shines ? NULL : &m, shines ? &lamp : NULL, 0, &places);
        if (result != SFIELD_OK)
            return failed("placing shells", result, error);
        d.radii = places.radii;
        d.shell_count = places.shell_count;
    }
    if (from != 0 || to != units_of(settings)) {
        d.shard_begin = from;
        d.shard_end = to;
    }
    if (rd_setting_is(settings, "kind", "self"))
        result = build_self(settings, mesh, &d, &field, error);
    else if (shines)
        result = sfield_build_emitter(&d, &lamp, &field, NULL);
    else if (d.frame_count > 1) {
        if (build_film(mesh, &d, &field, &result, error) != 0)
            return -1;
    } else if (rd_setting_is(settings, "kind", "source"))
        result = sfield_build_emissive(&d, &lit, mesh->radiance, &field, NULL);
    else
        result = sfield_build(&d, &m, &field, NULL);
    ex_progress(NULL, 1);
    return result == SFIELD_OK ? bytes_of(field, data, size, error) : failed("build", result, error);
}

static int merge(const void *const *parts, const size_t *sizes, size_t count, int packed, void **data, size_t *size,
                 char *error)
{
    static char label[] = "merging";
    sfield_system system = services(label);
    sfield_field **fields = calloc(count, sizeof(sfield_field *)), *whole = NULL;
    sfield_result result = fields ? SFIELD_OK : SFIELD_ERR_ALLOC;
    (void)packed;
    for (size_t i = 0; i < count && result == SFIELD_OK; i++)
        result = sfield_open(parts[i], sizes[i], NULL, &fields[i]);
    if (result == SFIELD_OK)
        result = sfield_merge((const sfield_field *const *)fields, count, &system, &whole);
    ex_progress(NULL, 1);
    for (size_t i = 0; i < count && fields; i++)
        sfield_free(fields[i]);
    free(fields);
    return result == SFIELD_OK ? bytes_of(whole, data, size, error) : failed("merge", result, error);
}

static int info(const void *data, size_t size, char *line, size_t room, char *error)
{
    static char label[] = "reading";
    sfield_system system = services(label);
    sfield_field *field;
    sfield_info i;
    sfield_result result = sfield_open(data, size, &system, &field);
    ex_progress(NULL, 1);
    if (result != SFIELD_OK)
        return failed("file", result, error);
    sfield_get_info(field, &i);
    sfield_free(field);
    snprintf(
        line, room,
        "{\"technique\": \"shadowfield\", \"file_bytes\": %lu, \"kind\": \"%s\", \"basis\": \"%s\", \"bands\": %u, "
        "\"cube_side\": %u, \"shell_count\": %u, \"position_side\": %u, \"sample_count\": %lu, "
        "\"coefficient_count\": %llu, \"frame_count\": %u, \"inner\": %.6g, "
        "\"outer\": %.6g, \"shard_begin\": %u, \"shard_end\": %u, \"center\": [%.9g, %.9g, %.9g], "
        "\"radius\": %.9g}",
        (unsigned long)size, kinds[i.kind], i.basis == SFIELD_BASIS_HAAR ? "haar" : "sh", (unsigned)i.bands,
        (unsigned)i.cube_side, (unsigned)i.shell_count, (unsigned)i.position_side, (unsigned long)i.sample_count,
        (unsigned long long)i.coefficient_count, (unsigned)i.frame_count, (double)i.inner, (double)i.outer,
        (unsigned)i.shard_begin, (unsigned)i.shard_end, (double)i.center[0], (double)i.center[1],
        (double)i.center[2], (double)i.radius);
    return 0;
}

/* Built again with the same settings: the bytes are the same everywhere. The kind is the file's. */
static int verify(const rd_settings *settings, const void *data, size_t size, const bk_mesh *mesh, ex_pool *pool,
                  char *line, size_t room, char *error)
{
    static char label[] = "reading";
    rd_settings own = *settings;
    char kind[32];
    sfield_field *field;
    sfield_info i;
    void *again;
    size_t again_size, wrong = 0;
    uint32_t units;
    double seconds;
    sfield_system system = services(label);
    sfield_result result = sfield_open(data, size, &system, &field);
    ex_progress(NULL, 1);
    if (result != SFIELD_OK)
        return failed("file", result, error);
    sfield_get_info(field, &i);
    sfield_free(field);
    snprintf(kind, sizeof kind, "kind=%s", mesh->lamp_text ? "lamp" : kinds[i.kind]);
    if (rd_settings_add(&own, kind, error) != 0 || plan(&own, mesh, &units, &seconds, error) != 0)
        return -1;
    if (bake(&own, mesh, i.shard_begin, i.shard_end ? i.shard_end : units, pool, &again, &again_size, error) != 0)
        return -1;
    for (size_t k = 0; k < size && k < again_size; k++)
        wrong += ((const unsigned char *)data)[k] != ((const unsigned char *)again)[k];
    wrong += size > again_size ? size - again_size : again_size - size;
    free(again);
    snprintf(line, room, "{\"technique\": \"shadowfield\", \"file_bytes\": %lu, \"wrong\": %lu}", (unsigned long)size,
             (unsigned long)wrong);
    return wrong != 0;
}

const bk_technique bk_shadowfield = { "shadowfield", keys, NULL, plan, weigh, bake, merge, info, verify };
