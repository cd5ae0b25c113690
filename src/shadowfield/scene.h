/* ---- scenes: entities, and where they are ---- */

static void sfield__free_lists(sfield_scene *s)
{
    sfield__free(&s->allocator, s->item);
    sfield__free(&s->allocator, s->rotation);
    sfield__free(&s->allocator, s->occluder);
    sfield__free(&s->allocator, s->light);
    sfield__free(&s->allocator, s->taps);
    sfield__free(&s->allocator, s->moved);
#ifndef SFIELD_WITHOUT_ROOMS
    sfield__free(&s->allocator, s->held);
#endif
#ifndef SFIELD_WITHOUT_HIERARCHY
    sfield__free(&s->allocator, s->tree.keys);
    sfield__free(&s->allocator, s->tree.ball);
#endif
}

SFIELD_DEF void sfield_scene_free(sfield_scene *s)
{
    sfield__allocator a;
    if (!s) return;
    a = s->allocator;
    sfield__free_lists(s);
    sfield_algebra_free(s->algebra);
    sfield__free(&a, s->sky);
    sfield__free(&a, s->texel);
    sfield__free(&a, s->scratch);
#ifndef SFIELD_WITHOUT_GLOSS
    sfield__free(&a, s->brdf);
#endif
    sfield__free(&a, s);
}

/* Checks a desc and fills in its defaults. */
static sfield_result sfield__read_scene_desc(sfield_scene_desc *d, int has_out)
{
    const sfield__logger log = sfield__logger_of(&d->system, "sfield_scene_create");
    const int haar = d->basis == SFIELD_BASIS_HAAR;
    if (!has_out) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "out", "is NULL");
    if (!sfield__system_good(&d->system)) return sfield__fail_allocator(&log);
    if (!sfield__check_value(&log, (uint32_t)d->basis < SFIELD_BASIS_COUNT, "desc.basis", (double)d->basis,
                             "0..2") ||
        !sfield__check_value(&log, (uint32_t)d->product < SFIELD_PRODUCT_COUNT, "desc.product",
                             (double)d->product, "0..4") ||
        !sfield__check_value(&log, d->bands <= SFIELD_MAX_BANDS, "desc.bands", d->bands, "0..8") ||
        !sfield__check_value(&log, !d->cube_side || sfield__is_side(d->cube_side, 4), "desc.cube_side",
                             d->cube_side, "0, 4, 8, 16, 32 or 64") ||
        !sfield__check_value(&log, sfield__in(d->reach, 0, 1e6f), "desc.reach", (double)d->reach, "0..1e6"))
        return SFIELD_ERR_DESC;
#ifdef SFIELD_WITHOUT_WAVELETS
    if (haar)
        return sfield__fail(&log, SFIELD_ERR_DESC, "desc.basis",
                            "is not in this header, joined without wavelets");
#endif
#ifdef SFIELD_WITHOUT_LOGARITHMS
    if (d->product == SFIELD_PRODUCT_EXP)
        return sfield__fail(&log, SFIELD_ERR_DESC, "desc.product",
                            "is not in this header, joined without logarithms");
#endif
    if (d->product == SFIELD_PRODUCT_DEFAULT)
        d->product = haar ? SFIELD_PRODUCT_TEXELS : SFIELD_PRODUCT_TRIPLE;
    if (haar != (d->product >= SFIELD_PRODUCT_TEXELS))
        return sfield__fail(&log, SFIELD_ERR_DESC, "desc.product", "is not one of this basis");
    d->bands = d->bands ? d->bands : 4;
    d->cube_side = d->cube_side ? d->cube_side : haar ? 32 : 16;
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_create(const sfield_scene_desc *desc, sfield_scene **out)
{
    sfield_scene_desc d;
    sfield_result result;
    sfield__allocator a;
    sfield_scene *s;
    uint32_t haar, i, k;
    size_t kept;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    result = sfield__read_scene_desc(&d, out != NULL);
    if (result != SFIELD_OK) return result;
    haar = d.basis == SFIELD_BASIS_HAAR;
    a = sfield__allocator_of(&d.system);
    s = (sfield_scene *)sfield__alloc(&a, sizeof *s);
    if (!s) return SFIELD_ERR_ALLOC;
    memset(s, 0, sizeof *s);
    s->allocator = a;
    s->desc = d;
    s->simd = sfield__simd_level();
    s->side = d.cube_side;
    s->cells = 6 * s->side * s->side;
    s->coefs = haar ? s->cells : d.bands * d.bands;
    s->planes = haar ? s->cells : sfield__planes(d.bands);
    kept = 3 * (size_t)s->cells + 3 * (size_t)s->planes * 3;
    s->sky = (float *)sfield__alloc_array(&a, kept, sizeof *s->sky);
    s->texel = (float *)sfield__alloc_array(&a, 4 * (size_t)s->cells, sizeof *s->texel);
    if (!s->sky || !s->texel ||
        (!haar && sfield_algebra_create(d.bands, &d.system, &s->algebra) != SFIELD_OK)) {
        sfield_scene_free(s);
        return SFIELD_ERR_ALLOC;
    }
    memset(s->sky, 0, kept * sizeof *s->sky);
    s->sky_now = s->sky + 3 * s->cells;
    s->sky_still = s->sky_now + 3 * (size_t)s->planes;
    s->sun = s->sky_still + 3 * (size_t)s->planes;
    for (i = 0; i < s->cells; i++) {
        float dir[3];
        s->texel[3 * s->cells + i] = sfield_cube_texel(s->side, i, dir);
        for (k = 0; k < 3; k++) s->texel[k * s->cells + i] = dir[k];
    }
    *out = s;
    return SFIELD_OK;
}

static int sfield__field_fits(const sfield_scene *s, const sfield_field *f, sfield__kind kind)
{
    if (f->h.kind != (uint32_t)kind) return 0;
    if (f->h.basis == SFIELD_BASIS_HAAR) return s->algebra == NULL && f->h.cube_side == s->side;
    if (!s->algebra || f->h.bands != s->desc.bands) return 0;
    return kind != SFIELD__KIND_OCCLUSION || (s->desc.product == SFIELD_PRODUCT_EXP) == (f->h.logarithm != 0);
}

static void sfield__place_field(sfield__item *it, int which, const sfield_field *f, float scale)
{
    sfield__v3_store(it->center[which], sfield__m4_point(it->e.transform, sfield__v3_load(f->h.center)));
    it->radius[which] = scale * f->h.radius;
    it->inverse[which] = 1 / it->radius[which];
}

/* ---- hashes: what a cached T depends on ---- */

static uint64_t sfield__hash(uint64_t h, uint64_t x)
{
    h = (h ^ x) * 0x9e3779b97f4a7c15u;
    return h ^ h >> 29;
}

static uint64_t sfield__hash_bytes(uint64_t h, const void *data, size_t words)
{
    const uint8_t *p = (const uint8_t *)data;
    for (; words; words--, p += 4) {
        uint32_t x;
        memcpy(&x, p, sizeof x);
        h = sfield__hash(h, x);
    }
    return h;
}

/* Returns the result of an entity that cannot be used, once its line is written. */
static sfield_result sfield__fail_entity(const sfield_scene *s, sfield_result result, size_t index,
                                         const char *text)
{
    const sfield__logger log = sfield__logger_of(&s->desc.system, "sfield_scene_entities");
    return sfield__fail_at(&log, result, "entities", index, text);
}

/* Fills in the hashes of an item. They are taken here, since its fields may be freed before the next call. */
static void sfield__hash_item(sfield__item *it)
{
    const sfield_entity *e = &it->e;
    if (e->occlusion) {
        it->field = sfield__hash(e->occlusion->h.crc, (uint64_t)(uintptr_t)e->occlusion) | 1;
        it->body = sfield__hash_bytes(it->field, e->transform, 16) | 1;
    }
    if (e->source) {
        uint64_t h = sfield__hash(e->source->h.crc, (uint64_t)(uintptr_t)e->source);
        h = sfield__hash_bytes(sfield__hash_bytes(h, e->transform, 16), e->tint, 3);
        it->light = sfield__hash_bytes(h, &e->time, 1) | 1;
    }
}

static sfield_result sfield__make_item(const sfield_scene *s, const sfield_entity *e, size_t index,
                                       sfield__item *it, sfield_rotation *rotation)
{
    float scale;
    uint32_t i, k;
    memset(it, 0, sizeof *it);
    it->e = *e;
    memmove(it->e.transform, sfield__m4_or_identity(e->transform), sizeof it->e.transform);
    e = &it->e;
    if (!sfield__m4_is_rigid_uniform(e->transform, &scale))
        return sfield__fail_entity(s, SFIELD_ERR_INPUT, index,
                                   "has a transform that is no rotation with one scale > 0");
    if (!sfield__finite(e->time))
        return sfield__fail_entity(s, SFIELD_ERR_INPUT, index, "has a time that is not finite");
    it->identity = sfield__is_upright(e->transform);
    for (i = 0; i < 3; i++) {
        if (!sfield__in(e->tint[i], -1e18f, 1e18f))
            return sfield__fail_entity(s, SFIELD_ERR_INPUT, index, "has a tint beyond -1e18..1e18");
        for (k = 0; k < 3; k++)
            it->turn[3 * i + k] = it->identity ? (i == k ? 1.0f : 0.0f) : e->transform[4 * i + k] / scale;
    }
    if ((e->occlusion && e->occlusion->h.shard_end) || (e->source && e->source->h.shard_end))
        return sfield__fail_entity(s, SFIELD_ERR_MISMATCH, index,
                                   "has a field that is a shard: sfield_merge first");
    if (e->occlusion) {
        if (!sfield__field_fits(s, e->occlusion, SFIELD__KIND_OCCLUSION))
            return sfield__fail_entity(
                s, SFIELD_ERR_MISMATCH, index,
                "has an occlusion of another kind, basis, bands or logarithm than the scene");
        sfield__place_field(it, 0, e->occlusion, scale);
        it->inscribed = e->occlusion->h.inscribed * scale;
        it->reach = it->radius[0] * (s->desc.reach > 0 ? s->desc.reach
                                                       : e->occlusion->radii[e->occlusion->h.shells - 1]);
    }
    if (e->source) {
        if (!sfield__field_fits(s, e->source, SFIELD__KIND_SOURCE))
            return sfield__fail_entity(s, SFIELD_ERR_MISMATCH, index,
                                       "has a source of another kind, basis or bands than the scene");
        sfield__place_field(it, 1, e->source, scale);
    }
    sfield__hash_item(it);
    /* An entity that only receives may turn, unless it has a self-visibility. */
    if (!s->algebra) {
        const int sparse = s->desc.product == SFIELD_PRODUCT_SPARSE;
        if (sparse && !it->identity && (e->occlusion || e->source))
            return sfield__fail_entity(s, SFIELD_ERR_MISMATCH, index,
                                       "is rotated, which SFIELD_PRODUCT_SPARSE does not do");
        return SFIELD_OK;
    }
    return sfield_sh_rotation(s->algebra, e->transform, rotation);
}

/* Notes all that results depend on now. before: the hash before, if no more than occluders moved, else 0. */
static void sfield__note_change(sfield_scene *s, uint64_t before)
{
    s->before_hash = before;
    s->now_hash = sfield__hash(s->entities_hash, s->sky_hash) | 1;
}

/* Compares the new entities with those before. Notes which occluders moved, and whether nothing else has. */
static void sfield__note_moves(const sfield_scene *s, sfield_scene *n)
{
    int alike = n->item_count == s->item_count && n->item_count > 0;
    uint64_t h = n->item_count;
    uint32_t i;
    n->moved_count = 0;
    for (i = 0; i < n->item_count; i++) {
        sfield__item *now = &n->item[i];
        const sfield__item *was = alike ? &s->item[i] : now;
        h = sfield__hash(sfield__hash(h, now->body), now->light);
        memcpy(now->was, was->center[0], sizeof now->was);
        if (!alike) continue;
        alike = was->field == now->field && was->light == now->light &&
                !(was->reach < now->reach || was->reach > now->reach);
        if (now->body != was->body) n->moved[n->moved_count++] = i;
    }
    if (h == s->entities_hash && alike) {       /* nothing moved: what moved before still counts */
        for (i = 0; i < n->item_count; i++) memcpy(n->item[i].was, s->item[i].was, sizeof n->item[i].was);
        memcpy(n->moved, s->moved, s->moved_count * sizeof *s->moved);
        n->moved_count = s->moved_count;
        return;
    }
    n->entities_hash = h;
    sfield__note_change(n, alike ? s->now_hash : 0);
}

/* Makes the lists of the new scene beside the old one. */
static sfield_result sfield__make_lists(sfield_scene *n, const sfield_entity *entities, size_t count)
{
    uint32_t i, j, turned = 0, light = 0;
    size_t room = count ? count : 1;
    n->item = (sfield__item *)sfield__alloc_array(&n->allocator, room, sizeof *n->item);
    n->rotation =
        (sfield_rotation *)sfield__alloc_array(&n->allocator, n->algebra ? room : 1, sizeof *n->rotation);
    n->occluder = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->occluder);
    n->light = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->light);
    n->moved = (uint32_t *)sfield__alloc_array(&n->allocator, room, sizeof *n->moved);
    if (!n->item || !n->rotation || !n->occluder || !n->light || !n->moved) return SFIELD_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        sfield__item *it = &n->item[i];
        sfield_result result = sfield__make_item(n, &entities[i], i, it, n->rotation + (n->algebra ? i : 0));
        if (result != SFIELD_OK) return result;
        if (it->e.occlusion) n->occluder[n->occluder_count++] = i;
        if (it->e.source) n->light[n->light_count++] = i;
        if (!n->algebra && !it->identity && (it->e.occlusion || it->e.source)) it->map = ++turned;
    }
#ifndef SFIELD_WITHOUT_WAVELETS
    if (turned && !sfield__make_all_taps(n, turned)) return SFIELD_ERR_ALLOC;
#endif
    n->maps = turned;
#ifndef SFIELD_WITHOUT_HIERARCHY
    if (!sfield__make_tree(n)) return SFIELD_ERR_ALLOC;
#endif
    for (i = n->light_count; i-- > 0;)
        for (j = 0; j < n->occluder_count; j++) {
            const sfield__item *a = &n->item[n->light[i]], *b = &n->item[n->occluder[j]];
            sfield__v3 d = sfield__v3_sub(sfield__v3_load(a->center[1]), sfield__v3_load(b->center[0]));
            if (a == b || !(sfield__v3_length(d) < a->radius[1] + b->radius[0])) continue;
            n->overlaps++;
            light = i;
        }
#ifndef SFIELD_WITHOUT_ROOMS
    if (n->overlaps && !sfield__find_rooms(n)) return SFIELD_ERR_ALLOC;
#endif
    if (n->overlaps && n->desc.strict)
        return sfield__fail_entity(n, SFIELD_ERR_INPUT, n->light[light],
                                   "is a light whose sphere overlaps an object's");
    return SFIELD_OK;
}

SFIELD_DEF sfield_result sfield_scene_entities(sfield_scene *s, const sfield_entity *entities, size_t count)
{
    sfield_scene n;
    sfield_result result;
    sfield__logger log;
    if (!s) return SFIELD_ERR_ARGUMENT;
    log = sfield__logger_of(&s->desc.system, "sfield_scene_entities");
    if (!entities && count) return sfield__fail(&log, SFIELD_ERR_ARGUMENT, "entities", "is NULL");
    if (!sfield__check_value(&log, count <= 65535, "count", (double)count, "at most 65535"))
        return SFIELD_ERR_LIMIT;
    n = *s;
    n.item = NULL;
    n.rotation = NULL;
    n.occluder = n.light = NULL;
    n.taps = NULL;
    n.moved = NULL;
#ifndef SFIELD_WITHOUT_ROOMS
    n.held = NULL;
    n.held_count = 0;
#endif
#ifndef SFIELD_WITHOUT_HIERARCHY
    memset(&n.tree, 0, sizeof n.tree);
#endif
    n.occluder_count = n.light_count = n.overlaps = 0;
    n.item_count = (uint32_t)count;
    result = sfield__make_lists(&n, entities, count);
    if (result != SFIELD_OK) {
        sfield__free_lists(&n);
        return result;
    }
    sfield__note_moves(s, &n);
    sfield__free_lists(s);
    *s = n;
    return SFIELD_OK;
}
