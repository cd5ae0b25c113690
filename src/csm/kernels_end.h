#undef COHSM__SET
#undef COHSM__WIDTH
#undef COHSM__LANE_COUNT
#endif /* COHSM__SET */

#if defined(CSM_IMPLEMENTATION) && !defined(CSM_IMPLEMENTED)
#define CSM_IMPLEMENTED
