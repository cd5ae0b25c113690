/* ---- kernels: one text, compiled for every instruction set ---- */

/* Names that every instruction set has of its own, see unit simd. */
#define sfield__pair SFIELD__NAME_IN_SET(sfield__pair, SFIELD__SET)
#define sfield__product_begin SFIELD__NAME_IN_SET(sfield__product_begin, SFIELD__SET)
#define sfield__product_end SFIELD__NAME_IN_SET(sfield__product_end, SFIELD__SET)
#define sfield__product SFIELD__NAME_IN_SET(sfield__product, SFIELD__SET)
#define sfield__pairs4 SFIELD__NAME_IN_SET(sfield__pairs4, SFIELD__SET)
#define sfield__term SFIELD__NAME_IN_SET(sfield__term, SFIELD__SET)
#define sfield__four_terms SFIELD__NAME_IN_SET(sfield__four_terms, SFIELD__SET)
#define sfield__terms4 SFIELD__NAME_IN_SET(sfield__terms4, SFIELD__SET)
#define sfield__product4 SFIELD__NAME_IN_SET(sfield__product4, SFIELD__SET)
#define sfield__rotate SFIELD__NAME_IN_SET(sfield__rotate, SFIELD__SET)
#define sfield__held SFIELD__NAME_IN_SET(sfield__held, SFIELD__SET)
#define sfield__row3 SFIELD__NAME_IN_SET(sfield__row3, SFIELD__SET)
#define sfield__row5 SFIELD__NAME_IN_SET(sfield__row5, SFIELD__SET)
#define sfield__row7 SFIELD__NAME_IN_SET(sfield__row7, SFIELD__SET)
#define sfield__rotate4 SFIELD__NAME_IN_SET(sfield__rotate4, SFIELD__SET)
#define sfield__corner_weights SFIELD__NAME_IN_SET(sfield__corner_weights, SFIELD__SET)
#define sfield__corner_weights_of SFIELD__NAME_IN_SET(sfield__corner_weights_of, SFIELD__SET)
#define sfield__shells SFIELD__NAME_IN_SET(sfield__shells, SFIELD__SET)
#define sfield__shells_of SFIELD__NAME_IN_SET(sfield__shells_of, SFIELD__SET)
#define sfield__between_four SFIELD__NAME_IN_SET(sfield__between_four, SFIELD__SET)
#define sfield__between_eight SFIELD__NAME_IN_SET(sfield__between_eight, SFIELD__SET)
#define sfield__eight_to_planes SFIELD__NAME_IN_SET(sfield__eight_to_planes, SFIELD__SET)
#define sfield__eight_times SFIELD__NAME_IN_SET(sfield__eight_times, SFIELD__SET)
#define sfield__mix_row SFIELD__NAME_IN_SET(sfield__mix_row, SFIELD__SET)
#define sfield__singles_times SFIELD__NAME_IN_SET(sfield__singles_times, SFIELD__SET)
#define sfield__mix SFIELD__NAME_IN_SET(sfield__mix, SFIELD__SET)
#define sfield__widen SFIELD__NAME_IN_SET(sfield__widen, SFIELD__SET)
#define sfield__transpose SFIELD__NAME_IN_SET(sfield__transpose, SFIELD__SET)
#define sfield__add_parts SFIELD__NAME_IN_SET(sfield__add_parts, SFIELD__SET)
#define sfield__planes_times SFIELD__NAME_IN_SET(sfield__planes_times, SFIELD__SET)
#define sfield__warp_angle SFIELD__NAME_IN_SET(sfield__warp_angle, SFIELD__SET)
#define sfield__node_before SFIELD__NAME_IN_SET(sfield__node_before, SFIELD__SET)
#define sfield__lanes_measure SFIELD__NAME_IN_SET(sfield__lanes_measure, SFIELD__SET)
#define sfield__weigh_shells SFIELD__NAME_IN_SET(sfield__weigh_shells, SFIELD__SET)
#define sfield__locate SFIELD__NAME_IN_SET(sfield__locate, SFIELD__SET)
#define sfield__same_eight SFIELD__NAME_IN_SET(sfield__same_eight, SFIELD__SET)
#define sfield__select SFIELD__NAME_IN_SET(sfield__select, SFIELD__SET)
#define sfield__to_local SFIELD__NAME_IN_SET(sfield__to_local, SFIELD__SET)
#define sfield__nearer SFIELD__NAME_IN_SET(sfield__nearer, SFIELD__SET)
#define sfield__look_at SFIELD__NAME_IN_SET(sfield__look_at, SFIELD__SET)
#define sfield__fade SFIELD__NAME_IN_SET(sfield__fade, SFIELD__SET)
#define sfield__recall SFIELD__NAME_IN_SET(sfield__recall, SFIELD__SET)
#define sfield__at_least_0 SFIELD__NAME_IN_SET(sfield__at_least_0, SFIELD__SET)
#define sfield__any_lane SFIELD__NAME_IN_SET(sfield__any_lane, SFIELD__SET)
#define sfield__face_start SFIELD__NAME_IN_SET(sfield__face_start, SFIELD__SET)
#define sfield__face_add_list SFIELD__NAME_IN_SET(sfield__face_add_list, SFIELD__SET)
#define sfield__face_dim SFIELD__NAME_IN_SET(sfield__face_dim, SFIELD__SET)
#define sfield__face_darken SFIELD__NAME_IN_SET(sfield__face_darken, SFIELD__SET)
#define sfield__face_hide SFIELD__NAME_IN_SET(sfield__face_hide, SFIELD__SET)
#define sfield__face_level SFIELD__NAME_IN_SET(sfield__face_level, SFIELD__SET)
#define sfield__face_transform SFIELD__NAME_IN_SET(sfield__face_transform, SFIELD__SET)
#define sfield__face_light SFIELD__NAME_IN_SET(sfield__face_light, SFIELD__SET)
#define sfield__face_finish SFIELD__NAME_IN_SET(sfield__face_finish, SFIELD__SET)
#define sfield__face_shade SFIELD__NAME_IN_SET(sfield__face_shade, SFIELD__SET)
#define sfield__haar_squares SFIELD__NAME_IN_SET(sfield__haar_squares, SFIELD__SET)
#define sfield__fill_cosines SFIELD__NAME_IN_SET(sfield__fill_cosines, SFIELD__SET)
#define sfield__dot_sky SFIELD__NAME_IN_SET(sfield__dot_sky, SFIELD__SET)
#define sfield__dim_texels SFIELD__NAME_IN_SET(sfield__dim_texels, SFIELD__SET)
#define sfield__shade_fours SFIELD__NAME_IN_SET(sfield__shade_fours, SFIELD__SET)
#define sfield__shade_square SFIELD__NAME_IN_SET(sfield__shade_square, SFIELD__SET)
#define sfield__darken SFIELD__NAME_IN_SET(sfield__darken, SFIELD__SET)

#define SFIELD__SET plain
#define SFIELD__WIDTH SFIELD__SIMD_WIDTH
#define SFIELD__LANE_COUNT 16

#endif /* !SHADOWFIELD_IMPLEMENTED */

#ifdef SFIELD__SET
#if SFIELD__SIMD_SETS
#if SFIELD_VERSION != 10000 /* this file's: another one that includes it as SFIELD_FILE has its own */
#error "shadowfield.h: the file that SFIELD_FILE names is of another version than the one that includes it"
#endif
#endif
