/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct P_allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} P_allocator;

static inline void *P_default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void P_default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int P_mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline int P_add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b) return 0;
    *out = a + b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int P_stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

/* Returns 1 if the functions of a public allocator are both there or both NULL. */
static inline int P_allocator_valid(void *(*alloc_fn)(size_t, void *), void (*free_fn)(void *, void *))
{
    return (alloc_fn == NULL) == (free_fn == NULL);
}

static inline P_allocator P_allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    P_allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : P_default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : P_default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *P_alloc(const P_allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *P_alloc_array(const P_allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return P_mul_size(count, item_size, &size) ? P_alloc(a, size) : NULL;
}

static inline void P_free(const P_allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}
