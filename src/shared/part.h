/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* The share from..to of a call's progress, 0..1. progress may be NULL. */
typedef struct P_part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} P_part;

/* Tells the caller that this fraction of the part is done. Returns not 0 if the caller cancels. progress
   must not be NULL. */
static inline int P_part_tell(const P_part *p, float fraction)
{
    return p->progress(p->user, p->from + (p->to - p->from) * fraction);
}

static inline P_part P_part_of(const P_part *whole, float from, float to)
{
    P_part p = *whole;
    p.from = whole->from + (whole->to - whole->from) * from;
    p.to = whole->from + (whole->to - whole->from) * to;
    return p;
}

/* Returns 1 if the caller cancels before step i of count; the caller is asked every so many steps. */
static inline int P_cancelled(const P_part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && P_part_tell(p, (float)((double)i / (double)count)) != 0;
}
