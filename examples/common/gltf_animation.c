/* gltf_animation.c - see rig.h: one animation of a glTF file is read and checked. A message names the sampler, its
   input or output, and the value. */
#include "rig.h"
#include <stdlib.h>
#include <string.h>

#if defined(DAPPLE_HAVE_TINYGLTF) && DAPPLE_HAVE_TINYGLTF

typedef struct track_reader {
    ex_rig          *rig;
    const gltf_file *file;
    ex_track        *track;
    char             where[48];      /* "animation 0: sampler 3" */
    const char      *path;
    char            *error;
} track_reader;

static int read_times(const track_reader *r, int index)
{
    ex_track *track = r->track;
    char what[64];
    snprintf(what, sizeof what, "%s: input", r->where);
    const gltf_accessor *a = ex_gltf_accessor(r->file, index, 1, what, r->path, r->error);
    if (!a) return -1;
    if (a->component_type != 5126)
        return ex_fail(r->error, "%s: %s: accessor %d does not hold floats", r->path, what, index);
    track->times = (float *)ex_rig_room(r->rig, (double)a->count, sizeof(float), r->path, r->error);
    if (!track->times) return -1;
    track->key_count = (uint32_t)a->count;
    for (uint32_t i = 0; i < track->key_count; i++) {
        const float time = track->times[i] = ex_gltf_float(a, i, 0);
        if (!(time >= 0 && time < 1e6f))
            return ex_fail(r->error, "%s: %s: time %u is %g: 0 to 1e6 seconds are allowed", r->path, what, (unsigned)i,
                           (double)time);
        if (i && !(time > track->times[i - 1]))
            return ex_fail(r->error, "%s: %s: time %u is %g, not after %g, the one before it", r->path, what,
                           (unsigned)i, (double)time, (double)track->times[i - 1]);
    }
    r->rig->duration = fmaxf(r->rig->duration, track->times[track->key_count - 1]);
    return 0;
}

/* Rotations of one length, which slerp wants; tangents of splines stay in proportion. */
static int check_rotations(const track_reader *r, const char *what)
{
    ex_track *track = r->track;
    const int is_spline = track->interpolation == GLTF_CUBICSPLINE;
    for (uint32_t i = 0; i < track->key_count; i++) {
        float *q = track->values + (is_spline ? 12 * (size_t)i + 4 : 4 * (size_t)i);
        float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(length > 1e-3f && length < 1e3f))
            return ex_fail(r->error, "%s: %s: the rotation of key %u has the length %g, not 1", r->path, what,
                           (unsigned)i, (double)length);
        for (int k = 0; k < 4 && !is_spline; k++) q[k] /= length;
    }
    return 0;
}

static int read_values(const track_reader *r, int index, gltf_path path)
{
    ex_track *track = r->track;
    const uint32_t per_key = track->width * (track->interpolation == GLTF_CUBICSPLINE ? 3 : 1);
    const int components = path == GLTF_WEIGHTS ? 1 : path == GLTF_ROTATION ? 4 : 3;
    char what[64];
    snprintf(what, sizeof what, "%s: output", r->where);
    const gltf_accessor *a = ex_gltf_accessor(r->file, index, components, what, r->path, r->error);
    if (!a) return -1;
    const double wanted = (double)track->key_count * per_key / components;
    if ((double)a->count != wanted)
        return ex_fail(r->error, "%s: %s has %u elements: %u times want %g", r->path, what, (unsigned)a->count,
                       (unsigned)track->key_count, wanted);
    track->values = (float *)ex_rig_room(r->rig, (double)track->key_count * per_key, sizeof(float), r->path, r->error);
    if (!track->values) return -1;
    for (size_t i = 0; i < a->count; i++)
        for (int k = 0; k < components; k++) {
            const float value = ex_gltf_float(a, i, k);
            if (!(fabsf(value) < HUGE_COORDINATE))
                return ex_fail(r->error, "%s: %s: element %u is %g: 1e9 is the most", r->path, what, (unsigned)i,
                               (double)value);
            track->values[i * (size_t)components + (size_t)k] = value;
        }
    return path == GLTF_ROTATION ? check_rotations(r, what) : 0;
}

/* The sampler's track, read when the first channel wants it. */
static int read_track(track_reader *r, const gltf_animation *animation, const gltf_channel *channel, uint32_t width,
                      uint32_t *track_of)
{
    ex_rig *rig = r->rig;
    const uint32_t known = track_of[channel->sampler];
    const gltf_sampler *sampler = &r->file->samplers[animation->first_sampler + (size_t)channel->sampler];
    const int is_rotation = channel->path == GLTF_ROTATION;
    if (known) {
        const ex_track *track = &rig->tracks[known - 1];
        if (track->width == width && track->is_rotation == is_rotation) return 0;
        return ex_fail(r->error, "%s: %s has channels of %u and of %u numbers", r->path, r->where,
                       (unsigned)track->width, (unsigned)width);
    }
    if (sampler->interpolation == GLTF_NO_INTERPOLATION)
        return ex_fail(r->error, "%s: %s: interpolation is none of LINEAR, STEP, CUBICSPLINE", r->path, r->where);
    if (ex_grow(&rig->tracks, &rig->track_count, sizeof *rig->tracks) != 0)
        return ex_fail(r->error, "%s: out of memory", r->path);
    track_of[channel->sampler] = rig->track_count;
    r->track = &rig->tracks[rig->track_count - 1];
    r->track->interpolation = sampler->interpolation;
    r->track->is_rotation = is_rotation;
    r->track->width = width;
    return read_times(r, sampler->input) || read_values(r, sampler->output, channel->path) ? -1 : 0;
}

static int read_channel(track_reader *r, const gltf_animation *animation, uint32_t number, const gltf_channel *channel,
                        uint32_t *track_of)
{
    ex_rig *rig = r->rig;
    const int node = channel->node;
    uint32_t width = channel->path == GLTF_ROTATION ? 4 : 3;
    if (node < 0 || channel->path == GLTF_NO_PATH) return 0;         /* an extension's */
    if ((size_t)node >= r->file->node_count)
        return ex_fail(r->error, "%s: animation %u: a channel's node %d does not exist", r->path, (unsigned)number,
                       node);
    if (channel->sampler < 0 || (size_t)channel->sampler >= animation->sampler_count)
        return ex_fail(r->error, "%s: animation %u: sampler %d does not exist", r->path, (unsigned)number,
                       channel->sampler);
    snprintf(r->where, sizeof r->where, "animation %u: sampler %d", (unsigned)number, channel->sampler);
    if (channel->path == GLTF_WEIGHTS) {
        const uint32_t body = rig->nodes[node].body;
        if (body == RIG_NONE) return 0;                              /* nothing of it is in the scene */
        width = rig->shapes[rig->bodies[body].shape].target_count;
        if (width == 0)
            return ex_fail(r->error, "%s: %s: node %d has no morph targets for weights", r->path, r->where, node);
    } else if (rig->nodes[node].has_matrix)
        return ex_fail(r->error, "%s: %s: node %d has a matrix, which animations cannot move", r->path, r->where, node);
    if (read_track(r, animation, channel, width, track_of) != 0) return -1;
    if (ex_grow(&rig->channels, &rig->channel_count, sizeof *rig->channels) != 0)
        return ex_fail(r->error, "%s: out of memory", r->path);
    ex_rig_channel *to = &rig->channels[rig->channel_count - 1];
    to->track = track_of[channel->sampler] - 1;
    to->node = (uint32_t)node;
    to->path = channel->path;
    return 0;
}

int ex_rig_add_animation(ex_rig *rig, const gltf_file *file, uint32_t number, const char *path, char *error)
{
    track_reader r;
    int result = 0;
    if (number == 0 && file->animation_count == 0) return 0;
    if (number >= file->animation_count)
        return ex_fail(error, "%s: animation %u does not exist, it has %u", path, (unsigned)number,
                       (unsigned)file->animation_count);
    memset(&r, 0, sizeof r);
    r.rig = rig;
    r.file = file;
    r.path = path;
    r.error = error;
    const gltf_animation *animation = &file->animations[number];
    uint32_t *track_of = (uint32_t *)ex_rig_room(rig, (double)animation->sampler_count, sizeof *track_of, path, error);
    if (!track_of) return -1;
    for (size_t i = 0; i < animation->channel_count && result == 0; i++)
        result = read_channel(&r, animation, number, &file->channels[animation->first_channel + i], track_of);
    free(track_of);
    return result;
}

#endif
