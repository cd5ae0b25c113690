/* orbit.c - see viewer.h */
#include "viewer.h"

#include <math.h>
#include <string.h>

static const float most = 1.55f;       /* of the elevation: not quite straight down */

/* Unit vectors of the camera: right, up, back. */
static void axes(const vw_orbit *o, float right[3], float up[3], float back[3])
{
    float ca = cosf(o->azimuth), sa = sinf(o->azimuth), ce = cosf(o->elevation), se = sinf(o->elevation);
    back[0] = ce * ca;
    back[1] = se;
    back[2] = ce * sa;
    right[0] = sa;
    right[1] = 0;
    right[2] = -ca;
    up[0] = -se * ca;
    up[1] = ce;
    up[2] = -se * sa;
}

void vw_orbit_from(vw_orbit *o, const ex_camera *camera)
{
    float d[3];
    for (int k = 0; k < 3; k++) {
        o->target[k] = camera->target[k];
        d[k] = camera->eye[k] - camera->target[k];
    }
    o->distance = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    o->azimuth = atan2f(d[2], d[0]);
    o->elevation = asinf(fmaxf(-1, fminf(1, d[1] / o->distance)));
    o->fovy = camera->fovy;
    vw_orbit_turn(o, 0, 0);
}

void vw_orbit_to(const vw_orbit *o, ex_camera *camera)
{
    float right[3], up[3], back[3];
    axes(o, right, up, back);
    for (int k = 0; k < 3; k++) {
        camera->target[k] = o->target[k];
        camera->eye[k] = o->target[k] + o->distance * back[k];
        camera->up[k] = up[k];
    }
    camera->fovy = o->fovy;
}

void vw_orbit_turn(vw_orbit *o, float right, float down)
{
    o->azimuth = fmodf(o->azimuth + right, 6.28318531f);
    o->elevation = fmaxf(-most, fminf(most, o->elevation + down));
}

void vw_orbit_move(vw_orbit *o, float x, float y)
{
    float right[3], up[3], back[3], scale = 2 * o->distance * tanf(0.5f * o->fovy);
    axes(o, right, up, back);
    for (int k = 0; k < 3; k++)
        o->target[k] += scale * (y * up[k] - x * right[k]);
}

void vw_orbit_zoom(vw_orbit *o, float steps) { o->distance = fmaxf(1e-5f, o->distance * powf(0.9f, steps)); }

void vw_orbit_matrix(const vw_orbit *o, float aspect, float radius, float out[16])
{
    float rows[3][3], eye[3], f = 1 / tanf(0.5f * o->fovy), far_away = o->distance + 20 * radius;
    float nearest = fmaxf(o->distance - 20 * radius, 1e-3f * fminf(radius, o->distance));
    float view[16], z = (far_away + nearest) / (nearest - far_away), w = 2 * far_away * nearest / (nearest - far_away);
    axes(o, rows[0], rows[1], rows[2]);
    memset(view, 0, sizeof view);
    for (int k = 0; k < 3; k++)
        eye[k] = o->target[k] + o->distance * rows[2][k];
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            view[4 * k + i] = rows[i][k];
        view[12 + i] = -(rows[i][0] * eye[0] + rows[i][1] * eye[1] + rows[i][2] * eye[2]);
    }
    for (int column = 0; column < 4; column++) {
        const float *v = view + 4 * column;
        out[4 * column] = f / aspect * v[0];
        out[4 * column + 1] = f * v[1];
        out[4 * column + 2] = z * v[2] + (column == 3 ? w : 0);
        out[4 * column + 3] = -v[2];
    }
}
