/* unit batch: tasks of a call, some at a time */

typedef struct P_batch { void (*task)(void *context, size_t index); void *context; size_t first; } P_batch;

/* The task of a batch, with the batch as its context. */
static inline void P_batch_task(void *context, size_t index)
{
    const P_batch *b = (const P_batch *)context;
    b->task(b->context, b->first + index);
}
