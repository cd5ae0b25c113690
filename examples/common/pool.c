/* pool.c - threads, time and progress. */
#define _POSIX_C_SOURCE 200809L
#include "common.h"
#include <pthread.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

struct ex_pool {
    pthread_mutex_t run_lock;        /* one run at a time; a nested run finds it taken and goes on alone */
    pthread_mutex_t lock;            /* guards everything below */
    pthread_cond_t  start, finished;
    pthread_t      *workers;
    int             worker_count;
    int             busy;            /* workers still inside the present run */
    unsigned        generation;      /* a new number starts a run */
    int             quit;
    ex_task         task;
    void           *context;
    size_t          next, count, batch;
    const char     *label;           /* of ex_pool_progress */
};

/* Takes indices a batch at a time, so that uneven tasks balance and tiny ones do not fight for the lock. */
static void work(ex_pool *pool)
{
    for (;;) {
        pthread_mutex_lock(&pool->lock);
        size_t begin = pool->next;
        size_t end = pool->count - begin > pool->batch ? begin + pool->batch : pool->count;
        pool->next = end;
        pthread_mutex_unlock(&pool->lock);
        if (begin == end) return;
        for (size_t i = begin; i < end; i++) pool->task(pool->context, i);
    }
}

static void *worker_main(void *argument)
{
    ex_pool *pool = (ex_pool *)argument;
    unsigned seen = 0;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->quit && pool->generation == seen) pthread_cond_wait(&pool->start, &pool->lock);
        if (pool->quit) break;
        seen = pool->generation;
        pthread_mutex_unlock(&pool->lock);
        work(pool);
        pthread_mutex_lock(&pool->lock);
        if (--pool->busy == 0) pthread_cond_signal(&pool->finished);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

ex_pool *ex_pool_create(int threads)
{
    if (threads <= 0) {
        long cores = sysconf(_SC_NPROCESSORS_ONLN);
        threads = cores < 1 ? 1 : cores > 256 ? 256 : (int)cores;
    }
    if (threads > 256) threads = 256;
    ex_pool *pool = (ex_pool *)calloc(1, sizeof *pool);
    if (!pool) return NULL;
    pool->workers = (pthread_t *)calloc((size_t)threads, sizeof *pool->workers);
    if (!pool->workers) { free(pool); return NULL; }
    pthread_mutex_init(&pool->run_lock, NULL);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->start, NULL);
    pthread_cond_init(&pool->finished, NULL);
    /* Fewer threads than asked for is no error: every index is still run. */
    while (pool->worker_count < threads - 1 &&
           pthread_create(&pool->workers[pool->worker_count], NULL, worker_main, pool) == 0)
        pool->worker_count++;
    return pool;
}

void ex_pool_run(void *opaque, size_t count, ex_task task, void *context)
{
    ex_pool *pool = (ex_pool *)opaque;
    if (!pool || pool->worker_count == 0 || count < 2 || pthread_mutex_trylock(&pool->run_lock) != 0) {
        for (size_t i = 0; i < count; i++) task(context, i);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    pool->task = task;
    pool->context = context;
    pool->next = 0;
    pool->count = count;
    pool->batch = 1 + count / (64 * (size_t)ex_pool_threads(pool));
    pool->busy = pool->worker_count;
    pool->generation++;
    pthread_cond_broadcast(&pool->start);
    pthread_mutex_unlock(&pool->lock);
    work(pool);
    pthread_mutex_lock(&pool->lock);
    while (pool->busy > 0) pthread_cond_wait(&pool->finished, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    pthread_mutex_unlock(&pool->run_lock);
}

void ex_pool_label(ex_pool *pool, const char *label)
{
    if (pool) pool->label = label;
}

int ex_pool_progress(void *opaque, float fraction)
{
    const ex_pool *pool = (const ex_pool *)opaque;
    return ex_progress((void *)(size_t)(pool ? pool->label : NULL), fraction);
}

static char said[EX_ERROR_SIZE];            /* what a header's failing call has said last */

void ex_pool_log(void *opaque, const char *message)
{
    (void)opaque;
    snprintf(said, sizeof said, "%s", message);
}

void ex_complain(const char *program, const char *error)
{
    if (*said) fprintf(stderr, "%s: %s (%s)\n", program, error, said);
    else fprintf(stderr, "%s: %s\n", program, error);
    *said = 0;
}

int ex_pool_threads(const ex_pool *pool) { return pool ? pool->worker_count + 1 : 1; }

void ex_pool_free(ex_pool *pool)
{
    if (!pool) return;
    pthread_mutex_lock(&pool->lock);
    pool->quit = 1;
    pthread_cond_broadcast(&pool->start);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->worker_count; i++) pthread_join(pool->workers[i], NULL);
    pthread_cond_destroy(&pool->finished);
    pthread_cond_destroy(&pool->start);
    pthread_mutex_destroy(&pool->lock);
    pthread_mutex_destroy(&pool->run_lock);
    free(pool->workers);
    free(pool);
}

double ex_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int ex_terminal(void) { return isatty(STDERR_FILENO); }

int ex_progress(void *label, float fraction)
{
    if (!ex_terminal()) return 0;
    if (fraction >= 1)
        fprintf(stderr, "\r\033[K");     /* leave a clean line behind */
    else
        fprintf(stderr, "\r%s %3.0f %%", label ? (const char *)label : "", 100 * (double)fraction);
    fflush(stderr);
    return 0;
}
