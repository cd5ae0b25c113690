/* ---- patterns: samples of the unit disc (equation 3), and blue noise ---- */

/* Writes a sample of the unit disc: its place at a radius and a share of a full turn, and its weight. */
static inline void rsm__disc_point(float *out, float radius, float turn, float weight)
{
    float s, c;
    rsm__sincos(turn * (2.0f * RSM__PI), &s, &c);
    out[0] = radius * c;
    out[1] = radius * s;
    out[2] = weight;
}

/* Makes a Poisson pattern by throwing darts on a torus that is twice the disc's radius wide. A dart must keep
   a least distance from all others; this is lowered whenever 100 darts in a row do not, so that every pattern
   is finished. No place of the torus differs from another, so that the disc is covered evenly up to its rim.
   Darts thrown at the disc alone would crowd at the rim (4 % too dark in T25 with 400). */
static inline void rsm__make_poisson(uint32_t count, uint32_t seed, float *out)
{
    /* Pairs from the front are points of the disc, pairs from the back (27 % as many) those in the square's
       corners. */
    float least = 1.5f / sqrtf((float)count);
    uint32_t found = 0, outside = 0, tries = 0;
    uint32_t dart, i;
    for (dart = 0; found < count; dart++) {
        float x = 2.0f * rsm__random(seed, 11, dart) - 1.0f, y = 2.0f * rsm__random(seed, 12, dart) - 1.0f;
        int hit = 0;
        for (i = 0; i < found + outside && !hit; i++) {
            const float *p = i < found ? out + 2 * i : out + 3 * count - 2 * (i - found + 1);
            float dx = fabsf(p[0] - x), dy = fabsf(p[1] - y);
            dx = dx < 1.0f ? dx : 2.0f - dx;
            dy = dy < 1.0f ? dy : 2.0f - dy;
            hit = dx * dx + dy * dy < least * least;
        }
        if (hit) {
            if (++tries < 100) continue;
            least *= 0.9f;
        } else if (x * x + y * y < 1.0f) {
            out[2 * found] = x;
            out[2 * found++ + 1] = y;
        } else if (outside < count / 2) {
            outside++;
            out[3 * count - 2 * outside] = x;
            out[3 * count - 2 * outside + 1] = y;
        }
        tries = 0;
    }
    for (i = count; i-- > 0;) {
        float x = out[2 * i], y = out[2 * i + 1];
        out[3 * i] = x;
        out[3 * i + 1] = y;
        out[3 * i + 2] = RSM__PI / (float)count;
    }
}

/* Makes a pattern of density C / r^2 outside of an inner disc and C / r_min^2 inside. Ring and disc are two
   strata, each with its share of the samples. A stratum is a lattice, with radii at even steps and angles by
   the golden ratio, which is even for any number of samples. */
static inline void rsm__make_log_radial(uint32_t count, float r_min, uint32_t seed, float *out)
{
    float length = -rsm__log(r_min), u, v, r;
    uint32_t inner = (uint32_t)((float)count / (1.0f + 2.0f * length) + 0.5f), i;
    if (inner < 1) inner = 1;
    if (inner >= count) inner = count - 1;
    for (i = 0; i < count; i++) {
        uint32_t k = i < inner ? i : i - inner, n = i < inner ? inner : count - inner;
        u = ((float)k + rsm__random(seed, 8, i < inner)) / (float)n;
        v = rsm__fraction(rsm__to_unit(k * 2654435769u) + rsm__random(seed, 9, i < inner));
        if (i < inner)
            rsm__disc_point(out + 3 * i, r_min * sqrtf(u), v, RSM__PI * r_min * r_min / (float)inner);
        else {
            r = rsm__exp(-length * (1.0f - u));
            rsm__disc_point(out + 3 * i, r, v, 2.0f * RSM__PI * r * r * length / (float)(count - inner));
        }
    }
}

/* Makes a pattern about the receiver. With `paper`, samples of EQUATION3 have the paper's weights. */
static inline void rsm__pattern_make(rsm_pattern pattern, uint32_t count, float r_min, int paper,
                                     uint32_t seed, float *out)
{
    float u, v;
    double sum = 0.0;
    uint32_t i;
    if (pattern == RSM_PATTERN_POISSON) rsm__make_poisson(count, seed, out);
    else if (pattern == RSM_PATTERN_LOG_RADIAL && count > 1) rsm__make_log_radial(count, r_min, seed, out);
    else
        for (i = 0; i < count; i++) {
            rsm__sobol2(i, seed, &u, &v);
            if (pattern == RSM_PATTERN_EQUATION3)
                rsm__disc_point(out + 3 * i, u, v, 2.0f * RSM__PI * u / (float)count);
            else rsm__disc_point(out + 3 * i, sqrtf(u), v, RSM__PI / (float)count);
        }
    if (!paper || pattern != RSM_PATTERN_EQUATION3) return;
    for (i = 0; i < count; i++) sum += (double)(out[3 * i] * out[3 * i] + out[3 * i + 1] * out[3 * i + 1]);
    for (i = 0; i < count && sum > 0.0; i++)
        out[3 * i + 2] =
            (float)(3.14159265358979 / sum) * (out[3 * i] * out[3 * i] + out[3 * i + 1] * out[3 * i + 1]);
}

RSM_DEF rsm_result rsm_pattern_build(rsm_pattern pattern, uint32_t sample_count, float r_min,
                                     int paper_weights, uint32_t seed, float *points)
{
    if (!points || sample_count == 0 || sample_count > RSM__MAX_SAMPLES || !(r_min >= 0.0f && r_min < 1.0f))
        return RSM_ERR_ARGUMENT;
    if ((int)pattern <= RSM_PATTERN_FLUX || pattern >= RSM_PATTERN_MIXED) return RSM_ERR_ARGUMENT;
    if (pattern == RSM_PATTERN_POISSON && sample_count > RSM__MAX_POISSON) return RSM_ERR_ARGUMENT;
    rsm__pattern_make(pattern, sample_count, r_min > 0.0f ? r_min : 1.0f / 32.0f, paper_weights, seed,
                      points);
    return RSM_OK;
}

/* Adds the energy of a set pixel to the pixels about it, round the borders: a Gaussian of sigma 1.9, where
   Ulichney says 1.5 to 2. A sign of -1 takes the energy away. */
static inline void rsm__splat_energy(float *energy, uint32_t side, uint32_t at, float sign)
{
    int32_t reach = side > 20 ? 10 : ((int32_t)side - 1) / 2, i, j;
    for (j = -reach; j <= reach; j++)
        for (i = -reach; i <= reach; i++) {
            uint32_t x = (at % side + side + (uint32_t)i) % side, y = (at / side + side + (uint32_t)j) % side;
            energy[y * side + x] += sign * rsm__exp((float)(i * i + j * j) * -0.1385f);
        }
}

/* Returns the pixel in the tightest cluster among set pixels, or, without `set`, the pixel in the largest
   void among those that are not. A pixel is set if its mark is above 0. */
static inline uint32_t rsm__find_extreme(const float *energy, const float *marks, uint32_t count, int set)
{
    uint32_t i, best = 0;
    float value = 0.0f;
    int found = 0;
    for (i = 0; i < count; i++)
        if ((marks[i] > 0.0f) == set && (!found || (set ? energy[i] > value : energy[i] < value))) {
            best = i;
            value = energy[i];
            found = 1;
        }
    return best;
}

/* Writes blue noise to marks, by void and cluster (Ulichney 1993). energy is scratch. While the ranks are
   found, the mark of a pixel is 0 (not set), 0.5 (set, with a rank that is not known yet), or its rank + 1.
   */
static inline void rsm__void_and_cluster(uint32_t side, uint32_t seed, float *energy, float *marks)
{
    uint32_t count = side * side, first = count / 10 + 1, i, k;
    for (i = 0; i < count; i++) energy[i] = marks[i] = 0.0f;
    for (i = 0, k = 0; i < first; k++) {
        uint32_t at = rsm__hash_combine(seed, k) % count;
        if (marks[at] > 0.0f) continue;
        marks[at] = 1.0f;
        rsm__splat_energy(energy, side, at, 1.0f);
        i++;
    }
    for (k = 0; k < count; k++) { /* spread them evenly: the pixel in the tightest cluster goes into the
                                     largest void, until it comes back to where it was */
        uint32_t from = rsm__find_extreme(energy, marks, count, 1), to;
        marks[from] = 0.0f;
        rsm__splat_energy(energy, side, from, -1.0f);
        to = rsm__find_extreme(energy, marks, count, 0);
        marks[to] = 1.0f;
        rsm__splat_energy(energy, side, to, 1.0f);
        if (to == from) break;
    }
    for (i = 0; i < count; i++)
        if (marks[i] > 0.0f) marks[i] = 0.5f;
    for (k = first; k-- > 0;) { /* ranks of these: the pixel in the tightest cluster is taken away first, and
                                   those that are left have 0.5 */
        uint32_t at, best = count;
        for (at = 0; at < count; at++)
            if (marks[at] == 0.5f && (best == count || energy[at] > energy[best])) best = at;
        marks[best] = (float)k + 1.0f;
        rsm__splat_energy(energy, side, best, -1.0f);
    }
    for (i = 0; i < count; i++) energy[i] = 0.0f;
    for (i = 0; i < count; i++)
        if (marks[i] > 0.0f) rsm__splat_energy(energy, side, i, 1.0f);
    for (k = first; k < count; k++) {
        uint32_t at = rsm__find_extreme(energy, marks, count, 0);
        marks[at] = (float)k + 1.0f;
        rsm__splat_energy(energy, side, at, 1.0f);
    }
    for (i = 0; i < count; i++) marks[i] = (marks[i] - 0.5f) / (float)count;
}

RSM_DEF rsm_result rsm_blue_noise(uint32_t side, uint32_t seed, const rsm_system *system, float *values)
{
    rsm__logger log = rsm__logger_of(system, "rsm_blue_noise");
    rsm_system none;
    rsm__allocator a;
    float *energy;
    memset(&none, 0, sizeof none);
    if (!system) system = &none;
    if (!values) return rsm__refuse(&log, RSM_ERR_ARGUMENT, "values", "is NULL");
    if (!rsm__check_range(&log, "side", side, 4, 64, "4..64")) return RSM_ERR_ARGUMENT;
    if (!rsm__system_valid(&log, system)) return RSM_ERR_DESC;
    a = rsm__allocator_of(system);
    energy = (float *)rsm__alloc_array(&a, (size_t)side * side, sizeof *energy);
    if (!energy) return rsm__refuse(&log, RSM_ERR_ALLOC, "the allocator", "returned no memory");
    rsm__void_and_cluster(side, seed, energy, values);
    rsm__free(&a, energy);
    return RSM_OK;
}
