/* adapter.h - what the rows of tests/adapter/rows.c ask a renderer, any renderer: six C functions, which you define for
   yours. docs/adapter.md says how to run the rows; tests/adapter/dapple_rows_test.c defines the functions by Dapple's
   headers, rays_rows_test.c by rays alone, without any of them.

   Space is right-handed; lengths are in units of the scene, radiance in W/(sr m^2), irradiance in W/m^2, intensity in
   W/sr. Arrays of vectors hold three floats for each. Every point that is asked about is a receiver of its own: it
   belongs to no triangle, and nothing lies closer to it than a hundredth of the scene, unless a row says so. */
#ifndef ADAPTER_H
#define ADAPTER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct adapter_scene {      /* triangles, which hide from both sides and throw light back from both */
    const float    *positions;      /* of vertices */
    size_t          vertex_count;   /* 0: an empty scene */
    const uint32_t *indices;        /* three to a triangle */
    size_t          triangle_count;
    const float    *albedos;        /* of each triangle, 0..1, diffuse and grey; NULL: all are black */
} adapter_scene;

typedef enum adapter_light_kind {
    ADAPTER_SKY,                    /* from everywhere: value, or value times texels */
    ADAPTER_SUN,                    /* from one direction */
    ADAPTER_POINT,
    ADAPTER_SPOT,                   /* even within a round cone with a hard edge */
    ADAPTER_RECTANGLE,              /* position + s u + t v; shines to the side of u x v alone */
    ADAPTER_DISC,                   /* shines to the side of direction alone */
    ADAPTER_SPHERE
} adapter_light_kind;

typedef struct adapter_light {
    adapter_light_kind kind;
    float        position[3];       /* corner of a rectangle, else the middle */
    float        direction[3];      /* unit: towards the sun; out of the spot; the disc's normal */
    float        u[3], v[3];        /* edges of a rectangle */
    float        radius;            /* of disc and sphere */
    float        cone_half_angle;   /* of a spot, radians */
    float        value[3];          /* r, g, b: radiance; of a sun irradiance of what faces it; of point and spot
                                       intensity */
    const float *texels;            /* of a sky: r, g, b factors, height rows of width, row 0 about +Y; column x begins
                                       at the angle 2 pi (x / width - 0.5) = atan2(z, x). NULL: even */
    uint32_t     width, height;
} adapter_light;

/* Functions return 1 if they answered, 0 if the renderer has no such answer: the row is skipped then, and says so. */

const char *adapter_name(void);

int adapter_open(const adapter_scene *scene);
/* Takes a scene, whose arrays live until adapter_close. One scene is open at a time. */

void adapter_close(void);

int adapter_visible(const float *positions, const float *ends, int at_infinity, size_t count, float *visible);
/* Writes for each point how much it sees of a place, 0..1: of its end, or with at_infinity of what lies in the unit
   direction that ends holds for it. Answers of filters count as lit from one half on. */

int adapter_direct(const adapter_light *light, const float *positions, const float *normals, size_t count,
                   float *irradiance);
/* Writes the irradiance, r, g, b, of each point by what comes straight from the light and is not hidden. */

int adapter_bounced(const adapter_light *light, const float *positions, const float *normals, size_t count,
                    float *irradiance);
/* Writes the irradiance of each point by light that the scene's triangles threw back once, no more and no less, with
   its shadows on both ways. The lights are suns and points. */

#ifdef __cplusplus
}
#endif
#endif
