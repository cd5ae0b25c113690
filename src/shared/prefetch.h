/* unit prefetch: asks for a cache line before it is read, in headers without unit hot, which does so, too */

#if defined(__GNUC__) && !defined(__TINYC__)
#define P_PREFETCH(p) __builtin_prefetch(p)
#else
#define P_PREFETCH(p) ((void)(p))
#endif
