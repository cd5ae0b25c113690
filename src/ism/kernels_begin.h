/* ---- kernels: one text, compiled for every instruction set ---- */

/* Every instruction set has its own functions of these names, see unit simd. */
#define ism__lanes3_cross ISM__NAME_IN_SET(ism__lanes3_cross, ISM__SET)
#define ism__lanes3_madd ISM__NAME_IN_SET(ism__lanes3_madd, ISM__SET)
#define ism__lanes3_turn ISM__NAME_IN_SET(ism__lanes3_turn, ISM__SET)
#define ism__lanes3_select ISM__NAME_IN_SET(ism__lanes3_select, ISM__SET)
#define ism__lanes3_store ISM__NAME_IN_SET(ism__lanes3_store, ISM__SET)
#define ism__lanes_to_tile ISM__NAME_IN_SET(ism__lanes_to_tile, ISM__SET)
#define ism__square_of_disc ISM__NAME_IN_SET(ism__square_of_disc, ISM__SET)
#define ism__stretch_to_lobe ISM__NAME_IN_SET(ism__stretch_to_lobe, ISM__SET)
#define ism__sizes ISM__NAME_IN_SET(ism__sizes, ISM__SET)
#define ism__places ISM__NAME_IN_SET(ism__places, ISM__SET)
#define ism__project ISM__NAME_IN_SET(ism__project, ISM__SET)
#define ism__span_axis ISM__NAME_IN_SET(ism__span_axis, ISM__SET)
#define ism__cut_at_edges ISM__NAME_IN_SET(ism__cut_at_edges, ISM__SET)
#define ism__before_sky ISM__NAME_IN_SET(ism__before_sky, ISM__SET)
#define ism__before_vpl ISM__NAME_IN_SET(ism__before_vpl, ISM__SET)
#define ism__place_some ISM__NAME_IN_SET(ism__place_some, ISM__SET)
#define ism__place_discs ISM__NAME_IN_SET(ism__place_discs, ISM__SET)
#define ism__texels_hit ISM__NAME_IN_SET(ism__texels_hit, ISM__SET)
#define ism__draw_disc ISM__NAME_IN_SET(ism__draw_disc, ISM__SET)
#define ism__draw_discs ISM__NAME_IN_SET(ism__draw_discs, ISM__SET)
#define ism__mean_solid_angle ISM__NAME_IN_SET(ism__mean_solid_angle, ISM__SET)

#define ISM__SET plain
#define ISM__WIDTH ISM__SIMD_WIDTH
#define ISM__LANE_COUNT 8

#endif /* !ISM_IMPLEMENTED */

#ifdef ISM__SET
#if ISM_VERSION != 900 /* this file's: another one that includes it as ISM_FILE has its own */
#error "ism.h: the file that ISM_FILE names is of another version than the one that includes it"
#endif
