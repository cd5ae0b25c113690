/* ---- kernels: one text, compiled for every instruction set ---- */

static const float gifilt__numbers[GIFILT__WIDE] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15 };

/* Names that every instruction set has of its own, see unit simd. */
#define gifilt__shapes GIFILT__NAME_IN_SET(gifilt__shapes, GIFILT__SET)
#define gifilt__shapes_load GIFILT__NAME_IN_SET(gifilt__shapes_load, GIFILT__SET)
#define gifilt__alike GIFILT__NAME_IN_SET(gifilt__alike, GIFILT__SET)
#define gifilt__at_most GIFILT__NAME_IN_SET(gifilt__at_most, GIFILT__SET)
#define gifilt__at_most3 GIFILT__NAME_IN_SET(gifilt__at_most3, GIFILT__SET)
#define gifilt__not_zero GIFILT__NAME_IN_SET(gifilt__not_zero, GIFILT__SET)
#define gifilt__are_there GIFILT__NAME_IN_SET(gifilt__are_there, GIFILT__SET)
#define gifilt__set_there GIFILT__NAME_IN_SET(gifilt__set_there, GIFILT__SET)
#define gifilt__chunk_set GIFILT__NAME_IN_SET(gifilt__chunk_set, GIFILT__SET)
#define gifilt__chunk_load GIFILT__NAME_IN_SET(gifilt__chunk_load, GIFILT__SET)
#define gifilt__chunk_wrong GIFILT__NAME_IN_SET(gifilt__chunk_wrong, GIFILT__SET)
#define gifilt__row_times GIFILT__NAME_IN_SET(gifilt__row_times, GIFILT__SET)
#define gifilt__chunk_project GIFILT__NAME_IN_SET(gifilt__chunk_project, GIFILT__SET)
#define gifilt__near_picture GIFILT__NAME_IN_SET(gifilt__near_picture, GIFILT__SET)
#define gifilt__place_axis GIFILT__NAME_IN_SET(gifilt__place_axis, GIFILT__SET)
#define gifilt__chunk_place GIFILT__NAME_IN_SET(gifilt__chunk_place, GIFILT__SET)
#define gifilt__add_to GIFILT__NAME_IN_SET(gifilt__add_to, GIFILT__SET)
#define gifilt__chunk_recall GIFILT__NAME_IN_SET(gifilt__chunk_recall, GIFILT__SET)
#define gifilt__range_of GIFILT__NAME_IN_SET(gifilt__range_of, GIFILT__SET)
#define gifilt__chunk_range GIFILT__NAME_IN_SET(gifilt__chunk_range, GIFILT__SET)
#define gifilt__share GIFILT__NAME_IN_SET(gifilt__share, GIFILT__SET)
#define gifilt__past_runs GIFILT__NAME_IN_SET(gifilt__past_runs, GIFILT__SET)
#define gifilt__past_each GIFILT__NAME_IN_SET(gifilt__past_each, GIFILT__SET)
#define gifilt__chunk_past GIFILT__NAME_IN_SET(gifilt__chunk_past, GIFILT__SET)
#define gifilt__chunk_blend GIFILT__NAME_IN_SET(gifilt__chunk_blend, GIFILT__SET)
#define gifilt__accumulate GIFILT__NAME_IN_SET(gifilt__accumulate, GIFILT__SET)
#define gifilt__means GIFILT__NAME_IN_SET(gifilt__means, GIFILT__SET)
#define gifilt__despeckled GIFILT__NAME_IN_SET(gifilt__despeckled, GIFILT__SET)
#define gifilt__add_tap GIFILT__NAME_IN_SET(gifilt__add_tap, GIFILT__SET)
#define gifilt__smooth_some GIFILT__NAME_IN_SET(gifilt__smooth_some, GIFILT__SET)
#define gifilt__smooth GIFILT__NAME_IN_SET(gifilt__smooth, GIFILT__SET)

#define GIFILT__SET plain
#define GIFILT__WIDTH GIFILT__SIMD_WIDTH
#define GIFILT__LANE_COUNT 8

#endif /* !GIFILTER_IMPLEMENTED */

#ifdef GIFILT__SET
#if GIFILT_VERSION != 10000 /* this file's: another one that includes it as GIFILT_FILE has its own */
#error "gifilter.h: the file that GIFILT_FILE names is of another version than the one that includes it"
#endif
