/* unit prefetch: asks for a cache line before it is read */

#if defined(__GNUC__) && !defined(__TINYC__)
#define P_PREFETCH(p) __builtin_prefetch(p)
#else
#define P_PREFETCH(p) ((void)(p))
#endif
