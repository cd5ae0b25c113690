/* ---- kernels: one text, compiled for every instruction set ---- */

/* Pending pixels of one cell in arrays, so that the tests of section 4 run in vectors. Cells of 8 x 8 and
   4 x 4 pixels fill these vectors; the three pending pixels of a cell of 2 x 2 fill three of eight lanes. */
enum { RSM__TILE = 128 };

typedef struct rsm__tile {
    float px[RSM__TILE], py[RSM__TILE], pz[RSM__TILE];
    float nx[RSM__TILE], ny[RSM__TILE], nz[RSM__TILE];
    int32_t  good[RSM__TILE];      /* a bit for each of the cell's samples that suits the pixel */
    uint32_t x[RSM__TILE], y[RSM__TILE];    /* of the pixel in the picture */
} rsm__tile;

/* Sets `bit` in those of a tile's pixels that a sample suits. s holds the sample's position and normal,
   limits the least cosine, the largest slope^2 and the largest distance^2. count is a multiple of 8. */
typedef void (*rsm__suit_kernel)(rsm__tile *t, size_t count, const float s[6], const float limits[3],
                                 int32_t bit);

/* Names that every instruction set has of its own, see unit simd. */
#define rsm__lights RSM__NAME_IN_SET(rsm__lights, RSM__SET)
#define rsm__receivers RSM__NAME_IN_SET(rsm__receivers, RSM__SET)
#define rsm__lights_load RSM__NAME_IN_SET(rsm__lights_load, RSM__SET)
#define rsm__light_in_all RSM__NAME_IN_SET(rsm__light_in_all, RSM__SET)
#define rsm__forms RSM__NAME_IN_SET(rsm__forms, RSM__SET)
#define rsm__forms_make RSM__NAME_IN_SET(rsm__forms_make, RSM__SET)
#define rsm__lane_sums RSM__NAME_IN_SET(rsm__lane_sums, RSM__SET)
#define rsm__sums_zero RSM__NAME_IN_SET(rsm__sums_zero, RSM__SET)
#define rsm__sums_add RSM__NAME_IN_SET(rsm__sums_add, RSM__SET)
#define rsm__sums_reduce RSM__NAME_IN_SET(rsm__sums_reduce, RSM__SET)
#define rsm__sum_blocks RSM__NAME_IN_SET(rsm__sum_blocks, RSM__SET)
#define rsm__sum_lights RSM__NAME_IN_SET(rsm__sum_lights, RSM__SET)
#define rsm__sum_lights_lossy RSM__NAME_IN_SET(rsm__sum_lights_lossy, RSM__SET)
#define rsm__sum_lights_near RSM__NAME_IN_SET(rsm__sum_lights_near, RSM__SET)
#define rsm__sum_lights_near_lossy RSM__NAME_IN_SET(rsm__sum_lights_near_lossy, RSM__SET)
#define rsm__sum_on_receivers RSM__NAME_IN_SET(rsm__sum_on_receivers, RSM__SET)
#define rsm__light_receivers RSM__NAME_IN_SET(rsm__light_receivers, RSM__SET)
#define rsm__light_receivers_lossy RSM__NAME_IN_SET(rsm__light_receivers_lossy, RSM__SET)
#define rsm__suit_tile RSM__NAME_IN_SET(rsm__suit_tile, RSM__SET)

#define RSM__SET plain
#define RSM__WIDTH RSM__SIMD_WIDTH
#define RSM__LANE_COUNT 8

#endif /* !RSM_IMPLEMENTED */

#ifdef RSM__SET
#if RSM_VERSION != 10000 /* this file's: another one that includes it as RSM_FILE has its own */
#error "rsm.h: the file that RSM_FILE names is of another version than the one that includes it"
#endif
