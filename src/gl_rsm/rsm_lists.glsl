// rsm_lists - has lists of pixels that compute shaders append to and read from, each with the number of
// groups of 64 that it takes. A work group collects its pixels in shared memory, then takes room in a list
// for all of them at once.
// uses: rsm_screen
#ifndef RSM_GROUP
#define RSM_GROUP 64        // invocations of the work group
#endif
shared uint rsm_pending[RSM_GROUP], rsm_wanted[4 * RSM_GROUP];
shared uint rsm_pending_count, rsm_wanted_count, rsm_pending_at, rsm_wanted_at;

// Returns the item of a pixel.
uint rsm_pack_pixel(ivec2 at) { return uint(at.x) | uint(at.y) << 16; }
// Returns the pixel of an item.
ivec2 rsm_unpack_pixel(uint item) { return ivec2(item & 65535u, item >> 16); }

// Finds the pixel of this invocation in a list, with groups of 64 that the list itself counts. Returns false
// if the list has ended.
bool rsm_item(uint list, out ivec2 at)
{
    uint i = 64u * (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) + gl_LocalInvocationIndex;
    bool inside = i < glbk_rsm_counts[4u * list + 3u];
    at = ivec2(0);
    if (inside) at = rsm_unpack_pixel(glbk_rsm_items[i]);
    return inside;
}

// Begins the lists of this group. All invocations call it.
void rsm_begin_lists()
{
    if (gl_LocalInvocationIndex == 0u) rsm_pending_count = rsm_wanted_count = 0u;
    barrier();
}

// Adds a pixel that stays pending.
void rsm_add_pending(ivec2 at) { rsm_pending[atomicAdd(rsm_pending_count, 1u)] = rsm_pack_pixel(at); }

// Adds a node that is to be evaluated.
void rsm_add_wanted(ivec2 at) { rsm_wanted[atomicAdd(rsm_wanted_count, 1u)] = rsm_pack_pixel(at); }

// Returns the place of a node among the marks.
uint rsm_mark(ivec2 number, ivec2 last) { return uint(number.y * (last.x + 1) + number.x); }

// Adds a node that is to be evaluated, unless it was evaluated or another invocation has added it.
void rsm_want(ivec2 at)
{
    int fine = int(glbk_rsm_frame.fine_step);
    ivec2 number = rsm_node_number(at, fine), last = rsm_node_number(rsm_picture_side() - 1, fine);
    uint i = rsm_mark(number, last), bit = 1u << (i & 31u);
    if ((glbk_rsm_marks[i >> 5] & bit) != 0u || (atomicOr(glbk_rsm_marks[i >> 5], bit) & bit) != 0u) return;
    rsm_receiver r;
    if (rsm_read(at, r) && texelFetch(glbk_rsm_coarse, number, 0).w >= 0.0) rsm_add_wanted(at);
}

// Takes room in a list for count pixels more, and returns where that room begins. If the list needs more
// groups, their number grows; they stand in rows of 1024, so that no side exceeds the 65,535 that GL
// guarantees.
uint rsm_room(uint list, uint count)
{
    uint at = atomicAdd(glbk_rsm_counts[4u * list + 3u], count);
    uint before = (at + 63u) / 64u, groups = (at + count + 63u) / 64u;
    if (groups > before) {
        if (before < 1024u) atomicMax(glbk_rsm_counts[4u * list], min(groups, 1024u));
        atomicMax(glbk_rsm_counts[4u * list + 1u], (groups + 1023u) / 1024u);
    }
    return at;
}

// Writes the pixels of this group to the two lists. All invocations call it.
void rsm_end_lists(uint pending_list, uint wanted_list)
{
    uint i = gl_LocalInvocationIndex;
    barrier();
    if (i == 0u && rsm_pending_count > 0u) rsm_pending_at = rsm_room(pending_list, rsm_pending_count);
    if (i == 0u && rsm_wanted_count > 0u) rsm_wanted_at = rsm_room(wanted_list, rsm_wanted_count);
    barrier();
    if (i < rsm_pending_count) glbk_rsm_left[rsm_pending_at + i] = rsm_pending[i];
    for (; i < rsm_wanted_count; i += uint(RSM_GROUP)) glbk_rsm_wanted[rsm_wanted_at + i] = rsm_wanted[i];
}
