/* ---- building: a desc, checked, with its defaults ---- */

/* Returns whether enums, bands and sides of a desc are in range; if not, a line says so. */
static int sfield__check_sides(const sfield__logger *log, const sfield_desc *d, int haar)
{
    return sfield__check_value(log, (uint32_t)d->spacing < SFIELD_SPACING_COUNT, "desc.spacing",
                               (double)d->spacing, "0..2") &&
           sfield__check_value(log, d->bands <= SFIELD_MAX_BANDS, "desc.bands", d->bands, "0..8") &&
           sfield__check_value(log, !d->cube_side || sfield__is_side(d->cube_side, 4), "desc.cube_side",
                               d->cube_side, "0, 4, 8, 16, 32 or 64") &&
           sfield__check_value(log, d->shell_count != 1 && d->shell_count <= 64, "desc.shell_count",
                               d->shell_count, "0 or 2..64") &&
           sfield__check_value(log, d->position_side != 1 && d->position_side <= 64, "desc.position_side",
                               d->position_side, "0 or 2..64") &&
           sfield__check_value(log, sfield__in(d->keep, 0, 1), "desc.keep", (double)d->keep, "0..1") &&
           sfield__check_value(log, sfield__in(d->window, 0, 1e6f), "desc.window", (double)d->window,
                               "0..1e6") &&
           sfield__check_value(log, !haar || !d->logarithm, "desc.logarithm", d->logarithm, "0 for wavelets");
}

/* Returns whether what differs by the kind of field is in range; if not, a line says so. */
static int sfield__check_kind(const sfield__logger *log, const sfield_desc *d, sfield__kind kind)
{
    static const char *const centers[3] = { "desc.center[0]", "desc.center[1]", "desc.center[2]" };
    const uint32_t shells = (d->shell_count                       ? d->shell_count
                             : d->basis == SFIELD_BASIS_HAAR ? 32
                                                             : 16) *
                            (d->frame_count ? d->frame_count : 1);
    uint32_t i;
    for (i = 0; i < 3; i++)
        if (!sfield__check_value(log, sfield__in(d->center[i], -1e18f, 1e18f), centers[i],
                                 (double)d->center[i], "-1e18..1e18"))
            return 0;
    if (!sfield__check_value(log, !d->radii || d->shell_count, "desc.shell_count", 0,
                             "2..64 with desc.radii"))
        return 0;
    return sfield__check_value(log, d->radius == 0 || sfield__in(d->radius, 1e-18f, 1e18f), "desc.radius",
                               (double)d->radius, "0 or 1e-18..1e18") &&
           sfield__check_value(log, kind == SFIELD__KIND_OCCLUSION || !d->logarithm, "desc.logarithm",
                               d->logarithm, "0 but for occlusion") &&
           sfield__check_value(log, d->frame_count <= (kind == SFIELD__KIND_SOURCE ? 256u : 1u),
                               "desc.frame_count", d->frame_count, "0..256 for sources, else 0 or 1") &&
           sfield__check_value(log,
                               d->frames_per_second == 0 || sfield__in(d->frames_per_second, 1e-6f, 1e6f),
                               "desc.frames_per_second", (double)d->frames_per_second, "0 or 1e-6..1e6") &&
           sfield__check_value(log, kind == SFIELD__KIND_SELF || d->shard_end <= shells, "desc.shard_end",
                               d->shard_end, "at most all shells of all frames") &&
           sfield__check_value(log, !d->shard_end || kind != SFIELD__KIND_SELF, "desc.shard_end",
                               d->shard_end, "0 for self-visibility") &&
           sfield__check_value(log, d->shard_end ? d->shard_begin < d->shard_end : !d->shard_begin,
                               "desc.shard_begin", d->shard_begin, "below shard_end, or both 0");
}

/* Computes the radii of the shells. Returns 0 if there are no such shells. */
static int sfield__set_radii(sfield__build *b)
{
    sfield_desc *d = &b->desc;
    const float outer = d->outer != 0 ? d->outer : d->basis == SFIELD_BASIS_HAAR ? 20.0f : 8.0f;
    uint32_t i;
    d->inner = d->inner != 0 ? d->inner : 0.2f;
    if (!sfield__check_value(&b->log, sfield__in(d->inner, 1e-3f, 1000), "desc.inner", (double)d->inner,
                      "0 or 0.001..1000") ||
        !sfield__check_value(&b->log, sfield__in(outer, d->inner * 1.1f, 1000), "desc.outer", (double)outer,
                      "0 or 1.1 inner..1000"))
        return 0;
    for (i = 0; i < b->h.shells && d->radii; i++) {
        b->radii[i] = d->radii[i];
        if (!sfield__in(d->radii[i], 1e-3f, 1000) || (i && !(d->radii[i] > d->radii[i - 1] * 1.0002f))) {
            sfield__log_element(&b->log, "desc.radii", i, "is", (double)d->radii[i],
                                "0.001..1000 and 0.02 % above the one before");
            return 0;
        }
    }
    if (d->radii) return 1;
    for (i = 0; i < b->h.shells; i++) {
        float t = (float)i / (float)(b->h.shells - 1), ratio = outer / d->inner;
        b->radii[i] = b->h.spacing == SFIELD_SPACING_UNIFORM ? d->inner + t * (outer - d->inner)
                                                             : d->inner * sfield__pow(ratio, t);
        if (!sfield__check_value(&b->log, !i || b->radii[i] > b->radii[i - 1] * 1.0002f, "desc.shell_count",
                                 b->h.shells, "few enough for 0.02 % between two of them"))
            return 0;
    }
    if (b->h.shells) b->radii[b->h.shells - 1] = outer;
    return 1;
}

static sfield_result sfield__read_desc(sfield__build *b, const sfield_desc *desc, sfield__kind kind,
                                       const char *function)
{
    sfield_desc *d = &b->desc;
    sfield__header *h = &b->h;
    const int self = kind == SFIELD__KIND_SELF;
    float keep;
    uint32_t haar;
    memset(b, 0, sizeof *b);
    b->simd = sfield__simd_level();
    if (desc) *d = *desc;
    b->log = sfield__logger_of(&d->system, function);
    if (!sfield__system_good(&d->system)) return sfield__fail_allocator(&b->log);
    b->allocator = sfield__allocator_of(&d->system);
    haar = d->basis == SFIELD_BASIS_HAAR;
#ifdef SFIELD_WITHOUT_WAVELETS
    if (haar)
        return sfield__fail(&b->log, SFIELD_ERR_DESC, "desc.basis",
                            "is not in this header, joined without wavelets");
#endif
    if (!sfield__check_value(&b->log, (uint32_t)d->basis < SFIELD_BASIS_COUNT, "desc.basis", (double)d->basis,
                      "0..2") ||
        !sfield__check_sides(&b->log, d, haar != 0) || !sfield__check_kind(&b->log, d, kind))
        return SFIELD_ERR_DESC;
    h->magic = SFIELD__MAGIC;
    h->format = SFIELD__FORMAT;
    h->kind = kind;
    h->basis = haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    h->logarithm = d->logarithm != 0;
    h->bands = haar ? 0 : d->bands ? d->bands : 4;
    h->cube_side = d->cube_side ? d->cube_side : haar ? 32 : 16;
    h->shells = self ? 0 : d->shell_count ? d->shell_count : haar ? 32 : 16;
    h->position_side = self ? 0 : d->position_side ? d->position_side : haar ? 32 : 16;
    h->spacing = d->spacing ? (uint32_t)d->spacing : (uint32_t)SFIELD_SPACING_GEOMETRIC;
    h->frames = d->frame_count ? d->frame_count : 1;
    h->frames_per_second = d->frames_per_second != 0 ? d->frames_per_second : 30;
    h->loop = d->loop != 0;
    h->channels = kind == SFIELD__KIND_SOURCE ? 3 : 1;
    h->window = d->window;
    h->radius = d->radius != 0 ? d->radius : 1;
    memcpy(h->center, d->center, sizeof h->center);
    b->planes = sfield__planes(h->bands);
    b->cells = 6 * h->cube_side * h->cube_side;
    h->stride = haar ? (h->channels == 3 ? 2u : 1u) : h->channels * b->planes;
    h->samples = self ? 1 : h->frames * h->shells * 6 * h->position_side * h->position_side;
    h->shard_begin = d->shard_begin;
    h->shard_end = d->shard_end;
    keep = d->keep != 0 ? d->keep : 0.01f;
    b->most = (uint32_t)(keep * (float)b->cells);
    b->most = b->most < 1 ? 1 : b->most;
    if (!sfield__set_radii(b)) return SFIELD_ERR_DESC;
    sfield_sh_window(h->bands, h->window, b->window);
    return SFIELD_OK;
}
