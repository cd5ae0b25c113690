/* gltf.h - the seam between gltf.c and whatever parses glTF files: one function. It shows the parsed file as plain
   arrays and promises nothing about what they say; every index, size and number is checked in gltf.c. */
#ifndef EX_GLTF_H
#define EX_GLTF_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct gltf_sparse {     /* elements in place of an accessor's; count 0 = none. NULL: no such bytes */
    size_t count;
    const uint8_t *indices, *values;                /* which elements, ascending; and what they are */
    size_t index_bytes, value_bytes;                /* from there to the end of their buffer views */
    int    index_type;           /* 5121, 5123 or 5125 */
} gltf_sparse;

typedef struct gltf_accessor {
    const uint8_t *data;         /* first element, or NULL: no such bytes in the file; of a sparse one: all 0 */
    size_t   bytes;              /* from data to the end of its buffer view */
    size_t   stride;             /* between elements; 0 = tightly packed */
    size_t   count;
    int      component_type;     /* 5120..5126 as in the file */
    int      components;         /* 1..4, 16 for MAT4; 0 for other matrices and nonsense */
    int      normalized;
    gltf_sparse sparse;
} gltf_accessor;

typedef struct gltf_primitive {
    int mesh;                    /* primitives are listed mesh by mesh */
    int mode;                    /* 4 triangles, 5 strip, 6 fan; others hold no surface */
    int positions, normals, indices, material;      /* -1 = none */
    int uvs[2];                  /* TEXCOORD_0 and _1 */
    int colors;                  /* COLOR_0 */
    int joints[2], weights[2];   /* JOINTS_0 and _1, WEIGHTS_0 and _1 */
    size_t first_target, target_count;              /* in gltf_file.targets */
} gltf_primitive;

typedef struct gltf_target { int positions, normals; } gltf_target;    /* accessors of differences, -1 = none */

typedef struct gltf_weights { const double *values; size_t count; } gltf_weights;    /* of morph targets */

typedef struct gltf_material {
    double base_color[4], emissive[3], emissive_strength, metallic, roughness, alpha_cutoff, transmission;
    int    alpha_mode;           /* 0 opaque, 1 mask, 2 blend */
    int    double_sided, base_image, emissive_image, transmission_image, uv_set; /* images: -1 = none; uv_set: base */
    int    normal_image, normal_uv_set, rough_image, rough_uv_set;
} gltf_material;

/* Only those that a material names as base colour, emission, transmission, normal or roughness have pixels. */
typedef struct gltf_image { const uint8_t *pixels; size_t bytes; int width, height, channels, bits; } gltf_image;

typedef struct gltf_light { int kind; double color[3], intensity, outer_angle; } gltf_light;  /* 0 sun 1 point 2 spot */

typedef struct gltf_node {
    const char *name;
    const int  *children;
    size_t      child_count;
    int         mesh, camera, light, skin;
    gltf_weights weights;        /* in place of those of the mesh; count 0 = none */
    int         has_matrix;
    double      matrix[16], translation[3], rotation[4], scale[3];
} gltf_node;

typedef struct gltf_skin { const int *joints; size_t joint_count; int inverse_bind; } gltf_skin;

typedef enum gltf_path { GLTF_TRANSLATION, GLTF_ROTATION, GLTF_SCALE, GLTF_WEIGHTS, GLTF_NO_PATH } gltf_path;
typedef enum gltf_interpolation { GLTF_LINEAR, GLTF_STEP, GLTF_CUBICSPLINE, GLTF_NO_INTERPOLATION } gltf_interpolation;

typedef struct gltf_channel { int sampler, node; gltf_path path; } gltf_channel;     /* node: -1 = none */
typedef struct gltf_sampler { int input, output; gltf_interpolation interpolation; } gltf_sampler;
/* Ranges of gltf_file.channels and .samplers; a channel counts the samplers of its animation. */
typedef struct gltf_animation { size_t first_channel, channel_count, first_sampler, sampler_count; } gltf_animation;

typedef struct gltf_file {
    const gltf_accessor  *accessors;  size_t accessor_count;
    const gltf_primitive *primitives; size_t primitive_count;
    const gltf_material  *materials;  size_t material_count;
    const gltf_image     *images;     size_t image_count;
    const gltf_light     *lights;     size_t light_count;
    const gltf_node      *nodes;      size_t node_count;
    const double         *yfovs;      size_t camera_count;      /* 0 for an orthographic one */
    const int            *roots;      size_t root_count;        /* of the default scene */
    const gltf_weights   *weights;    size_t mesh_count;        /* one a mesh */
    const gltf_target    *targets;    size_t target_count;
    const gltf_skin      *skins;      size_t skin_count;
    const gltf_channel   *channels;   size_t channel_count;
    const gltf_sampler   *samplers;   size_t sampler_count;
    const gltf_animation *animations; size_t animation_count;
    const char *unsupported;          /* a required extension that the parser does not know, or NULL */
} gltf_file;

/* Whether the JSON of the file can be given to a parser: its depth, and what its values may take of ex_memory_limit.
   0, or -1 with one line in error. */
int ex_gltf_check(const char *path, char *error);

/* Ends a text at its first line and replaces control characters. */
void ex_one_line(char *error);

/* Bytes of a PNG's or JPEG's pixels with four channels; 0: neither, or built without stb. */
double ex_picture_bytes(const void *data, size_t size);

/* The accessor if it is there, has that many components and lies inside its bytes; else NULL with the error. */
const gltf_accessor *ex_gltf_accessor(const gltf_file *file, int index, int components, const char *what,
                                      const char *path, char *error);
/* Of an accessor that was checked: a component of element i as a float, or the only one as it is. */
float    ex_gltf_float(const gltf_accessor *a, size_t i, int component);
uint32_t ex_gltf_uint(const gltf_accessor *a, size_t i);

typedef int (*gltf_visitor)(void *context, const gltf_file *file, char *error);

/* Parses path, calls visit with the contents, frees them. Returns visit's result, or -1 with error (error_size bytes)
   filled in where the file cannot be read or parsed. */
int ex_gltf_parse(const char *path, gltf_visitor visit, void *context, char *error, size_t error_size);

#ifdef __cplusplus
}
#endif

#endif
