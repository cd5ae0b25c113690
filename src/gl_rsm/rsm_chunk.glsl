// rsm_chunk - brings lights of the list and points of the pattern into shared memory, for compute shaders
// whose groups read them together. The file comes before rsm_gather, whose numbers then count from the first
// of the chunk.
#define RSM_CHUNK 64u       // lights, as many as the group has invocations; or points, four times as many
shared uvec4 rsm_chunk[4u * RSM_CHUNK];
#define RSM_LIGHT(i, k) rsm_chunk[RSM_CHUNK * uint(k) + (i)]
#define RSM_POINT_AT(i) uintBitsToFloat(rsm_chunk[i].xyz)
