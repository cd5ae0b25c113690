/* rig.h - what moves a scene of a glTF file: nodes, skins, morph targets and one animation, as plain arrays that
   gltf_rig.c and gltf_animation.c read and check and pose.c plays. ex_scene.rig is one. */
#ifndef EX_RIG_H
#define EX_RIG_H

#include "internal.h"
#include "gltf.h"

#define HUGE_COORDINATE 1e9f         /* beyond it squared areas leave the range of floats */
#define RIG_NONE        UINT32_MAX

typedef struct ex_rig_node {
    uint32_t parent;             /* or RIG_NONE */
    uint32_t body;               /* what moves with this node and has morph targets or a skin, or RIG_NONE */
    int      has_matrix;         /* then `local` is the file's and stays */
    double   rest[10], now[10];  /* translation, rotation (x y z w), scale: of the file, and at the time of the pose */
    float    local[16], world[16];
} ex_rig_node;

typedef struct ex_track {        /* a sampler: values at times */
    gltf_interpolation interpolation;
    int      is_rotation;        /* LINEAR turns by the shorter way */
    uint32_t key_count, width;   /* floats of a value */
    float   *times;              /* ascending */
    float   *values;             /* of a key `width` floats; of CUBICSPLINE 3 x width: tangent in, value, tangent out */
} ex_track;

typedef struct ex_rig_channel { uint32_t track, node; gltf_path path; } ex_rig_channel;

typedef struct ex_skin {
    uint32_t joint_count, *joints;       /* nodes */
    float   *inverse_bind, *matrices;    /* 16 a joint; matrices: joint's world times inverse bind, of the pose */
} ex_skin;

typedef struct ex_shape {        /* a mesh as the file holds it, before morph targets and skins; count 0: it is rigid */
    uint32_t vertex_count, target_count;
    uint32_t joints_per_vertex;  /* 0, 4 or 8 */
    uint32_t highest_joint, highest_vertex;      /* greatest joint of a weight that is not 0, and its vertex */
    float   *positions, *normals;
    uint8_t *flat;               /* of each vertex: 1 = its normal is its triangle's, whatever that becomes */
    uint16_t *joints;
    float   *weights;            /* they sum to 1 */
    float   *position_deltas, *normal_deltas;    /* 3 x vertex_count a target */
} ex_shape;

typedef struct ex_body {         /* an object whose vertices move */
    uint32_t shape, mesh, object, node, skin;    /* skin: RIG_NONE = none, the object moves with its node */
    float   *rest_weights, *weights;             /* of the shape's targets: of the file, and of the pose */
} ex_body;

typedef struct ex_placed { uint32_t item, node; } ex_placed;     /* a rigid object or a light, and its node */

struct ex_rig {
    ex_rig_node    *nodes;    uint32_t node_count;
    uint32_t       *order;                           /* of nodes: parents first */
    ex_skin        *skins;    uint32_t skin_count;
    ex_shape       *shapes;   uint32_t shape_count;  /* of each mesh of the file */
    uint32_t       *users;                           /* of each mesh of the file: nodes that name it */
    ex_body        *bodies;   uint32_t body_count;
    ex_placed      *objects;  uint32_t object_count;
    ex_placed      *lights;   uint32_t light_count;
    ex_track       *tracks;   uint32_t track_count;
    ex_rig_channel *channels; uint32_t channel_count;
    float  duration;             /* seconds, of the longest track */
    double bytes, moved;         /* of memory; and vertices times targets, of all bodies */
    char   problem[EX_ERROR_SIZE];                   /* why the last pose failed */
};

/* ---- pose.c ---- */

void ex_compose(float m[16], const double translation_rotation_scale[10]);
int  ex_transform_usable(const float m[16]);     /* finite, affine, not all 0 */
/* Scale 0, by which animations hide things, becomes 1e-6: techniques want to divide by scales. */
void ex_transform_speck(float m[16]);
void ex_place_light(ex_light *light, const float m[16]);     /* position and direction by the node's world matrix */
/* The value of a track at a time: before its first key that one's, after its last that one's. */
void ex_track_value(const ex_track *track, float time, float *value);
/* Moves objects, lights and vertices to where they are at a time; of a time below 0 to where the file puts them without
   its animation. 0, or -1 with rig->problem. */
int  ex_rig_pose(ex_scene *scene, float time);

/* ---- gltf_rig.c, gltf_animation.c ---- */

/* Zeroed memory of the rig: a small file may name one array often. NULL with the error. */
void *ex_rig_room(ex_rig *rig, double count, size_t size, const char *path, char *error);

typedef struct ex_source { uint32_t primitive, vertex; } ex_source;     /* a vertex of a mesh in the file */

/* The loader's calls, in this order. NULL or -1: error is filled in. */
int  ex_rig_wanted(const gltf_file *file);           /* whether anything of the file moves */
ex_rig *ex_rig_begin(const gltf_file *file, const char *path, char *error);
int  ex_rig_add_shape(ex_rig *rig, const gltf_file *file, const ex_mesh *mesh, uint32_t number,
                      const ex_source *sources, const char *path, char *error);
/* 1: the mesh of the node is moved by a skin or morph targets; 2: by a skin, which ignores the node's own transform. */
int  ex_rig_moves(const ex_rig *rig, const gltf_file *file, uint32_t node);
int  ex_rig_add_body(ex_scene *scene, const gltf_file *file, uint32_t node, uint32_t object, const char *path,
                     char *error);
int  ex_rig_add_placed(ex_placed **list, uint32_t *count, uint32_t item, uint32_t node);     /* -1: out of memory */
int  ex_rig_add_animation(ex_rig *rig, const gltf_file *file, uint32_t number, const char *path, char *error);

#endif
