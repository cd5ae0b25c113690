// envsh_disc - points of the filter's disc, from the query that glbk_envsh_bind binds.
// uses: envsh_bindings
#define ENVSH_DISC(i) (((i) & 1u) != 0u ? glbk_envsh_query.disc[(i) >> 1].zw : glbk_envsh_query.disc[(i) >> 1].xy)
