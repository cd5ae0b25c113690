// envsh_disc - has the points of the filter's disc, from the query that glbk_envsh_bind binds.
// uses: envsh_bindings
#define ENVSH_DISC_PAIR(i) glbk_envsh_query.disc[(i) >> 1]
#define ENVSH_DISC(i) (((i) & 1u) != 0u ? ENVSH_DISC_PAIR(i).zw : ENVSH_DISC_PAIR(i).xy)
