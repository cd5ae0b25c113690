/* csm_baked.c - files of --baked for the technique csm. Maps of directions serve the sky and whatever else asks for
   directions; maps of places serve the light that lies where they look from. A file that serves nothing is an error:
   it was baked of another object, or for another light. */
#include "csm_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAME_PLACE 1e-3f         /* of the scene's radius; places stand off an emissive surface by a tenth of that */

struct cs_baked { const char *path; cohsm_maps *maps; cohsm_info info; int used; };

static int open_file(cs_baked *b, const cs_state *state, cohsm_system *system, char *error)
{
    size_t size;
    void *data = ex_file_read(b->path, &size, error);
    cohsm_result result;
    if (!data)
        return -1;
    result = cohsm_open_as(data, size, state->options.layout, 0, system, &b->maps);
    ex_progress(NULL, 1);
    free(data);
    if (result != COHSM_OK)
        return cs_failed(b->path, result, error);
    cohsm_get_info(b->maps, &b->info);
    return 0;
}

int cs_baked_open(cs_state *state, const rd_job *job, char *error)
{
    static char label[] = "csm maps";
    cohsm_system system;
    memset(&system, 0, sizeof system);
    system.allocator = cs_memory_allocator(&state->memory);
    system.progress = ex_progress;
    system.user = label;
    state->baked = calloc(job->baked_count + 1, sizeof *state->baked);
    if (!state->baked)
        return cs_out_of_memory(error);
    for (size_t i = 0; i < job->baked_count; i++) {
        state->baked[state->baked_count].path = job->baked[i];
        if (open_file(&state->baked[state->baked_count++], state, &system, error) != 0)
            return -1;
    }
    return 0;
}

void cs_baked_close(cs_state *state)
{
    for (size_t i = 0; i < state->baked_count; i++)
        cohsm_free(state->baked[i].maps);
    free(state->baked);
}

/* The file must have been made of this scene's casters. What can be compared at little cost is the sphere about them,
   with room for one that was given to bake. */
static int fits(const cs_state *state, const cs_baked *b)
{
    float off = fabsf(b->info.radius - state->sphere[3]);
    for (int k = 0; k < 3; k++)
        off = fmaxf(off, fabsf(b->info.center[k] - state->sphere[k]));
    return off < 0.2f * state->sphere[3];
}

int cs_baked_begin(cs_state *state, const rd_job *job, char *error)
{
    return state->baked_count ? cs_casters_sphere(job, state->sphere, error) : 0;
}

/* Do the maps look from the places of a domain, divided as the file divides it? 1, 0, or -1 with an error. */
static int same_places(const cs_baked *b, const cohsm_domain *domain, float most, char *error)
{
    cohsm_builder *builder;
    cohsm_desc desc;
    cohsm_result result;
    int same = 1;
    memset(&desc, 0, sizeof desc);
    desc.domain = *domain;
    if (b->info.domain != domain->kind || (domain->locations && domain->location_count != b->info.map_count))
        return 0;
    if (!domain->locations)
        memcpy(desc.domain.side, b->info.side, sizeof desc.domain.side);
    desc.map_side = 4;                           /* nothing is drawn: only where views look from is asked */
    memcpy(desc.center, b->info.center, sizeof desc.center);
    desc.radius = b->info.radius;
    result = cohsm_builder_create(&desc, &builder);
    if (result != COHSM_OK)
        return cs_failed(b->path, result, error);
    for (uint32_t i = 0; i < cohsm_builder_view_count(builder) && same; i++) {
        float place[4] = { 0, 0, 0, 0 };
        cohsm_view view;
        same = cohsm_builder_view(builder, i, &view) == COHSM_OK &&
               cohsm_location(b->maps, view.cell, place) == COHSM_OK;
        for (int k = 0; k < 3; k++)
            same &= fabsf(place[k] - view.location[k]) < most;
    }
    cohsm_builder_free(builder);
    return same;
}

int cs_baked_directions(cs_state *state, const rd_job *job, cs_casters *out, char *error)
{
    for (size_t i = 0; i < state->baked_count; i++) {
        cs_baked *b = &state->baked[i];
        if (b->info.positional || b->info.domain == COHSM_DOMAIN_LIST || b->info.domain == COHSM_DOMAIN_TABLE ||
            !fits(state, b))
            continue;
        b->used = 1;
        return cs_casters_of(out, state, job, b->maps, error) == 0 ? 1 : -1;
    }
    return 0;
}

int cs_baked_places(cs_state *state, const rd_job *job, const cohsm_domain *domain, cs_casters *out, char *error)
{
    for (size_t i = 0; i < state->baked_count; i++) {
        cs_baked *b = &state->baked[i];
        int same = b->info.positional && fits(state, b) ? same_places(b, domain, SAME_PLACE * job->radius, error) : 0;
        if (same < 0)
            return -1;
        if (!same)
            continue;
        b->used = 1;
        return cs_casters_of(out, state, job, b->maps, error) == 0 ? 1 : -1;
    }
    return 0;
}

/* What `bake csm --domain` wants for the first light that could have had maps of places, for the message. */
static void domain_wanted(const cs_state *state, char *text, size_t room)
{
    static const char *const names[] = { "", "", "", "line", "rectangle", "disc", "sphere" };
    *text = 0;
    for (size_t i = 0; i < state->light_count && !*text; i++) {
        const cs_light *light = &state->lights[i];
        cohsm_domain d;
        char ignored[EX_ERROR_SIZE];
        if (light->casters != &light->own || light->at_infinity ||
            cs_light_domain(light, &state->options, &d, ignored) != 0)
            continue;
        if (d.locations) {
            if (light->is_mesh)
                snprintf(text, room, ": a light wants --domain emissive, %u places", (unsigned)d.location_count);
            else
                snprintf(text, room, ": a light wants --domain list: of one place, %.7g %.7g %.7g 1",
                         (double)d.locations[0], (double)d.locations[1], (double)d.locations[2]);
        } else if (d.kind == COHSM_DOMAIN_SPHERE) {
            snprintf(text, room, ": a light wants --domain sphere:%.7g,%.7g,%.7g,%.7g", (double)d.origin[0],
                     (double)d.origin[1], (double)d.origin[2], (double)d.u[0]);
        } else {
            int n = snprintf(text, room, ": a light wants --domain %s:%.7g,%.7g,%.7g,%.7g,%.7g,%.7g", names[d.kind],
                             (double)d.origin[0], (double)d.origin[1], (double)d.origin[2], (double)d.u[0],
                             (double)d.u[1], (double)d.u[2]);
            if (d.kind != COHSM_DOMAIN_LINE && n > 0 && (size_t)n < room)
                snprintf(text + n, room - (size_t)n, ",%.7g,%.7g,%.7g", (double)d.v[0], (double)d.v[1], (double)d.v[2]);
        }
    }
}

int cs_baked_all_used(const cs_state *state, char *error)
{
    char wanted[EX_ERROR_SIZE / 2];
    for (size_t i = 0; i < state->baked_count; i++) {
        const cs_baked *b = &state->baked[i];
        if (b->used)
            continue;
        domain_wanted(state, wanted, sizeof wanted);
        snprintf(error, EX_ERROR_SIZE, "%.70s: %s%s", b->path,
                 !fits(state, b)       ? "maps of another object"
                 : b->info.positional  ? "maps of places where no light is"
                 : b->info.domain == COHSM_DOMAIN_LIST || b->info.domain == COHSM_DOMAIN_TABLE
                     ? "not maps of all directions"
                     : "maps of directions, and no light asks for them",
                 fits(state, b) && b->info.positional ? wanted : "");
        return -1;
    }
    return 0;
}
