// rsm_chunk - lights of the list and points of the pattern that a work group reads together, in shared memory: for
// compute programs, before rsm_gather, whose numbers then count from the chunk's first.
#define RSM_CHUNK 64u               // lights, as many as the group has invocations; or four times as many points
shared uvec4 rsm_chunk[4u * RSM_CHUNK];
#define RSM_LIGHT(i, k) rsm_chunk[RSM_CHUNK * uint(k) + (i)]
#define RSM_POINT_AT(i) uintBitsToFloat(rsm_chunk[i].xyz)
