/* ---- stream: objects that come and go ---- */

typedef struct cohsm__object {
    cohsm__header head;                 /* of its file, as it was opened last */
    int           known;                /* head is filled in */
    cohsm_maps   *maps;                 /* NULL: the object is not in memory */
    const void   *data;                 /* what load_fn gave, if the maps read it in place */
    size_t        data_bytes, bytes;    /* of data; what the object takes of the budget */
    uint32_t      holds;
    uint32_t      older, newer;         /* neighbours in the ring of those in memory that nobody holds */
} cohsm__object;

struct cohsm_stream {
    cohsm_stream_desc desc;
    cohsm__allocator  allocator;
    cohsm__object    *objects;          /* one more than there are: there the ring begins and ends. Its
                                           `newer` is the object that was used least recently */
    cohsm_stream_stats info;
    size_t            unheld;           /* bytes that the objects of the ring take of info.bytes */
    cohsm_maps        shell;            /* maps without a block, of the object that is looked at */
};

static void cohsm__ring_leave(cohsm_stream *s, uint32_t i)
{
    const cohsm__object *o = &s->objects[i];
    s->objects[o->older].newer = o->newer;
    s->objects[o->newer].older = o->older;
    s->unheld -= o->bytes;
}

static void cohsm__ring_enter(cohsm_stream *s, uint32_t i)
{
    const uint32_t end = s->desc.object_count, last = s->objects[end].older;
    s->objects[i].older = last;
    s->objects[i].newer = end;
    s->objects[last].newer = i;
    s->objects[end].older = i;
    s->unheld += s->objects[i].bytes;
}

static void cohsm__unload(const cohsm_stream *s, uint32_t i, const void *data, size_t bytes)
{
    if (s->desc.unload_fn) s->desc.unload_fn(s->desc.user, i, data, bytes);
}

/* Takes an object that nobody holds, or all do at the end, out of memory. */
static void cohsm__object_leave(cohsm_stream *s, uint32_t i)
{
    cohsm__object *o = &s->objects[i];
    cohsm_free(o->maps);
    o->maps = NULL;
    if (o->data) cohsm__unload(s, i, o->data, o->data_bytes);
    o->data = NULL;
    s->info.bytes -= o->bytes;
    s->info.objects--;
}

/* Makes room in the budget. Returns 0 if what is held leaves too little, when nothing has left. */
static int cohsm__make_room(cohsm_stream *s, uint64_t bytes)
{
    const uint32_t end = s->desc.object_count;
    const size_t budget = s->desc.budget_bytes;

    if (bytes > budget || s->info.bytes - s->unheld > budget - (size_t)bytes) return 0;
    while (s->info.bytes > budget - (size_t)bytes) {
        const uint32_t i = s->objects[end].newer;
        cohsm__ring_leave(s, i);
        cohsm__object_leave(s, i);
        s->info.evictions++;
    }
    return 1;
}

/* Logs that the budget has no room for an object. */
static cohsm_result cohsm__log_no_room(const cohsm_stream *s, const cohsm__logger *log, uint32_t i,
                                       uint64_t bytes)
{
    cohsm__log_element(log, "objects", i, s->info.held ? "beside those that are held takes" : "takes",
                       (double)bytes, "within desc.budget_bytes");
    return COHSM_ERR_LIMIT;
}

/* Logs why the file of an object was refused. Returns the result. */
static cohsm_result cohsm__log_object(const cohsm__logger *log, uint32_t i, cohsm_result result)
{
    const char *text = "is no file of csm.h, or a damaged one";
    if (result == COHSM_ERR_ALLOC) return cohsm__log_result(log, result);
    if (result == COHSM_ERR_VERSION) text = "is a file of an unknown version";
    if (result == COHSM_ERR_MISMATCH) text = "is a packed file, and this csm.h was joined without pack";
    if (result == COHSM_ERR_MEMORY) text = "lies at no multiple of 64 bytes";
    cohsm__log_element_text(log, "objects", i, text);
    return result;
}

/* Opens a file that load_fn gave, after making room for it. */
static cohsm_result cohsm__object_open(cohsm_stream *s, uint32_t i, cohsm__opening *file,
                                       const cohsm__logger *log)
{
    cohsm__object *o = &s->objects[i];
    cohsm__part part;
    cohsm_info info;
    uint64_t bytes;
    cohsm_result result = file->data ? cohsm__opening_start(file) : COHSM_ERR_FORMAT;

    if (result != COHSM_OK) return cohsm__log_object(log, i, result);
    if (o->known && memcmp(&o->head, &file->head, sizeof o->head) != 0) {
        cohsm__log_element_text(log, "objects", i, "has another file than before");
        return COHSM_ERR_INPUT;
    }
    bytes = file->cost + (file->in_place ? file->bytes : 0u);
    if (!cohsm__make_room(s, bytes)) return cohsm__log_no_room(s, log, i, bytes);
    if (s->info.peak_bytes < s->info.bytes + (size_t)bytes)
        s->info.peak_bytes = s->info.bytes + (size_t)bytes;
    memset(&part, 0, sizeof part);
    result = cohsm__opening_end(file, &s->allocator, &part, &o->maps);
    if (result != COHSM_OK) return cohsm__log_object(log, i, result);
    o->maps->log = s->desc.system.log;
    o->maps->log_user = s->desc.system.user;
    o->head = o->maps->head;
    o->known = 1;
    cohsm_get_info(o->maps, &info);
    o->bytes = info.memory_bytes + (file->in_place ? file->bytes : 0u);
    s->info.bytes += o->bytes;
    s->info.objects++;
    return COHSM_OK;
}

static cohsm_result cohsm__object_load(cohsm_stream *s, uint32_t i, const cohsm__logger *log)
{
    cohsm__object *o = &s->objects[i];
    const void *data = NULL;
    cohsm__opening file;
    cohsm_result result;

    file.bytes = 0;
    if (s->desc.load_fn(s->desc.user, i, &data, &file.bytes) != 0) {
        cohsm__log_element_text(log, "objects", i, "has no file: desc.load_fn said so");
        return COHSM_ERR_CANCELLED;
    }
    file.data = (const uint8_t *)data;
    file.in_place = s->desc.in_place;
    result = cohsm__object_open(s, i, &file, log);
    if (result == COHSM_OK && file.in_place) {
        o->data = data;
        o->data_bytes = file.bytes;
    } else cohsm__unload(s, i, data, file.bytes);
    return result;
}

static cohsm_result cohsm__object_hold(cohsm_stream *s, uint32_t i, const cohsm__logger *log)
{
    cohsm__object *o = &s->objects[i];
    cohsm_result result;

    if (o->maps) {
        s->info.hits++;
        if (!o->holds) cohsm__ring_leave(s, i);
    } else {
        result = cohsm__object_load(s, i, log);
        if (result != COHSM_OK) return result;
        s->info.loads++;
    }
    if (!o->holds++) s->info.held++;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_stream_use(cohsm_stream *s, uint32_t object, const cohsm_maps **out)
{
    cohsm__logger log = cohsm__logger_of(s ? &s->desc.system : NULL, "cohsm_stream_use");
    cohsm_result result;

    if (!s) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (object >= s->desc.object_count) {
        cohsm__log_bound(&log, "object", object, "below", s->desc.object_count, "the number of objects");
        return COHSM_ERR_ARGUMENT;
    }
    result = cohsm__object_hold(s, object, &log);
    if (result == COHSM_OK) *out = s->objects[object].maps;
    return result;
}

COHSM_DEF void cohsm_stream_end(cohsm_stream *s, uint32_t object)
{
    if (!s || object >= s->desc.object_count || !s->objects[object].holds) return;
    if (--s->objects[object].holds) return;
    s->info.held--;
    cohsm__ring_enter(s, object);
}

COHSM_DEF void cohsm_stream_get_stats(const cohsm_stream *s, cohsm_stream_stats *out)
{
    if (s && out) *out = s->info;
}

COHSM_DEF cohsm_result cohsm_stream_create(const cohsm_stream_desc *desc, cohsm_stream **out)
{
    cohsm__logger log = cohsm__logger_of(desc ? &desc->system : NULL, "cohsm_stream_create");
    cohsm__allocator a;
    cohsm__part part;
    cohsm_stream *s;
    uint32_t i;

    if (!desc) return COHSM_ERR_ARGUMENT;
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    if (!cohsm__services_of(&desc->system, &log, &a, &part)) return COHSM_ERR_DESC;
    if (!desc->object_count || desc->object_count > 1u << 24)
        return cohsm__refuse_value(&log, "desc.object_count", (double)desc->object_count, "1..2^24");
    if (!desc->budget_bytes) return cohsm__refuse_value(&log, "desc.budget_bytes", 0.0, "above 0");
    if (!desc->load_fn) return cohsm__refuse(&log, COHSM_ERR_DESC, "desc.load_fn", "is NULL");
    s = (cohsm_stream *)cohsm__alloc(&a, sizeof *s);
    if (!s) return cohsm__log_result(&log, COHSM_ERR_ALLOC);
    memset(s, 0, sizeof *s);
    s->desc = *desc;
    s->allocator = a;
    s->shell.log = desc->system.log;
    s->shell.log_user = desc->system.user;
    s->objects = (cohsm__object *)cohsm__alloc_array(&a, (size_t)desc->object_count + 1u, sizeof *s->objects);
    if (!s->objects) {
        cohsm__free(&a, s);
        return cohsm__log_result(&log, COHSM_ERR_ALLOC);
    }
    memset(s->objects, 0, ((size_t)desc->object_count + 1u) * sizeof *s->objects);
    i = desc->object_count;
    s->objects[i].older = s->objects[i].newer = i;
    *out = s;
    return COHSM_OK;
}

COHSM_DEF void cohsm_stream_free(cohsm_stream *s)
{
    cohsm__allocator a;
    uint32_t i;

    if (!s) return;
    a = s->allocator;
    for (i = 0; i < s->desc.object_count; i++)
        if (s->objects[i].maps) cohsm__object_leave(s, i);
    cohsm__free(&a, s->objects);
    cohsm__free(&a, s);
}
