/* unit part: the caller's progress within parts of a call, and whether it cancels */

/* progress may be NULL; from..to of 0..1. */
typedef struct P_part {
    int (*progress)(void *user, float fraction);
    void *user;
    float from, to;
} P_part;

/* Where progress is not NULL; fraction: of the part. */
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

/* Before step i of count, asked every so many steps. 1: the caller cancels. */
static inline int P_cancelled(const P_part *p, size_t i, size_t count, size_t every)
{
    return p->progress && i % every == 0 && P_part_tell(p, (float)((double)i / (double)count)) != 0;
}
