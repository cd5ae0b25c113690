/* ---- stream: scenes ---- */

/* What cohsm_stream_visible_scene asks, object by object; its answers lie apart until all are there. */
typedef struct cohsm__scene_walk {
    cohsm_stream *stream;
    const cohsm_stream_instance *instances;
    uint32_t    count;
    cohsm_query query;
    float      *visible;
    cohsm__tile tile;
    const cohsm__logger *log;
} cohsm__scene_walk;

/* Returns instance number i with maps that know what the header of its object says, and no more. */
static cohsm_instance cohsm__instance_of_header(const cohsm__scene_walk *w, uint32_t i)
{
    cohsm_stream *s = w->stream;
    cohsm_instance instance;
    cohsm__maps_of_header(&s->shell, &s->objects[w->instances[i].object].head);
    instance.maps = &s->shell;
    memcpy(instance.transform, w->instances[i].transform, sizeof instance.transform);
    return instance;
}

/* Checks instances and query. Objects that were never loaded are loaded for it. */
static cohsm_result cohsm__check_walk(const cohsm__scene_walk *w)
{
    const cohsm_stream *s = w->stream;
    uint32_t i, object;

    for (i = 0; i < w->count; i++) {
        cohsm_instance instance;
        cohsm_result result = COHSM_OK;
        object = w->instances[i].object;
        if (object >= s->desc.object_count) {
            cohsm__log_element(w->log, "instances", i, "has the object", (double)object,
                               "below desc.object_count");
            return COHSM_ERR_INPUT;
        }
        if (!s->objects[object].known) {
            result = cohsm__object_hold(w->stream, object, w->log);
            if (result != COHSM_OK) return result;
            cohsm_stream_end(w->stream, object);
        }
        instance = cohsm__instance_of_header(w, i);
        result = cohsm__check_instance(&instance, i, &w->query, w->log);
        if (result != COHSM_OK) return result;
    }
    return COHSM_OK;
}

/* Finds the samples of a block that ask an instance. Returns 0 if none of them sees any light still. */
static int cohsm__find_asking(const cohsm__scene_walk *w, cohsm__bunch *b, const cohsm_instance *instance,
                              uint32_t i, size_t begin, size_t count, int own)
{
    const cohsm_light_kind kind = w->query.light_kind;
    const int tested = kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION;
    size_t word;
    uint32_t bits;

    b->count = 1;
    cohsm__find_asked(b, instance, i, &w->query, begin, count, own, tested);
    for (word = 0; word < (count + 31) / 32; word++)
        for (bits = b->asked[0][word]; bits; bits &= bits - 1u)
            if (w->visible[begin + 32 * word + cohsm__first_bit_plain(bits)] > 0.0f) return 1;
    return 0;
}

/* Asks one instance for all samples from `begin` on that may have to. */
static void cohsm__ask_object(cohsm__scene_walk *w, const cohsm_instance *instance, uint32_t i, size_t begin,
                              int own)
{
    cohsm__bunch b;
    cohsm__asking a;

    a.instance = instance;
    a.number = i;
    a.asked = b.asked[0];
    for (; begin < w->query.count; begin += a.count) {
        a.begin = begin;
        a.count = w->query.count - begin < COHSM__BLOCK ? w->query.count - begin : (size_t)COHSM__BLOCK;
        if (cohsm__find_asking(w, &b, instance, i, begin, a.count, own))
            cohsm__ask_instance(&w->tile, &w->query, &a, w->visible);
    }
}

/* Holds the object of an instance and asks it, if any sample has to. */
static cohsm_result cohsm__visit(cohsm__scene_walk *w, uint32_t i, int own)
{
    cohsm_instance instance = cohsm__instance_of_header(w, i);
    const uint32_t object = w->instances[i].object;
    cohsm__bunch b;
    size_t begin, n;
    cohsm_result result;

    for (begin = 0; begin < w->query.count; begin += n) {
        n = w->query.count - begin < COHSM__BLOCK ? w->query.count - begin : (size_t)COHSM__BLOCK;
        if (cohsm__find_asking(w, &b, &instance, i, begin, n, own)) break;
    }
    if (begin >= w->query.count) return COHSM_OK;
    result = cohsm__object_hold(w->stream, object, w->log);
    if (result != COHSM_OK) return result;
    instance.maps = w->stream->objects[object].maps;
    cohsm__ask_object(w, &instance, i, begin, own);
    cohsm_stream_end(w->stream, object);
    return COHSM_OK;
}

/* Asks all instances: first the one that each sample lies on, then the others in their order. */
static cohsm_result cohsm__walk_scene(cohsm__scene_walk *w)
{
    uint32_t i;
    size_t k;
    int own;
    cohsm_result result;

    for (k = 0; k < w->query.count; k++) w->visible[k] = 1.0f;
    for (own = w->query.entities != NULL; own >= 0; own--)
        for (i = 0; i < w->count; i++) {
            result = cohsm__visit(w, i, own);
            if (result != COHSM_OK) return result;
        }
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_stream_visible_scene(cohsm_stream *s, const cohsm_stream_instance *instances,
                                                  size_t instance_count, const cohsm_query *query,
                                                  float *visible, size_t *refused)
{
    cohsm__logger log = cohsm__logger_of(s ? &s->desc.system : NULL, "cohsm_stream_visible_scene");
    cohsm__scene_walk w;
    cohsm_result result;

    if (!s) return COHSM_ERR_ARGUMENT;
    if (!query) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "query", "is NULL");
    if (query->count && !visible) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "visible", "is NULL");
    if (instance_count && !instances) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "instances", "is NULL");
    if (instance_count >= UINT32_MAX) {
        cohsm__log_value(&log, "instance_count", (double)instance_count, "below 2^32 - 1");
        return COHSM_ERR_LIMIT;
    }
    w.stream = s;
    w.instances = instances;
    w.count = (uint32_t)instance_count;
    w.query = cohsm__complete_query(query);
    w.log = &log;
    if (w.count <= 1) w.query.entities = NULL;              /* entities decide the order alone */
    result = cohsm__check_walk(&w);
    if (result != COHSM_OK) return result;
    if (query->count) {
        w.visible = (float *)cohsm__alloc_array(&s->allocator, query->count, sizeof(float));
        if (!w.visible) return cohsm__log_result(&log, COHSM_ERR_ALLOC);
        result = cohsm__walk_scene(&w);
        if (result == COHSM_OK) memcpy(visible, w.visible, query->count * sizeof(float));
        cohsm__free(&s->allocator, w.visible);
        if (result != COHSM_OK) return result;
    }
    if (refused) *refused = cohsm__count_refused(visible, query->count);
    return COHSM_OK;
}
