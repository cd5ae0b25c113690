/* ---- kernels: one text, compiled for every instruction set ---- */

static const int32_t cohsm__numbers[16] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15 };

/* Names that every instruction set has of its own, see unit simd. */
#define cohsm__triangles COHSM__NAME_IN_SET(cohsm__triangles, COHSM__SET)
#define cohsm__spans COHSM__NAME_IN_SET(cohsm__spans, COHSM__SET)
#define cohsm__sides COHSM__NAME_IN_SET(cohsm__sides, COHSM__SET)
#define cohsm__span COHSM__NAME_IN_SET(cohsm__span, COHSM__SET)
#define cohsm__spans_of COHSM__NAME_IN_SET(cohsm__spans_of, COHSM__SET)
#define cohsm__side_from COHSM__NAME_IN_SET(cohsm__side_from, COHSM__SET)
#define cohsm__side_loses COHSM__NAME_IN_SET(cohsm__side_loses, COHSM__SET)
#define cohsm__sides_step COHSM__NAME_IN_SET(cohsm__sides_step, COHSM__SET)
#define cohsm__side_areas COHSM__NAME_IN_SET(cohsm__side_areas, COHSM__SET)
#define cohsm__to_front COHSM__NAME_IN_SET(cohsm__to_front, COHSM__SET)
#define cohsm__note_samples COHSM__NAME_IN_SET(cohsm__note_samples, COHSM__SET)
#define cohsm__draw_boxes COHSM__NAME_IN_SET(cohsm__draw_boxes, COHSM__SET)
#define cohsm__draw_alone COHSM__NAME_IN_SET(cohsm__draw_alone, COHSM__SET)
#define cohsm__draw_some COHSM__NAME_IN_SET(cohsm__draw_some, COHSM__SET)
#define cohsm__draw_queue COHSM__NAME_IN_SET(cohsm__draw_queue, COHSM__SET)
#define cohsm__corner_load COHSM__NAME_IN_SET(cohsm__corner_load, COHSM__SET)
#define cohsm__fixed COHSM__NAME_IN_SET(cohsm__fixed, COHSM__SET)
#define cohsm__depths COHSM__NAME_IN_SET(cohsm__depths, COHSM__SET)
#define cohsm__queue_add COHSM__NAME_IN_SET(cohsm__queue_add, COHSM__SET)
#define cohsm__image_axes COHSM__NAME_IN_SET(cohsm__image_axes, COHSM__SET)
#define cohsm__image_axes_of COHSM__NAME_IN_SET(cohsm__image_axes_of, COHSM__SET)
#define cohsm__queue_triangles COHSM__NAME_IN_SET(cohsm__queue_triangles, COHSM__SET)
#define cohsm__find_x COHSM__NAME_IN_SET(cohsm__find_x, COHSM__SET)
#define cohsm__enqueue COHSM__NAME_IN_SET(cohsm__enqueue, COHSM__SET)
#define cohsm__prefetch_part COHSM__NAME_IN_SET(cohsm__prefetch_part, COHSM__SET)
#define cohsm__slab_add COHSM__NAME_IN_SET(cohsm__slab_add, COHSM__SET)
#define cohsm__find_slab COHSM__NAME_IN_SET(cohsm__find_slab, COHSM__SET)
#define cohsm__enqueue_slab COHSM__NAME_IN_SET(cohsm__enqueue_slab, COHSM__SET)
#define cohsm__divide_65535 COHSM__NAME_IN_SET(cohsm__divide_65535, COHSM__SET)
#define cohsm__grid_above_lanes COHSM__NAME_IN_SET(cohsm__grid_above_lanes, COHSM__SET)
#define cohsm__grid_below_lanes COHSM__NAME_IN_SET(cohsm__grid_below_lanes, COHSM__SET)
#define cohsm__intervals COHSM__NAME_IN_SET(cohsm__intervals, COHSM__SET)
#define cohsm__intervals_of COHSM__NAME_IN_SET(cohsm__intervals_of, COHSM__SET)
#define cohsm__narrow COHSM__NAME_IN_SET(cohsm__narrow, COHSM__SET)
#define cohsm__sees8 COHSM__NAME_IN_SET(cohsm__sees8, COHSM__SET)
#define cohsm__append8 COHSM__NAME_IN_SET(cohsm__append8, COHSM__SET)
#define cohsm__find_clusters COHSM__NAME_IN_SET(cohsm__find_clusters, COHSM__SET)
#define cohsm__find_block COHSM__NAME_IN_SET(cohsm__find_block, COHSM__SET)
#define cohsm__found_depth COHSM__NAME_IN_SET(cohsm__found_depth, COHSM__SET)
#define cohsm__tray_depths COHSM__NAME_IN_SET(cohsm__tray_depths, COHSM__SET)
#define cohsm__find_depths COHSM__NAME_IN_SET(cohsm__find_depths, COHSM__SET)
#define cohsm__search_tile COHSM__NAME_IN_SET(cohsm__search_tile, COHSM__SET)
#define cohsm__load_vectors COHSM__NAME_IN_SET(cohsm__load_vectors, COHSM__SET)
#define cohsm__step_roots COHSM__NAME_IN_SET(cohsm__step_roots, COHSM__SET)
#define cohsm__step_cells COHSM__NAME_IN_SET(cohsm__step_cells, COHSM__SET)
#define cohsm__step_axes COHSM__NAME_IN_SET(cohsm__step_axes, COHSM__SET)
#define cohsm__step_project COHSM__NAME_IN_SET(cohsm__step_project, COHSM__SET)
#define cohsm__step_places COHSM__NAME_IN_SET(cohsm__step_places, COHSM__SET)
#define cohsm__step_jitter COHSM__NAME_IN_SET(cohsm__step_jitter, COHSM__SET)
#define cohsm__address_latlong COHSM__NAME_IN_SET(cohsm__address_latlong, COHSM__SET)
#define cohsm__views COHSM__NAME_IN_SET(cohsm__views, COHSM__SET)
#define cohsm__views_of COHSM__NAME_IN_SET(cohsm__views_of, COHSM__SET)
#define cohsm__seen COHSM__NAME_IN_SET(cohsm__seen, COHSM__SET)
#define cohsm__see_along_axes COHSM__NAME_IN_SET(cohsm__see_along_axes, COHSM__SET)
#define cohsm__see_on_face COHSM__NAME_IN_SET(cohsm__see_on_face, COHSM__SET)
#define cohsm__onto_face COHSM__NAME_IN_SET(cohsm__onto_face, COHSM__SET)
#define cohsm__keys_decode COHSM__NAME_IN_SET(cohsm__keys_decode, COHSM__SET)
#define cohsm__stream_load COHSM__NAME_IN_SET(cohsm__stream_load, COHSM__SET)
#define cohsm__stream_project COHSM__NAME_IN_SET(cohsm__stream_project, COHSM__SET)
#define cohsm__load_strided COHSM__NAME_IN_SET(cohsm__load_strided, COHSM__SET)
#define cohsm__rays COHSM__NAME_IN_SET(cohsm__rays, COHSM__SET)
#define cohsm__load_rays COHSM__NAME_IN_SET(cohsm__load_rays, COHSM__SET)
#define cohsm__segments_miss COHSM__NAME_IN_SET(cohsm__segments_miss, COHSM__SET)
#define cohsm__cones_miss COHSM__NAME_IN_SET(cohsm__cones_miss, COHSM__SET)
#define cohsm__meet_spheres COHSM__NAME_IN_SET(cohsm__meet_spheres, COHSM__SET)
#define cohsm__slots COHSM__NAME_IN_SET(cohsm__slots, COHSM__SET)
#define cohsm__stream_find COHSM__NAME_IN_SET(cohsm__stream_find, COHSM__SET)
#define cohsm__stream_decode COHSM__NAME_IN_SET(cohsm__stream_decode, COHSM__SET)
#define cohsm__stream_rest COHSM__NAME_IN_SET(cohsm__stream_rest, COHSM__SET)
#define cohsm__stream_compare COHSM__NAME_IN_SET(cohsm__stream_compare, COHSM__SET)
#define cohsm__one_light COHSM__NAME_IN_SET(cohsm__one_light, COHSM__SET)
#define COHSM__ALL_LANES ((1u << COHSM__LANE_COUNT) - 1u)       /* bits of a mask in which all lanes are */

#define COHSM__SET plain
#define COHSM__WIDTH COHSM__SIMD_WIDTH
#define COHSM__LANE_COUNT 8

#endif /* !CSM_IMPLEMENTED */

#ifdef COHSM__SET
#if COHSM_VERSION != 10000 /* this file's: another one that includes it as COHSM_FILE has its own */
#error "csm.h: the file that COHSM_FILE names is of another version than the one that includes it"
#endif
