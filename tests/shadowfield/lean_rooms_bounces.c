/* without rooms and bounces: what needs neither is what it was (tests/scripts/lean.sh) */

#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"

#include <stdio.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

/* A square's field and two points under a white sky, printed with all their digits. */
static int print_harmonics(void)
{
    static const float corners[] = { -1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1 };
    static const uint32_t triangles[] = { 0, 2, 1, 0, 3, 2 };
    static const float place[6] = { 0, -0.5f, 0, 6, -0.5f, 0 }, up[6] = { 0, 1, 0, 0, 1, 0 }, sky[3] = { 1, 1, 1 };
    sfield_desc desc;
    sfield_mesh mesh;
    sfield_entity square = upright;
    sfield_points points;
    sfield_field *field;
    sfield_scene *scene;
    float rgb[6];
    int good;
    memset(&desc, 0, sizeof desc);
    memset(&mesh, 0, sizeof mesh);
    memset(&points, 0, sizeof points);
    desc.shell_count = desc.position_side = 4;
    mesh.positions = corners;
    mesh.vertex_count = 4;
    mesh.indices = triangles;
    mesh.index_count = 6;
    if (sfield_build(&desc, &mesh, &field, NULL) != SFIELD_OK) return 0;
    if (sfield_scene_create(NULL, &scene) != SFIELD_OK) return 0;
    square.occlusion = field;
    points.count = 2;
    points.positions = place;
    points.normals = up;
    points.entity = 0;
    points.rgb = rgb;
    good = sfield_scene_entities(scene, &square, 1) == SFIELD_OK &&
           sfield_scene_environment(scene, sky, 1, 1, NULL) == SFIELD_OK &&
           sfield_shade(scene, &points, 1, NULL) == SFIELD_OK;
    printf("%08lx %.9g %.9g\n", (unsigned long)field->h.crc, (double)rgb[0], (double)rgb[3]);
    sfield_scene_free(scene);
    sfield_free(field);
    return good && rgb[0] < rgb[3];
}

#ifdef SFIELD_WITHOUT_WAVELETS
static int wavelets_are_refused(void)
{
    static uint8_t file[4096];
    FILE *f = fopen("tests/shadowfield/format1-wavelets.sf", "rb");
    sfield_desc desc;
    sfield_scene_desc scene_desc;
    sfield_field *field;
    sfield_scene *scene;
    sfield_mesh mesh;
    const float corners[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    size_t size = f ? fread(file, 1, sizeof file, f) : 0;
    if (f) fclose(f);
    memset(&desc, 0, sizeof desc);
    memset(&scene_desc, 0, sizeof scene_desc);
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = 3;
    desc.basis = scene_desc.basis = SFIELD_BASIS_HAAR;
    return sfield_build(&desc, &mesh, &field, NULL) == SFIELD_ERR_DESC &&
           sfield_scene_create(&scene_desc, &scene) == SFIELD_ERR_DESC &&
           sfield_open(file, size, NULL, &field) == SFIELD_ERR_MISMATCH;
}
#else
static int wavelets_are_refused(void) { return 1; }
#endif

int main(void) { return print_harmonics() && wavelets_are_refused() ? 0 : 1; }
