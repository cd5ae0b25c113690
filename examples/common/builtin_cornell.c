/* builtin_cornell.c - the Cornell box as it was measured (www.graphics.cornell.edu/online/box/data.html).
   Coordinates in millimetres as published; the scene is in metres. Colours: the published spectra (reflectances
   400..700 nm in steps of 4, the lamp's four points) integrated with the CIE 1931 observer, converted to Rec. 709 and
   divided by what a flat spectrum gives, so that equal energy is white. */
#include "internal.h"

typedef float quad[4][3];

static void add_quads(ex_builder *b, const quad *quads, int count, uint32_t material)
{
    for (int i = 0; i < count; i++) {
        v3 p[4];
        for (int k = 0; k < 4; k++) p[k] = v3_scale(v3_load(quads[i][k]), 0.001f);
        ex_build_quad(b, p[0], p[1], p[2], p[3], material);
    }
}

static const quad white_walls[] = {
    {{552.8f, 0, 0}, {0, 0, 0}, {0, 0, 559.2f}, {549.6f, 0, 559.2f}},                           /* floor */
    {{556, 548.8f, 0}, {556, 548.8f, 559.2f}, {0, 548.8f, 559.2f}, {0, 548.8f, 0}},             /* ceiling */
    {{549.6f, 0, 559.2f}, {0, 0, 559.2f}, {0, 548.8f, 559.2f}, {556, 548.8f, 559.2f}}};         /* back */
static const quad green_wall[] = {{{0, 0, 559.2f}, {0, 0, 0}, {0, 548.8f, 0}, {0, 548.8f, 559.2f}}};
static const quad red_wall[] = {{{552.8f, 0, 0}, {549.6f, 0, 559.2f}, {556, 548.8f, 559.2f}, {556, 548.8f, 0}}};
/* Published in the ceiling's plane; half a millimetre lower here, so that the two do not fight. */
static const quad lamp[] = {{{343, 548.3f, 227}, {343, 548.3f, 332}, {213, 548.3f, 332}, {213, 548.3f, 227}}};

/* Top of a block, counter-clockwise from above; the published blocks have no bottom, ours do: closed objects. */
static const float short_block[4][2] = {{130, 65}, {82, 225}, {240, 272}, {290, 114}};
static const float tall_block[4][2] = {{423, 247}, {265, 296}, {314, 456}, {472, 406}};

static uint32_t add_block(ex_builder *b, const float corners[4][2], float height, uint32_t material)
{
    quad q[6];
    for (int i = 0; i < 4; i++) {
        int next = (i + 1) % 4, across = 3 - i;
        float side[4][3] = {{corners[i][0], 0, corners[i][1]}, {corners[next][0], 0, corners[next][1]},
                            {corners[next][0], height, corners[next][1]}, {corners[i][0], height, corners[i][1]}};
        for (int k = 0; k < 12; k++) q[i][k / 3][k % 3] = side[k / 3][k % 3];
        for (int k = 0; k < 3; k++) {
            q[4][i][k] = side[3][k];             /* top, in the published order */
            q[5][across][k] = side[0][k];        /* bottom, the other way round */
        }
    }
    add_quads(b, (const quad *)q, 6, material);
    return ex_build_finish(b);
}

void ex_build_cornell(ex_builder *b)
{
    uint32_t white = ex_build_material(b, 0.7378f, 0.7361f, 0.7371f);
    uint32_t green = ex_build_material(b, 0.0871f, 0.3986f, 0.0843f);
    uint32_t red = ex_build_material(b, 0.4718f, 0.0468f, 0.0489f);
    uint32_t light = ex_build_material(b, 0.78f, 0.78f, 0.78f);
    add_quads(b, white_walls, 3, white);
    add_quads(b, green_wall, 1, green);
    add_quads(b, red_wall, 1, red);
    ex_build_object(b, "room", ex_build_finish(b));
    ex_build_object(b, "short block", add_block(b, short_block, 165, white));
    ex_build_object(b, "tall block", add_block(b, tall_block, 330, white));
    add_quads(b, lamp, 1, light);
    ex_build_object(b, "lamp", ex_build_finish(b));
    if (b->failed) return;
    v3_store(b->scene->materials[light].emission, v3_make(17.1978f, 11.4761f, 3.0579f));
    ex_camera *camera = &b->scene->camera;
    v3_store(camera->eye, v3_make(0.278f, 0.273f, -0.8f));
    v3_store(camera->target, v3_make(0.278f, 0.273f, 0));
    v3_store(camera->up, v3_make(0, 1, 0));
    camera->fovy = 2 * atanf(0.5f * 0.025f / 0.035f);       /* 25 mm of film behind a 35 mm lens */
    b->scene->has_camera = 1;
}
