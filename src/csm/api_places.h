/* ---- fewer maps for the same answers ---- */

typedef struct cohsm_places_desc {
    cohsm_system       system;          /* parallel_for is not called */
    const cohsm_maps  *candidates;      /* maps of more places than you want to keep, N <= 16,384, such as
                                           small ones (map_side 32) of a LIST or TABLE: by their answers
                                           places are compared */
    const float       *receivers;       /* x, y, z of points as those that will ask, some thousands, in the
                                           space of the maps */
    size_t             receiver_count;  /* 1..2^28 */
    size_t             receiver_stride; /* bytes, a multiple of 4, >= 12; 0 = 12 */
    uint32_t           place_count;     /* K, how many of the candidates to choose, 1..N */
    float              bias;            /* as in cohsm_query */
} cohsm_places_desc;

COHSM_DEF cohsm_result cohsm_places_choose(const cohsm_places_desc *desc, uint32_t *places, uint32_t *instead,
                                           double *error);
/* Chooses those candidates that answer best for all others: adaptive sampling of a domain (section 7), by
   measured error. The error is the share of pairs of candidate and receiver whose answer changes if the
   candidate's map is replaced by that of the place which stands for it. Places are taken one by one, each
   where it lowers the error most, then exchanged as long as that lowers the error.
   places    receives place_count numbers of candidates, rising
   instead   receives for each of the N candidates the number within `places` of the one that stands for it,
             by which lights of the candidates ask maps of the places (COHSM_LIGHT_INDEX)
   error     may be NULL; receives the error, 0..1
   Errors    COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC, COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED
   Cost      N receiver_count queries, then N^2 (receiver_count / 32 + place_count) steps, and at most 16 N^2
             place_count for the exchanges; 4 N^2 + N receiver_count / 8 + 4 receiver_count bytes of memory */
